//! The driver's engine run once more over a recording, and what comes out otherwise today.
//!
//! A [`ReplayBackend`](sinew_replay_backend::ReplayBackend) brings back the voltages that were recorded. [`Replay`] runs the driver's own cycle over them in lockstep, with
//! the same beats and the same requests at the same cycles, and [`Comparison`] lists what comes out otherwise than it was recorded.
//!
//! # What it says, and what not
//! With the program, the rig file and a recording from the driver's first cycle on, everything comes out bit for bit the
//! same. Change the rig, an algorithm or the program, and what differs is their doing. But a recorded wire does not answer: it
//! goes on as it was heated then, whatever duty comes out now. Sensing, estimates, faults and the law's first answer are
//! those a change would have had; how the wire would have moved under that answer only a simulation can say.
#![forbid(unsafe_code)]

mod compare;
mod error;
mod replay;
mod session;

pub use compare::{Comparison, Difference, Place};
pub use error::Error;
pub use replay::{Completeness, Replay};
pub use session::{SessionCycle, SessionCycles, SessionSource, encode};
