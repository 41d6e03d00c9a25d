//! What no controller could do better: how fast a ball may pass the middle and still be caught, how fast a hexapod may walk.
//!
//! However it is controlled, the beam turns one way no faster than the wire heats at full power, and the other way no faster than it
//! cools. A ball that passes the middle with more than a certain speed is beyond any given distance before the beam has turned far enough.
//!
//! A paddle is the same in two directions, each of them by one wire of the wrist.
//!
//! A hexapod walks as fast as its feet go back on the ground, and they do that no faster than the wires of its coxae cool. However it steps, a
//! foot is down again no sooner than the wire of its femur has been heated and has cooled, and half of the feet are down meanwhile: so long at least
//! each stroke lasts.

use sinew_physics::Inputs;
use sinew_rig::{DemonstratorKind, Rig};
use sinew_sim_backend::SimulatedRig;

use crate::ball::{Ball, Beam};
use crate::demonstrator::{Demonstrator, Error};
use crate::hexapod::{JOINTS, Leg, MOST_UNEVEN};
use crate::torso::RIGHT_WRIST;

/// So long it is looked, s.
const LOOK_S: f64 = 2.0;
/// From one look to the next, s.
const STEP_S: f64 = 1e-3;
/// So long the wire is held where the beam is level before it is let go, s, by this gain, duty per m and per m s.
const HELD_S: f64 = 20.0;
const HOLD: [f64; 2] = [300.0, 300.0];
/// Share of its hot end's angle at which a wire can be held without being heated for nothing.
const NEARLY: f64 = 0.95;

/// Fastest a ball may pass the middle outwards and still turn back within a distance, m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Catchable {
    /// Towards the side that the wire lifts, which is caught by heating it.
    pub by_heating_m_s: f64,
    /// Towards the other, which is caught by letting the wire cool.
    pub by_cooling_m_s: f64,
}

impl Catchable {
    /// Within `distance_m`, in still air, by no more than the rig's `maximum_duty`; `None` where the rig has no ball; of a torso by its right wrist alone,
    /// whichever way that is slower.
    ///
    /// # Errors
    /// [`Error`] where the physics does not accept the wire.
    pub fn of(rig: &Rig, distance_m: f64) -> Result<Option<Catchable>, Error> {
        let declared = &rig.demonstrator;
        let wires: &[usize] = match declared.kind {
            DemonstratorKind::BallOnBeam => &[0],
            DemonstratorKind::Torso => &RIGHT_WRIST,
            _ => return Ok(None),
        };
        let beam = Beam::of(declared);
        let mut slowest: Option<Catchable> = None;
        for wire in wires {
            let Some((channel, _)) = rig.demonstrator_channels().flatten().nth(*wire) else { return Ok(None) };
            let most_duty = rig.channels[channel].limits.max_duty;
            let let_go = Held { wire: *wire, at_rad: 0.0 };
            let (Some(heated), Some(cooled)) = (let_go.turned(rig, most_duty)?, let_go.turned(rig, 0.0)?) else {
                return Ok(None);
            };
            // up is against the ball on the lifted arm
            let by_heating_m_s = fastest(&beam, &heated, distance_m);
            let by_cooling_m_s = fastest(&beam, &cooled.iter().map(|angle| -angle).collect::<Vec<_>>(), distance_m);
            slowest = Some(Catchable {
                by_heating_m_s: slowest.map_or(by_heating_m_s, |other| other.by_heating_m_s.min(by_heating_m_s)),
                by_cooling_m_s: slowest.map_or(by_cooling_m_s, |other| other.by_cooling_m_s.min(by_cooling_m_s)),
            });
        }
        Ok(slowest)
    }
}

/// Fastest a hexapod may walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walkable {
    /// How fast, m/s.
    pub speed_m_s: f64,
    /// Shortest time in which a foot is lifted over its highest foothold and put down again, s.
    pub step_s: f64,
}

