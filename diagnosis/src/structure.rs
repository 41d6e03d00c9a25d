//! Whether what a model leaves has a structure that noise of sensors has not.

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::fit::Fit;
use crate::forward::SIGNIFICANT;
use crate::residuals::Residuals;
use crate::significance::{Colour, draw_noise};
use crate::simulate::State;

/// Draws of noise for the test of structure.
const DRAWS: u64 = 200;

/// What is left matters from here on: predicted share of the mean square, and correlation between two sensors.
const LEAST_SHARE: f64 = 0.05;

const LEAST_CORRELATION: f64 = 0.3;

/// Whether what is left depends on the wire's state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Structure {
    /// Probability by noise of the same colour.
    pub(crate) p_value: f64,
}

impl Structure {
    /// Whether it is more than noise does, and more than nothing.
    pub(crate) fn is_there(&self) -> bool {
        self.p_value <= SIGNIFICANT
    }
}

/// Two things that noise of sensors does not do, whatever its colour: know the state of the wire (means over cells of
/// the state are learned from what is fitted and tried on what is kept back), and agree between sensors.
pub(crate) fn test(data: &Data, fit: &Fit, residuals: &Residuals, colours: &[Colour], seed: u64) -> Structure {
    let none = Structure { p_value: 1.0 };
    let Some(states) = fit.states(data) else { return none };
    let cells = cells(data, &states);
    let share = |residuals: &Residuals| cells.iter().map(|c| predicted_share(data, residuals, c)).fold(0.0, f64::max);
    let (known, shared) = (share(residuals), correlation(data, residuals));
    let (above_known, above_shared): (Vec<bool>, Vec<bool>) = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(0xbe70 + draw));
            let noise = draw_noise(data, colours, &mut rng);
            (share(&noise) >= known, correlation(data, &noise) >= shared)
        })
        .unzip();
    let p = |above: &[bool]| (above.iter().filter(|a| **a).count() + 1) as f64 / (DRAWS + 1) as f64;
    // what is too small to matter is none, however sure
    let p_known = if known > LEAST_SHARE { p(&above_known) } else { 1.0 };
    let p_shared = if shared > LEAST_CORRELATION { p(&above_shared) } else { 1.0 };
    Structure { p_value: (2.0 * p_known.min(p_shared)).min(1.0) }
}

/// The largest correlation between the residuals of two sensors.
fn correlation(data: &Data, residuals: &Residuals) -> f64 {
    let mut largest = 0.0f64;
    for a in 0..data.sensors.len() {
        for b in 0..a {
            let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
            for by_sensor in residuals {
                for (x, y) in by_sensor[a].iter().zip(&by_sensor[b]) {
                    let (x, y) = (f64::from(*x), f64::from(*y));
                    if !(x * y).is_nan() {
                        ab += x * y;
                        aa += x * x;
                        bb += y * y;
                    }
                }
            }
            if aa > 0.0 && bb > 0.0 {
                largest = largest.max(ab.abs() / (aa * bb).sqrt());
            }
        }
    }
    largest
}

/// The cell of every sample, by run, for several ways to divide the states.
fn cells(data: &Data, states: &[Vec<State>]) -> Vec<Vec<Vec<usize>>> {
    let quantiles = |f: &dyn Fn(&State) -> f64| -> Vec<f64> {
        let mut values: Vec<f64> = states.iter().flatten().map(f).collect();
        values.sort_by(f64::total_cmp);
        (1..12).map(|i| values[(values.len() - 1) * i / 12]).collect()
    };
    let by = |f: &dyn Fn(&State) -> f64| -> Vec<Vec<usize>> {
        let edges = quantiles(f);
        states
            .iter()
            .zip(&data.runs)
            .map(|(states, run)| {
                let middle = 0.5 * run.inputs.iter().fold(f64::NEG_INFINITY, |most, (i, _)| most.max(i.drive));
                states
                    .iter()
                    .zip(&run.inputs)
                    .map(|(s, (inputs, _))| {
                        let place = edges.partition_point(|e| *e < f(s));
                        place * 4 + 2 * usize::from(s.warming_k < 0.0) + usize::from(inputs.drive > middle)
                    })
                    .collect()
            })
            .collect()
    };
    vec![by(&|s| s.temperature_c), by(&|s| s.martensite), by(&|s| s.position_m)]
}

fn predicted_share(data: &Data, residuals: &Residuals, cells: &[Vec<usize>]) -> f64 {
    let (mut before, mut after) = (0.0, 0.0);
    for s in 0..data.sensors.len() {
        let mut sums = vec![(0.0, 0.0); 4 * 13];
        for ((run, by_sensor), cells) in data.runs.iter().zip(residuals).zip(cells) {
            for ((r, part), cell) in by_sensor[s].iter().zip(&run.part).zip(cells) {
                if *part == Part::Fitted && !r.is_nan() {
                    sums[*cell].0 += f64::from(*r);
                    sums[*cell].1 += 1.0;
                }
            }
        }
        for ((run, by_sensor), cells) in data.runs.iter().zip(residuals).zip(cells) {
            for ((r, part), cell) in by_sensor[s].iter().zip(&run.part).zip(cells) {
                if *part == Part::KeptBack && !r.is_nan() {
                    let (sum, count) = sums[*cell];
                    let mean = sum / f64::max(count, 1.0);
                    before += f64::from(*r).powi(2);
                    after += (f64::from(*r) - mean).powi(2);
                }
            }
        }
    }
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}
