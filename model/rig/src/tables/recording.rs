//! `[recording]`: how a foreign recording is written, and how its columns are named and scaled.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use toml_edit::{InlineTable, TableLike, Value};

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

/// How a foreign file is written, where that is not to be found out anew: `[recording.format]`. What is `None` is found out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileFormat {
    /// Name of the text's encoding, such as `windows-1252`.
    pub encoding: Option<String>,
    /// What stands between cells: one character, or `blanks` for any number of them.
    pub separator: Option<String>,
    /// The decimal sign: `.` or `,`.
    pub decimal: Option<String>,
    /// Order of the parts of a date: `dmy`, `mdy` or `ymd`.
    pub dates: Option<String>,
    /// Sheet of a spreadsheet, group of a TDMS file.
    pub sheet: Option<String>,
    /// Line (of a spreadsheet: row) on which the names begin, counted from 1; 0 = there are no names.
    pub header_line: Option<usize>,
    /// Line of the first row of numbers.
    pub first_line: Option<usize>,
}

impl FileFormat {
    /// Keys of the table with what each takes.
    pub const KEYS: [(&str, &str); 7] = [
        ("encoding", "the name of the text's encoding, such as \"windows-1252\""),
        ("separator", "what stands between cells: \";\", \",\", \"\\t\", \"|\" or \"blanks\""),
        ("decimal", "\".\" or \",\""),
        ("dates", "\"dmy\", \"mdy\" or \"ymd\""),
        ("sheet", "the name of the sheet"),
        ("header_line", "the line on which the names begin, 0 where there are none"),
        ("first_line", "the line of the first row of numbers"),
    ];

    fn text(&mut self, name: &str) -> Option<&mut Option<String>> {
        Some(match name {
            "encoding" => &mut self.encoding,
            "separator" => &mut self.separator,
            "decimal" => &mut self.decimal,
            "dates" => &mut self.dates,
            "sheet" => &mut self.sheet,
            _ => return None,
        })
    }

    fn line(&mut self, name: &str) -> Option<&mut Option<usize>> {
        Some(match name {
            "header_line" => &mut self.header_line,
            "first_line" => &mut self.first_line,
            _ => return None,
        })
    }

    /// What is given, by key, as it is written.
    fn given(&self) -> impl Iterator<Item = (&'static str, Value)> + use<> {
        let mut own = self.clone();
        FileFormat::KEYS.into_iter().filter_map(move |(name, _)| {
            let text = own.text(name).and_then(|text| text.take()).map(Value::from);
            let line = || own.line(name).and_then(|line| line.take()).map(|line| (line as i64).into());
            Some((name, text.or_else(line)?))
        })
    }
}

/// `[recording]` whole: how a foreign file is written, and what its columns are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mapping {
    /// How the file is written.
    pub format: FileFormat,
    /// What its columns are.
    pub columns: ColumnMap,
}

impl Mapping {
    /// The mapping as the text of a file, `head` as comments above it, `remarks` as comments above the columns they are about.
    /// Remarks of columns that are not mapped stand below.
    pub fn to_toml(&self, head: &[String], remarks: &[(String, String)]) -> String {
        let mut text = String::new();
        let comment = |text: &mut String, words: &str| {
            // one line each: a line break or another control character must not end the comment
            let words: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let _ = writeln!(text, "# {words}");
        };
        head.iter().for_each(|words| comment(&mut text, words));
        let mut given = self.format.given().peekable();
        if given.peek().is_some() {
            text += "[recording.format]\n";
        }
        for (name, value) in given {
            let _ = writeln!(text, "{name} = {value}");
        }
        text += if text.is_empty() { "[recording.columns]\n" } else { "\n[recording.columns]\n" };
        let names = RECORDING_COLUMNS.into_iter().filter(|name| self.columns.contains_key(*name));
        for name in names {
            remarks.iter().filter(|(of, _)| of == name).for_each(|(_, words)| comment(&mut text, words));
            let _ = writeln!(text, "{name} = {}", inline(&self.columns[name]));
        }
        let others: Vec<_> = remarks.iter().filter(|(of, _)| !self.columns.contains_key(of)).collect();
        if !others.is_empty() {
            text.push('\n');
        }
        others.iter().for_each(|(_, words)| comment(&mut text, words));
        text
    }
}

