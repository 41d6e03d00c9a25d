//! A whole driver with its threads, rings and services, on the scripted backend. Nothing here depends on how fast the
//! machine is: what has to be awaited is awaited by cycles.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::common::{Fake, Mishap, rig};
use sinew_backend::conformance::{Bench, suite};
use sinew_backend::{Backend, BackendError, Sample, Zero};
use sinew_driver::report::Ending;
use sinew_driver::{Driver, DriverHandle, Error, Options, Program};
use sinew_ipc::{Client, Fault, Mode};
use sinew_rig::{Pace, Rig};

/// A rig name of this test's own, so that tests run side by side.
fn name(test: &str) -> String {
    format!("driver-{test}-{}", std::process::id())
}

fn fast(mut rig: Rig) -> Rig {
    rig.simulation.pace = Pace::AsFastAsPossible;
    rig
}

fn start(rig: &Rig, options: Options) -> DriverHandle {
    match Driver::start(rig, Fake::new(rig), options) {
        Ok(handle) => handle,
        Err(error) => panic!("{error}"),
    }
}

/// Waits for something the driver will do sooner or later; only a driver that never does fails.
fn eventually(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "never: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

struct Scripted(Rig);

impl Bench for Scripted {
    type Backend = Fake;

    fn backend(&mut self) -> Fake {
        Fake::new(&self.0)
    }
}

#[test]
fn the_scripted_backend_keeps_the_contract() {
    let rig = rig("conformance", 5, 1000.0);
    let findings = suite(&mut Scripted(rig));
    assert!(findings.counts_allocations, "{findings:?}");
}

#[test]
fn with_all_that_linux_grants_nothing_is_allocated_either() {
    let mut rig = rig(&name("realtime"), 4, 500.0);
    rig.realtime.mode = sinew_rig::RealtimeMode::Try;
    let options = Options { duration_s: Some(0.2), ..Options::default() };
    let report = Driver::start(&rig, Fake::new(&rig), options).unwrap().join();
    assert_eq!(report.allocations_in_loop, Some(0));
    // Whatever was granted, the report is consistent.
    let granted = |id: &str| report.rt.rows.iter().any(|row| row.id == id && row.granted);
    assert_eq!(report.rt.policy == "SCHED_FIFO", granted("scheduler"));
    assert_eq!(report.rt.locked, granted("memory"));
    assert_eq!(report.rt.cpu.is_some(), granted("core"));
}

/// A channel for each law that a rig file can choose, all of them moving.
#[test]
fn no_law_allocates_in_the_loop() {
    let laws = sinew_rig::Algorithm::ALL;
    let mut rig = rig(&name("laws"), laws.len(), 500.0);
    for (channel, (_, law)) in rig.channels.iter_mut().zip(laws) {
        channel.control.algorithm = law;
    }
    let options =
        Options { duration_s: Some(0.5), program: Some(Program::tripod(laws.len(), 1.0)), ..Options::default() };
    let report = Driver::start(&rig, Fake::new(&rig), options).unwrap().join();
    assert_eq!(report.allocations_in_loop, Some(0));
    assert!(report.cycles > 10 && report.faults.is_empty(), "{report:?}");
}

#[test]
fn the_running_loop_allocates_nothing_and_reports_what_it_did() {
    let rig = rig(&name("alloc"), 18, 1000.0);
    let options = Options {
        duration_s: Some(1.0),
        program: Some(Program::tripod(18, 1.0)),
        floor_s: Some(0.05),
        ..Options::default()
    };
    let mut fake = Fake::new(&rig);
    fake.script = vec![(300..310, 4, Mishap::OpenWire)];
    let watch = fake.watch.clone();
    let handle = Driver::start(&rig, fake, options).unwrap();
    // Clients read, stream and command meanwhile: a service might then allocate on the loop's thread.
    let client = Client::connect(&rig.name).unwrap();
    assert_eq!(client.rig_text().unwrap().as_deref(), Some(rig.text()));
    let mut stream = client.stream().unwrap();
    let mut seen = 0u64;
    while handle.is_running() {
        while let Ok(Some(_)) = stream.next() {
            seen += 1;
        }
        let _ = client.set_stroke("wire1", 0.3, Duration::from_millis(100));
        std::thread::sleep(Duration::from_millis(5));
    }
    let report = handle.join();
    assert_eq!(report.allocations_in_loop, Some(0));
    assert_eq!(report.ended, Ending::Duration);
    assert!(report.cycles + report.missed >= 1000, "{} + {}", report.cycles, report.missed);
    assert_eq!(report.missed, report.missed_by_wakeup + report.missed_by_cycle);
    assert!(seen > 0 && report.unpublished == 0, "{seen} seen, {} lost", report.unpublished);
    assert!(watch.stopped.load(Ordering::Relaxed));
    let faults: Vec<_> = report.faults.iter().map(|fault| (fault.channel.as_str(), fault.flag)).collect();
    assert_eq!(faults, [("wire4", "open_wire")]);
    assert_eq!(report.channel[4].fault, Some("open_wire"));
    assert!(report.channel.iter().all(|channel| channel.duty == 0.0), "the last state is that of a stopped driver");
    assert!(report.floor.as_ref().unwrap().cycles > 0);
    // The contract's keys.
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["schema"], "sinew.run/1");
    for key in ["seconds", "rate_hz", "channels", "cycles", "missed", "allocations_in_loop"] {
        assert!(json[key].is_number(), "{key}: {}", json[key]);
    }
    for key in ["lateness_us", "cycle_us"] {
        for quantile in ["p50", "p99", "p999", "max"] {
            assert!(json[key][quantile].is_number(), "{key}.{quantile}");
        }
    }
    assert_eq!(json["rt"]["policy"], "SCHED_OTHER");
    assert_eq!(json["rt"]["locked"], false);
    assert!(json["channel"][0]["fault"].is_null() && json["channel"][0]["length_m"].is_number());
}

