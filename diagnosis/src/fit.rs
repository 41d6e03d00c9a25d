//! Bounded least squares through the simulator: Levenberg–Marquardt with numerical derivatives whose steps are large
//! enough for hysteresis, priors as residuals of their own, and bounds by projection.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::simulate::{self, State};
use crate::space::{Space, What};

/// Residuals over noise of the whole data: by run, sensor, sample; NaN where nothing was measured.
pub(crate) type Residuals = Vec<Vec<Vec<f32>>>;

/// How well a model does.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Score {
    /// Σ r² over samples the fit sees, and how many they are.
    pub(crate) fitted: f64,
    pub(crate) fitted_count: f64,
    /// Σ r² over samples kept back, and how many they are.
    pub(crate) kept: f64,
    pub(crate) kept_count: f64,
}

impl Score {
    /// Σ r² of both: an error that shows in a few stretches only may spare all that is kept back.
    pub(crate) fn sum(&self) -> f64 {
        self.fitted + self.kept
    }

    pub(crate) fn count(&self) -> f64 {
        self.fitted_count + self.kept_count
    }

    /// What is there beyond noise.
    pub(crate) fn excess(&self) -> f64 {
        self.sum() - self.count()
    }

    pub(crate) fn chi(&self) -> f64 {
        (self.sum() / self.count().max(1.0)).sqrt()
    }

    pub(crate) fn chi_kept(&self) -> f64 {
        (self.kept / self.kept_count.max(1.0)).sqrt()
    }

    pub(crate) fn chi_fitted(&self) -> f64 {
        (self.fitted / self.fitted_count.max(1.0)).sqrt()
    }
}

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

/// Residuals of the model at `z`; `None` where it cannot be built.
pub(crate) fn residuals(data: &Data, space: &Space, z: &[f64]) -> Option<Residuals> {
    let model = space.model(z)?;
    (0..data.runs.len())
        .map(|index| {
            let outputs = simulate::outputs(&model, &space.seen(data, index, z), &data.sensors)?;
            Some(compare(data, space, z, index, outputs))
        })
        .collect()
}

/// Turns simulated outputs of one recording into residuals over noise.
pub(crate) fn compare(data: &Data, space: &Space, z: &[f64], index: usize, outputs: Vec<Vec<f64>>) -> Vec<Vec<f32>> {
    let run = &data.runs[index];
    let position = data.position();
    let (mut zero, gain) = space.position_of(index, z);
    if data.free_zero
        && run.held_out
        && let Some(sensor) = position
    {
        // an arbitrary zero that was never fitted means nothing: the best one is taken
        zero = mean_difference(&run.measured[sensor], &outputs[sensor]);
    }
    data.sensors
        .iter()
        .enumerate()
        .map(|(s, sensor)| {
            let (zero, gain) = if Some(s) == position { (zero, gain) } else { (0.0, 1.0) };
            let weight = 1.0 / sensor.noise;
            run.measured[s]
                .iter()
                .zip(&outputs[s])
                .map(|(measured, simulated)| ((measured - zero - gain * simulated) * weight) as f32)
                .collect()
        })
        .collect()
}

