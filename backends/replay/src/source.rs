//! The source of recorded cycles, and the data a backend needs of one.

use std::fmt::Debug;

use sinew_backend::{BackendError, Sample};

/// A recording that can be read from its beginning, again and again.
pub trait Source: Send {
    /// A cycle of it.
    type Cycle: Cycle;
    /// What reads it.
    type Cycles: Cycles<Cycle = Self::Cycle, Error = Self::Error> + 'static;
    /// What can keep it from being read.
    type Error: Debug + Send + 'static;

    /// How many channels it has.
    fn channels(&self) -> usize;

    /// Its cycles, from the first.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn cycles(&self) -> Result<Self::Cycles, Self::Error>;
}

/// The cycles of a recording, one after the other.
pub trait Cycles: Send {
    /// A cycle of the recording.
    type Cycle: Cycle;
    /// What can keep it from being read on.
    type Error;

    /// Shows every cycle until `see` has enough and returns `false`, or to the end.
    ///
    /// # Errors
    /// Where it cannot be read on.
    fn each(self, see: &mut dyn FnMut(&Self::Cycle) -> bool) -> Result<(), Self::Error>;
}

/// A recorded cycle of a driver.
pub trait Cycle: Debug + Send + Sized + 'static {
    /// Room for a cycle of so many channels.
    fn new(channels: usize) -> Self;

    /// Becomes a copy of `other`, as far as there is room for channels, without allocating.
    fn copy_from(&mut self, other: &Self);

    /// Number of the cycle, from 1, consecutive over the cycles that ran.
    fn number(&self) -> u64;

    /// Number of its period, from the driver's start: cycles that ran and periods that were missed.
    fn period(&self) -> u64;

    /// What was sampled of a channel.
    fn sample(&self, channel: usize) -> Sample;

    /// The duty the cycle decided on for a channel, 0 ..= 1, which went out with the cycle after it.
    fn duty(&self, channel: usize) -> f64;

    /// How the backend failed a channel in this cycle, alone or as a whole; `None` where it did not.
    fn error(&self, channel: usize) -> Option<BackendError>;
}
