//! What is said of a whole rig.

use std::collections::BTreeMap;

use super::answer::SharedFinding;
use super::shared::{Estimate, Shared};
use crate::answer::{Diagnosis, Grade};
use crate::numbers;

/// What a shared effect does here, with numbers.
pub(crate) fn says(shared: &Shared, channels: &[String], estimate: &Estimate) -> String {
    let names = list(channels);
    let (value, low, high) = numbers::interval(estimate.value, estimate.low, estimate.high);
    let unit = shared.parameter.unit;
    match shared.id() {
        "shared.supply_resistance" => {
            format!("The supply of {names} sags under the sum of their currents, by {value} V/A ({low} to {high})")
        }
        "shared.neighbour_heating" => {
            format!("{names} heat each other: {value} {unit} ({low} to {high}) pass between the wires")
        }
        other => format!("{names} share {other}: {value} {unit} ({low} to {high})"),
    }
}

/// The answer in a few sentences.
pub(crate) fn summary(shared: &[SharedFinding], channels: &BTreeMap<String, Diagnosis>) -> String {
    let mut sentences: Vec<String> = shared
        .iter()
        .map(|finding| {
            let says = &finding.says;
            let chi = &finding.evidence;
            match finding.grade {
                Grade::Suspected => format!("Suspected only: {says}."),
                grade => format!(
                    "{says} ({}): chi on kept-back data {} without it, {} with it.",
                    grade.says(),
                    numbers::number(chi.holdout_chi_before),
                    numbers::number(chi.holdout_chi_after)
                ),
            }
        })
        .collect();
    if shared.is_empty() {
        sentences.push("The wires share nothing that these recordings show.".into());
    }
    sentences.extend(channels.iter().map(|(name, diagnosis)| {
        let effects: Vec<String> = diagnosis
            .effects
            .iter()
            .filter(|effect| effect.grade != Grade::Suspected)
            .map(|effect| effect.id.clone())
            .collect();
        let what = if effects.is_empty() { String::new() } else { format!(", {}", list(&effects)) };
        let remains = numbers::number(diagnosis.remains.chi);
        format!("{name}: {}{what}; chi {remains} remains.", diagnosis.verdict.name().replace('_', " "))
    }));
    sentences.join(" ")
}

fn list(names: &[String]) -> String {
    match names {
        [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => names.concat(),
    }
}
