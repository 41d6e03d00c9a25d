//! A session's samples as rows of the standard columns: simulated with the same rig they differ by no
//! more than the converter's noise.

use std::fs::File;

use crate::common::{Memory, Turn, record};
use sinew_driver::{Ask, Order};
use sinew_physics::{Inputs, Wire};
use sinew_recorder::layout;
use sinew_recording::session::{About, Ended, Head, SessionWriter, WriteOptions};
use sinew_recording::{Column, Options, Recording, read};
use sinew_replay::encode;
use sinew_rig::Rig;

const RIG: &str = "[rig]\nname = \"bench\"\nrate_hz = 1000.0\n\n[[channel]]\nname = \"wire\"\n\
    wire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
    drive = { supply_v = 6.0, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\
    load = { mass_kg = 0.2, damping_n_s_per_m = 40.0, spring_n_per_m = 150.0, preload_n = 1.96133 }\n";

fn save(rig_toml: &str, recording: &Memory, path: &std::path::Path) {
    let rig = Rig::parse(rig_toml, "rig.toml").unwrap();
    let layout = layout(rig.channels.iter().map(|channel| channel.name.clone()).collect()).unwrap();
    let about = About {
        rig: rig.name.clone(),
        rate_hz: rig.rate_hz,
        software: "test".into(),
        kind: "driver".into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: recording.cycles[0].0.monotonic_ns,
        rig_toml: Some(rig_toml.into()),
        extra: Default::default(),
    };
    let mut writer =
        SessionWriter::create(File::create(path).unwrap(), &about, &layout, WriteOptions::new("test.mcap")).unwrap();
    let mut bytes = Vec::new();
    for (head, states) in recording.cycles.iter() {
        encode(states, &mut bytes);
        let head = Head { cycle: head.cycle, monotonic_ns: head.monotonic_ns, missed: head.missed };
        writer.cycle(&head, &bytes).unwrap();
    }
    writer.finish(Ended::Complete).unwrap();
}

/// Warm, cold, held still, off for a while, and with periods missed in between.
fn exercise(rig: &Rig) -> Memory {
    record(rig, None, 8000, |cycle, _| {
        let duty = [0.35, 0.05, 0.6, 0.02, 0.2, 0.45][(cycle / 700) as usize % 6];
        let ask = if (3000..3400).contains(&cycle) { Ask::Off } else { Ask::Duty(duty) };
        let orders = vec![Order { ticket: 0, channel: 0, ask, hold_ns: u64::MAX }];
        Turn {
            missed: if cycle % 211 == 0 { 1 + cycle % 3 } else { 0 },
            orders: if cycle > 20 && cycle % 100 == 0 { orders } else { Vec::new() },
        }
    })
}

/// Root of the mean squared difference to the model driven by the recording's own inputs, in standard deviations of the
/// converter, for each measured column. `shift` moves the inputs by so many rows, as a wrong idea of a row would.
fn chi(rig: &Rig, recording: &Recording, shift: isize) -> Vec<(Column, f64)> {
    let model = &rig.channels[0].model;
    let adc = &rig.channels[0].adc;
    let sigma = |noise: f64, range: f64| {
        let step = range / 2f64.powi(adc.bits as i32);
        (noise * noise + step * step / 12.0).sqrt()
    };
    let (volt, ampere) =
        (sigma(adc.voltage_noise_v, adc.voltage_range_v), sigma(adc.current_noise_a, adc.current_range_a));
    let columns = [(Column::CurrentA, ampere), (Column::V1V, volt), (Column::V2V, volt), (Column::V3V, volt)];
    let rows: Vec<(Inputs, f64)> = recording.inputs_for(model).unwrap().collect();
    let mut wire = Wire::with_inputs(model, &rows[0].0).unwrap();
    let mut sums = [(0.0, 0u32); 4];
    for row in 0..rows.len() {
        let from = row.saturating_add_signed(shift).min(rows.len() - 1);
        wire.step(&Inputs { drive: rows[from].0.drive, ..rows[row].0 }, rows[row].1);
        let outputs = wire.outputs();
        for ((column, sigma), (sum, count)) in columns.iter().zip(&mut sums) {
            let Some(measured) = recording.get(*column).map(|values| values[row]).filter(|v| v.is_finite()) else {
                continue;
            };
            *sum += ((measured - column.of_outputs(&outputs).unwrap()) / sigma).powi(2);
            *count += 1;
        }
    }
    columns.iter().zip(sums).map(|((column, _), (sum, count))| (*column, (sum / f64::from(count)).sqrt())).collect()
}

#[test]
fn the_true_rig_file_explains_a_session_to_the_noise() {
    let rig = Rig::parse(RIG, "rig.toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    save(RIG, &exercise(&rig), &path);
    let options = Options { model: Some(&rig.channels[0].model), ..Options::default() };
    let recording = read(&path, &options).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(recording.time_s()[0], 0.0);
    assert!(recording.len() == 7999, "{}: every cycle but the last begins a row", recording.len());
    for (column, chi) in chi(&rig, &recording, 0) {
        assert!((0.95..1.05).contains(&chi), "{}: {chi}", column.name());
    }
    let position = recording.get(Column::PositionM).unwrap();
    assert!(position.iter().all(|x| x.is_nan() || (0.0..0.01).contains(x)));
}

/// A converter that sees a thousand times more, and a duty that is another one every period: an input a single row off, or a
/// sample, would show.
#[test]
fn inputs_and_samples_stand_in_the_right_rows() {
    let text =
        RIG.to_string() + "adc = { bits = 24, voltage_noise_v = 2e-6, current_noise_a = 5e-7, supply_noise_v = 0.0 }\n";
    let rig = Rig::parse(&text, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    let recorded = record(&rig, None, 3000, |cycle, _| {
        let ask = Ask::Duty(0.02 + (cycle * cycle * 7919 % 1000) as f64 * 5e-4);
        let orders = vec![Order { ticket: 0, channel: 0, ask, hold_ns: u64::MAX }];
        Turn { missed: if cycle % 53 == 0 { 1 } else { 0 }, orders: if cycle > 20 { orders } else { Vec::new() } }
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    save(&text, &recorded, &path);
    let recording = read(&path, &Options { model: Some(&rig.channels[0].model), ..Options::default() }).unwrap();
    let worst = |shift| chi(&rig, &recording, shift).into_iter().map(|(_, chi)| chi).fold(0.0, f64::max);
    let right = worst(0);
    assert!(right < 2.0, "{right}");
    for shift in [-1, 1] {
        assert!(worst(shift) > 30.0 * right, "shifted by {shift}: {}, else {right}", worst(shift));
    }
}

#[test]
fn a_shared_input_is_reckoned_back_to_the_wire() {
    let text = RIG.to_string() + "adc = { circuit = \"shared\" }\n";
    let rig = Rig::parse(&text, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    save(&text, &exercise(&rig), &path);
    let recording = read(&path, &Options { model: Some(&rig.channels[0].model), ..Options::default() }).unwrap();
    assert!(recording.get(Column::V3V).is_none(), "not sampled");
    let model = &rig.channels[0].model;
    let mut worst = 0.0f64;
    for (row, simulated) in recording.simulated(model).unwrap().enumerate() {
        let (_, outputs) = simulated.unwrap();
        let (v2_v, seen) = (outputs.v2_v, recording.get(Column::V2V).unwrap()[row]);
        worst = worst.max((v2_v - seen).abs() * f64::from(u8::from(seen.is_finite())));
    }
    // without the correction it would be off by the shunt's and switch's 40 mV
    assert!(worst < 0.02, "{worst} V");
}

#[test]
fn where_a_recording_has_holes_the_row_says_so() {
    let rig = Rig::parse(RIG, "rig.toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let whole = exercise(&rig);
    let mut cycles = whole.cycles[99..600].to_vec();
    cycles.drain(200..250);
    save(RIG, &Memory { cycles: std::sync::Arc::new(cycles) }, &path);
    let recording = read(&path, &Options { model: Some(&rig.channels[0].model), ..Options::default() }).unwrap();
    // cycles 100..=299 and 350..=600, of which the first of each has an unknown duty and the last of all no sample
    let rows = recording.time_s().windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>();
    assert_eq!(recording.len(), 199 + 250 - 1);
    let long: Vec<f64> = rows.iter().copied().filter(|dt_s| *dt_s > 0.0045).collect();
    assert_eq!(long.len(), 1, "{long:?}: one gap, the duty before it held");
    assert!((long[0] - 0.053).abs() < 3e-3, "{long:?}: 51 periods and what was missed in them");
    let off = recording.get(Column::Duty).unwrap().iter().zip(recording.get(Column::V3V).unwrap());
    assert!(off.clone().all(|(duty, v3_v)| *duty > 0.0 || v3_v.is_nan()));
}
