//! The catalogue of physics a simulation may have left out, by its stable ids.
//!
//! A rig file may name an effect of `[channel.effects."ID"]` at its null. This version simulates none of them,
//! so an effect that is switched on is an error rather than a line nobody reads.

/// One effect beyond the reference model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// Stable id, such as `thermal.draught`.
    pub id: &'static str,
    /// Its parameters.
    pub parameters: &'static [EffectParameter],
    /// How the same can be said in the reference model, or empty.
    pub instead: &'static str,
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Key in the rig file; carries its unit.
    pub name: &'static str,
    /// What it takes.
    pub kind: EffectParameterKind,
}

/// What a parameter of an effect takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EffectParameterKind {
    /// The effect vanishes where all of these are at this value, which is also their default.
    Switch {
        /// The null.
        null: f64,
    },
    /// A number that means nothing while the effect is at its null.
    Number,
    /// The name of another channel.
    Channel,
}

const fn switch(name: &'static str, null: f64) -> EffectParameter {
    EffectParameter { name, kind: EffectParameterKind::Switch { null } }
}

const fn other(name: &'static str) -> EffectParameter {
    EffectParameter { name, kind: EffectParameterKind::Number }
}

const fn effect(id: &'static str, parameters: &'static [EffectParameter]) -> Effect {
    Effect { id, parameters, instead: "" }
}

/// Every effect that lives in `[channel.effects."ID"]`.
pub static EFFECTS: &[Effect] = &[
    effect("thermal.draught", &[switch("gain", 0.0), other("start_s"), other("end_s")]),
    effect("thermal.natural_convection", &[switch("exponent", 0.0)]),
    effect("thermal.radiation", &[switch("emissivity", 0.0)]),
    effect("thermal.end_conduction", &[switch("conductivity_w_per_m_k", 0.0)]),
    effect("thermal.sheath", &[switch("heat_capacity_j_per_k", 0.0), other("inner_w_per_k"), other("outer_w_per_k")]),
    effect("thermal.ambient_drift", &[switch("rate_k_per_s", 0.0)]),
    effect(
        "thermal.neighbour",
        &[switch("conductance_w_per_k", 0.0), EffectParameter { name: "channel", kind: EffectParameterKind::Channel }],
    ),
    effect("electrical.supply_sag", &[switch("source_ohm", 0.0)]),
    Effect {
        id: "electrical.lead_resistance",
        parameters: &[switch("lead_ohm", 0.0)],
        instead: "lead_ohm in [channel.drive]",
    },
    effect("electrical.resistivity_stress", &[switch("austenite_per_gpa", 0.0), switch("martensite_per_gpa", 0.0)]),
    effect("electrical.poisson_area", &[switch("ratio", 0.0)]),
    effect("electrical.r_phase", &[switch("peak_uohm_cm", 0.0), other("temperature_c"), other("width_k")]),
    Effect {
        id: "kinetic.asymmetry",
        parameters: &[switch("heating_skew", 1.0), switch("cooling_skew", 1.0)],
        instead: "kinetics = \"richards\" with heating_skew and cooling_skew in [channel.material]",
    },
    effect("kinetic.unequal_slopes", &[switch("cooling_extra_k_per_mpa", 0.0)]),
    effect("kinetic.distributed", &[switch("spread_k", 0.0)]),
    effect("kinetic.lag", &[switch("seconds", 0.0)]),
    effect("kinetic.training_drift", &[switch("kelvin_per_cycle", 0.0)]),
    effect("mechanical.friction", &[switch("coulomb_n", 0.0)]),
    effect("mechanical.capstan", &[switch("mu_theta", 0.0)]),
    effect("mechanical.ratcheting", &[switch("strain_per_cycle", 0.0)]),
    effect("mechanical.frame_compliance", &[switch("compliance_m_per_n", 0.0)]),
    effect("mechanical.stress_dependent_strain", &[switch("stress_scale_mpa", 0.0)]),
    effect("mechanical.two_way", &[switch("strain", 0.0)]),
    effect("sensing.contact_resistance", &[switch("ohm", 0.0)]),
    effect("sensing.probe_deflection", &[switch("m_per_n", 0.0)]),
    effect(
        "sensing.offset",
        &[switch("v1_v", 0.0), switch("v2_v", 0.0), switch("v3_v", 0.0), switch("current_a", 0.0)],
    ),
    effect("sensing.gain", &[switch("v3", 1.0), switch("current", 1.0)]),
    effect("sensing.delay", &[switch("seconds", 0.0)]),
];

/// Effects that are a coefficient of the reference model, with their keys in `[channel.material]`.
pub static COEFFICIENT_EFFECTS: &[(&str, &[&str])] = &[
    ("thermal.latent_heat", &["latent_heat_j_per_kg"]),
    ("kinetic.stress_shift", &["stress_shift_k_per_mpa"]),
    ("kinetic.minor_loop", &["outer_loop_weight"]),
    ("mechanical.phase_modulus", &["martensite_modulus_gpa"]),
    ("mechanical.thermal_expansion", &["thermoelastic_mpa_per_k"]),
    (
        "electrical.resistivity_temperature",
        &["austenite_resistivity_slope_uohm_cm_per_k", "martensite_resistivity_slope_uohm_cm_per_k"],
    ),
];
