//! What one wire step costs: `cargo bench -p sinew-physics`.

use divan::{Bencher, black_box};
use sinew_physics::effects::{Definition, Entry, Law, OwnParameter, OwnRole, OwnState};
use sinew_physics::*;

fn main() {
    divan::main();
}

fn model() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: Some(Taps { l0_m: 0.0, ls_m: 0.15 }),
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96133 },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

/// Duty that sweeps slowly through the transformation and back.
fn sweep() -> Vec<f64> {
    (0..2500).map(|k| 0.15 + 0.12 * (f64::from(k) * std::f64::consts::TAU / 2500.0).sin()).collect()
}

fn run(bencher: Bencher, model: WireModel, dt: f64, duties: &[f64]) {
    let mut wire = Wire::new(&model).expect("a valid model");
    let inputs = model.rest_inputs();
    // past the start, so that the wire is in the middle of its transformation
    for _ in 0..2000 {
        wire.step(&Inputs { drive: 0.15, ..inputs }, 1e-3);
    }
    bencher.counter(divan::counter::ItemsCount::new(duties.len())).bench_local(|| {
        for &duty in duties {
            wire.step(&Inputs { drive: duty, ..inputs }, black_box(dt));
        }
        wire.position_m()
    });
}

/// Slowly changing duty at the steps of a driver and of a recording, in s.
#[divan::bench(args = [1e-4, 2e-4, 1e-3, 5e-3, 1e-2])]
fn slow_sweep(bencher: Bencher, dt: f64) {
    run(bencher, model(), dt, &sweep());
}

/// Sliding mode: full power and sensing pulse in turn, a reversal nearly every step.
#[divan::bench(args = [1e-4, 2e-4, 1e-3])]
fn switching(bencher: Bencher, dt: f64) {
    let duties: Vec<f64> = sweep().iter().enumerate().map(|(k, _)| if k % 5 == 0 { 0.7 } else { 0.02 }).collect();
    run(bencher, model(), dt, &duties);
}

/// The slow sweep at 1 ms with one effect on, by its id.
#[divan::bench(args = [
    "thermal.draught", "thermal.radiation", "thermal.end_conduction", "thermal.sheath", "electrical.r_phase", "kinetic.distributed",
    "kinetic.lag", "mechanical.friction", "mechanical.stress_dependent_strain", "sensing.delay", "empirical.thermal",
])]
fn with_effect(bencher: Bencher, id: &str) {
    let mut model = model();
    for parameter in effects::effect(id).expect("in the catalogue").parameters {
        parameter.set(&mut model, parameter.plausible.1);
    }
    run(bencher, model, 1e-3, &sweep());
}

/// The same term as `thermal.radiation`, and a force with a state, as laws that users write.
#[divan::bench(args = ["radiation", "relaxing_spring"])]
fn with_own(bencher: Bencher, name: &str) {
    let (enters, formula, unit, states) = match name {
        "radiation" => {
            let difference = "((temperature + 273.15 [K])^4 - (ambient + 273.15 [K])^4)";
            let formula = format!("-gain * 5.670374419e-8 [W/(m² K^4)] * surface * {difference}");
            (Entry::Heat, formula, "1", Vec::new())
        }
        _ => {
            let follows = OwnState {
                key: "follows".into(),
                unit: "mm".into(),
                start: 0.0,
                rate: "(position - follows) / 0.5 [s]".into(),
            };
            (Entry::Force, "-gain * (position - follows)".into(), "N/m", vec![follows])
        }
    };
    let gain = OwnParameter {
        key: "gain".into(),
        unit: unit.into(),
        role: OwnRole::Switch { null: 0.0 },
        range: (0.0, 1e3),
        plausible: (0.2, 0.9),
        about: "size".into(),
    };
    let (name, says) = (name.into(), "It is so".into());
    let law = Law::new(Definition { name, says, enters, formula, parameters: vec![gain], states }).expect("a law");
    let mut model = model();
    effects::row_of(law).parameters[0].set(&mut model, 0.9);
    run(bencher, model, 1e-3, &sweep());
}
