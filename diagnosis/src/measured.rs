//! What was measured of a wire's material elsewhere, a calorimeter's curve for one: how it joins a fit of recordings, and whether both
//! say the same.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use sinew_rig::Rig;

use crate::numbers::number;

/// Recordings and what was measured elsewhere contradict each other beyond so many σ of both.
const CONTRADICTS: f64 = 3.0;
/// Recordings that leave more than so many times a parameter's prior hardly tell of it.
const HARDLY: f64 = 3.0;

/// Parameters measured elsewhere, with what they are uncertain by: a normal distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// By what, for people: the file's name.
    pub source: String,
    /// Keys of the rig file.
    pub keys: Vec<String>,
    /// Their values, in the keys' units.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
}

/// A parameter that was measured elsewhere, beside what the recordings alone say of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredParameter {
    /// As measured, in the key's unit.
    pub value: f64,
    /// 1 σ of it.
    pub sigma: f64,
    /// By the recordings alone, its prior taken out of it; nothing where they hardly tell of it.
    pub by_recordings: Option<ByRecordings>,
}

/// What recordings alone say.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ByRecordings {
    /// In the key's unit.
    pub value: f64,
    /// 1 σ of it.
    pub sigma: f64,
    /// How far both are apart, in σ of their difference.
    pub apart_sigma: f64,
}

/// A belief in several parameters.
pub(crate) struct Belief {
    pub(crate) values: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) precision: DMatrix<f64>,
}

impl Measured {
    /// The same of some of the keys only.
    pub(crate) fn of(&self, is_meant: impl Fn(&str) -> bool) -> Measured {
        let places: Vec<usize> = (0..self.keys.len()).filter(|i| is_meant(&self.keys[*i])).collect();
        Measured {
            source: self.source.clone(),
            keys: places.iter().map(|i| self.keys[*i].clone()).collect(),
            values: DVector::from_iterator(places.len(), places.iter().map(|i| self.values[*i])),
            covariance: self.covariance.select_rows(&places).select_columns(&places),
        }
    }

    /// Together with the priors that the rig file itself states; those that hold where it says nothing are no knowledge of this wire.
    /// `None` where there is nothing.
    pub(crate) fn beside_stated(&self, rig: &Rig, channel: usize) -> Option<Belief> {
        if self.keys.is_empty() {
            return None;
        }
        let mut precision = self.covariance.clone().cholesky()?.inverse();
        let mut along = &precision * &self.values;
        for (i, key) in self.keys.iter().enumerate() {
            if let Some((value, sigma)) = stated(rig, channel, key) {
                precision[(i, i)] += 1.0 / (sigma * sigma);
                along[i] += value / (sigma * sigma);
            }
        }
        let covariance = precision.clone().cholesky()?.inverse();
        Some(Belief { values: &covariance * along, covariance, precision })
    }

    /// Each key beside what the recordings say alone, as far as they tell of it.
    pub(crate) fn compared(
        &self,
        rig: &Rig,
        channel: usize,
        recordings: Option<&Measured>,
    ) -> BTreeMap<String, MeasuredParameter> {
        let priors = rig.channels[channel].priors_in_force();
        let one = |key: &String| {
            let (value, sigma) = self.told(key)?;
            let prior = priors.get(key).zip(rig.parameter(channel, key)).map(|(prior, value)| prior.sigma(value));
            let by = recordings.and_then(|recordings| recordings.told(key));
            let is_told = |(_, sigma): &(f64, f64)| prior.is_none_or(|prior| *sigma < HARDLY * prior);
            let by_recordings = by.filter(is_told).map(|(by, of)| {
                let apart_sigma = (by - value).abs() / sigma.hypot(of);
                ByRecordings { value: by, sigma: of, apart_sigma }
            });
            Some((key.clone(), MeasuredParameter { value, sigma, by_recordings }))
        };
        self.keys.iter().filter_map(one).collect()
    }

    /// What it says of a key, and 1 σ.
    fn told(&self, key: &str) -> Option<(f64, f64)> {
        let i = self.keys.iter().position(|k| k == key)?;
        Some((self.values[i], self.covariance[(i, i)].sqrt()))
    }

    /// What it says of the difference of two keys, and 1 σ.
    fn told_between(&self, keys: [&str; 2]) -> Option<(f64, f64)> {
        let [a, b] = keys.map(|key| self.keys.iter().position(|k| k == key));
        let (a, b) = (a?, b?);
        let variance = self.covariance[(a, a)] + self.covariance[(b, b)] - 2.0 * self.covariance[(a, b)];
        Some((self.values[a] - self.values[b], variance.max(0.0).sqrt()))
    }

