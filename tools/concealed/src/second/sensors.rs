//! Sensors of the second generator: a converter that averages over the on-phase, a slow part in every amplifier, an
//! encoder with lines.

use rand::RngExt;
use rand::rngs::SmallRng;
use rand_distr::StandardNormal;

use super::super::generator::bench::{Bench, Sensor};
use super::super::generator::signals::{Put, Table};
use super::super::generator::world::World as _;
use super::rod::Shown;
use super::world::World;

/// Step of recordings, s.
pub const STEP_S: f64 = 5e-4;
/// Share of the noise that is slow, and its time, s.
const SLOW: f64 = 0.3;
const SLOW_S: f64 = 0.06;
/// A line of the encoder, in its white noise.
const LINE: f64 = 0.6;
/// Duty at which a converter has the noise of its data sheet: in shorter pulses it averages over fewer samples.
const AVERAGES_AT: f64 = 0.1;

/// A value of one sensor.
pub fn value(shown: &Shown, sensor: Sensor) -> f64 {
    match sensor {
        Sensor::Current => shown.current,
        Sensor::V1 => shown.volts[0],
        Sensor::V2 => shown.volts[1],
        Sensor::V3 => shown.volts[2],
        Sensor::Force => shown.force,
        Sensor::Position => shown.position,
    }
}

/// A recording of a wire under a programme; adds what was put on each sensor to `put`.
pub fn record(rng: &mut SmallRng, bench: &Bench, world: &World, duty: &[f64], put: &mut Put) -> Table {
    let clean = world.perfect(bench, duty, STEP_S);
    let time_s = (0..duty.len()).map(|i| i as f64 / bench.rate_hz).collect();
    let mut columns = vec![("duty", duty.to_vec())];
    if let Some(noise) = bench.supply_noise {
        let measured = duty.iter().map(|_| tidied(world.plain.supply + noise * normal(rng), noise)).collect();
        columns.push(("supply_v", measured));
    }
    let keeps = (-1.0 / (SLOW_S * bench.rate_hz)).exp();
    for ((sensor, noise), clean) in bench.sensors.iter().zip(clean) {
        let electrical = !matches!(sensor, Sensor::Force | Sensor::Position);
        let mut slow: f64 = normal(rng);
        let values: Vec<f64> = clean
            .iter()
            .zip(duty)
            .map(|(clean, duty)| {
                slow = keeps * slow + (1.0 - keeps * keeps).sqrt() * normal(rng);
                let fewer = if electrical { (AVERAGES_AT / duty.max(0.02)).clamp(0.3, 3.0).sqrt() } else { 1.0 };
                let shown = clean + noise * (fewer * normal(rng) + SLOW * slow);
                if *sensor == Sensor::Position {
                    LINE * noise * (shown / (LINE * noise)).round()
                } else {
                    tidied(shown, *noise)
                }
            })
            .collect();
        let sum = put.entry(*sensor).or_default();
        sum.0 += values.iter().zip(&clean).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        sum.1 += clean.len() as f64;
        columns.push((sensor.column(), values));
    }
    Table { time_s, columns }
}

fn normal(rng: &mut SmallRng) -> f64 {
    rng.sample(StandardNormal)
}

/// To a digit well below the noise.
fn tidied(value: f64, noise: f64) -> f64 {
    let unit = 10f64.powi((noise.log10() - 1.5).floor() as i32);
    (value / unit).round() * unit
}
