//! What can be wrong with accounts.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Every way it can fail.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A folder or file of accounts cannot be read or written.
    File {
        /// Which.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// A file is no account, or one that was damaged. It is left as it is.
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A recording cannot be read.
    Recording(Box<sinew_recording::Error>),
    /// A recording does not say of which wires it is.
    NoRig {
        /// The recording.
        file: String,
        /// Why not.
        reason: String,
    },
    /// It is not said of which of a rig's channels a recording is.
    NotChosen(sinew_rig::NotChosen),
    /// A recording has no such channel.
    NoChannel {
        /// The recording.
        file: String,
        /// The name that was given.
        name: String,
        /// Those it has.
        there: Vec<String>,
    },
    /// The thread that writes cannot be started.
    Thread(io::Error),
}

impl Error {
    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self {
            Error::File { .. } => {
                "make it readable and writable for you, or set SINEW_STATE_DIR to another folder".into()
            }
            Error::Damaged { .. } => {
                "`sinew life RIG.toml CHANNEL --new-wire` moves it aside and begins anew; or put a copy of it back"
                    .into()
            }
            Error::Recording(error) => error.hint(),
            Error::NoRig { .. } => "name its rig file with --rig".into(),
            Error::NotChosen(error) => error.remedy("--channel"),
            Error::NoChannel { there, .. } => format!("its channels are {}", there.join(", ")),
            Error::Thread(_) => "check the limits on threads and memory (`ulimit -a`)".into(),
        }
    }

    /// Whether what was given is wrong, and not the machine.
    pub fn is_input(&self) -> bool {
        !matches!(self, Error::File { .. } | Error::Thread(_))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::File { path, reason } => write!(f, "{}: {reason}", path.display()),
            Error::Damaged { path, reason } => {
                write!(f, "{}: is no account of a wire's life: {reason}", path.display())
            }
            Error::Recording(error) => f.write_str(&error.message()),
            Error::NoRig { file, reason } => write!(f, "{file}: {reason}"),
            Error::NotChosen(error) => error.fmt(f),
            Error::NoChannel { file, name, .. } => write!(f, "{file}: has no channel \"{name}\""),
            Error::Thread(error) => write!(f, "a thread could not be started: {error}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<sinew_recording::Error> for Error {
    fn from(error: sinew_recording::Error) -> Error {
        Error::Recording(Box::new(error))
    }
}
