//! Errors of driving a rig over Linux's interfaces, detected before any output.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// What is wrong, where, and what there is instead.
#[derive(Debug)]
pub enum Error {
    /// A name of the rig file that nothing on this machine bears, or that several do.
    Name {
        /// The channel, empty where it is about the backend as a whole.
        channel: String,
        /// The key of the rig file: in `[channel.linux]`, or with its table in `[backend]`.
        key: &'static str,
        /// What it says.
        found: String,
        /// What is wrong with it, with what there is.
        reason: String,
    },
    /// A file of the kernel could not be read or written.
    File {
        /// Which.
        path: PathBuf,
        /// What was tried: "read", "write 1000000".
        what: String,
        /// What the kernel said.
        error: io::Error,
    },
    /// A file of the kernel says something this backend does not understand.
    Content {
        /// Which.
        path: PathBuf,
        /// What it says.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The process that watches over the outputs did not start.
    Guard {
        /// What it said, or what the system did.
        reason: String,
    },
}

impl Error {
    pub(crate) fn name(channel: &str, key: &'static str, found: &str, reason: impl Into<String>) -> Error {
        Error::Name { channel: channel.into(), key, found: found.into(), reason: reason.into() }
    }

    pub(crate) fn file(path: &Path, what: impl Into<String>, error: impl Into<io::Error>) -> Error {
        Error::File { path: path.into(), what: what.into(), error: error.into() }
    }

    /// The number of the operating system's error, 0 where it was none.
    pub fn os_error(&self) -> i32 {
        match self {
            Error::File { error, .. } => error.raw_os_error().unwrap_or(0),
            _ => 0,
        }
    }

    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self {
            Error::Name { .. } => "`sinew doctor RIG.toml` lists what is attached under which names".into(),
            Error::File { path, error, .. } => match error.kind() {
                io::ErrorKind::PermissionDenied => format!(
                    "{} is not open to this user: see the udev rules in docs/linux-backend.md, or run as root",
                    path.display()
                ),
                io::ErrorKind::NotFound => "the device is gone, or its driver is not loaded; `dmesg` tells".into(),
                _ if error.raw_os_error() == Some(rustix::io::Errno::BUSY.raw_os_error()) => {
                    "somebody else has it: another driver, iio_readdev, gpioset, a kernel driver such as a fan's or a backlight's".into()
                }
                _ => "`dmesg` may tell more".into(),
            },
            Error::Content { .. } => "please report it, with the kernel's version and the chip".into(),
            Error::Guard { .. } => {
                "nothing is heated without the guard; see \"The dead program\" in docs/linux-backend.md".into()
            }
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Name { channel, key, found, reason } if channel.is_empty() => {
                write!(f, "backend.{key} = \"{found}\": {reason}")
            }
            Error::Name { channel, key, found, reason } => {
                write!(f, "channel \"{channel}\": linux.{key} = \"{found}\": {reason}")
            }
            Error::File { path, what, error } => write!(f, "{}: {what}: {error}", path.display()),
            Error::Content { path, found, expected } => {
                write!(f, "{}: \"{found}\", expected {expected}", path.display())
            }
            Error::Guard { reason } => write!(f, "the guard of the outputs did not start: {reason}"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::File { error, .. } => Some(error),
            _ => None,
        }
    }
}
