//! Whole diagnoses of short recordings whose truth is known: nothing missing, an effect, two threads or one. The
//! recordings are made with the project's own physics; cases made by another simulator are the business of `proof/`.

use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};
use rand_distr::StandardNormal;
use sinew_diagnosis::{Grade, LooksLike, Outcome, Settings, Verdict, diagnose, identify};
use sinew_physics::{Inputs, Wire};
use sinew_recording::{Column, Recording};
use sinew_rig::Rig;

const RIG: &str = r#"
[rig]
name = "bench"
rate_hz = 50.0
ambient_c = 25.0
[[channel]]
name = "wire"
[channel.wire]
diameter_mm = 0.125
length_mm = 160.0
[channel.drive]
supply_v = 6.0
shunt_ohm = 0.1
[channel.load]
mass_kg = 0.13
damping_n_s_per_m = 30.0
spring_n_per_m = 150.0
preload_n = 2.6
"#;

/// Measured columns and their noise, RMS.
const SENSORS: [(Column, f64); 4] =
    [(Column::CurrentA, 4e-4), (Column::V3V, 1.5e-3), (Column::ForceN, 3e-3), (Column::PositionM, 1.5e-5)];

/// 40 s of stairs and ramps at 50 Hz.
fn duty(t: f64) -> f64 {
    if t < 20.0 {
        [0.02, 0.25, 0.12, 0.3, 0.05, 0.2, 0.02, 0.28][(t / 2.5) as usize % 8]
    } else {
        let phase = ((t - 20.0) / 8.0).fract();
        0.02 + 0.28 * (1.0 - (2.0 * phase - 1.0).abs())
    }
}

/// A recording of the wire as `truth` has it.
fn record(truth: &Rig, seed: u64) -> Recording {
    record_beside(truth, seed, |_| 0.0, 1)
}

/// A recording of the wire as `truth` has it, with a force on its load that depends on where that is, and follows it so many
/// times a row.
fn record_beside(truth: &Rig, seed: u64, force_n: impl Fn(f64) -> f64, follows: u32) -> Recording {
    let model = &truth.channels[0].model;
    let mut wire = Wire::new(model).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let rows = 2000;
    let time: Vec<f64> = (0..rows).map(|i| f64::from(i) * 0.02).collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); SENSORS.len()];
    for t in &time {
        for _ in 0..follows {
            let external_n = force_n(wire.position_m());
            wire.step(&Inputs { drive: duty(*t), external_n, ..model.rest_inputs() }, 0.02 / f64::from(follows));
        }
        let seen = wire.outputs();
        for ((column, noise), values) in SENSORS.iter().zip(&mut columns) {
            let e: f64 = rng.sample(StandardNormal);
            values.push(column.of_outputs(&seen).unwrap() + noise * e);
        }
    }
    let mut recording = Recording::new("bench", time.clone()).unwrap();
    recording.set(Column::Duty, time.iter().map(|t| duty(*t)).collect()).unwrap();
    for ((column, _), values) in SENSORS.iter().zip(columns) {
        recording.set(*column, values).unwrap();
    }
    recording
}

fn believed() -> Rig {
    Rig::parse(RIG, "bench.toml").unwrap()
}

/// The wire as it is: other parameters than believed, within their priors.
fn real() -> Rig {
    let mut rig = believed();
    for (key, factor) in [
        ("convection_w_per_m2_k", 1.15),
        ("austenite_resistivity_uohm_cm", 0.95),
        ("transformation_strain", 1.08),
        ("martensite_modulus_gpa", 0.92),
        ("latent_heat_j_per_kg", 0.85),
    ] {
        let value = rig.parameter(0, key).unwrap();
        rig.set_parameter(0, key, value * factor).unwrap();
    }
    rig
}

fn settings(jobs: usize) -> Settings<'static> {
    Settings { seed: 7, jobs, thorough: false, progress: &|_, _| () }
}

fn answer(recording: &Recording, jobs: usize) -> Outcome {
    diagnose(&believed(), 0, std::slice::from_ref(recording), &[], &settings(jobs)).unwrap()
}

#[test]
fn a_rig_file_that_is_right_agrees() {
    let outcome = answer(&record(&believed(), 1), 0);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Agrees, "{}", outcome.diagnosis.summary);
    assert_eq!(outcome.improved, believed());
}