/// Reads `[recording]`.
pub(crate) fn mapping(reader: &mut Reader<'_>, node: &Node) -> Mapping {
    let mut mapping = Mapping::default();
    let Some(table) = reader.table(node, None, "recording", "[recording]") else { return mapping };
    for (name, node) in table {
        match name.as_str() {
            "format" => mapping.format = format(reader, node),
            "columns" => mapping.columns = columns(reader, node),
            _ => {
                let hint = unknown_hint(name, "", ["columns", "format"]);
                reader.problem(node.line, None, format!("recording.{name}"), What::Unknown { hint });
            }
        }
    }
    mapping
}

fn format(reader: &mut Reader<'_>, node: &Node) -> FileFormat {
    let mut format = FileFormat::default();
    let Some(table) = reader.table(node, None, "recording.format", "[recording.format]") else { return format };
    for (name, node) in table {
        if let Err(what) = format_key(&mut format, name, node) {
            reader.problem(node.line, None, format!("recording.format.{name}"), what);
        }
    }
    format
}

fn format_key(format: &mut FileFormat, name: &str, node: &Node) -> Result<(), What> {
    let Some((_, expected)) = FileFormat::KEYS.into_iter().find(|(key, _)| *key == name) else {
        return Err(What::Unknown { hint: unknown_hint(name, "", FileFormat::KEYS.map(|(key, _)| key)) });
    };
    let wrong = || Err(What::WrongType { found: node.value.describe(), expected: expected.into() });
    let one = |text: &str| text.chars().count() == 1;
    match (&node.value, name) {
        (Tree::Text(text), "decimal") if !matches!(text.as_str(), "." | ",") => return wrong(),
        (Tree::Text(text), "dates") if !matches!(text.as_str(), "dmy" | "mdy" | "ymd") => return wrong(),
        (Tree::Text(text), "separator") if text != "blanks" && !one(text) => return wrong(),
        (Tree::Text(text), _) => match format.text(name) {
            Some(place) => *place = Some(text.clone()),
            None => return wrong(),
        },
        (Tree::Integer(line), _) => match (format.line(name), usize::try_from(*line)) {
            (Some(place), Ok(line)) => *place = Some(line),
            _ => return wrong(),
        },
        _ => return wrong(),
    }
    Ok(())
}

fn columns(reader: &mut Reader<'_>, node: &Node) -> ColumnMap {
    let mut columns = ColumnMap::new();
    let Some(table) = reader.table(node, None, "recording.columns", "[recording.columns]") else { return columns };
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

/// A column as it is written.
fn inline(column: &Column) -> InlineTable {
    let mut table = InlineTable::new();
    table.insert("column", column.column.as_str().into());
    table.insert("scale", column.scale.into());
    table.insert("offset", column.offset.into());
    table
}

/// Writes what differs from `base`.
pub(crate) fn write_mapping(root: &mut dyn TableLike, mapping: &Mapping, base: Option<&Mapping>) {
    let nothing = Mapping::default();
    let base = base.unwrap_or(&nothing);
    let path = ["recording", "format"];
    let (old, new): (BTreeMap<_, _>, BTreeMap<_, _>) =
        (base.format.given().collect(), mapping.format.given().collect());
    for name in old.keys().filter(|name| !new.contains_key(*name)) {
        remove(root, &path, name);
    }
    let same = |name: &str, value: &Value| old.get(name).is_some_and(|old| old.to_string() == value.to_string());
    for (name, value) in new.into_iter().filter(|(name, value)| !same(name, value)) {
        put(root, &path, name, value);
    }
    let path = ["recording", "columns"];
    let (old, new) = (&base.columns, &mapping.columns);
    for name in old.keys().filter(|name| !new.contains_key(*name)) {
        remove(root, &path, name);
    }
    for (name, column) in new.iter().filter(|(name, column)| old.get(*name) != Some(column)) {
        put(root, &path, name, inline(column).into());
    }
}
