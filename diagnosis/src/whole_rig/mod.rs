//! Several wires of a rig at once: one answer per wire, and one for what they share.
//!
//! Every wire is diagnosed alone first, in the surroundings that the fitted models of the others make. What they may
//! share is an effect of the catalogue whose input is what the others do. Each is tried with one size for all wires it
//! ties together, by the sum of their log evidences; the best is taken if all wires, searched anew with it, are
//! together more probable than they are alone. So a supply that two wires share competes with whatever each of them has
//! found for itself.

mod answer;
mod others;
mod shared;
mod wire;
mod words;

use std::collections::BTreeMap;

use sinew_recording::Recording;
use sinew_rig::Rig;

use crate::answer::{Diagnosis, EffectSize, Evidence, Grade, Verdict};
use crate::data::Data;
use crate::diagnose::{Found, Outcome, in_pool};
use crate::error::Error;
use crate::evidence;
use crate::fit::Fit;
use crate::grade::{self, CONFIRMED};
use crate::prepare::{Prepared, Searched};
use crate::select::TAKEN;
use crate::settings::Settings;
use crate::space::Space;

pub use answer::{RIG_SCHEMA, RigDiagnosis, SharedFinding, SharedTried};
use shared::{Estimate, Shared};
use wire::Wire;

/// The recordings of one wire. The n-th of every wire are of the same run, with one clock.
#[derive(Debug, Clone)]
pub struct WireRecordings {
    /// Index of the channel.
    pub channel: usize,
    /// What is fitted.
    pub recordings: Vec<Recording>,
    /// What is only judged by.
    pub held_out: Vec<Recording>,
}

/// What a diagnosis of a whole rig gives.
#[derive(Debug, Clone)]
pub struct RigOutcome {
    /// The answer.
    pub diagnosis: RigDiagnosis,
    /// What there is of every wire, by the name of its channel, in the order given.
    pub wires: Vec<(String, Outcome)>,
    /// The rig with what was found in its models.
    pub improved: Rig,
}

/// Most shared effects, and how many of one round's candidates are searched in full before it ends.
const MOST_SHARED: usize = 4;
const FULL_SEARCHES: usize = 2;
/// How often surroundings and size are made from each other.
const TURNS: usize = 3;
/// Two explanations whose log evidence differs less than this cannot be distinguished.
const ALIKE: f64 = 5.0;

/// Finds where recordings of several wires differ from the rig's simulation, and what explains it: for each wire, and
/// for what they share.
///
/// # Errors
/// As [`diagnose`](crate::diagnose()); fewer than two wires, one of them twice, or another number of recordings for
/// some.
pub fn diagnose_rig(rig: &Rig, wires: &[WireRecordings], settings: &Settings<'_>) -> Result<RigOutcome, Error> {
    check(rig, wires)?;
    in_pool(settings.jobs, || {
        let alone = alone(rig, wires, settings)?;
        let mut state =
            State { rig: rig.clone(), wires: alone, shared: Vec::new(), suspected: Vec::new(), tried: Vec::new() };
        while state.shared.len() < MOST_SHARED && state.take_one(settings)? {}
        state.outcome(settings)
    })
}

fn check(rig: &Rig, wires: &[WireRecordings]) -> Result<(), Error> {
    let first = wires.first().ok_or(Error::FewWires { found: 0 })?;
    if wires.len() < 2 {
        return Err(Error::FewWires { found: wires.len() });
    }
    for (index, wire) in wires.iter().enumerate() {
        let channels = rig.channels.len();
        let Some(channel) = rig.channels.get(wire.channel) else {
            return Err(Error::NoChannel { found: wire.channel, channels });
        };
        let counts = (wire.recordings.len(), wire.held_out.len());
        let expected = (first.recordings.len(), first.held_out.len());
        if counts != expected || wires[..index].iter().any(|other| other.channel == wire.channel) {
            return Err(Error::UnevenWires { channel: channel.name.clone(), found: counts, expected });
        }
    }
    Ok(())
}

