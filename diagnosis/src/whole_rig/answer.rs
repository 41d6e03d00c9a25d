//! The answer for a whole rig: what `diagnosis.json` says of several wires at once.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::answer::{Diagnosis, EffectSize, Evidence, Grade, Verdict};

/// The name of the format of [`RigDiagnosis`].
pub const RIG_SCHEMA: &str = "sinew.diagnosis.rig/1";

/// What a diagnosis of several wires came to; serialises to `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigDiagnosis {
    /// [`RIG_SCHEMA`].
    pub schema: String,
    /// The answer in a word: the worst of the wires', or that they share something.
    pub verdict: Verdict,
    /// The answer in a few sentences, for a person.
    pub summary: String,
    /// What wires share, in the order it was found; what is suspected only comes last.
    pub shared: Vec<SharedFinding>,
    /// Everything they could have shared, the most probable first.
    pub tried: Vec<SharedTried>,
    /// The answer for every wire, with what it shares in its model, by the name of its channel.
    pub channels: BTreeMap<String, Diagnosis>,
    /// Those of all wires.
    pub warnings: Vec<String>,
    /// The seed everything random was drawn with.
    pub seed: u64,
}

/// What several wires share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedFinding {
    /// Its id: `shared.supply_resistance`, `shared.neighbour_heating`.
    pub id: String,
    /// What it does here, with numbers.
    pub says: String,
    /// The channels it ties together.
    pub channels: Vec<String>,
    /// Its size, one for all of them.
    pub parameters: BTreeMap<String, EffectSize>,
    /// What each of them says of that size by itself, by the name of its channel.
    pub by_channel: BTreeMap<String, EffectSize>,
    /// How well it is borne out.
    pub grade: Grade,
    /// Why it is believed: chi over all of these wires, without it with whatever each found instead; the rise of the
    /// sum of their log evidences.
    pub evidence: Evidence,
    /// What else they could share that explains them as well.
    pub cannot_be_told_apart_from: Vec<String>,
}

/// Something wires could have shared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedTried {
    /// Its id.
    pub id: String,
    /// The channels it would tie together.
    pub channels: Vec<String>,
    /// Minus twice the rise of the sum of their log evidences, as it was estimated beside what each wire had found
    /// alone.
    pub delta_bic: f64,
}
