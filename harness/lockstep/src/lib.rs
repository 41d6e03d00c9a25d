//! The driver's cycle and a virtual rig in lockstep: no clock, no thread, no shared memory, so as fast as possible, and
//! reproducible for the same seed. Tests, trials and figures of the supervisor use it.
//!
//! ```
//! use sinew_lockstep::Lockstep;
//!
//! let mut bench = Lockstep::new(&sinew_rig::Rig::hexapod(), None)?;
//! bench.run_s(0.5); // the driver has sensed every channel
//! bench.move_to(0, 0.4);
//! bench.run_s(2.0);
//! let state = bench.state(0);
//! assert!((state.length_m - state.target_m).abs() < 0.2e-3, "within 0.2 mm");
//! assert!(bench.trips().is_empty());
//! # Ok::<(), sinew_lockstep::LockstepError>(())
//! ```

use std::collections::HashMap;

use sinew_backend::{Backend, Sample};
use sinew_driver::commands::ChannelRules;
use sinew_driver::{Answer, Ask, Beat, Engine, Event, Occurrence, Order, Program, SupplySwitch};
use sinew_ipc::{ChannelState, Command, DriverState, Fault, Reply, Snapshot};
use sinew_rig::Rig;

use sinew_sim_backend::{Error, SimulatedRig};

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
    rig: Rig,
    engine: Engine,
    backend: SimulatedRig,
    rules: Vec<ChannelRules>,
    duty: Vec<f64>,
    samples: Vec<Sample>,
    snapshot: Box<Snapshot>,
    period: u64,
    trips: Vec<Trip>,
    supply: SupplySwitch,
    reset_stop: bool,
    tickets: u64,
    answers: HashMap<u64, Answer>,
}

impl Lockstep {
    /// A driver on the rig it is configured for. `program` is what the rig does while no client commands it.
    ///
    /// # Errors
    /// A rig that cannot be driven or simulated.
    pub fn new(rig: &Rig, program: Option<Program>) -> Result<Lockstep, LockstepError> {
        Lockstep::misjudging(rig, rig, program)
    }

    /// A driver configured for one rig, on another one with as many channels.
    ///
    /// # Errors
    /// A rig that cannot be driven or simulated.
    pub fn misjudging(believed: &Rig, truth: &Rig, program: Option<Program>) -> Result<Lockstep, LockstepError> {
        let engine = Engine::at_rest(believed, program).map_err(LockstepError::Driver)?;
        let rules = ChannelRules::of(believed).map_err(LockstepError::Driver)?;
        let mut backend = SimulatedRig::new(truth).map_err(LockstepError::Rig)?;
        // a virtual rig always starts
        let _ = backend.start();
        let channels = backend.channels();
        Ok(Lockstep {
            rig: believed.clone(),
            engine,
            backend,
            rules,
            duty: vec![0.0; channels],
            samples: vec![Sample::NONE; channels],
            snapshot: Box::new(Snapshot::new(channels)),
            period: 0,
            trips: Vec::new(),
            supply: SupplySwitch::default(),
            reset_stop: false,
            tickets: 0,
            answers: HashMap::new(),
        })
    }

    /// The rig the driver is configured for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The virtual rig: its truth.
    pub fn wires(&self) -> &SimulatedRig {
        &self.backend
    }

    /// The virtual rig: its faults, its world.
    pub fn backend(&mut self) -> &mut SimulatedRig {
        &mut self.backend
    }

    /// Resets the emergency stop at the terminal, for the next period.
    pub fn reset_emergency_stop(&mut self) {
        self.reset_stop = true;
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
        self.period as f64 / self.rig.rate_hz
    }

    /// The duty of every channel for the period that begins now.
    pub fn duty(&self) -> &[f64] {
        &self.duty
    }

    /// The duty in force at the wire in the period just past: what the power stage gave, not what the driver says.
    pub fn in_force(&self, channel: usize) -> f64 {
        self.backend.truth(channel).map_or(f64::NAN, |truth| truth.duty)
    }

