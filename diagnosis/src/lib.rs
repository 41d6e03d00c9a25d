//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
#![forbid(unsafe_code)]

mod answer;
mod beyond;
mod conditions;
mod data;
mod diagnose;
mod error;
mod experiment;
mod figures;
mod fit;
mod forward;
mod gates;
mod intervals;
mod locate;
mod noise;
mod numbers;
mod progress;
mod search;
mod significance;
mod simulate;
mod space;
mod starts;
mod words;

pub use answer::*;
pub use diagnose::{Identified, Outcome, Settings, diagnose, identify};
pub use error::{Broken, Error, Trouble};
pub use gates::{Exclude, LEAST_SAMPLES, MOST_SAMPLES, Warning, check, sensors};
pub use noise::{Noise, estimate};

#[cfg(test)]
mod testing;