/// Every wire by itself, in the surroundings that the rig file states.
fn alone(rig: &Rig, wires: &[WireRecordings], settings: &Settings<'_>) -> Result<Vec<Wire>, Error> {
    let mut prepared = Vec::new();
    for wire in wires {
        let Prepared { data, warnings } =
            Prepared::new(rig, wire.channel, &wire.recordings, &wire.held_out, settings.seed)?;
        prepared.push((wire.channel, data, warnings));
    }
    let as_given: Vec<others::Courses> = prepared
        .iter()
        .map(|(channel, data, _)| {
            let space = Space::reference(rig, *channel, data);
            others::Courses::of(*channel, data, &space, &vec![0.0; space.len()])
        })
        .collect::<Option<_>>()
        .ok_or(Error::NoFit)?;
    let mut found = Vec::new();
    for (channel, data, warnings) in prepared {
        let around = others::around(rig, channel, &data, &as_given);
        let data = data.among(&data, &around);
        let name = rig.channels[channel].name.clone();
        let progress = |stage: &str, share: f64| (settings.progress)(&format!("{name}: {stage}"), share);
        let space = Space::reference(rig, channel, &data);
        let from = Searched::new(&data, &space, space.drive());
        let settings = Settings { progress: &progress, ..*settings };
        let found_here = Found::search(rig, channel, data, from, &settings)?;
        found.push(Wire { channel, name, found: found_here, warnings });
    }
    Ok(found)
}

/// What is known so far.
struct State {
    /// The rig with what is shared in it.
    rig: Rig,
    wires: Vec<Wire>,
    shared: Vec<SharedFinding>,
    /// Better with them, but not on what was kept back.
    suspected: Vec<SharedFinding>,
    tried: Vec<SharedTried>,
}

/// A shared effect searched in full.
struct Full {
    rig: Rig,
    /// Of the wires it ties together, by index.
    found: Vec<(usize, Found)>,
    finding: SharedFinding,
    /// Rise of the log evidence of all wires.
    rise: f64,
}

impl State {
    /// Tries what the wires may share beside what is known, and takes the best if there is one.
    fn take_one(&mut self, settings: &Settings<'_>) -> Result<bool, Error> {
        let candidates = shared::candidates(&self.rig, &self.wires);
        let count = candidates.len() as f64;
        let mut estimates: Vec<(Shared, Rig, Estimate)> = Vec::new();
        for (number, candidate) in candidates.into_iter().enumerate() {
            (settings.progress)("what wires share", number as f64 / count);
            if let Some((rig, estimate)) = self.estimated(&candidate) {
                estimates.push((candidate, rig, estimate));
            }
        }
        estimates.sort_by(|a, b| b.2.rise.total_cmp(&a.2.rise));
        if self.tried.is_empty() {
            self.tried = estimates.iter().map(|(shared, _, estimate)| self.tried(shared, estimate)).collect();
        }
        for (shared, rig, estimate) in estimates.iter().take(FULL_SEARCHES) {
            if estimate.rise < TAKEN || self.is_suspected(shared) {
                continue;
            }
            let mut full = self.full(shared, rig, estimate, settings)?;
            if full.rise < TAKEN {
                continue;
            }
            let alike = estimates.iter().filter(|(_, _, other)| estimate.rise - other.rise < ALIKE);
            let others = alike.filter(|(other, ..)| other.id() != shared.id() || other.members != shared.members);
            full.finding.cannot_be_told_apart_from = others.map(|(other, ..)| self.said(other)).collect();
            if full.finding.grade == Grade::Suspected {
                self.suspected.push(full.finding);
                continue;
            }
            self.rig = full.rig;
            for (index, found) in full.found {
                self.wires[index].found = found;
            }
            self.shared.push(full.finding);
            return Ok(true);
        }
        Ok(false)
    }