impl Walkable {
    /// In still air, by no more than the rig's `maximum_duty`; `None` where the rig has no hexapod, or one whose femora do not lift a foot.
    ///
    /// # Errors
    /// [`Error`] where the physics does not accept a wire.
    pub fn of(rig: &Rig) -> Result<Option<Walkable>, Error> {
        let declared = &rig.demonstrator;
        let Some((coxa, _)) = rig.demonstrator_channels().flatten().next() else { return Ok(None) };
        if declared.kind != DemonstratorKind::Hexapod {
            return Ok(None);
        }
        let Some(most_rad) = Demonstrator::of(rig)?.map(|machine| machine.most_rad()) else { return Ok(None) };
        let [leg, ..] = Leg::all(declared);
        let lift_rad = MOST_UNEVEN * declared.unevenness_m / leg.reach_m([0.0; JOINTS])[1];
        let most_duty = rig.channels[coxa].limits.max_duty;
        let reaches = |trace: Option<Vec<f64>>, is_there: &dyn Fn(f64) -> bool| {
            Some(STEP_S * trace?.into_iter().position(is_there)? as f64)
        };
        let up_s = reaches(Held { wire: 1, at_rad: 0.0 }.turned(rig, most_duty)?, &|angle| angle >= lift_rad);
        let down_s = reaches(Held { wire: 1, at_rad: lift_rad }.turned(rig, 0.0)?, &|angle| angle <= 0.0);
        let back = Held { wire: 0, at_rad: NEARLY * most_rad }.turned(rig, 0.0)?;
        let (Some(up_s), Some(down_s), Some(back)) = (up_s, down_s, back) else { return Ok(None) };
        let step_s = up_s + down_s;
        // the furthest that a foot goes back in that time, as far outside as it gets
        let steps = ((step_s / STEP_S) as usize).clamp(1, back.len() - 1);
        let turned_rad = back.windows(steps + 1).map(|of| of[0] - of[steps]).fold(0.0, f64::max);
        let bent = [-most_rad, 0.0, most_rad];
        let reach_m = |femur: f64, tibia: f64| leg.reach_m([0.0, femur, tibia])[0];
        let reach_m = bent.into_iter().flat_map(|femur| bent.map(|tibia| reach_m(femur, tibia))).fold(0.0, f64::max);
        let stroke_m = 2.0 * reach_m * (0.5 * turned_rad).sin();
        Ok(Some(Walkable { speed_m_s: stroke_m / (STEP_S * steps as f64), step_s }))
    }
}

/// A wire of the demonstrator that is held at an angle, rad, until it is let go.
#[derive(Debug, Clone, Copy)]
struct Held {
    wire: usize,
    at_rad: f64,
}

impl Held {
    /// Angles from then on, rad, one each [`STEP_S`], with this duty.
    fn turned(self, rig: &Rig, duty: f64) -> Result<Option<Vec<f64>>, Error> {
        let Ok(wires) = SimulatedRig::new(rig) else { return Ok(None) };
        let Some(demonstrator) = Demonstrator::of(rig)? else { return Ok(None) };
        let Some((channel, _)) = rig.demonstrator_channels().flatten().nth(self.wire) else { return Ok(None) };
        let (Some(wire), Some(still)) = (wires.wire(channel), wires.inputs(channel)) else { return Ok(None) };
        let (mut wire, mut sum) = (wire.clone(), 0.0);
        let angle = |wire: &sinew_physics::Wire| demonstrator.angle_rad(self.wire, wire.position_m());
        for _ in 0..(HELD_S / STEP_S) as u64 {
            let below_m = (self.at_rad - angle(&wire)) * rig.demonstrator.lever_m;
            sum = (sum + HOLD[1] * below_m * STEP_S).clamp(0.0, 1.0);
            wire.step(&Inputs { drive: (HOLD[0] * below_m + sum).clamp(0.0, 1.0), ..still }, STEP_S);
        }
        let drive = Inputs { drive: duty, ..still };
        Ok(Some(
            (0..(LOOK_S / STEP_S) as u64)
                .map(|_| {
                    wire.step(&drive, STEP_S);
                    angle(&wire)
                })
                .collect(),
        ))
    }
}

