//! Errors of starting the simulated front-end.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// What keeps the host from running.
#[derive(Debug)]
pub enum Error {
    /// No pseudo-terminal, or not the given device.
    Line {
        /// What was tried.
        what: String,
        /// Why not.
        error: io::Error,
    },
    /// The link to the pseudo-terminal cannot be made.
    Link {
        /// Where.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
    /// The wires cannot be simulated.
    Wires(sinew_sim_backend::Error),
    /// More channels than a front-end has.
    Channels {
        /// The rig's.
        found: usize,
    },
    /// The timer or the wait failed.
    Timer(io::Error),
    /// The true temperatures cannot be written.
    Truth {
        /// Where.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Line { what, error } => write!(f, "{what}: {error}"),
            Error::Truth { path, error } => write!(f, "{}: cannot be written: {error}", path.display()),
            Error::Link { path, error } => write!(f, "{}: cannot be made a link: {error}", path.display()),
            Error::Wires(error) => error.fmt(f),
            Error::Channels { found } => {
                write!(f, "the rig has {found} channels, a front-end at most {}", sinew_front_end::MAX_CHANNELS)
            }
            Error::Timer(error) => write!(f, "the timer: {error}"),
        }
    }
}

impl std::error::Error for Error {}
