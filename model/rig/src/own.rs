//! Physics that users write, in a rig file and in a catalogue of their own: `[channel.effects."own.NAME"]` with a formula.

use std::path::Path;

use sinew_physics::effects::{Definition, Entry, Law, OwnParameter, OwnRole, OwnState};
use toml_edit::{Array, TableLike};

use crate::edit::{put, table_if};
use crate::error::{Error, What};
use crate::notes::Reader;
use crate::tree::{self, Node, Table, Tree};
use crate::value::{not_a_choice, number, unknown_hint};

/// Ids of laws that users write begin with this.
pub(crate) const OWN: &str = "own.";
/// The keys of a definition; every other key of its table is the value of a parameter.
pub(crate) const DEFINITION: [&str; 5] = ["says", "enters", "formula", "parameters", "states"];
const PARAMETER: [&str; 6] = ["unit", "null", "default", "range", "plausible", "about"];
const STATE: [&str; 3] = ["unit", "start", "rate"];

/// A laboratory's own candidates: laws that stand in a file, for any rig.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Catalogue {
    pub(crate) file: String,
    pub(crate) laws: Vec<SameLaw>,
}

/// A law, which is kept once: the same one is at the same place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SameLaw(pub(crate) &'static Law);

impl PartialEq for SameLaw {
    fn eq(&self, other: &SameLaw) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Catalogue {
    /// Reads a file of `[effects."own.NAME"]` tables.
    ///
    /// # Errors
    /// [`Error::Unreadable`], or [`Error::Invalid`] with every mistake found.
    pub fn load(path: &Path) -> Result<Catalogue, Error> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Catalogue::parse(&text, &file),
            Err(error) => Err(Error::Unreadable { file, reason: error.to_string() }),
        }
    }

    /// Reads the text of such a file; `file` is what messages call it.
    ///
    /// # Errors
    /// [`Error::Invalid`] with every mistake found, each with its line, its key and what would be right.
    pub fn parse(text: &str, file: &str) -> Result<Catalogue, Error> {
        let mut reader = Reader::new(file);
        let mut laws = Vec::new();
        match tree::parse(text.strip_prefix('\u{feff}').unwrap_or(text)) {
            Err(errors) => {
                for (line, message) in errors {
                    reader.problem(line, None, "", What::Syntax { message: format!("not TOML: {message}") });
                }
            }
            Ok(root) => {
                for (name, node) in root.iter().filter(|(name, _)| *name != "effects") {
                    let hint = unknown_hint(name, "", ["effects"]);
                    reader.problem(node.line, None, name.as_str(), What::Unknown { hint });
                }
                let effects = root.get("effects").and_then(|node| {
                    reader.table(node, None, "effects", "[effects.\"own.NAME\"]").map(|table| (node.line, table))
                });
                match effects {
                    Some((_, table)) => laws.extend(table.iter().filter_map(|(id, node)| entry(&mut reader, id, node))),
                    None if reader.found() == 0 => {
                        let expected = "at least one table [effects.\"own.NAME\"] with a formula".into();
                        reader.problem(1, None, "effects", What::Missing { expected });
                    }
                    None => {}
                }
            }
        }
        match reader.into_problems() {
            problems if problems.is_empty() => Ok(Catalogue { file: file.into(), laws }),
            problems => Err(Error::Invalid { problems }),
        }
    }

    /// Ids of its laws.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.laws.iter().map(|law| law.0.id())
    }
}

/// A law of a catalogue.
fn entry(reader: &mut Reader<'_>, id: &str, node: &Node) -> Option<SameLaw> {
    let path = format!("effects.\"{id}\"");
    let table = reader.table(node, None, &path, &format!("[{path}]"))?;
    let Some(name) = id.strip_prefix(OWN) else {
        let hint = "; ids in a catalogue of one's own begin with own., such as [effects.\"own.slipstream\"]".into();
        reader.problem(node.line, None, path, What::Unknown { hint });
        return None;
    };
    for (key, node) in table.iter().filter(|(key, _)| !DEFINITION.contains(&key.as_str())) {
        let hint = unknown_hint(key, "", DEFINITION);
        reader.problem(node.line, None, format!("{path}.{key}"), What::Unknown { hint });
    }
    law(reader, None, &path, name, node.line, table).map(SameLaw)
}

