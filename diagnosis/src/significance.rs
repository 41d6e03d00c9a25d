//! Is a gain on data kept back more than chance? A parametric bootstrap with refit, linearised about the fit: noise with
//! the spectrum of what is left is drawn, every candidate is refitted to it with all nuisance parameters, and the best
//! gain among them is what chance can do. That survives residuals that are correlated over hundreds of samples, where
//! tests that take samples as independent cry wolf nearly always.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::products;
use crate::residuals::Residuals;

/// Order of the autoregressive model of what is left.
const ORDER: usize = 6;
/// Draws of noise.
const DRAWS: usize = 999;

/// An autoregressive model of a sensor's residual.
#[derive(Debug, Clone)]
pub(crate) struct Colour {
    /// r_t = Σ φ_i r_(t−i) + e_t.
    pub(crate) coefficients: Vec<f64>,
    /// Standard deviation of e.
    pub(crate) innovation: f64,
    /// Standard deviation of r.
    pub(crate) deviation: f64,
}

impl Colour {
    /// By Yule and Walker, from all recordings of one sensor; missing samples are passed over.
    pub(crate) fn of(residuals: &Residuals, sensor: usize) -> Colour {
        let mut covariance = [0.0; ORDER + 1];
        let mut counts = [0.0; ORDER + 1];
        for by_sensor in residuals {
            let values = &by_sensor[sensor];
            for lag in 0..=ORDER {
                for (a, b) in values.iter().zip(values.iter().skip(lag)) {
                    let product = a * b;
                    if !product.is_nan() {
                        covariance[lag] += f64::from(product);
                        counts[lag] += 1.0;
                    }
                }
            }
        }
        for (c, n) in covariance.iter_mut().zip(counts) {
            *c /= f64::max(n, 1.0);
        }
        if counts[0] == 0.0 || covariance[0] <= 0.0 {
            return Colour { coefficients: vec![0.0; ORDER], innovation: 1.0, deviation: 1.0 };
        }
        let (coefficients, innovation) = levinson(&covariance);
        Colour { coefficients, innovation: innovation.max(0.0).sqrt(), deviation: covariance[0].sqrt() }
    }

    /// How many times more samples it takes to know the mean than if they were independent.
    pub(crate) fn inflation(&self) -> f64 {
        let dc = 1.0 - self.coefficients.iter().sum::<f64>();
        ((self.innovation / dc.max(1e-3)).powi(2) / (self.deviation * self.deviation)).max(1.0)
    }
}

/// Solves the Yule–Walker equations by Levinson's recursion: coefficients and the variance of the innovation.
fn levinson(covariance: &[f64]) -> (Vec<f64>, f64) {
    let order = covariance.len() - 1;
    let mut a = vec![0.0; order];
    let mut error = covariance[0] * (1.0 + 1e-9);
    for k in 0..order {
        let reflection = (covariance[k + 1] - (0..k).map(|j| a[j] * covariance[k - j]).sum::<f64>()) / error;
        let reflection = reflection.clamp(-0.9999, 0.9999);
        let before = a.clone();
        a[k] = reflection;
        for j in 0..k {
            a[j] = before[j] - reflection * before[k - 1 - j];
        }
        error *= 1.0 - reflection * reflection;
    }
    (a, error)
}

/// Probability that chance alone gives the first candidate's gain, or a better one to any of them, from the gains of each
/// candidate block by block: without anything to gain, each block would lose as often as win. Blocks are long against what
/// one error of a model lasts, where single samples, and any noise drawn after them, say far too much.
pub(crate) fn by_blocks(gains: &[Vec<f64>], seed: u64) -> f64 {
    let Some(found) = gains.first().map(|own| own.iter().sum::<f64>()) else { return 1.0 };
    let blocks = gains.iter().map(Vec::len).min().unwrap_or(0);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xb10c);
    let above = (0..DRAWS)
        .filter(|_| {
            let signs: Vec<f64> = (0..blocks).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
            let of = |own: &Vec<f64>| own.iter().zip(&signs).map(|(gain, sign)| gain * sign).sum::<f64>();
            gains.iter().map(of).fold(f64::NEG_INFINITY, f64::max) >= found
        })
        .count();
    (above + 1) as f64 / (DRAWS + 1) as f64
}

/// The gains on kept-back data that chance gives to the best of several candidates.
#[derive(Debug, Clone)]
pub(crate) struct Chance {
    gains: Vec<f64>,
    /// The best gain that the linearised candidates promise on the residuals themselves.
    promised: f64,
}

