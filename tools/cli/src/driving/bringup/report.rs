//! What a bring-up has come to, for a person and as JSON (`sinew.bringup/1`).

use std::fmt::Write as _;

use serde::Serialize;
use sinew_rig::Rig;

use super::judge::{Check, Verdict};
use crate::args::BringupStep as Step;

/// The whole of it.
#[derive(Debug, Serialize)]
pub struct Report {
    schema: &'static str,
    rig: String,
    file: String,
    /// Every look, in order: a step that was repeated is there as often.
    looks: Vec<Stepped>,
    /// Channels whose gains and offsets are in the rig file.
    pub written: Vec<String>,
    /// Where the rig file is kept as it was.
    pub copy: Option<String>,
}

/// One look of a step.
#[derive(Debug, Serialize)]
pub struct Stepped {
    step: &'static str,
    channel: Option<String>,
    good: bool,
    checks: Vec<Checked>,
    findings: Vec<Found>,
}

#[derive(Debug, Serialize)]
struct Checked {
    what: String,
    wanted: f64,
    tolerance: f64,
    seen: f64,
    unit: &'static str,
    good: bool,
}

/// Something wrong, by its name.
#[derive(Debug, Clone, Serialize)]
pub struct Found {
    /// Of the cause.
    #[serde(rename = "cause")]
    pub id: &'static str,
    channel: Option<String>,
    /// What it is.
    pub says: String,
    saw: String,
    /// What to do.
    pub remedy: String,
}

impl From<&Check> for Checked {
    fn from(check: &Check) -> Checked {
        let Check { what, wanted, tolerance, seen, unit } = check.clone();
        Checked { what, wanted, tolerance, seen, unit, good: check.is_good() }
    }
}

impl Stepped {
    /// Of a verdict.
    pub fn of(step: Step, place: Option<usize>, verdict: &Verdict, rig: &Rig) -> Stepped {
        let name = |place: usize| rig.channels[place].name.clone();
        let found = |finding: &super::judge::Finding| Found {
            id: finding.cause.id(),
            channel: finding.channel.map(name),
            says: finding.cause.says().into(),
            saw: finding.saw.clone(),
            remedy: finding.cause.remedy().into(),
        };
        Stepped {
            step: step.word(),
            channel: place.map(name),
            good: verdict.is_good(),
            checks: verdict.checks.iter().map(Checked::from).collect(),
            findings: verdict.findings.iter().map(found).collect(),
        }
    }

    /// For a person.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // writing to a String cannot fail
        for Checked { what, wanted, tolerance, seen, unit, good } in &self.checks {
            let mark = if *good { "✔" } else { "✖" };
            let decimals = match tolerance {
                tolerance if *tolerance >= 1.0 => 2,
                tolerance if *tolerance >= 0.01 => 3,
                _ => 4,
            };
            let _ = writeln!(
                text,
                "{mark} {what}: {seen:.decimals$} {unit}, expected {wanted:.decimals$} ± {tolerance:.decimals$} {unit}"
            );
        }
        for Found { id, channel, says, saw, remedy } in &self.findings {
            let of = channel.as_ref().map_or(String::new(), |channel| format!("{channel}: "));
            let _ = writeln!(text, "✖ {id}: {of}{says}\n    seen: {saw}\n    to do: {remedy}");
        }
        if self.good {
            let of = self.channel.as_ref().map_or(String::new(), |channel| format!(" {channel}"));
            let _ = writeln!(text, "✔ {}{of}: as it should be", self.step);
        }
        text
    }
}

impl Report {
    /// Of nothing yet.
    pub fn new(rig: &Rig) -> Report {
        Report {
            schema: "sinew.bringup/1",
            rig: rig.name.clone(),
            file: rig.file().into(),
            looks: Vec::new(),
            written: Vec::new(),
            copy: None,
        }
    }

    /// Another look.
    pub fn add(&mut self, stepped: Stepped) {
        self.looks.push(stepped);
    }

    /// Whether anything was looked at.
    pub fn has_looked(&self) -> bool {
        !self.looks.is_empty()
    }

    /// The latest look of each step and channel.
    fn latest(&self) -> impl Iterator<Item = &Stepped> {
        let is_last = |at: usize, look: &Stepped| {
            !self.looks[at + 1..].iter().any(|later| (later.step, &later.channel) == (look.step, &look.channel))
        };
        self.looks.iter().enumerate().filter(move |(at, look)| is_last(*at, look)).map(|(_, look)| look)
    }

    /// What is wrong still, the first of it.
    pub fn first(&self) -> Option<&Found> {
        self.latest().flat_map(|look| &look.findings).next()
    }

    /// Whether every one of these steps was looked at.
    pub fn is_whole(&self, steps: &[Step]) -> bool {
        steps.iter().all(|step| *step == Step::Estop || self.looks.iter().any(|look| look.step == step.word()))
    }

    /// In a few lines.
    pub fn text(&self) -> String {
        let (mut text, mut good, mut bad) = (String::from("\n"), 0, 0);
        for look in self.latest() {
            if look.good { good += 1 } else { bad += 1 }
        }
        let _ = writeln!(text, "{}: {good} steps as they should be, {bad} not", self.rig);
        if !self.written.is_empty() {
            let _ = writeln!(text, "gains and offsets written to {}: {}", self.file, self.written.join(", "));
        }
        text
    }
}
