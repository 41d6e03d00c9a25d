//! From the text of a rig file to a [`Rig`], collecting every mistake on the way.
//!
//! Here is the walk through the plain tables, which knows no key; what is special about a table stands in its module of
//! [`crate::tables`].

pub(crate) mod value;

use crate::error::{Error, What};
use crate::key::{Default, Section};
use crate::notes::{Given, Reader, Stated, line_at};
use crate::tables::rig::Source;
use crate::tables::{self, OTHER_TABLES, Rig, TOP, backend, channel, joint, of_rig, recording, simulation};
use crate::tree::{self, Node, Table, Tree};
use value::{unknown_hint, value};

/// Reads a rig file's text.
pub(crate) fn rig(text: &str, file: &str) -> Result<Rig, Error> {
    let mut reader = Reader::new(file);
    // A byte-order mark is no mistake; it is cut off only for the parser, lines stay as they are.
    let rig = match tree::parse(text.strip_prefix('\u{feff}').unwrap_or(text)) {
        Err(errors) => {
            for (line, message) in errors {
                reader.problem(line, None, "", What::Syntax { message: format!("not TOML: {message}") });
            }
            None
        }
        Ok(root) => Some(reader.root(&root)),
    };
    let problems = reader.into_problems();
    match rig {
        Some(mut rig) if problems.is_empty() => {
            rig.source = Source { file: file.to_string(), text: text.to_string() };
            Ok(rig)
        }
        _ => Err(Error::Invalid { problems }),
    }
}

/// The line of a channel's key in a rig's text, or of the nearest thing above it; for checks after reading.
pub(crate) fn line_of(source: &Source, channel: Option<usize>, path: &str) -> usize {
    let Ok(root) = tree::parse(source.text.strip_prefix('\u{feff}').unwrap_or(&source.text)) else { return 1 };
    let (mut line, mut table) = (1, &root);
    if let Some(index) = channel {
        let Some(Node { value: Tree::Array(channels), line: first }) = root.get("channel") else { return line };
        line = *first;
        let Some(Node { value: Tree::Table(t), line: header }) = channels.get(index) else { return line };
        (line, table) = (*header, t);
    }
    line_at(table, line, path.split('.').filter(|p| !p.is_empty()))
}

impl Reader<'_> {
    /// Reads a plain table into `target` and applies its defaults. `others` are sub-tables read elsewhere.
    /// Gives the keys that were there; those with a mistake too, so that no default talks over it.
    pub(crate) fn section<T>(
        &mut self,
        section: &'static Section<T>,
        node: Option<&Node>,
        others: &[&str],
        channel: Option<&str>,
        header: usize,
        target: &mut T,
    ) -> Given {
        match node {
            None if section.optional => Given::new(),
            None => self.keys(section, &Table::new(), others, channel, header, target),
            Some(node) => match self.table(node, channel, section.local(), &format!("[{}]", section.table)) {
                Some(table) => self.keys(section, table, others, channel, node.line, target),
                None => Given::new(),
            },
        }
    }

    /// Reads the keys of a plain table, see [`Reader::section`].
    pub(crate) fn keys<T>(
        &mut self,
        section: &'static Section<T>,
        table: &Table,
        others: &[&str],
        channel: Option<&str>,
        header: usize,
        target: &mut T,
    ) -> Given {
        let table_name = section.local();
        let path = |key: &str| if table_name.is_empty() { key.to_string() } else { format!("{table_name}.{key}") };
        for (name, node) in table {
            if section.key(name).is_none() && !others.contains(&name.as_str()) {
                let keys = section.keys().map(|k| k.name).chain(others.iter().copied());
                let hint = unknown_hint(name, section.table, keys);
                self.problem(node.line, channel, path(name), What::Unknown { hint });
            }
        }
        let mut given = Given::new();
        // In the order of the table: what selects a kind comes before the keys of that kind.
        for key in section.keys() {
            let Some(node) = table.get(key.name) else {
                if let Default::Required(expected) = key.default {
                    self.problem(header, channel, path(key.name), What::Missing { expected: expected.into() });
                    // Said once: what depends on it keeps quiet.
                    given.insert((table_name, key.name), header);
                }
                if let Some(default) = key.fixed_default() {
                    key.set(target, default);
                }
                continue;
            };
            given.insert((table_name, key.name), node.line);
            match value(key, node) {
                Ok(value) => key.set(target, value),
                Err(what) => self.problem(node.line, channel, path(key.name), what),
            }
        }
        given
    }

    /// Notes the keys of a table that mean nothing beside others, and what else the table finds wrong with them.
    pub(crate) fn belonging<T>(&mut self, section: &'static Section<T>, target: &T, stated: &Stated<'_>) {
        for key in section.keys() {
            if let Some(only) = key.only.filter(|_| !key.belongs(target)) {
                self.out_of_place(stated, (section.local(), key.name), (only.otherwise)(target, key.name));
            }
        }
        if let Some(check) = section.check {
            check(self, target, stated);
        }
    }

    fn root(&mut self, root: &Table) -> Rig {
        for (name, node) in root {
            if !TOP.contains(&name.as_str()) {
                let hint = unknown_hint(name, "", TOP);
                self.problem(node.line, None, name.as_str(), What::Unknown { hint });
            }
        }
        let mut rig = Rig::unread();
        let paths: Vec<&str> = of_rig().map(|section| section.table).chain(OTHER_TABLES).collect();
        for section in [&tables::rig::SECTION].into_iter().chain(of_rig()) {
            let others = within(&paths, section.table);
            let parent = section.table.rsplit_once('.').and_then(|(parent, _)| descend(root, parent));
            let header = parent.map_or(1, |node| node.line);
            let given = self.section(section, descend(root, section.table), &others, None, header, &mut rig);
            let stated = Stated { given, header, label: None, table: root, right: true };
            self.belonging(section, &rig, &stated);
        }
        rig.joints = root.get("joint").map_or_else(Vec::new, |node| joint::joints(self, node));
        let read = channel::channels(self, root.get("channel"), &mut rig);
        if let Some(node) = root.get("joint") {
            joint::complete(self, node, &mut rig);
        }
        channel::complete(self, &read, &mut rig);
        for check_channels in backend::CHECKS {
            check_channels(self, &rig, &read);
        }
        if let Some(node) = root.get("recording") {
            rig.columns = recording::columns(self, node);
        }
        if let Some(node) = descend(root, "simulation.fault") {
            rig.simulation.faults = simulation::faults(self, node, &rig.channels);
        }
        rig
    }
}

/// The tables that stand in `table`, of a list of paths.
pub(crate) fn within<'p>(paths: &[&'p str], table: &str) -> Vec<&'p str> {
    let inside = |path: &&'p str| match table {
        "" => Some(*path),
        _ => path.strip_prefix(table)?.strip_prefix('.'),
    };
    paths.iter().filter_map(inside).filter(|path| !path.is_empty() && !path.contains('.')).collect()
}

/// What stands at a path of tables, such as `sensors.noise`.
pub(crate) fn descend<'n>(table: &'n Table, path: &str) -> Option<&'n Node> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(first, rest)| (first, Some(rest)));
    let node = table.get(first)?;
    match (rest, &node.value) {
        (None, _) => Some(node),
        (Some(rest), Tree::Table(inner)) => descend(inner, rest),
        (Some(_), _) => None,
    }
}
