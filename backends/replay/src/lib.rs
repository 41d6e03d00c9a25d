//! A recording behind the contract of backends.
//!
//! [`ReplayBackend`] takes the place of power stage and converter: it brings back the voltages that were recorded. What it reads is a
//! [`Source`]; it knows of a recorded [`Cycle`] what a backend needs to know and nothing of files or messages.
#![forbid(unsafe_code)]

mod backend;
mod source;

pub use backend::ReplayBackend;
pub use source::{Cycle, Cycles, Source};
