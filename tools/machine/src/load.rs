//! What a wire of a rig pulls against: a known mass or spring, which no machine changes, and the force that follows from it.

use sinew_physics::{Load, WireModel};
use sinew_plot::quantity::number;

/// Load of a wire: M ẍ + B ẋ + K x = preload − tension, x its elongation (eq. 51).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnLoad {
    /// Moving mass M, kg.
    pub mass_kg: f64,
    /// Damping B, N s/m.
    pub damping_n_s_per_m: f64,
    /// Spring K, N/m; 0 = a hanging mass.
    pub spring_n_per_m: f64,
    /// Pull at the elongation 0, N.
    pub preload_n: f64,
}

impl OwnLoad {
    /// That of a wire; `None` where something else moves or pulls its end.
    pub fn of(model: &WireModel) -> Option<OwnLoad> {
        match model.load {
            Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } => {
                Some(OwnLoad { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n })
            }
            Load::ImposedPosition | Load::ImposedForce => None,
        }
    }

    /// Tension of the wire at rest at an elongation, N; a wire cannot push.
    pub fn at_rest_n(&self, elongation_m: f64) -> f64 {
        self.tension_n(elongation_m, 0.0, 0.0)
    }

    /// Tension of the wire in motion, N: at this elongation, m, velocity, m/s, and acceleration, m/s². What of the motion is not known
    /// is left out.
    pub fn tension_n(&self, elongation_m: f64, velocity_m_s: f64, acceleration_m_s2: f64) -> f64 {
        let known = |value: f64| if value.is_finite() { value } else { 0.0 };
        let moves_n = self.damping_n_s_per_m * known(velocity_m_s) + self.mass_kg * known(acceleration_m_s2);
        (self.preload_n - self.spring_n_per_m * elongation_m - moves_n).max(0.0)
    }

    /// Whether it pulls the same everywhere.
    pub fn is_constant(&self) -> bool {
        self.spring_n_per_m == 0.0
    }
}

impl std::fmt::Display for OwnLoad {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let OwnLoad { mass_kg, spring_n_per_m, preload_n, .. } = self;
        if self.is_constant() {
            return write!(f, "a mass of {} kg that pulls {} N", number(*mass_kg), number(*preload_n));
        }
        write!(
            f,
            "a spring of {} N/m that pulls {} N at the hot, unloaded length, and {} kg that move with it",
            number(*spring_n_per_m),
            number(*preload_n),
            number(*mass_kg)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_pulls_more_the_shorter_the_wire_and_a_mass_always_the_same() {
        let spring = OwnLoad { mass_kg: 0.1, damping_n_s_per_m: 30.0, spring_n_per_m: 150.0, preload_n: 2.4 };
        assert!((spring.at_rest_n(6e-3) - 1.5).abs() < 1e-12);
        assert_eq!(spring.at_rest_n(0.1), 0.0, "a wire cannot push");
        // it gets shorter, ever faster: friction and mass pull at it besides
        assert!((spring.tension_n(0.0, -0.01, -1.0) - (2.4 + 0.3 + 0.1)).abs() < 1e-12);
        assert_eq!(spring.tension_n(0.0, f64::NAN, f64::NAN), 2.4);
        assert_eq!(
            spring.to_string(),
            "a spring of 150 N/m that pulls 2.4 N at the hot, unloaded length, and 0.1 kg that move with it"
        );
        let mass = OwnLoad { mass_kg: 0.2, damping_n_s_per_m: 30.0, spring_n_per_m: 0.0, preload_n: 1.961 };
        assert_eq!((mass.at_rest_n(0.0), mass.at_rest_n(6e-3)), (1.961, 1.961));
        assert!(mass.is_constant() && mass.to_string().starts_with("a mass of 0.2 kg"));
    }
}
