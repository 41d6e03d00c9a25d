//! Columns of numbers between Python and Rust, as bytes of little-endian `f64`; and what a function of the analysis is given.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;
use sinew_recording::{Options, Recording};
use sinew_rig::{Catalogue, Channel, Rig};

use crate::failure::{bad_input, of_recording, of_rig};

/// A column by its name, as Python has it after a call.
pub type Column<'py> = (String, Bound<'py, PyBytes>);

/// The bytes of these numbers.
pub fn bytes<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    PyBytes::new(py, &bytes)
}

/// A recording as its columns, its time first.
pub fn columns_of<'py>(py: Python<'py>, recording: &Recording) -> Vec<Column<'py>> {
    let time = std::iter::once((sinew_recording::TIME.to_string(), bytes(py, recording.time_s())));
    time.chain(recording.columns().map(|(column, values)| (column.name().to_string(), bytes(py, values)))).collect()
}

/// A rig file: a path, or its text.
#[derive(FromPyObject)]
pub enum RigFile {
    /// Text, which has lines; or a path.
    #[pyo3(transparent)]
    Text(String),
    /// A path as `pathlib` has it.
    #[pyo3(transparent)]
    Path(PathBuf),
}

impl RigFile {
    /// Reads it, with laws of one's own.
    pub fn read(&self, catalogue: Option<&RigFile>) -> PyResult<Rig> {
        let laws = catalogue.map(|file| match file.text() {
            Ok(text) => Catalogue::parse(text, "catalogue"),
            Err(path) => Catalogue::load(path),
        });
        let laws = laws.transpose().map_err(|error| of_rig(&error))?.unwrap_or_default();
        let rig = match self.text() {
            Ok(text) => Rig::parse_with(text, "rig", &laws),
            Err(path) => Rig::load_with(path, &laws),
        };
        rig.map_err(|error| of_rig(&error))
    }

    /// Its text, or the path to it. No path has lines, and every rig file has.
    fn text(&self) -> Result<&str, &Path> {
        match self {
            RigFile::Text(text) if text.contains('\n') => Ok(text),
            RigFile::Text(path) => Err(Path::new(path)),
            RigFile::Path(path) => Err(path),
        }
    }
}

/// What was recorded: a file, or a name and columns.
#[derive(FromPyObject)]
pub enum Recorded {
    /// A file that the program reads as well.
    #[pyo3(transparent)]
    File(PathBuf),
    /// Columns in memory.
    #[pyo3(transparent)]
    Columns((String, Vec<(String, PyBackedBytes)>)),
}

impl Recorded {
    /// Reads it as the command line does: by the one reader of recordings, with the rig's names and units of columns.
    pub fn read(&self, options: &Options<'_>) -> PyResult<Recording> {
        let read = match self {
            Recorded::File(path) => sinew_recording::read(path, options),
            Recorded::Columns((name, columns)) => {
                sinew_recording::read_from(text(name, columns)?.as_bytes(), name, options)
            }
        };
        read.map_err(|error| of_recording(&error))
    }
}

/// Columns as the text of a CSV file, digit for digit.
fn text(name: &str, columns: &[(String, PyBackedBytes)]) -> PyResult<String> {
    let rows = columns.first().map_or(0, |(_, bytes)| bytes.len() / size_of::<f64>());
    if let Some((column, bytes)) = columns.iter().find(|(_, bytes)| bytes.len() != rows * size_of::<f64>()) {
        let found = bytes.len() / size_of::<f64>();
        return Err(bad_input(
            &format!("{name}: column {column:?} has {found} samples and the first one {rows}"),
            "give every column as many samples as there are times",
        ));
    }
    if let Some((column, _)) = columns.iter().find(|(column, _)| column.contains(['"', '\n', '\r'])) {
        return Err(bad_input(&format!("{name}: {column:?} is no name of a column"), "rename it"));
    }
    let mut text = columns.iter().map(|(column, _)| format!("\"{column}\"")).collect::<Vec<_>>().join(",") + "\n";
    for row in 0..rows {
        for (at, (_, bytes)) in columns.iter().enumerate() {
            let mut eight = [0; size_of::<f64>()];
            eight.copy_from_slice(&bytes[row * size_of::<f64>()..][..size_of::<f64>()]);
            let value = f64::from_le_bytes(eight);
            text += if at > 0 { "," } else { "" };
            // a missing sample is an empty cell
            if !value.is_nan() {
                text += &format!("{value:?}");
            }
        }
        text.push('\n');
    }
    Ok(text)
}

/// The channel that is meant: the named one, or the only one.
pub fn channel(rig: &Rig, name: Option<&str>) -> PyResult<usize> {
    rig.chosen(name).map_err(|error| bad_input(&error.to_string(), &error.remedy("channel=")))
}

/// How a recording of this channel is read.
pub fn options<'a>(rig: &'a Rig, channel: &'a Channel, ignore_columns: bool, max_rows: usize) -> Options<'a> {
    Options {
        ignore_columns,
        columns: Some(&rig.recording.columns),
        model: Some(&channel.model),
        max_rows,
        channel: Some(&channel.name),
    }
}
