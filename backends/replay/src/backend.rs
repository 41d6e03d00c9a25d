//! The backend that returns recorded samples.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use sinew_backend::{Backend, BackendError, ChannelFault, Sample, Zero, check_exchange};
use sinew_ring::{Consumer, Producer, ring};
use sinew_threads::Thread;

use crate::source::{Cycle, Cycles, Source};

/// Channels' states that are read ahead; at least [`AHEAD_CYCLES`] cycles.
const AHEAD_STATES: usize = 1 << 14;
const AHEAD_CYCLES: usize = 256;
/// How often the reader looks for room.
const ROOM: Duration = Duration::from_micros(200);
/// Longest an `exchange` waits for the disk before it gives up. Nothing is heated meanwhile: there is no wire.
const PATIENCE: Duration = Duration::from_secs(10);

/// How the backend failed in a recorded cycle: as a whole, or the lowest channel alone.
fn error(cycle: &impl Cycle, channels: usize) -> Option<BackendError> {
    (0..channels).find_map(|channel| cycle.error(channel))
}

/// A recording as a backend: it brings back what was sampled then, period by period, whatever duty it is given.
///
/// Periods are those of the recording: one it has no cycle of (missed then, or lost by the recorder) is all NaN, and
/// [`Backend::missed`] passes over recorded periods. Where the wire was driven then and is not now, or the other way round,
/// there is no sample of it, and what was read of the supply is all that is left. At the end of the recording `exchange`
/// answers [`BackendError::Unavailable`]. Samples are read ahead by a thread of its own between `start` and `stop`.
#[derive(Debug)]
pub struct ReplayBackend<S: Source> {
    source: S,
    channels: usize,
    /// What the reader leaves for the loop.
    ahead: Option<Consumer<S::Cycle>>,
    /// Whether the reader has come to the end, or to trouble.
    is_read: Arc<AtomicBool>,
    /// The first trouble of the reader.
    trouble: Arc<Mutex<Option<S::Error>>>,
    /// The cycle whose period is present or yet to come.
    recorded: S::Cycle,
    /// Whether `recorded` holds one.
    is_there: bool,
    /// Number of the present period; `None` before the first exchange.
    period: Option<u64>,
    missed: u64,
    /// The duty in force in the period just past, and the one in force then; NaN where that is not known.
    applied: Vec<f64>,
    recorded_applied: Vec<f64>,
    /// The duty a cycle of the recording decided on, which went out with the one after it.
    recorded_next: Vec<f64>,
    /// Number of the last recorded cycle that was passed.
    passed: u64,
    /// Whether the present cycle was recorded with an error.
    failed: bool,
}

impl<S: Source> ReplayBackend<S> {
    /// Of a recording.
    pub fn new(source: S) -> ReplayBackend<S> {
        let channels = source.channels();
        ReplayBackend {
            source,
            channels,
            ahead: None,
            is_read: Arc::default(),
            trouble: Arc::new(Mutex::new(None)),
            recorded: S::Cycle::new(channels),
            is_there: false,
            period: None,
            missed: 0,
            applied: vec![0.0; channels],
            recorded_applied: vec![f64::NAN; channels],
            recorded_next: vec![f64::NAN; channels],
            passed: 0,
            failed: false,
        }
    }

    /// Lets the next recorded cycle be present, however many periods later it is: how many went by without one, and the
    /// recorded cycle, whose samples the next [`Backend::exchange`] will bring. `None` at the end.
    ///
    /// # Errors
    /// What kept the recording from being read on.
    pub fn advance(&mut self) -> Result<Option<(u64, &S::Cycle)>, S::Error> {
        let at = self.period;
        if at.is_some_and(|at| self.is_there && self.recorded.period() <= at) {
            self.pass();
        }
        if !self.is_there && !self.take() {
            return self.trouble().map_or(Ok(None), Err);
        }
        let between = at.map_or(0, |at| self.recorded.period().saturating_sub(at + 1));
        Ok(Some((between, &self.recorded)))
    }

    /// Whether the reader has died: then the recording goes on where [`ReplayBackend::advance`] says that it ends.
    pub fn has_lost_its_reader(&self) -> bool {
        self.ahead.as_ref().is_some_and(Consumer::is_alone) && !self.is_read.load(Ordering::Acquire)
    }

    /// The reader's error, reported once.
    pub fn trouble(&self) -> Option<S::Error> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// The recorded cycle that [`ReplayBackend::advance`] returned last.
    pub fn recorded(&self) -> &S::Cycle {
        &self.recorded
    }

    /// Takes the next recorded cycle from the reader; false at the end of the recording.
    fn take(&mut self) -> bool {
        let Some(ahead) = &mut self.ahead else { return false };
        let mut waited_from = None;
        loop {
            // Read before the queue, so that cycles read between the two are not lost.
            let over = ahead.is_alone();
            let recorded = &mut self.recorded;
            if ahead.take(|cycle| std::mem::swap(recorded, cycle)).is_some() {
                self.is_there = true;
                return true;
            }
            if over || waited_from.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
                return false;
            }
            thread::yield_now();
        }
    }

    /// Leaves the present recorded cycle behind: what it put out is in force in the period after it.
    fn pass(&mut self) {
        let number = self.recorded.number();
        let follows = number == self.passed + 1;
        let whole = error(&self.recorded, self.channels).filter(|error| error.channel().is_none()).is_some();
        for channel in 0..self.channels {
            let failed = whole || self.recorded.error(channel).is_some();
            self.recorded_applied[channel] = match (failed, number) {
                (true, _) | (_, 1) => 0.0,
                _ if follows => self.recorded_next[channel],
                _ => f64::NAN,
            };
            self.recorded_next[channel] = self.recorded.duty(channel);
        }
        self.passed = number;
        self.is_there = false;
    }

    /// Whether the recorded cycle follows the one passed last: only then is it known what was in force in between.
    fn follows(&self) -> bool {
        self.recorded.number() == self.passed + 1
    }

    fn fail(&mut self, samples: &mut [Sample], error: BackendError) -> Result<(), BackendError> {
        samples.fill(Sample::NONE);
        self.applied.fill(0.0);
        Err(error)
    }
}

