//! Errors of starting a black box, or of writing a file of it.

use std::fmt;
use std::io;
use std::path::PathBuf;

use sinew_recording::session::Trouble;

/// Every way it can fail.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// Nothing says where files of this user go.
    NoPlace,
    /// The folder cannot be made or looked through.
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// The channels' names make no recording.
    Layout(Trouble),
    /// The file cannot be written.
    File(sinew_recording::Error),
    /// The thread that writes cannot be started.
    Thread(io::Error),
}

impl Error {
    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self {
            Error::NoPlace => "set SINEW_STATE_DIR to a folder that can be written".into(),
            Error::Folder { .. } => "make it writable, or set SINEW_STATE_DIR to another folder".into(),
            Error::Layout(_) => "give every channel a name of its own".into(),
            Error::File(error) => error.hint(),
            Error::Thread(_) => "check the limits on threads and memory (`ulimit -a`)".into(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::NoPlace => {
                f.write_str("neither SINEW_STATE_DIR nor XDG_STATE_HOME nor HOME says where black boxes go")
            }
            Error::Folder { path, reason } => write!(f, "{}: {reason}", path.display()),
            Error::Layout(trouble) => write!(f, "the rig cannot be recorded: {trouble}"),
            Error::File(error) => f.write_str(&error.message()),
            Error::Thread(error) => write!(f, "a thread could not be started: {error}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<Trouble> for Error {
    fn from(trouble: Trouble) -> Error {
        Error::Layout(trouble)
    }
}

impl From<sinew_recording::Error> for Error {
    fn from(error: sinew_recording::Error) -> Error {
        Error::File(error)
    }
}