#[test]
fn parameters_that_are_off_are_no_missing_physics_and_are_found() {
    let recording = record(&real(), 2);
    let outcome = answer(&recording, 0);
    assert_eq!(outcome.diagnosis.verdict, Verdict::ParametersOff, "{}", outcome.diagnosis.summary);
    assert!(outcome.diagnosis.effects.is_empty());
    assert!(outcome.diagnosis.left.chi < 1.05, "{}", outcome.diagnosis.left.chi);
    let identified = identify(&believed(), 0, &[recording], None, &settings(0)).unwrap();
    let mut outside = 0;
    for (key, fitted) in &identified.parameters {
        let truth = real().parameter(0, key).unwrap();
        outside += usize::from(truth < fitted.low || truth > fitted.high);
        // no further off than twice what the 90 % interval leaves open
        let (value, low, high) = (fitted.value, fitted.low, fitted.high);
        assert!((value - truth).abs() < high - low, "{key}: {value} ({low} to {high}) instead of {truth}");
    }
    // 90 % intervals of 17 parameters
    assert!(outside <= 5, "{outside} of {}", identified.parameters.len());
}

/// The same through a converter that rounds to steps of so many times each sensor's noise.
fn rounded(recording: &Recording, steps: f64) -> Recording {
    let mut rounded = recording.clone();
    for (column, noise) in SENSORS {
        let step = steps * noise;
        let values = recording.get(column).unwrap().iter().map(|value| (value / step).round() * step).collect();
        rounded.set(column, values).unwrap();
    }
    rounded
}

#[test]
fn what_a_coarse_converter_rounds_off_is_no_missing_physics() {
    for (seed, steps) in [(11, 4.0), (12, 8.0), (13, 8.0), (14, 16.0), (15, 16.0), (16, 30.0)] {
        let found = answer(&rounded(&record(&real(), seed), steps), 2).diagnosis;
        assert!(
            matches!(found.verdict, Verdict::ParametersOff | Verdict::Agrees),
            "steps of {steps} times the noise: {:?}, {:?}",
            found.verdict,
            found.remains
        );
    }
}

#[test]
fn friction_is_named_and_sized_whatever_the_number_of_threads() {
    let mut truth = real();
    truth.set_effect(0, "mechanical.friction", "coulomb_n", 0.1).unwrap();
    let recording = record(&truth, 3);
    let outcome = answer(&recording, 2);
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::PhysicsMissing, "{}", diagnosis.summary);
    assert_eq!(diagnosis.effects[0].id, "mechanical.friction");
    assert_eq!(diagnosis.location.equation.as_deref(), Some("mechanical"));
    let size = &diagnosis.effects[0].parameters["coulomb_n"];
    assert!((size.value - 0.1).abs() < 0.005 && size.low < size.value && size.value < size.high, "{size:?}");
    assert!(diagnosis.left.chi > 2.0 && diagnosis.left.chi_improved < 1.1, "{:?}", diagnosis.left);
    assert!(diagnosis.effects[0].evidence.p_value <= 0.01);
    let coulomb = outcome.improved.channels[0].model.effects.mechanical.friction.coulomb_n;
    assert!((coulomb - 0.1).abs() < 0.005);
    let again = answer(&recording, 1);
    assert_eq!(diagnosis, &again.diagnosis);
    assert_eq!(outcome.improved, again.improved);
}

/// Two recordings of one wire say the same in either order.
#[test]
fn the_order_of_recordings_changes_no_answer() {
    let mut truth = real();
    truth.set_effect(0, "mechanical.friction", "coulomb_n", 0.08).unwrap();
    let [a, b] = [record(&truth, 21), later(&record(&truth, 22), 500.0)];
    let of = |recordings: &[Recording]| diagnose(&believed(), 0, recordings, &[], &settings(0)).unwrap().diagnosis;
    let (one, other) = (of(&[a.clone(), b.clone()]), of(&[b, a]));
    for diagnosis in [&one, &other] {
        assert_eq!(diagnosis.effects[0].id, "mechanical.friction", "{}", diagnosis.summary);
        let size = &diagnosis.effects[0].parameters["coulomb_n"];
        assert!((size.value - 0.08).abs() < 0.004, "{size:?}");
    }
    assert!((one.effects[0].share - other.effects[0].share).abs() < 0.1);
    assert!((one.left.chi_improved / other.left.chi_improved - 1.0).abs() < 0.05);
}

