//! Whether an answer is right about what was concealed, by one set of rules: the proof's figures count by them, and `sinew reveal`
//! tells by them.

use serde::Serialize;

use crate::generator::case::Answer;
use crate::reported::{CRASHED, Named, Reported};

/// A case with what was reported on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// What was concealed.
    pub answer: Answer,
    /// What was reported.
    pub reported: Reported,
    /// 90 s at 200 Hz, on all cores, alone on the machine.
    pub long: bool,
}

/// An effect with a smaller share of what was wrong does not count as a wrong name.
const WORTH_A_NAME: f64 = 0.1;
/// chi up to which a second recording is predicted to within its noise.
const WITHIN_NOISE: f64 = 1.05;

/// How visible a single effect was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Level {
    /// Refitting hides it: less than half the noise is left.
    Hidden,
    /// About the noise.
    One,
    /// About three times the noise.
    Three,
    /// Five and a half times the noise and more.
    Ten,
}

impl Level {
    /// All, from faint to plain.
    pub const ALL: [Level; 4] = [Level::Hidden, Level::One, Level::Three, Level::Ten];

    /// Of what is left after refitting, RMS over the noise: the bounds are half way between the levels, in ratio.
    pub fn of(left: f64) -> Level {
        match left {
            l if l < 0.5 => Level::Hidden,
            l if l < 3f64.sqrt() => Level::One,
            l if l < 30f64.sqrt() => Level::Three,
            _ => Level::Ten,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Level::Hidden => "below ½",
            Level::One => "1×",
            Level::Three => "3×",
            Level::Ten => "10×",
        }
    }
}

impl Judged {
    /// `null`, `single`, `several`, `outside`, `own` or `trap`.
    pub fn group(&self) -> &str {
        &self.answer.group
    }

    /// Effects that are reported and that the structure of the truth does not hold anyway.
    fn effects(&self) -> impl Iterator<Item = &Named> {
        self.reported.effects.iter().filter(|e| !self.answer.allowed.contains(&e.id))
    }

    /// Physics is reported to be missing, in the catalogue or not, beside what the structure of the truth holds anyway.
    pub fn alarms(&self) -> bool {
        match self.reported.verdict.as_deref() {
            Some("unknown_physics") => true,
            Some("physics_missing") => self.effects().next().is_some() || self.reported.unknown,
            _ => false,
        }
    }

    /// What is reported first: an effect's id, or `nothing`, `unknown`, `no answer`.
    pub fn first(&self) -> &str {
        match self.reported.verdict.as_deref() {
            None => "no answer",
            Some("unknown_physics") => "unknown",
            _ if !self.alarms() => "nothing",
            _ => self.effects().next().map_or("unknown", |effect| &effect.id),
        }
    }

    /// The same effect, or one that is the same circuit.
    pub fn is_same(&self, reported: &str, truth: &str) -> bool {
        let has = |set: &[String], id: &str| set.iter().any(|s| s == id);
        reported == truth || self.answer.same.iter().any(|set| has(set, reported) && has(set, truth))
    }

    /// The effect reported first is one that is there.
    pub fn first_right(&self) -> bool {
        let first = self.first();
        self.answer.accept.iter().any(|truth| self.is_same(first, truth))
    }

    /// An effect that is there is named.
    pub fn names(&self, truth: &str) -> bool {
        self.reported.effects.iter().any(|e| self.is_same(&e.id, truth))
    }

    /// An effect that is there is named, or in the class of one that is.
    fn names_or_class(&self, truth: &str) -> bool {
        self.names(truth) || self.reported.effects.iter().any(|e| e.class.iter().any(|id| self.is_same(id, truth)))
    }

    /// All that is there is named.
    pub fn all_named(&self) -> bool {
        self.alarms() && self.answer.accept.iter().all(|truth| self.names(truth))
    }

    /// All that is there is named or in a declared class.
    pub fn all_in_class(&self) -> bool {
        self.alarms() && self.answer.accept.iter().all(|truth| self.names_or_class(truth))
    }

    /// The equation reported to be guilty is.
    pub fn equation_right(&self) -> bool {
        self.alarms() && self.reported.equation.as_ref().is_some_and(|e| self.answer.equations.contains(e))
    }

    /// A catalogue effect is blamed for what is none, with a share worth the name.
    pub fn false_effect(&self) -> bool {
        self.reported.verdict.as_deref() == Some("physics_missing") && self.effects().any(|e| e.share > WORTH_A_NAME)
    }

    /// The same, and what was put into the model does not predict the second recording.
    pub fn wrong_name(&self) -> bool {
        self.false_effect() && !self.predicts()
    }

    /// What is outside the catalogue is said to be, and nothing of the catalogue blamed for it.
    pub fn outside_said(&self) -> bool {
        self.reported.reports_unknown() && !self.false_effect()
    }

    /// Effects that are named beside a right one and are not there.
    pub fn has_spurious(&self) -> bool {
        self.effects().any(|e| !self.answer.accept.iter().any(|truth| self.is_same(&e.id, truth)))
    }

    /// At least one effect that is there is named.
    pub fn names_one(&self) -> bool {
        self.alarms() && self.answer.accept.iter().any(|truth| self.names(truth))
    }

    /// What went wrong, by rule; `None` where nothing did.
    pub fn failure(&self) -> Option<&'static str> {
        if self.right() {
            return None;
        }
        let first = self.first();
        let equation = |id: &str| id.split('.').next().map(String::from).unwrap_or_default();
        Some(match (self.group(), first) {
            (_, "no answer") => "no answer",
            ("null", "unknown") => "unknown physics where there is none",
            ("null", _) => "an effect where there is none",
            (_, "nothing") => "taken for parameters",
            ("single" | "several" | "own", "unknown") => "not found, said to be unknown",
            ("outside", _) => "an effect of the catalogue in its place",
            _ if self.all_in_class() => "in the declared class, another first",
            ("several", _) if self.names_one() => "a member is missing",
            _ if self.answer.equations.contains(&equation(first)) => "another effect of the same equation",
            _ => "an effect of another equation",
        })
    }

    /// What it put into the model predicts the second recording to within noise.
    pub fn predicts(&self) -> bool {
        self.reported.held.is_some_and(|chi| chi <= WITHIN_NOISE)
    }

    /// A broken recording was refused, or something was warned of and no physics made of it.
    pub fn survives_trap(&self) -> bool {
        match self.reported.verdict {
            None => !self.crashed(),
            Some(_) => !self.alarms() && !self.reported.warnings.is_empty(),
        }
    }

    /// No answer, and not because the input was refused.
    pub fn crashed(&self) -> bool {
        self.reported.verdict.is_none() && self.reported.trouble.starts_with(CRASHED)
    }

    /// Whether it counts as right in its group; an effect that refitting hides is right unless another is named.
    pub fn right(&self) -> bool {
        match self.group() {
            "null" => self.reported.verdict.is_some() && !self.alarms(),
            "single" if Level::of(self.answer.level) == Level::Hidden => !self.alarms() || self.all_in_class(),
            "single" | "own" => self.first_right(),
            "several" => self.all_named(),
            "outside" => self.outside_said(),
            _ => self.survives_trap(),
        }
    }
}