    /// Says where recordings and what was measured contradict each other.
    pub(crate) fn warn_of_contradictions(
        &self,
        rig: &Rig,
        channel: usize,
        recordings: &Measured,
        warnings: &mut Vec<String>,
    ) {
        self.warn_of_stated(rig, channel, warnings);
        let mut said = |what: String, by: f64, sigma: f64, measured: f64, of: f64, unit: &str| {
            let apart = (by - measured).abs() / sigma.hypot(of);
            if apart > CONTRADICTS {
                warnings.push(format!(
                    "{what}: the recordings alone say {} ± {} {unit}, {} says {} ± {} {unit}: {apart:.1} σ apart. The fit is a compromise \
                     that neither of them supports. A calorimeter's sample is free of stress, and may be annealed or trained otherwise \
                     than the wire: measure a piece of this wire, or fit without its curve",
                    number(by),
                    number(sigma),
                    self.source,
                    number(measured),
                    number(of),
                ));
            }
        };
        for (key, compared) in self.compared(rig, channel, Some(recordings)) {
            if let Some(by) = compared.by_recordings {
                let unit = rig.channels[channel].range_of(&key).map_or("", |(unit, ..)| unit);
                said(key, by.value, by.sigma, compared.value, compared.sigma, unit);
            }
        }
        // a thermometer's error moves both centres, and so does what stress shifts them by; not how far they are apart
        let centres = ["austenite_temperature_c", "martensite_temperature_c"];
        if let (Some((measured, of)), Some((by, sigma))) =
            (self.told_between(centres), recordings.told_between(centres))
        {
            said(format!("{} less {}", centres[0], centres[1]), by, sigma, measured, of, "K");
        }
    }

    /// Says where it contradicts what the rig file states.
    pub(crate) fn warn_of_stated(&self, rig: &Rig, channel: usize, warnings: &mut Vec<String>) {
        for (i, key) in self.keys.iter().enumerate() {
            let Some((value, sigma)) = stated(rig, channel, key) else { continue };
            let of = self.covariance[(i, i)].sqrt();
            let apart = (value - self.values[i]).abs() / sigma.hypot(of);
            if apart > CONTRADICTS {
                warnings.push(format!(
                    "{key}: the rig file states {} ± {}, {} says {} ± {}: {apart:.1} σ apart, and what is fitted lies between; \
                     correct whichever is wrong",
                    number(value),
                    number(sigma),
                    self.source,
                    number(self.values[i]),
                    number(of),
                ));
            }
        }
    }
}

/// What the rig file itself states of a key in its `[channel.priors]`: value and 1 σ.
fn stated(rig: &Rig, channel: usize, key: &str) -> Option<(f64, f64)> {
    let prior = rig.channels[channel].priors.get(key)?;
    let value = rig.parameter(channel, key)?;
    Some((value, prior.sigma(value))).filter(|(_, sigma)| *sigma > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::Prior;

    fn measured() -> Measured {
        Measured {
            source: "dsc.csv".into(),
            keys: vec!["austenite_temperature_c".into(), "martensite_temperature_c".into()],
            values: DVector::from_vec(vec![100.0, 60.0]),
            covariance: DMatrix::from_row_slice(2, 2, &[1.01, 1.0, 1.0, 1.01]),
        }
    }

    #[test]
    fn only_what_the_rig_file_states_stands_beside_it() {
        let mut rig = Rig::hexapod();
        let default = measured().beside_stated(&rig, 0).unwrap();
        assert!(
            (&default.values - measured().values).norm() < 1e-9 && (default.covariance[(0, 0)] - 1.01).abs() < 1e-9
        );
        // as sure as the curve, and 4 K away: half-way, and the other goes along, as the thermometer errs for both
        let a = rig.parameter(0, "austenite_temperature_c").unwrap();
        rig.channels[0].priors.insert("austenite_temperature_c".into(), Prior::Absolute(1.01_f64.sqrt()));
        let stated = measured().beside_stated(&rig, 0).unwrap();
        assert!((stated.values[0] - 0.5 * (100.0 + a)).abs() < 1e-9, "{}", stated.values);
        assert!((stated.values[1] - (60.0 + 0.5 * (a - 100.0) / 1.01)).abs() < 1e-9, "{}", stated.values);
        assert!((stated.covariance[(0, 0)] - 0.505).abs() < 1e-9);
    }

    #[test]
    fn contradictions_are_told_with_their_numbers_and_only_they() {
        let rig = Rig::hexapod();
        let said = |a: f64, m: f64| {
            let mut warnings = Vec::new();
            let recordings = Measured {
                values: DVector::from_vec(vec![a, m]),
                covariance: DMatrix::from_diagonal_element(2, 2, 0.01),
                ..measured()
            };
            measured().warn_of_contradictions(&rig, 0, &recordings, &mut warnings);
            warnings
        };
        assert_eq!(said(102.0, 62.0), Vec::<String>::new());
        let far = said(105.0, 65.0);
        assert!(far.len() == 2 && far[0].contains("105 ± 0.1 °C") && far[0].contains("100 ± 1"), "{far:?}");
        // each within its error, and not so their difference
        let wide = said(101.0, 59.0);
        assert!(wide.len() == 1 && wide[0].contains("less") && wide[0].contains("42"), "{wide:?}");
    }
}