#[test]
fn on_a_simulated_clock_a_run_is_the_same_every_time() {
    let run = |test: &str| {
        let rig = fast(rig(&name(test), 6, 1000.0));
        let mut fake = Fake::new(&rig);
        fake.script = vec![(500..520, 3, Mishap::SupplyDip)];
        let options = Options { duration_s: Some(20.0), program: Some(Program::tripod(6, 2.0)), ..Options::default() };
        let report = Driver::start(&rig, fake, options).unwrap().join();
        assert_eq!((report.cycles, report.missed, report.unpublished), (20_000, 0, 0));
        (serde_json::to_value(&report.channel).unwrap(), serde_json::to_value(&report.faults).unwrap())
    };
    assert_eq!(run("same1"), run("same2"));
}

#[test]
fn a_command_is_taken_acknowledged_and_seen_by_a_client_and_bad_ones_say_why() {
    let rig = rig(&name("commands"), 3, 1000.0);
    let handle = start(&rig, Options::default());
    let client = Client::connect(&rig.name).unwrap();
    assert_eq!(client.channels().len(), 3);
    eventually("proved", || client.latest().channel[2].mode() == Mode::Off);

    let hold = Duration::from_secs(5);
    let reply = client.set_stroke("wire2", 0.4, hold).unwrap();
    assert_eq!(reply.hold_s, 5.0);
    let wanted = client.channels()[2].length_at_stroke(0.4);
    eventually("in force", || {
        let state = client.latest();
        state.channel[2].mode() == Mode::Length && (state.channel[2].target_m - wanted).abs() < 1e-12
    });
    eventually("reached", || (client.latest().channel[2].length_m - wanted).abs() < 0.0003);
    // Against a spring a force is a length; the default lease is the rig's.
    let reply = client.set_force("wire1", 1.8, Duration::ZERO).unwrap();
    assert_eq!(reply.hold_s, rig.channels[1].limits.lease_s);
    eventually("force", || client.latest().channel[1].mode() == Mode::Force);

    let text = |result: Result<sinew_ipc::Reply, sinew_ipc::Error>| result.unwrap_err().to_string();
    for (bad, word) in [
        (client.set_length("wire0", f64::NAN, hold), "finite"),
        (client.set_length("wire0", 0.3, hold), "0.3"),
        (client.set_stroke("wire0", 1.2, hold), "1.2"),
        (client.set_duty("wire0", -0.1, hold), "0.1"),
        (client.set_duty("wire0", 0.1, Duration::from_secs(1_000_000)), "hold"),
        (client.set_force("wire0", 900.0, hold), "900"),
        (client.set_length("wire7", 0.16, hold), "wire7"),
        (client.command(7, sinew_ipc::CommandKind::Duty, 0.1, hold), "channel"),
    ] {
        let text = text(bad);
        assert!(text.contains(word), "{text:?} does not say {word:?}");
    }
    assert_eq!(client.latest().channel[0].mode(), Mode::Off, "a refused command changes nothing");
    client.all_off().unwrap();
    eventually("off", || client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off));
    client.stop().unwrap();
    eventually("stopped", || !handle.is_running());
    let report = handle.join();
    assert_eq!(report.ended, Ending::Stopped);
    assert!(report.faults.is_empty(), "{:?}", report.faults);
}

