//! Phase as an ensemble of grains: each is a play between two ramps, and nothing else is remembered.
//!
//! Grain i is martensite by at least m_i(ϑ) and at most a_i(ϑ), both ramps of width δ that fall with ϑ around M_i and A_i;
//! between them it stays as it is: ξ_i ← min(max(ξ_i, m_i(ϑ)), a_i(ϑ)). A sum of such plays is a Preisach operator: return to an
//! extreme wipes out what was inside, and loops between the same extremes are congruent. No closed form of the curves
//! enters: their shape is that of the grains' temperatures.

use rand::RngExt;
use rand::rngs::SmallRng;

/// Grains of a cell.
pub const GRAINS: usize = 40;

/// The grains of a wire, alike in all of its cells: where they transform beside A and M, in units of 1/k.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranks {
    /// On heating, beside A.
    pub heating: Vec<f64>,
    /// On cooling, beside M.
    pub cooling: Vec<f64>,
    /// Width of a grain's own ramp, K.
    pub ramp_k: f64,
}

/// Shares of grains by which a distribution departs from the logistic one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// One long tail.
    Gumbel,
    /// No tails.
    Flat,
    /// A second population, at higher temperatures.
    Shoulder,
}

/// Quantiles of such a distribution, mean 0.
fn quantiles(shape: Shape, departs: f64) -> Vec<f64> {
    let raw: Vec<f64> = (0..GRAINS)
        .map(|i| {
            let p = (i as f64 + 0.5) / GRAINS as f64;
            let logistic = (p / (1.0 - p)).ln();
            let other = match shape {
                Shape::Gumbel => -1.4 * (-p.ln()).ln(),
                Shape::Flat => 6.3 * (p - 0.5),
                Shape::Shoulder => logistic + if p > 0.75 { 4.0 } else { 0.0 },
            };
            (1.0 - departs) * logistic + departs * other
        })
        .collect();
    let mean = raw.iter().sum::<f64>() / GRAINS as f64;
    raw.into_iter().map(|q| q - mean).collect()
}

