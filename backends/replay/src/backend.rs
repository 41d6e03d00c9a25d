//! A recording in the place of power stage and converter.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use sinew_driver::{Backend, BackendError, Sample, check_exchange};
use sinew_ipc::{ChannelState, CycleHeader, HeldCycle};
use sinew_ring::{Consumer, Producer, ring};

use crate::error::Error;
use crate::source::{Cycles, Source};

/// Channels' states that are read ahead; at least [`AHEAD_CYCLES`] cycles.
const AHEAD_STATES: usize = 1 << 14;
const AHEAD_CYCLES: usize = 256;
/// How often the reader looks for room.
const ROOM: Duration = Duration::from_micros(200);
/// Longest an `exchange` waits for the disk before it gives up. Nothing is heated meanwhile: there is no wire.
const PATIENCE: Duration = Duration::from_secs(10);

/// Number of a cycle's period, from the driver's start: cycles that ran and those that were missed.
fn period(cycle: &HeldCycle) -> u64 {
    cycle.header.cycle + cycle.header.missed
}

/// How the backend failed in a cycle.
fn error(cycle: &HeldCycle) -> Option<BackendError> {
    let named = |(channel, state): (usize, &ChannelState)| BackendError::from_code(state.backend, channel as u32);
    cycle.channels.iter().enumerate().find_map(named)
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
    ahead: Option<Consumer<HeldCycle>>,
    /// The first trouble of the reader.
    trouble: Arc<Mutex<Option<Error>>>,
    /// The cycle whose period is present or yet to come.
    recorded: HeldCycle,
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
}

impl<S: Source> ReplayBackend<S> {
    /// Of a recording.
    pub fn new(source: S) -> ReplayBackend<S> {
        let channels = source.channels();
        ReplayBackend {
            source,
            channels,
            ahead: None,
            trouble: Arc::default(),
            recorded: HeldCycle::new(channels),
            is_there: false,
            period: None,
            missed: 0,
            applied: vec![0.0; channels],
            recorded_applied: vec![f64::NAN; channels],
            recorded_next: vec![f64::NAN; channels],
            passed: 0,
        }
    }

    /// Lets the next recorded cycle be present, however many periods later it is: how many went by without one, and the
    /// cycle as it was then, which the next [`Backend::exchange`] will bring the samples of. `None` at the end.
    ///
    /// # Errors
    /// What kept the recording from being read on.
    pub fn advance(&mut self) -> Result<Option<(u64, CycleHeader)>, Error> {
        let at = self.period;
        if at.is_some_and(|at| self.is_there && period(&self.recorded) <= at) {
            self.pass();
        }
        if !self.is_there && !self.take() {
            return self.trouble().map_or(Ok(None), Err);
        }
        let between = at.map_or(0, |at| period(&self.recorded).saturating_sub(at + 1));
        Ok(Some((between, self.recorded.header)))
    }

    /// What kept the reader from going on, told once.
    pub fn trouble(&self) -> Option<Error> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// The recorded states of the cycle that [`ReplayBackend::advance`] told of.
    pub fn recorded(&self) -> &[ChannelState] {
        &self.recorded.channels
    }

