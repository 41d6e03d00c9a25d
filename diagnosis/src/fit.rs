//! Bounded least squares through the simulator: Levenberg–Marquardt with numerical derivatives whose steps are large
//! enough for hysteresis, priors as residuals of their own, and bounds by projection.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sinew_physics::effects::Effect;

use crate::data::{Data, Part};
use crate::derivatives;
use crate::products::{flat, matrix, product, square};
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
    /// How often derivatives are taken.
    pub(crate) iterations: usize,
    /// A step that promises less ends the fit: 1 is what a parameter one standard deviation off costs …
    pub(crate) negligible: f64,
}

/// … or less than this share of what the objective has above pure noise.
const NEGLIGIBLE_SHARE: f64 = 5e-3;

/// Steps that gain less than this many times what is negligible, and next to nothing of what is above noise, though they
/// promised more: where the country is rough, so many in a row are the end of the way.
const CRAWL: f64 = 2.5;

const CRAWL_SHARE: f64 = 1e-4;

const MOST_CRAWLS: usize = 3;

/// A step that gains this share of what it promised needs no bending …
const AS_PROMISED: f64 = 0.75;

/// … and after one that gains this share the next may be longer.
const FAIR: f64 = 0.25;

/// How often a step is damped more before there is none, by derivatives of the place itself and of one near it.
const FRESH_ATTEMPTS: usize = 8;
const STALE_ATTEMPTS: usize = 2;

/// Further steps by the same derivatives.
const MOST_CHORDS: usize = 4;

/// A step of less than this, in standard deviations of what it moves, squared, leaves derivatives what they are.
const SAME_PLACE: f64 = 0.25;

/// Damping that is as good as none, relative to the curvature along each coordinate.
const LEAST_DAMPING: f64 = 1e-9;

impl Effort {
    /// Far enough to see how good a model is.
    pub(crate) const SEARCH: Effort = Effort { iterations: 10, negligible: 0.1 };

    pub(crate) fn iterations(iterations: usize) -> Effort {
        Effort { iterations, ..Effort::SEARCH }
    }
}

/// A place on the way of a fit.
struct Place {
    z: Vec<f64>,
    /// Not whitened.
    left: Residuals,
    residuals: Residuals,
    score: Score,
    objective: f64,
}

impl Place {
    /// `None` where the model cannot be built.
    fn new(data: &Data, space: &Space, z: Vec<f64>) -> Option<Place> {
        let left = residuals::fitted_at(data, space, &z)?;
        Some(Place::with(data, space, z, left))
    }

    /// Where so much is `left`, not whitened.
    fn with(data: &Data, space: &Space, z: Vec<f64>, left: Residuals) -> Place {
        let residuals = data.white(&left);
        let score = residuals::score(data, &residuals);
        let objective = score.fitted + space.resistance(&z);
        Place { z, left, residuals, score, objective }
    }
}

/// Derivatives of the residuals that were taken somewhere near, not whitened: they serve whatever the error of the model, and
/// whatever the data lack, as long as these have the same rows.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    columns: Arc<Vec<Residuals>>,
    /// Where; `None` where they were put together from several places.
    at: Option<Vec<f64>>,
}

impl Known {
    /// Taken at `z`.
    pub(crate) fn at(data: &Data, space: &Space, z: &[f64]) -> Option<Known> {
        Known::beside(data, space, z, &residuals::fitted_at(data, space, z)?)
    }

    /// The same, where `left` are the residuals there, not whitened.
    fn beside(data: &Data, space: &Space, z: &[f64], left: &Residuals) -> Option<Known> {
        let columns = derivatives::plain(data, space, z, left, 0..space.len())?;
        Some(Known { columns: Arc::new(columns), at: Some(z.to_vec()) })
    }

    /// With those along the coordinates that `space` has besides, which come last, taken at `z`.
    pub(crate) fn and_those_of(&self, data: &Data, space: &Space, z: &[f64]) -> Option<Known> {
        let left = residuals::fitted_at(data, space, z)?;
        let more = derivatives::plain(data, space, z, &left, self.columns.len()..space.len())?;
        Some(Known { columns: Arc::new(self.columns.iter().cloned().chain(more).collect()), at: None })
    }

    /// Without those along the coordinates of an effect of `space`, which is taken out.
    pub(crate) fn without(&self, space: &Space, effect: &Effect) -> Known {
        let stays = space.coordinates.iter().zip(self.columns.iter()).filter(|(c, _)| !c.is_of(effect));
        Known { columns: Arc::new(stays.map(|(_, column)| column.clone()).collect()), at: None }
    }

    /// As the data whiten them.
    pub(crate) fn white(&self, data: &Data) -> Vec<Residuals> {
        derivatives::white(data, &self.columns)
    }

