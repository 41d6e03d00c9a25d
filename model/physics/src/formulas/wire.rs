//! The formulas of a whole wire: its geometry, its alloy, its circuit and the effects that add to them.

use crate::model::WireModel;

impl WireModel {
    /// What is in series with the wire outside its taps, in Ω: [`Drive::series_ohm`](crate::Drive::series_ohm) with the
    /// effects that add to it, unknown leads and the supply's own resistance. Whoever knows the rig file alone takes
    /// `series_ohm` instead.
    pub fn outside_ohm(&self) -> f64 {
        self.effects.electrical.in_series(self.drive.series_ohm())
    }

    /// Heat capacity m c_p, in J/K (eq. 48).
    pub fn heat_capacity_j_per_k(&self) -> f64 {
        self.geometry.heat_capacity_j_per_k(&self.material)
    }

    /// Latent heat m ΔH of the whole wire, in J (eq. 48).
    pub fn latent_heat_j(&self) -> f64 {
        self.geometry.latent_heat_j(&self.material)
    }

    /// Loss h A_s to the air at `above_k` over ambient, in W/K (eq. 27, 34), without the effects that change it.
    pub fn loss_w_per_k(&self, above_k: f64) -> f64 {
        self.geometry.loss_w_per_k(self.material.convection_at(self.geometry.diameter_m, above_k))
    }

    /// Loss by the material's h alone, in W/K: of a wire whose convection is constant. Where it is not, the number that
    /// stands in the material all the same; what reckons with it asks for no more than its size.
    pub fn constant_loss_w_per_k(&self) -> f64 {
        self.geometry.loss_w_per_k(self.material.convection_w_per_m2_k)
    }

    /// Stiffness of the wire where it is stiffest, E A_c/L_0 with the larger modulus, in N/m.
    pub fn stiffest_n_per_m(&self) -> f64 {
        self.geometry.stiffness_n_per_m(self.material.stiffest_modulus_pa())
    }

    /// Stiffness of the cold wire, all of it martensite, in N/m.
    pub fn cold_stiffness_n_per_m(&self) -> f64 {
        self.geometry.stiffness_n_per_m(self.material.martensite_modulus_pa)
    }
}
