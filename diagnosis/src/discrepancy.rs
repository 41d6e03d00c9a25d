//! A likelihood that knows that the model is wrong. What a model leaves of a sensor is its noise and, beside it, an error
//! of the model that keeps its sign for a while: a process with a size and a memory of its own, by recording and sensor.
//! Thousands of samples that repeat one error then count as what they know, and parameters stay where they are believed.
//!
//! The covariance of a residual, in units of the sensor's noise, is K = (1 + (ẏ δt)²) I + a² exp(−|t − t'| / τ): white
//! noise (more of it in a row of fewer samples than usual), what half a row of time is worth where the signal is steep, and the process. A Kalman filter of one state
//! whitens residuals, and derivatives, in one pass; normal equations, steps and curvatures are then those of white noise.
//! Blocks kept back are whitened each from its own start: their density is marginal, and no process interpolates into
//! them from its neighbours.

use std::sync::Arc;

use rayon::prelude::*;

use crate::data::{Data, Part, Run};
use crate::whitening::{Filter, Residuals, Sight, Whitening};

/// Largest error of a model, as a share of the sensor's range: a larger process swallows the misfit, and the fit stays
/// wherever it is.
const LARGEST: f64 = 0.02;
/// Least one, in units of noise: below it nothing changes.
const SMALLEST: f64 = 0.02;
/// Memories, s; the least is besides at least two rows.
const MEMORIES_S: (f64, f64) = (0.02, 10.0);
/// A memory of less than so many times the shortest is as short as there is.
const BRIEF: f64 = 1.5;
/// How far the logarithms of size and memory may lie from noise's own size and from one second, 1 σ.
const SIZE_SPREAD: f64 = 5.0;
const MEMORY_SPREAD: f64 = 2.5;
/// Steps of the search for size and memory, in their logarithms.
const FIRST_STEP: f64 = 1.0;
const LAST_STEP: f64 = 0.06;
/// What an instant of a sample is known to, in rows.
const INSTANT: f64 = 0.5;

/// The error of a model in one sensor of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wander {
    /// RMS, in units of the sensor's noise.
    pub(crate) size: f64,
    /// Time after which it is forgotten to 1/e, s.
    pub(crate) memory_s: f64,
    /// Its memory is the shortest there is, about two rows: no model errs so, but filters and amplifiers colour noise.
    pub(crate) is_brief: bool,
}

/// The errors of a model, by recording and sensor.
#[derive(Debug, Clone)]
pub(crate) struct Discrepancy {
    pub(crate) wanders: Vec<Vec<Wander>>,
}

impl Discrepancy {
    /// One that is the given share of each sensor's range and lasts `memory_s`.
    pub(crate) fn of_range(data: &Data, share: f64, memory_s: f64) -> Discrepancy {
        let by_sensor = |run: &Run| {
            let sensors = data.sensors.iter().enumerate();
            sensors
                .map(|(s, sensor)| {
                    let size = (share * run.range(s) / sensor.noise).max(SMALLEST);
                    Wander::new(size, memory_s)
                })
                .collect()
        };
        Discrepancy { wanders: data.runs.iter().map(by_sensor).collect() }
    }

    /// The most probable one for `left`, residuals over noise that are not whitened, searched from this one.
    pub(crate) fn refitted(&self, data: &Data, left: &Residuals) -> Discrepancy {
        let mut refitted = self.most_probable(data, Part::Fitted, LARGEST, left).1;
        refitted.expect_in_held_out(data);
        refitted
    }

    /// The same for what is kept back of `left`.
    pub(crate) fn on_kept(&self, data: &Data, left: &Residuals) -> Discrepancy {
        self.most_probable(data, Part::KeptBack, LARGEST, left).1
    }

