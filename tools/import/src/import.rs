//! A table by a mapping: a recording.

use std::path::Path;

use sinew_physics::WireModel;
use sinew_recording::{Options, Recording, read_table};
use sinew_rig::Mapping;

use crate::table::{ROW_NUMBER, Table};

/// The recording that a mapping makes of a table. Columns that it does not name are passed over; one that it names must be there.
///
/// # Errors
/// What every recording is refused for, with the line of the file: [`sinew_recording::read()`].
pub fn recording(
    path: &Path,
    table: &Table,
    mapping: &Mapping,
    model: Option<&WireModel>,
) -> Result<Recording, sinew_recording::Error> {
    let mut header: Vec<String> = table.columns.iter().map(|column| column.name.clone()).collect();
    let mut columns: Vec<&[f64]> = table.columns.iter().map(|column| column.values.as_slice()).collect();
    let numbers: Vec<f64> = (0..table.len()).map(|row| row as f64).collect();
    if table.column(ROW_NUMBER).is_none() {
        header.push(ROW_NUMBER.into());
        columns.push(&numbers);
    }
    let options = Options { ignore_columns: true, columns: Some(&mapping.columns), model, ..Options::default() };
    let line = |row: usize| table.lines.get(row).map(|line| *line as u64);
    read_table(&path.display().to_string(), &header, &columns, line, &options)
}
