//! Errors of recording.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Every way a recording can fail.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// There is a file of that name already.
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A size or time after which to begin a new file that is too small for one.
    TooSmall {
        /// What.
        what: &'static str,
        /// As given, bytes or s.
        found: f64,
        /// The least that will do.
        least: f64,
    },
    /// The connection to the driver failed.
    Driver(sinew_ipc::Error),
    /// A file could not be written.
    File(sinew_recording::Error),
    /// A thread could not be started, or died.
    Thread(io::Error),
}

impl Error {
    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self {
            Error::Exists { .. } => "choose another name, or --force to replace it".into(),
            Error::TooSmall { least, .. } => format!("give at least {least}"),
            Error::Driver(error) => error.remedy(),
            Error::File(error) => error.hint(),
            Error::Thread(_) => "check the limits on threads and memory (`ulimit -a`)".into(),
        }
    }

    /// Whether this is the caller's mistake and not a failure of the machine or the driver.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::Exists { .. } | Error::TooSmall { .. } => true,
            Error::Driver(error) => error.is_bad_input(),
            Error::File(error) => error.is_bad_input(),
            Error::Thread(_) => false,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Exists { path } => write!(f, "{}: is there already", path.display()),
            Error::TooSmall { what, found, .. } => write!(f, "a {what} of {found} is too small for a file"),
            Error::Driver(error) => error.fmt(f),
            Error::File(error) => f.write_str(&error.message()),
            Error::Thread(error) => write!(f, "a thread failed: {error}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<sinew_ipc::Error> for Error {
    fn from(error: sinew_ipc::Error) -> Error {
        Error::Driver(error)
    }
}

impl From<sinew_recording::Error> for Error {
    fn from(error: sinew_recording::Error) -> Error {
        Error::File(error)
    }
}
