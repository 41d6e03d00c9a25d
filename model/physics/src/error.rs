//! What can be wrong with a wire's parameters.

/// What can be wrong with a wire's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error {
    /// A parameter is outside its physical range (NaN included).
    OutOfRange {
        /// The rig-file key, in whose unit the numbers are.
        key: &'static str,
        /// What was given.
        found: f64,
        /// Least value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Error::OutOfRange { key, found, low, high } => write!(f, "{key} is {found}, expected {low} to {high}"),
        }
    }
}

impl std::error::Error for Error {}
