//! The routines on the simulated machine: they report the wire's true parameters.

use std::sync::Arc;

use sinew_machine::analysis::{self, Finding};
use sinew_machine::hanging::{Disturbance, playable};
use sinew_machine::plan::{self, holding_power_w};
use sinew_machine::{
    Bounded, Ending, Options, Part, Programme, Ran, Routine, RoutineKind, SimulatedMachine, Watch, record, run,
};
use sinew_physics::WireModel;
use sinew_recording::{Column, Recording};
use sinew_rig::Rig;

fn rig() -> Rig {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/test-machine.toml");
    Rig::load(std::path::Path::new(path)).expect("the example")
}

fn options(rig: &Rig, kind: RoutineKind) -> Options {
    Options::default_for(kind, &rig.channels[0].model, &rig.machine)
}

/// Runs a routine until `until_s`.
fn run_until(rig: &Rig, truth: &WireModel, kind: RoutineKind, options: &Options, until_s: f64) -> (Ran, Routine) {
    let wire = &rig.channels[0];
    let mut machine = SimulatedMachine::new(truth, &rig.machine, 1).expect("a wire");
    let mut routine = plan::routine(kind, &wire.model, &rig.machine, options);
    let mut watch = Watch::new(&wire.model, &wire.limits, &rig.machine);
    let ran = run::run(&mut machine, &mut routine, &mut watch, &mut |row, _, _| row.time_s < until_s);
    (ran, routine)
}

fn findings(rig: &Rig, kind: RoutineKind, options: &Options) -> Vec<Finding> {
    let model = &rig.channels[0].model;
    let (ran, routine) = run_until(rig, model, kind, options, f64::INFINITY);
    assert_eq!(ran.ending, Ending::Complete);
    analysis::findings(&analysed(rig, kind, options, &ran, &routine))
}

/// What the analysis gets of a run.
fn analysed<'a>(
    rig: &'a Rig,
    kind: RoutineKind,
    options: &'a Options,
    ran: &'a Ran,
    routine: &'a Routine,
) -> analysis::Run<'a> {
    analysis::Run {
        kind,
        options,
        stages: routine.stages(),
        rows: &ran.rows,
        model: &rig.channels[0].model,
        spec: &rig.machine,
        at_rest: None,
    }
}

fn find<'a>(all: &'a [Finding], key: &str, of: usize) -> &'a Finding {
    all.iter().filter(|finding| finding.key == key).nth(of).expect(key)
}

/// Within three of its own standard uncertainties.
fn agrees(finding: &Finding, truth: f64) {
    let (value, sigma) = (finding.value.expect(finding.key), finding.sigma.expect(finding.key));
    assert!((value - truth).abs() <= 3.0 * sigma, "{} of {}: {value} ± {sigma}, true {truth}", finding.key, finding.of);
    assert!(sigma < 0.35 * truth.abs(), "{}: ± {sigma} says nothing of {truth}", finding.key);
}

/// The plateaus lie where the phase diagram has them: σ = (T − M)/α on loading and (T − A)/α on unloading.
#[test]
fn loops_show_the_moduli_and_the_phase_diagram() {
    let rig = rig();
    let model = &rig.channels[0].model;
    let m = &model.material;
    let mut o = options(&rig, RoutineKind::DirectStrain);
    let temperatures = [108.0, 120.0];
    o.heating = temperatures.map(|c| holding_power_w(model, c, model.ambient_c)).to_vec();
    o.strains = vec![0.0, 0.07];
    let all = findings(&rig, RoutineKind::DirectStrain, &o);
    for (level, celsius) in temperatures.into_iter().enumerate() {
        agrees(find(&all, "austenite_modulus_gpa", level), m.austenite_modulus_pa * 1e-9);
        agrees(find(&all, "martensite_modulus_gpa", level), m.martensite_modulus_pa * 1e-9);
        let plateau = |centre_c: f64| (celsius - centre_c) / m.stress_shift_k_per_pa * 1e-6;
        agrees(find(&all, "loading_plateau_mpa", level), plateau(m.martensite_temperature_c));
        agrees(find(&all, "unloading_plateau_mpa", level), plateau(m.austenite_temperature_c));
        let width = (m.austenite_temperature_c - m.martensite_temperature_c) / m.stress_shift_k_per_pa * 1e-6;
        agrees(find(&all, "hysteresis_width_mpa", level), width);
        // ∮σ dε of ε = C(ξ)σ + ε_L ξ between two plateaus: ε_L Δσ + ½ ΔC (σ₁² − σ₂²)
        let (up, down) = (plateau(m.martensite_temperature_c), plateau(m.austenite_temperature_c));
        let softer = 1e6 / m.martensite_modulus_pa - 1e6 / m.austenite_modulus_pa;
        let exact = m.transformation_strain * (up - down) + 0.5 * softer * (up * up - down * down);
        agrees(find(&all, "loop_energy_mj_per_m3", level), exact);
    }
    agrees(find(&all, "loading_slope_mpa_per_k", 0), 1e-6 / m.stress_shift_k_per_pa);
    agrees(find(&all, "martensite_temperature_c", 0), m.martensite_temperature_c);
    agrees(find(&all, "austenite_temperature_c", 0), m.austenite_temperature_c);
}

