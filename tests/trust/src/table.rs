//! The table: for the terminal while it grows, as Markdown, and as JSON.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::kind::{Group, Measured, Row, Unit};

/// Name and version of the JSON's form.
pub const SCHEMA: &str = "sinew.trust/1";

/// Everything measured.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Tries asked for of each kind.
    pub tries: usize,
    /// Seed of all phases.
    pub seed: u64,
    /// How long it took, s.
    pub seconds: f64,
    /// A row for each kind.
    pub rows: Vec<Row>,
}

impl Report {
    /// Kinds in which every try came out as promised.
    pub fn kept(&self) -> usize {
        self.rows.iter().filter(|row| row.measured.kept).count()
    }
}

/// What an earlier run has measured, by the names of its kinds.
///
/// # Errors
/// A file that cannot be read, or is none of these.
pub fn earlier(path: &Path) -> Result<HashMap<String, Measured>, Failure> {
    #[derive(Deserialize)]
    struct Named {
        name: String,
        #[serde(flatten)]
        measured: Measured,
    }
    #[derive(Deserialize)]
    struct Rows {
        rows: Vec<Named>,
    }
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| wrong(&e))?;
    let Rows { rows } = serde_json::from_str(&text).map_err(|e| wrong(&e))?;
    Ok(rows.into_iter().map(|row| (row.name, row.measured)).collect())
}

impl Group {
    /// Its heading.
    pub fn title(self) -> &'static str {
        match self {
            Group::Electrical => "Electrical: supply, power stage, wire, taps, converter",
            Group::Stop => "Emergency stop and enable line",
            Group::Budgets => "Budgets: current, heat, temperature",
            Group::Commands => "Commands",
            Group::Loop => "The loop",
            Group::Process => "The driver's process and its machine",
            Group::Clients => "Clients",
            Group::Serial => "The line to a front-end",
            Group::Linux => "Linux's own outputs and converters",
        }
    }
}

fn number(value: f64, unit: Unit) -> String {
    match unit {
        Unit::Periods => format!("{value:.0}"),
        Unit::Milliseconds if value >= 10.0 => format!("{value:.0}"),
        _ => format!("{value:.1}"),
    }
}

/// What was promised of a row, in a word.
pub fn promised(row: &Row) -> String {
    format!("{} {}", number(row.within, row.unit), row.unit)
}

/// What was seen of it.
pub fn observed(row: &Row) -> String {
    match (row.measured.worst, row.measured.median) {
        (Some(worst), Some(median)) => format!("{} / {}", number(worst, row.unit), number(median, row.unit)),
        _ => "–".into(),
    }
}

/// What came of it, in a word.
pub fn verdict(row: &Row) -> String {
    match (row.measured.kept, row.measured.failed) {
        (true, _) => "kept".into(),
        (false, 0) => "not tried".into(),
        (false, failed) => format!("**broken** in {failed}"),
    }
}

/// One line for the terminal.
pub fn line(row: &Row) -> String {
    let mut text = format!(
        "{:<32} {:>5} tries  promised {:>10}  worst / median {:>14} {:<8} {:>5.1} s  {}",
        row.name,
        row.measured.tries,
        promised(row),
        observed(row),
        row.unit.to_string(),
        row.measured.seconds,
        verdict(row)
    );
    if let Some(remark) = row.measured.remark.as_ref().filter(|_| !row.measured.kept) {
        let _ = write!(text, "\n    {remark}");
    }
    text
}

/// The table as Markdown, a section for each group.
pub fn markdown(report: &Report) -> String {
    let rows = &report.rows;
    let mut text = format!(
        "# Faults injected\n\n{} kinds; every promise kept in {} of them. Seed {}, {:.0} s on the clock.\n",
        rows.len(),
        report.kept(),
        report.seed,
        rows.iter().map(|row| row.measured.seconds).sum::<f64>()
    );
    let mut group = None;
    for row in rows {
        if group.replace(row.group) != Some(row.group) {
            let _ = write!(
                text,
                "\n### {}\n\n| fault | injected | reaction | promised | worst / median | tries | lost | |\n|---|---|---|---|---|---|---|---|\n",
                row.group.title()
            );
        }
        let flags: Vec<String> = row.flags.iter().map(|flag| format!("`{flag}`")).collect();
        let flags = if flags.is_empty() { String::new() } else { format!(" ({})", flags.join(", ")) };
        let remark =
            row.measured.remark.as_deref().filter(|_| !row.measured.kept).map(|r| format!(": {r}")).unwrap_or_default();
        let _ = writeln!(
            text,
            "| `{}`{flags} | {} | {} | {} | {} | {} | {} | {}{} |",
            row.name,
            row.injected,
            row.expected,
            promised(row),
            observed(row),
            row.measured.tries,
            row.lost,
            verdict(row),
            remark.replace('|', "/").replace('\n', " ")
        );
    }
    text
}
