//! The sliding surfaces of chapter 11: the error and its derivatives weighed by a bandwidth λ.

/// The critically damped surface σ = ë + 2λė + λ²e of chapter 11, in m/s²: from the `error` of a length in m, its
/// derivatives in m/s and m/s², and λ in 1/s.
#[inline]
pub fn sliding_surface(error_m: f64, velocity_m_s: f64, acceleration_m_s2: f64, lambda_per_s: f64) -> f64 {
    acceleration_m_s2 + lambda_per_s * (2.0 * velocity_m_s + lambda_per_s * error_m)
}

/// The surface of first order, σ = ė + λe, in m/s.
#[inline]
pub fn sliding_surface_first_order(error_m: f64, velocity_m_s: f64, lambda_per_s: f64) -> f64 {
    velocity_m_s + lambda_per_s * error_m
}
