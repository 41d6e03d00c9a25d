//! An unchanged replay is identical bit for bit, and a change shows as a difference.

use crate::common::{Memory, Turn, record, replay_all};
use sinew_driver::{Ask, Order, Program};
use sinew_ipc::{Fault, Mode};
use sinew_replay::{Difference, Replay};
use sinew_rig::{Algorithm, FaultKind, Rig};

fn order(channel: usize, ask: Ask, hold_s: f64) -> Order {
    let hold_ns = if hold_s.is_finite() { (hold_s * 1e9) as u64 } else { u64::MAX };
    Order { ticket: 0, channel, ask, hold_ns }
}

fn differences(replay: &Replay<Memory>, channel: usize) -> Vec<(&'static str, Difference)> {
    replay.comparison().of_channel(channel).map(|(field, difference)| (field.name, difference)).collect()
}

fn assert_identical(replay: &Replay<Memory>, channels: usize) {
    let found: Vec<_> = (0..channels).flat_map(|channel| differences(replay, channel)).collect();
    assert!(replay.comparison().is_identical() && replay.completeness().is_whole(), "{found:#?}");
}

/// The walking hexapod with everything that can happen to it.
fn eventful(rig: &Rig) -> Memory {
    let length_m = |stroke: f64| {
        let engine = sinew_driver::Engine::at_rest(rig, None).unwrap();
        engine.channels()[2].stroke_range().length_m(stroke)
    };
    let (short_m, long_m) = (length_m(0.6), length_m(0.2));
    record(rig, Some(Program::tripod(18, 1.5)), 4000, |cycle, faults| {
        let mut turn = Turn::default();
        match cycle {
            1 => turn.missed = 3,
            200 => turn.orders = vec![order(2, Ask::Length(short_m), 0.4), order(7, Ask::Duty(0.3), 0.25)],
            // while its lease lasts, the same setpoint again and another one
            400 => turn.orders = vec![order(7, Ask::Off, f64::INFINITY), order(2, Ask::Length(long_m), 0.7)],
            500 => turn.missed = 5,
            700 => assert!(faults.set(4, FaultKind::OpenWire)),
            750 => turn.orders = vec![order(4, Ask::Reset, 0.0), order(5, Ask::Off, 0.2)],
            // refused: latched
            760 => turn.orders = vec![order(4, Ask::Duty(0.1), 1.0)],
            900 => faults.clear_all(),
            910 => turn.orders = vec![order(4, Ask::Reset, 0.0)],
            1200 => assert!(faults.set(11, FaultKind::BackendError)),
            1203 => faults.clear_all(),
            1300 => turn.orders = vec![order(11, Ask::Reset, 0.0), order(12, Ask::Off, 0.05)],
            1500 => faults.set_backend_error(true),
            1504 => faults.set_backend_error(false),
            1600..1618 => turn.orders = vec![order(cycle as usize - 1600, Ask::Reset, 0.0)],
            2000 => assert!(faults.set(9, FaultKind::SupplyDip)),
            2100 => faults.clear_all(),
            2300 => turn.missed = 400,
            2400..2418 => turn.orders = vec![order(cycle as usize - 2400, Ask::Reset, 0.0)],
            _ if cycle % 97 == 0 => turn.missed = cycle % 5,
            _ => {}
        }
        turn
    })
}

#[test]
fn an_eventful_run_comes_out_bit_for_bit() {
    let rig = Rig::hexapod();
    let recording = eventful(&rig);
    let seen = |fault: Fault| recording.cycles.iter().any(|(_, states)| states.iter().any(|s| s.fault == fault.code()));
    for fault in [Fault::OpenWire, Fault::Backend, Fault::CycleOverrun] {
        assert!(seen(fault), "{fault:?} did not happen");
    }
    for mode in [Mode::Off, Mode::Length, Mode::Duty, Mode::Program, Mode::Fault] {
        assert!(recording.cycles.iter().any(|(_, states)| states.iter().any(|s| s.mode() == mode)), "{mode:?}");
    }
    assert_identical(&replay_all(&rig, &recording), 18);
}

