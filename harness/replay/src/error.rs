//! Why a recording cannot be replayed.

use std::fmt;

use sinew_threads::Thread;

/// What stands in the way.
#[derive(Debug)]
pub enum Error {
    /// The recording cannot be read.
    Recording(sinew_recording::Error),
    /// The recording lacks what a replay starts from.
    Lacks {
        /// The recording.
        file: String,
        /// What it lacks.
        what: String,
    },
    /// The rig has another number of channels than the recording.
    Channels {
        /// Channels of the recording.
        expected: usize,
        /// Channels of the rig.
        found: usize,
    },
    /// The driver does not take the rig.
    Driver(sinew_driver::Error),
    /// A thread has died before the end of the recording.
    Died(Thread),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Recording(error) => f.write_str(&error.message()),
            Error::Lacks { file, what } => write!(f, "{file}: {what}"),
            Error::Channels { expected, found } => {
                write!(f, "the recording has {expected} channels, but the rig has {found}")
            }
            Error::Driver(error) => error.fmt(f),
            Error::Died(thread) => write!(f, "the thread that {} has died", thread.row().does),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::Driver(error) => Some(error),
            _ => None,
        }
    }
}
