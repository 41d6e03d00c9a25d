//! A hexapod: a rigid body on six legs without weight, whose joints stand as its wires hold them.
//!
//! ```text
//! m v̇ = m g + Σ F_i        I ω̇ + ω × I ω = Σ r_i × F_i
//! ```
//!
//! with the ground's forces F_i on the feet ([`Ground`]), which are springs with a damper and hold by Coulomb friction. What they do at a joint,
//! its wire has to hold besides its own load. Left out: the legs' own mass (it is the body's), and that a foot is round.

mod ground;
mod leg;

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2 as G;
use sinew_rig::Demonstrator;

use crate::chance::Noise;
use crate::space::{Turn, Vector, cross, difference, sum, times};

use ground::{Foot, Ground};
pub(crate) use leg::{JOINTS, LEGS, Leg, Parts};

/// A step of the body is no longer than this share of the time in which its feet stop it, and a period of the rig has no more steps than so many: feet
/// for which that is not enough are softer than declared.
const STEP: f64 = 0.5;
const MOST_STEPS: f64 = 64.0;
/// A foot's damper over its spring, s: on six feet of 600 N/m, 60 g swing out with half of the critical damping.
const FOOT_DAMPING_S: f64 = 4e-3;
/// A foothold is within so many times the unevenness, RMS, of the plane: a foot that is higher looks for another one.
pub(crate) const MOST_UNEVEN: f64 = 2.5;
/// It has fallen, too, where it leans by more than this, rad: a machine that walks so slowly has no business to.
const LEANS_RAD: f64 = 0.175;

/// Angles of all its joints, rad, leg by leg.
pub(crate) type Angles = [[f64; JOINTS]; LEGS];

/// How it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// Where its middle is, m: ahead of where it was put down, to the left of that, above the ground.
    pub at_m: [f64; 3],
    /// Heading to the left, pitch with the nose down, roll to the right, rad.
    pub turned_rad: [f64; 3],
    /// Angles of coxa, femur and tibia, rad: front left, front right, middle left, middle right, rear left, rear right.
    pub angles_rad: [[f64; 3]; 6],
    /// Which feet stand on the ground.
    pub stands: [bool; 6],
}

/// One of a rig file.
#[derive(Debug)]
pub(crate) struct Hexapod {
    mass_kg: f64,
    /// About its own axes, kg m².
    inertia: Vector,
    /// What pulls at it, m/s².
    gravity: Vector,
    /// Lowest points of its body.
    corners_m: [Vector; 4],
    legs: [Leg; LEGS],
    ground: Ground,
    /// Steps in a period.
    steps: u32,
    uneven_m: f64,
    feet: [Foot; LEGS],
    /// Where the feet were at the end of the last period, in the body's own directions.
    placed: Option<[Vector; LEGS]>,
    at_m: Vector,
    speed_m_s: Vector,
    turn: Turn,
    /// In its own directions, rad/s.
    spin: Vector,
    footholds: Noise,
}

