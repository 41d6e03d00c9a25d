//! What every kind of file becomes: named columns of numbers.

use sinew_rig::FileFormat;

/// A file as named columns of numbers of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What the file is, in words: `text, windows-1252, columns separated by ";"`.
    pub kind: String,
    /// The columns, in the file's order; all as long.
    pub columns: Vec<Column>,
    /// How the file is written, as far as it had to be found out.
    pub format: FileFormat,
    /// Samples a second, where the file says so beside its columns, and in which words.
    pub rate_hz: Option<(f64, String)>,
    /// What was passed over, and where.
    pub notes: Vec<String>,
    /// Line (row) of the file that each row stands in; empty where there are no lines.
    pub lines: Vec<usize>,
}

/// A column as it stands in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, made unique; what a mapping calls it.
    pub name: String,
    /// Its unit, where the file has it apart from the name.
    pub unit: Option<String>,
    /// Its numbers, NaN where a sample is missing. Of times of day and dates: seconds since the first.
    pub values: Vec<f64>,
    /// Whether it was written as times of day or dates.
    pub clock: bool,
}

/// Name of the column that every file has: the number of the row, from 0. For files whose rows have no times.
pub const ROW_NUMBER: &str = "#";

impl Table {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }
}

/// Gives columns without a name one, and makes names that stand twice unique.
pub(crate) fn name_all(columns: &mut [Column]) {
    for i in 0..columns.len() {
        let (before, rest) = columns.split_at_mut(i);
        let taken = |name: &str| before.iter().any(|column| column.name == name);
        let own = &mut rest[0].name;
        if own.trim().is_empty() {
            *own = format!("column {}", i + 1);
        }
        let (first, mut count) = (own.clone(), 2);
        while taken(own) {
            *own = format!("{first} ({count})");
            count += 1;
        }
    }
}
