//! The score: each choice's figures relative to their requirements, on seeds not used for tuning.

use serde::Serialize;

use crate::row::{Figures, Row};
use crate::{Choice, Family};

/// Seeds to develop with.
pub const DEVELOPMENT: u64 = 1;
/// Seeds to score with begin here.
pub const SCORING: u64 = 90_001;

/// What has to be reached: a figure's name, its unit, its target, and where it stands in a row.
pub struct Target {
    /// In words.
    pub name: &'static str,
    /// Unit of the figure.
    pub unit: &'static str,
    /// At most this.
    pub most: f64,
    /// The figure of a row; NaN where it has none.
    pub figure: fn(&Figures) -> f64,
}

/// The targets, all for the driver's own measurement.
pub static TARGETS: [Target; 5] = [
    Target {
        name: "settling up / bound",
        unit: "1",
        most: 1.25,
        figure: |figures| figures.ratio_up.unwrap_or(f64::NAN),
    },
    Target {
        name: "settling down / bound",
        unit: "1",
        most: 1.25,
        figure: |figures| figures.ratio_down.unwrap_or(f64::NAN),
    },
    Target { name: "overshoot", unit: "%", most: 0.5, figure: |figures| figures.overshoot_percent },
    Target { name: "steady-state error, RMS", unit: "%", most: 0.3, figure: |figures| figures.steady_rms_percent },
    // not at 1 Hz, which is out of a lone wire's reach (see `follow`): there all would count the same
    Target { name: "tracking at 0.25 Hz, RMS", unit: "%", most: 0.4, figure: |figures| figures.tracking_percent(0.25) },
];

/// What won the last full run, `sinew bench control`: controller, estimator and sensing. The default of a fresh rig file is to
/// be the same; a test holds the two together, and the page says so where a run finds another winner.
pub const WINNER: [&str; 3] = ["time_optimal", "fused", "dual"];

/// A figure counts for at most so many times its target: how bad something useless is says nothing.
pub const WORST: f64 = 10.0;

/// How far a row is from the targets: the mean of its figures over their targets, each at most [`WORST`]; 1 and less is there.
/// A row with a fault is the worst there is. `None` for one without figures.
pub fn of_row(row: &Row) -> Option<f64> {
    let figures = row.figures.as_ref()?;
    if !figures.faults.is_empty() {
        return Some(WORST);
    }
    let shares = TARGETS.iter().map(|target| {
        let share = (target.figure)(figures) / target.most;
        if share.is_nan() { WORST } else { share.clamp(0.0, WORST) }
    });
    Some(shares.sum::<f64>() / TARGETS.len() as f64)
}

/// A choice's place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// `algorithm` of the rig file.
    pub controller: String,
    /// `estimator` of the rig file.
    pub estimator: String,
    /// `sensing` of the rig file.
    pub sensing: String,
    /// The mean of the two that follow; less is better.
    pub score: f64,
    /// Mean score over the plants the driver knows.
    pub known: f64,
    /// Mean score over the plants it misjudges.
    pub misjudged: f64,
}

impl Place {
    /// The choice.
    pub fn choice(&self) -> Choice {
        Choice { controller: self.controller.clone(), estimator: self.estimator.clone(), sensing: self.sensing.clone() }
    }
}

/// All choices that were run on the same plants, the best first. One that is refused on a plant gets the worst there.
pub fn ranking(rows: &[Row]) -> Vec<Place> {
    let mut choices: Vec<(&str, &str, &str)> = Vec::new();
    for row in rows {
        let choice = (row.controller.as_str(), row.estimator.as_str(), row.sensing.as_str());
        if !choices.contains(&choice) {
            choices.push(choice);
        }
    }
    let mean = |choice: (&str, &str, &str), family: Family| {
        let scores: Vec<f64> = rows
            .iter()
            .filter(|row| (row.controller.as_str(), row.estimator.as_str(), row.sensing.as_str()) == choice)
            .filter(|row| row.family == family)
            .map(|row| of_row(row).unwrap_or(WORST))
            .collect();
        (!scores.is_empty()).then(|| scores.iter().sum::<f64>() / scores.len() as f64)
    };
    let mut places: Vec<Place> = choices
        .into_iter()
        .filter_map(|choice| {
            let (known, misjudged) = (mean(choice, Family::Known), mean(choice, Family::Misjudged));
            let either = known.or(misjudged)?;
            let (known, misjudged) = (known.unwrap_or(either), misjudged.unwrap_or(either));
            Some(Place {
                controller: choice.0.into(),
                estimator: choice.1.into(),
                sensing: choice.2.into(),
                score: 0.5 * (known + misjudged),
                known,
                misjudged,
            })
        })
        .collect();
    places.sort_by(|a, b| a.score.total_cmp(&b.score));
    places
}
