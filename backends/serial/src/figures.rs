//! Statistics of the line, readable while the loop runs.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts since the backend was made. Written by the loop, readable by any thread.
#[derive(Debug, Default)]
pub struct LineFigures {
    pub(crate) sent: AtomicU64,
    pub(crate) unsent: AtomicU64,
    pub(crate) answered: AtomicU64,
    pub(crate) late: AtomicU64,
    pub(crate) damaged: AtomicU64,
    pub(crate) trips: AtomicU64,
    pub(crate) connections: AtomicU64,
}

impl LineFigures {
    pub(crate) fn count(counter: &AtomicU64) {
        // One writer: a load and a store, no locked instruction.
        counter.store(counter.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    /// Duty frames the line took.
    pub fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    /// Duty frames it had no room for.
    pub fn unsent(&self) -> u64 {
        self.unsent.load(Ordering::Relaxed)
    }

    /// Duty frames whose samples were there by the next exchange.
    pub fn answered(&self) -> u64 {
        self.answered.load(Ordering::Relaxed)
    }

    /// Samples that came too late, or of another frame.
    pub fn late(&self) -> u64 {
        self.late.load(Ordering::Relaxed)
    }

    /// Frames that came damaged.
    pub fn damaged(&self) -> u64 {
        self.damaged.load(Ordering::Relaxed)
    }

    /// How often the front-end was found to have switched off for silence.
    pub fn trips(&self) -> u64 {
        self.trips.load(Ordering::Relaxed)
    }

    /// How often the line was opened and the front-end found on it.
    pub fn connections(&self) -> u64 {
        self.connections.load(Ordering::Relaxed)
    }
}