    /// Whether they were taken so near to `z`, by the knowledge there is of it, that they are those of the place.
    pub(crate) fn serve(&self, z: &[f64], information: &DMatrix<f64>) -> bool {
        let Some(at) = &self.at else { return false };
        let moved = DVector::from_iterator(z.len(), z.iter().zip(at).map(|(z, at)| z - at));
        moved.len() == at.len() && (information * &moved).dot(&moved) < SAME_PLACE
    }
}

/// Derivatives of the residuals at a place, kept true on further steps by what these show (Broyden, 1965).
struct Slope {
    /// Columns: the coordinates.
    columns: DMatrix<f32>,
    /// Their products, the priors' pulls added.
    information: DMatrix<f64>,
    /// The residuals at the place they were last true at.
    left: DVector<f32>,
}

impl Slope {
    fn new(data: &Data, space: &Space, known: &Known, here: &Place) -> Slope {
        let columns = matrix(data, Part::Fitted, &known.white(data).iter().collect::<Vec<_>>());
        let mut information = square(&columns);
        space.add_pulls(&mut information);
        let left = DVector::from_vec(flat(data, Part::Fitted, &here.residuals));
        Slope { columns, information, left }
    }

    /// Half the derivative of the objective at `z`.
    fn gradient(&self, space: &Space, z: &[f64]) -> DVector<f64> {
        let mut gradient = product(&self.columns, &self.left);
        space.add_pulls_at(z, &mut gradient);
        gradient
    }

    /// What the residuals did on a step beyond what their derivatives predict (half the second derivative along it).
    fn beyond(&self, after: &DVector<f32>, step: &DVector<f64>) -> DVector<f32> {
        after - &self.left - &self.columns * step.map(|s| s as f32)
    }

    /// Its products with the derivatives.
    fn bend(&self, data: &Data, after: &Residuals, step: &DVector<f64>) -> DVector<f64> {
        let after = DVector::from_vec(flat(data, Part::Fitted, after));
        product(&self.columns, &self.beyond(&after, step))
    }

    /// Takes in what a step from the last place to `here` has shown.
    fn learn(&mut self, data: &Data, here: &Place, step: &DVector<f64>) {
        let after = DVector::from_vec(flat(data, Part::Fitted, &here.residuals));
        let length = step.norm_squared();
        if length > 0.0 {
            let beyond = self.beyond(&after, step);
            let along = product(&self.columns, &beyond) / length;
            let square = f64::from(beyond.norm_squared()) / (length * length);
            self.information += &along * step.transpose() + step * along.transpose() + step * step.transpose() * square;
            self.columns.ger((1.0 / length) as f32, &beyond, &step.map(|s| s as f32), 1.0);
        }
        self.left = after;
    }
}

/// What a search for the next place came to.
enum Next {
    /// A better place, and the step there.
    Better(Place, DVector<f64>),
    /// Nothing worth a step is promised, or none is better.
    Nothing,
}

/// A fit on its way.
struct Walk<'a> {
    data: &'a Data,
    space: &'a Space,
    effort: Effort,
    here: Place,
    damping: f64,
    /// Steps in a row that gained next to nothing.
    slow: usize,
}

impl Walk<'_> {
    fn above_noise(&self) -> f64 {
        (self.here.objective - self.here.score.fitted_count).max(0.0)
    }

    fn place(&self, from: &[f64], step: &DVector<f64>) -> Option<Place> {
        let moved = from.iter().zip(step.iter()).map(|(z, s)| z + s).collect();
        Place::new(self.data, self.space, moved)
    }

    /// The next place, the step damped up to so many times for it.
    fn next(&mut self, slope: &Slope, attempts: usize) -> Next {
        let gradient = slope.gradient(self.space, &self.here.z);
        let above_noise = self.above_noise();
        for attempt in 0..attempts {
            let (step, promised) = bounded_step(self.space, &self.here.z, &slope.information, &gradient, self.damping);
            if promised < self.effort.negligible + NEGLIGIBLE_SHARE * above_noise {
                // damping hides the way along a valley that the data hardly slope: look without before calling it the end
                if self.damping > LEAST_DAMPING && attempt == 0 {
                    self.damping = LEAST_DAMPING;
                    continue;
                }
                break;
            }
            if let Some(straight) = self.place(&self.here.z, &step) {
                let mut best = straight;
                if best.objective > self.here.objective - AS_PROMISED * promised {
                    let bend = slope.bend(self.data, &best.residuals, &step);
                    let (correction, _) = bounded_step(self.space, &best.z, &slope.information, &bend, self.damping);
                    best =
                        self.place(&best.z, &correction).filter(|bent| bent.objective < best.objective).unwrap_or(best);
                }
                let gained = self.here.objective - best.objective;
                if gained > 0.0 {
                    let crawl = CRAWL * self.effort.negligible + CRAWL_SHARE * above_noise;
                    self.slow = if gained < crawl { self.slow + 1 } else { 0 };
                    self.damping = match gained / promised {
                        ratio if ratio > FAIR => (self.damping * 0.1).max(LEAST_DAMPING),
                        ratio if ratio < 0.1 => self.damping * 4.0,
                        _ => self.damping,
                    };
                    let step = DVector::from_iterator(
                        best.z.len(),
                        best.z.iter().zip(&self.here.z).map(|(to, from)| to - from),
                    );
                    return Next::Better(best, step);
                }
            }
            self.damping = (self.damping * 10.0).max(1e-6);
        }
        Next::Nothing
    }

    /// Goes on by derivatives that have served already, while steps gain what they promise.
    fn go_on(&mut self, slope: &mut Slope) {
        for _ in 0..MOST_CHORDS {
            let gradient = slope.gradient(self.space, &self.here.z);
            let (step, promised) = bounded_step(self.space, &self.here.z, &slope.information, &gradient, self.damping);
            if promised < self.effort.negligible + NEGLIGIBLE_SHARE * self.above_noise() {
                return;
            }
            match self.place(&self.here.z, &step) {
                Some(next) if self.here.objective - next.objective > FAIR * promised => {
                    slope.learn(self.data, &next, &step);
                    self.here = next;
                }
                _ => return,
            }
        }
    }
}

