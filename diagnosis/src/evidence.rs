//! Why every effect that was found is believed: what the evidence falls by without it, and how others do in its place.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rayon::prelude::*;
use sinew_physics::effects::Effect;

use crate::answer::{Alternative, EffectSize, Evidence, FoundEffect, Grade, Tried};
use crate::data::Data;
use crate::explanation::Explanation;
use crate::fit::Fit;
use crate::grade::chi_kept;
use crate::intervals::Interval;
use crate::select::{InPlace, Selection, TAKEN};
use crate::shares::Shares;
use crate::space::What;
use crate::words;

/// Two explanations whose log evidence differs less than this cannot be distinguished.
const ALIKE: f64 = 5.0;
/// Rise of the log evidence from which an effect that was not taken is suspected.
const SUSPECTED: f64 = 4.0;

/// A rival that explains the recording as well as what was found.
pub(crate) struct Rival {
    pub(crate) id: &'static str,
    pub(crate) fit: Fit,
}

/// What the effects of a selection are believed for.
#[derive(Default)]
pub(crate) struct Found {
    /// In the order of their shares.
    pub(crate) effects: Vec<FoundEffect>,
    /// Explanations as good, with another effect in the place of one found.
    pub(crate) rivals: Vec<Rival>,
}

/// Judges the effects of a selection on all of `data`, where `chosen` is carried to its end, with its
/// `intervals`.
pub(crate) fn judge(data: &Data, selection: &Selection, chosen: &Explanation, intervals: &[Interval]) -> Found {
    let best = &selection.chosen;
    let shares = Shares::of(&chosen.fit);
    let chi_after = chi_kept(data, &chosen.fit);
    let mut found = Found::default();
    for InPlace { effect, borne_out, without, others } in &selection.in_place {
        let mut alternatives: Vec<Alternative> = others
            .par_iter()
            .map(|(other, explanation)| Alternative {
                id: other.id.to_string(),
                delta_bic: -2.0 * (explanation.evidence - best.evidence),
                holdout_chi: chi_kept(data, &explanation.fit),
            })
            .collect();
        alternatives.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        let alike: Vec<&(&'static Effect, Explanation)> =
            others.iter().filter(|(_, explanation)| best.evidence - explanation.evidence < ALIKE).collect();
        found.rivals.extend(alike.iter().map(|(other, x)| Rival { id: other.id, fit: x.fit.clone() }));
        let place = chosen.fit.space.effects.iter().position(|e| e.id == effect.id);
        let parameters = sizes(effect, &chosen.fit, intervals);
        found.effects.push(FoundEffect {
            id: effect.id.to_string(),
            says: words::says(effect, &parameters),
            parameters,
            share: place.and_then(|place| shares.effects.get(place)).copied().unwrap_or(0.0),
            grade: borne_out.grade,
            evidence: Evidence {
                holdout_chi_before: chi_kept(data, &without.fit),
                holdout_chi_after: chi_after,
                delta_bic: -2.0 * (best.evidence - without.evidence),
                p_value: p_value(best.evidence - without.evidence, selection.tried()),
                holdout_rise: borne_out.rise,
            },
            cannot_be_told_apart_from: alike.iter().map(|(other, _)| other.id.to_string()).collect(),
            alternatives,
        });
    }
    // what is borne out comes first: a share says nothing of that
    let weight = |effect: &FoundEffect| (effect.grade != Grade::Suspected, effect.share);
    found.effects.sort_by(|a, b| weight(b).partial_cmp(&weight(a)).unwrap_or(Ordering::Equal));
    found.effects.extend(next_in_line(data, selection));
    found
}

/// Effects none of which what was kept back bears out: they are suspected, and the model is the one without.
pub(crate) fn suspects(data: &Data, selection: &Selection) -> Vec<FoundEffect> {
    let places = selection.in_place.iter();
    let mut found: Vec<FoundEffect> =
        places.map(|place| suspect(data, selection, place.effect, &selection.chosen, &place.without)).collect();
    found.extend(next_in_line(data, selection));
    found
}

/// What the last round would have added next, had it been clearer.
fn next_in_line(data: &Data, selection: &Selection) -> Option<FoundEffect> {
    let best = &selection.chosen;
    let (effect, with) = selection.rounds.last()?.refitted.first()?;
    let is_new = best.fit.space.effects.iter().all(|e| e.id != effect.id);
    let rise = with.evidence - best.evidence;
    (is_new && (SUSPECTED..TAKEN).contains(&rise)).then(|| suspect(data, selection, effect, with, best))
}

/// An effect that is in the model `with` and in no other.
fn suspect(
    data: &Data,
    selection: &Selection,
    effect: &'static Effect,
    with: &Explanation,
    without: &Explanation,
) -> FoundEffect {
    let fit = &with.fit;
    let places = fit.space.coordinates.iter().zip(&fit.z).zip(fit.deviations());
    let intervals: Vec<Interval> = places.map(|((c, z), deviation)| Interval::about(c, *z, deviation)).collect();
    let parameters = sizes(effect, fit, &intervals);
    let place = fit.space.effects.iter().position(|e| e.id == effect.id);
    let shares = Shares::of(fit).effects;
    let rise = with.evidence - without.evidence;
    FoundEffect {
        id: effect.id.to_string(),
        says: words::says(effect, &parameters),
        parameters,
        share: place.and_then(|place| shares.get(place)).copied().unwrap_or(0.0),
        grade: Grade::Suspected,
        evidence: Evidence {
            holdout_chi_before: chi_kept(data, &without.fit),
            holdout_chi_after: chi_kept(data, fit),
            delta_bic: -2.0 * rise,
            p_value: p_value(rise, selection.tried()),
            holdout_rise: with.rise_on_kept(data, without),
        },
        cannot_be_told_apart_from: Vec::new(),
        alternatives: Vec::new(),
    }
}

/// Every model that a selection tried, the best on what was kept back first.
pub(crate) fn tried(data: &Data, selection: &Selection) -> Vec<Tried> {
    let names = |x: &Explanation| x.fit.space.effects.iter().map(|e| e.id.to_string()).collect::<Vec<_>>();
    let row = |x: &Explanation| Tried {
        effects: names(x),
        holdout_chi: chi_kept(data, &x.fit),
        delta_bic: -2.0 * (x.evidence - selection.reference.evidence),
        chosen: names(x) == names(&selection.chosen),
        screened: false,
    };
    let mut all = vec![row(&selection.chosen), row(&selection.reference)];
    for round in &selection.rounds {
        all.extend(round.refitted.iter().map(|(_, x)| row(x)));
        // what screening alone says of the others, beside what it was added to
        let base = row(&round.base);
        all.extend(round.screened.iter().map(|s| Tried {
            effects: base.effects.iter().cloned().chain([s.candidate.effect.id.to_string()]).collect(),
            delta_bic: base.delta_bic - 2.0 * s.gain,
            chosen: false,
            screened: true,
            ..base.clone()
        }));
    }
    let mut seen: Vec<Vec<String>> = Vec::new();
    all.retain(|t| {
        let new = !seen.contains(&t.effects);
        seen.push(t.effects.clone());
        new
    });
    all.sort_by(|a, b| a.holdout_chi.total_cmp(&b.holdout_chi));
    all
}

/// Suspects what is needed in the long rows of a search only, and not where all of `data` are simulated as they are.
pub(crate) fn regrade(data: &Data, selection: &mut Selection) {
    let Some(chosen) = selection.chosen.on(data) else { return };
    selection.in_place.par_iter_mut().filter(|place| place.is_borne_out()).for_each(|place| {
        let rise = place.without.on(data).map_or(f64::INFINITY, |without| chosen.evidence - without.evidence);
        if rise < TAKEN {
            place.borne_out.grade = Grade::Suspected;
        }
    });
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
