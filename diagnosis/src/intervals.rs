//! How well a fit knows what it fitted: 90 % intervals from the curvature, widened where what is left is correlated,
//! for effects walked out along the profile, and over all models that may as well be the right one.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::derivatives;
use crate::explanation::Explanation;
use crate::fit::{self, Effort, Fit, Known};
use crate::products;
use crate::residuals;
use crate::space::{Coordinate, What};

/// How far a simulation is to be trusted, as a share of a sensor's range: two simulators of the same equations agree to
/// this (see the physics' reference trajectories). With thousands of samples it is more than what noise leaves open.
const SIMULATION_ERROR: f64 = 2e-4;
/// Half-width of a 90 % interval, in standard deviations, and the fall of the profile there.
pub(crate) const Z90: f64 = 1.6449;
const FALL90: f64 = Z90 * Z90;
/// What is outside on either side.
const TAIL: f64 = 0.05;
/// Halvings in the search for an end, and how many standard deviations away it begins.
const HALVINGS: usize = 60;
const FAR: f64 = 6.0;

/// How often derivatives are taken on the profile, beside those there are: it ends less than two standard deviations away.
const PROFILE_STEPS: usize = 0;

/// A 90 % interval of one coordinate, in its own unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interval {
    pub(crate) value: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// Another model that may be the right one, and how probable it is beside the one whose intervals are asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rival<'a> {
    pub(crate) explanation: &'a Explanation,
    pub(crate) odds: f64,
}

