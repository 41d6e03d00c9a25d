//! Derivatives of the residuals along the coordinates of a model, by simulation where they are not known: with steps large enough
//! for hysteresis, and sharpened along the directions that the data hardly tell apart.

use std::ops::Range;

use nalgebra::{DVector, SymmetricEigen};
use rayon::prelude::*;
use sinew_recording::Column;

use crate::data::{Data, Part};
use crate::products::gram;
use crate::residuals::{self, Residuals, zip};
use crate::space::{self, Space, What};

/// How derivatives step, in units of each coordinate's own step.
#[derive(Debug, Clone, Copy)]
struct Steps {
    length: f64,
    both_sides: bool,
}

const ONE_SIDED: Steps = Steps { length: 1.0, both_sides: false };
const CENTRAL: Steps = Steps { length: 0.5, both_sides: true };

/// How often derivatives are sharpened where intervals are taken from them.
const ROUNDS: usize = 2;

/// Derivatives of what is fitted along every coordinate, whitened.
pub(crate) fn one_sided(data: &Data, space: &Space, z: &[f64]) -> Option<Vec<Residuals>> {
    let left = residuals::fitted_at(data, space, z)?;
    Some(white(data, &by(data, space, z, &left, 0..space.len(), ONE_SIDED)?))
}

/// The same, never whitened, along some coordinates; `left` are the residuals there, not whitened either.
pub(crate) fn plain(
    data: &Data,
    space: &Space,
    z: &[f64],
    left: &Residuals,
    along: Range<usize>,
) -> Option<Vec<Residuals>> {
    by(data, space, z, left, along, ONE_SIDED)
}

/// As [`one_sided`], as good as they can be had: where intervals are taken from.
pub(crate) fn sharp(data: &Data, space: &Space, z: &[f64]) -> Option<Vec<Residuals>> {
    let left = residuals::fitted_at(data, space, z)?;
    let mut columns = white(data, &by(data, space, z, &left, 0..space.len(), CENTRAL)?);
    for _ in 0..ROUNDS {
        sharpen(data, space, z, &mut columns);
    }
    Some(columns)
}

/// As the data whiten them.
pub(crate) fn white(data: &Data, columns: &[Residuals]) -> Vec<Residuals> {
    columns.par_iter().map(|column| data.white(column)).collect()
}

/// Derivatives as `steps` says; what acts on the sensors alone is known without a simulation.
fn by(
    data: &Data,
    space: &Space,
    z: &[f64],
    left: &Residuals,
    along: Range<usize>,
    steps: Steps,
) -> Option<Vec<Residuals>> {
    along
        .into_par_iter()
        .map(|i| {
            let coordinate = &space.coordinates[i];
            if let Some(known) = of_sensor(data, space, z, i, left) {
                return Some(known);
            }
            let step = steps.length * coordinate.step;
            let go = |step: f64| {
                if !(coordinate.low..=coordinate.high).contains(&(z[i] + step)) {
                    return None;
                }
                let mut moved = z.to_vec();
                moved[i] += step;
                residuals::fitted_at(data, space, &moved)
            };
            let above = go(step);
            let below = if steps.both_sides || above.is_none() { go(-step) } else { None };
            match (above, below) {
                (Some(above), Some(below)) => Some(zip(&above, &below, |a, b| (a - b) * (0.5 / step) as f32)),
                (Some(above), None) => Some(zip(&above, left, |a, here| (a - here) * (1.0 / step) as f32)),
                (None, Some(below)) => Some(zip(&below, left, |b, here| (here - b) * (1.0 / step) as f32)),
                (None, None) => None,
            }
        })
        .collect()
}