    /// The most probable one for a part of `left`, searched from this one, its size at most that share of each sensor's range; before
    /// it minus twice the logarithm of the probability.
    fn most_probable(&self, data: &Data, part: Part, most: f64, left: &Residuals) -> (f64, Discrepancy) {
        let largest = Discrepancy::of_range(data, most, 1.0);
        let places: Vec<(usize, usize)> =
            (0..data.runs.len()).flat_map(|r| (0..data.sensors.len()).map(move |s| (r, s))).collect();
        let (deviances, found): (Vec<f64>, Vec<Wander>) = places
            .into_par_iter()
            .map(|(r, s)| {
                let most = largest.wanders[r][s].size.max(2.0 * SMALLEST);
                Signal::of(data, r, s, left).most_probable(part, self.wanders[r][s], most, &left[r][s])
            })
            .unzip();
        let sensors = data.sensors.len().max(1);
        (deviances.iter().sum(), Discrepancy { wanders: found.chunks(sensors).map(<[Wander]>::to_vec).collect() })
    }

    /// Whether it is less than so many times the noise in every sensor.
    pub(crate) fn is_less_than(&self, noises: f64) -> bool {
        self.wanders.iter().flatten().all(|wander| wander.size < noises)
    }

    /// In a recording that is kept back as a whole an error is expected as large as in the others.
    fn expect_in_held_out(&mut self, data: &Data) {
        for s in 0..data.sensors.len() {
            let fitted = data.runs.iter().zip(&self.wanders).filter(|(run, _)| !run.held_out);
            let seen: Vec<Wander> = fitted.map(|(_, by_sensor)| by_sensor[s]).collect();
            let Some(largest) = seen.iter().max_by(|a, b| a.size.total_cmp(&b.size)) else { continue };
            let square = seen.iter().map(|wander| wander.size * wander.size).sum::<f64>() / seen.len() as f64;
            let expected = Wander { size: square.sqrt(), ..*largest };
            for (run, by_sensor) in data.runs.iter().zip(&mut self.wanders) {
                if run.held_out {
                    by_sensor[s] = expected;
                }
            }
        }
    }

    /// Minus twice the logarithm of how probable what is kept back of `left` is, in every block by itself, with an error of its
    /// own size and memory: one that is found where the fit sees, where it may be none, would make any error elsewhere a
    /// catastrophe.
    pub(crate) fn deviance_kept(&self, data: &Data, left: &Residuals) -> f64 {
        self.most_probable(data, Part::KeptBack, 1.0, left).0
    }

    /// The data for a model that is wrong by this; `left` are its residuals over noise.
    pub(crate) fn whitened(&self, data: &Data, left: &Residuals) -> Data {
        Data { whitening: Some(Arc::new(self.whitening(data, left))), ..data.clone() }
    }

    /// The filters that whiten what is left of `data`; `left` are residuals over noise near which they will be used.
    fn whitening(&self, data: &Data, left: &Residuals) -> Whitening {
        let mut whitening = Whitening { filters: Vec::new(), log_fitted: 0.0, prior: 0.0 };
        for (r, by_sensor) in self.wanders.iter().enumerate() {
            let filters: Vec<(Filter, [f64; 2])> = by_sensor
                .par_iter()
                .enumerate()
                .map(|(s, wander)| Signal::of(data, r, s, left).filter(*wander))
                .collect();
            whitening.prior += by_sensor.iter().map(|wander| wander.penalty()).sum::<f64>();
            whitening.log_fitted += filters.iter().map(|(_, [fitted, _])| fitted).sum::<f64>();
            whitening.filters.push(filters.into_iter().map(|(filter, _)| filter).collect());
        }
        whitening
    }
}

impl Wander {
    /// One that is no finding of its own.
    const fn new(size: f64, memory_s: f64) -> Wander {
        Wander { size, memory_s, is_brief: false }
    }

    /// Minus twice the logarithm of its own prior.
    fn penalty(self) -> f64 {
        (self.size.ln() / SIZE_SPREAD).powi(2) + (self.memory_s.ln() / MEMORY_SPREAD).powi(2)
    }
}

/// One sensor in one recording, as a filter sees it.
struct Signal {
    sight: Arc<[Sight]>,
    /// Time since the sample before, s.
    since_s: Vec<f64>,
    /// White variance of every sample, in units of noise².
    white: Vec<f64>,
}

