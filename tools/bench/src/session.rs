//! A driver and its simulated rig in lockstep: no clock, no thread, one cycle a call. The rig is one wire in its load, or two on
//! a joint, of which the agonist is commanded and measured.

use std::fmt;

use sinew_backend::{Backend, Sample, Truth};
use sinew_control::{Estimate, StrokeRange};
use sinew_driver::{Ask, Beat, Engine, Occurrence, Order};
use sinew_ipc::Fault;
use sinew_physics::{Inputs, Wire, WireModel};
use sinew_rig::Rig;
use sinew_sim_backend::{SimulatedRig, World};

/// Why something cannot be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Error {
    /// The rig file or the driver does not take it, with the reason.
    Rig(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Rig(reason) => f.write_str(reason),
        }
    }
}

impl std::error::Error for Error {}

/// One cycle from outside.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Simulated time at its end, s.
    pub time_s: f64,
    /// What the wire really does.
    pub truth: Truth,
    /// What the driver believes of it.
    pub estimate: Estimate,
    /// Length as the driver's observer has it, m.
    pub length_m: f64,
    /// Duty for the next period.
    pub duty: f64,
    /// The sliding surface.
    pub surface: f64,
}

/// What a session can drive: how many channels with how many joints.
const WHOLE: [(usize, usize); 2] = [(1, 0), (2, 1)];

/// A driver, and its wire or pair of wires.
#[derive(Debug)]
pub struct Session {
    engine: Engine,
    rig: SimulatedRig,
    samples: Vec<Sample>,
    duty: Vec<f64>,
    cycles: u64,
    period_s: f64,
    model: WireModel,
    fault: Option<Fault>,
    /// The wire's power with the switch closed is what this share of it may be on average.
    max_duty: f64,
}

impl Session {
    /// A driver that believes `believed` before a wire that is as in `truth`, cold and at rest.
    ///
    /// # Errors
    /// [`Error::Rig`] where either cannot be made.
    pub fn new(believed: &Rig, truth: &Rig) -> Result<Session, Error> {
        let engine = Engine::at_rest(believed, None).map_err(|error| Error::Rig(error.to_string()))?;
        let mut rig = SimulatedRig::new(truth).map_err(|error| Error::Rig(error.to_string()))?;
        let counts = [believed, truth].map(|rig| (rig.channels.len(), rig.joints.len()));
        let (Some(channel), true) = (believed.channels.first(), counts[0] == counts[1] && WHOLE.contains(&counts[0]))
        else {
            return Err(Error::Rig(format!("one wire or one joint expected, twice the same, {counts:?} found")));
        };
        let max_duty = channel.limits.max_duty;
        rig.start().map_err(|error| Error::Rig(error.to_string()))?;
        Ok(Session {
            engine,
            rig,
            samples: vec![Sample::NONE; believed.channels.len()],
            duty: vec![0.0; believed.channels.len()],
            cycles: 0,
            period_s: 1.0 / believed.rate_hz,
            model: truth.nominal_model(0),
            fault: None,
            max_duty,
        })
    }

    /// Where the driver counts its strokes from.
    pub fn stroke(&self) -> StrokeRange {
        self.engine.channels()[0].stroke_range()
    }

    /// Length of a period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.cycles as f64 * self.period_s
    }

    /// The wire, its load and its supply as they are.
    pub fn model(&self) -> &WireModel {
        &self.model
    }

    /// The first fault that was latched.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// What the wire really does now.
    pub fn truth(&self) -> Truth {
        self.rig.truth(0).unwrap_or(NOTHING)
    }

    /// The wire as it is now: its clone goes on alone.
    pub fn wire(&self) -> Option<&Wire> {
        self.rig.wire(0)
    }

    /// What acts on it, with nothing driven.
    pub fn inputs(&self) -> Option<Inputs> {
        self.rig.inputs(0)
    }

    /// The largest duty the driver may give.
    pub fn max_duty(&self) -> f64 {
        self.max_duty
    }

    /// Electrical energy put into all wires since the start, J.
    pub fn energy_j(&self) -> f64 {
        (0..self.duty.len()).filter_map(|channel| self.rig.energy(channel)).map(|energy| energy.heat_in_j).sum()
    }

    /// Changes the world around the wires from now on; a pull pulls the commanded one.
    pub fn disturb(&mut self, world: &World) {
        for channel in 1..self.duty.len() {
            self.rig.disturb(channel, &World { pull_n: 0.0, ..*world });
        }
        self.rig.disturb(0, world);
    }

    /// Commands the driver, until the next command.
    pub fn ask(&mut self, ask: Ask) {
        self.engine.take(&Order { ticket: 0, channel: 0, ask, hold_ns: u64::MAX }, self.now_ns());
    }

    fn now_ns(&self) -> u64 {
        (self.time_s() * 1e9) as u64
    }

    /// One period.
    pub fn cycle(&mut self) -> Moment {
        let exchanged = self.rig.exchange(&self.duty, &mut self.samples);
        self.cycles += 1;
        let beat = Beat { now_ns: self.now_ns(), missed: 0 };
        let fault = &mut self.fault;
        self.engine.cycle(beat, exchanged, &self.samples, &mut self.duty, |event| {
            if let Occurrence::Tripped(what) = event.what {
                fault.get_or_insert(what);
            }
        });
        let channel = &self.engine.channels()[0];
        Moment {
            time_s: self.cycles as f64 * self.period_s,
            truth: self.truth(),
            estimate: *channel.estimate(),
            length_m: channel.length_m(),
            duty: self.duty[0],
            surface: channel.surface(),
        }
    }
}

/// Of a channel there is none of.
const NOTHING: Truth = Truth {
    length_m: f64::NAN,
    velocity_m_s: f64::NAN,
    temperature_c: f64::NAN,
    martensite: f64::NAN,
    force_n: f64::NAN,
    resistance_ohm: f64::NAN,
    power_w: f64::NAN,
    duty: f64::NAN,
};