/// The derivative along a coordinate that acts on what a sensor shows and on nothing else: its zero, its offset, its gain.
fn of_sensor(data: &Data, space: &Space, z: &[f64], i: usize, left: &Residuals) -> Option<Residuals> {
    let coordinate = &space.coordinates[i];
    let slope = coordinate.slope(z[i]);
    match &coordinate.what {
        What::Zero(run) if data.position().is_some() => Some(of_zero(data, slope, *run, left)),
        What::Key(key) => {
            let (column, acts) = amplifier(key)?;
            let sensor = data.sensors.iter().position(|sensor| sensor.column == column)?;
            let noise = data.sensors[sensor].noise;
            // shown = gain seen + offset, of which a residual is what was measured less the run's own gain times this
            let offset = space.value(&format!("sensing.offset.{}", column.name()), z)?;
            let value = coordinate.value(z[i]);
            let mut derivative = nothing(left);
            for (r, run) in data.runs.iter().enumerate() {
                let (zero, gain) = if data.position() == Some(sensor) { space.position_of(r, z) } else { (0.0, 1.0) };
                let rows = derivative[r][sensor].iter_mut().zip(&left[r][sensor]).zip(&run.measured[sensor]);
                for ((derivative, left), measured) in rows {
                    *derivative = match acts {
                        Acts::Adds => (-slope * gain / noise) as f32,
                        Acts::Multiplies => {
                            let shown = (measured - zero - f64::from(*left) * noise) / gain;
                            (-slope * gain * (shown - offset) / value / noise) as f32
                        }
                    };
                }
            }
            Some(derivative)
        }
        _ => None,
    }
}

/// What an amplifier's key does to what its sensor shows.
#[derive(Debug, Clone, Copy)]
enum Acts {
    Adds,
    Multiplies,
}

/// The sensor behind `sensing.offset.KEY` or `sensing.gain.KEY`.
fn amplifier(key: &str) -> Option<(Column, Acts)> {
    if let Some(of) = key.strip_prefix("sensing.offset.") {
        return space::amplified(of).map(|column| (column, Acts::Adds));
    }
    let of = key.strip_prefix("sensing.gain.")?;
    space::amplified(of).map(|column| (column, Acts::Multiplies))
}

/// No derivative anywhere.
fn nothing(left: &Residuals) -> Residuals {
    left.iter().map(|by_sensor| by_sensor.iter().map(|values| vec![0.0; values.len()]).collect()).collect()
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
    space.add_pulls(&mut information);
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
pub(crate) fn of_zero(data: &Data, scale: f64, run: usize, left: &Residuals) -> Residuals {
    let mut derivative = nothing(left);
    if let Some(position) = data.position() {
        derivative[run][position].fill((-scale / data.sensors[position].noise) as f32);
    }
    derivative
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Prepared;
    use crate::testing::{recording, rig};

    #[test]
    fn what_acts_on_a_sensor_alone_is_known_as_a_simulation_would_say() {
        let rig = rig();
        let model = &rig.channels[0].model;
        let stairs = |t: f64| [0.05, 0.3, 0.02, 0.35, 0.1][(t / 4.0) as usize % 5];
        let data = Prepared::new(&rig, 0, &[recording(model, stairs, 3)], &[], 1).unwrap().data;
        let space = Space::reference(&rig, 0, &data);
        let z: Vec<f64> = (0..space.len()).map(|i| 0.3 * (i as f64).sin()).collect();
        let left = residuals::fitted_at(&data, &space, &z).unwrap();
        let mut known = 0;
        for i in 0..space.len() {
            let Some(direct) = of_sensor(&data, &space, &z, i, &left) else { continue };
            known += 1;
            let there = |step: f64| {
                let mut moved = z.clone();
                moved[i] += step;
                residuals::fitted_at(&data, &space, &moved).unwrap()
            };
            let stepped = zip(&there(0.5), &there(-0.5), |above, below| above - below);
            let flat = |of: &Residuals| of.iter().flatten().flatten().copied().collect::<Vec<f32>>();
            let most = flat(&direct).iter().fold(0.0f32, |most, d| most.max(d.abs()));
            for (direct, stepped) in flat(&direct).iter().zip(flat(&stepped)) {
                let name = &space.coordinates[i].what;
                assert!((direct - stepped).abs() <= 2e-3 * most, "{name:?}: {direct} and {stepped}");
            }
        }
        assert!(known >= 6, "{known} of {}", space.len());
    }
}
