//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
#![forbid(unsafe_code)]

mod answer;
mod attempt;
mod closed_form;
mod conditions;
mod data;
mod derivatives;
mod describe;
mod diagnose;
mod error;
mod evidence;
mod experiment;
mod figures;
mod fit;
mod forward;
mod gates;
mod intervals;
mod locate;
mod noise;
mod numbers;
mod prepare;
mod products;
mod progress;
mod residuals;
mod search;
mod settings;
mod significance;
mod simulate;
mod space;
mod stages;
mod starts;
mod structure;
mod unknown;
mod words;

pub use answer::*;
pub use diagnose::{Identified, Outcome, diagnose, identify};
pub use error::{Broken, Error, Trouble};
pub use gates::{Exclude, LEAST_SAMPLES, MOST_SAMPLES, Warning, check, sensors};
pub use noise::{Noise, estimate};
pub use settings::Settings;

#[cfg(test)]
mod testing;
