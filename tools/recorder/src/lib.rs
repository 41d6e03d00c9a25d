//! Records a running driver: a client like any other, which writes every cycle of all channels into files.
//!
//! [`Recorder::start`] connects a stream to two threads. One drains it: it copies every cycle out of shared memory into blocks, and
//! never waits for anything but the driver. The other one compresses the blocks and writes them. Between the two lies a buffer of
//! several seconds ([`Options::buffer_bytes`]), so that a disk that stands still for that long loses nothing. What does not fit in
//! is lost, counted, and named in the file ([`sinew_recording::session::Ending`]).
//!
//! Data are brought to the disk every few seconds and at the end of each file, so that even when the power fails only the last
//! seconds are missing. A recorder that is killed leaves every chunk it had completed, which is all but the last second.
#![forbid(unsafe_code)]

mod blocks;
mod drain;
mod error;
mod events;
mod figures;
mod files;
mod recorder;
mod state;
mod writer;

pub use blocks::Block;
pub use error::Error;
pub use events::FaultEvents;
pub use figures::loop_figures;
pub use files::part_path;
pub use recorder::{Live, Options, Recorder, Report, unix_ns};
pub use state::layout;
