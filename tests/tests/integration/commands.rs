//! Commands from other processes: taken, carried out and seen by everybody; or refused with the reason, changing nothing.

use sinew_ipc::{ALL_CHANNELS, ChannelState, Client, CommandKind, Error, Mode, Reason};
use sinew_tests::{Driver, Rig, SENSING_DUTY, wait_for, wait_until};
use std::time::Duration;

const LONG: Duration = Duration::from_secs(120);

/// Cycles whose mean length says whether a wire has settled: single measurements are as noisy as the converter makes them.
const WINDOW: usize = 250;

/// Waits until the channel's length, as this client sees it, is within 0.5 % of stroke of its target, in the mean of half a
/// second, and the driver says so too.
#[track_caller]
fn wait_until_settled(client: &Client, channel: usize, target_m: f64) {
    let info = client.channels()[channel];
    let stroke_m = info.cold_length_m - info.hot_length_m;
    let mut stream = client.stream().unwrap();
    // The first batch may have begun before the command.
    let from = client.latest().cycle;
    let mut lengths = Vec::new();
    let mut settled = 0;
    let mean_m = wait_for("the wire to settle", || {
        while let Some(cycle) = stream.next().unwrap() {
            if cycle.header.cycle < from {
                continue;
            }
            let state = &cycle.channels[channel];
            assert_eq!((state.fault(), state.mode()), (None, Mode::Length), "{state:?}");
            assert!((state.target_m - target_m).abs() < 1e-12, "{state:?}");
            lengths.push(state.length_m);
            settled += usize::from(state.flags & ChannelState::FLAG_SETTLED != 0);
            if lengths.len() == WINDOW {
                let mean_m = lengths.iter().sum::<f64>() / WINDOW as f64;
                if (mean_m - target_m).abs() < 0.005 * stroke_m && settled > WINDOW / 2 {
                    return Some(mean_m);
                }
                lengths.clear();
                settled = 0;
            }
        }
        None
    });
    println!("settled at {mean_m} m, asked for {target_m} m");
}

#[test]
fn a_command_is_taken_settles_and_is_seen_by_another_client() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, robot) = Driver::ready(&rig);
    let observer = rig.client();
    let left = robot.channels()[0];
    let cold_m = observer.latest().channels()[0].length_m;
    assert!((cold_m - left.cold_length_m).abs() < 1e-3, "{cold_m} m at rest, {} m expected", left.cold_length_m);

    let reply = robot.set_stroke("left", 0.4, LONG).unwrap();
    assert_eq!(reply.hold_s, 120.0);
    // What is acknowledged is in force: the very next look sees it.
    let seen = observer.latest().channels()[0];
    let target_m = left.length_at_stroke(0.4);
    assert_eq!(seen.mode(), Mode::Length);
    assert!((seen.target_m - target_m).abs() < 1e-12, "{seen:?}");
    assert!(seen.lease_s > 60.0 && seen.lease_s < 120.1, "{seen:?}");
    wait_until_settled(&observer, 0, target_m);
    let hot = observer.latest().channels()[0];
    assert!(hot.temperature_c > 50.0 && hot.martensite < 0.95, "{hot:?}");

    // And back, which takes cooling.
    let target_m = left.length_at_stroke(0.1);
    robot.set_length("left", target_m, LONG).unwrap();
    wait_until_settled(&observer, 0, target_m);

    // Nobody asked the other one for anything.
    let right = observer.latest().channels()[1];
    assert_eq!((right.mode(), right.fault(), right.duty), (Mode::Off, None, SENSING_DUTY), "{right:?}");
    assert!((right.length_m - cold_m).abs() < 2e-4 && right.target_m.is_nan(), "{right:?}");
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().unwrap().len(), 0, "{report:#}");
}

