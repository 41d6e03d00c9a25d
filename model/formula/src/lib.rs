//! Formulas that users write, such as `gain * (temperature - ambient)`: parsed, checked for units, and evaluated without
//! allocation.
//!
//! A formula is arithmetic over named quantities and a dozen functions. It cannot loop, call, read or write, its length is
//! bounded, and one that was accepted evaluates in a time that its length bounds; so a file that somebody else wrote can
//! carry one. All quantities are in SI where it is evaluated; units are declared once, by the names and in brackets behind
//! numbers (`2.5 [mm]`), and what does not fit together is an error with its place.
//!
//! ```
//! use sinew_formula::{Formula, Quantity, Unit};
//!
//! let watt_per_kelvin: Unit = "mW/K".parse().unwrap();
//! let names = [
//!     Quantity { name: "gain", dimension: watt_per_kelvin.dimension },
//!     Quantity { name: "temperature", dimension: Unit::parse("°C").unwrap().dimension },
//! ];
//! let loss = Formula::new("gain * (temperature - 20 [°C])", &names, Unit::parse("W").unwrap().dimension).unwrap();
//! assert_eq!(loss.value(&[0.5, 80.0]), 30.0);
//! // and how it changes with the temperature
//! assert_eq!(loss.tangent(&[0.5, 80.0], 1), (30.0, 0.5));
//! ```

mod check;
mod error;
mod program;
mod syntax;
mod unit;

pub use crate::check::Quantity;
pub use crate::error::{Error, Place};
pub use crate::program::Formula;
pub use crate::unit::{Dimension, Unit};
