//! The driving temperature and the logistic curve (eq. 12, 20), for whoever needs one of them without a history.
//!
//! The simulation's [`Hysteresis`](crate::Hysteresis) computes the same curve from the side that keeps the small phase's
//! digits; a test there holds it to [`logistic`].

use crate::params::Material;

/// So far above A, at its stress, a wire is wholly austenite, in K.
pub const SURELY_HOT_K: f64 = 40.0;

/// Beyond this exponent the curve is 0 to the last digit.
const MOST_EXPONENT: f64 = 700.0;

/// The logistic outer curve ξ = 1/(1 + e^((ϑ − centre)/width)) (eq. 20), width = 1/k in K.
#[inline]
pub fn logistic(driving_c: f64, centre_c: f64, width_k: f64) -> f64 {
    1.0 / (1.0 + ((driving_c - centre_c) / width_k).min(MOST_EXPONENT).exp())
}

/// ln((1−ξ)/ξ): how far above a curve's centre ϑ lies at a martensite fraction, in widths (eq. 20 the other way).
#[inline]
pub fn logit(martensite: f64) -> f64 {
    ((1.0 - martensite) / martensite).ln()
}

/// How far a stress in Pa moves the transformation, σ/α (eq. 12), in K, for 1/α in K/Pa.
#[inline]
pub fn stress_shift_k(shift_k_per_pa: f64, stress_pa: f64) -> f64 {
    shift_k_per_pa * stress_pa
}

impl Material {
    /// Centre A of the transformation on heating under a stress in Pa, A + σ/α (eq. 12, 20), in °C.
    pub fn austenite_at_c(&self, stress_pa: f64) -> f64 {
        self.austenite_temperature_c + stress_shift_k(self.stress_shift_k_per_pa, stress_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logit_inverts_the_curve() {
        for xi in [1e-6, 0.1, 0.5, 0.99] {
            let theta = 93.0 + 3.2 * logit(xi);
            assert!((logistic(theta, 93.0, 3.2) / xi - 1.0).abs() < 1e-12);
        }
        assert!(logistic(1e300, 93.0, 3.2) < 1e-300);
    }
}
