//! Constants stated as known, and sensors, that are off by more than their tolerances allow.

use std::collections::BTreeMap;

use sinew_physics::effects;

use crate::answer::{BeyondTolerance, EffectSize, Evidence, FoundEffect, Grade};
use crate::fit::Fit;
use crate::intervals::Interval;
use crate::numbers::number;
use crate::space::{Coordinate, What};
use crate::stages::Compared;
use crate::words;

/// Probability that any of them is called off where none is.
const FAMILY_LEVEL: f64 = 0.01;

/// The tolerances in a fit: their coordinates by index.
fn tolerances(fit: &Fit) -> impl Iterator<Item = (usize, &Coordinate, f64)> {
    let all = fit.space.coordinates.iter().zip(&fit.z).enumerate();
    all.filter(|(_, (c, _))| c.is_tolerance()).map(|(i, (c, z))| (i, c, *z))
}

/// Those that are off by more than chance, the furthest first.
pub(crate) fn beyond(fit: &Fit) -> Vec<BeyondTolerance> {
    let most = two_sided(FAMILY_LEVEL / tolerances(fit).count().max(1) as f64);
    let mut found: Vec<BeyondTolerance> = tolerances(fit)
        .filter(|(.., z)| z.abs() > most)
        .map(|(_, c, z)| {
            let key = words::key_of(c);
            let (given, value) = (c.origin, c.value(z));
            let unit = fit.space.unit_of(&key);
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let says = format!(
                "{key} is {}{unit}, not {}{unit}: {:.1} times its tolerance away",
                number(value),
                number(given),
                z.abs()
            );
            BeyondTolerance { key, sigmas: z, says }
        })
        .collect();
    found.sort_by(|a, b| b.sigmas.abs().total_cmp(&a.sigmas.abs()));
    found
}

/// Those of them that the catalogue knows as an effect of the same circuit.
pub(crate) fn as_effects(
    fit: &Fit,
    intervals: &[Interval],
    beyond: &[BeyondTolerance],
    compared: &Compared,
) -> Vec<FoundEffect> {
    let mut found: Vec<FoundEffect> = Vec::new();
    // what a wrong model needs, its nuisances give
    let grade = if compared.chosen.leaves_little() { Grade::OnThisProgrammeOnly } else { Grade::Suspected };
    for off in beyond {
        let Some(effect) = off.key.rsplit_once('.').and_then(|(id, _)| effects::effect(id)) else { continue };
        if found.iter().any(|there| there.id == effect.id) {
            continue;
        }
        let parameters: BTreeMap<String, EffectSize> = tolerances(fit)
            .filter_map(|(i, c, _)| {
                let What::Key(key) = &c.what else { return None };
                let p = effect.parameters.iter().find(|p| *key == format!("{}.{}", effect.id, p.key))?;
                let Interval { value, low, high } = intervals[i];
                Some((p.key.to_string(), EffectSize { value, low, high, unit: p.unit.to_string() }))
            })
            .collect();
        // how improbable so far an excursion is
        let delta_bic = -off.sigmas * off.sigmas;
        found.push(FoundEffect {
            id: effect.id.to_string(),
            says: words::says(effect, &parameters),
            parameters,
            share: 0.0,
            grade,
            evidence: Evidence {
                holdout_chi_before: compared.recalibrated.score.chi_kept(),
                holdout_chi_after: compared.improved.score.chi_kept(),
                delta_bic,
                p_value: FAMILY_LEVEL,
                ..Evidence::default()
            },
            alternatives: Vec::new(),
            cannot_be_told_apart_from: Vec::new(),
        });
    }
    found
}

/// How far a normal variable is from its mean with less than this probability, in σ.
fn two_sided(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if libm::erfc(middle / 2f64.sqrt()) > probability { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_a_normal_variable() {
        for (probability, sigmas) in [(0.05, 1.959964), (0.01, 2.575829), (0.0004, 3.540084)] {
            assert!((two_sided(probability) - sigmas).abs() < 5e-4);
        }
    }
}