    /// Takes the next recorded cycle from the reader; false at the end of the recording.
    fn take(&mut self) -> bool {
        let Some(ahead) = &mut self.ahead else { return false };
        let mut waited_from = None;
        loop {
            // Asked before looking, so that what is read between the two is not lost.
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
        let head = self.recorded.header;
        let follows = head.cycle == self.passed + 1;
        let whole = error(&self.recorded).filter(|error| error.channel().is_none()).is_some();
        for (channel, state) in self.recorded.channels.iter().enumerate() {
            let failed = whole || state.backend != 0;
            self.recorded_applied[channel] = match (failed, head.cycle) {
                (true, _) | (_, 1) => 0.0,
                _ if follows => self.recorded_next[channel],
                _ => f64::NAN,
            };
            self.recorded_next[channel] = state.duty;
        }
        self.passed = head.cycle;
        self.is_there = false;
    }

    /// Whether the recorded cycle follows the one passed last: only then is it known what was in force in between.
    fn follows(&self) -> bool {
        self.recorded.header.cycle == self.passed + 1
    }

    fn fail(&mut self, samples: &mut [Sample], error: BackendError) -> Result<(), BackendError> {
        samples.fill(Sample::NONE);
        self.applied.fill(0.0);
        Err(error)
    }
}

/// Reads a recording ahead of the loop until it ends or nobody wants it any more.
fn read_ahead(cycles: impl Cycles, mut ahead: Producer<HeldCycle>) -> Result<(), Error> {
    cycles.each(&mut |head, channels| {
        while !ahead.put(|cycle| cycle.copy_from(*head, channels)) {
            if ahead.is_alone() {
                return false;
            }
            thread::sleep(ROOM);
        }
        true
    })
}

impl<S: Source> Backend for ReplayBackend<S> {
    fn channels(&self) -> usize {
        self.channels
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.stop();
        let unavailable = BackendError::Unavailable { os_error: 0 };
        let note = |trouble: &Mutex<Option<Error>>, error: Error| {
            trouble.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        };
        let cycles = match self.source.cycles() {
            Ok(cycles) => cycles,
            Err(error) => {
                note(&self.trouble, error);
                return Err(unavailable);
            }
        };
        let (channels, trouble) = (self.channels, self.trouble.clone());
        let room = AHEAD_CYCLES.max(AHEAD_STATES / channels.max(1));
        let (ahead, ahead_out) = ring((0..room).map(|_| HeldCycle::new(channels)));
        let reader = thread::Builder::new().name("sinew-replay".into()).spawn(move || {
            if let Err(error) = read_ahead(cycles, ahead) {
                note(&trouble, error);
            }
        });
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
        while !self.is_there || present.is_some_and(|present| period(&self.recorded) < present) {
            if self.is_there {
                self.pass();
            }
            if !self.take() {
                return self.fail(samples, BackendError::Unavailable { os_error: 0 });
            }
        }
        let present = present.unwrap_or_else(|| period(&self.recorded));
        self.period = Some(present);

        let is_recorded = period(&self.recorded) == present;
        let known = is_recorded && (self.follows() || self.recorded.header.cycle == 1);
        for (channel, sample) in samples.iter_mut().enumerate() {
            *sample = if is_recorded { sample_of(&self.recorded.channels[channel]) } else { Sample::NONE };
            let (now, then) = (self.applied[channel] > 0.0, self.recorded_applied[channel]);
            let driven_then = match self.recorded.header.cycle {
                1 => Some(false),
                _ if known && !then.is_nan() => Some(then > 0.0),
                _ => None,
            };
            // Nobody knows what a converter would have seen of a wire that was driven otherwise.
            if driven_then.unwrap_or(true) != now {
                *sample = Sample { supply_v: sample.supply_v, ..Sample::NONE };
            }
        }
        let error = error(&self.recorded).filter(|_| is_recorded);
        self.applied.copy_from_slice(duty);
        match error {
            None => Ok(()),
            Some(error @ BackendError::Channel { channel, .. }) => {
                samples[channel as usize] = Sample::NONE;
                self.applied[channel as usize] = 0.0;
                Err(error)
            }
            Some(error) => self.fail(samples, error),
        }
    }

    fn missed(&mut self, periods: u64) {
        self.missed = self.missed.saturating_add(periods);
    }

    fn stop(&mut self) {
        // The reader finds itself alone and ends by itself.
        self.ahead = None;
        self.applied.fill(0.0);
    }
}

/// The sample a recorded state came from.
fn sample_of(state: &ChannelState) -> Sample {
    Sample {
        v1_v: state.v1_v,
        v2_v: state.v2_v,
        v3_v: state.v3_v,
        current_a: state.current_a,
        supply_v: state.supply_v,
    }
}
