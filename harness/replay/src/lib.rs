//! Runs the driver's engine over a recording and compares the output with the recorded one.
//!
//! A [`ReplayBackend`](sinew_replay_backend::ReplayBackend) returns the recorded voltages. [`Replay`] runs the driver's own cycle over them in lockstep, with
//! the same beats and the same requests at the same cycles, and [`Comparison`] lists the differences from the recording.
//!
//! # Limits: open loop
//! With the same program and rig file and a recording from the driver's first cycle on, the output is bit for bit the
//! same. After a change of rig, algorithm or program, that change causes the differences. But a recorded wire does not respond:
//! it behaves as it was heated in the recording, whatever the new duty. So the duty that went out then takes the place of the one that was decided
//! now, after each cycle. Sensing, estimates, faults and the law's output at each moment are those of the change; how the wire would have
//! moved only a simulation shows.
//!
//! ```no_run
//! use sinew_recording::session::Session;
//! use sinew_replay::{Replay, SessionSource};
//! use sinew_rig::Rig;
//!
//! let path = "session.mcap".as_ref();
//! let session = Session::open(path)?;
//! let mut replay = Replay::new(&Rig::load("my-rig.toml".as_ref())?, SessionSource::new(path, &session)?)?;
//! while replay.cycle(|_| {})?.is_some() {}
//! println!("decides the same today: {}", replay.comparison().is_identical());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod compare;
mod error;
mod replay;
mod session;

pub use compare::{Comparison, Difference, Place};
pub use error::Error;
pub use replay::{Completeness, Replay};
pub use session::{SessionCycle, SessionCycles, SessionSource, encode};