    /// Every fault that was latched.
    pub fn trips(&self) -> &[Trip] {
        &self.trips
    }

    fn now_ns(&self) -> u64 {
        1_000_000_000 + (self.period as f64 * 1e9 / self.rig.rate_hz) as u64
    }

    /// Lets one period pass.
    pub fn step(&mut self) {
        self.step_after(0);
    }

    /// Lets one period pass, after so many in which the driver was not there.
    pub fn step_after(&mut self, missed: u64) {
        if missed > 0 {
            self.backend.missed(missed);
            self.period += missed;
            self.engine.come_late(missed, &mut self.duty);
        }
        let exchanged = self.backend.exchange(&self.duty, &mut self.samples);
        let beat = Beat { now_ns: self.now_ns(), missed };
        self.engine.note_outputs(&self.backend);
        self.engine.clear(&mut self.backend);
        let was_reset = std::mem::take(&mut self.reset_stop);
        self.supply.look(&self.backend, &mut self.engine, was_reset);
        let Lockstep { period, trips, answers, .. } = self;
        let tell = |event: Event| match event.what {
            Occurrence::Tripped(fault) => trips.push(Trip { period: *period, channel: event.channel as usize, fault }),
            Occurrence::Answered { ticket, answer } => drop(answers.insert(ticket, answer)),
            _ => {}
        };
        self.engine.cycle(beat, exchanged, &self.samples, &mut self.duty, tell);
        self.supply.switch(&self.engine, &mut self.backend);
        self.period += 1;
        self.engine.describe(self.now_ns(), DriverState::Running, &mut self.snapshot);
    }

    /// Lets so many periods pass.
    pub fn run(&mut self, periods: u64) {
        (0..periods).for_each(|_| self.step());
    }

    /// Lets time pass, s.
    pub fn run_s(&mut self, seconds: f64) {
        self.run((seconds * self.rig.rate_hz).round() as u64);
    }

    fn order(&mut self, channel: usize, ask: Ask, hold_ns: u64) -> Option<Answer> {
        self.tickets += 1;
        self.engine.take(&Order { ticket: self.tickets, channel, ask, hold_ns }, self.now_ns())
    }

    /// Asks something of a channel, for good. `None`: the answer comes with a later period.
    pub fn ask(&mut self, channel: usize, ask: Ask) -> Option<Answer> {
        self.order(channel, ask, u64::MAX)
    }

    /// Asks a channel for a stroke, 0 = cold, 1 = hot.
    pub fn move_to(&mut self, channel: usize, stroke: f64) -> Option<Answer> {
        let length_m = self.engine.channels()[channel].stroke_range().length_m(stroke);
        self.ask(channel, Ask::Length(length_m))
    }

    /// A command as it comes from a client: judged by the desk's rules, then by the loop.
    ///
    /// # Errors
    /// The refusal the client would get.
    pub fn command(
        &mut self,
        channel: usize,
        kind: u32,
        value: f64,
        hold_s: f64,
    ) -> Result<Option<Answer>, Box<Reply>> {
        let sequence = self.tickets + 1;
        let command = Command { client: 1, sequence, channel: channel as u32, kind, value, hold_s };
        let (ask, granted_s) = self.rules[channel].check(&command).map_err(Box::new)?;
        let hold_ns = if granted_s > 0.0 { (granted_s * 1e9) as u64 } else { u64::MAX };
        Ok(self.order(channel, ask, hold_ns))
    }

    /// Asks for a reset, and lets periods pass until it is answered; `None` when that does not come within 4 s.
    pub fn reset(&mut self, channel: usize) -> Option<Answer> {
        if let Some(answer) = self.ask(channel, Ask::Reset) {
            return Some(answer);
        }
        let ticket = self.tickets;
        for _ in 0..4 * (self.rig.rate_hz as u64) {
            self.step();
            if let Some(answer) = self.answers.remove(&ticket) {
                return Some(answer);
            }
        }
        None
    }

    /// What the driver publishes of a channel after the last period.
    pub fn state(&self, channel: usize) -> &ChannelState {
        &self.snapshot.channel[channel]
    }
}
