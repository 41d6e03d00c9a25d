//! From the rows of a run to the numbers its routine exists for, each with how it was found or why it cannot be told.

mod line;
pub mod loops;
pub mod steps;
pub mod sweep;

use serde::Serialize;
use sinew_physics::WireModel;

use crate::plan::{Options, RoutineKind};
use crate::run::Row;
use crate::stage::Stage;

/// One number, or the reason why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Its key for programs, such as `austenite_modulus_gpa`.
    pub key: &'static str,
    /// What it is, in words.
    pub name: &'static str,
    /// Of which level, step or frequency; empty where it is of the whole run.
    pub of: String,
    /// The number; `None` where it cannot be told.
    pub value: Option<f64>,
    /// Its standard uncertainty, 1 σ, in the same unit.
    pub sigma: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// How it was found, or why it cannot be told.
    pub how: String,
}

impl Finding {
    fn new(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        of: &str,
        value: Estimate,
        how: impl Into<String>,
    ) -> Finding {
        if !value.value.is_finite() {
            return Finding::unknown(key, name, unit, of, "the samples give no number");
        }
        let sigma = value.sigma.is_finite().then_some(value.sigma);
        Finding { key, name, of: of.into(), value: Some(value.value), sigma, unit, how: how.into() }
    }

    fn unknown(key: &'static str, name: &'static str, unit: &'static str, of: &str, why: impl Into<String>) -> Finding {
        let how = format!("cannot tell because {}", why.into());
        Finding { key, name, of: of.into(), value: None, sigma: None, unit, how }
    }

    fn from(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        of: &str,
        found: &Result<Estimate, String>,
        how: impl Into<String>,
    ) -> Finding {
        match found {
            Ok(value) => Finding::new(key, name, unit, of, *value, how),
            Err(why) => Finding::unknown(key, name, unit, of, why.clone()),
        }
    }
}

/// A value and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// 1 σ.
    pub sigma: f64,
}

impl Estimate {
    fn scaled(self, by: f64) -> Estimate {
        Estimate { value: self.value * by, sigma: self.sigma * by.abs() }
    }

    /// With a further uncertainty that has nothing to do with the others.
    fn and(self, sigma: f64) -> Estimate {
        Estimate { sigma: self.sigma.hypot(sigma), ..self }
    }
}

/// Mean and its uncertainty from how much repetitions differ; a single one keeps its own.
fn mean(all: &[Estimate]) -> Option<Estimate> {
    let count = all.len() as f64;
    let value = all.iter().map(|e| e.value).sum::<f64>() / count;
    let own = (all.iter().map(|e| e.sigma * e.sigma).sum::<f64>()).sqrt() / count;
    match all.len() {
        0 => None,
        1 => Some(all[0]),
        _ => {
            let spread = all.iter().map(|e| (e.value - value).powi(2)).sum::<f64>() / (count - 1.0);
            Some(Estimate { value, sigma: own.max((spread / count).sqrt()) })
        }
    }
}

/// What is analysed.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// Which routine it was.
    pub kind: RoutineKind,
    /// With which numbers.
    pub options: &'a Options,
    /// Its stages, to which rows refer.
    pub stages: &'a [Stage],
    /// Its rows.
    pub rows: &'a [Row],
    /// The wire as it is believed to be.
    pub model: &'a WireModel,
    /// Its machine.
    pub spec: &'a sinew_rig::Machine,
}

impl<'a> Run<'a> {
    /// Stretches of one stage each, in their order, whole ones only: a stage the run ended in is no measurement.
    pub fn stretches(&self) -> impl Iterator<Item = (&'a Stage, &'a [Row])> + use<'a> {
        let (stages, rows) = (self.stages, self.rows);
        let last = rows.last().map_or(0, |row| row.directive.stage);
        // the last stage of all was left when it was over; any other last one was not
        let whole = move |stage: usize| stage < last || stage + 1 == stages.len();
        rows.chunk_by(|a, b| a.directive.stage == b.directive.stage).filter_map(move |rows| {
            let stage = rows.first()?.directive.stage;
            (whole(stage)).then_some((stages.get(stage)?, rows))
        })
    }
}

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    match run.kind {
        RoutineKind::DirectStrain | RoutineKind::DirectLoad => loops::findings(run),
        RoutineKind::ConstantForceSweep | RoutineKind::ConstantStrainSweep => sweep::open_loop(run),
        RoutineKind::PositionRegulation => steps::findings(run),
        RoutineKind::PositionTracking | RoutineKind::TrackingSweep => sweep::closed_loop(run),
    }
}
