//! Why a calorimeter's curve tells nothing of a model.

use std::fmt;

/// A curve that cannot be fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// What the curve lacks.
    Curve(sinew_standards::Error),
    /// A model that cannot be built.
    Model(sinew_physics::Error),
    /// The model stays as it is in a furnace without force: its criterion moves the phase by stress alone.
    NothingMoves,
    /// The fit does not come to an end: the curve is of another shape than the model's.
    NoFit,
}

impl From<sinew_standards::Error> for Error {
    fn from(error: sinew_standards::Error) -> Error {
        Error::Curve(error)
    }
}

impl From<sinew_physics::Error> for Error {
    fn from(error: sinew_physics::Error) -> Error {
        Error::Model(error)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Curve(error) => error.fmt(f),
            Error::Model(error) => write!(f, "cannot be simulated: {error}"),
            Error::NothingMoves => {
                write!(f, "says nothing of this rig file's model, whose criterion moves the phase by stress alone")
            }
            Error::NoFit => write!(f, "cannot be fitted by this rig file's kinetics"),
        }
    }
}

impl std::error::Error for Error {}