#[test]
fn a_fault_is_latched_for_clients_and_reset_through_them() {
    let rig = rig(&name("reset"), 2, 1000.0);
    let mut fake = Fake::new(&rig);
    fake.script = vec![(100..u64::MAX, 1, Mishap::ProbeLost)];
    let handle = Driver::start(&rig, fake, Options::default()).unwrap();
    let client = Client::connect(&rig.name).unwrap();
    eventually("fault", || client.latest().channel[1].fault() == Some(Fault::ProbeLost));
    let refused = client.set_duty("wire1", 0.1, Duration::from_secs(1)).unwrap_err().to_string();
    assert!(refused.contains(Fault::ProbeLost.cause()), "{refused}");
    let refused = client.reset("wire1").unwrap_err().to_string();
    assert!(refused.contains(Fault::ProbeLost.cause()), "{refused}");
    assert_eq!(client.latest().channel[1].duty, 0.0);
    client.reset("wire0").unwrap();
    handle.stop();
    let report = handle.join();
    assert_eq!(report.channel[1].fault, Some("probe_lost"));
    assert_eq!(report.faults[0].cause, Fault::ProbeLost.cause());
}

#[test]
fn a_second_driver_of_the_same_rig_is_refused_by_the_first_ones_process_id() {
    let rig = rig(&name("twice"), 1, 100.0);
    let handle = start(&rig, Options::default());
    match Driver::start(&rig, Fake::new(&rig), Options::default()) {
        Err(error @ Error::Services(sinew_ipc::Error::AlreadyRunning { pid, .. })) => {
            assert_eq!(pid, std::process::id());
            assert!(error.to_string().contains(&pid.to_string()));
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("two drivers run one rig"),
    }
    drop(handle);
    // The name is free again.
    drop(start(&rig, Options::default()));
}

#[test]
fn a_panic_in_the_loop_stops_the_outputs_and_ends_the_run() {
    let rig = rig(&name("panic"), 2, 1000.0);
    let fake = Fake::new(&rig);
    let watch = fake.watch.clone();
    watch.panic_at.store(50, Ordering::Relaxed);
    let handle = Driver::start(&rig, fake, Options::default()).unwrap();
    eventually("ended", || !handle.is_running());
    assert!(watch.stopped.load(Ordering::Relaxed), "outputs are zero");
    let report = handle.join();
    assert_eq!(report.ended, Ending::Panicked);
    // Fewer where the machine made the loop miss a period.
    assert!((1..50).contains(&report.cycles), "{}", report.cycles);
}

/// What a driver believes of its wire in the first cycle that is seen of it, °C, and how long after its start that was, s; it ends
/// when it knows that the wire is cold.
fn first_belief(rig: &Rig, fake: Fake) -> (f64, f64) {
    let handle = Driver::start(rig, fake, Options::default()).unwrap();
    let client = Client::connect(&rig.name).unwrap();
    let (mut most_c, mut seen_s) = (f64::NEG_INFINITY, f64::NAN);
    eventually("measured", || {
        let latest = client.latest();
        let state = latest.channels()[0];
        if state.temperature_c > most_c {
            most_c = state.temperature_c;
            seen_s = latest.monotonic_ns.saturating_sub(client.info().started_ns) as f64 * 1e-9;
        }
        // What is believed of this backend's wire, which is no real one, settles at 55 to 64 °C, as its noise falls.
        state.length_m.is_finite() && state.temperature_c < 70.0
    });
    drop(client);
    handle.stop();
    handle.join();
    (most_c, seen_s)
}

#[test]
fn what_is_known_of_a_wire_outlives_its_driver_and_an_unknown_one_is_at_its_limit() {
    // Slow enough that a client sees the first cycles.
    let rig = rig(&name("memory"), 1, 50.0);
    let limit_c = rig.channels[0].limits.max_temperature_c;
    let fake = || {
        let mut fake = Fake::new(&rig);
        fake.outlives = Some(format!("{} {}", rig.name, std::process::id()));
        fake
    };
    // Where the machine is busy, a client sees it late, and what is believed has cooled since: no wire like this does so faster.
    const COOLS_K_PER_S: f64 = 150.0;
    let is_at_its_limit = |fake: Fake, why: &str| {
        let (believed_c, seen_s) = first_belief(&rig, fake);
        let cooled_k = COOLS_K_PER_S * seen_s;
        assert!(
            believed_c < limit_c + 1.0 && believed_c > limit_c - 1.0 - cooled_k,
            "{why}: {believed_c} after {seen_s} s"
        );
    };
    is_at_its_limit(fake(), "nothing is known");
    let (remembered_c, _) = first_belief(&rig, fake());
    assert!(remembered_c < 0.5 * limit_c, "{remembered_c} °C, though it was left cold a moment ago");
    let mut foreign = fake();
    foreign.mark = 2;
    is_at_its_limit(foreign, "somebody else has used it since");
    let mut another = fake();
    another.outlives = Some(format!("{} other", rig.name));
    is_at_its_limit(another, "another output");
}

#[test]
fn a_backend_whose_outputs_nothing_ends_is_refused() {
    struct Endless(Fake);
    impl Backend for Endless {
        fn channels(&self) -> usize {
            self.0.channels()
        }
        fn start(&mut self) -> Result<(), BackendError> {
            self.0.start()
        }
        fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
            self.0.exchange(duty, samples)
        }
        fn stop(&mut self) -> Zero {
            self.0.stop()
        }
    }
    let rig = rig(&name("endless"), 1, 1000.0);
    let options = Options { private: true, ..Options::default() };
    let error = Driver::start(&rig, Endless(Fake::new(&rig)), options).unwrap_err().to_string();
    assert!(error.contains("needs a watchdog"), "{error}");
}

