//! A model of the wire fitted together with the error it leaves, and how probable that makes the recordings.

use nalgebra::DMatrix;
use sinew_physics::effects::Effect;

use crate::data::{Data, Sensor};
use crate::discrepancy::{Discrepancy, Wander};
use crate::fit::{self, Effort, Fit, Known};
use crate::residuals::{self, Residuals};
use crate::space::Space;

/// Sizes of a model's error on the way from belief, as shares of each sensor's range, and its memory there, s: the large
/// features of a recording lead, and parameters stay where they are believed until the data insist.
const SHARES: [f64; 3] = [0.3, 0.1, 0.04];
/// The one of them at which what is missing is looked for first.
const NEAR: f64 = 0.1;
const MEMORY_S: f64 = 2.0;
/// Iterations at each of these sizes.
const ON_THE_WAY: usize = 2;
/// Most rounds of parameters and error refitted by turns, and the rise of evidence that ends them.
const ROUNDS: usize = 6;
const SETTLED: f64 = 0.3;
/// What is negligible on the way and where models are compared, which differ by tens where one is taken for the other.
const ROUGHLY: f64 = 1.0;

/// An error of a model of less than this, in units of noise, is as good as none.
const NEXT_TO_NOTHING: f64 = 0.25;
/// One that nobody overlooks.
const PLAIN: f64 = 2.0;

/// A model fitted, and the error it is known to leave.
#[derive(Debug, Clone)]
pub(crate) struct Explanation {
    /// By residuals whitened for `discrepancy`.
    pub(crate) fit: Fit,
    pub(crate) discrepancy: Discrepancy,
    /// Logarithm of the probability of what is fitted, the parameters and the error integrated over (Laplace), up to what
    /// is common to all models.
    pub(crate) evidence: f64,
    /// The last derivatives that were taken, for whoever goes on from here on data of the same rows.
    known: Option<Known>,
}

/// How long an explanation is refitted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turns {
    pub(crate) rounds: usize,
    /// How often derivatives are taken in the first of them.
    pub(crate) iterations: usize,
    /// What ends them: as [`Effort::negligible`], and as a rise of the evidence.
    negligible: f64,
    settled: f64,
}

impl Turns {
    /// To the end.
    pub(crate) const ALL: Turns = Turns { rounds: ROUNDS, iterations: 6, negligible: 0.1, settled: SETTLED };
    /// Far enough to see whether it is worth more.
    pub(crate) const FIRST: Turns = Turns { rounds: 1, iterations: 1, ..Turns::SOME };
    /// Far enough to be compared.
    pub(crate) const SOME: Turns = Turns { rounds: 3, iterations: 4, negligible: ROUGHLY, settled: ROUGHLY };
}

impl Explanation {
    /// From `start`, where everything that may move is believed to be: with a large error first, which lets the large features
    /// of a recording lead, and smaller ones then. Gives also the explanation while the error was large enough for all
    /// parameters to stay near: there what is missing shows before anything has made up for it.
    pub(crate) fn from_belief(data: &Data, space: &Space, start: &[f64], turns: Turns) -> Option<[Explanation; 2]> {
        let mut z = start.to_vec();
        let mut left = residuals::plain_at(data, space, &z)?;
        let mut near = None;
        let mut known = None;
        for share in SHARES {
            let discrepancy = Discrepancy::of_range(data, share, MEMORY_S);
            let effort = Effort { iterations: ON_THE_WAY - usize::from(known.is_some()), negligible: ROUGHLY };
            let fit = refit(data, space, &z, &discrepancy, &mut left, effort, &mut known)?;
            z.clone_from(&fit.z);
            if share == NEAR {
                near = Explanation::new(data, fit, discrepancy, &left, known.clone());
            }
        }
        let last = Discrepancy::of_range(data, SHARES[SHARES.len() - 1], MEMORY_S);
        Some([near?, Explanation::by(data, space, &z, &last, turns, known)?])
    }

    /// Whether it leaves nothing but noise, which may have a colour: then nothing can be better.
    pub(crate) fn leaves_noise(&self) -> bool {
        self.discrepancy.wanders.iter().flatten().all(is_noise)
    }

    /// Whether it leaves nothing but noise, or is wrong by no more than rounding is, in every sensor of `data`, which it explains: what a converter rounds off keeps its sign
    /// for as long as the values stand between two levels, as an error of the model does.
    pub(crate) fn leaves_rounding(&self, data: &Data) -> bool {
        let is_rounding =
            |(wander, sensor): (&Wander, &Sensor)| is_noise(wander) || wander.size * sensor.noise <= sensor.rounding;
        self.discrepancy.wanders.iter().all(|run| run.iter().zip(&data.sensors).all(is_rounding))
    }

