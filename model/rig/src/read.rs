//! From the text of a rig file to a [`Rig`], collecting every mistake on the way.

mod channels;
mod joints;
mod walk;

use std::path::Path;

use crate::complete;
use crate::error::{Error, What};
use crate::notes::{Given, Reader, Stated};
use crate::own::Catalogue;
use crate::tables::rig::Source;
use crate::tables::{Mapping, OTHER_TABLES, RIG, Rig, TOP, of_rig, recording, simulation};
use crate::tree::{self, Table};
use crate::value::unknown_hint;
use walk::{descend, within};

/// The rig file of the built-in hexapod.
pub const HEXAPOD_TOML: &str = include_str!("hexapod.toml");

impl Rig {
    /// Reads a rig file.
    ///
    /// # Errors
    /// [`Error::Unreadable`] where the file cannot be read as text, else as [`Rig::parse`].
    pub fn load(path: &Path) -> Result<Rig, Error> {
        Rig::load_with(path, &Catalogue::default())
    }

    /// Reads a rig file, every channel of which has the laws of `catalogue` besides its own, at their null.
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn load_with(path: &Path, catalogue: &Catalogue) -> Result<Rig, Error> {
        Rig::parse_with(&read(path)?, &path.display().to_string(), catalogue)
    }

    /// Reads the text of a rig file; `file` is what messages call it.
    ///
    /// # Errors
    /// [`Error::Invalid`] with every mistake found, each with its line, its key and what would be right.
    pub fn parse(text: &str, file: &str) -> Result<Rig, Error> {
        Rig::parse_with(text, file, &Catalogue::default())
    }

    /// Reads the text of a rig file, every channel of which has the laws of `catalogue` besides its own, at their null.
    ///
    /// # Errors
    /// As [`Rig::parse`].
    pub fn parse_with(text: &str, file: &str, catalogue: &Catalogue) -> Result<Rig, Error> {
        rig(Source { file: file.to_string(), text: text.to_string(), catalogue: catalogue.clone() })
    }

    /// The built-in rig: a hexapod of eighteen wires, three joints to each of six legs.
    ///
    /// # Panics
    /// Never: its text is part of the program and a test reads it.
    pub fn hexapod() -> Rig {
        match Rig::parse(HEXAPOD_TOML, "examples/hexapod.toml") {
            Ok(rig) => rig,
            Err(error) => unreachable!("the built-in rig: {error}"),
        }
    }
}

impl Mapping {
    /// Reads the mapping in a file of its own, which has `[recording.format]` and `[recording.columns]` and nothing else.
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn load(path: &Path) -> Result<Mapping, Error> {
        Mapping::parse(&read(path)?, &path.display().to_string())
    }

    /// Reads the text of such a file; `file` is what messages call it.
    ///
    /// # Errors
    /// As [`Rig::parse`].
    pub fn parse(text: &str, file: &str) -> Result<Mapping, Error> {
        let mut reader = Reader::new(file);
        let tree = parse(&mut reader, text).unwrap_or_default();
        let mut mapping = Mapping::default();
        for (name, node) in &tree {
            if name == "recording" {
                mapping = recording::mapping(&mut reader, node);
            } else {
                let hint =
                    "; a mapping has [recording.format] and [recording.columns], and a rig file is given with --rig";
                reader.problem(node.line, None, name.as_str(), What::Unknown { hint: hint.into() });
            }
        }
        match reader.into_problems() {
            problems if problems.is_empty() => Ok(mapping),
            problems => Err(Error::Invalid { problems }),
        }
    }
}

/// A file as text.
fn read(path: &Path) -> Result<String, Error> {
    let file = path.display().to_string();
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) => return Err(Error::Unreadable { file, reason: error.to_string() }),
    };
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|b| **b == b'\n').count();
        Error::Unreadable { file, reason: format!("line {line} is not UTF-8 text; is this a rig file?") }
    })
}

/// The text as a tree; its mistakes are noted.
fn parse(reader: &mut Reader<'_>, text: &str) -> Option<Table> {
    // A byte-order mark is no mistake; it is cut off only for the parser, lines stay as they are.
    match tree::parse(text.strip_prefix('\u{feff}').unwrap_or(text)) {
        Ok(tree) => Some(tree),
        Err(errors) => {
            for (line, message) in errors {
                reader.problem(line, None, "", What::Syntax { message: format!("not TOML: {message}") });
            }
            None
        }
    }
}

/// Reads a rig file's text.
fn rig(source: Source) -> Result<Rig, Error> {
    let mut reader = Reader::new(&source.file);
    let rig = parse(&mut reader, &source.text).map(|tree| root(&mut reader, &tree, &source.catalogue));
    let problems = reader.into_problems();
    match rig {
        Some(mut rig) if problems.is_empty() => {
            rig.source = source;
            Ok(rig)
        }
        _ => Err(Error::Invalid { problems }),
    }
}

/// Reads the whole file, table by table.
fn root(reader: &mut Reader<'_>, root: &Table, catalogue: &Catalogue) -> Rig {
    for (name, node) in root {
        if !TOP.contains(&name.as_str()) {
            let hint = unknown_hint(name, "", TOP);
            reader.problem(node.line, None, name.as_str(), What::Unknown { hint });
        }
    }
    let mut rig = Rig::unread();
    let mut given = Given::new();
    let paths: Vec<&str> = of_rig().map(|section| section.table).chain(OTHER_TABLES).collect();
    for section in [&*RIG].into_iter().chain(of_rig()) {
        let others = within(&paths, section.table);
        let parent = section.table.rsplit_once('.').and_then(|(parent, _)| descend(root, parent));
        let header = parent.map_or(1, |node| node.line);
        let own = reader.section(section, descend(root, section.table), &others, None, header, &mut rig);
        let stated = Stated { given: own, header, label: None, table: root, right: true };
        reader.belonging(section, &rig, &stated);
        given.extend(stated.given);
    }
    let stated = Stated { given, header: 1, label: None, table: root, right: true };
    complete::rig(reader, &rig, &stated);
    rig.joints = root.get("joint").map_or_else(Vec::new, |node| joints::joints(reader, node));
    let read = channels::channels(reader, root.get("channel"), catalogue, &mut rig);
    if let Some(node) = root.get("joint") {
        complete::joints(reader, node, &mut rig);
    }
    complete::channels(reader, &read, &mut rig);
    complete::demonstrator(reader, &rig, &stated);
    if let Some(node) = root.get("recording") {
        rig.recording = recording::mapping(reader, node);
    }
    if let Some(node) = descend(root, "simulation.fault") {
        let channels: Vec<&str> = rig.channels.iter().map(|channel| channel.name.as_str()).collect();
        rig.simulation.faults = simulation::faults(reader, node, &channels);
    }
    rig
}
