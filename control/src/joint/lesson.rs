//! The rig file's own pair, simulated when a law is made: what laws that are fitted to a pair are fitted to.
//!
//! One wire is warmed while the other cools, slowly to and fro, at the temperatures at which both are at the tension that is kept. The
//! joint is quieter than the real one, since at rest its inertia says nothing.

use super::setup::PairSetup;
use crate::laws::Side;
use sinew_physics::{Drive, DriveKind, Effects, Inputs, Joint, JointMotion, Wire, WireModel};

/// Where the lesson turns round, in shares of the whole swing; on the first way the pair is still slack, and nothing is learnt.
const TURNS: [f64; 7] = [1.0, -1.0, 1.0, -0.4, 0.5, -0.7, 1.0];
/// How far beyond both curves' centres it goes, in widths.
const BEYOND_WIDTHS: f64 = 4.0;
/// How slowly, K/s, in steps of so many seconds.
const SLOWLY_K_PER_S: f64 = 2.0;
const STEP_S: f64 = 5e-3;
/// Angular frequency of the quieter joint on its wires, rad/s: one that a step follows.
const QUIET_RAD_S: f64 = 40.0;
/// Points that are kept.
const POINTS: usize = 800;

/// The pair at a moment of the lesson.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub resistance_ohm: [f64; 2],
    pub angle_rad: f64,
    /// Half of what the agonist's duty that holds its temperature is above the antagonist's, beyond the duties of the middle.
    pub difference: f64,
    /// The side of the loop that the angle is on.
    pub falling: bool,
}

/// What was learnt of a pair.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lesson {
    /// Duties that hold both wires in the middle of their hysteresis at the tension that is kept.
    pub middle: [f64; 2],
    pub points: Vec<Point>,
}

/// One wire of the lesson.
struct Pupil {
    model: WireModel,
    wire: Wire,
    middle_c: f64,
    swing_k: f64,
    loss: f64,
    per_full_power: f64,
}

impl Pupil {
    /// The duty that holds it at a temperature, °C.
    fn duty(&self, temperature_c: f64) -> f64 {
        self.loss * (temperature_c - self.model.ambient_c) * self.per_full_power
    }

    /// What brings it to a temperature within ten steps.
    fn inputs(&self, to_c: f64) -> Inputs {
        let now_c = self.wire.temperature_c();
        let power = self.loss * (now_c - self.model.ambient_c)
            + self.model.heat_capacity_j_per_k() * (to_c - now_c) / (10.0 * STEP_S);
        Inputs { drive: power.max(0.0), ..self.model.rest_inputs() }
    }
}

impl Lesson {
    /// Of the reference model of both wires; `None` of a pair that the physics does not accept.
    pub fn of(setup: &PairSetup<'_>) -> Option<Lesson> {
        let models = setup.models.map(|model| {
            let drive = Drive { kind: DriveKind::Power, ..model.drive };
            WireModel { drive, effects: Effects::default(), taps: None, ..model.clone() }
        });
        let joint = quiet(&setup.settings.joint, [&models[0], &models[1]]);
        let mut motion = JointMotion::new(&joint, [&models[0], &models[1]]).ok()?;
        let [first, second] = &models;
        let pupil = |side: usize, model: &WireModel| -> Option<Pupil> {
            let map = &setup.maps[side];
            let shift = setup.settings.tension_n * map.per_area * map.shift;
            let half_loop = 0.5 * (map.heating_centre - map.cooling_centre);
            Some(Pupil {
                wire: motion.wire(side, model).ok()?,
                model: model.clone(),
                middle_c: map.cooling_centre + half_loop + shift,
                swing_k: half_loop + BEYOND_WIDTHS * map.heating_width.max(map.cooling_width),
                loss: map.loss,
                per_full_power: 1.0 / map.full_power,
            })
        };
        let mut pair = [pupil(0, first)?, pupil(1, second)?];
        let middle = [0, 1].map(|side| pair[side].duty(pair[side].middle_c));
        let swing_k = pair[0].swing_k.max(pair[1].swing_k);
        let step = SLOWLY_K_PER_S * STEP_S / swing_k;
        let mut points = Vec::new();
        let (mut at, mut side) = (0.0, Side::COLD);
        for (way, to) in TURNS.into_iter().enumerate() {
            let steps = ((to - at) / step).abs().ceil();
            let from = at;
            for k in 1..=steps as usize {
                at = from + (to - from) * k as f64 / steps;
                let inputs = [0, 1].map(|side| {
                    let swing = if side == 0 { at } else { -at } * pair[side].swing_k;
                    pair[side].inputs(pair[side].middle_c + swing)
                });
                let [agonist, antagonist] = &mut pair;
                motion.step([&mut agonist.wire, &mut antagonist.wire], [&inputs[0], &inputs[1]], 0.0, STEP_S);
                side.follow(motion.angle_rad() / (0.5 * setup.stroke_rad));
                if way > 0 {
                    points.push(point(&pair, &motion, middle, side));
                }
            }
        }
        let each = points.len().div_ceil(POINTS).max(1);
        Some(Lesson { middle, points: points.into_iter().step_by(each).collect() })
    }
}