impl Signal {
    fn of(data: &Data, r: usize, s: usize, left: &Residuals) -> Signal {
        let (run, sensor) = (&data.runs[r], &data.sensors[s]);
        let n = run.time_s.len();
        let mut block = usize::MAX;
        let sight = (0..n)
            .map(|row| match run.part[row] {
                _ if left[r][s][row].is_nan() => Sight::Missing,
                Part::LeftOut => Sight::Missing,
                Part::Fitted => Sight::Fitted,
                Part::KeptBack if run.block[row] == block => Sight::Kept,
                Part::KeptBack => {
                    block = run.block[row];
                    Sight::FirstKept
                }
            })
            .collect();
        let since_s = (0..n).map(|row| if row == 0 { 0.0 } else { run.time_s[row] - run.time_s[row - 1] }).collect();
        // the model's own signal: what was measured less what it leaves
        let seen = |row: usize| run.measured[s][row] / sensor.noise - f64::from(left[r][s][row]);
        let white = (0..n)
            .map(|row| {
                let (before, after) = (row.saturating_sub(1), (row + 1).min(n - 1));
                let steep = (seen(after) - seen(before)) / (after - before).max(1) as f64;
                let own = sensor.variance(run.samples.get(row).copied().unwrap_or(1));
                if steep.is_nan() { own } else { own + (INSTANT * steep).powi(2) }
            })
            .collect();
        Signal { sight, since_s, white }
    }

    /// The filter for an error of this kind, and Σ ln of the variances, fitted and kept back.
    fn filter(&self, wander: Wander) -> (Filter, [f64; 2]) {
        let n = self.sight.len();
        let mut filter = Filter {
            sight: Arc::clone(&self.sight),
            decay: Vec::with_capacity(n),
            gain: Vec::with_capacity(n),
            weight: Vec::with_capacity(n),
        };
        let logs = self.run(wander, |decay, gain, weight| {
            filter.decay.push(decay as f32);
            filter.gain.push(gain as f32);
            filter.weight.push(weight as f32);
        });
        (filter, logs)
    }

    /// Runs the filter's own recursion; `each` is given decay, gain and weight of every sample.
    fn run(&self, wander: Wander, mut each: impl FnMut(f64, f64, f64)) -> [f64; 2] {
        let all = wander.size * wander.size;
        let (mut fitted, mut kept) = (all, all);
        let mut logs = [LogOfProduct::default(); 2];
        let (mut since, mut decay) = (f64::NAN, 1.0);
        for ((sight, since_s), white) in self.sight.iter().zip(&self.since_s).zip(&self.white) {
            if *since_s != since {
                (since, decay) = (*since_s, (-*since_s / wander.memory_s).exp());
            }
            let square = decay * decay;
            fitted = square * fitted + all * (1.0 - square);
            kept = square * kept + all * (1.0 - square);
            let (uncertain, log) = match sight {
                Sight::Missing => {
                    each(decay, 0.0, 0.0);
                    continue;
                }
                Sight::Fitted => (&mut fitted, 0),
                Sight::Kept => (&mut kept, 1),
                Sight::FirstKept => {
                    kept = all;
                    (&mut kept, 1)
                }
            };
            let variance = *uncertain + white;
            let gain = *uncertain / variance;
            *uncertain *= 1.0 - gain;
            logs[log].times(variance);
            each(decay, gain, 1.0 / variance.sqrt());
        }
        logs.map(|log| log.value())
    }

    /// Minus twice the logarithm of how probable one part of `left` is, with this error.
    fn deviance(&self, part: Part, wander: Wander, left: &[f32]) -> f64 {
        let (mut expected, mut sum, mut row) = (0.0, 0.0, 0);
        let logs = self.run(wander, |decay, gain, weight| {
            expected *= decay;
            let sight = self.sight[row];
            if part_of(sight) == Some(part) {
                if sight == Sight::FirstKept {
                    expected = 0.0;
                }
                let new = f64::from(left[row]) - expected;
                expected += gain * new;
                sum += (weight * new).powi(2);
            }
            row += 1;
        });
        let log = if part == Part::KeptBack { logs[1] } else { logs[0] };
        sum + log + wander.penalty()
    }