impl Hexapod {
    /// Of a rig file, to be put down where its world begins, and to be followed period by period.
    pub fn new(declared: &Demonstrator, seed: u64, period_s: f64) -> Hexapod {
        let Demonstrator { body_kg, leg_spacing_m, hip_width_m, belly_m, .. } = *declared;
        // a box as long as the rows of hips, as wide, and as high below them as above
        let [x, y, z] = [2.0 * leg_spacing_m, hip_width_m, 2.0 * belly_m].map(|side| side * side);
        let (sin, cos) = declared.slope_rad.sin_cos();
        let inertia = [y + z, x + z, x + y].map(|squares| body_kg * squares / 12.0);
        let legs = Leg::all(declared);
        let (stiffness_n_per_m, steps) = followed(declared.foot_n_per_m, body_kg, inertia, &legs, period_s);
        let corner = |ahead, left| [ahead * leg_spacing_m, left * 0.5 * hip_width_m, -belly_m];
        Hexapod {
            mass_kg: body_kg,
            inertia,
            gravity: [-G * sin, 0.0, -G * cos],
            corners_m: [corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)],
            legs,
            ground: Ground {
                stiffness_n_per_m,
                damping_n_s_per_m: stiffness_n_per_m * FOOT_DAMPING_S,
                friction: declared.friction,
            },
            steps,
            uneven_m: declared.unevenness_m,
            feet: [Foot::default(); LEGS],
            placed: None,
            at_m: [0.0; 3],
            speed_m_s: [0.0; 3],
            turn: Turn::heading(declared.heading_rad),
            spin: [0.0; 3],
            footholds: Noise::new(seed, 4),
        }
    }

    /// How it stands with its joints at these angles, rad.
    pub fn stance(&self, angles_rad: &Angles) -> Stance {
        Stance {
            at_m: self.at_m,
            turned_rad: self.turn.angles(),
            angles_rad: *angles_rad,
            stands: self.feet.map(|foot| foot.stands()),
        }
    }

    /// How far it leans, rad.
    pub fn leans_rad(&self) -> f64 {
        self.turn.out([0.0, 0.0, 1.0])[2].clamp(-1.0, 1.0).acos()
    }

    /// Whether it lies.
    pub fn has_fallen(&self) -> bool {
        let is_down = |corner: Vector| sum(self.at_m, self.turn.out(corner))[2] < 0.0;
        self.leans_rad() > LEANS_RAD || self.corners_m.into_iter().any(is_down)
    }

    /// A hand puts it on its feet where it is, level, looking where it looked.
    pub fn set_up(&mut self) {
        let Some(placed) = self.placed else { return };
        let [heading, ..] = self.turn.angles();
        self.turn = Turn::heading(heading);
        let lowest_m = placed.iter().map(|foot| foot[2]).fold(f64::INFINITY, f64::min);
        self.at_m[2] = -lowest_m;
        (self.speed_m_s, self.spin) = ([0.0; 3], [0.0; 3]);
        self.feet = [Foot::default(); LEGS];
    }

    /// Lets a period pass in which its joints go to these angles, rad; how the ground turns each of them, N m, on average.
    pub fn pass(&mut self, angles_rad: &Angles, period_s: f64) -> [[f64; JOINTS]; LEGS] {
        let mut there = [[0.0; 3]; LEGS];
        for ((there, leg), angles) in there.iter_mut().zip(&self.legs).zip(angles_rad) {
            *there = leg.parts(*angles).foot;
        }
        if self.placed.is_none() {
            self.placed = Some(there);
            self.set_up();
        }
        let before = self.placed.replace(there).unwrap_or(there);
        let mut moves = [[0.0; 3]; LEGS];
        for leg in 0..LEGS {
            moves[leg] = times(1.0 / period_s, difference(there[leg], before[leg]));
        }
        let mut pushed = [[0.0; 3]; LEGS];
        let dt_s = period_s / f64::from(self.steps);
        for step in 1..=self.steps {
            let mut feet = before;
            for (foot, moves) in feet.iter_mut().zip(moves) {
                *foot = sum(*foot, times(f64::from(step) * dt_s, moves));
            }
            let forces = self.step(&feet, &moves, dt_s);
            for (pushed, force) in pushed.iter_mut().zip(forces) {
                *pushed = sum(*pushed, times(1.0 / f64::from(self.steps), force));
            }
        }
        std::array::from_fn(|leg| self.legs[leg].torques_n_m(angles_rad[leg], pushed[leg]))
    }

    /// One step with its feet at places that move, m and m/s in its own directions (semi-implicit Euler): the ground's forces on them, N, in its own.
    fn step(&mut self, feet_m: &[Vector; LEGS], moves_m_s: &[Vector; LEGS], dt_s: f64) -> [Vector; LEGS] {
        let (mut force, mut torque, mut forces) = (times(self.mass_kg, self.gravity), [0.0; 3], [[0.0; 3]; LEGS]);
        for leg in 0..LEGS {
            let foot_m = feet_m[leg];
            let at_m = sum(self.at_m, self.turn.out(foot_m));
            let speed = sum(self.speed_m_s, self.turn.out(sum(moves_m_s[leg], cross(self.spin, foot_m))));
            let push = if at_m[2] > MOST_UNEVEN * self.uneven_m {
                // its next foothold is another one
                self.feet[leg] = Foot::default();
                [0.0; 3]
            } else {
                let foothold = || self.uneven_m * self.footholds.normal().clamp(-MOST_UNEVEN, MOST_UNEVEN);
                self.feet[leg].push_n(&self.ground, foothold, at_m, speed)
            };
            forces[leg] = self.turn.back(push);
            force = sum(force, push);
            torque = sum(torque, cross(foot_m, forces[leg]));
        }
        self.speed_m_s = sum(self.speed_m_s, times(dt_s / self.mass_kg, force));
        let turning = difference(torque, cross(self.spin, self.angular()));
        for ((spin, turning), inertia) in self.spin.iter_mut().zip(turning).zip(self.inertia) {
            *spin += dt_s * turning / inertia;
        }
        self.at_m = sum(self.at_m, times(dt_s, self.speed_m_s));
        self.turn = self.turn.spun(self.spin, dt_s);
        forces
    }

    /// Angular momentum in its own directions, kg m²/s.
    fn angular(&self) -> Vector {
        std::array::from_fn(|axis| self.inertia[axis] * self.spin[axis])
    }
}

