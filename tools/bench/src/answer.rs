//! The result of a run of the bench: rows, ranking, findings.

use rayon::prelude::*;
use serde::Serialize;
use sinew_control::{EstimatorKind, StrokeRange};
use sinew_physics::Wire;

use crate::findings::{Finding, findings};
use crate::follow::{Course, least_error};
use crate::row::{FREQUENCIES_HZ, Row, SINE_MIDDLE, SINE_SWING};
use crate::score::{DEVELOPMENT, Place, SCORING, ranking};
use crate::sensing;
use crate::{Choice, Family, Plan, Plant, Ran};

/// Schema of `bench.json`.
pub const SCHEMA: &str = "sinew.bench.control/1";

/// Everything a run says but its pictures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// The command that makes it again.
    pub command: String,
    /// Seeds of the noise.
    pub seeds: Vec<u64>,
    /// The plants of the run.
    pub plants: Vec<About>,
    /// A row for each choice on each plant.
    pub rows: Vec<Row>,
    /// The choices by their score, the best first.
    pub ranking: Vec<Place>,
    /// What a rig file chooses that says nothing of it.
    pub default: Default,
    /// What the thesis found, looked for here.
    pub findings: Vec<Finding>,
    /// The least error on the sines that was found for whoever knows everything in advance, see [`crate::follow`]; empty where it was
    /// not looked for.
    pub reachable: Vec<Reachable>,
    /// Chapter 7's experiment.
    pub sensing: sensing::Report,
}

/// What can be reached on a plant's sine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reachable {
    /// The plant.
    pub plant: &'static str,
    /// Hz.
    pub frequency_hz: f64,
    /// RMS error, % of the stroke.
    pub rms_percent: f64,
}

/// Frequencies below which any good controller follows as well as it measures, Hz.
const REACHABLE_FROM_HZ: f64 = 0.25;

/// What can be reached on the sines of a plant.
pub fn reachable(plant: &'static Plant) -> Vec<Reachable> {
    let of = |frequency_hz: f64| {
        let believed = plant.believed(&Choice::default(), DEVELOPMENT).ok()?;
        let truth = plant.truth(&believed);
        let model = &truth.channels.first()?.model;
        let course = Course {
            range: StrokeRange::of(model).ok()?,
            rest_m: model.geometry.length_m,
            middle: SINE_MIDDLE,
            swing: SINE_SWING,
            frequency_hz,
            max_duty: believed.channels.first()?.limits.max_duty,
            inputs: model.rest_inputs(),
        };
        let rms_percent = 100.0 * least_error(&Wire::new(model).ok()?, &course);
        Some(Reachable { plant: plant.name, frequency_hz, rms_percent })
    };
    FREQUENCIES_HZ.into_par_iter().filter(|frequency| *frequency >= REACHABLE_FROM_HZ).filter_map(of).collect()
}

/// Chapter 7's experiment with the driver's estimators; the quick one sweeps one load, faster.
pub fn sensing_report(quick: bool) -> sensing::Report {
    let seed = if quick { DEVELOPMENT } else { SCORING };
    let mut plan = sensing::Plan::new(seed, EstimatorKind::ALL.map(|kind| (kind.word().to_owned(), kind)).to_vec());
    if quick {
        plan = sensing::Plan { sweep_s: 24.0, loads_gf: vec![200.0], ..plan };
    }
    sensing::experiment(&plan)
}

/// A plant in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct About {
    /// Its name.
    pub plant: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Why it is there.
    pub family: Family,
}

/// A choice, as the rows name it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Default {
    /// `algorithm` of the rig file.
    pub controller: String,
    /// `estimator` of the rig file.
    pub estimator: String,
    /// `sensing` of the rig file.
    pub sensing: String,
}

impl Answer {
    /// What `ran` says, which `command` made.
    pub fn of(
        plan: &Plan,
        ran: &[Ran],
        sensing: sensing::Report,
        reachable: Vec<Reachable>,
        command: String,
    ) -> Answer {
        let rows: Vec<Row> = ran.iter().map(|ran| ran.row.clone()).collect();
        let default = Choice::default();
        // the findings' laws take the default estimator, or the only one that was run
        let ran_default = rows.iter().any(|row| row.estimator == default.estimator);
        let estimator = if ran_default {
            default.estimator.clone()
        } else {
            rows.first().map(|row| row.estimator.clone()).unwrap_or_default()
        };
        Answer {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            command,
            seeds: plan.seeds.clone(),
            plants: plan
                .plants
                .iter()
                .filter_map(|name| Plant::named(name))
                .map(|plant| About { plant: plant.name, about: plant.about, family: plant.family })
                .collect(),
            ranking: ranking(&rows),
            findings: findings(&rows, &estimator),
            default: Default { controller: default.controller, estimator: default.estimator, sensing: default.sensing },
            rows,
            reachable,
            sensing,
        }
    }

    /// The winner, where anything was ranked.
    pub fn winner(&self) -> Option<&Place> {
        self.ranking.first()
    }
}
