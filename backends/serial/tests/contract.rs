//! The conformance suite for backends, over a pseudo-terminal with the firmware on the other end.

use std::time::{Duration, Instant};

use sinew_backend::allocations::CountingAllocator;
use sinew_backend::conformance::{Bench, suite};
use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, StopInputs, Unused};
use sinew_front_end::{ChannelFault as DeviceFault, Decoder, MAX_BODY, encode_hello};
use sinew_front_end_host::{Host, Options, Order, Spoilt};
use sinew_rig::{BackendKind, EnableSignal, FaultKind, Rig, SamplingCircuit};
use sinew_serial_backend::{Error, SerialBackend};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Slow, and patient with machines that do something else for seconds.
const RATE_HZ: f64 = 200.0;
const WATCHDOG: u32 = 200;
const PATIENCE: usize = 4000;

/// A rig on a front-end at the end of a link in a folder of its own.
fn rig(folder: &tempfile::TempDir) -> Rig {
    let mut rig = Rig::hexapod();
    rig.channels.truncate(4);
    rig.rate_hz = RATE_HZ;
    // The suite drives without a supervisor; I²t on the device would end that, and has tests of its own.
    rig.channels.iter_mut().for_each(|channel| channel.limits.energy_budget_j = 1e3);
    // Not in the rig's order: each is to find its own.
    rig.channels[0].backend.serial.index = Some(3);
    rig.channels[3].backend.serial.index = Some(0);
    rig.backend.kind = BackendKind::Serial;
    rig.backend.serial.port = Some(link(folder).display().to_string());
    rig.backend.serial.watchdog_periods = WATCHDOG;
    rig
}

fn link(folder: &tempfile::TempDir) -> std::path::PathBuf {
    folder.path().join("front-end")
}

fn host(rig: &Rig, folder: &tempfile::TempDir, spoilt: [Spoilt; 2]) -> Host {
    let options = Options { link: Some(link(folder)), spoilt, ..Options::default() };
    Host::start(rig, options).unwrap_or_else(|error| panic!("{error}"))
}

struct Line {
    rig: Rig,
    folder: tempfile::TempDir,
    host: Option<Host>,
    next: Instant,
}

impl Line {
    fn new(circuit: SamplingCircuit) -> Line {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut rig = rig(&folder);
        rig.channels.iter_mut().for_each(|channel| channel.adc.circuit = circuit);
        Line { rig, folder, host: None, next: Instant::now() }
    }

    fn host(&self) -> &Host {
        self.host.as_ref().expect("a backend is made before it is mistreated")
    }

    fn place(&self, channel: usize) -> usize {
        self.rig.front_end_index(channel).expect("a channel of the rig") as usize
    }
}

impl Bench for Line {
    type Backend = SerialBackend;

    fn backend(&mut self) -> SerialBackend {
        self.host = None;
        self.host = Some(host(&self.rig, &self.folder, [Spoilt::default(); 2]));
        SerialBackend::connect(&self.rig).unwrap_or_else(|error| panic!("{error}"))
    }

    fn pace(&mut self) {
        let period = Duration::from_secs_f64(1.0 / RATE_HZ);
        let now = Instant::now();
        // As the loop does: a late tick continues from now, and no two ticks follow at once.
        self.next = if self.next + period < now { now } else { self.next + period };
        std::thread::sleep(self.next.saturating_duration_since(now));
    }

    fn patience(&self) -> usize {
        PATIENCE
    }

    fn put_out(&mut self, channel: usize) -> Option<f64> {
        Some(self.host().put_out(self.place(channel)))
    }

    fn unplug(&mut self) -> bool {
        self.host().order(Order::Disconnect);
        true
    }

    fn plug_in(&mut self) {
        self.host().order(Order::Connect);
    }

    fn break_channel(&mut self, channel: usize) -> Option<ChannelFault> {
        self.host().order(Order::Break(self.place(channel) as u8, DeviceFault::Stage));
        Some(ChannelFault::Stage)
    }

    fn mend_channel(&mut self, channel: usize) {
        self.host().order(Order::Mend(self.place(channel) as u8));
    }
}

#[test]
fn it_keeps_the_contract_of_backends() {
    for circuit in [SamplingCircuit::SeparateTaps, SamplingCircuit::Shared] {
        let findings = suite(&mut Line::new(circuit));
        assert!(findings.counts_allocations && findings.skipped.is_empty(), "{findings:?}");
        let [median_ns, worst_ns] = findings.exchange_ns;
        println!("{circuit:?}: an exchange takes {median_ns} ns, at worst {worst_ns} ns");
    }
}

