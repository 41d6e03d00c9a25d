//! The catalogue against the contract: ids, switches, nulls, shapes, ranges.

use sinew_physics::Error;
use sinew_physics::effects::{Home, Nature, Role, catalogue};

use crate::common::hanging;

/// An id, its switches with their nulls, its shapes.
type Row = (&'static str, &'static [(&'static str, f64)], &'static [&'static str]);

/// The contract: ids, their switches with nulls, their shapes. What is not physics of the wire alone (the other channel
/// of a neighbour, the sensor of a delay) is not a number.
const CONTRACT: [Row; 34] = [
    ("thermal.latent_heat", &[("latent_heat_j_per_kg", 0.0)], &[]),
    ("kinetic.stress_shift", &[("stress_shift_k_per_mpa", 0.0)], &[]),
    ("kinetic.minor_loop", &[("outer_loop_weight", 0.0)], &[]),
    // null where it equals the austenite modulus, 75 GPa by default
    ("mechanical.phase_modulus", &[("martensite_modulus_gpa", 75.0)], &[]),
    ("mechanical.thermal_expansion", &[("thermoelastic_mpa_per_k", 0.0)], &[]),
    (
        "electrical.resistivity_temperature",
        &[("austenite_resistivity_slope_uohm_cm_per_k", 0.0), ("martensite_resistivity_slope_uohm_cm_per_k", 0.0)],
        &[],
    ),
    ("thermal.draught", &[("gain", 0.0)], &["start_s", "end_s"]),
    ("thermal.natural_convection", &[("exponent", 0.0)], &[]),
    ("thermal.radiation", &[("emissivity", 0.0)], &[]),
    ("thermal.end_conduction", &[("conductivity_w_per_m_k", 0.0)], &[]),
    ("thermal.sheath", &[("heat_capacity_j_per_k", 0.0)], &["inner_w_per_k", "outer_w_per_k"]),
    ("thermal.ambient_drift", &[("rate_k_per_s", 0.0)], &[]),
    ("thermal.neighbour", &[("conductance_w_per_k", 0.0)], &[]),
    ("electrical.supply_sag", &[("source_ohm", 0.0)], &[]),
    ("electrical.lead_resistance", &[("lead_ohm", 0.0)], &[]),
    ("electrical.resistivity_stress", &[("austenite_per_gpa", 0.0), ("martensite_per_gpa", 0.0)], &[]),
    ("electrical.poisson_area", &[("ratio", 0.0)], &[]),
    ("electrical.r_phase", &[("peak_uohm_cm", 0.0)], &["temperature_c", "width_k"]),
    ("kinetic.asymmetry", &[("heating_skew", 1.0), ("cooling_skew", 1.0)], &[]),
    ("kinetic.unequal_slopes", &[("cooling_extra_k_per_mpa", 0.0)], &[]),
    ("kinetic.distributed", &[("spread_k", 0.0)], &[]),
    ("kinetic.lag", &[("seconds", 0.0)], &[]),
    ("kinetic.training_drift", &[("kelvin_per_cycle", 0.0)], &[]),
    ("mechanical.friction", &[("coulomb_n", 0.0)], &[]),
    ("mechanical.capstan", &[("mu_theta", 0.0)], &[]),
    ("mechanical.ratcheting", &[("strain_per_cycle", 0.0)], &[]),
    ("mechanical.frame_compliance", &[("compliance_m_per_n", 0.0)], &[]),
    ("mechanical.stress_dependent_strain", &[("stress_scale_mpa", 0.0)], &[]),
    ("mechanical.two_way", &[("strain", 0.0)], &[]),
    ("sensing.contact_resistance", &[("ohm", 0.0)], &[]),
    ("sensing.probe_deflection", &[("m_per_n", 0.0)], &[]),
    ("sensing.offset", &[("v1_v", 0.0), ("v2_v", 0.0), ("v3_v", 0.0), ("current_a", 0.0)], &[]),
    ("sensing.gain", &[("v3", 1.0), ("current", 1.0)], &[]),
    ("sensing.delay", &[("seconds", 0.0)], &[]),
];

#[test]
fn the_catalogue_is_that_of_the_contract() {
    let model = hanging();
    let mechanisms: Vec<_> = catalogue().filter(|e| e.nature == Nature::Mechanism).collect();
    assert_eq!(mechanisms.len(), CONTRACT.len());
    for (row, (id, switches, shapes)) in mechanisms.iter().zip(&CONTRACT) {
        assert_eq!(row.id, *id);
        assert_eq!(row.equation.name(), id.split('.').next().unwrap());
        let found: Vec<_> =
            row.parameters.iter().filter(|p| p.is_switch()).map(|p| (p.key, p.null(&model).unwrap())).collect();
        assert_eq!(found, *switches, "{id}");
        let found: Vec<_> =
            row.parameters.iter().filter(|p| matches!(p.role, Role::Shape { .. })).map(|p| p.key).collect();
        assert_eq!(found, *shapes, "{id}");
    }
    let empirical: Vec<_> = catalogue().filter(|e| e.nature == Nature::Empirical).map(|e| e.id).collect();
    let equations = ["thermal", "electrical", "kinetic", "mechanical", "load", "position", "voltage"];
    assert_eq!(empirical, equations.map(|e| format!("empirical.{e}")));
}

#[test]
fn every_parameter_comes_back_as_it_was_set_and_is_checked() {
    for row in catalogue() {
        for p in row.parameters {
            assert!(
                p.low <= p.plausible.0 && p.plausible.0 < p.plausible.1 && p.plausible.1 <= p.high,
                "{} {}",
                row.id,
                p.key
            );
            let mut m = hanging();
            row.set_null(&mut m);
            assert!(row.is_null(&m), "{} {}", row.id, p.key);
            for value in [p.plausible.0, p.plausible.1] {
                (p.set)(&mut m, value);
                assert!(((p.get)(&m) - value).abs() <= 1e-12 * value.abs());
            }
            assert_eq!(row.is_null(&m), !p.is_switch(), "{} {}", row.id, p.key);
            row.set_null(&mut m);
            assert!(row.is_null(&m));
            if row.home == Home::Table {
                // on, then out of range
                for other in row.parameters {
                    (other.set)(&mut m, other.plausible.1);
                }
                m.validate().unwrap_or_else(|e| panic!("{e}"));
                for wrong in [p.high + 1.0 + p.high.abs(), f64::NAN] {
                    (p.set)(&mut m, wrong);
                    let Err(Error::OutOfRange { key, .. }) = m.validate() else { panic!("{} {}", row.id, p.key) };
                    assert_eq!(key, format!("{}.{}", row.id, p.key));
                }
            }
        }
    }
}