/// At little power the wire goes slack as martensite, at much it comes back (figure 85).
#[test]
fn power_turns_shape_memory_into_super_elasticity() {
    let rig = rig();
    let model = &rig.channels[0].model;
    let mut o = options(&rig, RoutineKind::DirectStrain);
    o.heating = [80.0, 115.0].map(|c| holding_power_w(model, c, model.ambient_c)).to_vec();
    o.strains = vec![0.0, 0.04];
    o.cycles = 1;
    let all = findings(&rig, RoutineKind::DirectStrain, &o);
    let residual = |level: usize| find(&all, "residual_strain_percent", level).value.expect("slack");
    assert!(residual(0) > 2.0 && residual(1) < 0.3, "{} and {} %", residual(0), residual(1));
    let unknown = find(&all, "unloading_plateau_mpa", 0);
    assert!(unknown.value.is_none() && unknown.how.contains("did not come back"), "{unknown:?}");
}

/// A wire that does not transform is a first-order lag in temperature: T = m c/(h A) is its bandwidth.
#[test]
fn a_wire_without_transformation_has_the_bandwidth_of_its_heat() {
    let mut rig = rig();
    let material = &mut rig.channels[0].model.material;
    // all of it austenite, whose expansion is what is seen
    material.austenite_temperature_c = -100.0;
    material.martensite_temperature_c = -120.0;
    material.thermoelastic_pa_per_k = 5e6;
    let model = &rig.channels[0].model;
    let mut o = options(&rig, RoutineKind::ConstantForceSweep);
    let exact = 1.0 / (std::f64::consts::TAU * plan::thermal_time_s(model));
    o.heating = vec![0.0, holding_power_w(model, 90.0, model.ambient_c)];
    o.frequencies_hz = plan::spaced(0.05 * exact, 4.0 * exact, 8);
    o.loads_n = vec![1.0];
    o.cycles = 1;
    let all = findings(&rig, RoutineKind::ConstantForceSweep, &o);
    agrees(find(&all, "open_loop_bandwidth_hz", 0), exact);
    // heat makes this wire longer, which counts as 180° from shortening: its 45° cannot be determined
    let stroke = find(&all, "stroke_mm", 0).value.expect("a stroke");
    let m = &model.material;
    let expected = m.thermoelastic_pa_per_k / m.austenite_modulus_pa * 65.0 * model.geometry.length_m * 1e3;
    assert!((stroke / expected - 1.0).abs() < 0.03, "{stroke} mm, expected {expected}");
}

/// A mass on a wire that is only a spring: with nothing driven it sinks as its own equation of motion says.
#[test]
fn the_hanging_mass_moves_as_a_mass_does() {
    let mut rig = rig();
    rig.machine.rate_hz = 1000.0;
    rig.machine.force_rate_hz = 1000.0;
    rig.machine.force_noise_n = 0.0;
    let material = &mut rig.channels[0].model.material;
    material.austenite_temperature_c = -100.0;
    material.martensite_temperature_c = -120.0;
    let model = rig.channels[0].model.clone();
    let stiffness = model.material.austenite_modulus_pa * model.geometry.area_m2() / model.geometry.length_m;
    let load_n = 1.0;
    let mass_kg = stiffness / (20.0f64 * 20.0);
    let mut o = options(&rig, RoutineKind::PositionRegulation);
    o.plant = playable(&model, load_n, 0.05, Some(mass_kg), &rig.machine);
    o.heating = vec![0.0, 0.0];
    o.strains = vec![0.01, 0.011];
    // let go, then pulled by a step: it rings at √(k/M), around an elongation more by F/k
    let pull_n = 0.4;
    o.disturbances = vec![Disturbance { start_s: o.hold_s, end_s: 1e9, pull_n }];
    let (ran, routine) = run_until(&rig, &model, RoutineKind::PositionRegulation, &o, f64::INFINITY);
    let is_held = |row: &&sinew_machine::Row| matches!(routine.stages()[row.directive.stage].part, Part::Hold { .. });
    let held: Vec<f64> = ran.rows.iter().filter(is_held).map(|row| row.reading.position_m).collect();
    let before = ran.rows.iter().rfind(|row| row.directive.disturbance_n == 0.0).expect("before").reading.position_m;
    let last = held[held.len() - 1];
    assert!(((last - before) * stiffness / pull_n - 1.0).abs() < 0.01, "{} m", last - before);
    let crossings: Vec<usize> = (1..2000).filter(|&i| (held[i - 1] - last) * (held[i] - last) < 0.0).collect();
    let half_s = (crossings[4] - crossings[0]) as f64 / 4.0 / rig.machine.rate_hz;
    let found = std::f64::consts::PI / half_s;
    assert!((found / 20.0 - 1.0).abs() < 0.03, "{found} rad/s");
}