#[test]
fn a_driver_that_was_late_is_no_broken_sensor() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rig = rig(&folder);
    rig.rate_hz = 20.0;
    rig.backend.serial.watchdog_periods = 20;
    let _host = host(&rig, &folder, [Spoilt::default(); 2]);
    let mut backend = SerialBackend::connect(&rig).unwrap_or_else(|error| panic!("{error}"));
    backend.start().expect("it is there");
    let figures = backend.figures();
    let period = Duration::from_secs_f64(1.0 / rig.rate_hz);
    let duty = [0.1, 0.2, 0.3, 0.4];
    let mut samples = vec![Sample::NONE; 4];
    let (mut held, mut measured) = (0, 0);
    for _ in 0..8 {
        std::thread::sleep(period);
        assert!(backend.is_due(), "after a whole period, whatever is there");
        // This one came late: its point of the grid was nearly a period ago.
        let sent = Instant::now();
        let late = backend.exchange(&duty, &mut samples);
        // The next point of the grid.
        std::thread::sleep(period / 20);
        let before = figures.answered();
        if !backend.is_due() {
            held += 1;
            std::thread::sleep(period);
            let next = backend.exchange(&duty, &mut samples);
            measured += u32::from(late.is_ok() && next.is_ok() && figures.answered() > before);
        } else {
            assert!(sent.elapsed() > period / 2, "what was sent {:?} ago has not had its period", sent.elapsed());
        }
    }
    // A machine that is busy may be late itself, but not each time.
    assert!(held > 0 && measured > 0, "{held} {measured} {figures:?}");
}

#[test]
fn on_a_bad_line_it_measures_what_arrives_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rig = rig(&folder);
    let bad = Spoilt { lost: 0.1, damaged: 0.1, swapped: 0.1, delay_ns: 0 };
    let host = host(&rig, &folder, [Spoilt::default(); 2]);
    let mut backend = SerialBackend::connect(&rig).unwrap_or_else(|error| panic!("{error}"));
    host.order(Order::Spoil([bad; 2]));
    backend.start().expect("it is there");
    let figures = backend.figures();
    let mut samples = vec![Sample::NONE; 4];
    let mut measured = 0;
    for _ in 0..400 {
        std::thread::sleep(Duration::from_secs_f64(1.0 / RATE_HZ));
        match backend.exchange(&[0.1, 0.2, 0.3, 0.4], &mut samples) {
            Ok(()) => {}
            Err(error) => assert!(matches!(error, BackendError::Timeout { .. }), "{error}"),
        }
        for sample in samples.iter().filter(|sample| sample.current_a.is_finite()) {
            // 6.5 V on 9 to 12 ohms: whatever the line does to a frame, no other number comes out of it.
            assert!((0.3..1.0).contains(&sample.current_a), "{sample:?}");
            measured += 1;
        }
    }
    assert!(measured > 0 && figures.damaged() > 0 && figures.late() > 0, "{measured} {figures:?}");
    assert!(figures.answered() < figures.sent(), "{figures:?}");
}

/// A started backend, its front-end, and one period after the other until something holds.
struct Driven {
    backend: SerialBackend,
    host: Host,
    duty: [f64; 4],
    samples: [Sample; 4],
}

impl Driven {
    fn new(rig: &Rig, folder: &tempfile::TempDir) -> Driven {
        let host = host(rig, folder, [Spoilt::default(); 2]);
        let mut backend = SerialBackend::connect(rig).unwrap_or_else(|error| panic!("{error}"));
        backend.start().expect("it is there");
        Driven { backend, host, duty: [0.0; 4], samples: [Sample::NONE; 4] }
    }

    fn exchange(&mut self) -> Result<(), BackendError> {
        std::thread::sleep(Duration::from_secs_f64(1.0 / RATE_HZ));
        self.backend.exchange(&self.duty, &mut self.samples)
    }

    fn until(&mut self, what: &str, is_so: impl Fn(&Driven, Result<(), BackendError>) -> bool) {
        let so = (0..PATIENCE).any(|_| {
            let answer = self.exchange();
            is_so(self, answer)
        });
        assert!(so, "{what}: {:?} {:?}", self.samples, self.backend.stop_inputs());
    }

