//! What breaks in the rig, played by its simulation: only that channel goes off, at once, latched with its first cause, until
//! somebody resets it with the cause gone.

use sinew_ipc::{ChannelState, Client, CycleStream, Error, Fault, FaultWatch, Mode, Reason, Snapshot};
use sinew_tests::{Driver, RATE_HZ, Rig, SENSING_DUTY, wait_for, wait_until};
use std::collections::HashMap;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(120);
const DUTY: f64 = 0.1;
/// When the first thing breaks, s of simulated time: long after a driver is ready and its wires are powered.
const BREAKS_S: f64 = 5.0;
/// For how long everything is broken in the test of all kinds, s.
const BROKEN_S: f64 = 5.0;

/// The machine was too slow for what is to be done between two times of the simulation.
struct Late;

/// Faults are played at times of the simulation, and how far a test gets by then depends on the machine: where it comes too
/// late, everything begins again with so many times as much time.
#[track_caller]
fn in_time(attempt: impl Fn(f64) -> Result<(), Late>) {
    let in_time = [1.0, 2.0, 4.0, 8.0].into_iter().any(|stretch| attempt(stretch).is_ok());
    assert!(in_time, "the machine is too slow, whatever time it is given");
}

/// That it is not `end_s` yet.
fn before(end_s: f64, client: &Client) -> Result<(), Late> {
    if time_s(&client.latest()) < end_s { Ok(()) } else { Err(Late) }
}

/// Simulated time, which goes on through periods the loop misses, s.
fn time_s(state: &Snapshot) -> f64 {
    (state.cycle + state.missed) as f64 / RATE_HZ
}

fn fault(channel: &str, kind: &str, value: Option<f64>, from_s: f64, to_s: f64) -> String {
    let value = value.map(|v| format!("value = {v:?}\n")).unwrap_or_default();
    let channel = if channel.is_empty() { String::new() } else { format!("channel = \"{channel}\"\n") };
    format!("\n[[simulation.fault]]\n{channel}kind = \"{kind}\"\nstart_s = {from_s:?}\nend_s = {to_s:?}\n{value}")
}

#[track_caller]
fn refused(result: Result<sinew_ipc::Reply, Error>) -> Reason {
    match result {
        Err(Error::Refused(refusal)) => {
            assert!(!refusal.message().is_empty() && !refusal.remedy().is_empty());
            refusal.reason
        }
        other => panic!("expected a refusal, got {other:?}"),
    }
}

/// Resets again and again until it is accepted, as somebody does who mends the rig meanwhile.
#[track_caller]
fn reset_when_possible(client: &Client, channel: &str) {
    wait_until("the reset to be accepted", || match client.reset(channel) {
        Ok(_) => true,
        Err(Error::Refused(refusal)) if matches!(refusal.reason, Reason::CauseRemains(_) | Reason::TooHot { .. }) => {
            false
        }
        Err(error) => panic!("{error}"),
    });
}

/// Name of the channel, kind and size of what breaks, and what it may be recognised as.
const BROKEN: [(&str, &str, Option<f64>, &[Fault]); 10] = [
    ("open", "open_wire", None, &[Fault::OpenWire]),
    ("short", "shorted_wire", Some(0.05), &[Fault::ShortedWire, Fault::OverCurrent]),
    ("tap1", "probe_lost", Some(1.0), &[Fault::ProbeLost]),
    ("tap2", "probe_lost", Some(2.0), &[Fault::ProbeLost]),
    ("end", "probe_lost", Some(3.0), &[Fault::ProbeLost, Fault::ShortedWire]),
    ("dip", "supply_dip", Some(0.5), &[Fault::SupplyDip]),
    ("nan", "adc_nan", None, &[Fault::NoSample, Fault::NotFinite]),
    ("full", "adc_saturated", None, &[Fault::Saturated, Fault::ShortedWire]),
    ("contact", "contact_resistance", Some(2.0), &[Fault::OutOfRange, Fault::ProbeLost]),
    ("stuck", "adc_stuck", None, &[Fault::Stuck]),
];