/// Reads the definition in a table, at `path`, of the law called `name`.
pub(crate) fn law(
    reader: &mut Reader<'_>,
    label: Option<&str>,
    path: &str,
    name: &str,
    header: usize,
    table: &Table,
) -> Option<&'static Law> {
    let before = reader.found();
    let mut within = Within { reader, label, path, header };
    let says = within.text(table, "says", "a sentence: what it does");
    let words = Entry::ALL.map(|(_, word, ..)| word);
    let enters = within.text(table, "enters", &format!("where it enters: {}", words.join(", ")));
    let entry = enters.as_ref().and_then(|enters| {
        let found = Entry::ALL.iter().find(|(_, word, ..)| word == enters).map(|(entry, ..)| *entry);
        if found.is_none() {
            within.problem(table, "enters", not_a_choice(enters, &words));
        }
        found
    });
    let formula = within.text(table, "formula", "the term as a formula, such as \"-gain * velocity\"");
    let parameters = within.each(table, "parameters", &PARAMETER, |within, key, table| within.parameter(key, table));
    let states = within.each(table, "states", &STATE, |within, key, table| within.state(key, table));
    let (Some(says), Some(enters), Some(formula)) = (says, entry, formula) else { return None };
    if within.reader.found() > before {
        return None;
    }
    let definition = Definition { name: name.into(), says, enters, formula, parameters, states };
    match Law::new(definition) {
        Ok(law) => Some(law),
        Err(undefined) => {
            // the nearest table or key that is written
            let mut line = header;
            let mut at = Some(table);
            for part in undefined.part.split('.') {
                let Some(node) = at.and_then(|table| table.get(part)) else { break };
                line = node.line;
                at = if let Tree::Table(inner) = &node.value { Some(inner) } else { None };
            }
            let key = if undefined.part.is_empty() { path.into() } else { format!("{path}.{}", undefined.part) };
            let message = format!("is wrong: {}", undefined.what);
            within.reader.problem(line, label, key, What::Contradiction { message });
            None
        }
    }
}

/// The table of a definition, or one within it.
struct Within<'a, 'r> {
    reader: &'a mut Reader<'r>,
    label: Option<&'a str>,
    path: &'a str,
    header: usize,
}

impl Within<'_, '_> {
    fn problem(&mut self, table: &Table, key: &str, what: What) {
        let line = table.get(key).map_or(self.header, |node| node.line);
        self.reader.problem(line, self.label, format!("{}.{key}", self.path), what);
    }

    fn text(&mut self, table: &Table, key: &str, expected: &str) -> Option<String> {
        let what = match table.get(key).map(|node| &node.value) {
            Some(Tree::Text(text)) if !text.trim().is_empty() => return Some(text.trim().to_string()),
            Some(other) => What::WrongType { found: other.describe(), expected: expected.into() },
            None => What::Missing { expected: expected.into() },
        };
        self.problem(table, key, what);
        None
    }

    fn number(&mut self, table: &Table, key: &str, expected: &str) -> Option<f64> {
        let found = table.get(key).map(|node| number(node, expected));
        match found {
            Some(Ok(found)) => return Some(found),
            Some(Err(what)) => self.problem(table, key, what),
            None => self.problem(table, key, What::Missing { expected: expected.into() }),
        }
        None
    }

    /// Two numbers.
    fn pair(&mut self, table: &Table, key: &str) -> Option<(f64, f64)> {
        let expected = "two numbers, such as [0.0, 10.0]".to_string();
        let what = match table.get(key).map(|node| &node.value) {
            Some(Tree::Array(nodes)) if nodes.len() == 2 => {
                match (number(&nodes[0], &expected), number(&nodes[1], &expected)) {
                    (Ok(low), Ok(high)) => return Some((low, high)),
                    (Err(what), _) | (_, Err(what)) => what,
                }
            }
            Some(other) => What::WrongType { found: other.describe(), expected },
            None => What::Missing { expected },
        };
        self.problem(table, key, what);
        None
    }

