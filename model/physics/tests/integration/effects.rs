//! Every effect of the catalogue: its row against the contract, its null against the reference model, and its term
//! against an independent computation of the same equation.

use sinew_physics::effects::{self, Effect, Home, Nature, Role, catalogue, effect};
use sinew_physics::*;

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

fn hanging() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: Some(Taps { l0_m: 0.002, ls_m: 0.146 }),
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96133 },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

fn set(model: &mut WireModel, id: &str, key: &str, value: f64) {
    let row = effect(id).unwrap_or_else(|| panic!("{id} is in the catalogue"));
    let parameter = row.parameters.iter().find(|p| p.key == key).unwrap_or_else(|| panic!("{id} has {key}"));
    (parameter.set)(model, value);
}

fn with(model: &WireModel, values: &[(&str, &str, f64)]) -> WireModel {
    let mut model = model.clone();
    for (id, key, value) in values {
        set(&mut model, id, key, *value);
    }
    model
}

/// The rows beyond the reference model.
fn tables() -> impl Iterator<Item = &'static Effect> {
    catalogue().filter(|e| e.home == Home::Table)
}

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

/// The excitation of the comparisons: stairs of duty, up and down.
fn duty(t: f64) -> f64 {
    [0.05, 0.28, 0.14, 0.2, 0.12, 0.3, 0.02, 0.16][(t / 0.9) as usize % 8]
}

/// Columns every comparison looks at.
fn columns(o: &Outputs) -> [f64; 8] {
    [o.temperature_c, o.martensite, o.position_m, o.resistance_ohm, o.v2_v, o.v3_v, o.current_a, o.force_n]
}

fn hang(model: &WireModel, dt: f64, seconds: f64) -> Vec<[f64; 8]> {
    let mut wire = Wire::new(model).expect("a valid model");
    let every = (0.05 / dt).round() as usize;
    (1..=(seconds / dt).round() as usize)
        .filter_map(|k| {
            wire.step(&Inputs { drive: duty((k as f64 - 0.5) * dt), ..model.rest_inputs() }, dt);
            (k % every == 0).then(|| columns(&wire.outputs()))
        })
        .collect()
}

/// Largest difference per column.
fn apart(a: &[[f64; 8]], b: &[[f64; 8]]) -> [f64; 8] {
    std::array::from_fn(|i| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs()).fold(0.0, f64::max))
}

/// Effects that are there but at their null take the long way through the equations and arrive at the same place.
#[test]
fn effects_at_their_null_are_the_reference_model() {
    let loads = [
        hanging().load,
        Load::ImposedForce,
        Load::ImposedPosition,
        Load::SpringMassDamper { mass_kg: 0.01, damping_n_s_per_m: 0.5, spring_n_per_m: 200.0, preload_n: 1.0 },
    ];
    for load in loads {
        let plain = WireModel { load, ..hanging() };
        let mut null = plain.clone();
        for row in tables() {
            for p in row.parameters.iter().filter(|p| !p.is_switch()) {
                (p.set)(&mut null, 0.5 * (p.plausible.0 + p.plausible.1));
            }
        }
        assert!(null.effects != plain.effects && tables().all(|row| row.is_null(&null)));
        let (mut a, mut b) = (Wire::new(&plain).unwrap(), Wire::new(&null).unwrap());
        for k in 0..4000 {
            let t = 2e-3 * f64::from(k);
            let imposed = match load {
                Load::ImposedForce => 1.5 + (0.8 * t).sin(),
                Load::ImposedPosition => 0.003 + 0.002 * (0.8 * t).sin(),
                Load::SpringMassDamper { .. } => 0.0,
            };
            let inputs = Inputs { drive: duty(t), imposed, ..plain.rest_inputs() };
            a.step(&inputs, 2e-3);
            b.step(&inputs, 2e-3);
            for (x, y) in columns(&a.outputs()).iter().zip(columns(&b.outputs())) {
                assert!((x - y).abs() <= 1e-9 * (1.0 + x.abs()), "{load:?} at {t}: {x} {y}");
            }
        }
    }
}