    /// Resets a channel, again and again, as a client does where that comes before the mending.
    fn reset_until(&mut self, channel: usize, is_so: impl Fn(&Driven) -> bool) {
        let so = (0..PATIENCE).any(|_| {
            self.backend.clear(channel);
            let _ = self.exchange();
            is_so(self)
        });
        assert!(so, "channel {channel} is not reset: {:?}", self.samples);
    }
}

#[test]
fn what_flows_with_duty_0_is_sampled_and_a_stage_that_conducts_loses_its_supply() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rig = rig(&folder);
    rig.backend.enable.signal = EnableSignal::Level;
    let mut driven = Driven::new(&rig, &folder);
    let dark = |driven: &Driven, channel: usize| driven.samples[channel].current_a;
    driven.until("nothing flows", |driven, _| dark(driven, 1).abs() < 0.01 && driven.samples[1].v3_v.abs() < 0.1);
    driven.host.order(Order::Fault(1, FaultKind::StageOn));
    // 6.5 V on 9 to 12 ohms.
    driven.until("it is seen", |driven, _| dark(driven, 1) > 0.3);
    assert!(driven.samples[1].v3_v > 3.0, "{:?}", driven.samples);
    let stage = Err(BackendError::Channel { channel: 1, fault: ChannelFault::Stage });
    driven.until("the front-end sees it as well", |_, answer| answer == stage);
    // It has taken the supply of all by itself.
    driven.duty[0] = 0.2;
    driven.until("nothing flows in any wire", |driven, _| dark(driven, 0).abs() < 0.01);
    driven.duty[0] = 0.0;
    // Reset while it still conducts, which nobody can know without a supply.
    driven.backend.clear(1);
    driven.until("it conducts again", |driven, _| dark(driven, 1) > 0.3);
    driven.until("and is found again", |_, answer| answer == stage);
    driven.host.order(Order::Whole(1, FaultKind::StageOn));
    driven.reset_until(1, |driven| driven.backend.failure(1).is_none() && dark(driven, 1).abs() < 0.01);
}

#[test]
fn channels_that_fail_at_once_are_all_told_and_stay_so_until_each_is_reset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rig = rig(&folder);
    let mut driven = Driven::new(&rig, &folder);
    let places = [1, 3].map(|channel| rig.front_end_index(channel).expect("a channel of the rig") as u8);
    driven.host.order(Order::Break(places[0], DeviceFault::StageHot));
    driven.host.order(Order::Break(places[1], DeviceFault::Stage));
    let failures = |driven: &Driven| [0, 1, 2, 3].map(|channel| driven.backend.failure(channel));
    let both = [None, Some(ChannelFault::OverTemperature), None, Some(ChannelFault::Stage)];
    driven.until("both are told", |driven, answer| answer.is_err() && failures(driven) == both);
    for place in places {
        driven.host.order(Order::Mend(place));
    }
    for _ in 0..20 {
        let _ = driven.exchange();
        assert_eq!(failures(&driven), both, "nothing but a reset clears them");
    }
    driven.reset_until(1, |driven| failures(driven) == [None, None, None, both[3]]);
    driven.reset_until(3, |driven| failures(driven) == [None; 4]);
}

#[test]
fn a_cut_takes_the_supply_of_all_and_a_restore_gives_it_back() {
    for signal in [EnableSignal::Level, EnableSignal::Pulses] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut rig = rig(&folder);
        rig.backend.enable.signal = signal;
        rig.backend.enable.dropout_s = 0.5;
        let mut driven = Driven::new(&rig, &folder);
        driven.duty = [0.1; 4];
        let flows = |driven: &Driven| driven.samples.iter().all(|sample| sample.current_a > 0.3);
        driven.until("it is driven", |driven, _| flows(driven));
        assert!(driven.backend.cut() && driven.backend.cut(), "there is a line");
        driven.until("nothing flows", |driven, _| driven.samples.iter().all(|sample| sample.current_a.abs() < 0.01));
        for _ in 0..5 {
            let _ = driven.exchange();
            assert!(!flows(&driven), "{signal:?}");
        }
        driven.backend.restore();
        driven.until("it is driven again", |driven, _| flows(driven));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut driven = Driven::new(&rig(&folder), &folder);
    assert!(!driven.backend.cut(), "this rig has none");
    assert_eq!(driven.backend.stop_inputs(), None);
}

