//! What material laboratories report of a shape-memory alloy, read off their curves: [`calorimetry`](calorimetry()) (ASTM F2004),
//! [`recovery`](recovery()) (F2082 bent, E3098 pulled), [`thermal_cycle`](thermal_cycle()) (E3097) and [`tension`](tension()) (F2516).
//!
//! Pure functions on curves in SI units (temperatures in °C), in the order in which they were measured. Temperatures are where tangents
//! meet: that of the steepest place of a transformation, and the base lines before and after it. How far they move with the choice of
//! the stretch a tangent is laid through comes with them; it is not the thermometer's error.
//!
//! # Example
//! ```
//! use sinew_standards::thermal_cycle;
//!
//! // strain of a wire under constant force: martensite up to 80 °C, austenite from 90 °C on, and back from 60 to 50 °C
//! let strain = |t: f64, start: f64, finish: f64| 0.04 * (1.0 - ((t - start) / (finish - start)).clamp(0.0, 1.0));
//! let up = (20..=140).map(f64::from).map(|t| (t, strain(t, 80.0, 90.0)));
//! let down = (20..=140).rev().map(f64::from).map(|t| (t, strain(t, 50.0, 60.0)));
//! let (temperature_c, strain): (Vec<f64>, Vec<f64>) = up.chain(down).unzip();
//! let cycle = thermal_cycle(&temperature_c, &strain)?;
//! assert!((cycle.heating.start_c.value - 80.0).abs() < 1.0 && (cycle.cooling.start_c.value - 60.0).abs() < 1.0);
//! assert!((cycle.transformation_strain - 0.04).abs() < 1e-3 && cycle.residual_strain.abs() < 1e-9);
//! # Ok::<(), sinew_standards::Error>(())
//! ```
#![forbid(unsafe_code)]

mod branch;
mod calorimetry;
mod cycle;
mod error;
mod fit;
mod tension;
mod transition;

pub use branch::stretches;
pub use calorimetry::{Calorimetry, LOGISTIC_SPAN, Peak, calorimetry};
pub use cycle::{Recovery, ThermalCycle, recovery, thermal_cycle};
pub use error::Error;
pub use tension::{LOWER_PLATEAU_AT, PRELOAD_PA, Tension, UPPER_PLATEAU_AT, tension};
pub use transition::{Estimate, STRAIN_SPAN, Transition};
