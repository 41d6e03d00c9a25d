//! What can be wrong with a recording in MCAP.

use std::fmt;

/// The kinds of trouble with a recording in MCAP; [`crate::What::Session`] carries them.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trouble {
    /// It does not begin as an MCAP file does.
    NotMcap {
        /// What it looks like.
        found: &'static str,
    },
    /// An MCAP file without cycles.
    Foreign {
        /// The topics it has.
        topics: Vec<String>,
    },
    /// Its cycles are described in a way that is not understood.
    Schema {
        /// Why not.
        reason: String,
    },
    /// A record is damaged.
    Damaged {
        /// Where the record begins, bytes from the start.
        offset: u64,
        /// In what way.
        reason: String,
    },
    /// A record claims to be larger than any is.
    TooLarge {
        /// Where the record begins, bytes from the start.
        offset: u64,
        /// What it claims, bytes.
        found: u64,
        /// The most that is read, bytes.
        limit: u64,
    },
    /// A layout no message can have, handed over by a program.
    Layout {
        /// Why not.
        reason: String,
    },
    /// A cycle of another size than the layout says, handed over by a program.
    CycleBytes {
        /// Bytes of the layout's channels.
        expected: usize,
        /// Bytes handed over.
        found: usize,
    },
    /// A cycle that does not come after the one before, handed over by a program.
    NotAfter {
        /// Number of the cycle before.
        previous: u64,
        /// Number of this cycle.
        found: u64,
    },
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::NotMcap { found } => write!(f, "is {found}, expected a recording in MCAP"),
            Trouble::Foreign { topics } if topics.is_empty() => f.write_str("has no topic /cycles, nor any other"),
            Trouble::Foreign { topics } => write!(f, "has no topic /cycles, only {}", topics.join(", ")),
            Trouble::Schema { reason } => write!(f, "describes its cycles in a way that is not understood: {reason}"),
            Trouble::Damaged { offset, reason } => write!(f, "is damaged at byte {offset}: {reason}"),
            Trouble::TooLarge { offset, found, limit } => {
                write!(f, "has a record of {found} bytes at byte {offset}, expected at most {limit}")
            }
            Trouble::Layout { reason } => write!(f, "cannot have such channels: {reason}"),
            Trouble::CycleBytes { expected, found } => {
                write!(f, "was given a cycle of {found} bytes, expected {expected}")
            }
            Trouble::NotAfter { previous, found } => write!(f, "was given cycle {found} after cycle {previous}"),
        }
    }
}

impl std::error::Error for Trouble {}

impl Trouble {
    /// What a person can do about it.
    pub(crate) fn hint(&self) -> &'static str {
        match self {
            Trouble::NotMcap { .. } => {
                "name what `sinew record` has written; a recording as CSV is read by commands that say so, by the name .csv or .csv.gz"
            }
            Trouble::Foreign { .. } | Trouble::Schema { .. } => {
                "only recordings of sinew are read; bring others into CSV, which every lab can write"
            }
            Trouble::Damaged { .. } | Trouble::TooLarge { .. } => {
                "`sinew recording doctor` tells what is left of it, `sinew recording recover` makes a good file of that"
            }
            Trouble::Layout { .. } | Trouble::CycleBytes { .. } | Trouble::NotAfter { .. } => {
                "give every cycle as the layout says, in order"
            }
        }
    }
}
