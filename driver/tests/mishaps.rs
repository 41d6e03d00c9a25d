//! A driver around code that violates its contract: backends that panic or write nothing, a helper's thread that dies.
//!
//! A separate binary, because its log, of which a process has only one, panics.

#[path = "integration/common.rs"]
mod common;

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use common::{Fake, Mishap, rig};
use sinew_backend::{Backend, BackendError, Sample, Zero};
use sinew_driver::report::Ending;
use sinew_driver::{Driver, Error, Options};
use sinew_rig::Pace;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

/// A rig name of this test's own.
fn name(test: &str) -> String {
    format!("mishap-{test}-{}", std::process::id())
}

/// A log that panics over a word.
struct Touchy;

/// The flag of the fault it cannot stand.
const WORD: &str = "supply_dip";

impl Visit for Touchy {
    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
    fn record_str(&mut self, _: &Field, value: &str) {
        assert_ne!(value, WORD, "the script says: panic");
    }
}

impl Subscriber for Touchy {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }
    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, event: &Event<'_>) {
        event.record(&mut Touchy);
    }
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

#[test]
fn a_helper_that_panics_ends_the_run_with_outputs_at_zero_and_the_report_says_so() {
    tracing::subscriber::set_global_default(Touchy).unwrap();
    let rig = rig(&name("helper"), 1, 1000.0);
    let mut fake = Fake::new(&rig);
    fake.script = vec![(30..60, 0, Mishap::SupplyDip)];
    let watch = fake.watch.clone();
    let handle = Driver::start(&rig, fake, Options { private: true, ..Options::default() }).unwrap();
    let start = Instant::now();
    while handle.is_running() {
        assert!(start.elapsed() < Duration::from_secs(60), "it runs on without its helper");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(watch.stopped.load(Ordering::Relaxed), "outputs are zero");
    assert_eq!(handle.join().ended, Ending::Panicked);
}

/// A backend that panics while it starts.
struct Hasty(Fake);

impl Backend for Hasty {
    fn channels(&self) -> usize {
        self.0.channels()
    }
    fn start(&mut self) -> Result<(), BackendError> {
        panic!("the script says: panic")
    }
    fn exchange(&mut self, _: &[f64], _: &mut [Sample]) -> Result<(), BackendError> {
        Err(BackendError::NotStarted)
    }
    fn silence_s(&self) -> Option<f64> {
        self.0.silence_s()
    }
    fn stop(&mut self) -> Zero {
        self.0.stop()
    }
}

#[test]
fn a_backend_that_panics_while_it_starts_is_stopped() {
    let rig = rig(&name("start"), 1, 1000.0);
    let fake = Fake::new(&rig);
    let watch = fake.watch.clone();
    let error = Driver::start(&rig, Hasty(fake), Options { private: true, ..Options::default() }).unwrap_err();
    assert!(matches!(error, Error::Thread(_)), "{error}");
    assert!(watch.stopped.load(Ordering::Relaxed), "outputs are zero");
}

/// A backend that says all is well and leaves the samples as they are.
struct Silent {
    fake: Fake,
    scratch: Vec<Sample>,
    periods: u64,
}

impl Backend for Silent {
    fn channels(&self) -> usize {
        self.fake.channels()
    }
    fn start(&mut self) -> Result<(), BackendError> {
        self.fake.start()
    }
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        self.periods += 1;
        let samples = if self.periods > 50 { &mut self.scratch[..] } else { samples };
        self.fake.exchange(duty, samples)
    }
    fn silence_s(&self) -> Option<f64> {
        self.fake.silence_s()
    }
    fn is_at_rest(&self) -> bool {
        self.fake.is_at_rest()
    }
    fn stop(&mut self) -> Zero {
        self.fake.stop()
    }
}

#[test]
fn a_sample_nobody_wrote_is_none_and_not_the_one_before() {
    let mut rig = rig(&name("silent"), 1, 1000.0);
    // On a simulated clock no period is missed.
    rig.simulation.pace = Pace::AsFastAsPossible;
    let backend = Silent { fake: Fake::new(&rig), scratch: vec![Sample::NONE], periods: 0 };
    let options = Options { private: true, duration_s: Some(0.06), ..Options::default() };
    let report = Driver::start(&rig, backend, options).unwrap().join();
    assert_eq!(report.faults.iter().map(|fault| fault.flag).collect::<Vec<_>>(), ["no_sample"]);
    assert!(report.channel[0].length_m.is_nan(), "{:?}", report.channel);
}
