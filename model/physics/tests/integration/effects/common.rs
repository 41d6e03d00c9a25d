//! The wire, the settings and the comparisons that all of these tests share.

use sinew_physics::effects::{Effect, Home, catalogue, effect};
use sinew_physics::*;

pub fn hanging() -> WireModel {
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

pub fn set(model: &mut WireModel, id: &str, key: &str, value: f64) {
    let row = effect(id).unwrap_or_else(|| panic!("{id} is in the catalogue"));
    let parameter = row.parameters.iter().find(|p| p.key == key).unwrap_or_else(|| panic!("{id} has {key}"));
    parameter.set(model, value);
}

pub fn with(model: &WireModel, values: &[(&str, &str, f64)]) -> WireModel {
    let mut model = model.clone();
    for (id, key, value) in values {
        set(&mut model, id, key, *value);
    }
    model
}

/// The rows beyond the reference model.
pub fn tables() -> impl Iterator<Item = &'static Effect> {
    catalogue().filter(|e| e.home == Home::Table)
}

/// The excitation of the comparisons: stairs of duty, up and down.
pub fn duty(t: f64) -> f64 {
    [0.05, 0.28, 0.14, 0.2, 0.12, 0.3, 0.02, 0.16][(t / 0.9) as usize % 8]
}

/// Columns every comparison looks at.
pub fn columns(o: &Outputs) -> [f64; 8] {
    [o.temperature_c, o.martensite, o.position_m, o.resistance_ohm, o.v2_v, o.v3_v, o.current_a, o.force_n]
}

pub fn hang(model: &WireModel, dt: f64, seconds: f64) -> Vec<[f64; 8]> {
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
pub fn apart(a: &[[f64; 8]], b: &[[f64; 8]]) -> [f64; 8] {
    std::array::from_fn(|i| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs()).fold(0.0, f64::max))
}

pub fn set_all(model: &WireModel, id: &'static str, values: &[(&'static str, f64)]) -> WireModel {
    let values: Vec<_> = values.iter().map(|(key, value)| (id, *key, *value)).collect();
    with(model, &values)
}