/// The intervals of all coordinates of a model at the end of its fit on `data`, which may be thinned: they know as much for a
/// fraction of the work. Those of effects are walked out along the profile. What `rivals` have too is where the models say together
/// (Bayesian model averaging: Hoeting, Madigan, Raftery and Volinsky 1999): that one was chosen is no knowledge. `None` where the
/// model cannot be built.
pub(crate) fn intervals(data: &Data, found: &Explanation, rivals: &[Rival<'_>]) -> Option<Vec<Interval>> {
    let fit = &found.fit;
    let known = found.derivatives(data)?;
    let reaches = reaches(&found.judges(data)?, fit, &known);
    let others: Vec<(&Fit, Vec<f64>, f64)> =
        rivals.iter().map(|rival| (&rival.explanation.fit, rival.explanation.fit.deviations(), rival.odds)).collect();
    let plain = fit.deviations();
    let places = fit.space.coordinates.iter().zip(&fit.z).zip(reaches).enumerate();
    let interval = |(i, ((c, z), [down, up])): (usize, ((&Coordinate, &f64), [f64; 2]))| {
        let own = Belief { at: *z, down: down / Z90, up: up / Z90, weight: 1.0 };
        // what widened the one is of the recordings, and widens the others
        let widened = ((down + up) / (2.0 * Z90 * plain[i])).clamp(1.0, f64::MAX);
        let mut beliefs = vec![own];
        beliefs.extend(others.iter().filter_map(|(other, deviations, odds)| {
            let there = other.space.coordinates.iter().position(|there| there.what.is_the_same(&c.what))?;
            let (at, of) = (other.z[there], &other.space.coordinates[there]);
            let deviation = widened * deviations[there] * (of.slope(at) / c.slope(*z)).abs();
            let at = c.at(of.value(at));
            (deviation.is_finite() && at.is_finite()).then_some(Belief {
                at,
                down: deviation,
                up: deviation,
                weight: *odds,
            })
        }));
        if beliefs.len() == 1 {
            return Interval::of(c, *z, z - down, z + up);
        }
        // the best value belongs to the interval, wherever the others are
        Interval::of(c, *z, quantile(&beliefs, TAIL).min(*z), quantile(&beliefs, 1.0 - TAIL).max(*z))
    };
    Some(places.map(interval).collect())
}

/// What a model says of a coordinate: a normal with a half on either side.
#[derive(Debug, Clone, Copy)]
struct Belief {
    at: f64,
    /// Standard deviations below and above.
    down: f64,
    up: f64,
    weight: f64,
}

impl Belief {
    /// Probability of less than this.
    fn below(&self, x: f64) -> f64 {
        let deviation = if x < self.at { self.down } else { self.up };
        match (x - self.at) / deviation {
            far if far.is_finite() => 0.5 * (1.0 + libm::erf(far * std::f64::consts::FRAC_1_SQRT_2)),
            // one that is known exactly
            _ => f64::from(u8::from(x >= self.at)),
        }
    }
}

/// Where beliefs together put this much below.
fn quantile(beliefs: &[Belief], share: f64) -> f64 {
    let all: f64 = beliefs.iter().map(|belief| belief.weight).sum();
    let below = |x: f64| beliefs.iter().map(|belief| belief.weight * belief.below(x)).sum::<f64>() / all;
    let low = beliefs.iter().map(|b| b.at - FAR * b.down).fold(f64::INFINITY, f64::min);
    let high = beliefs.iter().map(|b| b.at + FAR * b.up).fold(f64::NEG_INFINITY, f64::max);
    let (mut low, mut high) = (low, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// How far each coordinate may go down and up.
fn reaches(data: &Data, fit: &Fit, known: &Known) -> Vec<[f64; 2]> {
    let n = fit.space.len();
    let spread = Spread::of(data, fit);
    let deviations = spread.as_ref().map_or_else(|| fit.deviations(), |s| s.deviations.clone());
    (0..n)
        .into_par_iter()
        .map(|i| {
            let c = &fit.space.coordinates[i];
            let z = fit.z[i];
            let reach = Z90 * deviations[i];
            let side = |sign: f64| -> f64 {
                let room = if sign > 0.0 { c.high - z } else { z - c.low };
                match &spread {
                    Some(spread) if matches!(c.what, What::Effect(..)) && reach < room => {
                        profile(data, fit, known, spread, i, sign * reach).unwrap_or(reach).min(room)
                    }
                    _ => reach.min(room.max(0.0)),
                }
            };
            [side(-1.0), side(1.0)]
        })
        .collect()
}

impl Interval {
    /// A value known to a standard deviation, in the coordinate's scales, within its bounds.
    pub(crate) fn about(c: &Coordinate, z: f64, deviation: f64) -> Interval {
        Interval::of(c, z, z - Z90 * deviation, z + Z90 * deviation)
    }

    fn of(c: &Coordinate, z: f64, low: f64, high: f64) -> Interval {
        let [a, b] = [low, high].map(|end| c.value(end.clamp(c.low, c.high)));
        Interval { value: c.value(z), low: a.min(b), high: a.max(b) }
    }
}

/// How far the coordinate may go before the profile has fallen as far as a 90 % interval allows, given a first guess.
fn profile(data: &Data, fit: &Fit, known: &Known, spread: &Spread, i: usize, guess: f64) -> Option<f64> {
    let target = FALL90 * spread.inflation[i];
    let mut space = fit.space.clone();
    // the others go along as far as a straight valley would take them
    let mut z: Vec<f64> = (0..fit.z.len())
        .map(|j| fit.z[j] + guess * spread.covariance[(j, i)] / spread.covariance[(i, i)].max(1e-300))
        .collect();
    z[i] = fit.z[i] + guess;
    // held there: no room to move
    let c = &mut space.coordinates[i];
    (c.low, c.high) = (z[i], z[i]);
    let known = &mut Some(known.clone());
    let refitted = fit::fit_from(data, &space, &z, &mut None, Effort::iterations(PROFILE_STEPS), known)?;
    let fall = refitted.objective - fit.objective;
    if fall <= 0.0 {
        return Some(guess.abs() * 2.0);
    }
    // a parabola through the two points, but no wild extrapolation
    Some(guess.abs() * (target / fall).sqrt().clamp(0.5, 2.5))
}

/// What the curvature of a fit says.
struct Spread {
    /// Standard deviations of the coordinates, in their scales, widened where what is left is correlated.
    deviations: Vec<f64>,
    /// By how much that widened each, as a variance.
    inflation: Vec<f64>,
    /// Of the coordinates, not widened.
    covariance: DMatrix<f64>,
}

impl Spread {
    /// Gradients summed over blocks show how far the samples of a block pull together.
    fn of(data: &Data, fit: &Fit) -> Option<Spread> {
        let n = fit.space.len();
        let here = fit.residuals(data)?;
        let columns = derivatives::sharp(data, &fit.space, &fit.z)?;
        let mut information = products::gram(data, Part::Fitted, &columns);
        fit.space.add_pulls(&mut information);
        for i in 0..n {
            information[(i, i)] += 1e-12;
        }
        let covariance = information.cholesky()?.inverse();
        let mut middle: DMatrix<f64> = DMatrix::zeros(n, n);
        // what an error of one size throughout comes to where residuals are whitened
        let ones = residuals::zip(&here, &here, |a, _| if a.is_nan() { f32::NAN } else { 1.0 });
        let ones = data.white(&ones);
        for (r, run) in data.runs.iter().enumerate() {
            let blocks = run.block.last().map_or(0, |b| b + 1);
            for s in 0..data.sensors.len() {
                // what the simulation itself may be wrong by, the same way throughout a block
                let wrong = SIMULATION_ERROR * run.range(s) / data.sensors[s].noise;
                let mut pulls = vec![DVector::<f64>::zeros(n); blocks];
                let mut errors = pulls.clone();
                for (i, column) in columns.iter().enumerate() {
                    for (row, (d, residual)) in column[r][s].iter().zip(&here[r][s]).enumerate() {
                        if run.part[row] == Part::Fitted && !d.is_nan() && !residual.is_nan() {
                            pulls[run.block[row]][i] += f64::from(d * residual);
                            errors[run.block[row]][i] += wrong * f64::from(*d * ones[r][s][row]);
                        }
                    }
                }
                for sum in pulls.iter().chain(&errors) {
                    middle += sum * sum.transpose();
                }
            }
        }
        fit.space.add_pulls(&mut middle);
        let sandwich = &covariance * middle * &covariance;
        let (deviations, inflation) = (0..n)
            .map(|i| {
                let plain = covariance[(i, i)].max(0.0);
                let wide = sandwich[(i, i)].max(plain);
                (wide.sqrt(), (wide / plain.max(1e-300)).max(1.0))
            })
            .unzip();
        Some(Spread { deviations, inflation, covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beliefs_together_are_as_wide_as_they_differ() {
        let belief = |at: f64, weight: f64| Belief { at, down: 1.0, up: 1.0, weight };
        assert!((quantile(&[belief(0.0, 1.0)], TAIL) + Z90).abs() < 1e-4);
        // another one far away takes what it is worth of either tail
        let apart = [belief(0.0, 1.0), belief(30.0, 1.0)];
        // P(x < q) = 0.05 over both is 0.1 of the first
        assert!((quantile(&apart, TAIL) + 1.2816).abs() < 1e-3, "{}", quantile(&apart, TAIL));
        assert!((quantile(&apart, 1.0 - TAIL) - 31.2816).abs() < 1e-3);
        // and one that is improbable none
        let one = [belief(0.0, 1.0), belief(30.0, 1e-3)];
        assert!((quantile(&one, 1.0 - TAIL) - Z90).abs() < 0.02);
        // halves of their own
        let skewed = [Belief { at: 1.0, down: 0.5, up: 2.0, weight: 1.0 }];
        assert!((quantile(&skewed, TAIL) - (1.0 - 0.5 * Z90)).abs() < 1e-4);
        assert!((quantile(&skewed, 1.0 - TAIL) - (1.0 + 2.0 * Z90)).abs() < 1e-4);
    }
}