/// The default law settles without a steady error, and follows faster than the wire follows the heater by itself.
#[test]
fn a_law_settles_and_is_faster_than_no_law() {
    let rig = rig();
    let run = |kind: RoutineKind| findings(&rig, kind, &options(&rig, kind));
    let held = run(RoutineKind::PositionRegulation);
    for of in 0..2 {
        let settling = find(&held, "settling_s", of).value.expect("it settles");
        assert!(settling < 3.0, "{settling} s");
        // 0.5 % of the way
        let error = find(&held, "steady_error_um", of).value.expect("a mean");
        assert!(error.abs() < 25.0, "{error} µm");
    }
    let bandwidth = |kind: RoutineKind, key: &str| find(&run(kind), key, 0).value.expect("a bandwidth");
    let open = bandwidth(RoutineKind::ConstantForceSweep, "open_loop_bandwidth_hz");
    let closed = bandwidth(RoutineKind::TrackingSweep, "closed_loop_bandwidth_hz");
    assert!(closed > 2.0 * open, "{closed} Hz closed, {open} Hz open");
}

#[test]
fn a_limit_ends_a_routine_at_zero_output_and_what_was_completed_counts() {
    let mut rig = rig();
    rig.machine.max_force_n = 2.0;
    let model = rig.channels[0].model.clone();
    let mut o = options(&rig, RoutineKind::DirectStrain);
    o.heating = vec![holding_power_w(&model, 80.0, 25.0), holding_power_w(&model, 120.0, 25.0)];
    o.strains = vec![0.0, 0.04];
    o.cycles = 1;
    let (ran, routine) = run_until(&rig, &model, RoutineKind::DirectStrain, &o, f64::INFINITY);
    let Ending::Breach(breach) = &ran.ending else { panic!("{:?}", ran.ending) };
    assert_eq!(breach.what, Bounded::Force);
    assert!(breach.to_string().contains("machine.max_force_n"), "{breach}");
    let loops = analysis::loops::cycles(&analysed(&rig, RoutineKind::DirectStrain, &o, &ran, &routine));
    assert_eq!(loops.len(), 1, "the second level was not completed");
}

#[test]
fn whoever_stops_a_routine_keeps_what_there_is() {
    let rig = rig();
    let o = options(&rig, RoutineKind::ConstantForceSweep);
    let (ran, _) = run_until(&rig, &rig.channels[0].model, RoutineKind::ConstantForceSweep, &o, 30.0);
    assert_eq!(ran.ending, Ending::Stopped);
    assert!((ran.rows.len() as f64 / rig.machine.rate_hz - 30.0).abs() < 0.1);
    assert!(record::recording("stopped", &ran.rows).is_ok());
}

/// A recording says what the model makes of it: the same wire answers to within the noise of the sensors.
#[test]
fn recordings_are_what_the_model_simulates() {
    let rig = rig();
    let mounted = record::rig_in_machine(&rig, 0);
    for kind in RoutineKind::OF_THESIS {
        let mut o = options(&rig, kind);
        o.frequencies_hz.truncate(2);
        o.cycles = 1;
        let (ran, _) = run_until(&rig, &rig.channels[0].model, kind, &o, 60.0);
        let recording = record::recording(kind.word(), &ran.rows).expect("rows");
        let foretold = sinew_machine::characterise::foretell(&mounted, 0, &recording).expect("inputs");
        let chi = foretold.chi;
        // a law that heats at 300 K/s moves the wire within a row
        let most = if kind.is_closed_loop() { 2.0 } else { 1.15 };
        assert!((0.9..most).contains(&chi), "{}: {chi} {:?}", kind.word(), foretold.misfits);
    }
}

