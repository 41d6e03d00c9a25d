//! Which effects are worth a fit: every one is tried by a secant or two, after what the parameters can make up for, and the
//! more promising ones are taken a few steps with the derivatives that all have in common.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use sinew_physics::effects::{Effect, Nature};

use crate::data::{Data, Part};
use crate::explanation::Explanation;
use crate::fit::{self, Fit, Known};
use crate::products;
use crate::residuals::{self, Residuals, zip};
use crate::space::What;
use crate::starts::Candidate;

/// Candidates that are sketched, and the gain by screening that makes one worth it.
const SKETCHED: usize = 6;
const WORTH_A_FIT: f64 = 3.0;
/// Secants of screening, in scales of what is switched on.
const SECANTS: [f64; 2] = [0.5, 0.04];
/// Least size a fit begins with, in the same: a size of nothing has no derivative for shapes, and some none at all.
const LEAST_START: f64 = 0.05;
/// Steps of a sketch.
const SKETCH_STEPS: usize = 4;

/// A candidate as screening sees it.
#[derive(Debug, Clone)]
pub(crate) struct Screened {
    pub(crate) candidate: Candidate,
    /// Rise of the log evidence, linearised.
    pub(crate) gain: f64,
    /// Where a fit of it starts.
    start: Vec<f64>,
}

/// What screening shares among candidates: the derivatives at an explanation.
struct Screen<'a> {
    data: Data,
    base: &'a Explanation,
    here: Residuals,
    known: Known,
    columns: DMatrix<f32>,
    factor: Cholesky<f64, Dyn>,
    gradient: DVector<f64>,
    left: DVector<f32>,
}

