//! Inner loops as the literature has them, with the gap that eq. 26 closes: for comparison alone, no wire is stepped by it.

use crate::formulas::logistic;
use crate::params::Material;

/// The phase of a wire whose history variables are set to ξ as it is at a reversal (eq. 19, 25): there its curve starts at another ξ
/// than the wire has. Logistic curves, whatever the material's kinetics.
#[derive(Debug, Clone, Copy)]
pub struct KeptHistory {
    /// Centre in °C and width 1/k in K of the heating and of the cooling curve.
    heating: (f64, f64),
    cooling: (f64, f64),
    /// ϑ last followed to, °C.
    theta: f64,
    martensite: f64,
    heats: bool,
    /// ξ_M while it heats, 1 − ξ_A while it cools.
    history: f64,
}

impl KeptHistory {
    /// All martensite, at a driving temperature ϑ = T − σ/α in °C far below the heating curve.
    pub fn new(material: &Material, theta_c: f64) -> KeptHistory {
        KeptHistory {
            heating: (material.austenite_temperature_c, 1.0 / material.heating_steepness_per_k),
            cooling: (material.martensite_temperature_c, 1.0 / material.cooling_steepness_per_k),
            theta: theta_c,
            martensite: 1.0,
            heats: true,
            history: 1.0,
        }
    }

    /// The martensite fraction as ϑ goes on to here, in °C; a ϑ that stays changes nothing.
    pub fn follow(&mut self, theta_c: f64) -> f64 {
        if theta_c == self.theta || theta_c.is_nan() {
            return self.martensite;
        }
        let heats = theta_c > self.theta;
        if heats != self.heats {
            self.history = if heats { self.martensite } else { 1.0 - self.martensite };
        }
        (self.theta, self.heats) = (theta_c, heats);
        self.martensite = if heats {
            self.history * logistic(theta_c, self.heating.0, self.heating.1)
        } else {
            1.0 - self.history * (1.0 - logistic(theta_c, self.cooling.0, self.cooling.1))
        };
        self.martensite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_transformations_are_the_outer_curves_and_short_reversals_jump() {
        let material = Material::default();
        let mut phase = KeptHistory::new(&material, 20.0);
        assert_eq!(phase.follow(93.0), 0.5);
        assert!(phase.follow(200.0) < 1e-12);
        assert!((phase.follow(67.0) - 0.5).abs() < 1e-12);
        let mut phase = KeptHistory::new(&material, 20.0);
        phase.follow(93.0);
        let before = phase.follow(92.0);
        // half of what is left of the outer curve at 92.1 °C, which has well above half
        let after = phase.follow(92.1);
        assert!((before - 0.5).abs() < 0.01 && after < 0.3, "{before} {after}");
        assert_eq!(phase.follow(f64::NAN), after);
    }
}
