//! Slow quantities measured with noise: the level beneath a column such as the supply voltage.
//!
//! A measured supply drives the simulation row by row, so its sensor's noise would appear in every simulated voltage. The
//! quantity itself stands nearly still, and what it does can be distinguished from the noise by the column alone. Local level:
//!
//! y_t = x_t + e_t, var e = r; x_{t+1} = x_t + w_t, var w = q Δt (Δt in typical intervals).
//!
//! The differences of the column fix q + 2r (their variance); how it splits is what foretells each sample best from those
//! before it (maximum likelihood: far sharper than the differences' covariance −r, whose error alone would hide any q
//! below r/√n). Then one filter runs forward and one backward, and the level is their mean, weighted by how sure each is.
//! A column that really moves (q ≫ r) comes out as it went in.
//!
//! Nothing is smoothed across a jump: where the two sides of a place disagree by more than [`JUMP_SIGMA`], each side
//! keeps its own level, so a dip of the supply stays as sharp as it was recorded.

use std::borrow::Cow;

/// Fewer samples than this tell no noise from motion.
const LEAST_SAMPLES: usize = 20;
/// Two sides that differ by more than so many standard deviations are two levels.
const JUMP_SIGMA: f64 = 6.0;
/// One surprise counts no more than that of so many standard deviations: jumps do not decide how noisy a column is.
const SURPRISE_SIGMA: f64 = 3.0;
/// Share of the differences that may be jumps; the size of noise is read at this quantile of the others …
const QUANTILE: f64 = 0.9;
/// … which is so many standard deviations of a normal distribution.
const QUANTILE_SIGMA: f64 = 1.644_853_6;
/// Weights of the newest sample (gains of the filter) that are tried. The least keeps a memory of 200 samples to each side,
/// which takes 96 % of the noise away and still follows what changes within seconds.
const GAINS: [f64; 14] = [0.005, 0.0075, 0.011, 0.017, 0.025, 0.04, 0.06, 0.09, 0.14, 0.2, 0.3, 0.45, 0.65, 0.85];
/// The split is found from at most so many samples, from the middle of the column.
const MOST_FITTED: usize = 20_000;
/// Jumps are looked for again on the pieces they leave, so often at most.
const ROUNDS: usize = 16;

/// The level beneath `values`, whose samples are taken at `time_s`; NaN = missing, and stays so.
/// `values` themselves where nothing can be estimated or there is nothing to smooth.
///
/// `time_s` increases and has as many samples.
pub(crate) fn level<'a>(time_s: &[f64], values: &'a [f64]) -> Cow<'a, [f64]> {
    let present: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_finite()).collect();
    if present.len() < LEAST_SAMPLES {
        return Cow::Borrowed(values);
    }
    let samples = Samples::new(time_s, values, &present);
    let Some(noise) = samples.noise() else { return Cow::Borrowed(values) };
    let smooth = samples.level(&noise);
    let mut level = values.to_vec();
    for (&place, smooth) in present.iter().zip(smooth) {
        level[place] = smooth;
    }
    Cow::Owned(level)
}

/// How much of a column is noise.
#[derive(Debug, Clone, Copy)]
struct Noise {
    /// r, in the column's unit squared.
    variance: f64,
    /// q/r per typical interval.
    ratio: f64,
}

/// The samples that are there.
struct Samples {
    /// y.
    values: Vec<f64>,
    /// Time from the sample before, in typical intervals; nothing for the first.
    gaps: Vec<f64>,
    /// Where a new level begins: nothing is carried over from the sample before.
    fresh: Vec<bool>,
}

/// What is known of the level at a sample from one side of it.
#[derive(Debug, Clone, Copy)]
struct Belief {
    level: f64,
    /// In units of r; infinite where that side says nothing.
    variance: f64,
}

const NOTHING: Belief = Belief { level: 0.0, variance: f64::INFINITY };

impl Belief {
    /// With the sample `y` taken in too.
    fn after(self, y: f64) -> Belief {
        if self.variance.is_infinite() {
            return Belief { level: y, variance: 1.0 };
        }
        let gain = self.variance / (self.variance + 1.0);
        Belief { level: self.level + gain * (y - self.level), variance: gain }
    }

    /// After the level has walked for a while.
    fn later(self, ratio: f64, gap: f64) -> Belief {
        Belief { variance: self.variance + ratio * gap, ..self }
    }
}

impl Samples {
    fn new(time_s: &[f64], values: &[f64], present: &[usize]) -> Samples {
        let between: Vec<f64> = present.windows(2).map(|w| time_s[w[1]] - time_s[w[0]]).collect();
        let typical = quantile(between.clone(), 0.5);
        let gaps = std::iter::once(0.0).chain(between.iter().map(|s| s / typical)).collect();
        let mut fresh = vec![false; present.len()];
        fresh[0] = true;
        Samples { values: present.iter().map(|&i| values[i]).collect(), gaps, fresh }
    }

