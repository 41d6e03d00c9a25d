//! What reading a rig file notes: where it says what, and every mistake with its line and its key.

use std::collections::BTreeMap;

use crate::error::{Problem, What};
use crate::tree::{Node, Table, Tree};

/// Table, without the `channel.` before it, and key.
pub(crate) type Place = (&'static str, &'static str);

/// What a file gives itself, with lines.
pub(crate) type Given = BTreeMap<Place, usize>;

/// What checks know of a table of the rig or of a channel beside its values.
pub(crate) struct Stated<'n> {
    pub given: Given,
    /// The line that stands for what is not given.
    pub header: usize,
    /// What messages call the channel; `None` where it is no channel's.
    pub label: Option<String>,
    pub table: &'n Table,
    /// Whether nothing was wrong with it, key by key.
    pub right: bool,
}

impl Stated<'_> {
    /// Whether the file gives a key itself.
    pub(crate) fn gives(&self, table: &'static str, key: &'static str) -> bool {
        self.given.contains_key(&(table, key))
    }

    /// Whether the file has a table of this name in this one.
    pub(crate) fn has_table(&self, name: &str) -> bool {
        self.table.contains_key(name)
    }

    /// The line of the first of some keys that is given.
    pub(crate) fn line_of_first(&self, places: &[Place]) -> usize {
        places.iter().find_map(|place| self.given.get(place).copied()).unwrap_or(self.header)
    }

    /// The line of what stands at a path, or of the nearest thing above it.
    pub(crate) fn line_at(&self, path: &[&str]) -> usize {
        line_at(self.table, self.header, path.iter().copied())
    }

    pub(crate) fn label(&self) -> Option<&str> {
        self.label.as_deref()
    }
}

/// Reads a file, noting its mistakes; the walk through its tables is in [`crate::read`].
pub(crate) struct Reader<'a> {
    file: &'a str,
    problems: Vec<Problem>,
}

impl<'a> Reader<'a> {
    /// With no mistake noted yet; `file` is what messages call the file.
    pub(crate) fn new(file: &'a str) -> Reader<'a> {
        Reader { file, problems: Vec::new() }
    }

    /// The mistakes in the order of their lines.
    pub(crate) fn into_problems(mut self) -> Vec<Problem> {
        self.problems.sort_by_key(|p| p.line);
        self.problems
    }

    /// Notes a mistake.
    pub(crate) fn problem(&mut self, line: usize, channel: Option<&str>, key: impl Into<String>, what: What) {
        let (file, channel) = (self.file.to_string(), channel.map(str::to_string));
        self.problems.push(Problem { file, line, channel, key: key.into(), what });
    }

    /// How many mistakes were found so far.
    pub(crate) fn found(&self) -> usize {
        self.problems.len()
    }

    /// Whether one was found in a line, of a key that begins like this.
    pub(crate) fn found_in(&self, line: usize, prefix: &str) -> bool {
        self.problems.iter().any(|p| p.line == line && p.key.starts_with(prefix))
    }

    /// Notes that a key makes no sense, where it is given.
    pub(crate) fn out_of_place(&mut self, stated: &Stated<'_>, place: Place, message: impl Into<String>) {
        if stated.given.contains_key(&place) {
            self.contradiction(stated, &[place], message.into());
        }
    }

    /// Notes that keys stand against each other, at the first of them that is given.
    pub(crate) fn contradiction(&mut self, stated: &Stated<'_>, places: &[Place], message: String) {
        let given = places.iter().find(|place| stated.given.contains_key(*place));
        let (table, key) = given.unwrap_or(&places[0]);
        let line = stated.line_of_first(places);
        self.problem(line, stated.label(), format!("{table}.{key}"), What::Contradiction { message });
    }

    /// The table that stands here, which can only be one.
    pub(crate) fn table<'n>(
        &mut self,
        node: &'n Node,
        channel: Option<&str>,
        key: &str,
        header: &str,
    ) -> Option<&'n Table> {
        if let Tree::Table(table) = &node.value {
            return Some(table);
        }
        let (found, expected) = (node.value.describe(), format!("a table: {header}"));
        self.problem(node.line, channel, key, What::WrongType { found, expected });
        None
    }
}

/// The line of what stands at a path, or of the nearest thing above it.
pub(crate) fn line_at<'p>(table: &Table, header: usize, path: impl IntoIterator<Item = &'p str>) -> usize {
    let (mut line, mut table) = (header, table);
    for part in path {
        let Some(node) = table.get(part) else { break };
        line = node.line;
        let Tree::Table(inner) = &node.value else { break };
        table = inner;
    }
    line
}

/// A number as one would write it: conversions between units leave dust in the last digits.
pub(crate) fn tidy(n: f64) -> f64 {
    format!("{n:.9e}").parse().unwrap_or(n)
}