/// The machine does what a file says, and what it records then is what a model makes of the file.
#[test]
fn a_programme_is_played_as_it_stands() {
    let rig = rig();
    let model = &rig.channels[0].model;
    let times: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
    let stairs: Vec<f64> = times.iter().map(|t| [0.02, 0.12, 0.06, 0.14][(t / 5.0) as usize % 4]).collect();
    let pulled: Vec<f64> = times.iter().map(|t| 4e-3 + 3e-3 * (0.4 * t).sin()).collect();
    let mut file = Recording::new("next.csv", times).expect("times");
    file.set(Column::CurrentA, stairs).expect("a current");
    file.set(Column::PositionM, pulled).expect("a course");
    let mut o = options(&rig, RoutineKind::Programme);
    o.programme = Some(Arc::new(Programme::of(&file).expect("a programme")));

    let all = findings(&rig, RoutineKind::Programme, &o);
    let value = |key: &str| find(&all, key, 0).value.expect(key);
    // the amplifier takes a moment at each of the seven steps
    assert!(value("heat_error") < 0.02 * 140.0, "{all:?}");
    assert!(value("elongation_error") < 0.02, "{all:?}");

    let (ran, _) = run_until(&rig, model, RoutineKind::Programme, &o, f64::INFINITY);
    assert!((ran.rows.len() as f64 / rig.machine.rate_hz - 40.0).abs() < 0.1, "{} rows", ran.rows.len());
    let recording = record::recording("programme", &ran.rows).expect("rows");
    let foretold = sinew_machine::characterise::foretell(&record::rig_in_machine(&rig, 0), 0, &recording);
    let chi = foretold.expect("inputs").chi;
    assert!((0.9..1.15).contains(&chi), "{chi}");
}

/// A new wire settles as its effects say: the routine ends when they are smaller than the tolerance, and says by how much it moved.
#[test]
fn a_new_wire_is_cycled_until_it_has_settled() {
    let rig = rig();
    let (model, n_0, first_k, first) = (&rig.channels[0].model, 6.0, -1.0, 4e-4);
    let mut o = options(&rig, RoutineKind::BreakIn);
    o.cycles = 60;
    let judge = |truth: &WireModel| {
        let (ran, routine) = run_until(&rig, truth, RoutineKind::BreakIn, &o, f64::INFINITY);
        assert_eq!(ran.ending, Ending::Complete);
        analysis::findings(&analysed(&rig, RoutineKind::BreakIn, &o, &ran, &routine))
    };
    let value = |all: &[Finding], key: &str| find(all, key, 0).value;

    let old = judge(model);
    assert!(value(&old, "cycles_to_settle").unwrap() <= 3.0 && value(&old, "cycles").unwrap() <= 6.0, "{old:?}");

    let mut new = model.clone();
    new.effects.kinetic.training_drift =
        sinew_physics::effects::TrainingDrift { kelvin_per_cycle: first_k, settles_after_cycles: n_0 };
    new.effects.mechanical.ratcheting =
        sinew_physics::effects::Ratcheting { strain_per_cycle: first, settles_after_cycles: n_0 };
    let all = judge(&new);
    // what a cycle moves is smaller than both tolerances from here on
    let smaller = |size: f64, within: f64| n_0 * (size / within).ln();
    let expected = smaller(first, o.tolerance.strain).max(smaller(-first_k, o.tolerance.kelvin));
    let took = value(&all, "cycles_to_settle").expect("it settles");
    assert!((took - expected).abs() < 4.0, "{took} cycles where {expected} are right");
    assert!(value(&all, "cycles").unwrap() < 30.0);
    // the first cycle has moved it already when half of its way is done
    let moved = |size: f64| size * n_0 * ((-0.3 / n_0).exp() - (-(took + 2.0) / n_0).exp());
    let cold = value(&all, "cold_moved_percent").unwrap();
    assert!((cold / (100.0 * moved(first)) - 1.0).abs() < 0.2, "{cold} %");
    let heating_k = value(&all, "heating_moved_k").unwrap();
    assert!((heating_k / moved(first_k) - 1.0).abs() < 0.3, "{heating_k} K");

    // one that never settles is cycled to the end, and that is said
    new.effects.kinetic.training_drift.settles_after_cycles = 0.0;
    o.cycles = 12;
    let (ran, routine) = run_until(&rig, &new, RoutineKind::BreakIn, &o, f64::INFINITY);
    let all = analysis::findings(&analysed(&rig, RoutineKind::BreakIn, &o, &ran, &routine));
    assert_eq!((value(&all, "cycles_to_settle"), value(&all, "cycles")), (None, Some(12.0)));
    assert!(find(&all, "cycles_to_settle", 0).how.contains("after 12 cycles"));
}
