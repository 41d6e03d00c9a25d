//! Unknown wires, one after the other: parameters 10 to 30 % off the rig file's, either way, drawn by a
//! seed; each is characterised, and recordings not fitted are predicted. Prints a row for each wire.
//!
//! `cargo run --release -p sinew-machine --example wires`

use std::path::Path;
use std::time::Instant;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use sinew_diagnosis::Settings;
use sinew_machine::characterise::{Place, Recorded, fit, judge, tasks};
use sinew_machine::{SimulatedMachine, Watch, plan, record, run};
use sinew_physics::Material;
use sinew_rig::Rig;

/// How many wires.
const WIRES: u64 = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/test-machine.toml");
    let rig = Rig::load(Path::new(path))?;
    let wire = &rig.channels[0];
    println!(
        "wire  chi as believed  chi fitted  chi unseen  E_A, %  E_M, %  A, K  M, K  h, %  ΔH, %  recorded, s  fit, s"
    );
    for seed in 1..=WIRES {
        let mut truth = wire.model.clone();
        hide(&mut truth.material, seed);
        let mut recorded = Vec::new();
        for (number, task) in tasks(&wire.model, &rig.machine).into_iter().enumerate() {
            let mut machine = SimulatedMachine::new(&truth, &rig.machine, 100 * seed + number as u64)?;
            let mut routine = plan::routine(task.kind, &wire.model, &rig.machine, &task.options);
            let mut watch = Watch::new(&wire.model, &wire.limits, &rig.machine);
            let ran = run::run(&mut machine, &mut routine, &mut watch, &mut |_, _, _| true);
            let recording = record::recording(task.name, &ran.rows)?;
            recorded.push(Recorded { task, recording });
        }
        let started = Instant::now();
        let settings = Settings { seed: 1, jobs: 0, thorough: false, progress: &|_, _| () };
        let identified = fit(&rig, 0, Place::Machine, &recorded, &settings)?;
        let took_s = started.elapsed().as_secs_f64();
        let judged = judge(&rig, 0, Place::Machine, &identified, &recorded)?;
        let of = |fitted: bool, believed: bool| {
            let met = judged.recordings.iter().filter(move |met| met.fitted == fitted);
            met.map(|met| if believed { met.chi_as_believed } else { met.chi }).fold(0.0, f64::max)
        };
        let seconds: f64 = judged.recordings.iter().map(|met| met.seconds).sum();
        let (found, really) = (identified.rig.channels[0].model.material, truth.material);
        let off = |of: fn(&Material) -> f64| 100.0 * (of(&found) / of(&really) - 1.0);
        let kelvins = |of: fn(&Material) -> f64| of(&found) - of(&really);
        println!(
            "{seed:>4}  {:>15.0}  {:>10.3}  {:>10.3}  {:>+6.2}  {:>+6.2}  {:>+4.2}  {:>+4.2}  {:>+5.2}  {:>+5.2}  {seconds:>11.0}  {took_s:>6.1}",
            of(false, true),
            of(true, false),
            judged.chi_unseen,
            off(|m| m.austenite_modulus_pa),
            off(|m| m.martensite_modulus_pa),
            kelvins(|m| m.austenite_temperature_c),
            kelvins(|m| m.martensite_temperature_c),
            off(|m| m.convection_w_per_m2_k),
            off(|m| m.latent_heat_j_per_kg),
        );
    }
    Ok(())
}

/// Moves every parameter by 10 to 30 % either way; transformation temperatures by as much of their distance from the room,
/// resistivities by half of it, the specific heat by a third, for nobody is that wrong about them.
fn hide(m: &mut Material, seed: u64) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut off = |share: f64| {
        let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
        1.0 + sign * share * (0.1 + 0.2 * random.random::<f64>())
    };
    m.austenite_modulus_pa *= off(1.0);
    m.martensite_modulus_pa *= off(1.0);
    m.transformation_strain *= off(1.0);
    m.stress_shift_k_per_pa *= off(1.0);
    m.heating_steepness_per_k *= off(1.0);
    m.cooling_steepness_per_k *= off(1.0);
    m.latent_heat_j_per_kg *= off(1.0);
    m.convection_w_per_m2_k *= off(1.0);
    m.austenite_resistivity_ohm_m *= off(0.5);
    m.martensite_resistivity_ohm_m *= off(0.5);
    m.specific_heat_j_per_kg_k *= off(0.33);
    // both by the same, so that the hysteresis keeps some width
    let shift = 68.0 * (off(0.4) - 1.0);
    m.austenite_temperature_c += shift;
    m.martensite_temperature_c += shift;
}
