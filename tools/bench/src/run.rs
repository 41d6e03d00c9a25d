//! Runs rows in parallel.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::bound::swing_s;
use crate::row::{Bounds, Row, Traces, bounds, row};
use crate::score::{DEVELOPMENT, SCORING};
use crate::{Choice, Family, Plant};

/// What is run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Plants, by name.
    pub plants: Vec<&'static str>,
    /// Choices of a lone wire.
    pub choices: Vec<Choice>,
    /// Choices of a pair on a joint.
    pub of_joint: Vec<Choice>,
    /// Seeds of the noise.
    pub seeds: Vec<u64>,
}

/// Which words are kept; an empty list keeps all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Filter {
    /// Controllers.
    pub controllers: Vec<String>,
    /// Estimators.
    pub estimators: Vec<String>,
    /// Plants.
    pub plants: Vec<String>,
}

/// Plants of a quick run: one the driver knows, one it misjudges, and those of the thesis' findings.
pub const QUICK: [&str; 5] = ["figure", "convection_less", "thesis_3w", "thesis_1w", "thesis_no_feedforward"];

/// Every controller with every estimator, as a fresh rig file measures; measured otherwise, with the estimator of a fresh rig
/// file alone: what is lost in the measurement no estimator brings back.
fn choices() -> Vec<Choice> {
    let default = Choice::default();
    let mut choices = Choice::all();
    choices.retain(|choice| choice.sensing == default.sensing || choice.estimator == default.estimator);
    choices
}

impl Plan {
    /// Every plant, on `seeds` seeds to score with.
    pub fn full(seeds: usize) -> Plan {
        let plants = Plant::all().iter().map(|plant| plant.name).collect();
        Plan { plants, choices: choices(), of_joint: Choice::of_joint(), seeds: (SCORING..).take(seeds).collect() }
    }

    /// A few plants on seeds to develop with, for tests and for a first look.
    pub fn quick(seeds: usize) -> Plan {
        Plan { plants: QUICK.into(), seeds: (DEVELOPMENT..).take(seeds).collect(), ..Plan::full(0) }
    }

    /// What is left of it. A plant that is requested by name is in, whether the plan had it or not.
    #[must_use]
    pub fn only(mut self, filter: &Filter) -> Plan {
        let keeps = |words: &[String], word: &str| words.is_empty() || words.iter().any(|w| w == word);
        if !filter.plants.is_empty() {
            let all = Plant::all().iter().map(|plant| plant.name);
            self.plants = all.filter(|name| keeps(&filter.plants, name)).collect();
        }
        self.choices.retain(|choice| keeps(&filter.controllers, &choice.controller));
        self.choices.retain(|choice| keeps(&filter.estimators, &choice.estimator));
        // a joint has one estimator, which is no word of the rig file
        self.of_joint.retain(|choice| keeps(&filter.controllers, &choice.controller));
        self
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.cases().len()
    }

    /// Every choice on every plant; a joint has laws of its own.
    fn cases(&self) -> Vec<(&'static Plant, Choice)> {
        let plants = self.plants.iter().filter_map(|name| Plant::named(name));
        let on = |plant: &'static Plant| {
            let choices = if plant.family == Family::Pair { &self.of_joint } else { &self.choices };
            choices.iter().map(move |choice| (plant, choice.clone()))
        };
        plants.flat_map(on).collect()
    }
}

/// A row with its picture, where there is one.
#[derive(Debug, Clone, PartialEq)]
pub struct Ran {
    /// The row.
    pub row: Row,
    /// Its first seed over time: of the figure's wire and of the thesis' plants.
    pub traces: Option<Traces>,
}

/// Runs a plan, on as many threads as the caller's pool of rayon has; `progress` gets how many rows are done.
pub fn run(plan: &Plan, progress: &(dyn Fn(usize) + Sync)) -> Vec<Ran> {
    let cases = plan.cases();
    // a load that rings takes seconds for each bound: once a plant, not once a row
    let rings = |plant: &&Plant| plant.model().as_ref().and_then(swing_s).is_some();
    let plants: Vec<&Plant> = plan.plants.iter().filter_map(|name| Plant::named(name)).filter(rings).collect();
    let seed = plan.seeds.first().copied().unwrap_or(DEVELOPMENT);
    let shared: Vec<(&str, Option<Bounds>)> =
        plants.par_iter().map(|plant| (plant.name, bounds(plant, seed))).collect();
    let done = AtomicUsize::new(0);
    let of = |plant: &Plant| shared.iter().find(|(name, _)| *name == plant.name)?.1.as_ref();
    cases
        .par_iter()
        .map(|(plant, choice)| {
            let pictured = plant.name == "figure" || plant.family == Family::Thesis;
            let (row, traces) = row(plant, choice, &plan.seeds, of(plant), pictured);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            Ran { row, traces }
        })
        .collect()
}
