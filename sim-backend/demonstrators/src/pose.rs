//! How a machine stands.

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
}

impl Pose {
    /// As four numbers, for cells that other threads read.
    pub(crate) fn to_numbers(self) -> [f64; 4] {
        match self {
            Pose::Beam { angle_rad, ball_m } => [angle_rad, ball_m, 0.0, 0.0],
            Pose::Servo { angle_rad, asked_rad } => [angle_rad, asked_rad, 0.0, 0.0],
            Pose::Arm { angles_rad: [a, b], target_m: [x, y] } => [a, b, x, y],
        }
    }

    /// Of the same kind, by such numbers.
    pub(crate) fn with_numbers(self, [a, b, x, y]: [f64; 4]) -> Pose {
        match self {
            Pose::Beam { .. } => Pose::Beam { angle_rad: a, ball_m: b },
            Pose::Servo { .. } => Pose::Servo { angle_rad: a, asked_rad: b },
            Pose::Arm { .. } => Pose::Arm { angles_rad: [a, b], target_m: [x, y] },
        }
    }
}