    /// An estimate of a shared effect, and the rig with it.
    fn estimated(&self, shared: &Shared) -> Option<(Rig, Estimate)> {
        let mut tied = self.rig.clone();
        shared.tie(&mut tied, &self.wires);
        let mut fits: Vec<Fit> = self.wires.iter().map(|wire| wire.found.compared.chosen.fit.clone()).collect();
        let mut estimate: Option<Estimate> = None;
        for _ in 0..TURNS {
            let courses = self.courses(&tied, &fits)?;
            let around = |wire: &Wire| others::around(&tied, wire.channel, &wire.found.data, &courses);
            let next = shared.estimate(&self.wires, &around)?;
            shared.set(&mut tied, &self.wires, next.value);
            for (index, fit) in shared.members.iter().zip(&next.fits) {
                fits[*index] = fit.clone();
            }
            let has_settled = estimate.as_ref().is_some_and(|before| next.agrees_with(before.value));
            let is_hopeless = next.rise < 0.0;
            estimate = Some(next);
            if has_settled || is_hopeless {
                break;
            }
        }
        Some((tied, estimate?))
    }

    /// What every wire does, with these fitted models, tied to the others as this rig has it: their courses without
    /// that are what it is done in.
    fn courses(&self, rig: &Rig, fits: &[Fit]) -> Option<Vec<others::Courses>> {
        let course = |(wire, fit): (&Wire, &Fit), data: &Data| {
            others::Courses::with(wire.channel, data, &fit.space, &fit.z, rig)
        };
        let wires = || self.wires.iter().zip(fits);
        let before: Vec<others::Courses> =
            wires().map(|(wire, fit)| course((wire, fit), &wire.found.data)).collect::<Option<_>>()?;
        wires()
            .map(|(wire, fit)| {
                let data = &wire.found.data;
                course((wire, fit), &data.among(data, &others::around(rig, wire.channel, data, &before)))
            })
            .collect()
    }

    /// The wires a shared effect ties together, each searched anew with it.
    fn full(&self, shared: &Shared, rig: &Rig, first: &Estimate, settings: &Settings<'_>) -> Result<Full, Error> {
        let mut rig = rig.clone();
        let mut fits: Vec<Fit> = self.wires.iter().map(|wire| wire.found.compared.chosen.fit.clone()).collect();
        for (index, fit) in shared.members.iter().zip(&first.fits) {
            fits[*index] = fit.clone();
        }
        let mut estimate = first.clone();
        let mut anew = Vec::new();
        let mut moves = Vec::new();
        for _ in 0..TURNS {
            let held = estimate.value;
            let courses = self.courses(&rig, &fits).ok_or_else(Error::lost_fit)?;
            anew.clear();
            for index in &shared.members {
                let Wire { channel, name, found, .. } = &self.wires[*index];
                let progress = |stage: &str, share: f64| {
                    (settings.progress)(&format!("{name}, with {}: {stage}", shared.id()), share);
                };
                let around = others::around(&rig, *channel, &found.data, &courses);
                let (data, from) = (found.data.among(&found.data, &around), found.from.among(&around));
                let settings = Settings { progress: &progress, ..*settings };
                anew.push((*index, Found::search(&rig, *channel, data, from, &settings)?));
            }
            for (index, found) in &anew {
                fits[*index] = found.compared.chosen.fit.clone();
            }
            let courses = self.courses(&rig, &fits).ok_or_else(Error::lost_fit)?;
            let around = |index: usize, data: &Data| others::around(&rig, self.wires[index].channel, data, &courses);
            estimate = shared.again(&anew, &around, held).unwrap_or(estimate);
            shared.set(&mut rig, &self.wires, estimate.value);
            moves.push(estimate.value - held);
            if estimate.agrees_with(held) || estimate.weight() < TAKEN {
                break;
            }
        }
        if let [.., before, last] = moves[..] {
            estimate.widen(last / before);
        }
        let (mut rise, mut rise_on_kept) = (estimate.price, 0.0);
        let mut chi = BTreeMap::new();
        for (index, with) in &anew {
            let without = &self.wires[*index].found;
            rise += with.selection.chosen.evidence - without.selection.chosen.evidence;
            let deviance = |found: &Found| found.selection.chosen.deviance_kept(&found.searched);
            if let (Some(without), Some(with)) = (deviance(without), deviance(with)) {
                rise_on_kept += 0.5 * (without - with);
            }
            chi.insert(*index, [without, with].map(|found| grade::chi_kept(&found.data, &found.compared.chosen.fit)));
        }
        let is_held_out = anew.iter().any(|(_, found)| found.data.runs.iter().any(|run| run.held_out));
        let grade = match rise_on_kept {
            rise if rise < CONFIRMED => Grade::Suspected,
            _ if is_held_out => Grade::ConfirmedOnAnotherProgramme,
            _ => Grade::OnThisProgrammeOnly,
        };
        let mean = |of: usize| (chi.values().map(|chi| chi[of] * chi[of]).sum::<f64>() / chi.len() as f64).sqrt();
        let names: Vec<String> = shared.members.iter().map(|index| self.wires[*index].name.clone()).collect();
        let unit = shared.parameter.unit.to_string();
        let size = |[value, low, high]: [f64; 3]| EffectSize { value, low, high, unit: unit.clone() };
        let by_channel = names.iter().cloned().zip(estimate.by_wire.iter().map(|wire| size(*wire))).collect();
        let finding = SharedFinding {
            id: shared.id().to_string(),
            says: words::says(shared, &names, &estimate),
            parameters: [(shared.parameter.key.to_string(), size([estimate.value, estimate.low, estimate.high]))]
                .into(),
            channels: names,
            by_channel,
            grade,
            evidence: Evidence {
                holdout_chi_before: mean(0),
                holdout_chi_after: mean(1),
                delta_bic: -2.0 * rise,
                p_value: evidence::p_value(rise, self.tried.len()),
                holdout_rise: rise_on_kept,
            },
            cannot_be_told_apart_from: Vec::new(),
        };
        // a search anew may end better for other reasons
        let rise = rise.min(estimate.weight());
        Ok(Full { rig, found: anew, finding, rise })
    }

