//! An unknown wire: its parameters are found, and the fitted rig predicts recordings it was not fitted to.

use sinew_diagnosis::Settings;
use sinew_machine::characterise::{Place, Recorded, fit, fitted_rig, judge, tasks};
use sinew_machine::{Ending, SimulatedMachine, Watch, plan, record, run};
use sinew_rig::{Prior, Rig, default_priors, is_tolerance};

#[test]
fn an_unknown_wire_is_found_out() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/test-machine.toml");
    let mut rig = Rig::load(std::path::Path::new(path)).expect("the example");
    // here wire, machine and sensors are what the file says to the last digit: a diameter known to 1 % leaves moduli at 2 %
    for (key, _) in default_priors().into_iter().filter(|(key, _)| is_tolerance(key)) {
        rig.channels[0].priors.insert(key.to_string(), Prior::Absolute(0.0));
    }
    let wire = &rig.channels[0];
    let mut truth = wire.model.clone();
    let m = &mut truth.material;
    m.austenite_modulus_pa *= 0.8;
    m.martensite_modulus_pa *= 1.25;
    m.transformation_strain *= 0.85;
    m.austenite_temperature_c += 7.0;
    m.martensite_temperature_c -= 5.0;
    m.stress_shift_k_per_pa *= 1.2;
    m.heating_steepness_per_k *= 1.2;
    m.cooling_steepness_per_k *= 0.8;
    m.latent_heat_j_per_kg *= 0.75;
    m.convection_w_per_m2_k *= 1.15;
    m.austenite_resistivity_ohm_m *= 1.1;
    let recorded: Vec<Recorded> = tasks(&wire.model, &rig.machine)
        .into_iter()
        .enumerate()
        .map(|(number, task)| {
            let mut machine = SimulatedMachine::new(&truth, &rig.machine, number as u64).expect("a wire");
            let mut routine = plan::routine(task.kind, &wire.model, &rig.machine, &task.options);
            let mut watch = Watch::new(&wire.model, &wire.limits, &rig.machine);
            let ran = run::run(&mut machine, &mut routine, &mut watch, &mut |_, _, _| true);
            assert_eq!(ran.ending, Ending::Complete, "{}", task.name);
            let recording = record::recording(task.name, &ran.rows).expect("rows");
            Recorded { task, recording }
        })
        .collect();
    let settings = Settings { seed: 1, jobs: 0, thorough: false, progress: &|_, _| () };
    let identified = fit(&rig, 0, Place::Machine, &recorded, &settings).expect("a fit");
    let judged = judge(&rig, 0, Place::Machine, &identified, &recorded).expect("inputs");
    assert!(judged.chi_unseen <= 1.1, "{:?}", judged.recordings);
    assert!(judged.recordings.iter().filter(|met| !met.fitted).all(|met| met.chi_as_believed > 10.0));
    let fitted = fitted_rig(&rig, 0, &identified).channels[0].model.material;
    let t = &truth.material;
    for (name, found, really, share) in [
        ("E_A", fitted.austenite_modulus_pa, t.austenite_modulus_pa, 0.005),
        ("E_M", fitted.martensite_modulus_pa, t.martensite_modulus_pa, 0.005),
        ("ε_L", fitted.transformation_strain, t.transformation_strain, 0.003),
        ("A", fitted.austenite_temperature_c, t.austenite_temperature_c, 0.005),
        ("M", fitted.martensite_temperature_c, t.martensite_temperature_c, 0.005),
        ("1/α", fitted.stress_shift_k_per_pa, t.stress_shift_k_per_pa, 0.01),
        ("h", fitted.convection_w_per_m2_k, t.convection_w_per_m2_k, 0.005),
        ("ΔH", fitted.latent_heat_j_per_kg, t.latent_heat_j_per_kg, 0.02),
    ] {
        assert!((found / really - 1.0).abs() < share, "{name}: {found}, true {really}");
    }
}