    /// The error that makes one part of `left` most probable, searched from `start` and from where its own spread points, with
    /// its deviance.
    fn most_probable(&self, part: Part, start: Wander, most: f64, left: &[f32]) -> (f64, Wander) {
        let (sum, count) = left
            .iter()
            .zip(self.sight.iter().zip(&self.white))
            .filter(|(_, (sight, _))| part_of(**sight) == Some(part))
            .fold((0.0, 0.0), |(sum, count), (r, (_, white))| (sum + f64::from(*r).powi(2) / white, count + 1.0));
        if count == 0.0 {
            return (0.0, Wander::new(SMALLEST, 1.0));
        }
        let beyond = (sum / count - 1.0).max(0.01).sqrt();
        let row_s = self.since_s.iter().sum::<f64>() / self.since_s.len().max(1) as f64;
        let shortest = MEMORIES_S.0.max(2.0 * row_s);
        let kept_in = |size: f64, memory: f64| {
            let memory_s = memory.exp().clamp(shortest, MEMORIES_S.1);
            Wander { size: size.exp().clamp(SMALLEST, most), memory_s, is_brief: memory_s < BRIEF * shortest }
        };
        let from = |start: Wander| {
            let mut at = kept_in(start.size.ln(), start.memory_s.ln());
            let mut least = self.deviance(part, at, left);
            let mut step = FIRST_STEP;
            while step > LAST_STEP {
                let (size, memory) = (at.size.ln(), at.memory_s.ln());
                let next = [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)]
                    .map(|(by, for_s)| kept_in(size + by, memory + for_s))
                    .into_iter()
                    .filter(|wander| *wander != at)
                    .map(|wander| (self.deviance(part, wander, left), wander))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                match next {
                    Some((deviance, wander)) if deviance < least - 0.01 => (least, at) = (deviance, wander),
                    _ => step *= 0.5,
                }
            }
            (least, at)
        };
        let own = Wander::new(beyond, 0.3);
        let (a, b) = (from(start), from(own));
        if a.0 <= b.0 { a } else { b }
    }
}

/// Σ ln of many factors, with few logarithms.
#[derive(Debug, Clone, Copy)]
struct LogOfProduct {
    sum: f64,
    /// Of the factors since.
    product: f64,
}

impl Default for LogOfProduct {
    fn default() -> Self {
        LogOfProduct { sum: 0.0, product: 1.0 }
    }
}

impl LogOfProduct {
    fn times(&mut self, factor: f64) {
        self.product *= factor;
        if !(1e-100..1e100).contains(&self.product) {
            *self = LogOfProduct { sum: self.value(), product: 1.0 };
        }
    }