impl<'a> Screen<'a> {
    fn new(data: &Data, base: &'a Explanation) -> Option<Screen<'a>> {
        let data = base.judges(data)?;
        let fit = &base.fit;
        let here = fit.residuals(&data)?;
        let known = base.derivatives(&data)?;
        let columns = products::matrix(&data, Part::Fitted, &known.white(&data).iter().collect::<Vec<_>>());
        let mut information = products::square(&columns);
        let left = DVector::from_vec(products::flat(&data, Part::Fitted, &here));
        let mut gradient = products::product(&columns, &left);
        for (i, pull) in fit.space.pulls().enumerate() {
            information[(i, i)] += pull + 1e-9;
            gradient[i] += pull * fit.z[i];
        }
        Some(Screen { base, here, known, columns, factor: information.cholesky()?, gradient, left, data })
    }

    /// How much the evidence would rise, by secants, after what the parameters can make up for. Some effects have no
    /// derivative where they begin, others bend long before they are as large as rigs show them: what promises more counts.
    fn gain(&self, candidate: &Candidate) -> Option<Screened> {
        let found = SECANTS.iter().filter_map(|size| self.gain_by(candidate, *size));
        found.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// The same by secants of `size`, in scales of each switch.
    fn gain_by(&self, candidate: &Candidate, size: f64) -> Option<Screened> {
        let fit = &self.base.fit;
        let (space, start) = fit.space.with(candidate.effect, &candidate.start, &fit.z);
        let old = fit.space.len();
        let switches: Vec<usize> = (old..space.len())
            .filter(|i| matches!(space.coordinates[*i].what, What::Effect(_, p) if p.is_switch()))
            .collect();
        let mut null = start.clone();
        switches.iter().for_each(|i| null[*i] = 0.0);
        let secants: Vec<Residuals> = switches
            .iter()
            .map(|i| {
                let c = &space.coordinates[*i];
                let size = if c.high >= size { size } else { -size.min(-c.low) };
                let mut moved = null.clone();
                moved[*i] = size;
                let there = residuals::at(&self.data, &space, &moved)?;
                Some(zip(&there, &self.here, |there, here| (there - here) / size as f32))
            })
            .collect::<Option<_>>()?;
        let own = products::matrix(&self.data, Part::Fitted, &secants.iter().collect::<Vec<_>>());
        let cross = self.columns.tr_mul(&own).map(f64::from);
        let made_up = self.factor.solve(&cross);
        let mut information = products::square(&own) - cross.transpose() * &made_up;
        let gradient: DVector<f64> = products::product(&own, &self.left) - made_up.transpose() * &self.gradient;
        let mut log_prior = 0.0;
        for (k, i) in switches.iter().enumerate() {
            let pull = space.coordinates[*i].pull.max(1e-3);
            information[(k, k)] += pull;
            log_prior += 0.5 * pull.ln();
        }
        let factor = information.cholesky()?;
        let mut sizes = -factor.solve(&gradient);
        for (k, i) in switches.iter().enumerate() {
            sizes[k] = sizes[k].clamp(space.coordinates[*i].low, space.coordinates[*i].high);
        }
        let l = factor.l();
        let promised = -gradient.dot(&sizes) - 0.5 * (l.transpose() * &sizes).norm_squared();
        let gain = promised - l.diagonal().map(f64::ln).sum() + log_prior;
        let mut start = null;
        for (k, i) in switches.iter().enumerate() {
            let c = &space.coordinates[*i];
            let least = if c.high > 0.0 { LEAST_START } else { -LEAST_START };
            start[*i] = if sizes[k].abs() < LEAST_START { least } else { sizes[k] }.clamp(c.low, c.high);
        }
        Some(Screened { candidate: candidate.clone(), gain, start })
    }
}

/// Keeps the first of every effect.
pub(crate) fn keep_first<T>(all: &mut Vec<T>, effect: impl Fn(&T) -> &'static Effect) {
    let mut seen: Vec<&'static str> = Vec::new();
    all.retain(|one| {
        let id = effect(one).id;
        let is_new = !seen.contains(&id);
        seen.push(id);
        is_new
    });
}

/// Where the refit of a candidate sets out.
#[derive(Clone)]
pub(crate) struct Sketch {
    pub(crate) fit: Fit,
    pub(crate) known: Option<Known>,
}

impl From<Explanation> for Sketch {
    fn from(explanation: Explanation) -> Self {
        let (fit, known) = explanation.into_parts();
        Sketch { fit, known }
    }
}

/// What screening comes to at one explanation.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    /// The candidates, the most promising first.
    pub(crate) screened: Vec<Screened>,
    /// The best of them, taken a few steps, the best first.
    pub(crate) sketched: Vec<Fit>,
    /// Derivatives along what they have in common.
    known: Known,
}

impl Field {
    /// Of `candidates`, several starts of one effect among them; the best of each is kept where `one_each`.
    pub(crate) fn of(data: &Data, base: &Explanation, candidates: &[Candidate], one_each: bool) -> Option<Field> {
        let screen = Screen::new(data, base)?;
        let mut screened: Vec<Screened> =
            candidates.par_iter().filter_map(|candidate| screen.gain(candidate)).collect();
        screened.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        if one_each {
            keep_first(&mut screened, |s| s.candidate.effect);
        }
        let gram = products::square(&screen.columns);
        let worth = screened.iter().filter(|s| s.gain > WORTH_A_FIT).take(SKETCHED).collect::<Vec<_>>();
        let mut sketched: Vec<Fit> = worth
            .into_par_iter()
            .filter_map(|s| {
                let (space, _) = base.fit.space.with(s.candidate.effect, &s.candidate.start, &base.fit.z);
                fit::sketch(&screen.data, &space, &s.start, &screen.columns, &gram, SKETCH_STEPS)
            })
            .collect();
        sketched.sort_by(|a, b| a.objective.total_cmp(&b.objective));
        Some(Field { screened, sketched, known: screen.known })
    }

    /// The first `most` mechanisms of the sketched, each with derivatives to set out by.
    pub(crate) fn starts(&self, data: &Data, most: usize) -> Vec<Sketch> {
        let mechanisms = self.sketched.iter().filter(|fit| !is_shape(fit)).take(most);
        mechanisms.map(|fit| self.start(data, fit)).collect()
    }

    /// Other curves, where they are among the sketched: they are beside the mechanisms and not in their place.
    pub(crate) fn shapes(&self, data: &Data) -> Vec<Sketch> {
        self.sketched.iter().filter(|fit| is_shape(fit)).map(|fit| self.start(data, fit)).collect()
    }

    fn start(&self, data: &Data, fit: &Fit) -> Sketch {
        Sketch { fit: fit.clone(), known: self.known.and_those_of(data, &fit.space, &fit.z) }
    }
}

fn is_shape(fit: &Fit) -> bool {
    fit.space.effects.last().is_some_and(|effect| effect.nature == Nature::Shape)
}
