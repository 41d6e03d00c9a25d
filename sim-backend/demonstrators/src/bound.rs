//! What no controller could do better: how fast a ball may pass the middle and still be caught.
//!
//! However it is controlled, the beam turns one way no faster than the wire heats at full power, and the other way no faster than it
//! cools. A ball that passes the middle with more than a certain speed is beyond any given distance before the beam has turned far enough.

use sinew_physics::Inputs;
use sinew_rig::{DemonstratorKind, Rig};
use sinew_sim_backend::SimulatedRig;

use crate::ball::{Ball, Beam};
use crate::demonstrator::{Demonstrator, Error};

/// So long it is looked, s.
const LOOK_S: f64 = 2.0;
/// From one look to the next, s.
const STEP_S: f64 = 1e-3;
/// So long the wire is held where the beam is level before it is let go, s, by this gain, duty per m and per m s.
const HELD_S: f64 = 20.0;
const HOLD: [f64; 2] = [300.0, 300.0];

/// Fastest a ball may pass the middle outwards and still turn back within a distance, m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Catchable {
    /// Towards the arm that the wire lifts, which is caught by heating it.
    pub by_heating_m_s: f64,
    /// Towards the other, which is caught by letting the wire cool.
    pub by_cooling_m_s: f64,
}

impl Catchable {
    /// Within `distance_m`, in still air, by no more than the rig's `maximum_duty`; `None` where the rig has no ball on a beam.
    ///
    /// # Errors
    /// [`Error`] where the physics does not accept the wire.
    pub fn of(rig: &Rig, distance_m: f64) -> Result<Option<Catchable>, Error> {
        let declared = &rig.demonstrator;
        let [Some((channel, _)), _] = rig.demonstrator_channels() else { return Ok(None) };
        if declared.kind != DemonstratorKind::BallOnBeam {
            return Ok(None);
        }
        let beam = Beam::of(declared);
        let most_duty = rig.channels[channel].limits.max_duty;
        let (Some(heated), Some(cooled)) = (turned(rig, channel, most_duty)?, turned(rig, channel, 0.0)?) else {
            return Ok(None);
        };
        // up is against the ball on the lifted arm
        Ok(Some(Catchable {
            by_heating_m_s: fastest(&beam, &heated, distance_m),
            by_cooling_m_s: fastest(&beam, &cooled.iter().map(|angle| -angle).collect::<Vec<_>>(), distance_m),
        }))
    }
}

/// Angles of the beam from level on, rad, one each [`STEP_S`], once the wire has this duty.
fn turned(rig: &Rig, channel: usize, duty: f64) -> Result<Option<Vec<f64>>, Error> {
    let Ok(wires) = SimulatedRig::new(rig) else { return Ok(None) };
    let Some(demonstrator) = Demonstrator::of(rig)? else { return Ok(None) };
    let (Some(wire), Some(still)) = (wires.wire(channel), wires.inputs(channel)) else { return Ok(None) };
    let (mut wire, mut sum) = (wire.clone(), 0.0);
    let angle = |wire: &sinew_physics::Wire| demonstrator.angle_rad(wire.position_m());
    for _ in 0..(HELD_S / STEP_S) as u64 {
        let below_m = -angle(&wire) * rig.demonstrator.lever_m;
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
            let angles = turned(&rig, 0, 0.0).unwrap().unwrap();
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
}