    fn value(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

fn part_of(sight: Sight) -> Option<Part> {
    match sight {
        Sight::Missing => None,
        Sight::Fitted => Some(Part::Fitted),
        Sight::Kept | Sight::FirstKept => Some(Part::KeptBack),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    use super::*;

    const WANDER: Wander = Wander::new(3.0, 0.4);

    /// Rows at uneven times, some missing, two blocks of them kept back.
    fn signal() -> (Signal, Vec<f64>) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        let mut time_s = vec![0.0];
        (1..60).for_each(|k| time_s.push(time_s[k - 1] + rng.random_range(0.01..0.05)));
        let sight = (0..60)
            .map(|row| match row {
                _ if row % 11 == 5 => Sight::Missing,
                20 | 40 => Sight::FirstKept,
                21..30 | 41..50 => Sight::Kept,
                _ => Sight::Fitted,
            })
            .collect();
        let since_s = (0..60).map(|row| if row == 0 { 0.0 } else { time_s[row] - time_s[row - 1] }).collect();
        let white = (0..60).map(|row| 1.0 + 0.5 * f64::from(row % 4)).collect();
        (Signal { sight, since_s, white }, time_s)
    }

    /// rᵀ K⁻¹ r and ln |K| of some rows, with the whole matrix.
    fn dense(signal: &Signal, time_s: &[f64], rows: &[usize], left: &[f32]) -> (f64, f64) {
        let n = rows.len();
        let k = DMatrix::from_fn(n, n, |i, j| {
            let apart_s = (time_s[rows[i]] - time_s[rows[j]]).abs();
            let white = if i == j { signal.white[rows[i]] } else { 0.0 };
            white + WANDER.size * WANDER.size * (-apart_s / WANDER.memory_s).exp()
        });
        let r = DVector::from_iterator(n, rows.iter().map(|row| f64::from(left[*row])));
        let factor = k.cholesky().expect("positive");
        let log = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        (r.dot(&factor.solve(&r)), log)
    }

    #[test]
    fn the_filter_whitens_as_the_whole_covariance_does() {
        let (signal, time_s) = signal();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
        let left: Vec<f32> = (0..60)
            .map(
                |row| if signal.sight[row] == Sight::Missing { f32::NAN } else { rng.sample::<f32, _>(StandardNormal) },
            )
            .collect();
        let (filter, [log_fitted, log_kept]) = signal.filter(WANDER);
        let white = filter.whiten(&left);
        let rows = |of: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..60).filter(|row| signal.sight[*row] != Sight::Missing && of(*row)).collect()
        };
        let sum = |rows: &[usize]| rows.iter().map(|row| f64::from(white[*row]).powi(2)).sum::<f64>();
        let is_kept = |row: usize| (20..30).contains(&row) || (40..50).contains(&row);
        let fitted = rows(&|row| !is_kept(row));
        let (square, log) = dense(&signal, &time_s, &fitted, &left);
        assert!((sum(&fitted) - square).abs() < 1e-3 * square && (log_fitted - log).abs() < 1e-9);
        assert!((signal.deviance(Part::Fitted, WANDER, &left) - square - log - WANDER.penalty()).abs() < 1e-6 * square);
        // each block kept back by itself: nothing of it comes from its neighbours
        let blocks = [rows(&|row| (20..30).contains(&row)), rows(&|row| (40..50).contains(&row))];
        let dense: Vec<(f64, f64)> = blocks.iter().map(|block| dense(&signal, &time_s, block, &left)).collect();
        let whole: f64 = dense.iter().map(|(square, log)| square + log).sum();
        assert!((signal.deviance(Part::KeptBack, WANDER, &left) - whole - WANDER.penalty()).abs() < 1e-6 * whole);
        let dense = dense.into_iter();
        let (square, log) = dense.fold((0.0, 0.0), |(s, l), (square, log)| (s + square, l + log));
        assert!((sum(&rows(&is_kept)) - square).abs() < 1e-3 * square && (log_kept - log).abs() < 1e-9);
    }

    #[test]
    fn the_size_and_memory_of_an_error_are_found() {
        let n = 20_000;
        let signal = Signal {
            sight: vec![Sight::Fitted; n].into(),
            since_s: (0..n).map(|row| if row == 0 { 0.0 } else { 0.01 }).collect(),
            white: vec![1.0; n],
        };
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(13);
        let decay = (-0.01 / WANDER.memory_s).exp();
        let mut error = 0.0;
        let left: Vec<f32> = (0..n)
            .map(|_| {
                let [new, noise]: [f64; 2] = std::array::from_fn(|_| rng.sample(StandardNormal));
                error = decay * error + WANDER.size * (1.0 - decay * decay).sqrt() * new;
                (error + noise) as f32
            })
            .collect();
        let (_, found) = signal.most_probable(Part::Fitted, Wander::new(50.0, 5.0), 100.0, &left);
        assert!((found.size / WANDER.size - 1.0).abs() < 0.12, "{found:?}");
        assert!((found.memory_s / WANDER.memory_s - 1.0).abs() < 0.25, "{found:?}");
        // and noise alone is none
        let noise: Vec<f32> = (0..n).map(|_| rng.sample(StandardNormal)).collect();
        let (_, found) = signal.most_probable(Part::Fitted, Wander::new(5.0, 1.0), 100.0, &noise);
        assert!(found.size < 0.1, "{found:?}");
        // nor is a filter's: the mean of two neighbours, of noise that was taken a quarter too small
        let coloured: Vec<f32> =
            noise.windows(2).map(|pair| 1.3 * (pair[0] + pair[1]) / 2f32.sqrt()).chain([0.0]).collect();
        let (_, found) = signal.most_probable(Part::Fitted, Wander::new(5.0, 1.0), 100.0, &coloured);
        assert!(found.is_brief && found.size < 1.0, "{found:?}");
        let (_, found) = signal.most_probable(Part::Fitted, Wander::new(5.0, 1.0), 100.0, &left);
        assert!(!found.is_brief, "{found:?}");
    }
}
