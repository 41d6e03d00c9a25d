//! The built-in program of a rig, active while no client commands it: a pure function of channel and time, or a replay's targets.
//!
//! It lets the built-in hexapod walk on the spot. A client's command overrides it on a channel while its lease lasts, then
//! the program continues at the current time.

use std::f64::consts::PI;

/// A reference for each channel as a function of time. The loop asks it without allocating or locking.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Steps of so many seconds.
    Gait { period_s: f64, joints: Vec<Joint> },
    /// Each of so many channels up and down in so many seconds.
    Steps { period_s: f64, channels: usize },
    /// What a file says, from row to row and again from the start.
    Played { times_s: Vec<f64>, strokes: Vec<Vec<Option<f64>>> },
    /// What was last given for each channel.
    Given(Vec<Option<f64>>),
}

/// What one wire does in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Joint {
    /// Where in the step its leg begins, 0 ..= 1: half a step apart for the two tripods.
    phase: f64,
    motion: Motion,
    low: f64,
    high: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    /// Up and down again while the leg is in the air, at rest on the ground.
    Lift,
    /// Forward while the leg is in the air, back while it is on the ground.
    Swing,
    /// Stretched while on the ground, drawn in while in the air.
    Extend,
}

impl Program {
    /// Wires of a leg, in the order of the channels: coxa (swings it), femur (lifts it), tibia (reaches).
    pub const WIRES_A_LEG: usize = 3;

    /// A tripod gait on the spot, for channels in the order of the built-in hexapod: legs from front to rear, left before right,
    /// three wires each. Front and rear leg of one side and the middle leg of the other are in the air together, half a step
    /// apart from the other three, so that three feet always stand. Strokes stay in 10 % to 50 %. `period_s` (s, at least
    /// 0.1) is the time of a whole step; a 0.125 mm wire cools in about 1.4 s, so 6 s is a comfortable walk.
    pub fn tripod(channels: usize, period_s: f64) -> Program {
        let joints = (0..channels)
            .map(|channel| {
                let leg = channel / Self::WIRES_A_LEG;
                let (motion, low, high) = match channel % Self::WIRES_A_LEG {
                    0 => (Motion::Swing, 0.15, 0.45),
                    1 => (Motion::Lift, 0.10, 0.50),
                    _ => (Motion::Extend, 0.10, 0.40),
                };
                // Rows of two legs: the left one of a row goes with the right one of the next.
                let tripod = (leg / 2 + leg) % 2;
                Joint { phase: 0.5 * tripod as f64, motion, low, high }
            })
            .collect();
        // NaN and everything too fast become the fastest step there is.
        Program { kind: Kind::Gait { period_s: period_s.max(0.1), joints } }
    }

    /// Each wire from 10 % to 40 % of its stroke, a while there, and back, within `period_s` (s, at least 0.1); the wires begin one after the
    /// other, so that a supply is not asked for all of them at once.
    pub fn steps(channels: usize, period_s: f64) -> Program {
        Program { kind: Kind::Steps { period_s: period_s.max(0.1), channels } }
    }

    /// The strokes of each channel (`None` = it is not moved) from each of these times on, s, increasing; the last one is where it begins again.
    /// A channel's strokes are as many as there are times.
    pub fn played(times_s: Vec<f64>, strokes: Vec<Vec<Option<f64>>>) -> Program {
        Program { kind: Kind::Played { times_s, strokes } }
    }

    /// Whatever [`Program::give`] said last of each of so many channels, nothing before: for a replay.
    pub fn given(channels: usize) -> Program {
        Program { kind: Kind::Given(vec![None; channels]) }
    }

    /// From now on the stroke of `channel` is this; `None` = it is not moved. Only for a program made by [`Program::given`].
    #[inline]
    pub fn give(&mut self, channel: usize, stroke: Option<f64>) {
        if let Kind::Given(strokes) = &mut self.kind
            && let Some(given) = strokes.get_mut(channel)
        {
            *given = stroke;
        }
    }

    /// How many channels it moves.
    pub fn channels(&self) -> usize {
        match &self.kind {
            Kind::Gait { joints, .. } => joints.len(),
            Kind::Steps { channels, .. } => *channels,
            Kind::Played { strokes, .. } => strokes.len(),
            Kind::Given(strokes) => strokes.len(),
        }
    }

    /// Stroke of `channel` at `time_s` (s since the start), 0 = cold and long, 1 = hot and short; `None` for a channel it does
    /// not move. But for what was given and what is played, continuous in time, with a continuous first derivative, and out of rest.
    #[inline]
    pub fn stroke(&self, channel: usize, time_s: f64) -> Option<f64> {
        let (period_s, joints) = match &self.kind {
            Kind::Gait { period_s, joints } => (*period_s, joints),
            Kind::Given(strokes) => return *strokes.get(channel)?,
            Kind::Steps { period_s, channels } if channel < *channels => {
                // its turn comes a share of the period later than that of the wire before
                let begun = time_s / period_s - channel as f64 / *channels as f64;
                let ramp = if begun < 0.5 { 0.5 - 0.5 * (PI * (2.0 * begun).max(0.0)).cos() } else { 1.0 };
                return Some(ramp * Self::step(begun.max(0.0).rem_euclid(1.0)));
            }
            Kind::Steps { .. } => return None,
            Kind::Played { times_s, strokes } => {
                let strokes = strokes.get(channel)?;
                let at_s = match times_s.as_slice() {
                    // one row alone holds from the start on
                    [] | [_] => f64::INFINITY,
                    [.., last_s] => time_s.rem_euclid(*last_s),
                };
                let row = times_s.partition_point(|from_s| *from_s <= at_s).checked_sub(1)?;
                return *strokes.get(row)?;
            }
        };
        let joint = joints.get(channel)?;
        let steps = time_s / period_s;
        let at = (steps + joint.phase).rem_euclid(1.0);
        // The leg is in the air in the first half of its step.
        let shape = match joint.motion {
            Motion::Lift if at < 0.5 => raised_cosine(2.0 * at),
            Motion::Lift => 0.0,
            Motion::Swing => 0.5 - 0.5 * (2.0 * PI * at).cos(),
            Motion::Extend if at < 0.5 => 1.0 - raised_cosine(2.0 * at),
            Motion::Extend => 1.0,
        };
        let ramp = if steps < 1.0 { 0.5 - 0.5 * (PI * steps.max(0.0)).cos() } else { 1.0 };
        Some(ramp * (joint.low + (joint.high - joint.low) * shape))
    }
}

