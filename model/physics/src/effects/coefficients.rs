//! Effects that are a coefficient of the reference model: they live with the material and count as left out at their
//! null.

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, Null, Role, parameter, switch};
use crate::params::Material;

impl<M: Has<Material>> Group<M> for Material {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "thermal.latent_heat",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Heating,
            term: "m ΔH ξ̇ in the heat balance (eq. 48)",
            says: "Forming martensite gives off heat and forming austenite takes it up",
            parameters: &[switch!(
                0.0,
                "latent_heat_j_per_kg",
                "J/kg",
                (0.0, 200_000.0),
                (10_000.0, 35_000.0),
                1.0,
                latent_heat_j_per_kg,
                "latent heat of transformation ΔH"
            )],
        },
        Effect {
            id: "kinetic.stress_shift",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Nothing,
            term: "ϑ = T − σ/α (eq. 12)",
            says: "Stress moves the transformation to higher temperatures",
            parameters: &[switch!(
                0.0,
                "stress_shift_k_per_mpa",
                "K/MPa",
                (0.0, 1.0),
                (0.08, 0.16),
                1e-6,
                stress_shift_k_per_pa,
                "shift 1/α of A and M with stress"
            )],
        },
        Effect {
            id: "kinetic.minor_loop",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Nothing,
            term: "dξ/dϑ → (1 − w) dξ/dϑ inside the outer curves (eq. 24)",
            says: "After a reversal the phase holds still until it meets the other outer curve",
            parameters: &[switch!(
                0.0,
                "outer_loop_weight",
                "1",
                (0.0, 1.0),
                (0.5, 0.95),
                1.0,
                outer_loop_weight,
                "weight w of the outer loop"
            )],
        },
        Effect {
            id: "mechanical.phase_modulus",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Nothing,
            term: "C(ξ) = (1 − ξ)/E_A + ξ/E_M (eq. 4)",
            says: "Martensite is softer than austenite",
            parameters: &[parameter!(
                Role::Switch { null: Null::Of(|model: &M| model.part().austenite_modulus_pa / 1e9) },
                "martensite_modulus_gpa",
                "GPa",
                (1.0, 300.0),
                (20.0, 45.0),
                1e9,
                martensite_modulus_pa,
                "Young's modulus E_M of martensite"
            )],
        },
        Effect {
            id: "mechanical.thermal_expansion",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Nothing,
            term: "strain C(ξ) θ (T − T_0) (eq. 23)",
            says: "The wire grows with temperature apart from its transformation",
            parameters: &[switch!(
                0.0,
                "thermoelastic_mpa_per_k",
                "MPa/K",
                (-5.0, 5.0),
                (0.2, 0.9),
                1e6,
                thermoelastic_pa_per_k,
                "thermoelastic coefficient θ"
            )],
        },
        Effect {
            id: "electrical.resistivity_temperature",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Material,
            needs: Needs::Nothing,
            term: "ρ_A0 + α_A (T − T_0), ρ_M0 + α_M (T − T_0) (eq. 37)",
            says: "Each phase's resistivity rises with temperature",
            parameters: &[
                switch!(
                    0.0,
                    "austenite_resistivity_slope_uohm_cm_per_k",
                    "µΩ·cm/K",
                    (-1.0, 1.0),
                    (0.02, 0.3),
                    1e-8,
                    austenite_resistivity_slope_ohm_m_per_k,
                    "slope α_A of austenite's resistivity"
                ),
                switch!(
                    0.0,
                    "martensite_resistivity_slope_uohm_cm_per_k",
                    "µΩ·cm/K",
                    (-1.0, 1.0),
                    (0.02, 0.3),
                    1e-8,
                    martensite_resistivity_slope_ohm_m_per_k,
                    "slope α_M of martensite's resistivity"
                ),
            ],
        },
    ];
}
