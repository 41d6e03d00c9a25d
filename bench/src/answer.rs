//! What a run of the bench says: rows, ranking, findings.

use serde::Serialize;
use sinew_control::EstimatorKind;

use crate::findings::{Finding, findings};
use crate::row::Row;
use crate::score::{DEVELOPMENT, Place, SCORING, ranking};
use crate::sensing;
use crate::{Choice, Family, Plan, Plant, Ran};

/// Schema of `bench.json`.
pub const SCHEMA: &str = "sinew.bench.control/1";

/// State estimators that chapter 7's experiment scores beside the plain measurements.
const ESTIMATORS: [(&str, EstimatorKind); 1] = [("enthalpy", EstimatorKind::Enthalpy)];

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
    /// Chapter 7's experiment.
    pub sensing: sensing::Report,
}

/// Chapter 7's experiment with the driver's estimators; the quick one sweeps one load, faster.
pub fn sensing_report(quick: bool) -> sensing::Report {
    let seed = if quick { DEVELOPMENT } else { SCORING };
    let mut plan = sensing::Plan::new(seed, ESTIMATORS.map(|(word, kind)| (word.to_owned(), kind)).to_vec());
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
    pub fn of(plan: &Plan, ran: &[Ran], sensing: sensing::Report, command: String) -> Answer {
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
            sensing,
        }
    }

    /// The winner, where anything was ranked.
    pub fn winner(&self) -> Option<&Place> {
        self.ranking.first()
    }
}
