//! Heat: what the air takes, what the wire holds, and how fast it cools (eq. 27, 34, 48).

use crate::params::{Convection, Geometry, Material};

/// How far above ambient wires work, in K: where one number has to stand for a convection that depends on temperature.
/// Effects that make h depend on temperature leave it as the material gives it there.
pub const WORKING_EXCESS_K: f64 = 60.0;

/// The exponent of natural convection in eq. 34.
pub(crate) const CONVECTION_EXPONENT: f64 = 1.0 / 6.0;

/// By what natural convection grows with the temperature above ambient, |T − T_∞|^(1/6) with the difference in K (eq. 34).
#[inline]
pub fn convection_growth(above_k: f64) -> f64 {
    above_k.abs().powf(CONVECTION_EXPONENT)
}

impl Material {
    /// Convection coefficient h of a wire of this diameter at `above_k` over ambient, in W/(m² K): the material's own, or
    /// 65.5 exp(−D/4) (T − T_∞)^(1/6) with D in mm (eq. 34). `above_k` is the operating point: the temperature at hand, or
    /// [`WORKING_EXCESS_K`].
    pub fn convection_at(&self, diameter_m: f64, above_k: f64) -> f64 {
        match self.convection {
            Convection::Constant => self.convection_w_per_m2_k,
            Convection::Natural => 65.5 * (-0.25 * diameter_m * 1e3).exp() * convection_growth(above_k),
        }
    }
}

impl Geometry {
    /// Loss h A_s of the whole wire to the air, in W/K (eq. 27), for a convection coefficient in W/(m² K).
    #[inline]
    pub fn loss_w_per_k(&self, convection_w_per_m2_k: f64) -> f64 {
        convection_w_per_m2_k * self.surface_m2()
    }

    /// Mass ρ_d A_c L_0 of the wire, in kg.
    pub fn mass_kg(&self, material: &Material) -> f64 {
        material.density_kg_per_m3 * self.volume_m3()
    }

    /// Heat capacity m c_p of the wire, in J/K (eq. 48).
    pub fn heat_capacity_j_per_k(&self, material: &Material) -> f64 {
        self.mass_kg(material) * material.specific_heat_j_per_kg_k
    }

    /// Latent heat m ΔH of the whole wire, in J (eq. 48).
    pub fn latent_heat_j(&self, material: &Material) -> f64 {
        self.mass_kg(material) * material.latent_heat_j_per_kg
    }
}

/// Time constant of the wire's cooling, 1/λ = m c_p/(h A_s) (after eq. 34: λ = 4h/(ρ_d D c_p)), in s: from its heat capacity
/// in J/K and its loss in W/K.
#[inline]
pub fn cooling_time_s(heat_capacity_j_per_k: f64, loss_w_per_k: f64) -> f64 {
    heat_capacity_j_per_k / loss_w_per_k
}

/// What relaxes exponentially towards a value, `time_constants` of its time constants later: the solution of eq. 27 for a
/// constant power. Exact for any step.
#[inline]
pub fn relaxed(from: f64, towards: f64, time_constants: f64) -> f64 {
    towards + (from - towards) * (-time_constants).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn natural_convection_is_equation_34() {
        let material = Material { convection: Convection::Natural, ..Material::default() };
        let expected = 65.5 * (-0.125_f64 / 4.0).exp() * 60.0_f64.powf(1.0 / 6.0);
        assert!((material.convection_at(0.125e-3, 60.0) / expected - 1.0).abs() < 1e-14);
        assert_eq!(material.convection_at(0.125e-3, -60.0), material.convection_at(0.125e-3, 60.0));
        assert_eq!(Material::default().convection_at(0.125e-3, 60.0), 121.2, "a constant one does not depend on it");
    }

    #[test]
    fn the_time_constant_does_not_depend_on_the_length() {
        let m = Material::default();
        for length_m in [0.05, 0.4] {
            let wire = Geometry { diameter_m: 0.125e-3, length_m };
            let time_s = cooling_time_s(wire.heat_capacity_j_per_k(&m), wire.loss_w_per_k(m.convection_w_per_m2_k));
            let lambda =
                4.0 * m.convection_w_per_m2_k / (m.density_kg_per_m3 * wire.diameter_m * m.specific_heat_j_per_kg_k);
            assert!((time_s * lambda - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn relaxing_in_two_steps_is_relaxing_in_one() {
        let at_once = relaxed(90.0, 25.0, 1.7);
        assert!((relaxed(relaxed(90.0, 25.0, 0.6), 25.0, 1.1) - at_once).abs() < 1e-12);
    }
}