#[test]
fn every_fault_switches_its_channel_off_alone_and_is_latched_until_reset() {
    in_time(|stretch| every_fault_of_a_span([BREAKS_S * stretch, (BREAKS_S + BROKEN_S) * stretch]));
}

fn every_fault_of_a_span([from_s, to_s]: [f64; 2]) -> Result<(), Late> {
    let mut faults = String::new();
    for (channel, kind, value, _) in BROKEN {
        faults += &fault(channel, kind, value, from_s, to_s);
    }
    let names: Vec<&str> = BROKEN.iter().map(|b| b.0).chain(["whole"]).collect();
    let rig = Rig::bench(&names, &faults);
    let (driver, client) = Driver::ready(&rig);
    let mut watch = client.faults();
    let mut stream = client.stream().unwrap();
    for name in &names {
        let set = client.set_duty(name, DUTY, LONG);
        before(from_s, &client)?;
        set.unwrap();
    }
    let commanded = client.latest();
    let latched = latched_one_by_one(&mut stream, commanded.cycle, &names);
    for ((name, kind, _, expected), found) in BROKEN.iter().zip(latched) {
        println!("{name}: {kind} recognised as {}", found.flag());
        assert!(expected.contains(&found), "{name}: {kind} recognised as {found:?}, expected {expected:?}");
    }
    every_subscriber_hears_once(&mut watch);
    refused_while_the_cause_remains(&rig, &client, latched, to_s)?;
    off_until_reset(&rig, &client, &names, to_s);
    reported_with_the_first_cause(&driver.stop(), latched, [from_s, to_s]);
    Ok(())
}

/// Follows every cycle from the commands on until all ten are latched, and gives what each was recognised as.
fn latched_one_by_one(stream: &mut CycleStream, commanded_cycle: u64, names: &[&str]) -> [Fault; BROKEN.len()] {
    let mut unhealthy = [0; BROKEN.len()];
    let mut latched: [Option<Fault>; BROKEN.len()] = [None; BROKEN.len()];
    wait_until("all faults to be latched", || {
        while let Some(cycle) = stream.next().unwrap() {
            if cycle.header.cycle <= commanded_cycle {
                continue;
            }
            assert_eq!(cycle.lost, 0);
            let sound = &cycle.channels[BROKEN.len()];
            assert_eq!((sound.mode(), sound.duty, sound.fault()), (Mode::Duty, DUTY, None), "the neighbour goes on");
            for (i, (state, name)) in cycle.channels.iter().zip(names).take(BROKEN.len()).enumerate() {
                unhealthy[i] += u32::from(state.health != 0 && latched[i].is_none());
                match (latched[i], state.fault()) {
                    (None, None) if state.health == 0 => assert_eq!(state.duty, DUTY, "{name}: {state:?}"),
                    // The first bad sample already takes the power away.
                    (None, None) => assert!(state.duty <= SENSING_DUTY, "{name}: {state:?}"),
                    (before, Some(fault)) => {
                        assert_eq!((state.mode(), state.duty), (Mode::Fault, 0.0), "{name}: {state:?}");
                        assert!(
                            before.is_none_or(|b| b == fault),
                            "{name}: the first cause stays: {before:?}, {fault:?}"
                        );
                        if before.is_none() {
                            assert!(unhealthy[i] <= 2, "{name}: off after {} bad samples", unhealthy[i]);
                        }
                        latched[i] = Some(fault);
                    }
                    (Some(fault), None) => panic!("{name}: {fault:?} went away by itself: {state:?}"),
                }
            }
        }
        latched.iter().all(Option::is_some)
    });
    latched.map(Option::unwrap)
}

