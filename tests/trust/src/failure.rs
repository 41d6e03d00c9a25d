//! Errors of a try.

use std::fmt;

/// Why a try did not come out.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    /// The driver did something else than it promises.
    Unexpected(String),
    /// It cannot be tried on this machine.
    Impossible(String),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Unexpected(what) => f.write_str(what),
            Failure::Impossible(why) => write!(f, "cannot be tried here: {why}"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Failure {
        Failure::Unexpected(error.to_string())
    }
}

impl From<sinew_ipc::Error> for Failure {
    fn from(error: sinew_ipc::Error) -> Failure {
        Failure::Unexpected(error.to_string())
    }
}

/// An unexpected thing, in words.
pub fn unexpected<T>(what: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::Unexpected(what.into()))
}

/// Fails with these words unless it is so.
pub fn expect(so: bool, otherwise: impl FnOnce() -> String) -> Result<(), Failure> {
    if so { Ok(()) } else { Err(Failure::Unexpected(otherwise())) }
}
