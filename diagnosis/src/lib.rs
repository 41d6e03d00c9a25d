//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
#![forbid(unsafe_code)]

mod answer;
mod error;
mod gates;
mod noise;

pub use answer::*;
pub use error::{Broken, Error, Trouble};
pub use gates::{Exclude, LEAST_SAMPLES, MOST_SAMPLES, Warning, check, sensors};
pub use noise::{Noise, estimate};

#[cfg(test)]
mod testing;