#[test]
fn an_emergency_stop_is_open_until_the_front_end_says_otherwise() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rig = rig(&folder);
    rig.backend.estop.fitted = true;
    let mut driven = Driven::new(&rig, &folder);
    assert_eq!(driven.backend.stop_inputs(), Some(StopInputs::OPEN), "nobody has said anything");
    let is_closed = |driven: &Driven| driven.backend.stop_inputs().is_some_and(|inputs| inputs.is_closed);
    driven.until("it is closed", |driven, _| is_closed(driven));
    driven.duty = [0.1; 4];
    driven.until("it is driven", |driven, _| driven.host.put_out(0) > 0.0);
    driven.host.order(Order::Fault(0, FaultKind::EstopOpen));
    driven.until("it is open", |driven, _| !is_closed(driven));
    // The duties are still asked for.
    for _ in 0..20 {
        let _ = driven.exchange();
        assert!((0..4).all(|place| driven.host.put_out(place) == 0.0) && !is_closed(&driven));
    }
    driven.host.order(Order::Fault(0, FaultKind::EstopReset));
    driven.host.order(Order::Whole(0, FaultKind::EstopOpen));
    let closed = Some(StopInputs { is_closed: true, is_reset_pressed: true });
    driven.until("it is closed, and its button pressed", |driven, _| driven.backend.stop_inputs() == closed);
    driven.until("it is driven", |driven, _| driven.host.put_out(0) > 0.0);
    // What is not heard any more is open.
    driven.host.order(Order::Disconnect);
    driven.until("it is open", |driven, _| !is_closed(driven));
    driven.host.order(Order::Connect);
    driven.until("it is closed", |driven, _| is_closed(driven));
}

#[test]
fn an_older_front_end_is_called_what_it_is() {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&master).and_then(|()| unlockpt(&master)).expect("it is ours");
    let path = ptsname(&master, Vec::new()).expect("it has a name").into_string().expect("in ASCII");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rig = rig(&folder);
    rig.backend.serial.port = Some(path);
    // A firmware of protocol 1, which drops all frames but those of its own version, and answers a hello.
    let old = std::thread::spawn(move || {
        let mut decoder = Decoder::<MAX_BODY>::new();
        let mut buffer = [0; 256];
        loop {
            let count = rustix::io::read(&master, &mut buffer).unwrap_or(0);
            for byte in &buffer[..count] {
                let nonce = match decoder.push(*byte) {
                    Some(Ok([1, 1, nonce @ ..])) => nonce.to_vec(),
                    _ => continue,
                };
                // An identification of it without a channel; the stuffing is that of a hello in its version, so this one is built
                // from the same pieces.
                let mut line = [0; 64];
                let nonce = u32::from_le_bytes(nonce.try_into().expect("four bytes"));
                let length = encode_hello(1, nonce, &mut line).expect("it fits");
                let _ = rustix::io::write(&master, &line[..length]);
                return master;
            }
        }
    });
    let error = SerialBackend::connect(&rig).expect_err("another protocol");
    drop(old.join());
    let said = error.to_string();
    assert!(said.ends_with("speaks protocol 1, this driver 2: flash the firmware of this release"), "{said}");
}

#[test]
fn what_does_not_fit_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rig = rig(&folder);
    let says = |rig: &Rig| match SerialBackend::connect(rig) {
        Ok(_) => "connected".to_string(),
        Err(error) => error.to_string(),
    };
    assert!(says(&rig).contains("front-end cannot be opened: No such file"), "{}", says(&rig));
    let _host = host(&rig, &folder, [Spoilt::default(); 2]);

    let mut other = rig.clone();
    other.rate_hz = 500.0;
    assert!(says(&other).contains("keeps 200.0 to 200.0 Hz, rig.rate_hz is 500.0"), "{}", says(&other));
    let mut other = rig.clone();
    other.channels[2].backend.serial.index = Some(9);
    assert!(says(&other).contains("has 4 channels, the rig needs 10"), "{}", says(&other));
    let mut other = rig.clone();
    other.channels[1].adc.voltage_range_v *= 2.0;
    assert!(says(&other).contains("adc.voltage_range_v is 20.0000, the front-end's converter has 10.0000"));
    let mut other = rig.clone();
    other.backend.enable.signal = EnableSignal::Pulses;
    assert!(says(&other).contains("has no enable pin, backend.enable.signal asks for one"), "{}", says(&other));
    let mut other = rig.clone();
    other.backend.estop.fitted = true;
    assert!(says(&other).contains("has no pins for an emergency stop"), "{}", says(&other));
    let mut other = rig.clone();
    other.backend.serial.watchdog_periods = 201;
    assert!(says(&other).contains("goes off after 1000 ms of silence at the latest"), "{}", says(&other));

    let taken = SerialBackend::connect(&rig).unwrap_or_else(|error| panic!("{error}"));
    assert!(taken.front_end().ends_with(", started after power-on"), "{}", taken.front_end());
    assert!(
        !taken.output_name(0).unwrap_or_default().contains("started"),
        "its outputs are the same however it started"
    );
    assert!(matches!(SerialBackend::connect(&rig), Err(Error::Taken { .. })), "one driver a line");
    let dying = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        drop(taken);
    });
    let next = SerialBackend::connect(&rig);
    assert!(next.is_ok(), "a killed driver may hold its line a moment longer: {:?}", next.err());
    dying.join().expect("the line was let go");
    drop(next);
    let mut file = rig.clone();
    file.backend.serial.port = Some("/dev/null".into());
    assert_eq!(says(&file), "/dev/null is no serial line");
    let (_nobody, path) = (tempfile::tempdir(), "/dev/ptmx");
    file.backend.serial.port = Some(path.into());
    assert!(says(&file).contains(path), "{}", says(&file));
}

