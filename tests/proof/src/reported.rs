//! What a diagnosis reported on a case, as far as it is scored, and what it took.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sinew_diagnosis::{Diagnosis, Grade};

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
}

fn of_grade(diagnosis: &Diagnosis, grade: Grade) -> Vec<String> {
    diagnosis.effects.iter().filter(|e| e.grade == grade).map(|e| e.id.clone()).collect()
}

impl Reported {
    /// The scored part of a diagnosis.
    pub fn of(diagnosis: &Diagnosis) -> Reported {
        let effects = diagnosis
            .effects
            .iter()
            // what is only suspected is not named
            .filter(|effect| effect.grade != Grade::Suspected)
            .map(|effect| Named {
                id: effect.id.clone(),
                class: effect.cannot_be_told_apart_from.clone(),
                share: effect.share,
                sizes: effect.parameters.iter().map(|(key, p)| (key.clone(), [p.value, p.low, p.high])).collect(),
            })
            .collect();
        Reported {
            verdict: Some(diagnosis.verdict.name().to_string()),
            effects,
            suspected: of_grade(diagnosis, Grade::Suspected),
            remains: diagnosis.remains.looks_like.says().to_string(),
            equation: diagnosis.location.equation.clone(),
            unknown: diagnosis.unknown.is_some(),
            chi: [diagnosis.left.chi, diagnosis.left.chi_improved],
            p_value: diagnosis.left.p_value,
            warnings: diagnosis.warnings.clone(),
            parameters: diagnosis.parameters.iter().map(|(key, p)| (key.clone(), [p.low, p.high])).collect(),
            ..Reported::default()
        }
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