/// Subscribers hear of it once a channel.
fn every_subscriber_hears_once(watch: &mut FaultWatch<&Client>) {
    let mut told: HashMap<String, Fault> = HashMap::new();
    wait_until("the faults to be reported", || {
        while let Some(change) = watch.poll() {
            assert_eq!(change.before, None, "{change:?}");
            assert_eq!(told.insert(change.name, change.after.unwrap()), None, "told twice");
        }
        told.len() == BROKEN.len()
    });
}

/// While the cause is there, setpoints and resets are refused with it; to switch off what is off is no mistake.
fn refused_while_the_cause_remains(
    rig: &Rig,
    client: &Client,
    latched: [Fault; BROKEN.len()],
    to_s: f64,
) -> Result<(), Late> {
    for ((name, ..), fault) in BROKEN.iter().zip(latched) {
        assert_eq!(refused(client.set_duty(name, DUTY, LONG)), Reason::Faulted(fault), "{name}");
        assert_eq!(refused(client.set_stroke(name, 0.2, LONG)), Reason::Faulted(fault), "{name}");
        client.off(name).unwrap();
        let reset = client.reset(name);
        before(to_s, client)?;
        let Reason::CauseRemains(now) = refused(reset) else { panic!("{name}") };
        let expected = BROKEN.iter().find(|b| b.0 == *name).unwrap().3;
        assert!(expected.contains(&now), "{name}: {now:?}");
        let state = client.latest().channels()[client.channel(name).unwrap()];
        assert_eq!((state.mode(), state.duty), (Mode::Fault, 0.0), "{name}: {state:?}");
    }
    let asked = rig.ask(&["reset", "open"]);
    before(to_s, client)?;
    let cli = asked.expect(1);
    assert!(cli.stderr.contains("open_wire") && cli.stderr.contains("hint: "), "{cli:?}");
    Ok(())
}