#[test]
fn a_dropped_handle_stops_the_outputs() {
    let rig = rig(&name("drop"), 1, 1000.0);
    let fake = Fake::new(&rig);
    let watch = fake.watch.clone();
    let handle = Driver::start(&rig, fake, Options { private: true, ..Options::default() }).unwrap();
    eventually("running", || watch.periods.load(Ordering::Relaxed) > 10);
    drop(handle);
    assert!(watch.stopped.load(Ordering::Relaxed));
}

/// A backend that does not come up.
struct Broken(Fake);

impl Backend for Broken {
    fn channels(&self) -> usize {
        self.0.channels()
    }
    fn start(&mut self) -> Result<(), BackendError> {
        Err(BackendError::Unavailable { os_error: 19 })
    }
    fn exchange(&mut self, _: &[f64], _: &mut [Sample]) -> Result<(), BackendError> {
        Err(BackendError::NotStarted)
    }
    fn silence_s(&self) -> Option<f64> {
        self.0.silence_s()
    }
    fn is_at_rest(&self) -> bool {
        self.0.is_at_rest()
    }
    fn stop(&mut self) -> Zero {
        self.0.stop()
    }
}

/// A backend that is never due, and counts how often it is asked.
struct NeverDue(Fake, Arc<AtomicU64>);

impl Backend for NeverDue {
    fn channels(&self) -> usize {
        self.0.channels()
    }
    fn start(&mut self) -> Result<(), BackendError> {
        self.0.start()
    }
    fn is_due(&mut self) -> bool {
        self.1.fetch_add(1, Ordering::Relaxed);
        false
    }
    fn missed(&mut self, periods: u64) {
        self.0.missed(periods);
    }
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        self.0.exchange(duty, samples)
    }
    fn silence_s(&self) -> Option<f64> {
        self.0.silence_s()
    }
    fn is_at_rest(&self) -> bool {
        self.0.is_at_rest()
    }
    fn stop(&mut self) -> Zero {
        self.0.stop()
    }
}

#[test]
fn a_period_that_is_not_due_is_missed_and_counted_and_the_next_one_is_not() {
    let rig = rig(&name("not-due"), 1, 500.0);
    let fake = Fake::new(&rig);
    let (watch, asked) = (fake.watch.clone(), Arc::new(AtomicU64::new(0)));
    let options = Options { private: true, ..Options::default() };
    let handle = Driver::start(&rig, NeverDue(fake, asked.clone()), options).unwrap();
    eventually("running", || watch.periods.load(Ordering::Relaxed) > 60);
    handle.stop();
    let report = handle.join();
    // Each cycle but the first comes after one period that was let pass, at least.
    assert!(report.missed + 1 >= report.cycles && report.cycles > 10, "{report:?}");
    assert_eq!(report.missed_by_wakeup + report.missed_by_cycle, report.missed, "{report:?}");
    assert!(asked.load(Ordering::Relaxed) >= report.cycles, "{report:?}");
    let periods = report.seconds * report.rate_hz;
    assert!((periods - (report.cycles + report.missed) as f64).abs() < 0.5, "{periods} periods: {report:?}");
}

#[test]
fn what_cannot_be_started_says_why_and_leaves_nothing_behind() {
    let mut rig = rig(&name("broken"), 2, 1000.0);
    let error = Driver::start(&rig, Broken(Fake::new(&rig)), Options::default()).unwrap_err();
    assert!(matches!(error, Error::Backend(BackendError::Unavailable { os_error: 19 })), "{error}");

    let other = crate::common::rig("other", 3, 1000.0);
    let error = Driver::start(&rig, Fake::new(&other), Options::default()).unwrap_err();
    assert!(matches!(error, Error::Channels { expected: 2, found: 3 }), "{error}");

    // A core no machine has: refused everywhere, and an error with strict.
    rig.realtime.mode = sinew_rig::RealtimeMode::Strict;
    rig.realtime.cpu = Some(4095);
    match Driver::start(&rig, Fake::new(&rig), Options::default()).unwrap_err() {
        Error::NotRealtime { refused } => assert!(refused.iter().any(|row| row.contains("core 4095")), "{refused:?}"),
        other => panic!("{other}"),
    }
    // The name was given back each time.
    rig.realtime.mode = sinew_rig::RealtimeMode::Off;
    drop(start(&rig, Options::default()));
}
