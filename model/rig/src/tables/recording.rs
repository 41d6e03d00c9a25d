//! `[recording.columns]`: how a recording's foreign columns are named and scaled.

use std::collections::BTreeMap;

use toml_edit::{InlineTable, TableLike};

use crate::edit::{put, remove};
use crate::error::What;
use crate::notes::Reader;
use crate::suggest::nearest;
use crate::tree::{Node, Tree};
use crate::value::{number, unknown_hint};

/// The columns a recording can have: the keys of [`ColumnMap`].
pub const RECORDING_COLUMNS: [&str; 13] = [
    "time_s",
    "duty",
    "power_w",
    "temperature_c",
    "supply_v",
    "current_a",
    "v1_v",
    "v2_v",
    "v3_v",
    "force_n",
    "position_m",
    "ambient_c",
    "disturbance_n",
];

/// Where a recording's columns come from, by the contract's column name; columns not listed keep their name.
pub type ColumnMap = BTreeMap<String, Column>;

/// A foreign column: value = `scale` · raw + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in the recording.
    pub column: String,
    /// Factor to the contract's unit; never 0.
    pub scale: f64,
    /// Added after scaling, in the contract's unit.
    pub offset: f64,
}

/// Reads `[recording]`.
pub(crate) fn columns(reader: &mut Reader<'_>, node: &Node) -> ColumnMap {
    let mut columns = ColumnMap::new();
    let Some(table) = reader.table(node, None, "recording", "[recording]") else { return columns };
    for (name, node) in table {
        if name != "columns" {
            let hint = unknown_hint(name, "", ["columns"]);
            reader.problem(node.line, None, format!("recording.{name}"), What::Unknown { hint });
            continue;
        }
        let Some(table) = reader.table(node, None, "recording.columns", "[recording.columns]") else { continue };
        for (name, node) in table {
            let path = format!("recording.columns.{name}");
            if !RECORDING_COLUMNS.contains(&name.as_str()) {
                let hint = match nearest(name, RECORDING_COLUMNS) {
                    Some(near) => format!(", did you mean {near}?"),
                    None => format!("; the columns of a recording are {}", RECORDING_COLUMNS.join(", ")),
                };
                reader.problem(node.line, None, path, What::Unknown { hint });
            } else if let Some(column) = column(reader, node, &path) {
                columns.insert(name.clone(), column);
            }
        }
    }
    columns
}

fn column(reader: &mut Reader<'_>, node: &Node, path: &str) -> Option<Column> {
    let expected = "the foreign column's name, or { column = \"Pos\", scale = -1.0, offset = 0.0 }";
    let table = match &node.value {
        Tree::Text(column) => return Some(Column { column: column.clone(), scale: 1.0, offset: 0.0 }),
        Tree::Table(table) => table,
        other => {
            let (found, expected) = (other.describe(), expected.into());
            reader.problem(node.line, None, path, What::WrongType { found, expected });
            return None;
        }
    };
    let mut column = Column { column: String::new(), scale: 1.0, offset: 0.0 };
    for (name, node) in table {
        if let Err(what) = column_key(&mut column, name, node) {
            reader.problem(node.line, None, format!("{path}.{name}"), what);
        }
    }
    if !table.contains_key("column") {
        let expected = "the foreign column's name".into();
        reader.problem(node.line, None, format!("{path}.column"), What::Missing { expected });
    }
    Some(column)
}

fn column_key(column: &mut Column, name: &str, node: &Node) -> Result<(), What> {
    match (name, &node.value) {
        ("column", Tree::Text(text)) => column.column = text.clone(),
        ("column", other) => {
            return Err(What::WrongType { found: other.describe(), expected: "the column's name".into() });
        }
        ("scale", _) => {
            column.scale = number(node, "a number other than 0")?;
            if column.scale == 0.0 {
                let message = "is 0, expected the factor from the foreign unit to the contract's".into();
                return Err(What::Contradiction { message });
            }
        }
        ("offset", _) => column.offset = number(node, "a number")?,
        _ => return Err(What::Unknown { hint: unknown_hint(name, "", ["column", "scale", "offset"]) }),
    }
    Ok(())
}

/// Writes the columns that differ from those of `base`.
pub(crate) fn write_columns(root: &mut dyn TableLike, columns: &ColumnMap, base: Option<&ColumnMap>) {
    let path = ["recording", "columns"];
    let nothing = ColumnMap::new();
    let old = base.unwrap_or(&nothing);
    for name in old.keys().filter(|name| !columns.contains_key(*name)) {
        remove(root, &path, name);
    }
    for (name, column) in columns.iter().filter(|(name, column)| old.get(*name) != Some(column)) {
        let mut table = InlineTable::new();
        table.insert("column", column.column.as_str().into());
        table.insert("scale", column.scale.into());
        table.insert("offset", column.offset.into());
        put(root, &path, name, table.into());
    }
}
