//! The report of a run: the numbers as JSON and for a terminal, and their origin.

use std::fmt::Write as _;

use serde::Serialize;
use sinew_plot::quantity::{fixed, is_sane, number, shown_unit};

use crate::analysis::{Finding, Run, findings};
use crate::run::{Ending, Ran};

/// Version of the JSON.
const SCHEMA: &str = "sinew.test/1";

/// What a report says of where it comes from.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct About {
    /// Name of the rig.
    pub rig: String,
    /// Name of the channel.
    pub channel: String,
    /// The command that makes it again, as typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
}

/// Where the numbers of a running rig come from.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct OnRig {
    /// Which sensor gave the position.
    pub position: String,
    /// What pulled at the wire, by which its force is reckoned.
    pub load: String,
}

/// The report of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// `sinew.test/1`.
    pub schema: &'static str,
    /// Where it comes from.
    #[serde(flatten)]
    pub about: About,
    /// Which routine.
    pub routine: &'static str,
    /// Whether the machine was computed, or the wires of the rig.
    pub simulated: bool,
    /// Of a running rig: what its numbers come from. `None` = a machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub running: Option<OnRig>,
    /// How it ended, in words.
    pub ending: String,
    /// Whether not all of the routine was done: numbers are of the stages that were completed.
    pub partial: bool,
    /// Length of the recording, s.
    pub seconds: f64,
    /// Rows of the recording.
    pub rows: usize,
    /// What was found.
    pub findings: Vec<Finding>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

impl Report {
    /// Analyses a run.
    pub fn of(
        run: &Run<'_>,
        ran: &Ran,
        simulated: bool,
        running: Option<OnRig>,
        about: About,
        notes: Vec<String>,
    ) -> Report {
        Report {
            schema: SCHEMA,
            about,
            routine: run.kind.word(),
            simulated,
            running,
            ending: ran.ending.to_string(),
            partial: ran.ending != Ending::Complete,
            seconds: ran.rows.len() as f64 / run.spec.rate_hz,
            rows: ran.rows.len(),
            findings: findings(run),
            notes,
        }
    }

    /// On what it was run, before the rig's name.
    pub(crate) fn place(&self) -> &'static str {
        match (self.running.is_some(), self.simulated) {
            (true, true) => "the running rig, its wires simulated, ",
            (true, false) => "the running rig ",
            (false, true) => "the simulated machine, rig ",
            (false, false) => "the machine, rig ",
        }
    }

    /// The table for a terminal.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} of {} on {}{}: {}, {} s\n",
            self.routine,
            self.about.channel,
            self.place(),
            self.about.rig,
            self.ending,
            fixed(self.seconds, 1)
        );
        if self.partial {
            text.push_str("partial: the numbers are of what was completed\n");
        }
        if let Some(OnRig { position, load }) = &self.running {
            let _ = writeln!(text, "position: {position}\nforce: reckoned from the load, {load}");
        }
        for note in &self.notes {
            let _ = writeln!(text, "note: {note}");
        }
        let known: Vec<[String; 3]> =
            self.findings.iter().filter_map(|f| Some([label(f), value(f)?, shown_unit(f.unit).to_string()])).collect();
        let width = |i: usize| known.iter().map(|row| row[i].chars().count()).max().unwrap_or(0);
        let (first, second) = (width(0), width(1));
        for [name, value, unit] in &known {
            let pad = |text: &str, width: usize| " ".repeat(width.saturating_sub(text.chars().count()));
            let _ = writeln!(text, "  {name}{}  {}{value} {unit}", pad(name, first), pad(value, second));
        }
        // one line for what cannot be determined for one reason
        let mut unknown: Vec<(&str, &str, Vec<&str>)> = Vec::new();
        for finding in self.findings.iter().filter(|f| f.value.is_none()) {
            let same =
                |(name, how, _): &&mut (&str, &str, Vec<&str>)| (*name, *how) == (finding.name, finding.how.as_str());
            match unknown.iter_mut().find(same) {
                Some((_, _, of)) => of.push(&finding.of),
                None if finding.of.is_empty() => unknown.push((finding.name, &finding.how, Vec::new())),
                None => unknown.push((finding.name, &finding.how, vec![&finding.of])),
            }
        }
        for (name, how, of) in unknown {
            let of = if of.is_empty() { String::new() } else { format!(" ({})", of.join(", ")) };
            let _ = writeln!(text, "  {name}{of}: {how}");
        }
        text
    }
}

/// What a finding is called, with what it is of.
pub(crate) fn label(finding: &Finding) -> String {
    if finding.of.is_empty() { finding.name.to_string() } else { format!("{}, {}", finding.name, finding.of) }
}

/// A finding's number in as many digits as its uncertainty is worth; `None` where there is none.
pub(crate) fn value(finding: &Finding) -> Option<String> {
    let value = finding.value?;
    let Some(sigma) = finding.sigma.filter(|sigma| is_sane(*sigma) && *sigma > 0.0) else {
        return Some(number(value));
    };
    // two digits of the uncertainty, as long as that is no nonsense for the value
    let decimals = (1 - sigma.log10().floor() as i32).clamp(0, 6) as usize;
    Some(format!("{} ± {}", fixed(value, decimals), fixed(sigma, decimals)))
}