    /// Every table in the table `name`, each with keys of these only.
    fn each<T>(
        &mut self,
        table: &Table,
        name: &str,
        keys: &[&'static str],
        read: impl Fn(&mut Within<'_, '_>, &str, &Table) -> Option<T>,
    ) -> Vec<T> {
        let Some(node) = table.get(name) else { return Vec::new() };
        let path = format!("{}.{name}", self.path);
        let Some(tables) = self.reader.table(node, self.label, &path, &format!("[{path}.KEY]")) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        for (key, node) in tables {
            let path = format!("{path}.{key}");
            let Some(inner) = self.reader.table(node, self.label, &path, &format!("[{path}]")) else { continue };
            let mut within = Within { reader: self.reader, label: self.label, path: &path, header: node.line };
            for (key, _) in inner.iter().filter(|(key, _)| !keys.contains(&key.as_str())) {
                let hint = unknown_hint(key, "", keys.iter().copied());
                within.problem(inner, key, What::Unknown { hint });
            }
            found.extend(read(&mut within, key, inner));
        }
        found
    }

    fn parameter(&mut self, key: &str, table: &Table) -> Option<OwnParameter> {
        let unit = self.text(table, "unit", "its unit, such as \"W/(m² K)\"; \"1\" where it has none");
        let range = self.pair(table, "range");
        let plausible = if table.contains_key("plausible") { self.pair(table, "plausible") } else { range };
        let about = self.text(table, "about", "what it is");
        let role = match (table.contains_key("null"), table.contains_key("default")) {
            (true, false) => {
                self.number(table, "null", "where the effect vanishes").map(|null| OwnRole::Switch { null })
            }
            (false, true) => {
                self.number(table, "default", "its value where none is given").map(|default| OwnRole::Shape { default })
            }
            (true, true) => {
                let message = "has a null and a default, expected one of them: null where it turns the effect on \
                               and off, default where it says how the effect acts";
                self.problem(table, "default", What::Contradiction { message: message.into() });
                None
            }
            (false, false) => {
                let expected = "the value where the effect vanishes; or `default`, where this only says how it acts";
                self.problem(table, "null", What::Missing { expected: expected.into() });
                None
            }
        };
        let key = key.to_string();
        Some(OwnParameter { key, unit: unit?, role: role?, range: range?, plausible: plausible?, about: about? })
    }

    fn state(&mut self, key: &str, table: &Table) -> Option<OwnState> {
        let unit = self.text(table, "unit", "its unit, such as \"K\"");
        let start = self.number(table, "start", "its value at the first sample, in its unit");
        let rate = self.text(table, "rate", "its rate as a formula, in its unit per second");
        Some(OwnState { key: key.into(), unit: unit?, start: start?, rate: rate? })
    }
}

/// Two laws of one name that are not the same.
pub(crate) fn another(catalogue: &Catalogue) -> What {
    let message = format!("is defined here and, otherwise, in {}; take one of them out", catalogue.file);
    What::Contradiction { message }
}

/// Writes the definition of a law into its table, where it is not there.
pub(crate) fn write(root: &mut dyn TableLike, path: &[&str], law: &Law) {
    if table_if(root, path).is_some_and(|table| table.contains_key("formula")) {
        return;
    }
    let Definition { says, enters, formula, parameters, states, .. } = &law.definition;
    put(root, path, "says", says.as_str().into());
    put(root, path, "enters", enters.word().into());
    put(root, path, "formula", formula.as_str().into());
    let pair = |(low, high): (f64, f64)| toml_edit::Value::Array(Array::from_iter([low, high]));
    for parameter in parameters {
        let path = [path, &["parameters", &parameter.key]].concat();
        put(root, &path, "unit", parameter.unit.as_str().into());
        match parameter.role {
            OwnRole::Switch { null } => put(root, &path, "null", null.into()),
            OwnRole::Shape { default } => put(root, &path, "default", default.into()),
        }
        put(root, &path, "range", pair(parameter.range));
        put(root, &path, "plausible", pair(parameter.plausible));
        put(root, &path, "about", parameter.about.as_str().into());
    }
    for state in states {
        let path = [path, &["states", &state.key]].concat();
        put(root, &path, "unit", state.unit.as_str().into());
        put(root, &path, "start", state.start.into());
        put(root, &path, "rate", state.rate.as_str().into());
    }
}