impl Program {
    /// The stroke of a wire that goes up and down, at a share of its period.
    #[inline]
    fn step(at: f64) -> f64 {
        const LOW: f64 = 0.1;
        const HIGH: f64 = 0.4;
        /// Share of the period that the way up takes, and the way down.
        const WAY: f64 = 0.125;
        let up = |share: f64| 0.5 - 0.5 * (PI * share.clamp(0.0, 1.0)).cos();
        LOW + (HIGH - LOW) * (up(at / WAY) - up((at - 0.5) / WAY))
    }
}

/// A bump from 0 over 1 at the middle back to 0, for 0 ..= 1.
fn raised_cosine(at: f64) -> f64 {
    0.5 - 0.5 * (2.0 * PI * at).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_feet_stand_at_any_time() {
        let program = Program::tripod(18, 4.0);
        for tick in 0..4000 {
            let time_s = 4.0 + f64::from(tick) * 1e-3;
            let stands = |leg: &usize| {
                let femur = leg * Program::WIRES_A_LEG + 1;
                (program.stroke(femur, time_s).unwrap() - 0.1).abs() < 1e-12
            };
            let standing: Vec<usize> = (0..6).filter(stands).collect();
            // Front left, middle right, rear left; or the other three. At the moment of change, all six.
            let tripods = [vec![0, 3, 4], vec![1, 2, 5], vec![0, 1, 2, 3, 4, 5]];
            assert!(tripods.contains(&standing), "at {time_s} s on {standing:?}");
        }
    }

    #[test]
    fn stays_in_its_range_and_never_jumps() {
        let program = Program::tripod(18, 6.0);
        for channel in 0..18 {
            let mut last = program.stroke(channel, 0.0).unwrap();
            assert_eq!(last, 0.0, "it begins at rest");
            for tick in 1..20_000 {
                let stroke = program.stroke(channel, f64::from(tick) * 1e-3).unwrap();
                assert!((0.0..=0.5).contains(&stroke));
                assert!((stroke - last).abs() < 1e-3, "channel {channel}, tick {tick}: {last} to {stroke}");
                last = stroke;
            }
        }
        assert_eq!(program.stroke(18, 1.0), None);
    }

    #[test]
    fn steps_move_every_wire_in_turns_and_never_jump() {
        let program = Program::steps(3, 8.0);
        let mut begun = [f64::INFINITY; 3];
        for (channel, begun) in begun.iter_mut().enumerate() {
            let (mut last, mut low, mut high) = (0.0, 1.0f64, 0.0f64);
            for tick in 0..40_000 {
                let time_s = f64::from(tick) * 1e-3;
                let stroke = program.stroke(channel, time_s).unwrap();
                assert!((stroke - last).abs() < 1e-3, "channel {channel} at {time_s} s: {last} to {stroke}");
                if stroke > 1e-3 {
                    *begun = begun.min(time_s);
                }
                if time_s > 20.0 {
                    (low, high) = (low.min(stroke), high.max(stroke));
                }
                last = stroke;
            }
            assert!((low - 0.1).abs() < 1e-9 && (high - 0.4).abs() < 1e-9, "{low} {high}");
        }
        assert!(begun[0] < begun[1] && begun[1] < begun[2], "{begun:?}");
        assert_eq!(program.stroke(3, 1.0), None);
    }

    #[test]
    fn a_file_is_played_from_row_to_row_and_again() {
        let program = Program::played(
            vec![0.5, 1.0, 2.0],
            vec![vec![Some(0.1), Some(0.3), None], vec![None, Some(0.2), Some(0.2)]],
        );
        let at = |time_s: f64| [program.stroke(0, time_s), program.stroke(1, time_s)];
        assert_eq!(at(0.4), [None, None], "before its first row");
        assert_eq!(at(0.5), [Some(0.1), None]);
        assert_eq!(at(1.9), [Some(0.3), Some(0.2)]);
        assert_eq!(at(2.6), at(0.6), "after the last row from the start");
        assert_eq!(program.stroke(2, 1.0), None);
        let held = Program::played(vec![0.0], vec![vec![Some(0.2)]]);
        assert_eq!((held.stroke(0, 0.0), held.stroke(0, 1e6)), (Some(0.2), Some(0.2)));
        assert_eq!(Program::played(Vec::new(), vec![Vec::new()]).stroke(0, 1.0), None);
    }

    #[test]
    fn every_wire_moves() {
        let program = Program::tripod(18, 6.0);
        for channel in 0..18 {
            let strokes = (0..100).map(|tick| program.stroke(channel, 6.0 + f64::from(tick) * 0.06).unwrap());
            let (low, high) = strokes.fold((1.0f64, 0.0f64), |(low, high), stroke| (low.min(stroke), high.max(stroke)));
            assert!(high - low > 0.25, "channel {channel} moves by {}", high - low);
        }
    }
}