impl Chance {
    /// `nuisances` are the derivatives of the residuals along what is fitted in any case, each pulled to its prior by
    /// `pulls`; `candidates` those along each candidate's parameters.
    pub(crate) fn new(
        data: &Data,
        nuisances: &[Residuals],
        pulls: &[f64],
        candidates: &[Vec<Residuals>],
        residuals: &Residuals,
        colours: &[Colour],
        seed: u64,
    ) -> Chance {
        let columns: Vec<&Residuals> = nuisances.iter().chain(candidates.iter().flatten()).collect();
        let (n, all) = (nuisances.len(), columns.len());
        let parts = [Part::Fitted, Part::KeptBack];
        let [seen, kept] = parts.map(|part| products::square(&products::matrix(data, part, &columns)));
        let mut models: Vec<Model> = Vec::new();
        let base: Vec<usize> = (0..n).collect();
        let Some(reference) = Model::new(&base, &seen, pulls) else {
            return Chance { gains: Vec::new(), promised: 0.0 };
        };
        let mut next = n;
        for candidate in candidates {
            let own: Vec<usize> = (next..next + candidate.len()).collect();
            next += candidate.len();
            models.extend(Model::new(&[base.clone(), own].concat(), &seen, pulls));
        }
        let best_gain = |b_seen: &DVector<f64>, b_kept: &DVector<f64>| -> f64 {
            let before = reference.kept_change(b_seen, b_kept, &kept);
            models.iter().map(|m| before - m.kept_change(b_seen, b_kept, &kept)).fold(f64::NEG_INFINITY, f64::max)
        };
        // all that a draw of noise does here is its products with the columns, and those are normal with a covariance
        // that the columns, run backwards through each sensor's filter, give exactly
        let roots = parts.map(|part| {
            let filtered: Vec<Residuals> = columns.par_iter().map(|c| filtered(data, part, c, colours)).collect();
            // a root by eigenvalues: columns may well be alike
            let eigen = products::square(&products::matrix_of_all(data, &filtered.iter().collect::<Vec<_>>()))
                .symmetric_eigen();
            let spread = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
            eigen.eigenvectors * DMatrix::from_diagonal(&spread)
        });
        let [root_seen, root_kept] = &roots;
        let gains = (0..DRAWS)
            .into_par_iter()
            .map(|draw| {
                let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(draw as u64);
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
                let mut normal = || DVector::from_fn(all, |_, _| rng.sample::<f64, _>(StandardNormal));
                best_gain(&(root_seen * normal()), &(root_kept * normal()))
            })
            .collect();
        let along = |part| {
            DVector::from_iterator(
                all,
                columns.iter().map(|c| products::inner(data, part, c, residuals)).collect::<Vec<_>>(),
            )
        };
        Chance { gains, promised: best_gain(&along(Part::Fitted), &along(Part::KeptBack)) }
    }

    /// The best gain that the linearised candidates promise.
    pub(crate) fn promised(&self) -> f64 {
        self.promised
    }

    /// Probability that chance alone gives at least this gain.
    pub(crate) fn p_value(&self, gain: f64) -> f64 {
        let above = self.gains.iter().filter(|g| **g >= gain).count();
        (above + 1) as f64 / (self.gains.len() + 1) as f64
    }

    pub(crate) fn draws(&self) -> usize {
        self.gains.len()
    }
}

/// A linear least-squares fit of some of the columns.
struct Model {
    columns: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
}

impl Model {
    fn new(columns: &[usize], gram: &DMatrix<f64>, pulls: &[f64]) -> Option<Model> {
        let n = columns.len();
        let mut a = DMatrix::from_fn(n, n, |i, j| gram[(columns[i], columns[j])]);
        for (i, column) in columns.iter().enumerate() {
            a[(i, i)] += pulls.get(*column).copied().unwrap_or(0.0) + 1e-9 * a[(i, i)].abs() + 1e-12;
        }
        Some(Model { columns: columns.to_vec(), factor: a.cholesky()? })
    }

