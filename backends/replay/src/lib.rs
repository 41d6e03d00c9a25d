//! A recording as a backend.
//!
//! [`ReplayBackend`] replaces power stage and converter: it returns the recorded voltages. It reads a
//! [`Source`]; a recorded [`Cycle`] has only the data a backend needs, independent of files and messages.
#![forbid(unsafe_code)]

mod backend;
mod source;

pub use backend::ReplayBackend;
pub use source::{Cycle, Cycles, Source};