/// One setting of each mechanism of the catalogue, of a size that rigs show.
fn settings() -> Vec<(&'static str, Vec<(&'static str, f64)>)> {
    vec![
        ("thermal.draught", vec![("gain", 0.4), ("start_s", 1.5), ("end_s", 3.5)]),
        ("thermal.natural_convection", vec![("exponent", 0.17)]),
        ("thermal.radiation", vec![("emissivity", 0.8)]),
        ("thermal.end_conduction", vec![("conductivity_w_per_m_k", 18.0)]),
        ("thermal.sheath", vec![("heat_capacity_j_per_k", 0.01), ("inner_w_per_k", 0.02), ("outer_w_per_k", 0.01)]),
        ("thermal.ambient_drift", vec![("rate_k_per_s", 0.8)]),
        ("thermal.neighbour", vec![("conductance_w_per_k", 2e-3)]),
        ("electrical.supply_sag", vec![("source_ohm", 0.5)]),
        ("electrical.lead_resistance", vec![("lead_ohm", 0.4)]),
        ("electrical.resistivity_stress", vec![("austenite_per_gpa", 0.4), ("martensite_per_gpa", 0.2)]),
        ("electrical.poisson_area", vec![("ratio", 0.33)]),
        ("electrical.r_phase", vec![("peak_uohm_cm", 9.0), ("temperature_c", 60.0), ("width_k", 12.0)]),
        ("kinetic.asymmetry", vec![("heating_skew", 2.0), ("cooling_skew", 0.6)]),
        ("kinetic.unequal_slopes", vec![("cooling_extra_k_per_mpa", -0.04)]),
        ("kinetic.distributed", vec![("spread_k", 5.0)]),
        ("kinetic.lag", vec![("seconds", 0.2)]),
        ("kinetic.training_drift", vec![("kelvin_per_cycle", 0.8)]),
        ("mechanical.friction", vec![("coulomb_n", 0.15)]),
        ("mechanical.capstan", vec![("mu_theta", 0.1)]),
        ("mechanical.ratcheting", vec![("strain_per_cycle", 3e-4)]),
        ("mechanical.frame_compliance", vec![("compliance_m_per_n", 3e-4)]),
        ("mechanical.stress_dependent_strain", vec![("stress_scale_mpa", 90.0)]),
        ("mechanical.two_way", vec![("strain", 0.006)]),
        ("sensing.contact_resistance", vec![("ohm", 0.3)]),
        ("sensing.probe_deflection", vec![("m_per_n", 5e-4)]),
        ("sensing.offset", vec![("v1_v", 0.02), ("v2_v", 0.02), ("v3_v", 0.02), ("current_a", 0.01)]),
        ("sensing.gain", vec![("v3", 1.02), ("current", 0.98)]),
        ("sensing.delay", vec![("seconds", 0.06)]),
    ]
}

fn set_all(model: &WireModel, id: &'static str, values: &[(&'static str, f64)]) -> WireModel {
    let values: Vec<_> = values.iter().map(|(key, value)| (id, *key, *value)).collect();
    with(model, &values)
}

