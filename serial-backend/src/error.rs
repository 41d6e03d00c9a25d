//! Why there is no front-end to drive wires with.

use std::fmt;
use std::io;

/// What keeps a front-end from being used.
#[derive(Debug)]
pub enum Error {
    /// The rig file names no port.
    NoPort,
    /// The device cannot be opened.
    Open {
        /// Its path.
        port: String,
        /// Why.
        error: io::Error,
    },
    /// It is no serial line.
    NotALine {
        /// Its path.
        port: String,
    },
    /// Somebody else has it.
    Taken {
        /// Its path.
        port: String,
    },
    /// Reading or writing failed.
    Line {
        /// Its path.
        port: String,
        /// Why.
        error: io::Error,
    },
    /// Nobody answers on it.
    Silent {
        /// Its path.
        port: String,
    },
    /// What answers is another version of the protocol.
    Version {
        /// Its path.
        port: String,
        /// The version it names.
        found: u8,
    },
    /// The front-end has not what the rig needs.
    Unfit {
        /// Its path.
        port: String,
        /// What it calls itself.
        front_end: String,
        /// What is needed, and what it has.
        reason: String,
    },
    /// The rig file and the front-end contradict each other.
    Contradiction {
        /// The channel.
        channel: String,
        /// The key of the rig file.
        key: &'static str,
        /// What it says, and what the front-end says.
        reason: String,
    },
    /// The thread that keeps the line cannot be started.
    Thread(io::Error),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::NoPort => f.write_str("the rig file names no port: backend.serial.port"),
            Error::Open { port, error } => write!(f, "{port} cannot be opened: {error}"),
            Error::NotALine { port } => write!(f, "{port} is no serial line"),
            Error::Taken { port } => write!(f, "{port} is used by another process"),
            Error::Line { port, error } => write!(f, "{port}: {error}"),
            Error::Silent { port } => write!(f, "no front-end answers on {port}"),
            Error::Version { port, found } => write!(
                f,
                "the front-end on {port} speaks version {found} of the protocol, expected {}",
                sinew_front_end::VERSION
            ),
            Error::Unfit { port, front_end, reason } => write!(f, "front-end {front_end} on {port}: {reason}"),
            Error::Contradiction { channel, key, reason } => write!(f, "channel \"{channel}\": {key} {reason}"),
            Error::Thread(error) => write!(f, "the thread that keeps the line cannot be started: {error}"),
        }
    }
}

impl std::error::Error for Error {}