impl Ranks {
    /// A distribution at random.
    pub fn random(rng: &mut SmallRng) -> Ranks {
        let shapes = [Shape::Gumbel, Shape::Flat, Shape::Shoulder];
        let mut one = || quantiles(shapes[rng.random_range(0..3)], rng.random_range(0.15..=0.6));
        let (heating, sorted) = (one(), one());
        // a grain that is late on heating need not be late on cooling: ranks are shuffled among near ones
        let mut order: Vec<(f64, usize)> = (0..GRAINS).map(|i| (i as f64 + rng.random_range(-8.0..=8.0), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut cooling = vec![0.0; GRAINS];
        for (quantile, (_, grain)) in sorted.into_iter().zip(order) {
            cooling[grain] = quantile;
        }
        Ranks { heating, cooling, ramp_k: rng.random_range(3.0..=5.0) }
    }
}

/// The grains' temperatures on a wire.
#[derive(Debug, Clone)]
pub struct Ensemble {
    upper: Vec<f64>,
    lower: Vec<f64>,
    per_k: f64,
}

impl Ensemble {
    /// Around A and M with steepnesses k_A and k_M, in °C and 1/K.
    pub fn new(ranks: &Ranks, a: f64, m: f64, k_a: f64, k_m: f64) -> Ensemble {
        let upper: Vec<f64> = ranks.heating.iter().map(|q| a + q / k_a).collect();
        // no grain cools through its transformation above where it heats through it
        let lower = ranks.cooling.iter().zip(&upper).map(|(q, upper)| (m + q / k_m).min(upper - 1.0)).collect();
        Ensemble { upper, lower, per_k: 1.0 / ranks.ramp_k }
    }

    fn ramp(&self, centre: f64, theta: f64) -> f64 {
        ((centre - theta) * self.per_k + 0.5).clamp(0.0, 1.0)
    }

    /// Martensite at ϑ after what the grains remember, and its slope, 1/K.
    pub fn at(&self, theta: f64, grains: &[f64]) -> (f64, f64) {
        let (mut sum, mut moving) = (0.0, 0.0);
        for ((upper, lower), was) in self.upper.iter().zip(&self.lower).zip(grains) {
            let (most, least) = (self.ramp(*upper, theta), self.ramp(*lower, theta));
            let is = was.max(least).min(most);
            sum += is;
            let rides = is != *was || *was == most || *was == least;
            moving += if rides && is > 0.0 && is < 1.0 { 1.0 } else { 0.0 };
        }
        let share = 1.0 / grains.len() as f64;
        (sum * share, -moving * share * self.per_k)
    }

    /// Lets the grains follow ϑ.
    pub fn follow(&self, theta: f64, grains: &mut [f64]) {
        for ((upper, lower), grain) in self.upper.iter().zip(&self.lower).zip(grains) {
            *grain = grain.max(self.ramp(*lower, theta)).min(self.ramp(*upper, theta));
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn ensemble(seed: u64) -> Ensemble {
        let ranks = Ranks::random(&mut SmallRng::seed_from_u64(seed));
        Ensemble::new(&ranks, 93.0, 67.0, 0.31, 0.31)
    }

    fn through(e: &Ensemble, grains: &mut [f64], thetas: &[f64]) -> f64 {
        thetas.iter().for_each(|t| e.follow(*t, grains));
        e.at(*thetas.last().expect("a temperature"), grains).0
    }

    #[test]
    fn a_return_to_an_extreme_wipes_out_what_was_inside() {
        for seed in 0..20 {
            let e = ensemble(seed);
            let (mut plain, mut looped) = (vec![1.0; GRAINS], vec![1.0; GRAINS]);
            through(&e, &mut plain, &[20.0, 95.0]);
            through(&e, &mut looped, &[20.0, 95.0, 70.0, 88.0, 75.0, 95.0]);
            assert_eq!(plain, looped, "seed {seed}");
            assert!(plain.iter().any(|g| *g > 0.0 && *g < 1.0) || plain.contains(&0.0));
        }
    }

    #[test]
    fn loops_between_the_same_extremes_are_congruent() {
        for seed in 0..20 {
            let e = ensemble(seed);
            // one comes from the cold, one from the hot side
            let (mut below, mut above) = (vec![1.0; GRAINS], vec![0.0; GRAINS]);
            through(&e, &mut below, &[20.0, 90.0, 72.0, 90.0]);
            through(&e, &mut above, &[150.0, 72.0, 90.0]);
            let mut heights = Vec::new();
            for theta in [84.0, 78.0, 72.0, 80.0, 90.0] {
                let pair = [&mut below, &mut above].map(|g| {
                    let before = e.at(90.0, g).0;
                    through(&e, g, &[theta]) - before
                });
                heights.push(pair[0]);
                // grown by as much wherever the loop is
                let level = through(&e, &mut below.clone(), &[theta]) - through(&e, &mut above.clone(), &[theta]);
                heights.push(level);
            }
            let levels: Vec<f64> = heights.iter().skip(1).step_by(2).copied().collect();
            for level in &levels {
                assert!((level - levels[0]).abs() < 1e-12, "seed {seed}: {levels:?}");
            }
        }
    }

    #[test]
    fn the_slope_is_that_of_the_ensemble_and_never_rises() {
        let e = ensemble(3);
        let mut grains = vec![1.0; GRAINS];
        for i in 0..400 {
            let theta = 60.0 + 50.0 * (i as f64 * 0.05).sin();
            let (xi, slope) = e.at(theta, &grains);
            assert!((0.0..=1.0).contains(&xi) && slope <= 0.0);
            e.follow(theta, &mut grains);
            let (same, _) = e.at(theta, &grains);
            assert!((xi - same).abs() < 1e-12);
        }
    }
}
