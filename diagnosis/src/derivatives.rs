//! Derivatives of the residuals along the coordinates of a model, by simulation: with steps large enough for hysteresis,
//! and sharpened along the directions that the data hardly tell apart.

use nalgebra::{DVector, SymmetricEigen};
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::products::gram;
use crate::residuals::{self, Residuals, zip};
use crate::space::{Space, What};

/// How derivatives step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps {
    /// In units of each coordinate's own step.
    length: f64,
    both_sides: bool,
    /// Rounds of [`sharpen`].
    rounds: usize,
}

impl Steps {
    pub(crate) const ONE_SIDED: Steps = Steps { length: 1.0, both_sides: false, rounds: 0 };
    pub(crate) const CENTRAL: Steps = Steps { length: 0.5, both_sides: true, rounds: 0 };
    pub(crate) const SHARP: Steps = Steps { rounds: 2, ..Steps::CENTRAL };
}

/// Derivatives of the residuals along every coordinate; all of one recording's own are known without a simulation.
pub(crate) fn one_sided(data: &Data, space: &Space, z: &[f64], at: &Residuals) -> Option<Vec<Residuals>> {
    by(data, space, z, at, Steps::ONE_SIDED)
}

/// As [`one_sided`], never whitened; `left` are the residuals there, not whitened either.
pub(crate) fn plain(data: &Data, space: &Space, z: &[f64], left: &Residuals) -> Option<Vec<Residuals>> {
    let data = Data { whitening: None, ..data.clone() };
    by(&data, space, z, left, Steps::ONE_SIDED)
}

/// As [`one_sided`], as good as they can be had: where intervals are taken from.
pub(crate) fn sharp(data: &Data, space: &Space, z: &[f64], at: &Residuals) -> Option<Vec<Residuals>> {
    by(data, space, z, at, Steps::SHARP)
}

/// Derivatives as `steps` says.
fn by(data: &Data, space: &Space, z: &[f64], at: &Residuals, steps: Steps) -> Option<Vec<Residuals>> {
    let mut columns = (0..space.len())
        .into_par_iter()
        .map(|i| {
            let coordinate = &space.coordinates[i];
            if let What::Zero(run) = coordinate.what
                && data.position().is_some()
            {
                return Some(of_zero(data, coordinate.scale, run, at));
            }
            let step = steps.length * coordinate.step;
            let go = |step: f64| {
                if !(coordinate.low..=coordinate.high).contains(&(z[i] + step)) {
                    return None;
                }
                let mut moved = z.to_vec();
                moved[i] += step;
                residuals::at(data, space, &moved)
            };
            let above = go(step);
            let below = if steps.both_sides || above.is_none() { go(-step) } else { None };
            match (above, below) {
                (Some(above), Some(below)) => Some(zip(&above, &below, |a, b| (a - b) * (0.5 / step) as f32)),
                (Some(above), None) => Some(zip(&above, at, |a, here| (a - here) * (1.0 / step) as f32)),
                (None, Some(below)) => Some(zip(&below, at, |b, here| (here - b) * (1.0 / step) as f32)),
                (None, None) => None,
            }
        })
        .collect::<Option<Vec<Residuals>>>()?;
    for _ in 0..steps.rounds {
        sharpen(data, space, z, &mut columns);
    }
    Some(columns)
}

/// Directions are sharpened that the data hold this many times less firmly (in curvature) than the firmest.
const SLOPPY: f64 = 1e-3;

/// Length of the steps along them, in their own standard deviations.
const STRIDE: f64 = 0.5;

/// Takes derivatives anew along the directions that the data hardly tell apart. Put together from the coordinates they
/// are what is left of large numbers that cancel, mostly errors: a fit stops short along such a valley, and intervals
/// come out far too narrow, as errors look like knowledge. Along the direction itself a step may be as long as the
/// valley, and from both sides its bend drops out.
fn sharpen(data: &Data, space: &Space, z: &[f64], columns: &mut [Residuals]) {
    if columns.is_empty() {
        return;
    }
    let mut information = gram(data, Part::Fitted, columns);
    for (i, pull) in space.pulls().enumerate() {
        information[(i, i)] += pull;
    }
    let eigen = SymmetricEigen::new(information);
    let firmest = eigen.eigenvalues.max();
    let anew: Vec<(DVector<f64>, Residuals)> = (0..columns.len())
        .into_par_iter()
        .filter(|k| eigen.eigenvalues[*k] < SLOPPY * firmest)
        .filter_map(|k| {
            let along = eigen.eigenvectors.column(k).into_owned();
            let room = space.coordinates.iter().zip(z).zip(along.iter()).map(|((c, z), v)| {
                let room = (c.high - z).min(z - c.low);
                if *v == 0.0 { f64::INFINITY } else { room / v.abs() }
            });
            let step = room.fold(STRIDE / eigen.eigenvalues[k].max(1e-6).sqrt(), f64::min);
            let go = |step: f64| {
                let moved: Vec<f64> = z.iter().zip(along.iter()).map(|(z, v)| z + step * v).collect();
                residuals::at(data, space, &moved)
            };
            if step <= 0.0 {
                return None;
            }
            let (above, below) = (go(step)?, go(-step)?);
            Some((along, zip(&above, &below, |a, b| (a - b) * (0.5 / step) as f32)))
        })
        .collect();
    for (along, derivative) in anew {
        let mut error = derivative;
        for (column, v) in columns.iter().zip(along.iter()) {
            error = zip(&error, column, |e, c| e - *v as f32 * c);
        }
        for (column, v) in columns.iter_mut().zip(along.iter()) {
            *column = zip(column, &error, |c, e| c + *v as f32 * e);
        }
    }
}

/// What the zero of the position in one recording does to the residuals, per `scale`.
pub(crate) fn of_zero(data: &Data, scale: f64, run: usize, at: &Residuals) -> Residuals {
    let position = data.position();
    let column: Residuals = at
        .iter()
        .enumerate()
        .map(|(r, by_sensor)| {
            by_sensor
                .iter()
                .enumerate()
                .map(|(s, values)| {
                    let slope =
                        if r == run && Some(s) == position { (-scale / data.sensors[s].noise) as f32 } else { 0.0 };
                    vec![slope; values.len()]
                })
                .collect()
        })
        .collect();
    data.white(&column)
}