/// The fastest outward speed from the middle, m/s, from which these angles, positive against the ball, turn it back within a distance.
fn fastest(beam: &Beam, angles: &[f64], distance_m: f64) -> f64 {
    let is_caught = |speed_m_s: f64| {
        let mut ball = Ball { at_m: 0.0, speed_m_s };
        for angle in angles {
            ball.roll(beam, *angle, 0.0, STEP_S);
            if ball.at_m > distance_m {
                return false;
            }
            if ball.speed_m_s <= 0.0 {
                return true;
            }
        }
        false
    };
    let (mut caught, mut lost) = (0.0, 10.0);
    for _ in 0..40 {
        let middle = 0.5 * (caught + lost);
        if is_caught(middle) { caught = middle } else { lost = middle }
    }
    caught
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_beam_that_turns_at_once_it_is_galileis() {
        let beam = Beam { half_m: 1.0, ball_kg: 1.0, inertia: 0.4, rolling: 0.0 };
        let angles = vec![0.05; 5000];
        let exact = (2.0 * 9.80665 * 0.05_f64.sin() / 1.4 * 0.01).sqrt();
        assert!((fastest(&beam, &angles, 0.01) / exact - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_tube_takes_the_heat_faster_than_bare_air() {
        let text = crate::BOWDEN_SERVO;
        let tube = text.find("# 500 mm of PTFE tube").unwrap()..text.find("[demonstrator]").unwrap();
        let bare = text.replace(&text[tube], "");
        let back_s = |text: &str| {
            let rig = Rig::parse(text, "tube.toml").unwrap();
            let angles = Held { wire: 0, at_rad: 0.0 }.turned(&rig, 0.0).unwrap().unwrap();
            STEP_S * angles.iter().position(|angle| *angle < -0.4).unwrap() as f64
        };
        let (tube_s, bare_s) = (back_s(text), back_s(&bare));
        assert!(tube_s < 0.8 * bare_s, "{tube_s} s in the tube, {bare_s} s without");
    }

    #[test]
    fn a_thicker_wire_catches_less_by_cooling() {
        let of = |text: &str| {
            let rig = Rig::parse(text, "bound.toml").unwrap();
            Catchable::of(&rig, 0.01).unwrap().unwrap()
        };
        let thin = of(crate::BALL_ON_BEAM);
        let thick = of(&crate::BALL_ON_BEAM.replace("flexinol-50-ht", "flexinol-100-ht").replace("0.3 }", "1.0 }"));
        assert!(thin.by_cooling_m_s > 1.3 * thick.by_cooling_m_s, "{thin:?} {thick:?}");
        assert!(thin.by_heating_m_s > 0.02 && thin.by_cooling_m_s > 0.02, "{thin:?}");
    }

    #[test]
    fn a_paddle_catches_no_more_than_the_slower_wire_of_its_wrist() {
        let of = |text: &str| Catchable::of(&Rig::parse(text, "bound.toml").unwrap(), 0.03).unwrap().unwrap();
        let alike = of(crate::TORSO);
        let (before, after) = crate::TORSO.split_once("name = \"right_roll\"").unwrap();
        let after =
            after.replacen("flexinol-50-ht", "flexinol-76-ht", 1).replacen("preload_n = 0.3", "preload_n = 0.6", 1);
        let slower = of(&format!("{before}name = \"right_roll\"{after}"));
        assert!(alike.by_cooling_m_s > 1.1 * slower.by_cooling_m_s, "{alike:?} {slower:?}");
        assert!(slower.by_heating_m_s <= alike.by_heating_m_s, "{alike:?} {slower:?}");
    }

    #[test]
    fn a_hexapod_of_thicker_wire_walks_slower() {
        let of = |text: &str| Walkable::of(&Rig::parse(text, "bound.toml").unwrap()).unwrap().unwrap();
        let thin = of(crate::WALKER);
        let thick = of(&crate::WALKER.replace("flexinol-130-ht", "flexinol-200-ht"));
        assert!(thin.speed_m_s > 1.3 * thick.speed_m_s && thin.step_s < thick.step_s, "{thin:?} {thick:?}");
        assert!((0.005..0.1).contains(&thin.speed_m_s), "{thin:?}");
    }
}