#[test]
fn every_kind_of_command_does_what_it_says() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, robot) = Driver::ready(&rig);
    let observer = rig.client();
    let left = || observer.latest().channels()[0];

    robot.set_duty("left", 0.1, LONG).unwrap();
    let state = left();
    assert_eq!((state.mode(), state.duty), (Mode::Duty, 0.1), "{state:?}");
    assert!(state.target_m.is_nan(), "{state:?}");
    wait_until("0.1 of duty to heat the wire", || left().temperature_c > 30.0);
    // 0.1 of V²/R over a period, to a few percent. A sample that was bad takes the heating away for a cycle, so not every one has it.
    wait_until("0.1 of the full power", || {
        let state = left();
        let current_a = 6.5 / (state.resistance_ohm + 0.12);
        let power_w = 0.1 * current_a * current_a * state.resistance_ohm;
        (state.power_w / power_w - 1.0).abs() < 0.05
    });

    // Against a spring, a force is a length: F = preload − K (L − L0).
    robot.set_force("left", 1.6, LONG).unwrap();
    let state = left();
    assert_eq!(state.mode(), Mode::Force);
    assert!((state.target_m - (0.160 + (2.4 - 1.6) / 150.0)).abs() < 1e-9, "{state:?}");

    robot.off("left").unwrap();
    assert_eq!((left().mode(), left().duty), (Mode::Off, SENSING_DUTY));

    robot.set_stroke("left", 0.2, LONG).unwrap();
    robot.set_stroke("right", 0.3, LONG).unwrap();
    assert!(observer.latest().channels().iter().all(|c| c.mode() == Mode::Length));
    robot.all_off().unwrap();
    assert!(observer.latest().channels().iter().all(|c| c.mode() == Mode::Off));
    // To reset what has no fault is no mistake.
    robot.reset("left").unwrap();

    // A lease nobody gave is the channel's own.
    assert_eq!(robot.set_stroke("left", 0.0, Duration::ZERO).unwrap().hold_s, 0.5);
    driver.stop();
}

#[test]
fn what_cannot_be_is_refused_and_the_setpoint_before_stays() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, robot) = Driver::ready(&rig);
    let info = robot.channels()[0];
    robot.set_stroke("left", 0.3, LONG).unwrap();
    let before = robot.latest().channels()[0].target_m;
    let commands = robot.loop_stats().refusals;
    let mut refused = 0;
    let mut reason = |channel: u32, kind: CommandKind, value: f64, hold: Duration| -> Reason {
        refused += 1;
        let error = robot.command(channel, kind, value, hold).expect_err("to be refused");
        assert!(error.is_bad_input(), "{error}");
        assert!(!error.message().is_empty() && !error.remedy().is_empty());
        let Error::Refused(refusal) = error else { panic!("{error}") };
        let state = robot.latest().channels()[0];
        assert_eq!((state.mode(), state.target_m, state.fault()), (Mode::Length, before, None), "after {refusal:?}");
        refusal.reason
    };
    use CommandKind::{Duty, Force, Length, Off, Reset, Stroke};
    for kind in [Length, Stroke, Duty, Force] {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -f64::NAN] {
            assert_eq!(reason(0, kind, value, LONG), Reason::NotFinite, "{kind:?} {value}");
        }
        for value in [1e300, -1e300, -1.0] {
            let Reason::OutOfRange { low, high } = reason(0, kind, value, LONG) else { panic!("{kind:?} {value}") };
            assert!(low < high && !(low..=high).contains(&value), "{kind:?} {value}: {low} to {high}");
        }
    }
    // Just beyond what the wire can reach; the refusal names the limits that clients are told beforehand.
    let beyond = Reason::OutOfRange { low: info.min_length_m, high: info.max_length_m };
    assert_eq!(reason(0, Length, info.min_length_m - 1e-6, LONG), beyond);
    assert_eq!(reason(0, Length, info.max_length_m + 1e-6, LONG), beyond);
    assert_eq!(reason(0, Stroke, 1.001, LONG), Reason::OutOfRange { low: 0.0, high: 1.0 });
    assert_eq!(reason(0, Duty, 1.001, LONG), Reason::OutOfRange { low: 0.0, high: info.max_duty });
    // Leases: not for ever, and not shorter than a period.
    for hold in [Duration::from_secs(3601), Duration::MAX, Duration::from_micros(10)] {
        let low = 1.0 / sinew_tests::RATE_HZ;
        assert_eq!(reason(0, Stroke, 0.3, hold), Reason::HoldOutOfRange { low, high: 3600.0 }, "{hold:?}");
    }
    // Channels that are not there, and commands that are not meant for all.
    for channel in [2, 63, 64, 1000, ALL_CHANNELS - 1] {
        for kind in [Length, Stroke, Duty, Off, Reset] {
            assert_eq!(reason(channel, kind, 0.1, LONG), Reason::UnknownChannel, "{kind:?} of {channel}");
        }
    }
    assert_eq!(reason(ALL_CHANNELS, Stroke, 0.1, LONG), Reason::UnknownChannel);
    wait_until("the refusals to be counted", || robot.loop_stats().refusals == commands + refused);

    let error = robot.set_stroke("lfet", 0.1, LONG).unwrap_err();
    assert!(matches!(error, Error::UnknownChannel { .. }) && error.remedy().contains("\"left\""), "{error}");
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().unwrap().len(), 0, "a refusal is no fault of the wire: {report:#}");
}

