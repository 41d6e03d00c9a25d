//! From fits and residuals to the fields of the answer.

use std::collections::BTreeMap;

use sinew_physics::effects::Equation;

use crate::answer::{FittedParameter, FoundEffect, Location, RecordingSummary, Verdict};
use crate::conditions;
use crate::data::{Data, Part};
use crate::evidence::Rival;
use crate::experiment::{self, NextExperiment};
use crate::fit::Fit;
use crate::intervals::Interval;
use crate::locate::{self, Located};
use crate::numbers::number;
use crate::residuals::Residuals;
use crate::select::Selection;
use crate::space::What;
use crate::stages::Compared;
use crate::words;

/// What a search that was cut short has not tried.
pub(crate) fn cut_short(selection: &Selection) -> String {
    let rounds = selection.rounds.len();
    format!(
        "the search was cut short after {rounds} round{}: whether more is missing beside what was found, and whether something \
         else explains it as well, was not tried to the end (--thorough does, for as long as it takes)",
        if rounds == 1 { "" } else { "s" }
    )
}

/// What was kept back is not explained by what explains all that was fitted: no search sees what acts there only.
pub(crate) fn only_where_kept_back(data: &Data) -> String {
    let remedy = if data.runs.iter().any(|run| run.held_out) {
        "give that recording to fit, and keep another back"
    } else {
        "another --seed fits other blocks; what it then finds needs a recording that has more of it"
    };
    format!(
        "what was fitted is explained to within the noise of the sensors, what was kept back is not: what is missing, or a \
         parameter that nothing else tells, acts there only; {remedy}"
    )
}

/// What a reader must know of a fit.
pub(crate) fn warn_of_fit(fit: &Fit, warnings: &mut Vec<String>) {
    if !fit.converged {
        warnings.push("the fit of the parameters did not converge: take their values with caution".into());
    }
    for (place, (coordinate, z)) in fit.space.coordinates.iter().zip(&fit.z).enumerate() {
        let (What::Key(_) | What::BothModuli) = coordinate.what else { continue };
        let key = words::key_of(coordinate);
        let bound = *z <= coordinate.low + 1e-6 || *z >= coordinate.high - 1e-6;
        if bound {
            warnings.push(format!(
                "{key} ended on its bound, {}: it stands in for something else, or its prior is too narrow",
                number(coordinate.value(*z))
            ));
        } else if z.abs() > 3.0 && !fit.space.is_tied(place) {
            warnings.push(format!(
                "{key} = {} is {:.1} σ of its prior away from the rig file",
                number(coordinate.value(*z)),
                z.abs()
            ));
        }
    }
}

/// Noise of every sensor, RMS, by column.
pub(crate) fn noise_by_column(data: &Data) -> BTreeMap<String, f64> {
    data.sensors.iter().map(|s| (s.column.name().to_string(), s.noise)).collect()
}

/// The parameters of the reference model in a fit.
pub(crate) fn parameters(fit: &Fit, intervals: &[Interval]) -> BTreeMap<String, FittedParameter> {
    fit.space
        .coordinates
        .iter()
        .zip(intervals)
        .filter(|(c, _)| matches!(c.what, What::Key(_) | What::BothModuli))
        .map(|(c, i)| {
            let key = words::key_of(c);
            let unit = fit.space.unit_of(&key).to_string();
            (
                key,
                FittedParameter {
                    given: c.origin,
                    value: i.value,
                    low: i.low,
                    high: i.high,
                    unit,
                    prior_sigma: c.scale,
                },
            )
        })
        .collect()
}

/// What recording would show more.
pub(crate) fn next_experiment(
    data: &Data,
    verdict: Verdict,
    Compared { chosen, reference, .. }: &Compared,
    rivals: &[Rival],
    effects: &[FoundEffect],
) -> NextExperiment {
    let propose = |rival: &Fit| experiment::propose(data, &chosen.fit, rival);
    match (verdict, rivals.first()) {
        (Verdict::PhysicsMissing, Some(rival)) => {
            let named = effects
                .iter()
                .find(|e| e.cannot_be_told_apart_from.iter().any(|id| id == rival.id))
                .map_or("the effect found", |e| e.id.as_str());
            words::separate(named, rival.id, propose(&rival.fit))
        }
        (Verdict::PhysicsMissing, None) => words::confirm(effects, propose(&reference.fit)),
        // without a closed form there is nothing to tell apart yet
        (Verdict::UnknownPhysics, _) if chosen.fit.space.effects.is_empty() => words::explore(None),
        (Verdict::UnknownPhysics, _) => words::explore(propose(&reference.fit)),
        (Verdict::Agrees | Verdict::ParametersOff, _) => words::nothing_needed(&chosen.fit, data),
    }
}

/// Where the mismatch is: in which equation, when, and under which conditions.
pub(crate) fn location(
    data: &Data,
    guilty: Option<Equation>,
    Compared { chosen, reference, recalibrated, .. }: &Compared,
    located: &[Located],
) -> Location {
    let equation_scores = locate::scores(located);
    let Some(guilty) = guilty else { return Location { equation_scores, ..Location::default() } };
    let event = chosen.fit.space.effects.iter().find_map(|e| words::event_of(e, &chosen.fit));
    let windows = match event {
        Some((start_s, end_s)) => conditions::share_in(data, &recalibrated.residuals, start_s, end_s),
        None => conditions::windows(data, &recalibrated.residuals),
    };
    Location {
        equation: Some(guilty.name().to_string()),
        equation_scores,
        windows,
        conditions: conditions::conditions(data, &reference.fit, &recalibrated.residuals),
    }
}

/// Every recording, with what was fitted of it alone.
pub(crate) fn summaries(data: &Data, fit: &Fit, residuals: &Residuals) -> Vec<RecordingSummary> {
    data.runs
        .iter()
        .enumerate()
        .map(|(index, run)| {
            let (mut sum, mut count) = (0.0, 0.0);
            for values in &residuals[index] {
                for (r, part) in values.iter().zip(&run.part) {
                    if *part == Part::KeptBack && !r.is_nan() {
                        sum += f64::from(*r).powi(2);
                        count += 1.0;
                    }
                }
            }
            let (zero, gain) = fit.space.position_of(index, &fit.z);
            let mut offsets = BTreeMap::new();
            if data.free_zero && !run.held_out {
                offsets.insert("position_m".to_string(), zero);
                if fit.space.coordinates.iter().any(|c| matches!(c.what, What::Gain(r) if r == index)) {
                    offsets.insert("position_gain".to_string(), gain);
                }
            }
            RecordingSummary {
                name: run.name.clone(),
                samples: run.time_s.len(),
                duration_s: run.duration_s(),
                held_out: run.held_out,
                chi: (count > 0.0).then(|| (sum / count).sqrt()),
                offsets,
            }
        })
        .collect()
}
