//! A whole driver, recorded by a client from its first cycle on under commands and faults, is replayed bit for bit.

use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{Memory, replay_all};
use sinew_backend::{Backend, BackendError, Sample, Zero};
use sinew_driver::{Driver, Options, Program};
use sinew_ipc::{Client, Fault, Mode};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::SimulatedRig;

/// A simulated rig that starts when it is told to: the services are there by then, so that nobody misses the first cycle.
struct Gated {
    rig: SimulatedRig,
    open: Receiver<()>,
}

impl Backend for Gated {
    fn channels(&self) -> usize {
        self.rig.channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        let _ = self.open.recv_timeout(Duration::from_secs(60));
        self.rig.start()
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        self.rig.exchange(duty, samples)
    }

    fn missed(&mut self, periods: u64) {
        self.rig.missed(periods);
    }

    fn silence_s(&self) -> Option<f64> {
        self.rig.silence_s()
    }
    fn stop(&mut self) -> Zero {
        self.rig.stop()
    }

    fn is_at_rest(&self) -> bool {
        self.rig.is_at_rest()
    }
}

/// The hexapod with a joint more: two wires that turn a knee.
fn rig() -> Rig {
    let joint = "\n[[channel]]\nname = \"flexor\"\nwire = { diameter_mm = 0.05, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
        drive = { supply_v = 12.0, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\n[[channel]]\nname = \"extensor\"\n\
        wire = { diameter_mm = 0.05, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
        drive = { supply_v = 12.0, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\n[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\n\
        antagonist = \"extensor\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\n";
    let mut rig =
        Rig::parse(&(sinew_rig::HEXAPOD_TOML.to_string() + joint), "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    rig.name = format!("replayed-{}", std::process::id());
    rig.rate_hz = 500.0;
    rig
}

/// Waits for something that must come true; the limit only ends a test that has failed.
fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let since = Instant::now();
    while !is_so() {
        assert!(since.elapsed() < Duration::from_secs(60), "never: {what}");
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_driver_that_was_commanded_and_broken_comes_out_bit_for_bit() {
    let rig = rig();
    let channels = rig.channels.len();
    let simulated = SimulatedRig::new(&rig).unwrap();
    let faults = simulated.faults();
    let (opens, open) = mpsc::channel();
    let name = rig.name.clone();
    let client = thread::spawn(move || {
        let since = Instant::now();
        let client = loop {
            match Client::connect(&name) {
                Ok(client) => break client,
                Err(error) => assert!(since.elapsed() < Duration::from_secs(60), "{error}"),
            }
            thread::sleep(Duration::from_millis(2));
        };
        let mut stream = client.stream().unwrap();
        opens.send(()).unwrap();
        let mut cycles = Vec::new();
        loop {
            match stream.next_within(Duration::from_millis(200)) {
                Ok(Some(cycle)) => cycles.push((*cycle.header, cycle.channels.to_vec())),
                Ok(None) => {}
                Err(_) => return (cycles, stream.lost()),
            }
        }
    });
    let options = Options { program: Some(Program::tripod(18, 1.5)), simulated: true, ..Options::default() };
    let driver = Driver::start(&rig, Gated { rig: simulated, open }, options).unwrap_or_else(|e| panic!("{e}"));
    let commander = Client::connect(&rig.name).unwrap();
    let channel = |name: &str| commander.latest().channel[commander.channel(name).unwrap()];
    let hold = Duration::from_millis(300);
    until("sensors", || commander.latest().channels().iter().all(|channel| channel.mode() != Mode::Waiting));
    commander.set_stroke("flexor", 0.5, Duration::from_secs(2)).unwrap();
    commander.set_stroke("front_left_femur", 0.4, hold).unwrap();
    let _ = commander.set_duty("front_right_femur", 0.2, hold);
    until("motion", || channel("flexor").duty > 0.1);
    let _ = commander.off("front_right_femur");
    assert!(faults.set(4, FaultKind::OpenWire));
    until("the wire's fault", || channel(&rig.channels[4].name).fault() == Some(Fault::OpenWire));
    faults.clear_all();
    let _ = commander.reset(&rig.channels[4].name);
    let from = commander.latest().cycle;
    until("more of the walk", || commander.latest().cycle > from + 200);
    faults.set_backend_error(true);
    until("the backend's fault", || channel("flexor").fault() == Some(Fault::Backend));
    faults.set_backend_error(false);
    for channel in &rig.channels {
        let _ = commander.reset(&channel.name);
    }
    let _ = commander.set_stroke("extensor", 0.6, hold);
    until("four seconds", || commander.latest().cycle > 2000);
    driver.stop();
    let report = driver.join();
    let (cycles, lost) = client.join().unwrap();
    // What a reader too slow for this machine has lost cannot be replayed; everything else has to be.
    if lost > 0 {
        eprintln!("skipped: this reader lost {lost} cycles");
        return;
    }
    assert_eq!((cycles[0].0.cycle, cycles.len() as u64), (1, report.cycles), "every cycle from the first on");
    let seen = |test: &dyn Fn(&sinew_ipc::ChannelState) -> bool| cycles.iter().any(|(_, s)| s.iter().any(test));
    assert!(seen(&|s| s.fault == Fault::OpenWire.code()) && seen(&|s| s.fault == Fault::Backend.code()));
    for mode in [Mode::Length, Mode::Duty, Mode::Off, Mode::Program, Mode::Fault] {
        assert!(seen(&|s| s.mode() == mode), "{mode:?}");
    }
    let missed = cycles.last().unwrap().0.missed;
    let replayed = replay_all(&rig, &Memory { cycles: cycles.into() });
    let found: Vec<_> = (0..channels)
        .flat_map(|c| replayed.comparison().of_channel(c).map(move |(field, d)| (c, field.name, d)).collect::<Vec<_>>())
        .collect();
    assert!(replayed.comparison().is_identical() && replayed.completeness().is_whole(), "{missed} missed: {found:#?}");
}
