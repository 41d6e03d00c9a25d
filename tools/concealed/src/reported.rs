//! What a diagnosis reported on a case, as far as it is scored, and what it took.

use std::collections::BTreeMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// An effect that was named.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its id.
    pub id: String,
    /// What it is reported not to be distinguishable from.
    pub class: Vec<String>,
    /// Its share of what was wrong.
    pub share: f64,
    /// Value and ends of the 90 % interval of its parameters, by key.
    pub sizes: BTreeMap<String, [f64; 3]>,
}

/// What a diagnosis took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Took {
    /// Wall time, s.
    pub seconds: f64,
    /// Time its threads computed, all together, s: what it would take on a machine that does nothing else, whatever that
    /// one did.
    pub computing_s: f64,
    /// Largest resident memory, MiB.
    pub memory_mib: f64,
}

/// A diagnosis' answer, or why there is none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Reported {
    /// Its verdict; none where the input was refused or the process ended early.
    pub verdict: Option<String>,
    /// Why there is no verdict, or why the improved rig file could not be judged.
    pub trouble: String,
    /// Effects, in its order.
    pub effects: Vec<Named>,
    /// Effects that are only suspected.
    pub suspected: Vec<String>,
    /// What it says that what remains looks like.
    pub remains: String,
    /// The equation it blames.
    pub equation: Option<String>,
    /// Whether it gives a closed form for what is outside its catalogue.
    pub unknown: bool,
    /// chi on the data it kept back, recalibrated and improved.
    pub chi: [f64; 2],
    /// How probable it finds what is left, were nothing missing.
    pub p_value: f64,
    /// Its warnings.
    pub warnings: Vec<String>,
    /// 90 % intervals of the reference model's parameters, by key.
    pub parameters: BTreeMap<String, [f64; 2]>,
    /// chi of its improved rig file on the second recording, which it never saw, over the true noise.
    pub held: Option<f64>,
    /// What it took.
    pub took: Took,
    /// SHA-256 of the program that was asked.
    pub program: String,
}

impl Reported {
    /// The scored part of a `diagnosis.json`.
    ///
    /// # Errors
    /// The text is none.
    pub fn read(text: &[u8]) -> Result<Reported, serde_json::Error> {
        let written: Written = serde_json::from_slice(text)?;
        let parameters = written.parameters.iter().map(|(key, p)| (key.clone(), [p.low(), p.high()])).collect();
        // what is only suspected is not named
        let (suspected, named): (Vec<_>, Vec<_>) = written.effects.into_iter().partition(|e| e.grade == SUSPECTED);
        Ok(Reported {
            verdict: Some(written.verdict),
            effects: named.into_iter().map(Found::named).collect(),
            suspected: suspected.into_iter().map(|effect| effect.id).collect(),
            remains: written.remains.looks_like,
            equation: written.location.equation,
            unknown: written.unknown.is_some(),
            chi: [number(written.left.chi), number(written.left.chi_improved)],
            p_value: number(written.left.p_value),
            warnings: written.warnings,
            parameters,
            ..Reported::default()
        })
    }

    /// No verdict, and why.
    pub fn refused(why: &str) -> Reported {
        Reported { trouble: why.to_string(), ..Reported::default() }
    }

    /// Whether it reports that something is missing that its catalogue does not have.
    pub fn reports_unknown(&self) -> bool {
        self.verdict.as_deref() == Some("unknown_physics") || self.unknown
    }
}

/// How the trouble of a process that ended without an answer begins.
pub const CRASHED: &str = "ended without an answer";
/// The grade of an effect that is not borne out.
const SUSPECTED: &str = "suspected";

/// What is read of a `diagnosis.json`: the file is the contract, not the diagnosis' types.
#[derive(Deserialize)]
struct Written {
    verdict: String,
    effects: Vec<Found>,
    remains: Remains,
    #[serde(rename = "where")]
    location: Location,
    unknown: Option<IgnoredAny>,
    left: Left,
    warnings: Vec<String>,
    parameters: BTreeMap<String, Interval>,
}

#[derive(Deserialize)]
struct Found {
    id: String,
    #[serde(default)]
    cannot_be_told_apart_from: Vec<String>,
    share: Option<f64>,
    grade: String,
    parameters: BTreeMap<String, Interval>,
}

#[derive(Deserialize)]
struct Remains {
    looks_like: String,
}

#[derive(Deserialize)]
struct Location {
    equation: Option<String>,
}

#[derive(Deserialize)]
struct Left {
    chi: Option<f64>,
    chi_improved: Option<f64>,
    p_value: Option<f64>,
}

#[derive(Deserialize)]
struct Interval {
    value: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
}

/// A number that is not finite is `null` in JSON.
fn number(written: Option<f64>) -> f64 {
    written.unwrap_or(f64::NAN)
}

impl Interval {
    fn low(&self) -> f64 {
        number(self.low)
    }

    fn high(&self) -> f64 {
        number(self.high)
    }
}

impl Found {
    fn named(self) -> Named {
        let sizes =
            self.parameters.iter().map(|(key, p)| (key.clone(), [number(p.value), p.low(), p.high()])).collect();
        Named { id: self.id, class: self.cannot_be_told_apart_from, share: number(self.share), sizes }
    }
}
