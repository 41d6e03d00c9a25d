//! What was written when something broke.

use std::path::PathBuf;

/// What has come of it so far.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// The files, in order.
    pub files: Vec<PathBuf>,
    /// How many could not be written.
    pub failed: u64,
    /// Why not, the last one.
    pub failure: Option<String>,
}
