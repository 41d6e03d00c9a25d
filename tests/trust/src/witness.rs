//! A driver's process with an output log (the witness): the backend's own thread logs every output to a file
//! that outlives the process. So the log of a killed driver shows when it last powered a wire.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};
use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, StopInputs, Truth, Zero};

use crate::failure::Failure;

/// CLOCK_MONOTONIC now, ns.
pub fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// What a driver's backend is made to do, from another thread.
#[derive(Debug, Default)]
pub struct Mischief {
    /// Panic in the next exchange.
    pub panic: AtomicBool,
    /// Take so long, ns, in the next exchange.
    pub stall_ns: AtomicU64,
}

/// A backend whose outputs are written down. A record is the time (ns, CLOCK_MONOTONIC, eight bytes) and the duties (`f64`) that
/// went out then, all in the machine's own order of bytes.
#[derive(Debug)]
pub struct Watched<B> {
    backend: B,
    file: File,
    record: Vec<u8>,
    mischief: Arc<Mischief>,
}

impl<B: Backend> Watched<B> {
    /// Writes what goes through `backend` to this file.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn new(backend: B, path: &Path, mischief: Arc<Mischief>) -> std::io::Result<Watched<B>> {
        let record = vec![0; 8 * (1 + backend.channels())];
        Ok(Watched { backend, file: File::create(path)?, record, mischief })
    }

    fn write(&mut self, duty: impl Iterator<Item = f64>) {
        let (time, rest) = self.record.split_at_mut(8);
        time.copy_from_slice(&now_ns().to_ne_bytes());
        for (place, duty) in rest.chunks_exact_mut(8).zip(duty) {
            place.copy_from_slice(&duty.to_ne_bytes());
        }
        // If logging fails the log ends early, and the try fails.
        let _ = self.file.write_all(&self.record);
    }
}

impl<B: Backend> Backend for Watched<B> {
    fn channels(&self) -> usize {
        self.backend.channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.backend.start()
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        if self.mischief.panic.load(Ordering::Relaxed) {
            panic!("asked to panic");
        }
        let exchanged = self.backend.exchange(duty, samples);
        let whole = matches!(exchanged, Err(error) if error.channel().is_none());
        self.write(duty.iter().map(|&duty| if whole { 0.0 } else { duty }));
        let stall_ns = self.mischief.stall_ns.swap(0, Ordering::Relaxed);
        if stall_ns > 0 {
            std::thread::sleep(Duration::from_nanos(stall_ns));
        }
        exchanged
    }

    fn is_due(&mut self) -> bool {
        self.backend.is_due()
    }

    fn missed(&mut self, periods: u64) {
        self.backend.missed(periods);
    }

    fn cut(&mut self) -> bool {
        self.backend.cut()
    }

    fn restore(&mut self) {
        self.backend.restore();
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.backend.stop_inputs()
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.backend.failure(channel)
    }

    fn clear(&mut self, channel: usize) {
        self.backend.clear(channel);
    }

    fn is_confirmed(&self, channel: usize) -> bool {
        self.backend.is_confirmed(channel)
    }

    fn silence_s(&self) -> Option<f64> {
        self.backend.silence_s()
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        self.backend.output_name(channel)
    }

    fn past(&self, channel: usize) -> Past {
        self.backend.past(channel)
    }

    fn mark(&self, channel: usize) -> u64 {
        self.backend.mark(channel)
    }

    fn regained(&self) -> Option<f64> {
        self.backend.regained()
    }

    fn is_at_rest(&self) -> bool {
        self.backend.is_at_rest()
    }

    fn stop(&mut self) -> Zero {
        let zero = self.backend.stop();
        self.write(std::iter::repeat(0.0));
        zero
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        self.backend.truth(channel)
    }
}

/// What went out at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Put {
    /// When, ns on CLOCK_MONOTONIC.
    pub at_ns: u64,
    /// The duties.
    pub duty: Vec<f64>,
}

impl Put {
    /// Whether any wire gets anything.
    pub fn powers(&self) -> bool {
        self.duty.iter().any(|duty| *duty > 0.0)
    }
}

/// Everything a driver of so many channels has put out so far.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path, channels: usize) -> Result<Vec<Put>, Failure> {
    let bytes = std::fs::read(path)?;
    let word = |bytes: &[u8]| bytes.try_into().unwrap_or_default();
    Ok(bytes
        .chunks_exact(8 * (1 + channels))
        .map(|record| Put {
            at_ns: u64::from_ne_bytes(word(&record[..8])),
            duty: record[8..].chunks_exact(8).map(|duty| f64::from_ne_bytes(word(duty))).collect(),
        })
        .collect())
}
