//! Why every effect that was found is believed: what it gains, and how the others do in its place.

use std::collections::BTreeMap;

use crate::answer::{Alternative, EffectSize, Evidence, FoundEffect};
use crate::data::Data;
use crate::fit::Fit;
use crate::forward::{self, Selection, Step};
use crate::intervals::Interval;
use crate::search::{self, Racer};
use crate::space::What;
use crate::starts::Candidate;
use crate::words;

/// Rivals of one of several effects that are raced, and of these how many are refitted in full.
const RIVALS: usize = 5;
const RIVALS_REFITTED: usize = 3;
/// Two explanations whose likelihoods differ less than this (2 Δ ln L per effective sample) cannot be distinguished.
const ALIKE: f64 = 12.0;

/// A rival that explains the recording as well as what was found.
pub(crate) struct Rival {
    pub(crate) id: &'static str,
    pub(crate) fit: Fit,
}

/// Another effect in the place of one that was found.
struct InPlace {
    alternative: Alternative,
    /// It explains the recording as well.
    alike: bool,
    racer: Racer,
}

/// The effects of a selection in the order of their weight, and the rivals of any of them. `chosen` is the same fit
/// carried to its end, with its `intervals`; one sample in `inflation` counts.
pub(crate) fn found_effects(
    data: &Data,
    selection: &Selection,
    chosen: &Fit,
    intervals: &[Interval],
    inflation: f64,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> (Vec<FoundEffect>, Vec<Rival>) {
    let fit = &selection.fit;
    let mut found: Vec<(f64, FoundEffect)> = Vec::new();
    let mut rivals = Vec::new();
    let count = fit.space.effects.len();
    for (number, effect) in fit.space.effects.iter().enumerate() {
        progress("rivals", number as f64 / count as f64);
        let Some(step) = selection.steps.iter().find(|s| s.effect.id == effect.id) else { continue };
        let Some(without) = forward::drop_effect(data, fit, effect) else { continue };
        let others = in_place(data, selection, step, &without, inflation);
        for other in others.iter().filter(|other| other.alike) {
            if let Some(e) = other.racer.fit.space.effects.last() {
                rivals.push(Rival { id: e.id, fit: other.racer.fit.clone() });
            }
        }
        let parameters: BTreeMap<String, EffectSize> = fit
            .space
            .coordinates
            .iter()
            .zip(intervals)
            .filter_map(|(c, i)| match c.what {
                What::Effect(e, p) if e.id == effect.id => Some((
                    p.key.to_string(),
                    EffectSize { value: i.value, low: i.low, high: i.high, unit: p.unit.to_string() },
                )),
                _ => None,
            })
            .collect();
        let weight = forward::kept_gain(&without, fit);
        found.push((
            weight,
            FoundEffect {
                id: effect.id.to_string(),
                says: words::says(effect, &parameters),
                parameters,
                evidence: Evidence {
                    holdout_chi_before: without.score.chi_kept(),
                    holdout_chi_after: chosen.score.chi_kept(),
                    delta_bic: fit.bic(inflation) - without.bic(inflation),
                    p_value: step.p_value,
                },
                cannot_be_told_apart_from: others
                    .iter()
                    .filter(|o| o.alike)
                    .map(|o| o.alternative.id.clone())
                    .collect(),
                alternatives: others.into_iter().map(|o| o.alternative).collect(),
            },
        ));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    (found.into_iter().map(|(_, f)| f).collect(), rivals)
}

/// The effects that were fitted in the place of a step's, best first by data kept back.
fn in_place(data: &Data, selection: &Selection, step: &Step, without: &Fit, inflation: f64) -> Vec<InPlace> {
    let fit = &selection.fit;
    let mut others: Vec<InPlace> = rivals_of(data, selection, step, without)
        .into_iter()
        .filter_map(|racer| {
            let other = &racer.fit;
            let id = other.space.effects.last()?.id;
            let alike = (other.likelihood(inflation) - fit.likelihood(inflation)) < ALIKE
                && other.score.kept - fit.score.kept < ALIKE * inflation;
            let alternative = Alternative {
                id: id.to_string(),
                delta_bic: other.bic(inflation) - fit.bic(inflation),
                holdout_chi: other.score.chi_kept(),
            };
            Some(InPlace { alternative, alike, racer })
        })
        .collect();
    others.sort_by(|a, b| a.alternative.holdout_chi.total_cmp(&b.alternative.holdout_chi));
    others
}

/// Others in the place of a step's effect: those that did best when it was chosen, and what it took the place of.
fn rivals_of(data: &Data, selection: &Selection, step: &Step, without: &Fit) -> Vec<Racer> {
    let fit = &selection.fit;
    let alone = fit.space.effects.len() == 1 && step.field.iter().all(|racer| racer.fit.space.effects.len() == 1);
    if alone {
        let refitted = &step.field[..step.full];
        return refitted.iter().filter(|racer| racer.candidate.effect.id != step.effect.id).cloned().collect();
    }
    let best = step.field.iter().map(|racer| &racer.candidate).take(RIVALS);
    let candidates: Vec<Candidate> = best
        .chain(&selection.pruned)
        .filter(|c| !fit.space.effects.iter().any(|e| e.id == c.effect.id))
        .cloned()
        .collect();
    let (mut field, full) = search::race(data, without, candidates, RIVALS_REFITTED, &|_| ());
    field.truncate(full);
    forward::carry_on(data, &mut field, fit);
    field
}
