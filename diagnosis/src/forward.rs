//! What: effects are added one at a time, each refitted with everything that may move, judged by data kept back against
//! what chance gives to the best of all candidates; what is no longer needed is taken out again.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sinew_physics::effects::Effect;

use crate::data::{Data, Part};
use crate::derivatives;
use crate::fit::{self, Effort, Fit};
use crate::residuals::{self, Residuals};
use crate::search::{self, Racer};
use crate::significance::{Chance, Colour, by_blocks};
use crate::space::What;
use crate::starts::{self, Candidate};

/// An improvement that chance gives more often than this is none.
pub(crate) const SIGNIFICANT: f64 = 0.01;
/// Least share of the mean square on kept-back data that an effect has to take away to matter.
pub(crate) const MATTERS: f64 = 0.01;
/// chi under which little is left, and the probability by chance from which on no race is run there.
const LITTLE_LEFT: f64 = 1.05;
const WORTH_A_RACE: f64 = 0.05;
/// A rival's mean square on kept-back data is at most this many times that of the best.
const RIVAL: f64 = 1.3;
/// Priors are let go where what is left asks for less than this share of how firmly they hold.
const LOOSER: f64 = 0.7;
/// How often, as each time less is left.
const MOST_RELEASES: usize = 5;
/// Candidates that are fitted in full at every step.
const FINALISTS: usize = 4;
/// Most rounds of adding one; after each the unneeded are taken out.
const MOST_STEPS: usize = 5;

/// One effect that was added.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) effect: &'static Effect,
    pub(crate) p_value: f64,
    /// The candidates of that step, best first by data kept back; those fitted in full come first.
    pub(crate) field: Vec<Racer>,
    pub(crate) full: usize,
}

/// What forward selection came to.
#[derive(Debug, Clone)]
pub(crate) struct Selection {
    pub(crate) fit: Fit,
    pub(crate) steps: Vec<Step>,
    /// Probability of the first step's gain by chance; 1 where nothing gained.
    pub(crate) p_value: f64,
    /// How that was found.
    pub(crate) method: String,
    /// The field of a step that was not taken.
    pub(crate) rejected: Option<(Vec<Racer>, usize)>,
    /// What was added and taken out again.
    pub(crate) pruned: Vec<Candidate>,
    /// The reference model as it is best fitted, where the search found a better one on its way.
    pub(crate) reference: Fit,
}

impl Selection {
    /// The share of what the parameters alone leave that its effects take away.
    pub(crate) fn explained(&self) -> f64 {
        1.0 - self.fit.score.excess() / self.reference.score.excess().max(1e-9)
    }

    /// The same, scored by other data.
    pub(crate) fn judged_by(mut self, data: &Data) -> Option<Selection> {
        let fields = self.steps.iter_mut().map(|step| &mut step.field);
        for racer in fields.chain(self.rejected.iter_mut().map(|(field, _)| field)).flatten() {
            racer.fit = racer.fit.judged_by(data)?;
        }
        (self.fit, self.reference) = (self.fit.judged_by(data)?, self.reference.judged_by(data)?);
        Some(self)
    }
}

/// How residuals of a fit are coloured, by sensor, where the fit sees them: what is kept back has no say in any weight.
pub(crate) fn colours(data: &Data, residuals: &Residuals) -> Vec<Colour> {
    let seen = residuals::only(data, Part::Fitted, residuals);
    (0..data.sensors.len()).map(|s| Colour::of(&seen, s)).collect()
}

/// The mean square of what a fit leaves, in units of noise, times how many samples say the same: as many samples count
/// as one where it is the model that is wrong. 1 where only noise is left.
pub(crate) fn misfit(data: &Data, fit: &Fit) -> Option<f64> {
    let left = fit.residuals(data)?;
    let seen = residuals::only(data, Part::Fitted, &left);
    let (mut sum, mut samples) = (0.0, 0.0);
    for s in 0..data.sensors.len() {
        let colour = Colour::of(&seen, s);
        let count = seen.iter().flat_map(|by_sensor| &by_sensor[s]).filter(|r| !r.is_nan()).count() as f64;
        let blocks: usize = data.runs.iter().map(|run| run.block.last().map_or(0, |b| b + 1)).sum();
        // no error lasts longer than a block, or blocks would say nothing of each other
        sum += count * colour.deviation.powi(2) * colour.inflation().min(count / blocks.max(1) as f64);
        samples += count;
    }
    Some((sum / f64::max(samples, 1.0)).max(1.0))
}

