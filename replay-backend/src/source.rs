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
    /// Writes the next cycle's states into `states`, one for each channel, and gives its head; `None` at the end.
    ///
    /// # Errors
    /// Where it cannot be read on.
    fn next(&mut self, states: &mut [ChannelState]) -> Result<Option<CycleHeader>, Error>;
}