/// Keeps a trouble in mind, the first one.
fn note<E>(trouble: &Mutex<Option<E>>, error: E) {
    trouble.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
}

/// Reads a recording ahead of the loop until it ends or the backend is dropped. What became of that is known before `ahead` is gone.
fn read_ahead<C: Cycles>(
    cycles: C,
    mut ahead: Producer<C::Cycle>,
    is_read: &AtomicBool,
    trouble: &Mutex<Option<C::Error>>,
) {
    let mut is_struck = false;
    let read = cycles.each(&mut |read| {
        is_struck = sinew_threads::is_struck();
        if is_struck {
            return false;
        }
        while !ahead.put(|cycle| cycle.copy_from(read)) {
            if ahead.is_alone() {
                return false;
            }
            thread::sleep(ROOM);
        }
        true
    });
    if let Err(error) = read {
        note(trouble, error);
    }
    is_read.store(!is_struck, Ordering::Release);
}

impl<S: Source> Backend for ReplayBackend<S> {
    fn channels(&self) -> usize {
        self.channels
    }

    fn start(&mut self) -> Result<(), BackendError> {
        let _ = self.stop();
        let unavailable = BackendError::Unavailable { os_error: 0 };
        let cycles = match self.source.cycles() {
            Ok(cycles) => cycles,
            Err(error) => {
                note(&self.trouble, error);
                return Err(unavailable);
            }
        };
        let (channels, trouble) = (self.channels, self.trouble.clone());
        let room = AHEAD_CYCLES.max(AHEAD_STATES / channels.max(1));
        let (ahead, ahead_out) = ring((0..room).map(|_| S::Cycle::new(channels)));
        self.is_read = Arc::default();
        let (is_read, over) = (self.is_read.clone(), self.is_read.clone());
        let start = Thread::Reader.start().ends_when(move || over.load(Ordering::Acquire));
        let reader = start.spawn(move || read_ahead(cycles, ahead, &is_read, &trouble));
        if let Err(error) = reader {
            return Err(BackendError::Unavailable { os_error: error.raw_os_error().unwrap_or(0) });
        }
        self.ahead = Some(ahead_out);
        (self.is_there, self.period, self.missed, self.passed) = (false, None, 0, 0);
        self.recorded_applied.fill(f64::NAN);
        self.recorded_next.fill(f64::NAN);
        Ok(())
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        if self.ahead.is_none() {
            return Err(BackendError::NotStarted);
        }
        if let Err(error) = check_exchange(self.channels, duty, samples) {
            return self.fail(samples, error);
        }
        let missed = std::mem::take(&mut self.missed);
        let present = self.period.map(|period| period.saturating_add(1 + missed));
        // The first exchange begins the recording, wherever that begins.
        while !self.is_there || present.is_some_and(|present| self.recorded.period() < present) {
            if self.is_there {
                self.pass();
            }
            if !self.take() {
                return self.fail(samples, BackendError::Unavailable { os_error: 0 });
            }
        }
        let present = present.unwrap_or_else(|| self.recorded.period());
        self.period = Some(present);

        let is_recorded = self.recorded.period() == present;
        let known = is_recorded && (self.follows() || self.recorded.number() == 1);
        for (channel, sample) in samples.iter_mut().enumerate() {
            *sample = if is_recorded { self.recorded.sample(channel) } else { Sample::NONE };
            let (now, then) = (self.applied[channel] > 0.0, self.recorded_applied[channel]);
            let driven_then = match self.recorded.number() {
                1 => Some(false),
                _ if known && !then.is_nan() => Some(then > 0.0),
                _ => None,
            };
            // The samples of a wire driven with another duty are unknown.
            if driven_then.unwrap_or(true) != now {
                *sample = Sample { supply_v: sample.supply_v, ..Sample::NONE };
            }
        }
        let error = error(&self.recorded, self.channels).filter(|_| is_recorded);
        self.failed = error.is_some();
        self.applied.copy_from_slice(duty);
        match error {
            None => Ok(()),
            Some(error @ BackendError::Channel { .. }) => {
                for (channel, sample) in samples.iter_mut().enumerate() {
                    if self.recorded.error(channel).is_some() {
                        *sample = Sample::NONE;
                        self.applied[channel] = 0.0;
                    }
                }
                Err(error)
            }
            Some(error) => self.fail(samples, error),
        }
    }

    fn missed(&mut self, periods: u64) {
        self.missed = self.missed.saturating_add(periods);
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        match self.recorded.error(channel).filter(|_| self.failed)? {
            BackendError::Channel { fault, .. } => Some(fault),
            _ => None,
        }
    }

    fn silence_s(&self) -> Option<f64> {
        // there is no wire
        Some(0.0)
    }

    /// As the driver that recorded it began, or one like it.
    fn is_at_rest(&self) -> bool {
        true
    }

    fn stop(&mut self) -> Zero {
        // The reader detects the closed channel and ends by itself.
        self.ahead = None;
        self.applied.fill(0.0);
        Zero::Confirmed
    }
}