/// A fit whose priors hold more firmly than what it leaves asks for, let go as far as that.
fn let_go(data: &Data, mut fit: Fit) -> Fit {
    for _ in 0..MOST_RELEASES {
        match misfit(data, &fit) {
            Some(misfit) if misfit < LOOSER * fit.space.firmness => {
                let space = fit.space.firm(misfit);
                let objective = fit.score.fitted + space.resistance(&fit.z);
                fit = search::onward(data, Fit { space, objective, ..fit });
            }
            _ => break,
        }
    }
    fit
}

/// Adds effects to `base` while that helps on data kept back.
pub(crate) fn select(
    data: &Data,
    base: Fit,
    windows: &[(f64, f64)],
    seed: u64,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Selection {
    let reference = base.clone();
    let mut selection = Selection {
        fit: base,
        steps: Vec::new(),
        p_value: 1.0,
        method: bootstrap(0),
        rejected: None,
        pruned: Vec::new(),
        reference,
    };
    for number in 0..MOST_STEPS {
        let stage = format!("candidates, round {}", number + 1);
        if !is_worth_a_race(data, &mut selection, windows, seed, number) {
            break;
        }
        let candidates = candidates(data, &selection.fit, windows);
        if candidates.is_empty() {
            break;
        }
        let (mut field, full) = search::race(data, &selection.fit, candidates, FINALISTS, &|f| progress(&stage, f));
        field[..full].sort_by(|a, b| a.fit.score.kept.total_cmp(&b.fit.score.kept));
        let Some(first) = field.first_mut() else { break };
        first.fit = let_go(data, search::onward(data, first.fit.clone()));
        let best = first.clone();
        if kept_gain(&selection.fit, &best.fit) < MATTERS * selection.fit.score.kept {
            selection.rejected = Some((field, full));
            break;
        }
        let better_valley = look_for_better_valley(data, &mut selection, &best);
        let (p_value, method) = chance_of_gain(data, &selection.fit, &field, &best, windows, seed);
        if selection.steps.is_empty() {
            (selection.p_value, selection.method) = (p_value, method);
        }
        let matters = gain_above_noise(data, &selection.fit, &best.fit) > MATTERS * selection.fit.score.kept;
        if !(matters && p_value <= SIGNIFICANT) {
            selection.rejected = Some((field, full));
            if better_valley {
                continue;
            }
            break;
        }
        add(data, &mut selection, field, full, best, p_value);
        // nothing left that could be noticed
        if selection.fit.score.chi_kept().powi(2) < 1.0 + MATTERS {
            break;
        }
    }
    selection
}

/// Where next to nothing is left, the linearised candidates show whether a race of round `number` could find anything.
fn is_worth_a_race(data: &Data, selection: &mut Selection, windows: &[(f64, f64)], seed: u64, number: usize) -> bool {
    if selection.fit.score.chi_kept() < LITTLE_LEFT
        && let Some(chance) = chance(data, &selection.fit, &selection.fit, windows, seed)
    {
        let p_value = chance.p_value(chance.promised());
        if selection.steps.is_empty() {
            (selection.p_value, selection.method) = (p_value, bootstrap(chance.draws()));
        }
        let too_small = chance.promised() < 0.5 * MATTERS * selection.fit.score.kept;
        let nothing_left = selection.fit.score.chi_kept().powi(2) < 1.0 + MATTERS;
        return !(p_value > WORTH_A_RACE || too_small || (nothing_left && number > 0));
    }
    true
}

/// Fits the model without the effect from where the fit with it has led, and takes that where it is better: a better
/// valley of the same model is no effect. Whether it is better by more than nothing.
fn look_for_better_valley(data: &Data, selection: &mut Selection, best: &Racer) -> bool {
    match drop_effect(data, &best.fit, best.candidate.effect) {
        Some(without) if without.objective < selection.fit.objective => {
            let better = without.score.kept < (1.0 - MATTERS) * selection.fit.score.kept;
            if selection.steps.is_empty() {
                selection.reference = without.clone();
            }
            selection.fit = without;
            better
        }
        _ => false,
    }
}

/// Probability that chance gives what the best of a field gains over `base`, and how that was found.
fn chance_of_gain(
    data: &Data,
    base: &Fit,
    field: &[Racer],
    best: &Racer,
    windows: &[(f64, f64)],
    seed: u64,
) -> (f64, String) {
    let gain = kept_gain(base, &best.fit);
    if gain <= 0.0 {
        (1.0, bootstrap(0))
    } else if base.space.firmness > 1.0 {
        chance_by_blocks(data, base, field, seed)
    } else {
        chance(data, base, &best.fit, windows, seed)
            .map_or((1.0, bootstrap(0)), |c| (c.p_value(gain), bootstrap(c.draws())))
    }
}

/// Takes the best of a field into the model, and out of it what is no longer needed. `tested` was found to be more than
/// chance; the others that were fitted in full are carried as far as it first.
fn add(data: &Data, selection: &mut Selection, mut field: Vec<Racer>, full: usize, tested: Racer, p_value: f64) {
    carry_on(data, &mut field[1..full], &tested.fit);
    field[..full].sort_by(|a, b| a.fit.score.kept.total_cmp(&b.fit.score.kept));
    let best = field.first().unwrap_or(&tested).clone();
    selection.fit = best.fit;
    selection.steps.push(Step { effect: best.candidate.effect, p_value, field, full });
    // alone it has just been shown to be needed, unless a polished rival took its place
    if selection.steps.len() > 1 || selection.steps.last().is_some_and(|s| s.effect.id != tested.candidate.effect.id) {
        prune(data, selection);
    }
    if selection.steps.is_empty() {
        // the search has only led to a better valley of the model without
        selection.reference = selection.fit.clone();
        selection.p_value = 1.0;
    }
}

/// Carries those that come near the best as far as it was: which is better is decided between equals.
pub(crate) fn carry_on(data: &Data, field: &mut [Racer], best: &Fit) {
    let near = |racer: &&mut Racer| racer.fit.score.kept < RIVAL * best.score.kept;
    field.par_iter_mut().filter(near).for_each(|racer| {
        racer.fit = let_go(data, search::onward(data, racer.fit.clone()));
    });
}

/// Every start of every effect the model leaves out.
pub(crate) fn candidates(data: &Data, fit: &Fit, windows: &[(f64, f64)]) -> Vec<Candidate> {
    let Some(model) = fit.space.model(&fit.z) else { return Vec::new() };
    starts::missing(&model)
        .into_iter()
        .filter(|e| !fit.space.effects.iter().any(|there| there.id == e.id))
        .flat_map(|e| starts::starts(e, &model, windows, data.longest_s()))
        .collect()
}

/// The fit without an effect, everything else refitted.
pub(crate) fn drop_effect(data: &Data, fit: &Fit, effect: &Effect) -> Option<Fit> {
    let (space, z) = fit.space.without(effect, &fit.z);
    let found = fit::fit(data, &space, &z, Effort::SEARCH)?;
    // worth an exact end only where it might do without
    Some(if found.score.kept < RIVAL * fit.score.kept { search::onward(data, found) } else { found })
}

/// Takes out what is no longer needed now that others are in.
fn prune(data: &Data, selection: &mut Selection) {
    loop {
        let trials: Vec<(&'static Effect, Fit)> = selection
            .fit
            .space
            .effects
            .clone()
            .into_par_iter()
            .filter_map(|effect| Some((effect, drop_effect(data, &selection.fit, effect)?)))
            .collect();
        let Some((effect, fit)) = trials.into_iter().min_by(|a, b| a.1.score.kept.total_cmp(&b.1.score.kept)) else {
            return;
        };
        // an effect that does not matter is not named
        if fit.score.kept > selection.fit.score.kept * (1.0 + MATTERS) {
            return;
        }
        let step = selection.steps.iter().find(|s| s.effect.id == effect.id);
        selection.pruned.extend(step.and_then(|s| s.field.first()).map(|racer| racer.candidate.clone()));
        selection.steps.retain(|s| s.effect.id != effect.id);
        selection.fit = fit;
    }
}

/// How the bootstrap is described.
fn bootstrap(draws: usize) -> String {
    format!(
        "parametric bootstrap with refit, {draws} draws of noise with the spectrum of what is left; the best of all \
         candidates on data kept back is the statistic"
    )
}

/// Probability that chance gives the gain of the first of `field`, or any other a better one, and how that was found.
fn chance_by_blocks(data: &Data, base: &Fit, field: &[Racer], seed: u64) -> (f64, String) {
    let kept = |fit: &Fit| -> Option<Vec<f64>> {
        let left = fit.residuals(data)?;
        let mut sums = BTreeMap::new();
        for sample in residuals::kept(data, &left) {
            *sums.entry((sample.run, sample.block)).or_insert(0.0) += sample.square;
        }
        Some(sums.into_values().collect())
    };
    let Some(before) = kept(base) else { return (1.0, bootstrap(0)) };
    let gains: Vec<Vec<f64>> = field
        .par_iter()
        .filter_map(|racer| Some(before.iter().zip(kept(&racer.fit)?).map(|(before, after)| before - after).collect()))
        .collect();
    let method = format!(
        "the model being wrong by more than noise: signs drawn for the gains of the {} blocks kept back; the best of all \
         candidates is the statistic",
        before.len()
    );
    (by_blocks(&gains, seed), method)
}

/// What chance gives to the best candidate beyond `base`, with noise coloured as what `best` leaves.
fn chance(data: &Data, base: &Fit, best: &Fit, windows: &[(f64, f64)], seed: u64) -> Option<Chance> {
    let here = base.residuals(data)?;
    let nuisances = derivatives::one_sided(data, &base.space, &base.z, &here)?;
    let pulls: Vec<f64> = base.space.pulls().collect();
    let left = best.residuals(data)?;
    let mut seen = Vec::new();
    let candidates: Vec<Candidate> = candidates(data, base, windows)
        .into_iter()
        .filter(|c| {
            let event = c.start.parameters.len() > 2;
            let new = event || !seen.contains(&c.effect.id);
            seen.push(c.effect.id);
            new
        })
        .collect();
    let columns: Vec<Vec<Residuals>> = candidates
        .par_iter()
        .filter_map(|c| {
            let (space, z) = base.space.with(c.effect, &c.start, &base.z);
            let own: Vec<usize> = (base.space.len()..space.len())
                .filter(|i| match &space.coordinates[*i].what {
                    What::Effect(_, p) => p.is_switch(),
                    _ => false,
                })
                .collect();
            let null: Vec<f64> = z.iter().enumerate().map(|(i, z)| if own.contains(&i) { 0.0 } else { *z }).collect();
            let columns: Vec<Residuals> = own
                .iter()
                .filter_map(|i| {
                    let mut moved = null.clone();
                    let amount = if z[*i] == 0.0 { 0.3 } else { z[*i] };
                    moved[*i] = amount;
                    let there = residuals::at(data, &space, &moved)?;
                    Some(residuals::zip(&there, &here, |there, here| (there - here) / amount as f32))
                })
                .collect();
            if columns.is_empty() { None } else { Some(columns) }
        })
        .collect();
    Some(Chance::new(data, &nuisances, &pulls, &columns, &here, &colours(data, &left), seed))
}

/// What a model gains over another on kept-back samples, where a sensor within its noise already has nothing to gain: what
/// a coarse converter rounds away follows the signal, and bends to any parameter.
fn gain_above_noise(data: &Data, worse: &Fit, better: &Fit) -> f64 {
    let squares = |fit: &Fit| {
        let left = fit.residuals(data)?;
        let mut sums = vec![(0.0, 0.0); data.sensors.len()];
        for sample in residuals::kept(data, &left) {
            sums[sample.sensor].0 += sample.square;
            sums[sample.sensor].1 += 1.0;
        }
        Some(sums)
    };
    let (Some(worse), Some(better)) = (squares(worse), squares(better)) else { return 0.0 };
    worse.iter().zip(&better).map(|((worse, count), (better, _))| worse.max(*count) - better.max(*count)).sum()
}

/// What a model gains over another on kept-back samples.
pub(crate) fn kept_gain(worse: &Fit, better: &Fit) -> f64 {
    worse.score.kept - better.score.kept
}
