//! A fit of the parameters alone: to recordings, to what was measured elsewhere, or to both.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use sinew_recording::{Column, Recording};
use sinew_rig::{Prior, Rig};

use crate::answer::{FittedParameter, Stages};
use crate::data::Data;
use crate::describe;
use crate::diagnose::{in_pool, is_worth_it};
use crate::error::Error;
use crate::explanation::{Explanation, Turns};
use crate::fit::Fit;
use crate::intervals::{self, Interval, Z90};
use crate::measured::{Measured, MeasuredParameter};
use crate::noise::Noise;
use crate::numbers::digits;
use crate::prepare::{self, Prepared, Searched};
use crate::select;
use crate::settings::Settings;
use crate::space::{Space, What};
use crate::stages::Stage;

/// Recordings say something of a parameter of their own if they narrow its prior by more than this share of its precision.
const OWN_SHARE: f64 = 0.2;
/// Variance of what they hardly tell of, in that of its prior.
const UNTOLD: f64 = 100.0;

/// What a fit of the parameters alone gives.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The rig with the fitted parameters.
    pub rig: Rig,
    /// What was fitted.
    pub parameters: BTreeMap<String, FittedParameter>,
    /// Noise of every sensor, RMS, by column.
    pub noise: BTreeMap<String, f64>,
    /// How well it fits, as given and recalibrated.
    pub fit: Stages,
    /// What was measured elsewhere, by key, beside what the recordings alone say of it.
    pub measured: BTreeMap<String, MeasuredParameter>,
    /// What a reader must know.
    pub warnings: Vec<String>,
}

/// Fits the parameters of one channel within their priors to all of the recordings, and to what was measured of them elsewhere. Where there are no
/// recordings the rig is given what was measured.
///
/// # Errors
/// What is wrong with the rig or the recordings, with the remedy; neither recordings nor anything measured.
pub fn identify(
    rig: &Rig,
    channel: usize,
    recordings: &[Recording],
    measured: Option<&Measured>,
    settings: &Settings<'_>,
) -> Result<Identified, Error> {
    in_pool(settings.jobs, || match measured {
        Some(measured) if recordings.is_empty() => of_measured(measured, rig, channel),
        Some(measured) => {
            // first without it, so that a contradiction shows
            let alone = FittedAlone::to(rig, channel, recordings, None, settings)?;
            let by_recordings = by_recordings(&alone.found.fit, &alone.intervals()?, measured);
            let fitted = FittedAlone::to(rig, channel, recordings, Some(measured), settings)?;
            let mut identified = fitted.identified(rig, channel, settings)?;
            complete(measured, rig, channel, &mut identified)?;
            identified.measured = measured.compared(rig, channel, Some(&by_recordings));
            measured.warn_of_contradictions(rig, channel, &by_recordings, &mut identified.warnings);
            Ok(identified)
        }
        None => FittedAlone::to(rig, channel, recordings, None, settings)?.identified(rig, channel, settings),
    })
}

/// A fit of the parameters alone.
struct FittedAlone {
    data: Data,
    /// The same as they were simulated.
    searched: Data,
    found: Explanation,
    recalibrated: Stage,
    warnings: Vec<String>,
}

impl FittedAlone {
    fn to(
        rig: &Rig,
        channel: usize,
        recordings: &[Recording],
        measured: Option<&Measured>,
        settings: &Settings<'_>,
    ) -> Result<FittedAlone, Error> {
        let fitted_with = |noise: &BTreeMap<Column, Noise>| {
            let prepared = Prepared::quieter(rig, channel, recordings, &[], settings.seed, noise)?;
            let data = prepared.data.all_fitted();
            let reference = Space::reference(rig, channel, &data);
            let space = measured.map_or(reference.clone(), |measured| reference.told(measured));
            (settings.progress)("fitting", 0.1);
            let from = Searched::new(&data, &space, space.drive());
            let [_, found] = Explanation::from_belief(&from.data, &space, &vec![0.0; space.len()], Turns::SOME)
                .ok_or(Error::NoFit)?;
            // what long rows lack where the fit began is not what they lack where it ends
            let (searched, found) = select::settled(&from, &found, Turns::ALL).ok_or(Error::NoFit)?;
            let recalibrated = Stage::of_fit(&data, &found.fit)?;
            let (searched, warnings) = (searched.data, prepared.warnings);
            Ok::<_, Error>(FittedAlone { data, searched, found, recalibrated, warnings })
        };
        (settings.progress)("as given", 0.0);
        let fitted = fitted_with(&BTreeMap::new())?;
        let quieter = prepare::quieter(rig, channel, &fitted.data, &fitted.recalibrated.residuals);
        if !quieter.is_empty() {
            let anew = fitted_with(&quieter)?;
            if is_worth_it(&anew.found, &anew.recalibrated) {
                return Ok(anew);
            }
        }
        Ok(fitted)
    }

    fn intervals(&self) -> Result<Vec<Interval>, Error> {
        intervals::intervals(&self.searched, &self.found, &[]).ok_or_else(Error::lost_fit)
    }

