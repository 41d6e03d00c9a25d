//! What sensors make of what is there: noise, colour, steps of a converter, missing samples.

use std::collections::BTreeMap;

use rand::RngExt;
use rand::rngs::SmallRng;
use rand_distr::StandardNormal;

use super::bench::{Bench, Sensor};
use super::truth::Truth;
use super::wire::{STEP_S, Seen, Wire};

/// How the sensors err.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Errors {
    /// White noise.
    White,
    /// Noise of lag-one correlation ρ.
    Coloured(f64),
    /// A converter's step, in units of the white noise before it.
    Quantised(f64),
    /// White noise, and this share of the samples missing, some of them in a row.
    Missing(f64),
}

/// One recording as a table: columns by name, NaN = missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Names and values.
    pub columns: Vec<(&'static str, Vec<f64>)>,
}

impl Table {
    /// A column to change.
    pub fn column(&mut self, name: &str) -> Option<&mut Vec<f64>> {
        self.columns.iter_mut().find(|(n, _)| *n == name).map(|(_, values)| values)
    }
}

/// A value of one sensor.
pub fn value(seen: &Seen, sensor: Sensor) -> f64 {
    match sensor {
        Sensor::Current => seen.current,
        Sensor::V1 => seen.volts[0],
        Sensor::V2 => seen.volts[1],
        Sensor::V3 => seen.volts[2],
        Sensor::Force => seen.force,
        Sensor::Position => seen.position,
    }
}

/// What perfect sensors would show, by sensor then row, at steps of `step_s`.
pub fn perfect(bench: &Bench, truth: &Truth, duty: &[f64], step_s: f64) -> Vec<Vec<f64>> {
    let mut wire = Wire::new(truth);
    let mut out: Vec<Vec<f64>> = bench.sensors.iter().map(|_| Vec::with_capacity(duty.len())).collect();
    for duty in duty {
        let seen = wire.row(1.0 / bench.rate_hz, *duty, truth.supply, step_s);
        for (column, sensor) in out.iter_mut().zip(bench.sensors.keys()) {
            column.push(value(&seen, *sensor));
        }
    }
    out
}

/// Squares of what was put on each sensor, and of how many samples: with the steps of a converter larger than the noise,
/// what that comes to depends on where the signal rests.
pub type Put = BTreeMap<Sensor, (f64, f64)>;

/// A recording of a wire under a programme.
pub fn record(rng: &mut SmallRng, bench: &Bench, truth: &Truth, duty: &[f64], errors: Errors, put: &mut Put) -> Table {
    let clean = perfect(bench, truth, duty, STEP_S);
    let rows = duty.len();
    let time_s = (0..rows).map(|i| i as f64 / bench.rate_hz).collect();
    let mut columns = vec![("duty", duty.to_vec())];
    if let Some(noise) = bench.supply_noise {
        let supply = (0..rows).map(|_| rounded(truth.supply + noise * normal(rng), noise)).collect();
        columns.push(("supply_v", supply));
    }
    for ((sensor, noise), clean) in bench.sensors.iter().zip(clean) {
        let mut coloured: f64 = normal(rng);
        let mut values: Vec<f64> = clean
            .iter()
            .map(|clean| match errors {
                Errors::White | Errors::Missing(_) => rounded(clean + noise * normal(rng), *noise),
                Errors::Coloured(rho) => {
                    coloured = rho * coloured + (1.0 - rho * rho).sqrt() * normal(rng);
                    rounded(clean + noise * coloured, *noise)
                }
                Errors::Quantised(step) => {
                    let step = step * noise;
                    step * ((clean + noise * normal(rng)) / step).round()
                }
            })
            .collect();
        let sum = put.entry(*sensor).or_default();
        sum.0 += values.iter().zip(&clean).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        sum.1 += rows as f64;
        if let Errors::Missing(share) = errors {
            let burst = (rows as f64 * 0.5 * share) as usize;
            let from = rng.random_range(0..rows - burst);
            for (i, value) in values.iter_mut().enumerate() {
                if (from..from + burst).contains(&i) || rng.random_bool(0.5 * share) {
                    *value = f64::NAN;
                }
            }
        }
        columns.push((sensor.column(), values));
    }
    Table { time_s, columns }
}

fn normal(rng: &mut SmallRng) -> f64 {
    rng.sample(StandardNormal)
}

/// To a decimal digit well below the noise.
fn rounded(value: f64, noise: f64) -> f64 {
    let scale = 10f64.powi((1.5 - noise.log10()).ceil() as i32);
    (value * scale).round() / scale
}