    /// Splits the size of the differences into noise and motion; `None` where the column hardly ever changes (a constant,
    /// or coarse steps) or is nearly all motion, and is best taken as it is.
    fn noise(&self) -> Option<Noise> {
        let n = self.values.len();
        let start = n.saturating_sub(MOST_FITTED) / 2;
        let fitted = start..n.min(start + MOST_FITTED);
        let differences = self.values[fitted.clone()].windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        let step = (quantile(differences, QUANTILE) / QUANTILE_SIGMA).powi(2);
        if !(step > 0.0 && step.is_finite()) {
            return None;
        }
        let tried = GAINS.map(|gain| {
            let ratio = gain * gain / (1.0 - gain);
            Noise { variance: step / (2.0 + ratio), ratio }
        });
        let surprises = tried.map(|noise| self.surprise(fitted.clone(), &noise));
        let best = (0..tried.len()).min_by(|&a, &b| surprises[a].total_cmp(&surprises[b]))?;
        (best + 1 < tried.len()).then_some(tried[best])
    }

    /// −2 ln likelihood of samples, each foretold from those before it, up to a constant.
    fn surprise(&self, range: std::ops::Range<usize>, noise: &Noise) -> f64 {
        let mut belief = NOTHING;
        let mut sum = 0.0;
        for i in range {
            let y = self.values[i];
            if belief.variance.is_finite() {
                belief = belief.later(noise.ratio, self.gaps[i]);
                let variance = noise.variance * (belief.variance + 1.0);
                let squares = (y - belief.level).powi(2) / variance;
                sum += variance.ln() + squares.min(SURPRISE_SIGMA * SURPRISE_SIGMA);
                if squares > JUMP_SIGMA * JUMP_SIGMA {
                    belief = NOTHING;
                }
            }
            belief = belief.after(y);
        }
        sum
    }

    /// The level at every sample.
    fn level(mut self, noise: &Noise) -> Vec<f64> {
        let n = self.values.len();
        let mut before = vec![NOTHING; n];
        let mut from_here = vec![NOTHING; n];
        for _ in 0..ROUNDS {
            self.look(noise, &mut before, &mut from_here);
            if !self.part(noise, &before, &from_here) {
                break;
            }
        }
        self.look(noise, &mut before, &mut from_here);
        let mean = |(past, future): (&Belief, &Belief)| {
            let weight = future.variance / (past.variance + future.variance);
            future.level + if past.variance.is_finite() { weight * (past.level - future.level) } else { 0.0 }
        };
        before.iter().zip(&from_here).map(mean).collect()
    }

    /// What is known of each sample's level from those before it, and from it and those after it.
    fn look(&self, noise: &Noise, before: &mut [Belief], from_here: &mut [Belief]) {
        let samples = || self.values.iter().zip(&self.gaps).zip(&self.fresh);
        let mut belief = NOTHING;
        for (((y, gap), fresh), before) in samples().zip(before) {
            belief = if *fresh { NOTHING } else { belief.later(noise.ratio, *gap) };
            *before = belief;
            belief = belief.after(*y);
        }
        belief = NOTHING;
        for (((y, gap), fresh), from_here) in samples().zip(from_here).rev() {
            belief = belief.after(*y);
            *from_here = belief;
            belief = if *fresh { NOTHING } else { belief.later(noise.ratio, *gap) };
        }
    }

    /// Begins a new level wherever the two sides disagree most and by too much; whether any was begun.
    fn part(&mut self, noise: &Noise, before: &[Belief], from_here: &[Belief]) -> bool {
        let limit = noise.variance * JUMP_SIGMA * JUMP_SIGMA;
        let mut any = false;
        let mut worst: Option<(usize, f64)> = None;
        for i in 0..=self.values.len() {
            let apart = match (before.get(i), from_here.get(i)) {
                (Some(past), Some(future)) if past.variance.is_finite() => {
                    (past.level - future.level).powi(2) / (past.variance + future.variance)
                }
                _ => 0.0,
            };
            if apart > limit {
                if worst.is_none_or(|(_, most)| apart > most) {
                    worst = Some((i, apart));
                }
            } else if let Some((place, _)) = worst.take() {
                self.fresh[place] = true;
                any = true;
            }
        }
        any
    }
}