/// Then somebody mends it all; it stays latched until it is reset.
fn off_until_reset(rig: &Rig, client: &Client, names: &[&str], to_s: f64) {
    wait_until("the causes to go", || time_s(&client.latest()) > to_s + 0.1);
    let state = client.latest();
    for (name, state) in names.iter().zip(state.channels()).take(BROKEN.len()) {
        assert_eq!((state.mode(), state.duty), (Mode::Fault, 0.0), "{name}: {state:?}");
    }
    let all = rig.ask(&["reset", "--all"]);
    let cleared = all.expect(0);
    for (name, ..) in BROKEN {
        assert!(cleared.stdout.lines().any(|line| line.starts_with(&format!("{name}: "))), "{cleared:?}");
    }
    assert_eq!(rig.ask(&["reset", "--all"]).expect(0).stdout, "no channel has a fault\n");
    for (name, ..) in BROKEN {
        client.reset(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        let state = client.latest().channels()[client.channel(name).unwrap()];
        // And what was asked for before the fault is not taken up again.
        assert_eq!((state.mode(), state.duty, state.fault()), (Mode::Off, SENSING_DUTY, None), "{name}: {state:?}");
        client.set_duty(name, DUTY, LONG).unwrap();
        assert_eq!(client.latest().channels()[client.channel(name).unwrap()].duty, DUTY, "{name}");
    }
}

/// The driver's report has the first cause of each, and nothing of the channel that is whole.
fn reported_with_the_first_cause(report: &serde_json::Value, latched: [Fault; BROKEN.len()], [from_s, to_s]: [f64; 2]) {
    let mut first: HashMap<&str, &str> = HashMap::new();
    for fault in report["faults"].as_array().unwrap() {
        let (channel, flag) = (fault["channel"].as_str().unwrap(), fault["flag"].as_str().unwrap());
        let at_s = fault["time_s"].as_f64().unwrap();
        assert!((from_s - 0.01..to_s).contains(&at_s), "{fault:#}");
        assert!(!fault["cause"].as_str().unwrap().is_empty());
        first.entry(channel).or_insert(flag);
    }
    for ((name, ..), fault) in BROKEN.iter().zip(latched) {
        assert_eq!(first.get(name), Some(&fault.flag()), "{name}: {report:#}");
    }
    assert!(!first.contains_key("whole"), "{report:#}");
}

#[test]
fn the_first_cause_stays_whatever_breaks_next() {
    in_time(|stretch| one_cause_after_another(BREAKS_S * stretch, (BREAKS_S + 4.0) * stretch));
}

fn one_cause_after_another(breaks_s: f64, ends_s: f64) -> Result<(), Late> {
    let mut faults = fault("left", "probe_lost", Some(2.0), breaks_s, breaks_s + 1.0);
    faults += &fault("left", "open_wire", None, breaks_s + 0.5, ends_s);
    let rig = Rig::bench(&["left", "right"], &faults);
    let (driver, client) = Driver::ready(&rig);
    let mut stream = client.stream().unwrap();
    for name in ["left", "right"] {
        let set = client.set_stroke(name, 0.3, LONG);
        before(breaks_s, &client)?;
        set.unwrap();
    }
    let mut seen = Vec::new();
    wait_until("both causes to have been there", || {
        while let Some(cycle) = stream.next().unwrap() {
            let fault = cycle.channels[0].fault();
            assert_eq!(cycle.channels[1].fault(), None);
            if seen.last() != Some(&fault) {
                seen.push(fault);
            }
        }
        time_s(&client.latest()) > breaks_s + 1.1
    });
    assert_eq!(seen, [None, Some(Fault::ProbeLost)]);
    // The first cause has gone, but another is there: it is refused, and says what is wrong now.
    let reset = client.reset("left");
    before(ends_s, &client)?;
    assert_eq!(refused(reset), Reason::CauseRemains(Fault::OpenWire));
    wait_until("that to go too", || time_s(&client.latest()) > ends_s + 0.1);
    client.reset("left").unwrap();
    client.set_stroke("left", 0.2, LONG).unwrap();
    assert_eq!(client.latest().channels()[1].mode(), Mode::Length, "nobody has disturbed the other one");
    driver.stop();
    Ok(())
}

#[test]
fn a_backend_that_fails_takes_all_its_channels_and_one_channel_of_it_only_itself() {
    in_time(|stretch| one_fails_and_then_all(BREAKS_S * stretch, 2.0 * stretch));
}

fn one_fails_and_then_all(breaks_s: f64, span_s: f64) -> Result<(), Late> {
    let ends_s = breaks_s + span_s;
    let (all_from_s, all_to_s) = (breaks_s + 2.0 * span_s, breaks_s + 3.0 * span_s);
    let mut faults = fault("left", "backend_error", None, breaks_s, ends_s);
    faults += &fault("", "backend_error", None, all_from_s, all_to_s);
    let rig = Rig::bench(&["left", "right"], &faults);
    let (driver, client) = Driver::ready(&rig);
    let both = || client.latest().channels().iter().map(|c| (c.fault(), c.duty)).collect::<Vec<_>>();
    for name in ["left", "right"] {
        let set = client.set_duty(name, DUTY, LONG);
        before(breaks_s, &client)?;
        set.unwrap();
    }
    wait_until("one to fail", || client.latest().channels()[0].fault().is_some());
    let (seen, reset) = (both(), client.reset("left"));
    before(ends_s, &client)?;
    assert_eq!(seen, [(Some(Fault::Backend), 0.0), (None, DUTY)]);
    assert_eq!(refused(reset), Reason::CauseRemains(Fault::Backend));
    reset_when_possible(&client, "left");
    assert!(time_s(&client.latest()) >= ends_s, "at {} s", time_s(&client.latest()));
    let set = client.set_duty("left", DUTY, LONG);
    before(all_from_s, &client)?;
    set.unwrap();
    wait_until("all to fail", || client.latest().channels().iter().all(|c| c.fault().is_some()));
    assert_eq!(both(), [(Some(Fault::Backend), 0.0); 2]);
    assert!(time_s(&client.latest()) >= all_from_s - 0.01);
    for name in ["left", "right"] {
        let reset = client.reset(name);
        before(all_to_s, &client)?;
        assert_eq!(refused(reset), Reason::CauseRemains(Fault::Backend));
    }
    for name in ["left", "right"] {
        reset_when_possible(&client, name);
        assert!(time_s(&client.latest()) >= all_to_s, "at {} s", time_s(&client.latest()));
    }
    assert_eq!(both(), [(None, SENSING_DUTY); 2]);
    let report = driver.stop();
    assert!(report["backend_error"].is_string(), "{report:#}");
    Ok(())
}

#[test]
fn a_channel_without_a_sensor_is_never_powered() {
    let rig = Rig::bench(&["blind", "left"], &fault("blind", "adc_nan", None, 0.0, 1e6));
    let driver = Driver::start(&rig);
    let client = rig.client();
    let blind = || client.latest().channels()[0];
    wait_until("the fault", || blind().fault().is_some());
    assert_eq!((blind().fault(), blind().duty), (Some(Fault::NoSample), 0.0));
    assert!(blind().measured_length_m.is_nan(), "{:?}", blind());
    assert_eq!(refused(client.set_duty("blind", 0.5, LONG)), Reason::Faulted(Fault::NoSample));
    assert_eq!(refused(client.reset("blind")), Reason::CauseRemains(Fault::NoSample));
    // The other one works.
    wait_until("the other sensor", || client.latest().channels()[1].mode() == Mode::Off);
    client.set_duty("left", DUTY, LONG).unwrap();
    assert_eq!(client.latest().channels()[1].duty, DUTY);
    let mut said = String::new();
    wait_until("status to tell", || {
        said = rig.ask(&["status"]).expect(0).stdout;
        said.contains("no_sample")
    });
    let report = driver.stop();
    assert_eq!(report["channel"][0]["fault"], "no_sample", "{report:#}");
    assert_eq!(report["channel"][0]["length_m"], serde_json::Value::Null, "{report:#}");
    assert_eq!(report["channel"][1]["fault"], serde_json::Value::Null, "{report:#}");
}

#[test]
fn a_wire_asked_for_too_much_is_held_at_its_budget_and_told_so() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let limit_c = client.channels()[0].max_temperature_c;
    client.set_duty("left", client.channels()[0].max_duty, LONG).unwrap();
    let derated = ChannelState::FLAG_HEAT_BUDGET | ChannelState::FLAG_TEMPERATURE_BUDGET;
    let held = wait_for("the supervisor to step in", || {
        let left = client.latest().channels()[0];
        (left.flags & derated != 0).then_some(left)
    });
    assert_ne!(held.flags & ChannelState::FLAG_LIMITED, 0, "{held:?}");
    let since_s = time_s(&client.latest());
    wait_until("two seconds of it", || time_s(&client.latest()) > since_s + 2.0);
    let left = client.latest().channels()[0];
    assert_eq!(left.fault(), None, "held, and not tripped: {left:?}");
    assert!(left.temperature_c < limit_c, "{} °C where {limit_c} °C are allowed", left.temperature_c);
    assert_eq!(client.latest().channels()[1].fault(), None);
    driver.stop();
}

#[test]
fn a_rig_file_with_a_wrong_fault_is_refused() {
    for (text, words) in [
        (fault("lfet", "open_wire", None, 1.0, 2.0), &["rig.toml:", "lfet", "left"][..]),
        (fault("left", "opne_wire", None, 1.0, 2.0), &["rig.toml:", "opne_wire", "open_wire"]),
        (fault("left", "probe_lost", Some(4.0), 1.0, 2.0), &["rig.toml:", "4"]),
        (fault("left", "open_wire", None, 2.0, 1.0), &["rig.toml:", "end_s"]),
        (fault("left", "supply_dip", Some(f64::NAN), 1.0, 2.0).replace("NaN", "nan"), &["rig.toml:", "nan"]),
    ] {
        let rig = Rig::bench(&["left"], &text);
        sinew_tests::Process::start(&mut rig.command(&["--for", "1"])).finish().refused(words);
    }
}