    /// What a user gets of it.
    fn identified(self, rig: &Rig, channel: usize, settings: &Settings<'_>) -> Result<Identified, Error> {
        let given = Stage::as_given(&self.data, &Space::reference(rig, channel, &self.data))?;
        let fit = &self.found.fit;
        let mut warnings = self.warnings.clone();
        describe::warn_of_fit(fit, &mut warnings);
        (settings.progress)("intervals", 0.9);
        let intervals = self.intervals()?;
        let mut fitted_rig = rig.clone();
        fit.space.apply(&fit.z, &mut fitted_rig)?;
        let stages = Stages {
            as_given: given.misfits(&self.data, true),
            recalibrated: self.recalibrated.misfits(&self.data, true),
            improved: BTreeMap::new(),
        };
        (settings.progress)("done", 1.0);
        Ok(Identified {
            rig: fitted_rig,
            parameters: describe::parameters(fit, &intervals),
            noise: describe::noise_by_column(&self.data),
            fit: stages,
            measured: BTreeMap::new(),
            warnings,
        })
    }
}

/// The rig with what was measured, where there are no recordings; what it is uncertain by becomes the rig file's priors.
fn of_measured(measured: &Measured, rig: &Rig, channel: usize) -> Result<Identified, Error> {
    let mut warnings = Vec::new();
    measured.warn_of_stated(rig, channel, &mut warnings);
    let mut identified = Identified {
        rig: rig.clone(),
        parameters: BTreeMap::new(),
        noise: BTreeMap::new(),
        fit: Stages::default(),
        measured: measured.compared(rig, channel, None),
        warnings,
    };
    complete(measured, rig, channel, &mut identified)?;
    for (key, parameter) in &identified.parameters {
        let sigma = digits((parameter.high - parameter.low) / (2.0 * Z90));
        identified.rig.channels[channel].priors.insert(key.clone(), Prior::Absolute(sigma));
    }
    Ok(identified)
}

/// Adds what of it no recording was simulated with, and says of the others what the rig file believed.
fn complete(measured: &Measured, rig: &Rig, channel: usize, identified: &mut Identified) -> Result<(), Error> {
    let priors = rig.channels[channel].priors_in_force();
    let given = |key: &str| {
        let given = rig.parameter(channel, key).unwrap_or(f64::NAN);
        (given, priors.get(key).map_or(f64::NAN, |prior| prior.sigma(given)))
    };
    let rest = measured.of(|key| !identified.parameters.contains_key(key));
    if let Some(belief) = rest.beside_stated(rig, channel) {
        for (i, key) in rest.keys.iter().enumerate() {
            let Some((unit, low, high)) = rig.channels[channel].range_of(key) else { continue };
            let value = digits(belief.values[i].clamp(low, high));
            let reach = Z90 * belief.covariance[(i, i)].sqrt();
            identified.rig.set_parameter(channel, key, value)?;
            let (low, high) = ((value - reach).max(low), (value + reach).min(high));
            let (given, prior_sigma) = given(key);
            let parameter = FittedParameter { given, value, low, high, unit: unit.to_string(), prior_sigma };
            identified.parameters.insert(key.clone(), parameter);
        }
    }
    for key in &measured.keys {
        if let Some(parameter) = identified.parameters.get_mut(key) {
            (parameter.given, parameter.prior_sigma) = given(key);
        }
    }
    Ok(())
}

/// What recordings say alone of the keys that were measured elsewhere: what is left of the fit by them when its priors are taken out of it.
fn by_recordings(fit: &Fit, intervals: &[Interval], measured: &Measured) -> Measured {
    let coordinates = &fit.space.coordinates;
    let of_key = |key: &String| coordinates.iter().position(|c| matches!(&c.what, What::Key(name) if name == key));
    let (keys, places): (Vec<String>, Vec<usize>) =
        measured.keys.iter().filter_map(|key| Some((key.clone(), of_key(key)?))).unzip();
    let mut values = DVector::from_iterator(places.len(), places.iter().map(|i| intervals[*i].value));
    let mut own = DMatrix::from_diagonal_element(places.len(), places.len(), f64::INFINITY);
    if let Some(factor) = fit.information.clone().cholesky() {
        let all = factor.inverse();
        // in σ of the priors, as wide as the intervals are
        let slopes = DVector::from_iterator(places.len(), places.iter().map(|i| coordinates[*i].slope(fit.z[*i])));
        let wide = |k: usize| {
            let (place, interval) = (places[k], &intervals[places[k]]);
            (interval.high - interval.low).abs() / (2.0 * Z90 * slopes[k].abs() * all[(place, place)].sqrt())
        };
        let block = DMatrix::from_fn(places.len(), places.len(), |i, j| {
            all[(places[i], places[j])] * wide(i).max(1.0) * wide(j).max(1.0)
        });
        if let Some(precision) = block.cholesky().map(|factor| factor.inverse()) {
            let z = DVector::from_iterator(places.len(), places.iter().map(|i| fit.z[*i]));
            let prior = DMatrix::from_diagonal(&DVector::from_iterator(
                places.len(),
                places.iter().map(|i| coordinates[*i].pull),
            ));
            let eigen = SymmetricEigen::new(&precision - prior);
            let along = &precision * &z;
            let mut alone = DVector::zeros(places.len());
            let mut spread = DMatrix::zeros(places.len(), places.len());
            for (k, told) in eigen.eigenvalues.iter().enumerate() {
                let v = eigen.eigenvectors.column(k);
                // of a direction that they hardly tell of they say nothing against anything
                let (at, variance) =
                    if *told > OWN_SHARE { (v.dot(&along) / told, 1.0 / told) } else { (v.dot(&z), UNTOLD) };
                alone += v * at;
                spread += v * v.transpose() * variance;
            }
            values += slopes.component_mul(&(alone - z));
            own = DMatrix::from_fn(places.len(), places.len(), |i, j| spread[(i, j)] * slopes[i] * slopes[j]);
        }
    }
    Measured { source: "the recordings".into(), keys, values, covariance: own }
}