fn mean_difference(measured: &[f64], simulated: &[f64]) -> f64 {
    let (sum, count) = measured
        .iter()
        .zip(simulated)
        .filter(|(m, _)| !m.is_nan())
        .fold((0.0, 0.0), |(sum, count), (m, s)| (sum + m - s, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Sums of squares of what is fitted and what is kept back.
pub(crate) fn score(data: &Data, residuals: &Residuals) -> Score {
    let mut score = Score::default();
    for (run, by_sensor) in data.runs.iter().zip(residuals) {
        for values in by_sensor {
            for (r, part) in values.iter().zip(&run.part) {
                if r.is_nan() {
                    continue;
                }
                let square = f64::from(*r) * f64::from(*r);
                match part {
                    Part::Fitted => {
                        score.fitted += square;
                        score.fitted_count += 1.0;
                    }
                    Part::KeptBack => {
                        score.kept += square;
                        score.kept_count += 1.0;
                    }
                    Part::LeftOut => {}
                }
            }
        }
    }
    score
}

/// r² of every sample kept back, with its recording, sensor and block.
pub(crate) fn kept_squares<'a>(
    data: &'a Data,
    residuals: &'a Residuals,
) -> impl Iterator<Item = (usize, usize, usize, f64)> + 'a {
    data.runs.iter().zip(residuals).enumerate().flat_map(|(number, (run, by_sensor))| {
        by_sensor.iter().enumerate().flat_map(move |(sensor, values)| {
            let samples = values.iter().zip(&run.part).zip(&run.block);
            samples
                .filter(|((r, part), _)| **part == Part::KeptBack && !r.is_nan())
                .map(move |((r, _), block)| (number, sensor, *block, f64::from(*r).powi(2)))
        })
    })
}

/// Derivatives of the residuals along every coordinate; all of one recording's own are known without a simulation.
pub(crate) fn derivatives(data: &Data, space: &Space, z: &[f64], at: &Residuals) -> Option<Vec<Residuals>> {
    derivatives_by(data, space, z, at, Steps::ONE_SIDED)
}

/// As [`derivatives`], as good as they can be had: where intervals are taken from.
pub(crate) fn sharp_derivatives(data: &Data, space: &Space, z: &[f64], at: &Residuals) -> Option<Vec<Residuals>> {
    derivatives_by(data, space, z, at, Steps::SHARP)
}

/// How derivatives step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps {
    /// In units of each coordinate's own step.
    length: f64,
    both_sides: bool,
    /// Rounds of [`sharpen`].
    rounds: usize,
}

impl Steps {
    const ONE_SIDED: Steps = Steps { length: 1.0, both_sides: false, rounds: 0 };
    const CENTRAL: Steps = Steps { length: 0.5, both_sides: true, rounds: 0 };
    const SHARP: Steps = Steps { rounds: 2, ..Steps::CENTRAL };
}

fn derivatives_by(data: &Data, space: &Space, z: &[f64], at: &Residuals, steps: Steps) -> Option<Vec<Residuals>> {
    let mut columns = (0..space.len())
        .into_par_iter()
        .map(|i| {
            let coordinate = &space.coordinates[i];
            if let What::Zero(run) = coordinate.what
                && data.position().is_some()
            {
                return Some(zero_derivative(data, coordinate.scale, run, at));
            }
            let step = steps.length * coordinate.step;
            let go = |step: f64| {
                if !(coordinate.low..=coordinate.high).contains(&(z[i] + step)) {
                    return None;
                }
                let mut moved = z.to_vec();
                moved[i] += step;
                residuals(data, space, &moved)
            };
            let above = go(step);
            let below = if steps.both_sides || above.is_none() { go(-step) } else { None };
            match (above, below) {
                (Some(above), Some(below)) => Some(zip(&above, &below, |a, b| (a - b) * (0.5 / step) as f32)),
                (Some(above), None) => Some(zip(&above, at, |a, here| (a - here) * (1.0 / step) as f32)),
                (None, Some(below)) => Some(zip(&below, at, |b, here| (here - b) * (1.0 / step) as f32)),
                (None, None) => None,
            }
        })
        .collect::<Option<Vec<Residuals>>>()?;
    for _ in 0..steps.rounds {
        sharpen(data, space, z, &mut columns);
    }
    Some(columns)
}

/// Directions are sharpened that the data hold this many times less firmly (in curvature) than the firmest.
const SLOPPY: f64 = 1e-3;
/// Length of the steps along them, in their own standard deviations.
const STRIDE: f64 = 0.5;