#[test]
fn a_stale_setpoint_is_given_up_exactly_when_its_lease_ends() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, robot) = Driver::ready(&rig);
    let mut stream = robot.stream().unwrap();
    let hold = Duration::from_millis(700);
    // Duty, not length: so that it is plain whether the wire still gets anything.
    robot.set_duty("left", 0.15, hold).unwrap();
    robot.set_duty("right", 0.15, LONG).unwrap();
    let (mut taken_ns, mut last_ns) = (None, 0);
    let given_up_ns = wait_for("the lease to end", || {
        while let Some(cycle) = stream.next().unwrap() {
            assert_eq!(cycle.lost, 0);
            let (left, right) = (&cycle.channels[0], &cycle.channels[1]);
            if left.mode() == Mode::Duty {
                taken_ns.get_or_insert(cycle.header.monotonic_ns);
                assert!(left.lease_s > 0.0 && left.lease_s < 0.7 + 1e-9, "{left:?}");
                last_ns = cycle.header.monotonic_ns;
            } else if taken_ns.is_some() {
                // In that very cycle, and without taking the neighbour along.
                assert_eq!((left.mode(), left.duty), (Mode::Lapsed, SENSING_DUTY), "{left:?}");
                assert_eq!(left.fault(), None, "no fault");
                assert!(left.lease_s.is_nan() && left.target_m.is_nan(), "{left:?}");
                assert_eq!((right.mode(), right.duty), (Mode::Duty, 0.15), "{right:?}");
                return Some(cycle.header.monotonic_ns);
            }
        }
        None
    });
    let taken_ns = taken_ns.unwrap();
    // The loop takes an order right before a cycle whose time it then counts from: at most that far apart.
    assert!(given_up_ns - taken_ns >= 690_000_000, "given up after {} ns", given_up_ns - taken_ns);
    assert!(last_ns - taken_ns <= 700_000_000, "still held after {} ns", last_ns - taken_ns);

    // Nothing has to be reset: the next setpoint is simply taken.
    robot.set_duty("left", 0.05, LONG).unwrap();
    let left = robot.latest().channels()[0];
    assert_eq!((left.mode(), left.duty, left.fault()), (Mode::Duty, 0.05, None), "{left:?}");
    let report = driver.stop();
    assert_eq!(report["leases_lapsed"], 1, "{report:#}");
}

