//! The driver's cycle and a virtual rig in lockstep: no clock, no thread, no shared memory, so as fast as the machine can, and
//! the same again for the same seed. What tests, trials and figures of the supervisor run on.

use sinew_driver::{Answer, Ask, Backend, Beat, Engine, Event, Occurrence, Order, Program, Sample};
use sinew_ipc::{ChannelState, DriverState, Fault, Snapshot};
use sinew_rig::Rig;

use crate::{Error, SimulatedRig};

/// A fault that was latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trip {
    /// The period after whose sample it was, from 0.
    pub period: u64,
    /// Which channel.
    pub channel: usize,
    /// What.
    pub fault: Fault,
}

/// Why there is no lockstep: the rig cannot be simulated, or not driven.
#[derive(Debug)]
pub enum LockstepError {
    /// The virtual rig.
    Rig(Error),
    /// The driver.
    Driver(sinew_driver::Error),
}

impl std::fmt::Display for LockstepError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LockstepError::Rig(error) => error.fmt(f),
            LockstepError::Driver(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for LockstepError {}

/// A driver's engine on a virtual rig.
#[derive(Debug)]
pub struct Lockstep {
    engine: Engine,
    backend: SimulatedRig,
    duty: Vec<f64>,
    samples: Vec<Sample>,
    snapshot: Box<Snapshot>,
    rate_hz: f64,
    period: u64,
    trips: Vec<Trip>,
}

impl Lockstep {
    /// A driver on the rig it believes to have. `program` is what the rig does while nobody commands it.
    ///
    /// # Errors
    /// A rig that cannot be driven or simulated.
    pub fn new(rig: &Rig, program: Option<Program>) -> Result<Lockstep, LockstepError> {
        Lockstep::misjudging(rig, rig, program)
    }

    /// A driver that believes in one rig, on another one with as many channels.
    ///
    /// # Errors
    /// A rig that cannot be driven or simulated.
    pub fn misjudging(believed: &Rig, truth: &Rig, program: Option<Program>) -> Result<Lockstep, LockstepError> {
        let engine = Engine::new(believed, program).map_err(LockstepError::Driver)?;
        let mut backend = SimulatedRig::new(truth).map_err(LockstepError::Rig)?;
        // a virtual rig always starts
        let _ = backend.start();
        let channels = backend.channels();
        Ok(Lockstep {
            engine,
            backend,
            duty: vec![0.0; channels],
            samples: vec![Sample::NONE; channels],
            snapshot: Box::new(Snapshot::new(channels)),
            rate_hz: believed.rate_hz,
            period: 0,
            trips: Vec::new(),
        })
    }

    /// The virtual rig: its truth, its faults, its world.
    pub fn backend(&mut self) -> &mut SimulatedRig {
        &mut self.backend
    }

    /// The driver's engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Periods that have passed.
    pub fn period(&self) -> u64 {
        self.period
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.period as f64 / self.rate_hz
    }

    /// The duty of every channel for the period that begins now.
    pub fn duty(&self) -> &[f64] {
        &self.duty
    }

    /// Every fault that was latched.
    pub fn trips(&self) -> &[Trip] {
        &self.trips
    }

    fn now_ns(&self) -> u64 {
        1_000_000_000 + (self.period as f64 * 1e9 / self.rate_hz) as u64
    }

    /// Lets one period pass.
    pub fn step(&mut self) {
        let exchanged = self.backend.exchange(&self.duty, &mut self.samples);
        let beat = Beat { now_ns: self.now_ns(), missed: 0 };
        let (period, trips) = (self.period, &mut self.trips);
        self.engine.cycle(beat, exchanged, &self.samples, &mut self.duty, |event: Event| {
            if let Occurrence::Tripped(fault) = event.what {
                trips.push(Trip { period, channel: event.channel as usize, fault });
            }
        });
        if self.engine.must_cut() {
            self.backend.cut();
        }
        self.period += 1;
    }

    /// Lets so many periods pass.
    pub fn run(&mut self, periods: u64) {
        (0..periods).for_each(|_| self.step());
    }

    /// Lets time pass, s.
    pub fn run_s(&mut self, seconds: f64) {
        self.run((seconds * self.rate_hz).round() as u64);
    }

    /// Asks something of a channel, for good. `None`: the answer comes with a later period.
    pub fn ask(&mut self, channel: usize, ask: Ask) -> Option<Answer> {
        self.engine.take(&Order { ticket: 0, channel, ask, hold_ns: u64::MAX }, self.now_ns())
    }

    /// Asks a channel for a stroke, 0 = cold, 1 = hot.
    pub fn move_to(&mut self, channel: usize, stroke: f64) -> Option<Answer> {
        let length_m = self.engine.channels()[channel].stroke_range().length_m(stroke);
        self.ask(channel, Ask::Length(length_m))
    }

    /// What the driver would publish of a channel.
    pub fn state(&mut self, channel: usize) -> ChannelState {
        self.engine.describe(self.now_ns(), DriverState::Running, &mut self.snapshot);
        self.snapshot.channel[channel]
    }
}