/// Takes derivatives anew along the directions that the data hardly tell apart. Put together from the coordinates they
/// are what is left of large numbers that cancel, mostly errors: a fit stops short along such a valley, and intervals
/// come out far too narrow, as errors look like knowledge. Along the direction itself a step may be as long as the
/// valley, and from both sides its bend drops out.
fn sharpen(data: &Data, space: &Space, z: &[f64], columns: &mut [Residuals]) {
    if columns.is_empty() {
        return;
    }
    let mut information = gram(data, Part::Fitted, columns);
    for (i, pull) in space.pulls().enumerate() {
        information[(i, i)] += pull;
    }
    let eigen = SymmetricEigen::new(information);
    let firmest = eigen.eigenvalues.max();
    let anew: Vec<(DVector<f64>, Residuals)> = (0..columns.len())
        .into_par_iter()
        .filter(|k| eigen.eigenvalues[*k] < SLOPPY * firmest)
        .filter_map(|k| {
            let along = eigen.eigenvectors.column(k).into_owned();
            let room = space.coordinates.iter().zip(z).zip(along.iter()).map(|((c, z), v)| {
                let room = (c.high - z).min(z - c.low);
                if *v == 0.0 { f64::INFINITY } else { room / v.abs() }
            });
            let step = room.fold(STRIDE / eigen.eigenvalues[k].max(1e-6).sqrt(), f64::min);
            let go = |step: f64| {
                let moved: Vec<f64> = z.iter().zip(along.iter()).map(|(z, v)| z + step * v).collect();
                residuals(data, space, &moved)
            };
            if step <= 0.0 {
                return None;
            }
            let (above, below) = (go(step)?, go(-step)?);
            Some((along, zip(&above, &below, |a, b| (a - b) * (0.5 / step) as f32)))
        })
        .collect();
    for (along, derivative) in anew {
        let mut error = derivative;
        for (column, v) in columns.iter().zip(along.iter()) {
            error = zip(&error, column, |e, c| e - *v as f32 * c);
        }
        for (column, v) in columns.iter_mut().zip(along.iter()) {
            *column = zip(column, &error, |c, e| c + *v as f32 * e);
        }
    }
}

/// What the zero of the position in one recording does to the residuals, per `scale`.
pub(crate) fn zero_derivative(data: &Data, scale: f64, run: usize, at: &Residuals) -> Residuals {
    let position = data.position();
    at.iter()
        .enumerate()
        .map(|(r, by_sensor)| {
            by_sensor
                .iter()
                .enumerate()
                .map(|(s, values)| {
                    let slope =
                        if r == run && Some(s) == position { (-scale / data.sensors[s].noise) as f32 } else { 0.0 };
                    vec![slope; values.len()]
                })
                .collect()
        })
        .collect()
}

/// The residuals of one part; NaN elsewhere.
pub(crate) fn only(data: &Data, part: Part, residuals: &Residuals) -> Residuals {
    let mut of_part = residuals.clone();
    for (run, by_sensor) in data.runs.iter().zip(&mut of_part) {
        for (value, of) in by_sensor.iter_mut().flat_map(|values| values.iter_mut().zip(&run.part)) {
            if *of != part {
                *value = f32::NAN;
            }
        }
    }
    of_part
}

/// Combines two sets of residuals sample by sample.
pub(crate) fn zip(a: &Residuals, b: &Residuals, f: impl Fn(f32, f32) -> f32) -> Residuals {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()).collect())
        .collect()
}

/// Σ a b over the samples of a part; missing samples do not count.
pub(crate) fn inner(data: &Data, part: Part, a: &Residuals, b: &Residuals) -> f64 {
    let mut sum = 0.0;
    for ((run, a), b) in data.runs.iter().zip(a).zip(b) {
        for (a, b) in a.iter().zip(b) {
            // in stretches of f32: fast, and summed in f64 often enough
            for ((a, b), p) in a.chunks(64).zip(b.chunks(64)).zip(run.part.chunks(64)) {
                let mut part_sum = 0.0f32;
                for ((a, b), p) in a.iter().zip(b).zip(p) {
                    let product = a * b;
                    if *p == part && !product.is_nan() {
                        part_sum += product;
                    }
                }
                sum += f64::from(part_sum);
            }
        }
    }
    sum
}

/// The samples of a part, over all recordings and sensors, as a column; 0 where nothing was measured.
pub(crate) fn flat(data: &Data, part: Part, residuals: &Residuals) -> Vec<f32> {
    let mut flat = Vec::new();
    for (run, by_sensor) in data.runs.iter().zip(residuals) {
        for values in by_sensor {
            for (r, p) in values.iter().zip(&run.part) {
                if *p == part {
                    flat.push(if r.is_nan() { 0.0 } else { *r });
                }
            }
        }
    }
    flat
}