    /// Whether it is wrong by less than the noise in every sensor.
    pub(crate) fn leaves_little(&self) -> bool {
        self.discrepancy.is_less_than(1.0)
    }

    /// The evidence of a model that knows its parameters as well and leaves nothing but noise: what there is to gain.
    pub(crate) fn evidence_of_noise(&self, data: &Data) -> Option<f64> {
        let left = residuals::plain_at(data, &self.fit.space, &self.fit.z)?;
        let noise = Discrepancy::of_range(data, 0.0, 1.0).whitened(data, &left).whitening?;
        let objective = self.fit.score.fitted_count + self.fit.space.resistance(&self.fit.z);
        Some(evidence(&self.fit, objective, noise.log_fitted, noise.prior))
    }

    /// Whether it is wrong by less than the noise wherever it was fitted, and plainly in what was kept back: what is missing, or a
    /// parameter that nothing else tells, acts only there.
    pub(crate) fn errs_where_kept_back_only(&self, data: &Data) -> bool {
        let on_kept = |left| self.discrepancy.on_kept(data, &left).is_less_than(PLAIN);
        self.leaves_little()
            && residuals::plain_at(data, &self.fit.space, &self.fit.z).is_some_and(|left| !on_kept(left))
    }

    /// From `start`, with an error like `discrepancy` to begin with. `None` where the start is impossible.
    pub(crate) fn of(
        data: &Data,
        space: &Space,
        start: &[f64],
        discrepancy: &Discrepancy,
        turns: Turns,
    ) -> Option<Explanation> {
        Explanation::by(data, space, start, discrepancy, turns, None)
    }

    /// The same, setting out by derivatives that are known from somewhere near.
    pub(crate) fn by(
        data: &Data,
        space: &Space,
        start: &[f64],
        discrepancy: &Discrepancy,
        turns: Turns,
        mut known: Option<Known>,
    ) -> Option<Explanation> {
        let mut left = residuals::plain_at(data, space, start)?;
        let mut discrepancy = discrepancy.refitted(data, &left);
        let mut z = start.to_vec();
        let mut best: Option<Explanation> = None;
        for round in 0..turns.rounds {
            // the first one goes by derivatives taken as often as it likes, the others by what is known, and once more
            let iterations = if round == 0 { turns.iterations } else { 1 };
            let effort = Effort { iterations, negligible: turns.negligible };
            let fit = refit(data, space, &z, &discrepancy, &mut left, effort, &mut known)?;
            discrepancy = discrepancy.refitted(data, &left);
            z.clone_from(&fit.z);
            let found = Explanation::new(data, fit, discrepancy.clone(), &left, known.clone())?;
            let rise = best.as_ref().map_or(f64::INFINITY, |best| found.evidence - best.evidence);
            if rise > 0.0 {
                best = Some(found);
            }
            if rise < turns.settled {
                break;
            }
        }
        best
    }

    /// Another model from `start`, a few steps, with the same error: evidence that can be compared while the error is held.
    pub(crate) fn of_another(&self, data: &Data, space: &Space, start: &[f64]) -> Option<Explanation> {
        let mut left = residuals::plain_at(data, space, start)?;
        let effort = Effort { iterations: ON_THE_WAY, negligible: ROUGHLY };
        let mut known = None;
        let fit = refit(data, space, start, &self.discrepancy, &mut left, effort, &mut known)?;
        Explanation::new(data, fit, self.discrepancy.clone(), &left, known)
    }

    /// The fit, and the last derivatives that were taken.
    pub(crate) fn into_parts(self) -> (Fit, Option<Known>) {
        (self.fit, self.known)
    }

    /// The same refitted on `data` of the same rows, with an error like its own to begin with.
    pub(crate) fn again(&self, data: &Data, turns: Turns) -> Option<Explanation> {
        Explanation::by(data, &self.fit.space, &self.fit.z, &self.discrepancy, turns, self.known.clone())
    }

    /// The same without one of its effects, everything else refitted.
    pub(crate) fn without(&self, data: &Data, effect: &Effect, turns: Turns) -> Option<Explanation> {
        let (space, z) = self.fit.space.without(effect, &self.fit.z);
        let known = self.known.as_ref().map(|known| known.without(&self.fit.space, effect));
        Explanation::by(data, &space, &z, &self.discrepancy, turns, known)
    }

