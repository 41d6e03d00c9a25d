//! Strain, stiffness and the pull of the load (eq. 3, 4, 51).

use crate::params::{Geometry, Load, Material};

/// Standard gravity, in m/s².
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// Compliance C(ξ) = 1/E_A + ξ (1/E_M − 1/E_A) of phases in series (eq. 4), in 1/Pa. The same straight line in ξ makes the
/// modulus of phases in parallel of their moduli (eq. 3).
#[inline]
pub fn compliance(austenite_per_pa: f64, martensite_less_austenite_per_pa: f64, martensite: f64) -> f64 {
    austenite_per_pa + martensite_less_austenite_per_pa * martensite
}

/// What a load of spring and damper pulls with when its inertia plays no part, F_preload − K x − B ẋ (eq. 51), in N: from
/// the elongation x in m and its velocity in m/s.
#[inline]
pub fn load_pull_n(
    preload_n: f64,
    spring_n_per_m: f64,
    damping_n_s_per_m: f64,
    elongation_m: f64,
    velocity_m_s: f64,
) -> f64 {
    preload_n - spring_n_per_m * elongation_m - damping_n_s_per_m * velocity_m_s
}

impl Load {
    /// What it pulls with at rest at an elongation in m, in N (eq. 51 at rest); `None` where the load is imposed from
    /// outside.
    pub fn pull_at_rest_n(&self, elongation_m: f64) -> Option<f64> {
        match *self {
            Load::SpringMassDamper { spring_n_per_m, preload_n, .. } => {
                Some(load_pull_n(preload_n, spring_n_per_m, 0.0, elongation_m, 0.0))
            }
            Load::ImposedPosition | Load::ImposedForce => None,
        }
    }

    /// The elongation at which it pulls with a force in N at rest, x = (F_preload − F)/K (eq. 51 the other way), in m;
    /// `None` without a spring, or where the load is imposed.
    pub fn elongation_at_rest_m(&self, force_n: f64) -> Option<f64> {
        match *self {
            Load::SpringMassDamper { spring_n_per_m, preload_n, .. } if spring_n_per_m > 0.0 => {
                Some((preload_n - force_n) / spring_n_per_m)
            }
            _ => None,
        }
    }
}

impl Geometry {
    /// Stiffness of the wire as a spring, E A_c/L_0, in N/m.
    #[inline]
    pub fn stiffness_n_per_m(&self, modulus_pa: f64) -> f64 {
        modulus_pa * self.area_m2() / self.length_m
    }
}

impl Material {
    /// The larger modulus of both phases, in Pa: the stiffest the wire gets.
    pub fn stiffest_modulus_pa(&self) -> f64 {
        self.austenite_modulus_pa.max(self.martensite_modulus_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_pulls_where_it_says_it_does() {
        let load =
            Load::SpringMassDamper { mass_kg: 0.1, damping_n_s_per_m: 30.0, spring_n_per_m: 150.0, preload_n: 2.4 };
        let elongation_m = load.elongation_at_rest_m(1.4).unwrap();
        assert!((load.pull_at_rest_n(elongation_m).unwrap() - 1.4).abs() < 1e-12);
        assert_eq!(Load::ImposedForce.pull_at_rest_n(0.0), None);
    }

    #[test]
    fn pure_phases_have_their_own_compliance() {
        let (austenite, martensite) = (1.0 / 75e9, 1.0 / 28e9);
        assert_eq!(compliance(austenite, martensite - austenite, 0.0), austenite);
        assert!((compliance(austenite, martensite - austenite, 1.0) / martensite - 1.0).abs() < 1e-15);
    }
}