#[test]
fn a_setpoint_that_is_renewed_in_time_never_lapses() {
    let rig = Rig::bench(&["left"], "");
    let (driver, robot) = Driver::ready(&rig);
    let hold = Duration::from_secs(2);
    robot.set_stroke("left", 0.2, hold).unwrap();
    let (first, started) = (robot.latest().cycle, robot.latest().monotonic_ns);
    let mut stream = robot.stream().unwrap();
    // Three leases long.
    while robot.latest().monotonic_ns - started < 6_000_000_000 {
        robot.set_stroke("left", 0.2, hold).unwrap();
        while let Some(cycle) = stream.next().unwrap() {
            if cycle.header.cycle >= first {
                assert_eq!(cycle.channels[0].mode(), Mode::Length, "{:?}", cycle.channels[0]);
            }
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    let report = driver.stop();
    assert_eq!(report["leases_lapsed"], 0, "{report:#}");
}

#[test]
fn the_command_line_commands_a_channel() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let left = || client.latest().channels()[0];

    let said = rig.ask(&["set", "left", "stroke=40%", "--hold", "100"]).expect(0).stdout;
    assert!(said.contains("left") && said.contains("40"), "{said}");
    assert!((left().target_m - client.channels()[0].length_at_stroke(0.4)).abs() < 1e-9);
    assert!(left().lease_s > 10.0);

    rig.ask(&["set", "left", "length=164mm"]).expect(0);
    assert!((left().target_m - 0.164).abs() < 1e-12);
    rig.ask(&["set", "left", "force=1.6N"]).expect(0);
    assert_eq!(left().mode(), Mode::Force);
    rig.ask(&["set", "left", "duty=0.1", "--hold", "100"]).expect(0);
    assert_eq!((left().mode(), left().duty), (Mode::Duty, 0.1));
    rig.ask(&["set", "left", "off"]).expect(0);
    assert_eq!((left().mode(), left().duty), (Mode::Off, SENSING_DUTY));
    rig.ask(&["reset", "left"]).expect(0);
    driver.stop();
}

/// What only the wire tells is refused in the unit it was asked in, and what is offered instead is taken.
#[test]
fn a_setpoint_beyond_the_stroke_is_refused_with_the_nearest_one() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let is_off = || client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off);
    std::fs::write(rig.file("wave.csv"), "time_s,left,right\n0,10%,\n1,,stroke=30mm\n").unwrap();
    let file = rig.file("wave.csv").display().to_string();
    let outside = "right: stroke 30.00 mm is outside 0.00 to";
    rig.ask(&["set", "left", "stroke=10%", "right", "stroke=30mm"]).refused(&[outside, "the nearest is stroke="]);
    // a file is judged before the first of its rows is played
    rig.ask(&["play", &file]).refused(&[&format!("wave.csv:3: {outside}"), "the nearest is stroke="]);
    assert!(is_off());
    for beyond in ["stroke=140%", "stroke=-1mm", "stroke=30mm", "length=150mm", "length=200mm"] {
        let said = rig.ask(&["set", "right", beyond]).refused(&["right: "]).stderr;
        let nearest =
            said.split("the nearest is ").nth(1).and_then(|rest| rest.split([';', '\n']).next()).expect(&said);
        rig.ask(&["set", "right", nearest, "--hold", "0.1"]).expect(0);
    }
    driver.stop();
}

#[test]
fn the_command_line_says_what_is_wrong_with_a_command() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("right", 0.2, LONG).unwrap();
    let before = client.latest().channels()[1].target_m;
    rig.ask(&["set", "rihgt", "stroke=40%"]).refused(&["rihgt", "right"]);
    rig.ask(&["set", "elbow", "stroke=40%"]).refused(&["elbow", "left"]);
    rig.ask(&["reset", "elbow"]).refused(&["elbow"]);
    rig.ask(&["set", "right", "stroke=140%"]).refused(&["right: `stroke=140%`", "the nearest is stroke=100%"]);
    rig.ask(&["set", "right", "stroke=nan%"]).refused(&["nan"]);
    rig.ask(&["set", "right", "duty=nan"]).refused(&["nan"]);
    rig.ask(&["set", "right", "duty=1.5"]).refused(&["1.5"]);
    rig.ask(&["set", "right", "length=NaN mm"]).refused(&["NaN"]);
    rig.ask(&["set", "right", "length=inf"]).refused(&["inf"]);
    rig.ask(&["set", "right", "length=155"]).refused(&["unit", "mm"]);
    rig.ask(&["set", "right", "speed=3"]).refused(&["speed"]);
    rig.ask(&["set", "right", "banana"]).refused(&["banana"]);
    // Only the driver knows the wire's limits.
    rig.ask(&["set", "right", "length=300mm"]).refused(&["right", "length", "300"]);
    rig.ask(&["set", "right", "force=900N"]).refused(&["right", "force"]);
    rig.ask(&["set", "right", "stroke=10%", "--hold", "99999"]).refused(&["hold", "3600"]);
    let right = client.latest().channels()[1];
    assert_eq!((right.mode(), right.target_m), (Mode::Length, before));
    driver.stop();

    // Nobody is there any more.
    for args in [&["status"][..], &["set", "left", "off"], &["stop"], &["reset", "left"], &["monitor"]] {
        let said = rig.ask(args);
        assert!(matches!(said.code, Some(1 | 2)), "{said:?}");
        assert!(said.stderr.contains(&rig.name) && said.stderr.contains("hint: "), "{said:?}");
    }
}
