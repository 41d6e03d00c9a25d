//! Errors of connecting to a front-end.

use std::fmt;
use std::io;

use sinew_front_end::VERSION;

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

impl Error {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Error::NoPort | Error::NotALine { .. } => "backend.serial.port names the device, such as /dev/ttyACM0",
            Error::Open { .. } => {
                "plug it in, and see that you may open it: `ls -l /dev/serial/by-id`, `sudo usermod -aG dialout $USER`"
            }
            Error::Taken { .. } => "is another driver running? `sinew status`",
            Error::Silent { .. } => "is it powered, is its firmware a front-end's, is backend.serial.baud_hz its own?",
            Error::Version { .. } => "firmware and driver are of one release: docs/front-end.md says how to port it",
            Error::Unfit { .. } | Error::Contradiction { .. } => "mend the rig file, or use another front-end",
            Error::Line { .. } => "unplug it and plug it in again",
            Error::Thread(_) => "end some of this user's processes: the system allows no more threads",
        }
    }
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
            Error::Version { port, found } => {
                let remedy = if *found < VERSION { "flash the firmware" } else { "use the driver" };
                let of = if *found < VERSION { "this" } else { "its" };
                write!(
                    f,
                    "the front-end on {port} speaks protocol {found}, this driver {VERSION}: {remedy} of {of} release"
                )
            }
            Error::Unfit { port, front_end, reason } => write!(f, "front-end {front_end} on {port}: {reason}"),
            Error::Contradiction { channel, key, reason } => write!(f, "channel \"{channel}\": {key} {reason}"),
            Error::Thread(error) => write!(f, "the thread that keeps the line cannot be started: {error}"),
        }
    }
}

impl std::error::Error for Error {}
