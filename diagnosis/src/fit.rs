//! Bounded least squares through the simulator: Levenberg–Marquardt with numerical derivatives whose steps are large
//! enough for hysteresis, priors as residuals of their own, and bounds by projection.

use nalgebra::{DMatrix, DVector};

use crate::data::{Data, Part};
use crate::derivatives::{self, Steps};
use crate::products::{flat, matrix, square};
use crate::residuals::{self, Residuals, Score, zip};
use crate::simulate::{self, State};
use crate::space::Space;

/// The end of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) space: Space,
    pub(crate) z: Vec<f64>,
    pub(crate) score: Score,
    /// What was minimised: Σ r² over the fitted samples, plus the priors.
    pub(crate) objective: f64,
    /// JᵀJ of the last derivatives, priors included.
    pub(crate) information: DMatrix<f64>,
    /// The last step promised less than counts.
    pub(crate) converged: bool,
}

/// How long a fit goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) iterations: usize,
    /// Residuals count as if the noise were this many times larger: makes the way through rough country smoother.
    pub(crate) soften: f64,
    /// A step that promises less than this share of what the objective has above pure noise ends the fit …
    pub(crate) relative: f64,
    /// Derivatives to go by, one after the other, each until it sees no way on.
    pub(crate) steps: &'static [Steps],
}

/// … or less than this: a tenth of what a parameter one standard deviation off costs.
const NEGLIGIBLE: f64 = 0.1;

/// Steps that gain less than a quarter of that standard deviation's cost, and next to nothing of what is above noise, though
/// they promised more: where the country is rough, so many in a row are the end of the way.
const CRAWL: f64 = 0.25;

const CRAWL_SHARE: f64 = 1e-4;

const MOST_CRAWLS: usize = 3;

/// A step that gains this share of what it promised needs no bending …
const AS_PROMISED: f64 = 0.75;

/// … and after one that gains this share the next may be longer.
const FAIR: f64 = 0.25;

/// Damping that is as good as none, relative to the curvature along each coordinate.
const LEAST_DAMPING: f64 = 1e-9;

impl Effort {
    /// To the end: where intervals and likelihoods are taken from.
    pub(crate) const POLISH: Effort =
        Effort { iterations: 25, soften: 1.0, relative: 1e-4, steps: &[Steps::CENTRAL, Steps::SHARP] };
    /// Far enough to see how good a model is.
    pub(crate) const SEARCH: Effort =
        Effort { iterations: 10, soften: 1.0, relative: 5e-3, steps: &[Steps::ONE_SIDED] };

    pub(crate) fn iterations(iterations: usize) -> Effort {
        Effort { iterations, ..Effort::SEARCH }
    }
}

/// A place on the way of a fit.
struct Place {
    z: Vec<f64>,
    residuals: Residuals,
    score: Score,
    objective: f64,
}

impl Place {
    /// `None` where the model cannot be built.
    fn new(data: &Data, space: &Space, z: Vec<f64>, weight: f64) -> Option<Place> {
        let residuals = residuals::at(data, space, &z)?;
        let score = residuals::score(data, &residuals);
        let objective = weight * score.fitted + space.resistance(&z);
        Some(Place { z, residuals, score, objective })
    }
}

