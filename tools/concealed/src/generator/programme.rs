//! Drive programmes: stairs, ramps, full cycles and partial loops in random order, none of which burns the wire.

use rand::RngExt;
use rand::rngs::SmallRng;

use super::truth::Truth;

/// The least duty: without a current there is nothing to measure.
const SENSING_DUTY: f64 = 0.02;

/// Kinds of stretches, and the one of full cycles.
const KINDS: usize = 5;
const FULL_CYCLES: usize = 0;

/// A crude idea of the wire's temperature, for planning only.
struct Planner {
    /// K/s at full duty, 1/s, and K of latent heat spread over the transformation.
    heating: f64,
    cooling: f64,
    latent: f64,
    ambient: f64,
    hot: f64,
    cold: f64,
    temperature: f64,
    dt: f64,
    duty: Vec<f64>,
    rows: usize,
}

impl Planner {
    /// The duty that would hold a temperature.
    fn hold(&self, temperature: f64) -> f64 {
        (self.cooling * (temperature - self.ambient) / self.heating).clamp(SENSING_DUTY, 1.0)
    }

    fn full(&self) -> bool {
        self.duty.len() >= self.rows
    }

    /// One row at a duty, less where the wire would get too hot.
    fn put(&mut self, duty: f64) {
        if self.full() {
            return;
        }
        let too_hot = self.temperature > self.hot + 25.0;
        let duty = if too_hot { duty.min(self.hold(self.hot)) } else { duty };
        let duty = (duty.clamp(SENSING_DUTY, 1.0) * 1e6).round() / 1e6;
        let transforming = self.temperature > self.cold && self.temperature < self.hot;
        let slowed = if transforming { 1.0 + self.latent / (self.hot - self.cold) } else { 1.0 };
        let rate = self.heating * duty - self.cooling * (self.temperature - self.ambient);
        self.temperature += self.dt * rate / slowed;
        self.duty.push(duty);
    }

    fn stay(&mut self, duty: f64, seconds: f64) {
        for _ in 0..(seconds / self.dt).round() as usize {
            self.put(duty);
        }
    }
}

/// Duty by row for `seconds` at `rate_hz`.
pub fn programme(rng: &mut SmallRng, wire: &Truth, rate_hz: f64, seconds: f64) -> Vec<f64> {
    let m = &wire.material;
    let capacity = wire.wire_mass() * m.c_p;
    let ohm = wire.cold_ohm();
    let power = wire.supply * wire.supply * ohm / (ohm + wire.series()).powi(2);
    let cooling = wire.loss_w_per_k() / capacity;
    let tau = 1.0 / cooling;
    let mut plan = Planner {
        heating: power / capacity,
        cooling,
        latent: m.latent / m.c_p,
        ambient: wire.ambient,
        hot: wire.hot(),
        cold: m.m,
        temperature: wire.ambient,
        dt: 1.0 / rate_hz,
        duty: Vec::new(),
        rows: (seconds * rate_hz).round() as usize,
    };
    let (hot, cold) = (plan.hot, plan.cold - 10.0);
    plan.stay(SENSING_DUTY, 0.3);
    // a full cycle is among the first two: what never transforms shows nothing of transformation
    let mut last = usize::MAX;
    let mut place = 0;
    let mut cycled = false;
    while !plan.full() {
        let kind = if place == 1 && !cycled { FULL_CYCLES } else { rng.random_range(0..KINDS) };
        if kind == last {
            continue;
        }
        last = kind;
        place += 1;
        cycled |= kind == FULL_CYCLES;
        match kind {
            FULL_CYCLES => {
                for _ in 0..rng.random_range(1..=2) {
                    let boost = rng.random_range(0.5..=1.0);
                    let mut left = (6.0 * rate_hz) as usize;
                    while plan.temperature < hot + 5.0 && left > 0 && !plan.full() {
                        plan.put(boost);
                        left -= 1;
                    }
                    plan.stay(plan.hold(hot), rng.random_range(0.0..=0.8));
                    plan.stay(SENSING_DUTY, tau * rng.random_range(1.3..=2.6));
                }
            }
            // stairs
            1 => {
                for _ in 0..rng.random_range(3..=5) {
                    let level = rng.random_range(cold - 15.0..=hot + 10.0);
                    plan.stay(plan.hold(level), tau * rng.random_range(0.4..=1.5));
                }
            }
            // a ramp up, a ramp down
            2 => {
                let (low, high) = (plan.hold(cold - 20.0), plan.hold(hot + 10.0));
                let rows = (tau * rng.random_range(1.5..=4.0) * rate_hz) as usize;
                let top = rng.random_range(0.75..=1.0);
                for i in 0..2 * rows {
                    let u = 1.0 - (i as f64 / rows as f64 - 1.0).abs();
                    plan.put(low + (high - low) * top * u);
                }
            }
            // partial loops
            3 => {
                let middle = 0.5 * (hot + cold);
                for _ in 0..rng.random_range(2..=5) {
                    let period = tau * rng.random_range(0.3..=1.0);
                    plan.stay(plan.hold(middle + rng.random_range(8.0..=45.0)), period);
                    plan.stay(plan.hold(middle - rng.random_range(8.0..=60.0)), period);
                }
            }
            // rest
            _ => plan.stay(SENSING_DUTY, tau * rng.random_range(0.7..=2.0)),
        }
    }
    plan.duty
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::generator::bench::{Bench, Kin, Sensor};
    use crate::generator::signals::perfect;
    use crate::generator::wire::STEP_S;

    #[test]
    fn every_programme_transforms_the_wire_and_burns_none() {
        for seed in 0..12 {
            let mut rng = SmallRng::seed_from_u64(seed);
            let bench = Bench::random(&mut rng, Kin::Alike, None, false);
            let duty = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
            assert_eq!(duty.len(), (bench.rate_hz * bench.seconds) as usize);
            assert!(duty.iter().all(|d| (SENSING_DUTY..=1.0).contains(d)));
            let bench = Bench { sensors: [(Sensor::Position, 1.0)].into(), ..bench };
            let truth = bench.believed.clone();
            let position = &perfect(&bench, &truth, &duty, 4.0 * STEP_S)[0];
            let (low, high) =
                position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
            let stroke = truth.material.eps_l * truth.length;
            assert!((0.75..1.3).contains(&((high - low) / stroke)), "seed {seed}: {}", (high - low) / stroke);
        }
    }
}