/// The value below which this share of `values` lies; they are not empty.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    let place = ((values.len() - 1) as f64 * share) as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of standard deviation 1, the same every time.
    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64 + 0.5) / (1u64 << 31) as f64
        };
        (0..n).map(|_| (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()).collect()
    }

    fn times(n: usize) -> Vec<f64> {
        (0..n).map(|i| i as f64 * 0.005).collect()
    }

    fn rms(a: &[f64], b: &[f64]) -> f64 {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    }

    /// A truth with 3 mV of noise: what is left of the noise, as a share.
    fn left(truth: &[f64], seed: u64) -> f64 {
        let measured: Vec<f64> = truth.iter().zip(noise(truth.len(), seed)).map(|(x, e)| x + 0.003 * e).collect();
        rms(&level(&times(truth.len()), &measured), truth) / 0.003
    }

    #[test]
    fn a_constant_loses_nearly_all_its_noise() {
        for seed in 1..6 {
            let left = left(&[6.0; 18_000], seed);
            assert!(left < 0.06, "{left}");
        }
    }

    #[test]
    fn a_ramp_and_a_ripple_stay() {
        let ramp: Vec<f64> = (0..18_000).map(|i| 6.0 - i as f64 * 5e-5).collect();
        let remains = left(&ramp, 1);
        assert!(remains < 0.25, "{remains}");
        let ripple: Vec<f64> = times(18_000).iter().map(|t| 6.0 + 0.05 * (std::f64::consts::TAU * t).sin()).collect();
        let remains = left(&ripple, 2);
        assert!(remains < 0.6, "{remains}");
        // moving in one half and still in the other
        let half: Vec<f64> = (0..18_000).map(|i| 6.0 - (i as f64 - 9000.0).max(0.0) * 5e-5).collect();
        let remains = left(&half, 3);
        assert!(remains < 0.35, "{remains}");
    }

    #[test]
    fn dips_keep_their_edges() {
        let mut dip = vec![6.0; 6000];
        dip[2000..2100].fill(5.5);
        dip[3000] = 5.0;
        dip[4000..].fill(5.97);
        let measured: Vec<f64> = dip.iter().zip(noise(6000, 4)).map(|(x, e)| x + 0.003 * e).collect();
        let smooth = level(&times(6000), &measured);
        assert!(rms(&smooth, &dip) < 0.0004, "{}", rms(&smooth, &dip));
        for edge in [1999, 2000, 2099, 2100, 2999, 3001, 3999, 4000] {
            assert!((smooth[edge] - dip[edge]).abs() < 0.002, "{edge}: {}", smooth[edge]);
        }
        assert_eq!(smooth[3000], measured[3000], "alone on its level");
    }

    /// A step no single sample gives away: 2 σ.
    #[test]
    fn a_small_step_stays_sharp() {
        let mut step = vec![6.0; 4000];
        step[2000..].fill(6.006);
        let measured: Vec<f64> = step.iter().zip(noise(4000, 5)).map(|(x, e)| x + 0.003 * e).collect();
        let smooth = level(&times(4000), &measured);
        assert!((smooth[1980] - 6.0).abs() < 0.001 && (smooth[2020] - 6.006).abs() < 0.001);
    }

    #[test]
    fn what_really_moves_comes_out_as_it_went_in() {
        let mut at = 6.0;
        let walk: Vec<f64> = noise(2000, 6)
            .iter()
            .map(|e| {
                at += 0.01 * e;
                at
            })
            .collect();
        assert!(matches!(level(&times(2000), &walk), Cow::Borrowed(_)));
        // with a little noise the little is all that may change
        let measured: Vec<f64> = walk.iter().zip(noise(2000, 7)).map(|(x, e)| x + 0.003 * e).collect();
        assert!(rms(&level(&times(2000), &measured), &walk) < 0.0031);
        let still = [5.0; 100];
        assert_eq!(&*level(&times(100), &still), &still);
        let coarse: Vec<f64> = (0..200).map(|i| 20.0 + 0.5 * f64::from(i / 50)).collect();
        assert_eq!(&*level(&times(200), &coarse), &coarse[..]);
    }

    #[test]
    fn holes_stay_holes_and_gaps_loosen_the_ties() {
        let mut measured: Vec<f64> = noise(500, 8).iter().map(|e| 6.0 + 0.003 * e).collect();
        for hole in [0, 7, 8, 9, 499] {
            measured[hole] = f64::NAN;
        }
        let smooth = level(&times(500), &measured);
        for (i, (raw, smooth)) in measured.iter().zip(&*smooth).enumerate() {
            assert_eq!(raw.is_nan(), smooth.is_nan(), "{i}");
            assert!(raw.is_nan() || (smooth - 6.0).abs() < 0.001, "{i}: {smooth}");
        }
        assert!(matches!(level(&times(10), &measured[..10]), Cow::Borrowed(_)), "too few to tell");
        assert!(matches!(level(&times(50), &[f64::NAN; 50]), Cow::Borrowed(_)));

        // half an hour's pause: what was before says little of what is after
        let mut time = times(600);
        time[300..].iter_mut().for_each(|t| *t += 1800.0);
        let walked: Vec<f64> =
            noise(600, 9).iter().enumerate().map(|(i, e)| f64::from(i >= 300) * 0.004 + 6.0 + 0.003 * e).collect();
        let smooth = level(&time, &walked);
        assert!((smooth[299] - 6.0).abs() < 0.001 && (smooth[300] - 6.004).abs() < 0.001);
    }
}
