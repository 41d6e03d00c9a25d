//! Options of a recording.

use std::path::PathBuf;

use sinew_recording::session::Compression;

use crate::error::Error;

/// Smallest size after which a new file can begin, bytes, and shortest time, s.
const LEAST_FILE: u64 = 1_000_000;
const LEAST_FILE_S: f64 = 1.0;
/// Into so many files what is kept is divided where no size of a file is given: the oldest of them is what is removed at a time.
const FILES_KEPT: u64 = 8;

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
    /// Keep this many files of the recording, the one being written among them: the oldest are removed; `None` = all. Only what the
    /// recording has written itself is removed.
    pub keep_files: Option<u32>,
    /// Keep so many bytes of all files together, likewise; a new file then begins at an eighth of it, or at
    /// [`Options::max_bytes`].
    pub keep_bytes: Option<u64>,
    /// End before less is free on the disk than this, bytes, with [`Error::Floor`]; 0 = when it is full. It is asked for after each chunk
    /// (4 MiB or a second), and [`crate::Warning::LowSpace`] comes at twice as much.
    pub keep_free_bytes: u64,
    /// What may wait to be written, bytes; `None` = five seconds' worth, at least 64 MiB.
    pub buffer_bytes: Option<u64>,
}

impl Options {
    /// What stays free on the disk unless something else is asked for, bytes.
    pub const KEEP_FREE_BYTES: u64 = 256_000_000;

    /// Into one file, until it is stopped or the disk has only [`Options::KEEP_FREE_BYTES`] left, compressed by lz4.
    pub fn new(path: impl Into<PathBuf>) -> Options {
        Options {
            path: path.into(),
            overwrite: false,
            compression: Compression::default(),
            duration_s: None,
            max_bytes: None,
            max_file_s: None,
            keep_files: None,
            keep_bytes: None,
            keep_free_bytes: Options::KEEP_FREE_BYTES,
            buffer_bytes: None,
        }
    }

    /// Bytes a file may have.
    pub(crate) fn most_bytes(&self) -> Option<u64> {
        self.max_bytes.or(self.keep_bytes.map(|bytes| bytes / FILES_KEPT))
    }

    /// Whether older files are removed.
    pub(crate) fn removes(&self) -> bool {
        self.keep_files.is_some() || self.keep_bytes.is_some()
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let least = |what, found: Option<f64>, least: f64| match found {
            Some(found) if found.is_nan() || found < least => Err(Error::TooSmall { what, found, least }),
            _ => Ok(()),
        };
        least("size", self.max_bytes.map(|bytes| bytes as f64), LEAST_FILE as f64)?;
        least("time", self.max_file_s, LEAST_FILE_S)?;
        // One that is written, and one before it: else nothing would be left whenever a new one begins.
        let least = self.max_bytes.unwrap_or(FILES_KEPT / 2 * LEAST_FILE).saturating_mul(2);
        match (self.keep_files, self.keep_bytes) {
            (Some(found @ ..2), _) => Err(Error::TooFewKept { found }),
            (_, Some(found)) if found < least => Err(Error::TooLittleKept { found, least }),
            (Some(_), None) if self.max_bytes.is_none() && self.max_file_s.is_none() => Err(Error::OneFile),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_more_than_the_file_being_written() {
        let options =
            |max_bytes, keep_files, keep_bytes| Options { max_bytes, keep_files, keep_bytes, ..Options::new("a.mcap") };
        let (mb, check) = (1_000_000, |options: Options| options.check());
        assert!(matches!(check(options(None, Some(3), None)), Err(Error::OneFile)));
        assert!(check(Options { max_file_s: Some(60.0), ..options(None, Some(3), None) }).is_ok());
        assert!(matches!(check(options(Some(mb), Some(1), None)), Err(Error::TooFewKept { found: 1 })));
        assert!(check(options(Some(mb), Some(2), None)).is_ok());
        let error = check(options(Some(10 * mb), None, Some(19 * mb))).unwrap_err();
        assert!(matches!(error, Error::TooLittleKept { least: 20_000_000, .. }) && error.is_bad_input(), "{error}");
        assert!(check(options(Some(10 * mb), Some(5), Some(20 * mb))).is_ok());
        // without a size of a file, an eighth of what is kept
        assert!(matches!(check(options(None, None, Some(8 * mb - 1))), Err(Error::TooLittleKept { .. })));
        assert!(check(options(None, Some(4), Some(8 * mb))).is_ok());
        assert_eq!(options(None, None, Some(8 * mb)).most_bytes(), Some(mb));
        assert_eq!(options(Some(3 * mb), None, Some(8 * mb)).most_bytes(), Some(3 * mb));
    }
}