fn point(pair: &[Pupil; 2], motion: &JointMotion, middle: [f64; 2], side: Side) -> Point {
    let above = |side: usize| pair[side].duty(pair[side].wire.temperature_c()) - middle[side];
    Point {
        resistance_ohm: pair.each_ref().map(|pupil| pupil.wire.resistance_ohm()),
        angle_rad: motion.angle_rad(),
        difference: 0.5 * (above(0) - above(1)),
        falling: side.falling,
    }
}

/// The joint with so much inertia and damping that it is slow.
fn quiet(joint: &Joint, models: [&WireModel; 2]) -> Joint {
    let fastest = joint.fastest_rad_s(models);
    if fastest <= QUIET_RAD_S {
        return *joint;
    }
    let inertia_kg_m2 = joint.inertia_kg_m2 * (fastest / QUIET_RAD_S).powi(2);
    Joint { inertia_kg_m2, damping_n_m_s: joint.damping_n_m_s.max(inertia_kg_m2 * QUIET_RAD_S), ..*joint }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::testing::pair;

    /// The lesson goes over the whole way, both ways, and comes back to where it was: what it learns is one loop.
    #[test]
    fn the_lesson_goes_through_the_whole_loop() {
        pair(
            |_| (),
            |setup| {
                let lesson = Lesson::of(setup).unwrap();
                let shares = || lesson.points.iter().map(|point| point.angle_rad / setup.stroke_rad);
                let (least, most) =
                    (shares().fold(f64::INFINITY, f64::min), shares().fold(f64::NEG_INFINITY, f64::max));
                assert!((-0.52..-0.45).contains(&least) && (0.45..0.52).contains(&most), "{least} {most}");
                // in the middle of the way up the agonist is hotter than on the way down, by the hysteresis
                let middle = |falling: bool| {
                    let near =
                        |point: &&Point| point.falling == falling && (point.angle_rad / setup.stroke_rad).abs() < 0.1;
                    let found: Vec<f64> = lesson.points.iter().filter(near).map(|point| point.difference).collect();
                    found.iter().sum::<f64>() / found.len() as f64
                };
                assert!(middle(false) > 0.01 && middle(true) < -0.01, "{} {}", middle(false), middle(true));
                assert!(lesson.middle.iter().all(|duty| (0.05..0.3).contains(duty)), "{:?}", lesson.middle);
            },
        );
    }

    /// A joint that is slower than the lesson's is left as it is.
    #[test]
    fn only_a_quick_joint_is_made_quieter() {
        pair(
            |_| (),
            |setup| {
                let joint = setup.settings.joint;
                let slower = quiet(&joint, setup.models);
                assert!((slower.fastest_rad_s(setup.models) / QUIET_RAD_S - 1.0).abs() < 1e-9);
                assert_eq!(quiet(&slower, setup.models), slower);
            },
        );
    }
}
