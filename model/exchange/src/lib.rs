//! Recordings out to the formats other tools read, and foreign ones in.
//!
//! A [`Table`] is anything with cycles of channels: a session in a file, or one that [`Imported`] makes of a CSV recording. Its
//! cycles go, one by one and in bounded memory, into CSV files of the contract's columns ([`csv`]), into Parquet with every
//! field ([`parquet`]) or into a session ([`session`]).
//!
//! # Example
//! A recording of another laboratory becomes a session that every other tool reads:
//! ```
//! use sinew_exchange::{Imported, session};
//! use sinew_recording::session::{About, Session};
//! use sinew_recording::{Options, read_from};
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("monday.mcap");
//! let csv = "time_s,duty,force_n\n0.00,0.0,1.9\n0.01,0.4,2.0\n0.02,0.4,2.1\n";
//! let recording = read_from(csv.as_bytes(), "monday.csv", &Options::default())?;
//! let about = About {
//!     rig: "bench".into(),
//!     software: "their program".into(),
//! #     kind: String::new(),
//! #     rate_hz: 0.0,
//! #     simulated: false,
//! #     started_unix_ns: 0,
//! #     started_monotonic_ns: 0,
//! #     rig_toml: None,
//! #     extra: Default::default(),
//!     // and when it was recorded
//! };
//! let table = Imported::new(recording, "wire", about)?;
//! assert_eq!(session(&table, &path)?, 3);
//! assert_eq!(Session::open(&path)?.cycle_count(), 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod csv;
mod import;
#[cfg(feature = "parquet")]
mod parquet;
mod session;
mod table;

pub use csv::{CsvFile, csv};
pub use import::{IMPORT, Imported};
#[cfg(feature = "parquet")]
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
