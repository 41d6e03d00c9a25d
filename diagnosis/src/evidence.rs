//! Why every effect that was found is believed: what the evidence falls by without it, and how others do in its place.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sinew_physics::effects::Effect;

use crate::answer::{Alternative, EffectSize, Evidence, FoundEffect, Grade};
use crate::data::Data;
use crate::explanation::{Explanation, Turns};
use crate::fit::Fit;
use crate::intervals::Interval;
use crate::residuals;
use crate::select::{self, Selection, TAKEN};
use crate::shares::Shares;
use crate::space::What;
use crate::words;

/// Rivals of an effect that are refitted in its place.
const RIVALS: usize = 3;
/// Two explanations whose log evidence differs less than this cannot be distinguished.
const ALIKE: f64 = 5.0;
/// Rise of the log density of what is kept back from which an effect is confirmed there.
const CONFIRMED: f64 = 3.0;
/// Rise of the log evidence from which an effect that was not taken is suspected.
const SUSPECTED: f64 = 4.0;

/// A rival that explains the recording as well as what was found.
pub(crate) struct Rival {
    pub(crate) id: &'static str,
    pub(crate) fit: Fit,
}

/// What the effects of a selection are believed for.
pub(crate) struct Found {
    /// In the order of their shares.
    pub(crate) effects: Vec<FoundEffect>,
    /// Explanations as good, with another effect in the place of one found.
    pub(crate) rivals: Vec<Rival>,
}

/// Judges the effects of a selection on the data it was made on, `searched`, and on all of `data`, where `chosen` is carried
/// to its end, with its `intervals`.
pub(crate) fn judge(
    data: &Data,
    searched: &Data,
    selection: &Selection,
    chosen: &Explanation,
    intervals: &[Interval],
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Found {
    let best = &selection.chosen;
    let shares = Shares::of(&chosen.fit);
    let chi_after = chi_kept(data, &chosen.fit);
    let mut found = Found { effects: Vec::new(), rivals: Vec::new() };
    let count = best.fit.space.effects.len();
    for (number, effect) in best.fit.space.effects.iter().enumerate() {
        progress("rivals", number as f64 / count as f64);
        let (space, z) = best.fit.space.without(effect, &best.fit.z);
        let Some(without) = Explanation::of(searched, &space, &z, &best.discrepancy, Turns::SOME) else { continue };
        let others: Vec<(&'static Effect, Explanation)> = select::best_additions(searched, &without, RIVALS + 1)
            .into_iter()
            .filter(|(other, _)| other.id != effect.id)
            .take(RIVALS)
            .collect();
        let is_alike = |other: &Explanation| best.evidence - other.evidence < ALIKE;
        let mut alternatives: Vec<Alternative> = others
            .par_iter()
            .map(|(other, explanation)| Alternative {
                id: other.id.to_string(),
                delta_bic: -2.0 * (explanation.evidence - best.evidence),
                holdout_chi: chi_kept(data, &explanation.fit),
            })
            .collect();
        alternatives.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        let rivals = others.iter().filter(|(_, explanation)| is_alike(explanation));
        found.rivals.extend(rivals.clone().map(|(other, x)| Rival { id: other.id, fit: x.fit.clone() }));
        let parameters = sizes(effect, &chosen.fit, intervals);
        found.effects.push(FoundEffect {
            id: effect.id.to_string(),
            says: words::says(effect, &parameters),
            parameters,
            share: shares.effects.get(number).copied().unwrap_or(0.0),
            grade: grade(data, &without, best),
            evidence: Evidence {
                holdout_chi_before: chi_kept(data, &without.fit),
                holdout_chi_after: chi_after,
                delta_bic: -2.0 * (best.evidence - without.evidence),
                p_value: p_value(best.evidence - without.evidence, selection.tried()),
            },
            cannot_be_told_apart_from: rivals.map(|(other, _)| other.id.to_string()).collect(),
            alternatives,
        });
    }
    found.effects.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.effects.extend(suspected(data, searched, selection, chi_after));
    found
}

/// What the last round would have added next, had it been clearer.
fn suspected(data: &Data, searched: &Data, selection: &Selection, chi_before: f64) -> Option<FoundEffect> {
    let best = &selection.chosen;
    let (effect, with) = selection.rounds.last()?.refitted.first()?;
    let rise = with.evidence - best.evidence;
    if !(SUSPECTED..TAKEN).contains(&rise) || best.fit.space.effects.iter().any(|e| e.id == effect.id) {
        return None;
    }
    let deviations = with.fit.deviations();
    let intervals: Vec<Interval> = with
        .fit
        .space
        .coordinates
        .iter()
        .zip(&with.fit.z)
        .zip(&deviations)
        .map(|((c, z), deviation)| Interval::about(c, *z, *deviation))
        .collect();
    let parameters = sizes(effect, &with.fit, &intervals);
    let share = Shares::of(&with.fit).effects.last().copied().unwrap_or(0.0);
    debug_assert!(searched.whitening.is_none());
    Some(FoundEffect {
        id: effect.id.to_string(),
        says: words::says(effect, &parameters),
        parameters,
        share,
        grade: Grade::Suspected,
        evidence: Evidence {
            holdout_chi_before: chi_before,
            holdout_chi_after: chi_kept(data, &with.fit),
            delta_bic: -2.0 * rise,
            p_value: p_value(rise, selection.tried()),
        },
        cannot_be_told_apart_from: Vec::new(),
        alternatives: Vec::new(),
    })
}

/// How far what was kept back bears an effect out.
fn grade(data: &Data, without: &Explanation, with: &Explanation) -> Grade {
    let rise = 0.5 * (without.fit.score.deviance_kept() - with.fit.score.deviance_kept());
    if rise < CONFIRMED {
        Grade::Suspected
    } else if data.runs.iter().any(|run| run.held_out) {
        Grade::ConfirmedOnAnotherProgramme
    } else {
        Grade::OnThisProgrammeOnly
    }
}

/// Probability that the best of so many candidates raises the evidence this far where nothing is missing: an upper bound,
/// by Markov's inequality for the ratio of two probabilities of the data.
pub(crate) fn p_value(rise: f64, tried: usize) -> f64 {
    (tried.max(1) as f64 * (-rise).exp()).min(1.0)
}

/// Sizes of an effect's parameters with their intervals.
fn sizes(effect: &Effect, fit: &Fit, intervals: &[Interval]) -> BTreeMap<String, EffectSize> {
    let places = fit.space.coordinates.iter().zip(intervals);
    places
        .filter_map(|(c, i)| match c.what {
            What::Effect(e, p) if e.id == effect.id => {
                let size = EffectSize { value: i.value, low: i.low, high: i.high, unit: p.unit.to_string() };
                Some((p.key.to_string(), size))
            }
            _ => None,
        })
        .collect()
}

/// chi on what is kept back, over the noise of the sensors.
pub(crate) fn chi_kept(data: &Data, fit: &Fit) -> f64 {
    let left = residuals::plain_at(data, &fit.space, &fit.z);
    left.map_or(f64::NAN, |left| residuals::score(data, &left).chi_kept())
}
