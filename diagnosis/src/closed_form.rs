//! The sparse closed form, of terms of one equation, that explains most of what no effect of the catalogue does.

use rayon::prelude::*;
use sinew_physics::effects::{self, Effect, Nature};

use crate::data::Data;
use crate::fit::{self, Effort, Fit};
use crate::forward::MATTERS;
use crate::progress::each;
use crate::search::{Shared, polish};
use crate::space::{EFFECT_STEP, Start, What};
use crate::starts::Candidate;

/// Terms of a closed form at most.
const MOST_TERMS: usize = 3;

/// The first term has to take away this share of what noise leaves unexplained: less is no description.
const WORTH_WRITING: f64 = 0.25;

/// A further term has to take away this share of what the last one left.
const TERM_GAIN: f64 = 0.1;

/// A sparse closed form.
pub(crate) struct ClosedForm {
    /// The library its terms are from.
    pub(crate) library: &'static Effect,
    pub(crate) fit: Fit,
    /// Σ r² with its first term alone.
    pub(crate) left_by_one: f64,
}

/// The best sparse closed form beyond `base`: terms of one equation's library, added while each takes away enough on
/// data kept back.
pub(crate) fn search(data: &Data, base: &Fit, progress: &(dyn Fn(f64) + Sync)) -> Option<ClosedForm> {
    let model = base.space.model(&base.z)?;
    let libraries: Vec<&'static Effect> = effects::catalogue()
        .filter(|e| e.nature == Nature::Empirical && e.applies_to(&model) && e.is_null(&model))
        .collect();
    let first: Vec<Candidate> = libraries.iter().flat_map(|e| terms(e, base)).collect();
    let shared = Shared::of(data, base)?;
    let mut tried: Vec<(&'static Effect, Fit)> = each(first, 0.7, progress, |candidate| {
        let fit = shared.sketch(data, base, &candidate)?;
        Some((candidate.effect, fit))
    });
    tried.sort_by(|a, b| a.1.objective.total_cmp(&b.1.objective));
    tried.truncate(4);
    let (effect, mut best) = tried
        .into_par_iter()
        .filter_map(|(e, f)| Some((e, fit::fit(data, &f.space, &f.z, Effort::SEARCH)?)))
        .min_by(|a, b| a.1.score.kept.total_cmp(&b.1.score.kept))?;
    if base.score.kept - best.score.kept < WORTH_WRITING * (base.score.kept - base.score.kept_count) {
        return None;
    }
    let left_by_one = best.score.sum();
    for term in 1..MOST_TERMS {
        progress(0.7 + 0.1 * term as f64);
        let Some(shared) = Shared::of(data, &best) else { break };
        let mut next: Vec<Fit> =
            terms(effect, &best).into_par_iter().filter_map(|c| shared.sketch(data, &best, &c)).collect();
        next.sort_by(|a, b| a.objective.total_cmp(&b.objective));
        next.truncate(2);
        let Some(further) = next
            .into_par_iter()
            .filter_map(|f| fit::fit(data, &f.space, &f.z, Effort::SEARCH))
            .min_by(|a, b| a.score.kept.total_cmp(&b.score.kept))
        else {
            break;
        };
        let left = best.score.kept - best.score.kept_count;
        if best.score.kept - further.score.kept < (TERM_GAIN * left).max(MATTERS * best.score.kept) {
            break;
        }
        best = further;
    }
    Some(ClosedForm { library: effect, fit: polish(data, best), left_by_one })
}

/// One candidate per term of a library that is not in the fit yet.
fn terms(effect: &'static Effect, fit: &Fit) -> Vec<Candidate> {
    let there = |key: &str| {
        fit.space.coordinates.iter().any(|c| c.is_of(effect) && matches!(c.what, What::Effect(_, p) if p.key == key))
    };
    effect
        .parameters
        .iter()
        .enumerate()
        .filter(|(_, p)| !there(p.key))
        .map(|(only, _)| Candidate {
            effect,
            start: Start {
                parameters: effect
                    .parameters
                    .iter()
                    .enumerate()
                    .map(|(i, p)| {
                        let scale = if i == only { p.plausible.1.abs().max(p.plausible.0.abs()) } else { 0.0 };
                        (0.0, scale, 0.05, EFFECT_STEP)
                    })
                    .collect(),
                times_s: (0.0, 0.0),
            },
        })
        .collect()
}
