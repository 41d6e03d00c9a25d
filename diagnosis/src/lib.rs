//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
#![forbid(unsafe_code)]

mod answer;
mod error;
pub mod gates;
pub mod noise;

pub use answer::*;
pub use error::{Broken, Error, Trouble};

#[cfg(test)]
mod testing;