/// Fits from `start`. `None` where the start itself is impossible.
///
/// Levenberg–Marquardt, its steps bent along with the valley (geodesic acceleration, Transtrum and Sethna 2012): where
/// parameters make up for each other the valley is narrow and winds, and straight steps crawl along it.
pub(crate) fn fit(data: &Data, space: &Space, start: &[f64], effort: Effort) -> Option<Fit> {
    let n = space.len();
    let weight = 1.0 / (effort.soften * effort.soften);
    let pull = DVector::from_iterator(n, space.pulls());
    let start: Vec<f64> = space.coordinates.iter().zip(start).map(|(c, z)| z.clamp(c.low, c.high)).collect();
    let mut here = Place::new(data, space, start, weight)?;
    let mut damping = 1e-3;
    let mut information = DMatrix::identity(n, n);
    let mut converged = n == 0;
    let mut stage = 0;
    let mut slow = 0;
    for _ in 0..effort.iterations {
        if converged {
            break;
        }
        let columns = derivatives::by(data, space, &here.z, &here.residuals, effort.steps[stage])?;
        // the residuals are the last column: their products with the others are the gradient
        let all: Vec<&Residuals> = columns.iter().chain([&here.residuals]).collect();
        let all = matrix(data, Part::Fitted, &all);
        let products = square(&all) * weight;
        information = products.view((0, 0), (n, n)).into_owned();
        let mut gradient: DVector<f64> = products.view((0, n), (n, 1)).column(0).into_owned();
        for i in 0..n {
            information[(i, i)] += pull[i];
            gradient[i] += pull[i] * here.z[i];
        }
        let above_noise = (here.objective - weight * here.score.fitted_count).max(0.0);
        let mut next = None;
        for attempt in 0..8 {
            let (step, promised) = bounded_step(space, &here.z, &information, &gradient, damping);
            if promised < NEGLIGIBLE * space.firmness + effort.relative * above_noise {
                // damping hides the way along a valley that the data hardly slope: look without before calling it the end
                if damping > LEAST_DAMPING && attempt == 0 {
                    damping = LEAST_DAMPING;
                    continue;
                }
                break;
            }
            let by = |from: &[f64], step: &DVector<f64>| {
                let moved = from.iter().zip(step.iter()).map(|(z, s)| z + s).collect();
                Place::new(data, space, moved, weight)
            };
            if let Some(straight) = by(&here.z, &step) {
                let mut best = straight;
                if best.objective > here.objective - AS_PROMISED * promised {
                    let bend = bend(data, &all, &best.residuals, &step) * weight;
                    let (correction, _) = bounded_step(space, &best.z, &information, &bend, damping);
                    best = by(&best.z, &correction).filter(|bent| bent.objective < best.objective).unwrap_or(best);
                }
                let gained = here.objective - best.objective;
                if gained > 0.0 {
                    slow = if gained < CRAWL * space.firmness + CRAWL_SHARE * above_noise { slow + 1 } else { 0 };
                    damping = match gained / promised {
                        ratio if ratio > FAIR => (damping * 0.1).max(LEAST_DAMPING),
                        ratio if ratio < 0.1 => damping * 4.0,
                        _ => damping,
                    };
                    next = Some(best);
                    break;
                }
            }
            damping = (damping * 10.0).max(1e-6);
        }
        let improved = next.is_some();
        here = next.unwrap_or(here);
        if !improved || slow >= MOST_CRAWLS {
            slow = 0;
            converged = stage + 1 == effort.steps.len();
            stage += 1;
        }
    }
    let Place { z, score, objective, .. } = here;
    Some(Fit { space: space.clone(), z, score, objective, information, converged })
}

/// What the residuals did on a step beyond what their derivatives predict (half the second derivative along it), as its
/// products with the derivatives. `all` has the derivatives as its columns, and the residuals before the step as its last.
fn bend(data: &Data, all: &DMatrix<f32>, after: &Residuals, step: &DVector<f64>) -> DVector<f64> {
    let n = step.len();
    let derivatives = all.columns(0, n);
    let after = DVector::from_vec(flat(data, Part::Fitted, after));
    let beyond = after - all.column(n) - derivatives * step.map(|s| s as f32);
    derivatives.tr_mul(&beyond).map(f64::from)
}

/// A few steps from `start` with the derivatives along what `space` shares with a former fit taken from there, so that
/// only the new coordinates, which come last, cost simulations. Cheap and good enough to see who deserves a real fit.
pub(crate) fn sketch(
    data: &Data,
    space: &Space,
    start: &[f64],
    shared: &DMatrix<f32>,
    shared_gram: &DMatrix<f64>,
    steps: usize,
) -> Option<Fit> {
    let (n, old) = (space.len(), shared.ncols());
    let pulls: Vec<f64> = space.pulls().collect();
    let mut z: Vec<f64> = space.coordinates.iter().zip(start).map(|(c, z)| z.clamp(c.low, c.high)).collect();
    let mut here = residuals::at(data, space, &z)?;
    let mut at = residuals::score(data, &here);
    let mut objective = at.fitted + space.resistance(&z);
    let mut information = DMatrix::identity(n, n);
    for _ in 0..steps {
        let own: Vec<Residuals> = (old..n)
            .map(|i| {
                let c = &space.coordinates[i];
                let step = if z[i] + c.step <= c.high { c.step } else { -c.step };
                let mut moved = z.clone();
                moved[i] += step;
                let there = residuals::at(data, space, &moved)?;
                Some(zip(&there, &here, |there, here| (there - here) / step as f32))
            })
            .collect::<Option<_>>()?;
        information.view_mut((0, 0), (old, old)).copy_from(shared_gram);
        let new: Vec<&Residuals> = own.iter().chain([&here]).collect();
        let new = matrix(data, Part::Fitted, &new);
        let (cross, corner) = (shared.tr_mul(&new).cast::<f64>(), square(&new));
        let mut gradient = DVector::zeros(n);
        for i in 0..n {
            let at_residuals = n - old;
            gradient[i] = if i < old { cross[(i, at_residuals)] } else { corner[(i - old, at_residuals)] };
            gradient[i] += pulls[i] * z[i];
            for j in old..n {
                let product = if i < old { cross[(i, j - old)] } else { corner[(i - old, j - old)] };
                information[(i, j)] = product;
                information[(j, i)] = product;
            }
        }
        for (i, pull) in pulls.iter().enumerate() {
            information[(i, i)] += pull;
        }
        let mut damping = 1e-4;
        let mut improved = false;
        for _ in 0..4 {
            let (step, _) = bounded_step(space, &z, &information, &gradient, damping);
            let moved: Vec<f64> = z.iter().zip(step.iter()).map(|(z, s)| z + s).collect();
            if let Some(there) = residuals::at(data, space, &moved) {
                let then = residuals::score(data, &there);
                let value = then.fitted + space.resistance(&moved);
                if value < objective {
                    (z, here, at, objective) = (moved, there, then, value);
                    improved = true;
                    break;
                }
            }
            damping *= 100.0;
        }
        if !improved {
            break;
        }
    }
    Some(Fit { space: space.clone(), z, score: at, objective, information, converged: false })
}

