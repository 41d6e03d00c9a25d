//! Length, velocity and acceleration of a wire.

use sinew_physics::formulas::sliding_surface;

/// Length and its first two derivatives; positive = longer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Wire length, in m.
    pub length_m: f64,
    /// Its first derivative, in m/s.
    pub velocity_m_s: f64,
    /// Its second derivative, in m/s².
    pub acceleration_m_s2: f64,
}

impl Motion {
    /// The critically damped sliding surface ẍ + 2λẋ + λ²(x − x_ref) of chapter 11, in m/s².
    pub fn surface(&self, lambda_per_s: f64, reference_m: f64) -> f64 {
        let error_m = self.length_m - reference_m;
        sliding_surface(error_m, self.velocity_m_s, self.acceleration_m_s2, lambda_per_s)
    }
}
