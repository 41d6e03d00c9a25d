//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
#![forbid(unsafe_code)]

mod answer;

pub use answer::*;
