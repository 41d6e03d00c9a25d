//! Runs that take longer than a row should: a driver with one law on a plant of the control bench, and chapter 7's experiment, which
//! several rows look at and which is made once.

use sinew_bench::{Choice, Disturbed, Plant, Session, Step, Trace, disturb, idle, sensing, step};
use sinew_sim_backend::World;

use crate::chapter::Chapter;
use crate::found::Tried;

/// Seed of every run here: chance as little as any.
const SEED: u64 = 90_001;
/// The sensing pulse alone before anything is commanded, s.
const IDLE_S: f64 = 0.5;
/// A draught takes half as much heat again, and lasts so long, s.
const DRAUGHT: f64 = 0.5;
const DRAUGHT_S: f64 = 3.0;

/// What the rows of some chapters share.
#[derive(Debug, Default)]
pub struct Lab {
    sensing: Option<sensing::Report>,
}

impl Lab {
    /// Nothing has been run.
    #[cfg(test)]
    pub(crate) fn empty() -> Lab {
        Lab::default()
    }

    /// Runs what these chapters share.
    pub fn of(chapters: &[Chapter]) -> Lab {
        let sensing = || sensing::experiment(&sensing::Plan::new(SEED, Vec::new()));
        Lab { sensing: chapters.contains(&Chapter::Seven).then(sensing) }
    }

    /// Chapter 7's experiment.
    pub(crate) fn sensing(&self) -> Tried<&sensing::Report> {
        self.sensing.as_ref().ok_or_else(|| "chapter 7's experiment was not run".into())
    }
}

/// What is chosen in the rig file, beyond what a fresh one has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chosen {
    /// `algorithm`.
    pub law: &'static str,
    /// `estimator`; `None` = a fresh rig file's.
    pub estimator: Option<&'static str>,
    /// `sensing`; the same.
    pub sensing: Option<&'static str>,
}

impl Chosen {
    /// A law, and the rest as in a fresh rig file.
    pub const fn law(law: &'static str) -> Chosen {
        Chosen { law, estimator: None, sensing: None }
    }
}

/// A driver with its wire on a plant of the bench, ready to be commanded.
pub(crate) struct Run {
    session: Session,
    watch_s: f64,
    period_s: f64,
    /// What was seen so far.
    pub trace: Trace,
}

impl Run {
    /// A plant by name under what is chosen, cold and at rest.
    pub fn new(plant: &str, chosen: Chosen) -> Tried<Run> {
        let plant = Plant::named(plant).ok_or_else(|| format!("there is no plant {plant}"))?;
        let choice = Choice::default().with(Some(chosen.law), chosen.estimator, chosen.sensing);
        let believed = plant.believed(&choice, SEED)?;
        let mut session = Session::new(&believed, &plant.truth(&believed))?;
        idle(&mut session, IDLE_S);
        Ok(Run { session, watch_s: plant.watch_s, period_s: 1.0 / plant.rate_hz, trace: Trace::default() })
    }

    /// A step to a stroke, watched for as long as the bench watches one on this plant.
    pub fn step(&mut self, to: f64) -> Step {
        let (trace, period_s) = (&mut self.trace, self.period_s);
        step(&mut self.session, to, self.watch_s, false, |moment, error| {
            trace.see(moment, to, error, moment.time_s, period_s);
        })
    }

    /// A draught on a wire held at a stroke.
    pub fn draught(&mut self, stroke: f64) -> Disturbed {
        let world = World { draught: DRAUGHT, ..World::CALM };
        let (trace, period_s) = (&mut self.trace, self.period_s);
        disturb(&mut self.session, stroke, &world, DRAUGHT_S, |moment, error| {
            trace.see(moment, stroke, error, moment.time_s, period_s);
        })
    }
}