/// What a workshop's tools leave is no missing physics, and one constant that is further off is said.
#[test]
fn tolerances_are_no_finding_and_what_is_beyond_them_is() {
    let off = |factors: &[(&str, f64)]| {
        let mut rig = real();
        for (key, factor) in factors {
            let value = rig.parameter(0, key).unwrap();
            rig.set_parameter(0, key, value * factor).unwrap();
        }
        answer(&record(&rig, 23), 0).diagnosis
    };
    let within = [("length_mm", 1.004), ("mass_kg", 0.985), ("spring_n_per_m", 1.03), ("preload_n", 1.012)];
    let diagnosis = off(&[&within[..], &[("shunt_ohm", 0.98), ("supply_v", 1.003)]].concat());
    assert_eq!(diagnosis.verdict, Verdict::ParametersOff, "{}", diagnosis.summary);
    assert!(diagnosis.beyond_tolerance.is_empty(), "{:?}", diagnosis.beyond_tolerance);
    assert!(diagnosis.left.chi_improved < 1.06, "{}", diagnosis.left.chi_improved);
    assert_eq!(diagnosis.remains.looks_like, LooksLike::Noise, "{:?}", diagnosis.remains);
    let diagnosis = off(&[("spring_n_per_m", 1.3)]);
    assert_eq!(diagnosis.verdict, Verdict::ParametersOff, "{}", diagnosis.summary);
    assert_eq!(diagnosis.beyond_tolerance[0].key, "spring_n_per_m", "{:?}", diagnosis.beyond_tolerance);
}

/// A position that counts from anywhere, of which the rig file says that it counts from L₀: whatever the verdict, what is left
/// is said first, and what to do about it.
#[test]
fn what_is_not_explained_is_not_said_to_be() {
    let mut recording = record(&real(), 24);
    let moved: Vec<f64> = recording.get(Column::PositionM).unwrap().iter().map(|v| v - 0.006).collect();
    recording.set(Column::PositionM, moved).unwrap();
    let diagnosis = answer(&recording, 0).diagnosis;
    assert!(diagnosis.remains.chi > 10.0 && !diagnosis.is_explained(), "{}", diagnosis.summary);
    assert!(!diagnosis.summary.contains("No physics is missing"), "{}", diagnosis.summary);
    if diagnosis.verdict.is_complete() {
        assert!(diagnosis.next_experiment.contains("position_zero"), "{}", diagnosis.next_experiment);
    }
}

/// What no effect of the catalogue is gets no name of one, but its equation: a load that runs into rubber, and an encoder
/// whose marks are uneven.
#[test]
fn what_is_outside_the_catalogue_is_said_to_be_and_where() {
    let free = record(&real(), 24);
    let (short, long) = free
        .get(Column::PositionM)
        .unwrap()
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(short, long), x| (x.min(short), x.max(long)));
    let touches = 0.5 * (short + long);
    let rubber = record_beside(&real(), 24, |x| 800.0 * (touches - x).max(0.0), 20);
    let mut uneven = record(&real(), 25);
    let position: Vec<f64> = uneven.get(Column::PositionM).unwrap().to_vec();
    let marks = |x: &f64| x + 1.5e-4 * (std::f64::consts::TAU * x / 1e-3).sin();
    uneven.set(Column::PositionM, position.iter().map(marks).collect()).unwrap();
    for (recording, equation) in [(rubber, "mechanical"), (uneven, "sensing")] {
        let diagnosis = answer(&recording, 0).diagnosis;
        assert_eq!(diagnosis.verdict, Verdict::UnknownPhysics, "{}", diagnosis.summary);
        assert_eq!(diagnosis.location.equation.as_deref(), Some(equation), "{}", diagnosis.summary);
        assert!(diagnosis.effects.iter().all(|e| e.grade == Grade::Suspected), "{:?}", diagnosis.effects);
        assert_eq!(diagnosis.remains.looks_like, LooksLike::MissingMechanism, "{:?}", diagnosis.remains);
    }
}

/// The same rows at times `by_s` later.
fn later(recording: &Recording, by_s: f64) -> Recording {
    let times = recording.time_s().iter().map(|t| t + by_s).collect();
    let mut other = Recording::new("later", times).unwrap();
    for (column, values) in recording.columns() {
        other.set(column, values.to_vec()).unwrap();
    }
    other
}

