//! Recordings out to the formats other tools read, and foreign ones in.
//!
//! A [`Table`] is anything with cycles of channels: a session in a file, or one that [`Imported`] makes of a CSV recording. Its
//! cycles go, one by one and in bounded memory, into CSV files of the contract's columns ([`csv`]), into Parquet with every
//! field ([`parquet`]) or into a session ([`session`]).
#![forbid(unsafe_code)]

mod csv;
mod import;
mod parquet;
mod session;
mod table;

pub use csv::{CsvFile, csv};
pub use import::{IMPORT, Imported};
pub use parquet::{GROUP_BYTES, parquet};
pub use session::session;
pub use table::{Cycle, SessionPart, Table};

use std::path::Path;

use sinew_recording::{Error, What};

/// A file that cannot be written, with the reason.
fn unwritable(path: &Path, error: &dyn std::error::Error) -> Error {
    let what = What::Unwritable { reason: error.to_string() };
    Error { file: path.display().to_string(), line: None, column: None, what }
}
