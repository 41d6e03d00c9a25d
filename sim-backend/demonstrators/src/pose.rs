//! How a machine stands.

/// How the machine stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Angle the wire has turned it to, rad.
    pub angle_rad: f64,
    /// Of the ball on the beam: from the pivot, m; NaN while a hand has it. Of a servo: the angle it is asked for, rad.
    pub other: f64,
}
