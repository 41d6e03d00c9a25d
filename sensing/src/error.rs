//! Errors of a sensing configuration.

use std::fmt;

/// A configuration that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error {
    /// A number is NaN or outside its range.
    OutOfRange {
        /// Which number, with its unit.
        name: &'static str,
        /// What it was.
        value: f64,
        /// Smallest value that would do.
        min: f64,
        /// Largest value that would do.
        max: f64,
    },
    /// The two ends of a range are not in order.
    EmptyRange {
        /// Which range, with its unit.
        name: &'static str,
        /// Its lower end.
        min: f64,
        /// Its upper end.
        max: f64,
    },
    /// A straight line needs points at two different resistances at least.
    TooFewPoints {
        /// How many usable points there were.
        points: u64,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Error::OutOfRange { name, value, min, max } => {
                write!(f, "{name} is {value}, expected {min} to {max}")
            }
            Error::EmptyRange { name, min, max } => {
                write!(f, "{name} runs from {min} to {max}: the first must be below the second")
            }
            Error::TooFewPoints { points } => {
                write!(f, "{points} usable points do not span a line: need two different resistances")
            }
        }
    }
}

impl std::error::Error for Error {}

/// Checks one number against a closed range.
pub(crate) fn check(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    // NaN is in no range.
    if (min..=max).contains(&value) { Ok(()) } else { Err(Error::OutOfRange { name, value, min, max }) }
}

/// Checks that two finite numbers are in order.
pub(crate) fn check_ordered(name: &'static str, min: f64, max: f64) -> Result<(), Error> {
    if min.is_finite() && max.is_finite() && min < max { Ok(()) } else { Err(Error::EmptyRange { name, min, max }) }
}