/// The stiffness of feet, N/m, that can be followed, no more than declared, and the steps of a period that it takes.
fn followed(declared_n_per_m: f64, mass_kg: f64, inertia: Vector, legs: &[Leg; LEGS], period_s: f64) -> (f64, u32) {
    // what all feet do to the body for each of their N/m: along, and about each axis, 1/kg
    let [x, y, z] = legs.iter().map(|leg| leg.parts([0.0; JOINTS]).foot.map(|place| place * place)).fold([0.0; 3], sum);
    let held = [LEGS as f64 / mass_kg, (y + z) / inertia[0], (x + z) / inertia[1], (x + y) / inertia[2]];
    let most = held.into_iter().fold(0.0, f64::max);
    // their springs swing it at √(k · held), and their dampers stop it at d · held
    let most_per_s = STEP * MOST_STEPS / period_s;
    let stiffest_n_per_m = (most_per_s / (FOOT_DAMPING_S * most)).min(most_per_s * most_per_s / most);
    let stiffness_n_per_m = declared_n_per_m.min(stiffest_n_per_m);
    let per_s = (FOOT_DAMPING_S * stiffness_n_per_m * most).max((stiffness_n_per_m * most).sqrt());
    (stiffness_n_per_m, (period_s * per_s / STEP).ceil().min(MOST_STEPS) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::dot;

    pub fn declared() -> Demonstrator {
        let rig = sinew_rig::Rig::parse(crate::WALKER, "walker.toml").unwrap();
        Demonstrator {
            body_kg: 0.06,
            leg_spacing_m: 0.06,
            hip_width_m: 0.05,
            coxa_m: 0.012,
            femur_m: 0.03,
            tibia_m: 0.05,
            femur_rad: 20.0_f64.to_radians(),
            tibia_rad: 10.0_f64.to_radians(),
            friction: 0.7,
            slope_rad: 0.0,
            unevenness_m: 0.0,
            heading_rad: 0.0,
            ..rig.demonstrator
        }
    }

    const LEVEL: Angles = [[0.0; JOINTS]; LEGS];
    const PERIOD_S: f64 = 1e-3;

    /// Lets time pass with the joints where a function of time has them; the body, and the forces at the end, from the torques' own step.
    fn after(declared: &Demonstrator, seconds: f64, mut angles: impl FnMut(f64) -> Angles) -> Hexapod {
        let mut body = Hexapod::new(declared, 1, PERIOD_S);
        for period in 0..(seconds / PERIOD_S) as u32 {
            body.pass(&angles(f64::from(period) * PERIOD_S), PERIOD_S);
        }
        body
    }

    fn forces(body: &mut Hexapod, angles: &Angles) -> [Vector; LEGS] {
        let feet = std::array::from_fn(|leg| body.legs[leg].parts(angles[leg]).foot);
        body.step(&feet, &[[0.0; 3]; LEGS], 1e-9)
    }

    #[test]
    fn standing_the_feet_carry_its_weight_and_nothing_turns_it() {
        let lifted = |leg: usize| {
            let mut angles = LEVEL;
            angles[leg][1] = 0.3;
            angles
        };
        let tripod = {
            let mut angles = LEVEL;
            [0, 3, 4].into_iter().for_each(|leg| angles[leg][1] = 0.3);
            angles
        };
        for angles in [LEVEL, lifted(0), lifted(3), tripod] {
            let mut body = after(&declared(), 1.0, |_| angles);
            let pushed = forces(&mut body, &angles);
            let up: f64 = pushed.iter().map(|force| force[2]).sum();
            assert!((up / (0.06 * G) - 1.0).abs() < 1e-3, "{up}");
            let feet: [Vector; LEGS] = std::array::from_fn(|leg| body.legs[leg].parts(angles[leg]).foot);
            let torque = (0..LEGS).fold([0.0; 3], |all, leg| sum(all, cross(feet[leg], pushed[leg])));
            assert!(torque.iter().all(|t| t.abs() < 1e-5), "{torque:?}");
            assert!(!body.has_fallen());
        }
        // on a tripod the middle leg has half of it
        let mut body = after(&declared(), 1.0, |_| tripod);
        let middle = forces(&mut body, &tripod)[2][2];
        assert!((middle / (0.03 * G) - 1.0).abs() < 0.02, "{middle}");
    }

    #[test]
    fn without_its_middle_leg_a_tripod_tips() {
        let mut angles = LEVEL;
        // all of a side but one, and the other side's middle
        [0, 2, 4, 3].into_iter().for_each(|leg| angles[leg][1] = 1.2);
        let mut body = Hexapod::new(&declared(), 1, PERIOD_S);
        let falls = (0..3000).position(|_| {
            body.pass(&angles, PERIOD_S);
            body.has_fallen()
        });
        assert!(falls.is_some_and(|after| after > 20), "{falls:?}");
        body.set_up();
        assert!(!body.has_fallen() && body.leans_rad() < 1e-9);
    }

    #[test]
    fn feet_that_hold_move_it_by_their_own_way_and_no_more() {
        // all feet go straight back by a centimetre, in a second
        let coxa = |t: f64| 0.2 - 0.4 * (t - 0.5).clamp(0.0, 1.0);
        let angles = |t: f64| [[coxa(t), 0.0, 0.0]; LEGS];
        let body = after(&declared(), 2.0, angles);
        let way = |leg: &Leg| leg.parts([0.2, 0.0, 0.0]).foot[0] - leg.parts([-0.2, 0.0, 0.0]).foot[0];
        let exact = way(&body.legs[0]);
        assert!((body.at_m[0] / exact - 1.0).abs() < 0.02, "{} {exact}", body.at_m[0]);
        assert!(body.at_m[1].abs() < 1e-4 && body.turn.angles()[0].abs() < 1e-3);
        // without friction it stays where it is
        let ice = after(&Demonstrator { friction: 0.0, ..declared() }, 2.0, angles);
        assert!(ice.at_m[0].abs() < 1e-6, "{}", ice.at_m[0]);
    }

    #[test]
    fn on_a_slope_it_holds_as_long_as_friction_is_more() {
        for (slope, friction, holds) in [(0.30_f64, 0.35, true), (0.30, 0.27, false)] {
            let declared = Demonstrator { slope_rad: slope, friction, ..declared() };
            let body = after(&declared, 1.0, |_| LEVEL);
            if holds {
                assert!(body.at_m[0].abs() < 2e-3, "tan {slope} < {friction}: {}", body.at_m[0]);
            } else {
                // it begins to slide as soon as its feet bear it
                let exact = 0.5 * G * (slope.sin() - friction * slope.cos());
                assert!((-body.at_m[0] / exact - 1.0).abs() < 0.1, "{} {exact}", body.at_m[0]);
            }
        }
    }

    #[test]
    fn what_its_legs_do_is_what_it_gains() {
        // without dampers, and with feet that neither slip nor leave the ground: energy of body and springs changes by the work of the legs
        let mut body = Hexapod::new(&Demonstrator { friction: 1e3, ..declared() }, 1, PERIOD_S);
        for _ in 0..1000 {
            body.pass(&LEVEL, PERIOD_S);
        }
        body.ground.damping_n_s_per_m = 0.0;
        let places = |body: &Hexapod, t: f64| -> [Vector; LEGS] {
            let angles = [0.05 * (5.0 * t).sin(), 0.05 * (7.0 * t).sin(), 0.03 * (3.0 * t).sin()];
            std::array::from_fn(|leg| body.legs[leg].parts(angles).foot)
        };
        let energy = |body: &Hexapod, t: f64| {
            let moving = 0.5 * body.mass_kg * dot(body.speed_m_s, body.speed_m_s);
            let springs: f64 = places(body, t)
                .iter()
                .zip(&body.feet)
                .map(|(foot, held)| held.energy_j(&body.ground, sum(body.at_m, body.turn.out(*foot))))
                .sum();
            moving + 0.5 * dot(body.spin, body.angular()) + body.mass_kg * G * body.at_m[2] + springs
        };
        let (dt, before) = (1e-5, energy(&body, 0.0));
        let (mut work, mut most) = (0.0, 0.0_f64);
        for step in 0..30_000 {
            let t = f64::from(step) * dt;
            let (now, next) = (places(&body, t), places(&body, t + dt));
            let moves: [Vector; LEGS] = std::array::from_fn(|leg| times(1.0 / dt, difference(next[leg], now[leg])));
            let forces = body.step(&next, &moves, dt);
            work -= (0..LEGS).map(|leg| dot(forces[leg], moves[leg]) * dt).sum::<f64>();
            most = most.max(work.abs());
        }
        let gained = energy(&body, 0.3) - before;
        assert!((gained - work).abs() < 0.01 * most, "{gained} {work} {most}");
    }

    #[test]
    fn in_a_tripod_gait_without_slip_each_step_is_a_stroke() {
        // two tripods: one draws back on the ground while the other, lifted, goes forward
        const STEP_S: f64 = 0.6;
        let angles = |t: f64| {
            let t = (t - 0.5).max(0.0);
            std::array::from_fn(|leg| {
                let of = if [0, 3, 4].contains(&leg) { 0.0 } else { STEP_S };
                let phase = ((t + of).rem_euclid(2.0 * STEP_S)) / STEP_S;
                let forward = if phase < 1.0 { 0.1 - 0.2 * phase } else { -0.1 + 0.2 * (phase - 1.0) };
                // up at once and down at once, at the ends of the stroke
                let up = ((phase - 1.0).min(2.0 - phase) * 10.0).clamp(0.0, 1.0);
                [forward, 0.2 * up, 0.0]
            })
        };
        let declared = Demonstrator { friction: 2.0, ..declared() };
        let start = after(&declared, 0.5, angles).at_m[0];
        let body = after(&declared, 0.5 + 10.0 * STEP_S, angles);
        let leg = &body.legs[0];
        let stroke = leg.parts([0.1, 0.0, 0.0]).foot[0] - leg.parts([-0.1, 0.0, 0.0]).foot[0];
        let gone = body.at_m[0] - start;
        assert!((gone / (10.0 * stroke) - 1.0).abs() < 0.1, "{gone} {}", 10.0 * stroke);
        assert!(!body.has_fallen());
    }

    #[test]
    fn however_light_and_long_legged_it_is_and_however_slow_its_rig_it_comes_to_rest() {
        let long = Demonstrator { coxa_m: 0.05, femur_m: 0.1, tibia_m: 0.2, ..declared() };
        let light = Demonstrator { body_kg: 0.001, foot_n_per_m: 2000.0, ..declared() };
        for (declared, period_s) in [(declared(), 1e-2), (declared(), 1e-4), (light, 1e-3), (long, 1e-3)] {
            let mut body = Hexapod::new(&declared, 1, period_s);
            assert!(f64::from(body.steps) <= MOST_STEPS);
            for _ in 0..(2.0 / period_s) as u32 {
                body.pass(&LEVEL, period_s);
            }
            let speed = dot(body.speed_m_s, body.speed_m_s).sqrt();
            assert!(speed < 1e-3 && body.leans_rad() < 0.01, "{declared:?}: {speed} {}", body.leans_rad());
        }
    }
}
