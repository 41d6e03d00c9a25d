//! Errors at the start of a driver and in its operation.

use std::fmt;

use sinew_backend::BackendError;

/// Why there is no running driver.
#[derive(Debug)]
pub enum Error {
    /// The rig cannot be driven: what is wrong with which channel.
    Rig {
        /// Name of the channel, or of the rig.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// The backend has another number of channels than the rig.
    Channels {
        /// Channels of the rig.
        expected: usize,
        /// Channels of the backend.
        found: usize,
    },
    /// The backend's outputs stay as they are for ever once nobody drives them.
    Endless,
    /// The backend did not start.
    Backend(BackendError),
    /// `realtime = "strict"`, and Linux refused something.
    NotRealtime {
        /// What was refused, what it costs and what to type: one line each.
        refused: Vec<String>,
    },
    /// The shared services could not be opened; among them: another driver runs this rig.
    Services(sinew_ipc::Error),
    /// A thread could not be started.
    Thread(std::io::Error),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Rig { place, reason } => write!(f, "{place}: {reason}"),
            Error::Channels { expected, found } => {
                write!(f, "the rig has {expected} channels, but the backend has {found}")
            }
            Error::Endless => f.write_str(
                "nothing ends what this backend puts out when the driver dies: not even the sensing pulse could be given, and so the \
                 wires could not be moved at all; it needs a watchdog, and to say in `Backend::silence_s` how soon that acts",
            ),
            Error::Backend(error) => write!(f, "the backend did not start: {error}"),
            Error::NotRealtime { refused } => {
                write!(f, "realtime is \"strict\", and this machine refuses: {}", refused.join("; "))
            }
            Error::Services(error) => error.fmt(f),
            Error::Thread(error) => write!(f, "a thread could not be started: {error}"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::Backend(error) => Some(error),
            Error::Services(error) => Some(error),
            Error::Thread(error) => Some(error),
            _ => None,
        }
    }
}

impl From<BackendError> for Error {
    fn from(error: BackendError) -> Self {
        Error::Backend(error)
    }
}

impl From<sinew_ipc::Error> for Error {
    fn from(error: sinew_ipc::Error) -> Self {
        Error::Services(error)
    }
}