/// Exchanges until something is put out and measured, or for a while with nothing.
fn exchanged(line: &mut Line, backend: &mut SerialBackend, duty: f64) {
    let mut samples = [Sample::NONE; 4];
    for period in 0.. {
        line.pace();
        let _ = backend.exchange(&[duty; 4], &mut samples);
        let is_measured = samples.iter().all(|sample| sample.current_a.is_finite() && sample.current_a > 0.0);
        if if duty > 0.0 { is_measured } else { period == 10 } {
            return;
        }
        assert!(period < PATIENCE, "{samples:?}");
    }
}

#[test]
fn a_front_end_tells_each_driver_who_has_used_it_since() {
    let mut line = Line::new(SamplingCircuit::SeparateTaps);
    let mut first = line.backend();
    first.start().unwrap();
    let Past { mark, unused: Unused::For(_) } = first.past(0) else { panic!("{:?}", first.past(0)) };
    assert_eq!(mark, 0, "nobody has, since it started");
    exchanged(&mut line, &mut first, 0.0);
    assert_eq!(first.mark(0), 0, "and still nobody has");
    exchanged(&mut line, &mut first, 0.05);
    let mark = first.mark(0);
    assert_ne!(mark, 0);
    drop(first);

    // One that only looks changes nothing, and says for how long nobody has.
    std::thread::sleep(Duration::from_millis(300));
    let connect = |line: &Line| SerialBackend::connect(&line.rig).unwrap_or_else(|error| panic!("{error}"));
    let mut looks = connect(&line);
    looks.start().unwrap();
    assert!(
        matches!(looks.past(1), Past { mark: found, unused: Unused::For(s) } if found == mark && s >= 0.3),
        "{:?}",
        looks.past(1)
    );
    exchanged(&mut line, &mut looks, 0.0);
    assert_eq!(looks.mark(1), mark);
    drop(looks);

    let mut other = connect(&line);
    other.start().unwrap();
    assert_eq!(other.past(0).mark, mark);
    exchanged(&mut line, &mut other, 0.05);
    let theirs = other.mark(0);
    assert!(theirs != mark && theirs != 0 && other.regained().is_none());

    // Unplugged and back, and nobody else was there.
    let away_and_back = |line: &mut Line, backend: &mut SerialBackend, back: &mut dyn FnMut(&mut Line)| {
        let mut samples = [Sample::NONE; 4];
        line.host().order(Order::Disconnect);
        while backend.exchange(&[0.0; 4], &mut samples).is_ok() {
            line.pace();
        }
        back(line);
        let mut regained = None;
        for _ in 0..PATIENCE {
            line.pace();
            let exchanged = backend.exchange(&[0.0; 4], &mut samples);
            regained = regained.or(backend.regained());
            if exchanged.is_ok() {
                return regained;
            }
        }
        panic!("it does not come back");
    };
    assert_eq!(away_and_back(&mut line, &mut other, &mut |line| line.host().order(Order::Connect)), None);
    // Another one's place, or one that has restarted, knows nothing of it.
    let regained = away_and_back(&mut line, &mut other, &mut |line| {
        line.host = None;
        line.host = Some(host(&line.rig, &line.folder, [Spoilt::default(); 2]));
    });
    assert!(regained.is_some_and(|unused_s| unused_s < 60.0), "{regained:?}");
    assert_eq!(other.mark(0), 0);
}
