//! How a machine stands.

use crate::hexapod::Stance;
use crate::torso::TORSO_JOINTS;

/// How many numbers say it.
pub(crate) const NUMBERS: usize = 25;

/// How a machine stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pose {
    /// A ball on a beam.
    Beam {
        /// Angle of the beam, rad, positive where the wire lifts it.
        angle_rad: f64,
        /// Where the ball is, from the pivot, m; NaN while a hand has it.
        ball_m: f64,
    },
    /// A servo.
    Servo {
        /// Angle of its horn, rad.
        angle_rad: f64,
        /// The angle it is asked for, rad.
        asked_rad: f64,
    },
    /// An arm of two links.
    Arm {
        /// Angles its joints are turned by, from where they are at level strokes, rad.
        angles_rad: [f64; 2],
        /// Where the target is, from the shoulder, m.
        target_m: [f64; 2],
    },
    /// A hexapod.
    Hexapod(Stance),
    /// A torso with a ball on its paddle.
    Torso {
        /// Angles of shoulder, elbow, pitch and roll, rad: of the right arm, then of the left one.
        angles_rad: [f64; TORSO_JOINTS],
        /// Where the ball is, from the middle of the paddle, ahead and to the left, m; NaN while a hand has it.
        ball_m: [f64; 2],
    },
}

impl Pose {
    /// As so many numbers, for cells that other threads read.
    pub(crate) fn to_numbers(self) -> [f64; NUMBERS] {
        let mut numbers = [0.0; NUMBERS];
        let few = match self {
            Pose::Beam { angle_rad, ball_m } => [angle_rad, ball_m, 0.0, 0.0],
            Pose::Servo { angle_rad, asked_rad } => [angle_rad, asked_rad, 0.0, 0.0],
            Pose::Arm { angles_rad: [a, b], target_m: [x, y] } => [a, b, x, y],
            Pose::Torso { angles_rad, ball_m } => {
                let all = ball_m.into_iter().chain(angles_rad);
                numbers.iter_mut().zip(all).for_each(|(number, said)| *number = said);
                return numbers;
            }
            Pose::Hexapod(Stance { at_m, turned_rad, angles_rad, stands }) => {
                let which = stands.iter().rev().fold(0_u8, |bits, stands| bits << 1 | u8::from(*stands));
                let angles = angles_rad.as_flattened().iter().copied();
                let all = at_m.into_iter().chain(turned_rad).chain([f64::from(which)]).chain(angles);
                numbers.iter_mut().zip(all).for_each(|(number, said)| *number = said);
                return numbers;
            }
        };
        numbers[..few.len()].copy_from_slice(&few);
        numbers
    }

    /// Of the same kind, by such numbers.
    pub(crate) fn with_numbers(self, numbers: [f64; NUMBERS]) -> Pose {
        let [a, b, x, y, pitch, roll, which, angles @ ..] = numbers;
        match self {
            Pose::Beam { .. } => Pose::Beam { angle_rad: a, ball_m: b },
            Pose::Servo { .. } => Pose::Servo { angle_rad: a, asked_rad: b },
            Pose::Arm { .. } => Pose::Arm { angles_rad: [a, b], target_m: [x, y] },
            Pose::Torso { .. } => {
                Pose::Torso { angles_rad: std::array::from_fn(|joint| numbers[2 + joint]), ball_m: [a, b] }
            }
            Pose::Hexapod(_) => Pose::Hexapod(Stance {
                at_m: [a, b, x],
                turned_rad: [y, pitch, roll],
                angles_rad: std::array::from_fn(|leg| std::array::from_fn(|joint| angles[3 * leg + joint])),
                stands: std::array::from_fn(|leg| which as u8 >> leg & 1 == 1),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_in_numbers_is_understood() {
        let stance = Stance {
            at_m: [1.0, 2.0, 3.0],
            turned_rad: [4.0, 5.0, 6.0],
            angles_rad: std::array::from_fn(|leg| std::array::from_fn(|joint| (10 * leg + joint) as f64)),
            stands: [true, false, false, true, true, false],
        };
        let poses = [
            Pose::Beam { angle_rad: 1.0, ball_m: 2.0 },
            Pose::Servo { angle_rad: 1.0, asked_rad: 2.0 },
            Pose::Arm { angles_rad: [1.0, 2.0], target_m: [3.0, 4.0] },
            Pose::Hexapod(stance),
            Pose::Torso { angles_rad: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], ball_m: [9.0, 10.0] },
        ];
        for pose in poses {
            assert_eq!(pose.with_numbers([0.0; NUMBERS]).with_numbers(pose.to_numbers()), pose);
        }
    }
}