#[test]
fn a_setpoint_whose_lease_runs_out_with_nobody_behind_it_lapses_again() {
    let rig = Rig::hexapod();
    let recording = record(&rig, None, 900, |cycle, _| {
        let orders = if cycle == 100 { vec![order(0, Ask::Duty(0.2), 0.123_456)] } else { Vec::new() };
        Turn { missed: 0, orders }
    });
    assert_eq!(recording.cycles.last().unwrap().1[0].mode(), Mode::Lapsed);
    assert_identical(&replay_all(&rig, &recording), 18);
    // and has lapsed where a recording begins only after that
    let later = Memory { cycles: std::sync::Arc::new(recording.cycles[600..].to_vec()) };
    let replayed = replay_all(&rig, &later);
    let found = differences(&replayed, 0);
    let is_proving = |cycles| cycles < 20;
    assert!(found.iter().all(|(field, found)| *field != "mode" || is_proving(found.cycles)), "{found:?}");
}

const JOINT: &str = "[rig]\nname = \"joint\"\n\n[[channel]]\nname = \"flexor\"\nwire = { diameter_mm = 0.05, length_mm = 160.0 }\n\
    taps = { ls_mm = 150.0 }\ndrive = { supply_v = 12.0, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\n[[channel]]\n\
    name = \"extensor\"\nwire = { diameter_mm = 0.05, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
    drive = { supply_v = 12.0, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\n[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\n\
    antagonist = \"extensor\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\n\n[simulation]\nseed = 11\n";

#[test]
fn a_joint_comes_out_bit_for_bit() {
    let rig = Rig::parse(JOINT, "joint.toml").unwrap_or_else(|e| panic!("{e}"));
    let engine = sinew_driver::Engine::at_rest(&rig, None).unwrap();
    let length_m = |channel: usize, stroke: f64| engine.channels()[channel].stroke_range().length_m(stroke);
    let area_m2 = rig.channels[0].model.geometry.area_m2();
    let recording = record(&rig, None, 9000, |cycle, faults| {
        let mut turn = Turn::default();
        match cycle {
            50 => turn.orders = vec![order(0, Ask::Length(length_m(0, 0.6)), 10.0)],
            1500 => turn.orders = vec![order(1, Ask::Length(length_m(1, 0.55)), 1.5)],
            2500 => turn.orders = vec![order(1, Ask::Tension(250e6 * area_m2), 4.0)],
            // both in one cycle: the order in which they were taken decides
            4000 => turn.orders = vec![order(1, Ask::Duty(0.05), 1.0), order(0, Ask::Length(length_m(0, 0.4)), 1.0)],
            4300 => turn.orders = vec![order(0, Ask::Length(length_m(0, 0.5)), 1.0), order(1, Ask::Duty(0.05), 0.5)],
            5500 => assert!(faults.set(1, FaultKind::OpenWire)),
            5600 => faults.clear_all(),
            5700 => turn.orders = vec![order(1, Ask::Reset, 0.0)],
            5800 => turn.orders = vec![order(0, Ask::Reset, 0.0)],
            6000 => turn.orders = vec![order(0, Ask::Length(length_m(0, 0.5)), 3.0)],
            _ if cycle % 501 == 0 => turn.missed = 2,
            _ => {}
        }
        turn
    });
    assert!(recording.cycles.iter().any(|(_, states)| states[0].fault == Fault::JointPartner.code()));
    assert!(recording.cycles.iter().any(|(_, states)| states[1].mode() == Mode::Force));
    assert_identical(&replay_all(&rig, &recording), 2);
}

#[test]
fn another_algorithm_shows_itself_in_what_it_decides_and_in_nothing_that_was_measured() {
    let rig = Rig::hexapod();
    let recording = record(&rig, Some(Program::tripod(18, 1.5)), 1500, |_, _| Turn::default());
    let mut other = rig.clone();
    other.channels[3].control.algorithm = Algorithm::Pid;
    let replayed = replay_all(&other, &recording);
    for channel in (0..18).filter(|channel| *channel != 3) {
        assert_eq!(differences(&replayed, channel), [], "channel {channel} is as it was");
    }
    let found = differences(&replayed, 3);
    let of = |name: &str| found.iter().find(|(field, _)| *field == name).map(|(_, difference)| *difference);
    let duty = of("duty").expect("another law has another duty");
    assert!(duty.max > 0.05 && duty.cycles > 500 && duty.rms <= duty.max, "{duty:?}");
    assert_eq!(of("target_m"), None);
    // What the wire was given is what was put out then.
    for name in ["measured_length_m", "resistance_ohm", "power_w", "temperature_c"] {
        assert_eq!(of(name), None, "{name}");
    }
    // what it decides first is what differs first
    assert!(found.iter().all(|(_, difference)| difference.first.cycle
        >= duty.first.cycle.min(of("surface").map_or(u64::MAX, |s| s.first.cycle))));
}

#[test]
fn another_rig_shows_itself_in_what_is_made_of_the_voltages() {
    let rig = Rig::hexapod();
    let recording = record(&rig, None, 300, |_, _| Turn::default());
    let mut other = rig.clone();
    let taps = other.channels[1].model.taps.as_mut().unwrap();
    taps.ls_m *= 1.001;
    let replayed = replay_all(&other, &recording);
    let found = differences(&replayed, 1);
    let length =
        found.iter().find(|(field, _)| *field == "measured_length_m").expect("lengths are measured by the taps").1;
    assert!((1e-5..1e-3).contains(&length.max), "{length:?}");
    assert_eq!(differences(&replayed, 0), []);
}

#[test]
fn a_recording_that_begins_in_the_middle_says_so_and_measures_the_same() {
    let rig = Rig::hexapod();
    let whole = eventful(&rig);
    let cut = Memory { cycles: std::sync::Arc::new(whole.cycles[250..].to_vec()) };
    let replayed = replay_all(&rig, &cut);
    let complete = replayed.completeness();
    assert_eq!((complete.first_cycle, complete.lost, complete.is_whole()), (251, 0, false));
    let mut unlike = 0;
    for channel in 0..18 {
        let found = differences(&replayed, channel);
        // What was in the heat account before the recording began is not known: a reset may be refused in one and not the other.
        if found.iter().any(|(field, _)| *field == "fault") {
            unlike += 1;
            continue;
        }
        for (field, difference) in found {
            let measured =
                ["measured_length_m", "resistance_ohm", "power_w", "health", "target_m", "order"].contains(&field);
            // three cycles until the duty of then is in force again, and one in which it came late
            assert!(!measured || difference.cycles <= 4, "channel {channel}: {field}: {difference:?}");
            assert!(field != "temperature_c" || difference.rms < 1.0, "channel {channel}: {difference:?}");
        }
    }
    assert!(unlike <= 2, "{unlike} channels");
}

#[test]
fn lost_cycles_are_counted_and_missed_ones_are_not() {
    let rig = Rig::hexapod();
    let whole = eventful(&rig);
    let mut cycles = whole.cycles.to_vec();
    cycles.drain(600..610);
    cycles.drain(1000..1001);
    let replayed = replay_all(&rig, &Memory { cycles: std::sync::Arc::new(cycles) });
    let complete = replayed.completeness();
    assert_eq!((complete.lost, complete.first_lost, complete.is_whole()), (11, Some(601), false));
    let first = (0..18).flat_map(|channel| differences(&replayed, channel)).map(|(_, d)| d.first.cycle).min();
    assert!(first.is_some_and(|cycle| cycle > 610), "{first:?}: up to there nothing was lost");
}

#[test]
fn a_rig_of_another_size_is_refused() {
    let rig = Rig::hexapod();
    let recording = record(&rig, None, 10, |_, _| Turn::default());
    let other = Rig::parse(JOINT, "joint.toml").unwrap();
    let error = Replay::new(&other, recording).expect_err("two channels for eighteen");
    assert_eq!(error.to_string(), "the recording has 18 channels, but the rig has 2");
}