    /// The same without one of its effects, everything else left as it is.
    pub(crate) fn bared_of(&self, effect: &Effect) -> Explanation {
        let (space, z) = self.fit.space.without(effect, &self.fit.z);
        Explanation { fit: Fit { space, z, ..self.fit.clone() }, known: None, ..self.clone() }
    }

    /// The same model judged by `data` of other rows.
    pub(crate) fn on(&self, data: &Data) -> Option<Explanation> {
        let left = residuals::plain_at(data, &self.fit.space, &self.fit.z)?;
        let discrepancy = self.discrepancy.refitted(data, &left);
        Explanation::new(data, self.fit.clone(), discrepancy, &left, None)
    }

    /// Derivatives at its place.
    pub(crate) fn derivatives(&self, data: &Data) -> Option<Known> {
        let Fit { space, z, information, .. } = &self.fit;
        let known = self.known.clone().filter(|known| known.serve(z, information));
        known.or_else(|| Known::at(data, space, z))
    }

    /// The same for comparison only: nobody goes on from it.
    pub(crate) fn at_rest(self) -> Explanation {
        Explanation { known: None, ..self }
    }

    /// A fit judged by the error it leaves.
    fn new(
        data: &Data,
        fit: Fit,
        discrepancy: Discrepancy,
        left: &Residuals,
        known: Option<Known>,
    ) -> Option<Explanation> {
        let whitened = discrepancy.whitened(data, left);
        let white = whitened.whitening.as_ref()?.whiten(left);
        let score = residuals::score(&whitened, &white);
        let objective = score.fitted + fit.space.resistance(&fit.z);
        let fit = Fit { score, objective, ..fit };
        let prior_of_error = whitened.whitening.as_ref()?.prior;
        let evidence = evidence(&fit, objective, score.fitted_log, prior_of_error);
        Some(Explanation { fit, discrepancy, evidence, known })
    }

    /// Minus twice the logarithm of how probable what is kept back is.
    pub(crate) fn deviance_kept(&self, data: &Data) -> Option<f64> {
        let left = residuals::plain_at(data, &self.fit.space, &self.fit.z)?;
        Some(self.discrepancy.deviance_kept(data, &left))
    }

    /// How much more probable it makes what is kept back than `without` does, by the logarithm; 0 where one of them is impossible.
    pub(crate) fn rise_on_kept(&self, data: &Data, without: &Explanation) -> f64 {
        match (without.deviance_kept(data), self.deviance_kept(data)) {
            (Some(without), Some(with)) => 0.5 * (without - with),
            _ => 0.0,
        }
    }

    /// The data as this explanation judges them.
    pub(crate) fn judges(&self, data: &Data) -> Option<Data> {
        Some(self.discrepancy.whitened(data, &residuals::plain_at(data, &self.fit.space, &self.fit.z)?))
    }
}

/// Fits from `start`, where so much is `left` of everything, not whitened, judged by an error like `discrepancy`; leaves what is left at
/// the end, and derivatives as [`fit::fit_from`] does.
fn refit(
    data: &Data,
    space: &Space,
    start: &[f64],
    discrepancy: &Discrepancy,
    left: &mut Residuals,
    effort: Effort,
    known: &mut Option<Known>,
) -> Option<Fit> {
    let mut fitted = Some(residuals::without_held_out(data, left));
    let fit = fit::fit_from(&discrepancy.whitened(data, left), space, start, &mut fitted, effort, known)?;
    *left = residuals::with_held_out(data, space, &fit.z, fitted?)?;
    Some(fit)
}

/// Whether an error of a model is as good as none, or the colour of noise.
fn is_noise(wander: &Wander) -> bool {
    wander.size < NEXT_TO_NOTHING || wander.is_brief && wander.size < 1.0
}

/// Laplace's approximation at the end of a fit, by its objective, the logarithms of the variances behind it, and what the error of the
/// model costs by its own prior.
fn evidence(fit: &Fit, objective: f64, log_variances: f64, prior_of_error: f64) -> f64 {
    -0.5 * (objective + log_variances + prior_of_error) + fit.space.log_prior()
        - 0.5 * log_determinant(&fit.information)
}

/// ln |H| of a positive matrix, directions that nothing holds left out.
fn log_determinant(matrix: &DMatrix<f64>) -> f64 {
    matrix.clone().symmetric_eigenvalues().iter().filter(|value| **value > 1e-12).map(|value| value.ln()).sum()
}