/// What an effect changes is the same at steps of 1 ms and 5 ms.
#[test]
fn what_an_effect_does_does_not_depend_on_the_step() {
    let model = hanging();
    let (fine, coarse) = (hang(&model, 1e-3, 8.0), hang(&model, 5e-3, 8.0));
    assert_eq!(settings().len(), tables().filter(|e| e.nature == Nature::Mechanism).count());
    let mut wrong = Vec::new();
    for (id, values) in settings() {
        let on = set_all(&model, id, &values);
        let (fine_on, coarse_on) = (hang(&on, 1e-3, 8.0), hang(&on, 5e-3, 8.0));
        let size = apart(&fine_on, &fine);
        let change = |on: &[[f64; 8]], off: &[[f64; 8]]| -> Vec<[f64; 8]> {
            on.iter().zip(off).map(|(on, off)| std::array::from_fn(|i| on[i] - off[i])).collect()
        };
        let error = apart(&change(&coarse_on, &coarse), &change(&fine_on, &fine));
        assert!(size.iter().any(|s| *s > 1e-5), "{id} does nothing: {size:?}");
        for i in 0..8 {
            // where it only passes through another column, the reference model's own error of the step is the floor
            let floor = 0.3 * apart(&coarse, &fine)[i];
            if error[i] > 0.01 * size[i] + floor {
                wrong.push(format!(
                    "{id} column {i}: {:.3} % of {}, floor {floor}",
                    100.0 * error[i] / size[i],
                    size[i]
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The less there is of an effect, the less it changes: a search comes as near to a null as it likes.
#[test]
fn effects_grow_from_their_null() {
    let model = hanging();
    let plain = hang(&model, 5e-3, 4.0);
    for (id, values) in settings() {
        let row = effects::effect(id).unwrap();
        let change = |share: f64| {
            let mut little = set_all(&model, id, &values);
            for p in row.parameters.iter().filter(|p| p.is_switch()) {
                let null = p.null(&model).expect("a switch has a null");
                let value = (p.get)(&little);
                (p.set)(&mut little, null + share * (value - null));
            }
            let got = hang(&little, 5e-3, 4.0);
            assert!(got.iter().flatten().all(|x| x.is_finite()), "{id} at {share} of its size");
            apart(&got, &plain)
        };
        let whole = change(1.0);
        for share in [1e-3, 1e-9, 1e-30] {
            let part = change(share);
            if id == "thermal.sheath" {
                // a sleeve that holds no heat keeps heat in all the same, and is the contract's null nevertheless
                continue;
            }
            // cold zones reach as far as the root of what conducts; steps are solved to a thousandth
            let most = 2.0 * share.sqrt() + 1e-3;
            for i in 0..8 {
                let floor = 1e-6 * [100.0, 1.0, 7e-3, 10.0, 6.0, 6.0, 0.6, 2.0][i];
                assert!(part[i] <= most * whole[i] + floor, "{id} at {share}, column {i}: {} of {}", part[i], whole[i]);
            }
        }
    }
}

/// An explicit integration of the contract's equations in steps of 40 µs, for a wire on its outer curves under an
/// imposed tension: another way to every term that acts there. It reads the catalogue's numbers, not the simulator's.
struct Explicit {
    temperature: f64,
    /// Per grain: ξ_eq.
    grains: Vec<f64>,
    martensite: f64,
    sleeve: f64,
    travel: f64,
    resistance: f64,
    strain: f64,
}

/// What a comparison looks at: T, ξ, x and R, V_3 and I.
fn seen(o: &Outputs) -> [f64; 6] {
    [o.temperature_c, o.martensite, o.position_m, o.resistance_ohm, o.v3_v, o.current_a]
}

/// Tension over time, N.
fn tension(t: f64) -> f64 {
    2.0 + 0.8 * (1.3 * t).sin()
}

/// Quantiles of the normal distribution, as many as grains: by bisection on its integral.
fn normal_quantiles(n: usize) -> Vec<f64> {
    let step = 1e-3;
    let mut integral = 0.0;
    let mut found = Vec::new();
    let mut z = -8.0;
    while found.len() < n {
        let middle: f64 = z + 0.5 * step;
        integral += step * (-0.5 * middle * middle).exp() / (2.0 * std::f64::consts::PI).sqrt();
        z += step;
        while found.len() < n && integral > (found.len() as f64 + 0.5) / n as f64 {
            found.push(z);
        }
    }
    // so few lack the tails: the spread is given, not the tails
    let deviation = (found.iter().map(|z| z * z).sum::<f64>() / n as f64).sqrt();
    found.iter().map(|z| z / deviation).collect()
}

fn explicitly(model: &WireModel, seconds: f64, neighbour_c: f64) -> Vec<[f64; 6]> {
    let get = |id: &str, key: &str| -> f64 {
        let row = effect(id).unwrap();
        (row.parameters.iter().find(|p| p.key == key).unwrap().get)(model)
    };
    let (m, g) = (&model.material, &model.geometry);
    let (area, surface) = (g.area_m2(), g.surface_m2());
    let mass = m.density_kg_per_m3 * g.volume_m3();
    let capacity = mass * m.specific_heat_j_per_kg_k;
    let spread = get("kinetic.distributed", "spread_k");
    let offsets: Vec<f64> =
        if spread > 0.0 { normal_quantiles(41).iter().map(|z| z * spread).collect() } else { vec![0.0] };
    let sheath = ["heat_capacity_j_per_k", "inner_w_per_k", "outer_w_per_k"].map(|key| get("thermal.sheath", key));
    let draught = ["gain", "start_s", "end_s"].map(|key| get("thermal.draught", key));
    let scale = get("mechanical.stress_dependent_strain", "stress_scale_mpa") * 1e6;
    let two_way = get("mechanical.two_way", "strain");
    let skews = ["heating_skew", "cooling_skew"].map(|key| get("kinetic.asymmetry", key));
    let extra = get("kinetic.unequal_slopes", "cooling_extra_k_per_mpa") * 1e-6;
    let lag = get("kinetic.lag", "seconds");
    let drift = get("kinetic.training_drift", "kelvin_per_cycle");
    let ratchet = get("mechanical.ratcheting", "strain_per_cycle");
    let exponent = get("thermal.natural_convection", "exponent");
    let emissivity = get("thermal.radiation", "emissivity");
    let warming = get("thermal.ambient_drift", "rate_k_per_s");
    let between = get("thermal.neighbour", "conductance_w_per_k");
    let betas = ["austenite_per_gpa", "martensite_per_gpa"].map(|key| get("electrical.resistivity_stress", key) * 1e-9);
    let poisson = get("electrical.poisson_area", "ratio");
    let bump = ["peak_uohm_cm", "temperature_c", "width_k"].map(|key| get("electrical.r_phase", key));
    let contact = get("sensing.contact_resistance", "ohm");
    let circuit = model.drive.shunt_ohm
        + model.drive.switch_ohm
        + get("electrical.supply_sag", "source_ohm")
        + get("electrical.lead_resistance", "lead_ohm")
        + contact;
    let frame = get("mechanical.frame_compliance", "compliance_m_per_n");
    let curve = |k: f64, theta: f64, centre: f64, skew: f64| {
        (1.0 + skew * (k * (theta - centre)).min(300.0).exp()).powf(-1.0 / skew)
    };
    // ξ_eq held between the curves: the outer loop alone (w = 1)
    let clipped = |xi: f64, theta: f64, stress: f64| {
        let upper = curve(m.heating_steepness_per_k, theta, m.austenite_temperature_c, skews[0]);
        let lower = curve(m.cooling_steepness_per_k, theta, m.martensite_temperature_c + extra * stress, skews[1]);
        xi.max(lower).min(upper)
    };
    // from 10 % to 90 % in 0.15 s, as a ramp
    let edge = |since: f64| (0.5 + since / 0.1875).clamp(0.0, 1.0);
    let mean = |grains: &[f64]| grains.iter().sum::<f64>() / grains.len() as f64;
    let stress_at = |t: f64| tension(t) / area;
    let measure = |s: &mut Explicit, stress: f64| {
        let xi = s.martensite;
        let compliance = (1.0 - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
        let oriented = if scale > 0.0 { 1.0 - (-stress / scale).exp() } else { 1.0 };
        let warm = s.temperature - m.reference_temperature_c;
        s.strain = compliance * (stress + m.thermoelastic_pa_per_k * warm)
            + (m.transformation_strain * oriented + two_way) * xi
            + ratchet * 0.5 * s.travel;
        let austenite = (m.austenite_resistivity_ohm_m + m.austenite_resistivity_slope_ohm_m_per_k * warm)
            * (1.0 + betas[0] * stress);
        let martensite = (m.martensite_resistivity_ohm_m + m.martensite_resistivity_slope_ohm_m_per_k * warm)
            * (1.0 + betas[1] * stress);
        let z = (s.temperature - bump[1]) / bump[2];
        let resistivity = (1.0 - xi) * austenite + xi * martensite + bump[0] * 1e-8 * (-0.5 * z * z).exp() * xi;
        let narrow = 1.0 - poisson * stress * compliance;
        s.resistance = resistivity * g.length_m * (1.0 + s.strain) / (area * narrow * narrow);
    };
    let mut s = Explicit {
        temperature: model.ambient_c,
        grains: offsets.iter().map(|_| 1.0).collect(),
        martensite: 1.0,
        sleeve: model.ambient_c,
        travel: 0.0,
        resistance: 0.0,
        strain: 0.0,
    };
    let start = stress_at(0.0);
    for (xi, offset) in s.grains.iter_mut().zip(&offsets) {
        *xi = clipped(1.0, model.ambient_c - m.stress_shift_k_per_pa * start - offset, start);
    }
    s.martensite = mean(&s.grains);
    measure(&mut s, start);
    let dt = 4e-5;
    let mut rows = Vec::new();
    for k in 0..(seconds / dt).round() as usize {
        let t = k as f64 * dt;
        let stress = stress_at(t + dt);
        let current = model.drive.supply_v / (s.resistance + circuit);
        let power = duty(t + 0.5 * dt) * current * current * s.resistance;
        let ambient = model.ambient_c + warming * t;
        let above = s.temperature - ambient;
        let window = 1.0 + draught[0] * (edge(t - draught[1]) - edge(t - draught[2]));
        let mut loss = if sheath[0] > 0.0 {
            let inner = sheath[1] * (s.temperature - s.sleeve);
            s.sleeve += dt / sheath[0] * (inner - sheath[2] * (s.sleeve - ambient));
            inner
        } else {
            m.convection_w_per_m2_k * surface * window * (above.abs() / 60.0).powf(exponent) * above
        };
        let kelvin = |c: f64| (c + 273.15).powi(4);
        loss += emissivity * 5.670374419e-8 * surface * (kelvin(s.temperature) - kelvin(ambient));
        loss += between * (s.temperature - neighbour_c);
        // T and ξ together: m c_p ΔT = heat + (m ΔH + V ε σ) Δξ, by Newton on T with the slope taken numerically
        let oriented = if scale > 0.0 { 1.0 - (-stress / scale).exp() } else { 1.0 };
        let released =
            mass * m.latent_heat_j_per_kg + g.volume_m3() * stress * (m.transformation_strain * oriented + two_way);
        let shift = drift * 0.5 * s.travel;
        let phase = |temperature: f64, grains: &mut Vec<f64>| {
            for (i, offset) in offsets.iter().enumerate() {
                let theta = temperature - m.stress_shift_k_per_pa * stress - shift - offset;
                grains[i] = clipped(s.grains[i], theta, stress);
            }
            let equilibrium = mean(grains);
            if lag > 0.0 { s.martensite + dt / lag * (equilibrium - s.martensite) } else { equilibrium }
        };
        let heated = s.temperature + dt * (power - loss) / capacity;
        let mut grains = s.grains.clone();
        let mut temperature = s.temperature;
        for _ in 0..6 {
            let at =
                |t: f64, grains: &mut Vec<f64>| t - heated - released / capacity * (phase(t, grains) - s.martensite);
            let error = at(temperature, &mut grains);
            let slope = (at(temperature + 1e-6, &mut grains) - error) / 1e-6;
            temperature -= error / slope.max(1.0);
            if error.abs() < 1e-10 {
                break;
            }
        }
        let martensite = phase(temperature, &mut grains);
        s.travel += (martensite - s.martensite).abs();
        s.temperature = temperature;
        s.martensite = martensite;
        s.grains = grains;
        measure(&mut s, stress);
        if (k + 1) % 1250 == 0 {
            let current = model.drive.supply_v / (s.resistance + circuit);
            let position = g.length_m * s.strain + frame * area * stress;
            rows.push([
                s.temperature,
                s.martensite,
                position,
                s.resistance,
                current * (s.resistance + contact),
                current,
            ]);
        }
    }
    rows
}

fn simulated(model: &WireModel, seconds: f64, neighbour_c: f64) -> Vec<[f64; 6]> {
    let dt = 1e-3;
    let at = |t: f64| Inputs { drive: duty(t - 0.5 * dt), imposed: tension(t), ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(model, &at(0.0)).expect("a valid model");
    wire.set_neighbour_c(neighbour_c);
    (1..=(seconds / dt).round() as usize)
        .filter_map(|k| {
            wire.step(&at(k as f64 * dt), dt);
            (k % 50 == 0).then(|| seen(&wire.outputs()))
        })
        .collect()
}

/// What each term changes, by the simulator and by the explicit integration of the equations.
#[test]
fn terms_agree_with_an_explicit_integration_of_their_equations() {
    let mut model = WireModel { load: Load::ImposedForce, ..hanging() };
    model.material.outer_loop_weight = 1.0;
    let (plain, expected_plain) = (simulated(&model, 4.5, 60.0), explicitly(&model, 4.5, 60.0));
    let mut wrong = Vec::new();
    for (id, values) in settings() {
        let elsewhere = ["thermal.end_conduction", "mechanical.friction", "mechanical.capstan"];
        if elsewhere.contains(&id) || (id.starts_with("sensing.") && id != "sensing.contact_resistance") {
            continue;
        }
        let on = set_all(&model, id, &values);
        let (got, expected) = (simulated(&on, 4.5, 60.0), explicitly(&on, 4.5, 60.0));
        for i in 0..6 {
            let mut size = 0.0f64;
            let mut error = 0.0f64;
            for k in 0..got.len() {
                let (got, expected) = (got[k][i] - plain[k][i], expected[k][i] - expected_plain[k][i]);
                size = size.max(expected.abs());
                error = error.max((got - expected).abs());
            }
            let range = [100.0, 1.0, 7e-3, 2.0, 6.0, 1.0][i];
            if error > 0.02 * size + 1e-4 * range {
                wrong.push(format!("{id} column {i}: off by {error} of {size}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A furnace: the temperature over time is given, so movement is slow and known.
fn furnace(load: Load) -> WireModel {
    WireModel { load, drive: Drive { kind: DriveKind::Temperature, ..hanging().drive }, ..hanging() }
}

/// A mass that lags little behind.
fn light_damping() -> Load {
    Load::SpringMassDamper { mass_kg: 0.002, damping_n_s_per_m: 0.3, spring_n_per_m: 0.0, preload_n: 1.96133 }
}

/// Heats to 130 °C and cools to 40 °C in 10 s each, and says at each 5 ms: tension, position.
fn furnace_cycle(model: &WireModel, imposed: f64) -> Vec<(f64, f64)> {
    let at = |t: f64| Inputs {
        drive: if t < 10.0 { 40.0 + 9.0 * t } else { 220.0 - 9.0 * t },
        imposed,
        ..model.rest_inputs()
    };
    let mut wire = Wire::with_inputs(model, &at(0.0)).expect("a valid model");
    (1..=4000)
        .map(|k| {
            let t = 5e-3 * f64::from(k);
            wire.step(&at(t), 5e-3);
            (wire.outputs().force_n, wire.position_m())
        })
        .collect()
}

/// Sliding friction adds to the tension of a wire that gets shorter and takes from one that gets longer; between them
/// the end stands still.
#[test]
fn friction_sticks_and_slips() {
    let weight = 1.96133;
    let (coulomb, wrap) = (0.12, 0.08f64);
    let rigs = [(furnace(light_damping()), 0.0), (furnace(Load::ImposedForce), weight)];
    for (rig, imposed) in rigs {
        for (id, key, value, shorter, longer) in [
            ("mechanical.friction", "coulomb_n", coulomb, weight + coulomb, weight - coulomb),
            ("mechanical.capstan", "mu_theta", wrap, weight * wrap.exp(), weight / wrap.exp()),
        ] {
            let rows = furnace_cycle(&with(&rig, &[(id, key, value)]), imposed);
            let (mut slipped, mut stuck, mut back) = (0, 0, 0);
            for pair in rows.windows(2) {
                let ((_, before), (force, x)) = (pair[0], pair[1]);
                let speed = (x - before) / 5e-3;
                assert!(force >= longer - 2e-3 && force <= shorter + 2e-3, "{id}: {force}");
                if speed < -1e-5 {
                    assert!((force - shorter).abs() < 4e-3, "{id}: {force} while getting shorter by {speed}");
                    slipped += 1;
                } else if speed > 1e-5 {
                    // thermal strain makes the cold wire longer before it transforms
                    assert!((force - longer).abs() < 4e-3, "{id}: {force} while getting longer by {speed}");
                    back += 1;
                } else if speed.abs() < 1e-9 {
                    stuck += 1;
                }
            }
            assert!(slipped > 100 && back > 100 && stuck > 200, "{id}: {slipped} {back} {stuck}");
        }
    }
    // a machine that imposes the movement measures the friction on top
    let machine = WireModel { load: Load::ImposedPosition, ..furnace(Load::ImposedPosition) };
    let pull = |model: &WireModel| {
        let at = |t: f64| Inputs { imposed: 0.006 + 0.0005 * (t * 2.0).sin(), ..model.rest_inputs() };
        let mut wire = Wire::with_inputs(model, &at(0.0)).unwrap();
        (1..=1000)
            .map(|k| {
                wire.step(&at(5e-3 * f64::from(k)), 5e-3);
                (wire.outputs().force_n, wire.velocity_m_s())
            })
            .collect::<Vec<_>>()
    };
    let (free, dry) = (pull(&machine), pull(&with(&machine, &[("mechanical.friction", "coulomb_n", coulomb)])));
    for ((free, v), (dry, _)) in free.iter().zip(&dry) {
        if v.abs() > 4e-4 {
            assert!((dry - free - coulomb * v.signum()).abs() < 1e-3 * coulomb, "{dry} {free} at {v}");
        }
    }
}

/// A load that friction holds stays where it is, and one that rings comes to rest.
#[test]
fn friction_stops_a_ringing_load() {
    let mut model = hanging();
    model.load =
        Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 0.0, spring_n_per_m: 0.0, preload_n: 1.96133 };
    let model = with(&model, &[("mechanical.friction", "coulomb_n", 0.05)]);
    let mut wire = Wire::new(&model).unwrap();
    for _ in 0..500 {
        wire.step(&Inputs { external_n: 0.6, ..model.rest_inputs() }, 1e-3);
    }
    let there = wire.position_m();
    for k in 0..500 {
        // a pull within twice the friction changes nothing
        wire.step(&Inputs { external_n: 0.6 - 0.04 * f64::from(k % 2), ..model.rest_inputs() }, 1e-3);
        assert!((wire.position_m() - there).abs() < 1e-9 && wire.velocity_m_s().abs() < 1e-9);
    }
}

/// The cold ends of a wire that is heated steadily, against an integral along it: each point on its own outer curve at
/// the temperature of a fin.
#[test]
fn cold_ends_are_those_of_a_fin() {
    let mut model = WireModel { load: Load::ImposedForce, taps: Some(Taps { l0_m: 0.004, ls_m: 0.15 }), ..hanging() };
    model.material.outer_loop_weight = 1.0;
    model.drive.kind = DriveKind::Power;
    let force = 1.5;
    for length in [0.16, 0.03] {
        model.geometry.length_m = length;
        model.taps = Some(Taps { l0_m: 0.004, ls_m: length - 0.008 });
        for power in [2.5, 3.7, 4.2, 6.0] {
            let power = power * length;
            let on = with(&model, &[("thermal.end_conduction", "conductivity_w_per_m_k", 18.0)]);
            let inputs = Inputs { drive: power, imposed: force, ..model.rest_inputs() };
            let settle = |model: &WireModel| {
                let mut wire = Wire::with_inputs(model, &Inputs { drive: 0.0, ..inputs }).unwrap();
                for k in 1..=9000 {
                    // so slowly that nothing overshoots
                    let drive = power * (f64::from(k) / 1500.0).min(1.0);
                    wire.step(&Inputs { drive, ..inputs }, 5e-3);
                }
                wire.outputs()
            };
            let (plain, got) = (settle(&model), settle(&on));
            let (m, g) = (&model.material, &model.geometry);
            let stress = force / g.area_m2();
            let per_metre = m.convection_w_per_m2_k * std::f64::consts::PI * g.diameter_m;
            let at = |t: f64| {
                let z = m.heating_steepness_per_k * (t - m.stress_shift_k_per_pa * stress - m.austenite_temperature_c);
                let xi = 1.0 / (1.0 + z.exp());
                let compliance = (1.0 - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
                let warm = t - m.reference_temperature_c;
                let strain = compliance * (stress + m.thermoelastic_pa_per_k * warm) + m.transformation_strain * xi;
                let resistivity = (1.0 - xi)
                    * (m.austenite_resistivity_ohm_m + m.austenite_resistivity_slope_ohm_m_per_k * warm)
                    + xi * (m.martensite_resistivity_ohm_m + m.martensite_resistivity_slope_ohm_m_per_k * warm);
                (strain, resistivity)
            };
            // k A T'' = h π d (T − T∞) − p, with p by the resistance there, until that no longer changes
            let n = 4000;
            let piece = length / n as f64;
            let link = 18.0 * g.area_m2() / (piece * piece);
            let mut rise = vec![0.0; n];
            for _ in 0..200 {
                let local: Vec<f64> = rise.iter().map(|rise| at(25.0 + rise).1).collect();
                let all: f64 = local.iter().sum::<f64>() * piece;
                // half the wire by elimination from the clamp on, the other half is its mirror
                let half = n / 2;
                let (mut held, mut heat) = (vec![0.0; half], vec![0.0; half]);
                for i in 0..half {
                    let towards = if i == 0 { 2.0 * link } else { link };
                    held[i] = per_metre + towards + if i + 1 < half { link } else { 0.0 };
                    heat[i] = power * local[i] / all;
                    if i > 0 {
                        let weight = link / held[i - 1];
                        held[i] -= weight * link;
                        heat[i] += weight * heat[i - 1];
                    }
                }
                let mut next = 0.0;
                for i in (0..half).rev() {
                    next = (heat[i] + if i + 1 < half { link * next } else { 0.0 }) / held[i];
                    // halfway only: resistance falls as the wire transforms
                    rise[i] += 0.5 * (next - rise[i]);
                    rise[n - 1 - i] = rise[i];
                }
            }
            let above = rise[n / 2];
            assert!((got.temperature_c - 25.0 - above).abs() < 2e-3 * above, "{length} m, {power} W: {got:?} {above}");
            let (mut strain, mut ohm, mut ohm_to_tap) = (0.0, 0.0, 0.0);
            for (i, rise) in rise.iter().enumerate() {
                let (local, resistivity) = at(25.0 + rise);
                strain += local * piece;
                ohm += resistivity * piece / g.area_m2();
                if (i as f64 + 0.5) * piece < 0.004 {
                    ohm_to_tap += resistivity * piece / g.area_m2();
                }
            }
            let stretched = 1.0 + strain / length;
            let near = |got: f64, expected: f64, plain: f64, what: &str| {
                let size = (expected - plain).abs();
                assert!(
                    (got - expected).abs() < 0.04 * size + 2e-4 * plain.abs(),
                    "{what}, {length} m, {power} W: {got}, expected {expected}, without {plain}"
                );
            };
            near(got.position_m, strain, plain.position_m, "position");
            near(got.resistance_ohm, ohm * stretched, plain.resistance_ohm, "resistance");
            near(got.v1_v / got.current_a, ohm_to_tap, plain.v1_v / plain.current_a, "first tap");
        }
    }
}

#[test]
fn a_delayed_sensor_shows_what_was() {
    for (sensor, column) in [
        (effects::DelayedSensor::Position, 2),
        (effects::DelayedSensor::Voltages, 5),
        (effects::DelayedSensor::Current, 6),
        (effects::DelayedSensor::Force, 7),
    ] {
        assert_eq!(effects::DelayedSensor::from_name(sensor.name()), Some(sensor));
        for (dt, steps_behind) in [(1e-3, 60), (0.02, 3), (5e-5, 1200)] {
            let model = hanging();
            let mut late = with(&model, &[("sensing.delay", "seconds", 0.06)]);
            late.effects.sensing.delay.sensor = sensor;
            let (mut a, mut b) = (Wire::new(&model).unwrap(), Wire::new(&late).unwrap());
            let mut history = vec![columns(&a.outputs())];
            let scale = [1.0, 1.0, 7e-3, 8.0, 6.0, 6.0, 0.7, 2.0][column];
            for k in 1..(2.0 / dt) as usize {
                let inputs = Inputs { drive: 0.2 + 0.15 * (4.0 * k as f64 * dt).sin(), ..model.rest_inputs() };
                a.step(&inputs, dt);
                b.step(&inputs, dt);
                history.push(columns(&a.outputs()));
                let shown = columns(&b.outputs());
                let then = history[k.saturating_sub(steps_behind)][column];
                assert!(
                    (shown[column] - then).abs() < 1e-4 * scale,
                    "{sensor:?}, {dt} s, step {k}: {} {then}",
                    shown[column]
                );
                let other = if column == 2 { 5 } else { 2 };
                assert!((shown[other] - history[k][other]).abs() < 1e-12);
            }
        }
    }
    assert_eq!(effects::DelayedSensor::from_name("position"), None);
}

/// Amplifiers, the probe and the crimp change what is seen, not the wire.
#[test]
fn sensors_err_as_they_are_told() {
    let plain = hanging();
    let on = with(
        &plain,
        &[
            ("sensing.offset", "v1_v", 0.01),
            ("sensing.offset", "v3_v", -0.02),
            ("sensing.offset", "current_a", 0.005),
            ("sensing.gain", "v3", 1.03),
            ("sensing.gain", "current", 0.98),
            ("sensing.probe_deflection", "m_per_n", 4e-4),
        ],
    );
    let (mut a, mut b) = (Wire::new(&plain).unwrap(), Wire::new(&on).unwrap());
    for k in 0..1000 {
        let inputs = Inputs { drive: duty(4e-3 * f64::from(k)), ..plain.rest_inputs() };
        a.step(&inputs, 4e-3);
        b.step(&inputs, 4e-3);
        let (a, b) = (a.outputs(), b.outputs());
        assert!((b.v1_v - a.v1_v - 0.01).abs() < 1e-9);
        assert!((b.v3_v - (1.03 * a.v3_v - 0.02)).abs() < 1e-9);
        assert!((b.current_a - (0.98 * a.current_a + 0.005)).abs() < 1e-9);
        assert!((b.v2_v / a.v2_v - (0.148 - 4e-4 * a.force_n) / 0.148).abs() < 1e-9);
        assert!((b.position_m - a.position_m).abs() < 1e-12);
    }
}

/// An unknown input to an equation against the same thing said by known means.
#[test]
fn an_unknown_input_is_a_known_one_unsaid() {
    let run = |model: &WireModel, inputs: Inputs, unknown: Unknown| -> Vec<[f64; 8]> {
        let mut wire = Wire::with_inputs(model, &inputs).expect("a valid model");
        wire.set_unknown(unknown);
        (0..2000)
            .map(|k| {
                let drive = inputs.drive
                    + if model.drive.kind == DriveKind::Power {
                        2.5 * duty(4e-3 * f64::from(k))
                    } else {
                        duty(4e-3 * f64::from(k))
                    };
                wire.step(&Inputs { drive, ..inputs }, 4e-3);
                columns(&wire.outputs())
            })
            .collect()
    };
    let same = |a: &[[f64; 8]], b: &[[f64; 8]], tolerance: f64, what: &str| {
        let apart = apart(a, b);
        let scale = [100.0, 1.0, 7e-3, 8.0, 6.0, 6.0, 0.7, 2.0];
        assert!((0..8).all(|i| apart[i] <= tolerance * scale[i]), "{what}: {apart:?}");
    };
    let none = Unknown::default();
    let hanging = hanging();
    let inputs = hanging.rest_inputs();
    let mut powered = hanging.clone();
    powered.drive.kind = DriveKind::Power;
    // the current that goes with a given power is another matter
    let heat = |rows: Vec<[f64; 8]>| -> Vec<[f64; 8]> {
        rows.iter().map(|r| [r[0], r[1], r[2], r[3], 0.0, 0.0, 0.0, r[7]]).collect()
    };
    same(
        &heat(run(&powered, Inputs { drive: 0.05, ..powered.rest_inputs() }, none)),
        &heat(run(&powered, powered.rest_inputs(), Unknown { heat_w: 0.05, ..none })),
        1e-3,
        "heat",
    );
    let mut cooler = hanging.clone();
    cooler.material.austenite_temperature_c -= 2.0;
    cooler.material.martensite_temperature_c -= 2.0;
    same(
        &run(&cooler, inputs, none)[50..],
        &run(&hanging, inputs, Unknown { driving_k: 2.0, ..none })[50..],
        2e-3,
        "driving",
    );
    let pulled = Inputs { external_n: 0.2, ..inputs };
    let settled = 100;
    same(
        &run(&hanging, pulled, none)[settled..],
        &run(&hanging, inputs, Unknown { load_n: 0.2, ..none })[settled..],
        1e-3,
        "load",
    );
    let mut resistive = powered.clone();
    for rho in [
        &mut resistive.material.austenite_resistivity_ohm_m,
        &mut resistive.material.martensite_resistivity_ohm_m,
        &mut resistive.material.austenite_resistivity_slope_ohm_m_per_k,
        &mut resistive.material.martensite_resistivity_slope_ohm_m_per_k,
    ] {
        *rho *= 1.05;
    }
    same(
        &run(&resistive, powered.rest_inputs(), none),
        &run(&powered, powered.rest_inputs(), Unknown { resistivity: 0.05, ..none }),
        1e-6,
        "resistivity",
    );
    let strained = run(&powered, powered.rest_inputs(), Unknown { strain: 1e-3, ..none });
    let plain = run(&powered, powered.rest_inputs(), none);
    for (strained, plain) in strained[settled..].iter().zip(&plain[settled..]) {
        assert!((strained[2] - plain[2] - 1e-3 * 0.16).abs() < 1e-7, "{strained:?} {plain:?}");
    }
}

/// Closed forms that say what a parameter or a mechanism says do what that does.
#[test]
fn closed_forms_do_what_their_mechanism_does() {
    let model = hanging();
    let (m, g) = (&model.material, &model.geometry);
    let mut windy = model.clone();
    windy.material.convection_w_per_m2_k += 0.1 / 60.0 / g.surface_m2();
    let mut steep = model.clone();
    steep.material.stress_shift_k_per_pa = m.stress_shift_k_per_pa - 3.0 / 1e8;
    let mut resistive = model.clone();
    resistive.material.martensite_resistivity_ohm_m *= 1.1;
    resistive.material.martensite_resistivity_slope_ohm_m_per_k *= 1.1;
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } = model.load else {
        panic!("a hanging mass")
    };
    let stroke = m.transformation_strain * g.length_m;
    let mut sprung = model.clone();
    sprung.load =
        Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m: spring_n_per_m + 0.3 / stroke, preload_n };
    let mut damped = model.clone();
    damped.load =
        Load::SpringMassDamper { mass_kg, damping_n_s_per_m: damping_n_s_per_m + 20.0, spring_n_per_m, preload_n };
    let frame = 5e-4 / 1e8 * g.length_m / g.area_m2();
    let pairs: Vec<(WireModel, WireModel, f64, &[usize])> = vec![
        (windy, with(&model, &[("empirical.thermal", "tau", 0.1)]), 0.01, &[0, 1, 2, 3]),
        (steep, with(&model, &[("empirical.kinetic", "stress", 3.0)]), 0.02, &[0, 1, 2, 3]),
        (
            resistive,
            with(&model, &[("empirical.electrical", "martensite", 0.1), ("empirical.electrical", "mixed", 0.0)]),
            0.1,
            &[0, 1, 2, 3],
        ),
        (
            with(&model, &[("mechanical.two_way", "strain", 4e-3)]),
            with(&model, &[("empirical.mechanical", "martensite", 4e-3)]),
            0.02,
            &[2],
        ),
        (
            with(&model, &[("mechanical.frame_compliance", "compliance_m_per_n", frame)]),
            with(&model, &[("empirical.mechanical", "stress", 5e-4)]),
            // the wire's own strain and the frame's differ in resistance, hence in heat
            0.1,
            &[2],
        ),
        (sprung, with(&model, &[("empirical.load", "position", -0.3)]), 0.02, &[1, 2, 7]),
        (damped, with(&model, &[("empirical.load", "velocity", -0.2)]), 0.02, &[2]),
    ];
    let plain = hang(&model, 2e-3, 6.0);
    for (k, (known, form, allowed, looked_at)) in pairs.iter().enumerate() {
        let (known, form) = (hang(known, 2e-3, 6.0), hang(form, 2e-3, 6.0));
        let (size, error) = (apart(&known, &plain), apart(&known, &form));
        for &i in *looked_at {
            assert!(size[i] > 0.0 && error[i] < allowed * size[i], "pair {k} column {i}: {} of {}", error[i], size[i]);
        }
    }
    // sensors' errors
    let shown = hang(
        &with(&model, &[("empirical.position", "position", 5e-4), ("empirical.voltage", "martensite", 0.2)]),
        2e-3,
        6.0,
    );
    for (shown, plain) in shown.iter().zip(&plain) {
        assert!((shown[2] - plain[2] * (1.0 + 5e-4 / stroke)).abs() < 1e-9);
        assert!((shown[5] - plain[5] - plain[6] * 0.2 * plain[1]).abs() < 1e-9);
    }
}

/// A draught that is set is the same as a wire with so much more convection, and one that ends is gone.
#[test]
fn a_draught_that_is_set_is_more_convection() {
    let calm = hanging();
    let mut windy = calm.clone();
    windy.material.convection_w_per_m2_k *= 1.5;
    let run = |model: &WireModel, gain: f64| {
        let mut wire = Wire::new(model).expect("a valid model");
        wire.set_draught(gain);
        for _ in 0..3000 {
            wire.step(&Inputs { drive: 0.3, ..model.rest_inputs() }, 1e-3);
        }
        wire
    };
    let (set, built, mut still) = (run(&calm, 0.5), run(&windy, 0.0), run(&calm, 0.0));
    assert!((set.temperature_c() - built.temperature_c()).abs() < 1e-6);
    assert!((set.temperature_c() - still.temperature_c()).abs() > 5.0);
    let mut over = set;
    over.set_draught(0.0);
    for wire in [&mut over, &mut still] {
        for _ in 0..20_000 {
            wire.step(&Inputs { drive: 0.3, ..calm.rest_inputs() }, 1e-3);
        }
    }
    assert!((over.temperature_c() - still.temperature_c()).abs() < 0.5, "the same air, the same balance");
    assert!(over.energy().residual_j().abs() < 1e-9);
}
