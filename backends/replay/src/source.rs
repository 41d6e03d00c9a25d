//! Where recorded cycles come from.

use sinew_ipc::{ChannelState, CycleHeader};

use crate::error::Error;

/// A recording that can be read from its beginning, again and again.
pub trait Source: Send {
    /// What reads it.
    type Cycles: Cycles + 'static;

    /// How many channels it has.
    fn channels(&self) -> usize;

    /// Its cycles, from the first.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn cycles(&self) -> Result<Self::Cycles, Error>;
}

/// The cycles of a recording, one after the other.
pub trait Cycles: Send {
    /// Shows every cycle, head and channels' states, until it has seen enough and says `false`, or to the end.
    ///
    /// # Errors
    /// Where it cannot be read on.
    fn each(self, see: &mut dyn FnMut(&CycleHeader, &[ChannelState]) -> bool) -> Result<(), Error>;
}
