//! Outside the catalogue: whether what is left has a structure that noise has not, and the sparse closed form of the
//! guilty equation that explains most of it.

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rayon::prelude::*;
use sinew_physics::effects::{self, Effect, Nature};

use crate::data::{Data, Part};
use crate::fit::{self, Effort, Fit, Residuals};
use crate::forward::{MATTERS, SIGNIFICANT};
use crate::progress::each;
use crate::search::{Shared, polish};
use crate::significance::{Colour, draw_noise};
use crate::simulate::State;
use crate::space::{EFFECT_STEP, Start, What};
use crate::starts::Candidate;

/// Draws of noise for the test of structure.
const DRAWS: u64 = 200;
/// What is left matters from here on: predicted share of the mean square, and correlation between two sensors.
const LEAST_SHARE: f64 = 0.05;
const LEAST_CORRELATION: f64 = 0.3;
/// Terms of a closed form at most.
const MOST_TERMS: usize = 3;
/// The first term has to take away this share of what noise leaves unexplained: less is no description.
const WORTH_WRITING: f64 = 0.25;
/// A further term has to take away this share of what the last one left.
const TERM_GAIN: f64 = 0.1;

/// Whether what is left depends on the wire's state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Structure {
    /// Probability by noise of the same colour.
    pub(crate) p_value: f64,
}

/// Two things that noise of sensors does not do, whatever its colour: know the state of the wire (means over cells of
/// the state are learned from what is fitted and tried on what is kept back), and agree between sensors.
pub(crate) fn structure(data: &Data, fit: &Fit, residuals: &Residuals, colours: &[Colour], seed: u64) -> Structure {
    let none = Structure { p_value: 1.0 };
    let Some(states) = fit.states(data) else { return none };
    let cells = cells(data, &states);
    let share = |residuals: &Residuals| cells.iter().map(|c| predicted_share(data, residuals, c)).fold(0.0, f64::max);
    let (known, shared) = (share(residuals), correlation(data, residuals));
    let (above_known, above_shared): (Vec<bool>, Vec<bool>) = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(0xbe70 + draw));
            let noise = draw_noise(data, colours, &mut rng);
            (share(&noise) >= known, correlation(data, &noise) >= shared)
        })
        .unzip();
    let p = |above: &[bool]| (above.iter().filter(|a| **a).count() + 1) as f64 / (DRAWS + 1) as f64;
    // what is too small to matter is none, however sure
    let p_known = if known > LEAST_SHARE { p(&above_known) } else { 1.0 };
    let p_shared = if shared > LEAST_CORRELATION { p(&above_shared) } else { 1.0 };
    Structure { p_value: (2.0 * p_known.min(p_shared)).min(1.0) }
}

/// The largest correlation between the residuals of two sensors.
fn correlation(data: &Data, residuals: &Residuals) -> f64 {
    let mut largest = 0.0f64;
    for a in 0..data.sensors.len() {
        for b in 0..a {
            let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
            for by_sensor in residuals {
                for (x, y) in by_sensor[a].iter().zip(&by_sensor[b]) {
                    let (x, y) = (f64::from(*x), f64::from(*y));
                    if !(x * y).is_nan() {
                        ab += x * y;
                        aa += x * x;
                        bb += y * y;
                    }
                }
            }
            if aa > 0.0 && bb > 0.0 {
                largest = largest.max(ab.abs() / (aa * bb).sqrt());
            }
        }
    }
    largest
}

/// The cell of every sample, by run, for several ways to divide the states.
fn cells(data: &Data, states: &[Vec<State>]) -> Vec<Vec<Vec<usize>>> {
    let quantiles = |f: &dyn Fn(&State) -> f64| -> Vec<f64> {
        let mut values: Vec<f64> = states.iter().flatten().map(f).collect();
        values.sort_by(f64::total_cmp);
        (1..12).map(|i| values[(values.len() - 1) * i / 12]).collect()
    };
    let by = |f: &dyn Fn(&State) -> f64| -> Vec<Vec<usize>> {
        let edges = quantiles(f);
        states
            .iter()
            .zip(&data.runs)
            .map(|(states, run)| {
                let middle = 0.5 * run.inputs.iter().fold(f64::NEG_INFINITY, |most, (i, _)| most.max(i.drive));
                states
                    .iter()
                    .zip(&run.inputs)
                    .map(|(s, (inputs, _))| {
                        let place = edges.partition_point(|e| *e < f(s));
                        place * 4 + 2 * usize::from(s.warming_k < 0.0) + usize::from(inputs.drive > middle)
                    })
                    .collect()
            })
            .collect()
    };
    vec![by(&|s| s.temperature_c), by(&|s| s.martensite), by(&|s| s.position_m)]
}

fn predicted_share(data: &Data, residuals: &Residuals, cells: &[Vec<usize>]) -> f64 {
    let (mut before, mut after) = (0.0, 0.0);
    for s in 0..data.sensors.len() {
        let mut sums = vec![(0.0, 0.0); 4 * 13];
        for ((run, by_sensor), cells) in data.runs.iter().zip(residuals).zip(cells) {
            for ((r, part), cell) in by_sensor[s].iter().zip(&run.part).zip(cells) {
                if *part == Part::Fitted && !r.is_nan() {
                    sums[*cell].0 += f64::from(*r);
                    sums[*cell].1 += 1.0;
                }
            }
        }
        for ((run, by_sensor), cells) in data.runs.iter().zip(residuals).zip(cells) {
            for ((r, part), cell) in by_sensor[s].iter().zip(&run.part).zip(cells) {
                if *part == Part::KeptBack && !r.is_nan() {
                    let (sum, count) = sums[*cell];
                    let mean = sum / f64::max(count, 1.0);
                    before += f64::from(*r).powi(2);
                    after += (f64::from(*r) - mean).powi(2);
                }
            }
        }
    }
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}

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
pub(crate) fn closed_form(data: &Data, base: &Fit, progress: &(dyn Fn(f64) + Sync)) -> Option<ClosedForm> {
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

impl Structure {
    /// Whether it is more than noise does, and more than nothing.
    pub(crate) fn is_there(&self) -> bool {
        self.p_value <= SIGNIFICANT
    }
}