/// Fits from `start`. `None` where the start itself is impossible.
pub(crate) fn fit(data: &Data, space: &Space, start: &[f64], effort: Effort) -> Option<Fit> {
    fit_from(data, space, start, &mut None, effort, &mut None)
}

/// Fits from `start`, by derivatives that are known from somewhere near as long as they lead on; leaves those it ended with. What
/// is `left` of what is fitted, not whitened, may be known at the start, and is at the end.
///
/// Levenberg–Marquardt, its steps bent along with the valley (geodesic acceleration, Transtrum and Sethna 2012): where
/// parameters make up for each other the valley is narrow and winds, and straight steps crawl along it.
pub(crate) fn fit_from(
    data: &Data,
    space: &Space,
    start: &[f64],
    left: &mut Option<Residuals>,
    effort: Effort,
    known: &mut Option<Known>,
) -> Option<Fit> {
    let n = space.len();
    let inside: Vec<f64> = space.coordinates.iter().zip(start).map(|(c, z)| z.clamp(c.low, c.high)).collect();
    let here = match left.take() {
        Some(left) if inside == start => Place::with(data, space, inside, left),
        _ => Place::new(data, space, inside)?,
    };
    let mut walk = Walk { data, space, effort, here, damping: 1e-3, slow: 0 };
    let mut taken = 0;
    if known.is_none() {
        *known = Known::beside(data, space, &walk.here.z, &walk.here.left);
        taken += 1;
    }
    let mut slope = Slope::new(data, space, known.as_ref()?, &walk.here);
    // true at the place where the walk stands
    let mut is_fresh = known.as_ref()?.serve(&walk.here.z, &slope.information);
    let mut converged = n == 0;
    while !converged {
        match walk.next(&slope, if is_fresh { FRESH_ATTEMPTS } else { STALE_ATTEMPTS }) {
            Next::Better(place, step) if walk.slow < MOST_CRAWLS => {
                slope.learn(data, &place, &step);
                walk.here = place;
                walk.go_on(&mut slope);
                is_fresh = known.as_ref()?.serve(&walk.here.z, &slope.information);
            }
            next => {
                if let Next::Better(place, _) = next {
                    walk.here = place;
                }
                walk.slow = 0;
                converged = is_fresh;
                if converged || taken >= effort.iterations {
                    break;
                }
                *known = Known::beside(data, space, &walk.here.z, &walk.here.left);
                slope = Slope::new(data, space, known.as_ref()?, &walk.here);
                taken += 1;
                is_fresh = true;
            }
        }
    }
    let Place { z, left: at_end, score, objective, .. } = walk.here;
    *left = Some(at_end);
    Some(Fit { space: space.clone(), z, score, objective, information: slope.information, converged })
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
    /// What it leaves of what is fitted, whitened; `None` where its model cannot be built.
    pub(crate) fn residuals(&self, data: &Data) -> Option<Residuals> {
        residuals::at(data, &self.space, &self.z)
    }

    /// The states of the wire through every recording.
    pub(crate) fn states(&self, data: &Data) -> Option<Vec<Vec<State>>> {
        let model = self.space.model(&self.z)?;
        (0..data.runs.len()).map(|r| simulate::states(&model, &self.space.run(data, r, &self.z))).collect()
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