/// The damped Gauss–Newton step that stays within the bounds, and what the quadratic model promises of it.
fn bounded_step(
    space: &Space,
    z: &[f64],
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> (DVector<f64>, f64) {
    let n = z.len();
    let mut held: Vec<Option<f64>> = vec![None; n];
    // coordinates that would leave their bounds are held on them one after the other
    for _ in 0..=n {
        let free: Vec<usize> = (0..n).filter(|i| held[*i].is_none()).collect();
        let mut step = DVector::zeros(n);
        for (i, at) in held.iter().enumerate() {
            step[i] = at.unwrap_or(0.0);
        }
        if !free.is_empty() {
            let mut a = DMatrix::zeros(free.len(), free.len());
            let mut b = DVector::zeros(free.len());
            for (row, &i) in free.iter().enumerate() {
                for (column, &j) in free.iter().enumerate() {
                    a[(row, column)] = information[(i, j)];
                }
                a[(row, row)] += damping * information[(i, i)].max(1e-12) + 1e-12;
                b[row] = -gradient[i]
                    - (0..n).filter(|j| held[*j].is_some()).map(|j| information[(i, j)] * step[j]).sum::<f64>();
            }
            let solved = match a.clone().cholesky() {
                Some(cholesky) => cholesky.solve(&b),
                None => DVector::zeros(free.len()),
            };
            for (row, &i) in free.iter().enumerate() {
                step[i] = solved[row];
            }
        }
        let worst = free
            .iter()
            .map(|&i| {
                let to = z[i] + step[i];
                let c = &space.coordinates[i];
                (i, (c.low - to).max(to - c.high))
            })
            .filter(|(_, beyond)| *beyond > 1e-12)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match worst {
            Some((i, _)) => {
                let c = &space.coordinates[i];
                held[i] = Some((z[i] + step[i]).clamp(c.low, c.high) - z[i]);
            }
            None => {
                let promised = -2.0 * gradient.dot(&step) - (information * &step).dot(&step);
                return (step, promised);
            }
        }
    }
    (DVector::zeros(n), 0.0)
}

impl Fit {
    /// What it leaves; `None` where its model cannot be built.
    pub(crate) fn residuals(&self, data: &Data) -> Option<Residuals> {
        residuals::at(data, &self.space, &self.z)
    }

    /// The same, scored by other data: in other noise, or simulated otherwise.
    pub(crate) fn judged_by(&self, data: &Data) -> Option<Fit> {
        let score = residuals::score(data, &self.residuals(data)?);
        let objective = score.fitted + self.space.resistance(&self.z);
        Some(Fit { score, objective, ..self.clone() })
    }

    /// The states of the wire through every recording.
    pub(crate) fn states(&self, data: &Data) -> Option<Vec<Vec<State>>> {
        let model = self.space.model(&self.z)?;
        (0..data.runs.len()).map(|r| simulate::states(&model, &self.space.run(data, r, &self.z))).collect()
    }

    /// What explanations are compared by: everything measured, of which one sample in `inflation` counts, and the priors.
    pub(crate) fn likelihood(&self, inflation: f64) -> f64 {
        self.score.sum() / inflation + self.space.penalty(&self.z)
    }

    /// Bayesian information criterion for samples of which one in `inflation` counts.
    pub(crate) fn bic(&self, inflation: f64) -> f64 {
        let samples = self.score.count() / inflation;
        self.likelihood(inflation) + self.space.len() as f64 * samples.max(2.0).ln()
    }

    /// Standard deviations of the coordinates, in their scales, from the curvature.
    pub(crate) fn deviations(&self) -> Vec<f64> {
        let n = self.space.len();
        let mut information = self.information.clone();
        for i in 0..n {
            information[(i, i)] += 1e-12;
        }
        match information.cholesky() {
            Some(cholesky) => {
                let inverse = cholesky.inverse();
                (0..n).map(|i| inverse[(i, i)].max(0.0).sqrt()).collect()
            }
            None => vec![f64::INFINITY; n],
        }
    }
}