    fn said(&self, shared: &Shared) -> String {
        format!("{} ({})", shared.id(), self.names(shared).join(", "))
    }

    fn names(&self, shared: &Shared) -> Vec<String> {
        shared.members.iter().map(|index| self.wires[*index].name.clone()).collect()
    }

    fn tried(&self, shared: &Shared, estimate: &Estimate) -> SharedTried {
        SharedTried { id: shared.id().to_string(), channels: self.names(shared), delta_bic: -2.0 * estimate.rise }
    }

    fn is_suspected(&self, shared: &Shared) -> bool {
        self.suspected.iter().any(|finding| finding.id == shared.id() && finding.channels == self.names(shared))
    }

    fn outcome(mut self, settings: &Settings<'_>) -> Result<RigOutcome, Error> {
        let mut improved = self.rig.clone();
        let mut wires = Vec::new();
        let mut channels: BTreeMap<String, Diagnosis> = BTreeMap::new();
        let mut warnings = Vec::new();
        for Wire { channel, name, found, warnings: of_wire } in &self.wires {
            let progress = |stage: &str, share: f64| (settings.progress)(&format!("{name}: {stage}"), share);
            let settings = Settings { progress: &progress, ..*settings };
            let outcome = found.outcome(&self.rig, of_wire.clone(), &settings)?;
            improved.channels[*channel] = outcome.improved.channels[*channel].clone();
            warnings.extend(outcome.diagnosis.warnings.iter().map(|warning| format!("{name}: {warning}")));
            channels.insert(name.clone(), outcome.diagnosis.clone());
            wires.push((name.clone(), outcome));
        }
        let worst = |verdict: Verdict| channels.values().any(|diagnosis| diagnosis.verdict == verdict);
        let verdict = if worst(Verdict::UnknownPhysics) {
            Verdict::UnknownPhysics
        } else if worst(Verdict::PhysicsMissing) || !self.shared.is_empty() {
            Verdict::PhysicsMissing
        } else if worst(Verdict::ParametersOff) {
            Verdict::ParametersOff
        } else {
            Verdict::Agrees
        };
        self.shared.append(&mut self.suspected);
        let diagnosis = RigDiagnosis {
            schema: RIG_SCHEMA.to_string(),
            verdict,
            summary: words::summary(&self.shared, &channels),
            shared: self.shared,
            tried: self.tried,
            channels,
            warnings,
            seed: settings.seed,
        };
        Ok(RigOutcome { diagnosis, wires, improved })
    }
}

#[cfg(test)]
mod tests;
