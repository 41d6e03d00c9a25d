//! Options of a recording.

use std::path::PathBuf;

use sinew_recording::session::Compression;

use crate::error::Error;

/// Smallest size after which a new file can begin, bytes, and shortest time, s.
const LEAST_FILE: u64 = 1_000_000;
const LEAST_FILE_S: f64 = 1.0;

/// What to record, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// The file; see [`crate::part_path`] for the further ones.
    pub path: PathBuf,
    /// Replace files that are there.
    pub overwrite: bool,
    /// How chunks are compressed.
    pub compression: Compression,
    /// Stop after so long, s; `None` = never.
    pub duration_s: Option<f64>,
    /// Begin a new file before the present one is larger than this, bytes.
    pub max_bytes: Option<u64>,
    /// Begin a new file when the present one is so long, s.
    pub max_file_s: Option<f64>,
    /// What may wait to be written, bytes; `None` = five seconds' worth, at least 64 MiB.
    pub buffer_bytes: Option<u64>,
}

impl Options {
    /// Into one file, until it is stopped, compressed by lz4.
    pub fn new(path: impl Into<PathBuf>) -> Options {
        Options {
            path: path.into(),
            overwrite: false,
            compression: Compression::default(),
            duration_s: None,
            max_bytes: None,
            max_file_s: None,
            buffer_bytes: None,
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let least = |what, found: Option<f64>, least: f64| match found {
            Some(found) if found.is_nan() || found < least => Err(Error::TooSmall { what, found, least }),
            _ => Ok(()),
        };
        least("size", self.max_bytes.map(|bytes| bytes as f64), LEAST_FILE as f64)?;
        least("time", self.max_file_s, LEAST_FILE_S)
    }
}