/// A recording cut out of a longer one keeps its clock; an event in it is found all the same, and said in that clock.
#[test]
fn a_draught_is_found_whenever_the_clock_starts() {
    let mut truth = real();
    for (key, value) in [("gain", 0.5), ("start_s", 12.0), ("end_s", 24.0)] {
        truth.set_effect(0, "thermal.draught", key, value).unwrap();
    }
    let outcome = answer(&later(&record(&truth, 4), 100.0), 0);
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.effects.first().map(|e| e.id.as_str()), Some("thermal.draught"), "{}", diagnosis.summary);
    let gain = diagnosis.effects[0].parameters["gain"].value;
    assert!((gain - 0.5).abs() < 0.03, "{gain}");
    let window = &diagnosis.location.windows[0];
    assert!((window.start_s - 112.0).abs() < 0.5 && (window.end_s - 124.0).abs() < 0.5, "{window:?}");
    assert!(window.share > 0.3, "{window:?}");
}

/// A recording that is kept back as a whole judges, and the report shows it at every stage.
#[test]
fn a_recording_that_is_kept_back_judges_what_was_found_on_another() {
    let mut truth = real();
    truth.set_effect(0, "mechanical.friction", "coulomb_n", 0.15).unwrap();
    let (fitted, held) = (record(&truth, 10), record(&truth, 11));
    let outcome = diagnose(&believed(), 0, &[fitted], &[held], &settings(0)).unwrap();
    let diagnosis = &outcome.diagnosis;
    assert_eq!(diagnosis.effects.first().map(|e| e.id.as_str()), Some("mechanical.friction"), "{}", diagnosis.summary);
    assert_eq!(diagnosis.effects[0].grade, Grade::ConfirmedOnAnotherProgramme);
    let left = &diagnosis.left;
    assert!(left.chi_as_given > left.chi && left.chi > 1.5 && (0.9..1.1).contains(&left.chi_improved), "{left:?}");
    let shown = &outcome.figures.recordings[1];
    assert!(shown.time_s.len() > 100 && shown.kept_back.len() == 1, "{}", shown.kept_back.len());
    for sensor in &shown.sensors {
        for stage in [&sensor.as_given, &sensor.recalibrated, &sensor.improved] {
            assert!(stage.len() == shown.time_s.len() && stage.iter().all(|v| v.is_finite()), "{:?}", sensor.column);
        }
    }
    assert_eq!(outcome.next_programme.as_ref().map(|programme| programme.len()), Some(3000));
}

/// What is left out of one recording says nothing of the sensor's noise in another.
#[test]
fn a_dead_sensor_in_one_recording_spoils_no_other() {
    let mut dead = record(&real(), 5);
    dead.set(Column::PositionM, vec![0.004; dead.len()]).unwrap();
    let recordings = [record(&real(), 6), dead];
    let identified = identify(&believed(), 0, &recordings, None, &settings(0)).unwrap();
    let noise = identified.noise["position_m"];
    assert!((1e-5..2.5e-5).contains(&noise), "{noise}");
    assert!(identified.fit.recalibrated["position_m"].chi < 1.1, "{:?}", identified.fit.recalibrated);
}

/// Without anything to judge by there is no verdict.
#[test]
fn a_held_out_recording_must_measure_something_that_was_fitted() {
    let (mut fitted, mut held) = (record(&real(), 7), record(&real(), 8));
    for column in [Column::CurrentA, Column::V3V] {
        fitted.remove(column);
        held.remove(column);
    }
    fitted.remove(Column::ForceN);
    held.remove(Column::PositionM);
    let error = diagnose(&believed(), 0, &[fitted.clone()], &[held], &settings(0)).unwrap_err();
    assert!(error.is_bad_input() && error.to_string().contains("0 to judge"), "{error}");
    let error = diagnose(&believed(), 3, &[fitted], &[], &settings(0)).unwrap_err();
    assert!(error.to_string().contains("channel #4"), "{error}");
    assert!(diagnose(&believed(), 0, &[], &[], &settings(0)).is_err());
}

/// An effect that the rig file has already is refitted where it has a prior, as any parameter.
#[test]
fn numbers_of_effects_take_priors() {
    let mut truth = real();
    truth.set_effect(0, "mechanical.friction", "coulomb_n", 0.1).unwrap();
    let text = format!(
        "{RIG}\n[channel.effects.\"mechanical.friction\"]\ncoulomb_n = 0.06\n\n\
         [channel.priors]\n\"mechanical.friction.coulomb_n\" = 0.05\n"
    );
    let believed = Rig::parse(&text, "bench.toml").unwrap();
    let identified = identify(&believed, 0, &[record(&truth, 9)], None, &settings(0)).unwrap();
    let coulomb = &identified.parameters["mechanical.friction.coulomb_n"];
    assert!((coulomb.value - 0.1).abs() < 0.005 && coulomb.unit == "N", "{coulomb:?}");
}
