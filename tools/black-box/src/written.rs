//! The files written so far, and the writes that failed.

use std::path::PathBuf;

/// The result so far.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// The files, in order.
    pub files: Vec<PathBuf>,
    /// How many could not be written.
    pub failed: u64,
    /// Why not, the last one.
    pub failure: Option<String>,
}
