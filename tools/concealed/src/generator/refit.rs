//! How much of an effect is left once every uncertain parameter has been refitted: its level.
//!
//! The refit is Gauss–Newton against the priors, with a Jacobian taken at the truth without the effect and improved on the
//! way by Broyden's updates; a thorough refit takes it anew where that ends, and goes on. It is meant to be about as good
//! as a fit can be, not to be the diagnosis' own.

use super::bench::{Bench, PRIORS};
use super::world::{Concealed, World};

/// Step of the derivatives, in σ of the priors.
const DERIVATIVE_STEP: f64 = 0.05;
/// Stands for the size of another effect among the parameters' keys.
const OTHER: &str = "size of another effect";
/// Most rounds of Gauss–Newton with one Jacobian, and how often it is taken anew.
const ROUNDS: usize = 10;
const RELINEARISED: usize = 2;

/// A truth without the effect, and how its sensors follow the uncertain parameters and the sizes of other effects.
pub struct Refit<'a, W> {
    bench: &'a Bench,
    duty: &'a [f64],
    /// The truth without the effect.
    base: W,
    /// Other effects that are there, and their sizes: these are refitted, too.
    others: Vec<(&'a dyn Concealed<W>, f64)>,
    /// Everything the sensors show of it, over their noise.
    clean: Vec<f64>,
    /// σ of each parameter in its key's unit, and where truth is from the rig file in σ.
    parameters: Vec<(&'static str, f64, f64)>,
    /// By parameter: derivative of `clean`, per σ.
    jacobian: Vec<Vec<f64>>,
    /// Cholesky factor of JᵀJ + 1.
    factor: Vec<Vec<f64>>,
}

/// Where a refit stands.
struct Fit {
    /// Parameters, in σ from the base.
    z: Vec<f64>,
    residual: Vec<f64>,
    cost: f64,
}

impl<'a, W: World> Refit<'a, W> {
    /// For a truth without the effect under one programme. `others` are not yet in `base`.
    pub fn new(bench: &'a Bench, base: &W, others: Vec<(&'a dyn Concealed<W>, f64)>, duty: &'a [f64]) -> Self {
        let coefficients = base.coefficients();
        let mut parameters: Vec<(&'static str, f64, f64)> = PRIORS
            .iter()
            .filter_map(|(key, prior)| {
                let believed = bench.believed.get(key);
                let sigma = prior.sigma(believed);
                (sigma > 0.0).then(|| (*key, sigma, (coefficients.get(key) - believed) / sigma))
            })
            .collect();
        // a size may become nothing or double within 1 σ
        parameters.extend(others.iter().map(|_| (OTHER, 1.0, 0.0)));
        let base = base.clone();
        let mut refit =
            Refit { bench, duty, base, others, clean: Vec::new(), parameters, jacobian: vec![], factor: vec![] };
        refit.clean = refit.shown(&refit.at(&vec![0.0; refit.parameters.len()]));
        refit.jacobian = refit.jacobian_at(&vec![0.0; refit.parameters.len()], &refit.clean);
        refit.factor = cholesky(&refit.jacobian);
        refit
    }

    /// Derivatives at `z`, where `shown` is what sensors show.
    fn jacobian_at(&self, z: &[f64], shown: &[f64]) -> Vec<Vec<f64>> {
        (0..z.len())
            .map(|p| {
                let mut moved = z.to_vec();
                moved[p] += DERIVATIVE_STEP;
                let moved = self.shown(&self.at(&moved));
                moved.iter().zip(shown).map(|(a, b)| (a - b) / DERIVATIVE_STEP).collect()
            })
            .collect()
    }

    /// The base with its parameters moved by `z` σ.
    fn at(&self, z: &[f64]) -> W {
        let mut world = self.base.clone();
        let truth = world.coefficients_mut();
        let one_modulus = self.bench.believed.material.e_a == self.bench.believed.material.e_m;
        for ((key, sigma, _), z) in self.parameters.iter().zip(z) {
            if *key == OTHER {
                continue;
            }
            let value = (truth.get(key) + sigma * z).max(if key.ends_with("_c") { -50.0 } else { 1e-3 * sigma });
            // a rig file that says there is one modulus
            if one_modulus && *key == "martensite_modulus_gpa" {
                continue;
            }
            truth.set(key, value);
            if one_modulus && *key == "austenite_modulus_gpa" {
                truth.set("martensite_modulus_gpa", value);
            }
        }
        truth.material.m = truth.material.m.min(truth.material.a - 1.0);
        let sizes = &z[z.len() - self.others.len()..];
        for ((other, size), z) in self.others.iter().zip(sizes) {
            other.put_into(self.bench, &mut world, size * (1.0 + z).max(1e-3));
        }
        world
    }

    fn shown(&self, world: &W) -> Vec<f64> {
        let columns = world.perfect(self.bench, self.duty, W::LEVEL_STEP_S);
        columns
            .iter()
            .zip(self.bench.sensors.values())
            .flat_map(|(column, noise)| column.iter().map(move |v| v / noise))
            .collect()
    }

    /// Standard deviations of the sizes of the effects that are there, as shares of them, with everything else refitted:
    /// by Cramér and Rao, in white noise.
    pub fn deviations_of_others(&self) -> Vec<f64> {
        let n = self.parameters.len();
        let unit = |i: usize| (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        (n - self.others.len()..n).map(|i| solve(&self.factor, unit(i))[i].max(0.0).sqrt()).collect()
    }

    /// RMS over the noise, all sensors alike, of what a truth with the effect leaves after refitting without it.
    /// Infinite where the truth is no wire that could be simulated.
    pub fn left(&self, with_effect: &W, thorough: bool) -> f64 {
        let target = self.shown(with_effect);
        let z = vec![0.0; self.parameters.len()];
        let residual: Vec<f64> = target.iter().zip(&self.clean).map(|(a, b)| a - b).collect();
        let mut fit = Fit { cost: self.cost(&residual, &z), z, residual };
        self.descend(&target, &mut fit, self.jacobian.clone(), self.factor.clone());
        if thorough {
            for _ in 0..RELINEARISED {
                let before = fit.cost;
                let shown: Vec<f64> = target.iter().zip(&fit.residual).map(|(a, b)| a - b).collect();
                let jacobian = self.jacobian_at(&fit.z, &shown);
                let factor = cholesky(&jacobian);
                self.descend(&target, &mut fit, jacobian, factor);
                if fit.cost > 0.95 * before {
                    break;
                }
            }
        }
        let rms = (dot(&fit.residual, &fit.residual) / fit.residual.len() as f64).sqrt();
        if rms.is_finite() { rms } else { f64::INFINITY }
    }

    /// Rounds of Gauss–Newton until one hardly helps.
    fn descend(&self, target: &[f64], fit: &mut Fit, mut jacobian: Vec<Vec<f64>>, mut factor: Vec<Vec<f64>>) {
        for _ in 0..ROUNDS {
            let right: Vec<f64> = jacobian
                .iter()
                .zip(self.parameters.iter().zip(&fit.z))
                .map(|(j, ((_, _, away), z))| dot(j, &fit.residual) - (away + z))
                .collect();
            let step = solve(&factor, right);
            let before = fit.cost;
            for share in [1.0, 0.4, 0.1] {
                let moved: Vec<f64> = step.iter().map(|s| share * s).collect();
                let z: Vec<f64> = fit.z.iter().zip(&moved).map(|(z, s)| z + s).collect();
                let shown = self.shown(&self.at(&z));
                let residual: Vec<f64> = target.iter().zip(&shown).map(|(a, b)| a - b).collect();
                let cost = self.cost(&residual, &z);
                if !cost.is_finite() {
                    continue;
                }
                // Broyden: the Jacobian that would have foretold this
                let square = dot(&moved, &moved).max(1e-12);
                let mut missed: Vec<f64> = fit.residual.iter().zip(&residual).map(|(a, b)| (a - b) / square).collect();
                for (j, moved) in jacobian.iter().zip(&moved) {
                    missed.iter_mut().zip(j).for_each(|(m, j)| *m -= j * moved / square);
                }
                for (j, moved) in jacobian.iter_mut().zip(&moved) {
                    j.iter_mut().zip(&missed).for_each(|(j, m)| *j += m * moved);
                }
                if cost < fit.cost {
                    *fit = Fit { z, residual, cost };
                    break;
                }
            }
            if fit.cost > 0.97 * before {
                break;
            }
            factor = cholesky(&jacobian);
        }
    }

    fn cost(&self, residual: &[f64], z: &[f64]) -> f64 {
        dot(residual, residual) + self.parameters.iter().zip(z).map(|((_, _, away), z)| (away + z).powi(2)).sum::<f64>()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Lower factor of JᵀJ + 1; the one is the priors' and keeps it positive.
fn cholesky(jacobian: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = jacobian.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = dot(&jacobian[i], &jacobian[j]) + if i == j { 1.0 } else { 0.0 };
            for (a, b) in lower[i][..j].iter().zip(&lower[j][..j]) {
                sum -= a * b;
            }
            lower[i][j] = if i == j { sum.max(1e-300).sqrt() } else { sum / lower[j][j] };
        }
    }
    lower
}

fn solve(lower: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    for i in 0..n {
        for j in 0..i {
            x[i] -= lower[i][j] * x[j];
        }
        x[i] /= lower[i][i];
    }
    for i in (0..n).rev() {
        for j in i + 1..n {
            x[i] -= lower[j][i] * x[j];
        }
        x[i] /= lower[i][i];
    }
    x
}
