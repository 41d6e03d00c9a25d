//! How a recording is read.

use sinew_physics::WireModel;
use sinew_rig::ColumnMap;

/// Most rows a recording is read to by default: 83 minutes at 1 kHz, and at most 0.5 GB with every column there is.
pub const MAX_ROWS: usize = 5_000_000;

/// How to read a recording.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Pass over columns the contract does not know instead of refusing them.
    pub ignore_columns: bool,
    /// Foreign names and units, from the rig file. A name that is in the file under the contract's own name only is
    /// taken as it is.
    pub columns: Option<&'a ColumnMap>,
    /// The wire it was recorded on: its inputs must then be there and complete, and its elongation possible.
    pub model: Option<&'a WireModel>,
    /// Most rows, [`MAX_ROWS`] by default; a file with more is refused.
    pub max_rows: usize,
    /// Which channel of a session with several.
    pub channel: Option<&'a str>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options { ignore_columns: false, columns: None, model: None, max_rows: MAX_ROWS, channel: None }
    }
}
