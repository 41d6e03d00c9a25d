//! What calorimeters say together, for a fit of recordings.

use nalgebra::{DMatrix, DVector};
use sinew_diagnosis::Measured;

use crate::calorimeter::Fitted;

/// Error of a calorimeter's thermometer, 1 σ, K: the same on heating and on cooling, so that the width of a hysteresis is known better.
pub const THERMOMETER_K: f64 = 1.0;
/// And what heating and cooling differ by each: it is calibrated on heating, at one rate.
pub const DIRECTION_K: f64 = 0.3;
/// Error of its heat, 1 σ, as a share: calibration, mass and base line.
pub const HEAT_ERROR: f64 = 0.03;
/// Error of a steepness, 1 σ, as a share: a sample is not everywhere as hot as its pan, and its peak the wider for it.
pub const STEEPNESS_ERROR: f64 = 0.02;

/// The mean of what curves say of the keys that all of them tell of. Where there are several, how they differ says how sure it is: samples
/// of a wire differ by more than a curve's noise. The errors of the calorimeter are added once.
/// `None` without curves.
pub fn together(source: &str, curves: &[Fitted]) -> Option<Measured> {
    let first = curves.first()?;
    let keys: Vec<&'static str> =
        first.keys.iter().copied().filter(|key| curves.iter().all(|curve| curve.keys.contains(key))).collect();
    let count = curves.len() as f64;
    let of: Vec<(DVector<f64>, DMatrix<f64>)> = curves.iter().map(|curve| marginal(curve, &keys)).collect();
    let mean = of.iter().map(|(values, _)| values).sum::<DVector<f64>>() / count;
    let mut covariance = of.iter().map(|(_, covariance)| covariance).sum::<DMatrix<f64>>() / (count * count);
    if curves.len() > 1 {
        for (values, _) in &of {
            let off = values - &mean;
            covariance += &off * off.transpose() / (count * (count - 1.0));
        }
    }
    let is_temperature = |key: &str| ["austenite_temperature_c", "martensite_temperature_c"].contains(&key);
    for (i, a) in keys.iter().enumerate() {
        for (j, b) in keys.iter().enumerate() {
            if is_temperature(a) && is_temperature(b) {
                let own = if i == j { DIRECTION_K * DIRECTION_K } else { 0.0 };
                covariance[(i, j)] += THERMOMETER_K * THERMOMETER_K + own;
            } else if i == j {
                let share = if *a == "latent_heat_j_per_kg" { HEAT_ERROR } else { STEEPNESS_ERROR };
                covariance[(i, i)] += (share * mean[i]).powi(2);
            }
        }
    }
    Some(Measured {
        source: source.to_string(),
        keys: keys.iter().map(ToString::to_string).collect(),
        values: mean,
        covariance,
    })
}

/// What a curve says of some of its keys.
fn marginal(curve: &Fitted, keys: &[&str]) -> (DVector<f64>, DMatrix<f64>) {
    let places: Vec<usize> = keys.iter().filter_map(|key| curve.keys.iter().position(|k| k == key)).collect();
    let values = DVector::from_iterator(places.len(), places.iter().map(|i| curve.values[*i]));
    (values, curve.covariance.select_rows(&places).select_columns(&places))
}
