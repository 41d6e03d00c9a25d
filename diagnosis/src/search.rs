//! Which model: the reference refitted from many starts, and candidates raced against each other.

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::derivatives;
use crate::fit::{self, Effort, Fit};
use crate::products;
use crate::progress::each;
use crate::residuals;
use crate::space::{Coordinate, Space};
use crate::starts::Candidate;

/// Starts of the reference model drawn from the priors, besides the rig file's values themselves.
const RANDOM_STARTS: usize = 2;
/// Spread of those starts, in σ of the priors.
const START_SPREAD: f64 = 0.8;
/// Iterations after which the worse starts are given up.
const TRIAL_ITERATIONS: usize = 5;
/// chi under which a fit leaves nothing that another start could explain better.
const EXPLAINED: f64 = 1.05;

/// Fits with the noise taken large at first and smaller in steps: the large features of the recording lead, and the
/// parameters stay where they are believed until the data insist.
pub(crate) fn anneal(data: &Data, space: &Space, start: &[f64], effort: Effort) -> Option<Fit> {
    let first = residuals::score(data, &residuals::at(data, space, start)?);
    let mut soften = first.chi_fitted();
    let mut z = start.to_vec();
    while soften > 3.0 {
        let softened = Effort { iterations: 3, soften, relative: 1e-2, ..Effort::SEARCH };
        z = fit::fit(data, space, &z, softened)?.z;
        soften = soften.sqrt().max(1.0) * if soften > 30.0 { 1.0 } else { 0.5 };
    }
    fit::fit(data, space, &z, effort)
}

/// The best fit of a space from its believed values and from starts drawn from the priors.
/// Gives also how many of the starts that were carried through end as well as the best.
pub(crate) fn multistart(data: &Data, space: &Space, seed: u64) -> Option<(Fit, Agreement)> {
    // what is believed leads where the recording is explained: nothing can be better than noise
    let believed = anneal(data, space, &vec![0.0; space.len()], Effort::SEARCH)?;
    let believed = onward(data, believed);
    if believed.score.chi_fitted() < EXPLAINED {
        return Some((believed, Agreement { carried: 1, alike: 1 }));
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5ee_d0f5);
    let normal = Normal::new(0.0, START_SPREAD).ok()?;
    let starts: Vec<Vec<f64>> = (0..RANDOM_STARTS)
        .map(|_| {
            let draw = |c: &Coordinate| if c.pull > 0.0 { normal.sample(&mut rng).clamp(c.low, c.high) } else { 0.0 };
            space.coordinates.iter().map(draw).collect()
        })
        .collect();
    let drawn = starts
        .par_iter()
        .filter_map(|start| anneal(data, space, start, Effort::iterations(TRIAL_ITERATIONS)))
        .min_by(|a, b| a.objective.total_cmp(&b.objective));
    let drawn = drawn.map(|fit| if fit.converged { fit } else { onward(data, fit) });
    let mut carried: Vec<Fit> = drawn.into_iter().chain([believed]).collect();
    carried.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    let best = carried.first()?.clone();
    let good = carried.iter().filter(|f| f.objective <= best.objective * 1.01 + 10.0).count();
    let agreement = Agreement { carried: carried.len(), alike: good };
    Some((best, agreement))
}

/// The fit carried on: to its end where that may explain everything, far enough to compare it where it cannot.
pub(crate) fn onward(data: &Data, fit: Fit) -> Fit {
    if fit.score.chi_fitted() < 2.0 * EXPLAINED {
        return polish(data, fit);
    }
    fit::fit(data, &fit.space, &fit.z, Effort::SEARCH).unwrap_or(fit)
}

/// The fit carried to its end.
pub(crate) fn polish(data: &Data, fit: Fit) -> Fit {
    match fit::fit(data, &fit.space, &fit.z, Effort::POLISH) {
        Some(polished) if polished.objective <= fit.objective => polished,
        _ => fit,
    }
}

/// How far the starts agree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Agreement {
    pub(crate) carried: usize,
    pub(crate) alike: usize,
}

/// One candidate on its way.
#[derive(Debug, Clone)]
pub(crate) struct Racer {
    pub(crate) candidate: Candidate,
    pub(crate) fit: Fit,
}

/// Steps every candidate gets with the derivatives of the base, and iterations the better ones get with their own.
const SKETCH_STEPS: usize = 3;
const TRIAL: usize = 2;
/// How many get that far: this share of the field, at least this many times the finalists.
const TRIED_SHARE: f64 = 0.2;
const TRIED_LEAST: usize = 2;

/// The derivatives at a fit, for sketches of what may be added to it.
pub(crate) struct Shared {
    columns: nalgebra::DMatrix<f32>,
    gram: nalgebra::DMatrix<f64>,
}

impl Shared {
    pub(crate) fn of(data: &Data, base: &Fit) -> Option<Shared> {
        let here = base.residuals(data)?;
        let columns = derivatives::one_sided(data, &base.space, &base.z, &here)?;
        let columns = products::matrix(data, Part::Fitted, &columns.iter().collect::<Vec<_>>());
        let gram = products::square(&columns);
        Some(Shared { columns, gram })
    }

    /// A candidate after a few cheap steps.
    pub(crate) fn sketch(&self, data: &Data, base: &Fit, candidate: &Candidate) -> Option<Fit> {
        let (space, z) = base.space.with(candidate.effect, &candidate.start, &base.z);
        fit::sketch(data, &space, &z, &self.columns, &self.gram, SKETCH_STEPS)
    }
}

/// Races candidates from `base`: all get a few cheap steps, the better ones real iterations, the best a full fit.
/// The order is by what the fit sees; data kept back is not looked at. Gives every candidate effect's best racer,
/// best first, and how many of them are fitted in full.
pub(crate) fn race(
    data: &Data,
    base: &Fit,
    candidates: Vec<Candidate>,
    finalists: usize,
    progress: &(dyn Fn(f64) + Sync),
) -> (Vec<Racer>, usize) {
    let Some(shared) = Shared::of(data, base) else { return (Vec::new(), 0) };
    let mut field: Vec<Racer> = each(candidates, 0.3, progress, |candidate| {
        let fit = shared.sketch(data, base, &candidate)?;
        Some(Racer { candidate, fit })
    });
    drop(shared);
    sort(&mut field);
    let tried = ((field.len() as f64 * TRIED_SHARE) as usize).max(TRIED_LEAST * finalists).min(field.len());
    field[..tried].par_iter_mut().for_each(|racer| go_on(data, racer, TRIAL));
    progress(0.6);
    sort(&mut field);
    one_each(&mut field);
    let full = finalists.min(field.len());
    field[..full].par_iter_mut().for_each(|racer| go_on(data, racer, Effort::SEARCH.iterations));
    sort(&mut field[..full]);
    progress(1.0);
    (field, full)
}

fn go_on(data: &Data, racer: &mut Racer, iterations: usize) {
    if !racer.fit.converged
        && let Some(fit) = fit::fit(data, &racer.fit.space, &racer.fit.z, Effort::iterations(iterations))
        && fit.objective <= racer.fit.objective
    {
        racer.fit = fit;
    }
}

fn sort(field: &mut [Racer]) {
    field.sort_by(|a, b| a.fit.objective.total_cmp(&b.fit.objective));
}

/// Keeps the best racer of every effect, in order.
fn one_each(field: &mut Vec<Racer>) {
    let mut seen: Vec<&'static str> = Vec::new();
    field.retain(|racer| {
        let new = !seen.contains(&racer.candidate.effect.id);
        if new {
            seen.push(racer.candidate.effect.id);
        }
        new
    });
}
