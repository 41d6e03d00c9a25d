//! `sinew-trust drive`: a driver with an output log and fault injection by commands on its standard input; one
//! that drives hardware gets none: there the line or the kernel injects the faults.

use std::io::BufRead;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use sinew_backend::Backend;
use sinew_driver::{Driver, Options};
use sinew_linux_backend::{LinuxRig, Settings};
use sinew_rig::{BackendKind, FaultKind, Rig};
use sinew_serial_backend::SerialBackend;
use sinew_sim_backend::{FaultHandle, SimulatedRig};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

use crate::failure::{Failure, unexpected};
use crate::kind::between;
use crate::witness::{Mischief, Watched};

/// What to drive.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The rig file.
    rig: PathBuf,
    /// Where the witness writes.
    log: PathBuf,
    /// Ends by itself after so long, s.
    #[arg(long = "for", default_value_t = 300.0)]
    duration_s: f64,
    /// Writes the run's report.
    #[arg(long)]
    report: Option<PathBuf>,
    /// Breaks and mends something at random all the time, drawn from this seed.
    #[arg(long, value_name = "SEED")]
    random_faults: Option<u64>,
}

/// A log that panics when it is told to: the desk's thread writes to it when a fault is latched.
struct Touchy;

static TOUCHY: AtomicBool = AtomicBool::new(false);

impl Subscriber for Touchy {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }
    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event<'_>) {
        assert!(!TOUCHY.load(Ordering::Relaxed), "asked to panic");
    }
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// Drives until its time is over, it is asked to stop, or it breaks.
///
/// # Errors
/// A driver that does not start, or a report that cannot be written.
pub fn drive(args: &Args) -> Result<(), Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(error.to_string());
    tracing::subscriber::set_global_default(Touchy).map_err(|e| wrong(&e))?;
    let rig = Rig::load(&args.rig).map_err(|e| wrong(&e))?;
    let (backend, faults): (Box<dyn Backend>, _) = match rig.backend.kind {
        BackendKind::Simulated => {
            let wires = SimulatedRig::new(&rig).map_err(|e| wrong(&e))?;
            let faults = wires.faults();
            (Box::new(wires), Some(faults))
        }
        BackendKind::Serial => (Box::new(SerialBackend::connect(&rig).map_err(|e| wrong(&e))?), None),
        BackendKind::Linux => (Box::new(LinuxRig::new(Settings::of_rig(&rig)).map_err(|e| wrong(&e))?), None),
        #[allow(unreachable_patterns, reason = "until there is a backend whose wires nobody here can damage")]
        other => {
            return Err(Failure::Unexpected(format!("nothing here injects faults behind backend {}", other.word())));
        }
    };
    let mischief = Arc::new(Mischief::default());
    let watched = Watched::new(backend, &args.log, mischief.clone())?;
    let asked = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::flag::register(signal, asked.clone())?;
    }
    let options = Options { duration_s: Some(args.duration_s), simulated: faults.is_some(), ..Options::default() };
    let driver = Driver::start(&rig, watched, options).map_err(|e| wrong(&e))?;
    let names: Vec<String> = rig.channels.iter().map(|channel| channel.name.clone()).collect();
    if let Some(faults) = faults {
        if let Some(seed) = args.random_faults {
            let (faults, channels) = (faults.clone(), rig.channels.len());
            std::thread::spawn(move || break_at_random(seed, &faults, channels));
        }
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if let Err(failure) = obey(&line, &names, &faults, &mischief) {
                    eprintln!("{failure}");
                }
            }
        });
    }
    while driver.is_running() && !asked.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(1));
    }
    driver.stop();
    let report = driver.join();
    if let Some(path) = &args.report {
        std::fs::write(path, serde_json::to_string(&report).map_err(std::io::Error::other)?)?;
    }
    Ok(())
}

/// Some time after some time, something breaks for some time.
fn break_at_random(seed: u64, faults: &FaultHandle, channels: usize) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    loop {
        let (_, kind) = FaultKind::ALL[rng.random_range(0..FaultKind::ALL.len())];
        // It would take everything off until the next start, and the rest of the run would be a quiet one.
        if kind == FaultKind::StageOn {
            continue;
        }
        let channel = rng.random_range(0..channels);
        // Everything at once is rare.
        let whole = kind == FaultKind::BackendError && rng.random_range(0..20) == 0;
        match kind.value_range() {
            _ if whole => faults.set_backend_error(true),
            Some((low, high, _)) => drop(faults.set_sized(channel, kind, between(&mut rng, low, high.min(10.0)))),
            None => drop(faults.set(channel, kind)),
        }
        std::thread::sleep(Duration::from_secs_f64(between(&mut rng, 0.01, 1.0)));
        faults.clear(channel, kind);
        if whole {
            faults.set_backend_error(false);
        }
        std::thread::sleep(Duration::from_secs_f64(between(&mut rng, 0.05, 1.0)));
    }
}

/// `break CHANNEL KIND [SIZE]`, `mend`, `fail`, `panic`, `panic-helper`, `eat`, `stall MS`.
fn obey(line: &str, names: &[String], faults: &FaultHandle, mischief: &Mischief) -> Result<(), Failure> {
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        ["break", channel, kind, ref size @ ..] => {
            let channel = names.iter().position(|name| name == channel);
            let kind = FaultKind::ALL.iter().find(|(word, _)| *word == kind);
            let (Some(channel), Some((_, kind))) = (channel, kind) else {
                return unexpected(format!("what is {line:?}?"));
            };
            match size.first().and_then(|size| size.parse().ok()) {
                Some(size) => faults.set_sized(channel, *kind, size),
                None => faults.set(channel, *kind),
            };
        }
        ["eat"] => {
            // Until the kernel's OOM killer ends it.
            let mut eaten = Vec::new();
            loop {
                eaten.push(vec![1u8; 1 << 20]);
                std::hint::black_box(&eaten);
            }
        }
        ["mend"] => faults.clear_all(),
        ["fail"] => faults.set_backend_error(true),
        ["panic"] => mischief.panic.store(true, Ordering::Relaxed),
        ["panic-helper"] => {
            TOUCHY.store(true, Ordering::Relaxed);
            faults.set(0, FaultKind::OpenWire);
        }
        ["stall", ms] => {
            let ms: f64 = ms.parse().map_err(|_| Failure::Unexpected(format!("what is {line:?}?")))?;
            mischief.stall_ns.store((ms * 1e6) as u64, Ordering::Relaxed);
        }
        _ => return unexpected(format!("what is {line:?}?")),
    }
    Ok(())
}
