//! The walk through plain tables, which knows no key: it goes by what [`crate::tables`] say of them.

use crate::error::What;
use crate::key::{Default, Section};
use crate::notes::{Given, Reader, Stated};
use crate::tables::{sensors, tables_with};
use crate::tree::{Node, Table, Tree};
use crate::value::{self, value};

impl Reader<'_> {
    /// Reads a plain table into `target` and applies its defaults. `others` are sub-tables read elsewhere.
    /// Gives the keys that were there; those with a mistake too, so that no default talks over it.
    pub(crate) fn section<T: 'static>(
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
    pub(crate) fn keys<T: 'static>(
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
    pub(crate) fn belonging<T: 'static>(&mut self, section: &'static Section<T>, target: &T, stated: &Stated<'_>) {
        for key in section.keys() {
            if let Some(message) = key.out_of_place(target) {
                self.out_of_place(stated, (section.local(), key.name), message);
            }
        }
        if let Some(check) = &section.check {
            check(self, target, stated);
        }
    }
}

/// What an unknown key of a table was probably meant to be: one that lives in another table, a key of this one, or the
/// list.
fn unknown_hint<'k>(name: &str, table: &str, keys: impl IntoIterator<Item = &'k str>) -> String {
    // What a sensor's noise is called after belongs elsewhere by that name, but is not what was meant here.
    if table != sensors::NOISE
        && let Some(other) = tables_with(name).iter().find(|other| **other != table)
    {
        return format!(" here: it belongs in [{other}]");
    }
    value::unknown_hint(name, table, keys)
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