    /// Change of Σ r² over the kept-back samples by the fit to the others.
    fn kept_change(&self, b_seen: &DVector<f64>, b_kept: &DVector<f64>, kept: &DMatrix<f64>) -> f64 {
        let n = self.columns.len();
        let b = DVector::from_iterator(n, self.columns.iter().map(|c| -b_seen[*c]));
        let step = self.factor.solve(&b);
        let mut change = 0.0;
        for (i, ci) in self.columns.iter().enumerate() {
            change += 2.0 * step[i] * b_kept[*ci];
            for (j, cj) in self.columns.iter().enumerate() {
                change += step[i] * step[j] * kept[(*ci, *cj)];
            }
        }
        change
    }
}

/// A column, the samples of one part only, run backwards through each sensor's filter: Lᵀ c where L colours white noise.
fn filtered(data: &Data, part: Part, column: &Residuals, colours: &[Colour]) -> Residuals {
    data.runs
        .iter()
        .zip(column)
        .map(|(run, by_sensor)| {
            by_sensor
                .iter()
                .zip(colours)
                .map(|(values, colour)| {
                    let mut out = vec![0.0f32; values.len()];
                    let mut ahead = vec![0.0f64; colour.coefficients.len()];
                    for t in (0..values.len()).rev() {
                        let own = if run.part[t] == part && !values[t].is_nan() { f64::from(values[t]) } else { 0.0 };
                        let w = own + colour.coefficients.iter().zip(&ahead).map(|(a, w)| a * w).sum::<f64>();
                        ahead.rotate_right(1);
                        if let Some(first) = ahead.first_mut() {
                            *first = w;
                        }
                        out[t] = (colour.innovation * w) as f32;
                    }
                    out
                })
                .collect()
        })
        .collect()
}

/// Noise with the colour of each sensor's residual, in units of the sensors' noise.
pub(crate) fn draw_noise(data: &Data, colours: &[Colour], rng: &mut Xoshiro256PlusPlus) -> Residuals {
    data.runs
        .iter()
        .map(|run| {
            colours
                .iter()
                .zip(&run.measured)
                .map(|(colour, measured)| {
                    let order = colour.coefficients.len();
                    let mut past = vec![0.0; order];
                    // started from rest: let it forget that
                    let warm_up = 50;
                    let mut values = Vec::with_capacity(measured.len());
                    for t in 0..measured.len() + warm_up {
                        let e: f64 = rng.sample(StandardNormal);
                        let mut r = colour.innovation * e;
                        for (a, p) in colour.coefficients.iter().zip(&past) {
                            r += a * p;
                        }
                        past.rotate_right(1);
                        if let Some(first) = past.first_mut() {
                            *first = r;
                        }
                        if t >= warm_up {
                            values.push(if measured[t - warm_up].is_nan() { f32::NAN } else { r as f32 });
                        }
                    }
                    values
                })
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_that_gain_alike_are_no_chance_and_one_that_gains_all_may_be() {
        let alike = vec![vec![1.0; 20]];
        assert!(by_blocks(&alike, 1) < 0.002);
        let lone = |b: i32| if b == 3 { 100.0 } else { 0.1 * f64::from(b % 2) - 0.05 };
        assert!(by_blocks(&[(0..20).map(lone).collect()], 1) > 0.1);
        // by the best of many, chance does better
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut many: Vec<Vec<f64>> =
            (0..30).map(|_| (0..20).map(|_| rng.sample::<f64, _>(StandardNormal)).collect()).collect();
        many.sort_by(|a, b| b.iter().sum::<f64>().total_cmp(&a.iter().sum()));
        assert!(by_blocks(&many, 1) > 0.05 && by_blocks(&many[..1], 1) < 0.05);
        assert_eq!(by_blocks(&[], 1), 1.0);
    }

    #[test]
    fn an_autoregressive_process_is_recognised() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut r = 0.0;
        let values: Vec<f32> = (0..40_000)
            .map(|_| {
                let e: f64 = rng.sample(StandardNormal);
                r = 0.9 * r + e;
                r as f32
            })
            .collect();
        let colour = Colour::of(&vec![vec![values]], 0);
        assert!((colour.coefficients[0] - 0.9).abs() < 0.03, "{colour:?}");
        assert!((colour.innovation - 1.0).abs() < 0.03);
        // (1 + 0.9) / (1 − 0.9) = 19
        assert!((15.0..24.0).contains(&colour.inflation()), "{}", colour.inflation());
    }

    #[test]
    fn white_noise_inflates_nothing() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let values: Vec<f32> = (0..40_000).map(|_| rng.sample::<f64, _>(StandardNormal) as f32).collect();
        assert!(Colour::of(&vec![vec![values]], 0).inflation() < 1.2);
    }
}
