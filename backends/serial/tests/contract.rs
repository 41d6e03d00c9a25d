//! The conformance suite for backends, over a pseudo-terminal with the firmware on the other end.

use std::time::{Duration, Instant};

use sinew_backend::allocations::CountingAllocator;
use sinew_backend::conformance::{Bench, suite};
use sinew_backend::{Backend, BackendError, ChannelFault, Sample};
use sinew_front_end::ChannelFault as DeviceFault;
use sinew_front_end_host::{Host, Options, Order, Spoilt};
use sinew_rig::{BackendKind, Rig, SamplingCircuit};
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
    other.backend.serial.watchdog_periods = 201;
    assert!(says(&other).contains("goes off after 1000 ms of silence at the latest"), "{}", says(&other));

    let taken = SerialBackend::connect(&rig).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(SerialBackend::connect(&rig), Err(Error::Taken { .. })), "one driver a line");
    drop(taken);
    let mut file = rig.clone();
    file.backend.serial.port = Some("/dev/null".into());
    assert_eq!(says(&file), "/dev/null is no serial line");
    let (_nobody, path) = (tempfile::tempdir(), "/dev/ptmx");
    file.backend.serial.port = Some(path.into());
    assert!(says(&file).contains(path), "{}", says(&file));
}