/// The columns of a matrix, side by side.
pub(crate) fn matrix(data: &Data, part: Part, columns: &[&Residuals]) -> DMatrix<f32> {
    let flat: Vec<Vec<f32>> = columns.par_iter().map(|c| flat(data, part, c)).collect();
    let rows = flat.first().map_or(0, Vec::len);
    DMatrix::from_vec(rows, flat.len(), flat.concat())
}

/// As [`matrix`], of every sample whatever its part.
pub(crate) fn matrix_of_all(data: &Data, columns: &[&Residuals]) -> DMatrix<f32> {
    let flat: Vec<Vec<f32>> =
        columns.par_iter().map(|c| c.iter().flatten().flatten().copied().collect::<Vec<f32>>()).collect();
    DMatrix::from_vec(data.samples() * data.sensors.len(), flat.len(), flat.concat())
}

/// JᵀJ, summed in double precision: what the data hardly tell apart is eight orders below what they know best.
pub(crate) fn square(matrix: &DMatrix<f32>) -> DMatrix<f64> {
    const STRETCH: usize = 4096;
    let n = matrix.ncols();
    (0..matrix.nrows())
        .step_by(STRETCH)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|first| {
            let rows = matrix.rows(first, STRETCH.min(matrix.nrows() - first)).into_owned().cast::<f64>();
            rows.tr_mul(&rows)
        })
        .collect::<Vec<_>>()
        .into_iter()
        // in order: sums of floats depend on it, and the same seed must give the same answer on any number of threads
        .fold(DMatrix::zeros(n, n), |sum, part| sum + part)
}

/// JᵀJ of the samples of a part.
pub(crate) fn gram(data: &Data, part: Part, columns: &[Residuals]) -> DMatrix<f64> {
    square(&matrix(data, part, &columns.iter().collect::<Vec<_>>()))
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
        let residuals = residuals(data, space, &z)?;
        let score = score(data, &residuals);
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
        let columns = derivatives_by(data, space, &here.z, &here.residuals, effort.steps[stage])?;
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

/// What the residuals did on a step beyond what their derivatives said (half the second derivative along it), as its
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
    let mut here = residuals(data, space, &z)?;
    let mut at = score(data, &here);
    let mut objective = at.fitted + space.resistance(&z);
    let mut information = DMatrix::identity(n, n);
    for _ in 0..steps {
        let own: Vec<Residuals> = (old..n)
            .map(|i| {
                let c = &space.coordinates[i];
                let step = if z[i] + c.step <= c.high { c.step } else { -c.step };
                let mut moved = z.clone();
                moved[i] += step;
                let there = residuals(data, space, &moved)?;
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
            if let Some(there) = residuals(data, space, &moved) {
                let then = score(data, &there);
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
    /// The same, scored by other data: in other noise, or simulated otherwise.
    pub(crate) fn judged_by(&self, data: &Data) -> Option<Fit> {
        let score = score(data, &residuals(data, &self.space, &self.z)?);
        let objective = score.fitted + self.space.resistance(&self.z);
        Some(Fit { score, objective, ..self.clone() })
    }

    /// The states of the wire through every recording.
    pub(crate) fn states(&self, data: &Data) -> Option<Vec<Vec<State>>> {
        let model = self.space.model(&self.z)?;
        (0..data.runs.len()).map(|r| simulate::states(&model, &self.space.seen(data, r, &self.z))).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    /// To the last digit, or fits on a rough simulator part ways and the same seed gives another answer.
    #[test]
    fn sums_do_not_depend_on_the_threads() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let matrix = DMatrix::from_fn(50_000, 3, |_, _| random.random::<f32>() - 0.3);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| square(&matrix))
        };
        let one = on(1);
        for threads in [2, 3, 7] {
            assert_eq!(on(threads), one);
        }
        assert!((one[(0, 0)] - matrix.column(0).iter().map(|x| f64::from(*x).powi(2)).sum::<f64>()).abs() < 1e-6);
    }
}
