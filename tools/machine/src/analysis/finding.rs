//! One result of a run, its uncertainty, and its method or why it cannot be determined.

use serde::Serialize;

/// One number, or the reason why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Its key for programs, such as `austenite_modulus_gpa`.
    pub key: &'static str,
    /// What it is, in words.
    pub name: &'static str,
    /// Of which level, step or frequency; empty where it is of the whole run.
    pub of: String,
    /// The number; `None` where it cannot be determined.
    pub value: Option<f64>,
    /// Its standard uncertainty, 1 σ, in the same unit.
    pub sigma: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// How it was found, or why it cannot be determined.
    pub how: String,
}

impl Finding {
    pub(super) fn new(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        of: &str,
        value: Estimate,
        how: impl Into<String>,
    ) -> Finding {
        if !value.value.is_finite() {
            return Finding::unknown(key, name, unit, of, "the samples give no number");
        }
        let sigma = value.sigma.is_finite().then_some(value.sigma);
        Finding { key, name, of: of.into(), value: Some(value.value), sigma, unit, how: how.into() }
    }

    pub(super) fn unknown(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        of: &str,
        why: impl Into<String>,
    ) -> Finding {
        let how = format!("cannot tell because {}", why.into());
        Finding { key, name, of: of.into(), value: None, sigma: None, unit, how }
    }

    pub(super) fn from(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        of: &str,
        found: &Result<Estimate, String>,
        how: impl Into<String>,
    ) -> Finding {
        match found {
            Ok(value) => Finding::new(key, name, unit, of, *value, how),
            Err(why) => Finding::unknown(key, name, unit, of, why.clone()),
        }
    }
}

/// A value and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// 1 σ.
    pub sigma: f64,
}

impl Estimate {
    pub(super) fn scaled(self, by: f64) -> Estimate {
        Estimate { value: self.value * by, sigma: self.sigma * by.abs() }
    }

    /// With a further uncertainty that has nothing to do with the others.
    pub(super) fn and(self, sigma: f64) -> Estimate {
        Estimate { sigma: self.sigma.hypot(sigma), ..self }
    }
}

/// Mean and its uncertainty from how much repetitions differ; a single one keeps its own.
pub(super) fn mean(all: &[Estimate]) -> Option<Estimate> {
    let count = all.len() as f64;
    let value = all.iter().map(|e| e.value).sum::<f64>() / count;
    let own = (all.iter().map(|e| e.sigma * e.sigma).sum::<f64>()).sqrt() / count;
    match all.len() {
        0 => None,
        1 => Some(all[0]),
        _ => {
            let spread = all.iter().map(|e| (e.value - value).powi(2)).sum::<f64>() / (count - 1.0);
            Some(Estimate { value, sigma: own.max((spread / count).sqrt()) })
        }
    }
}
