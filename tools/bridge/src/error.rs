//! Why a bridge does not come up, or ends.

use std::fmt;
use std::net::SocketAddr;

use sinew_threads::Thread;

/// Why there is no bridge, or none any more.
#[derive(Debug)]
pub enum Error {
    /// The rig cannot have this name.
    Rig(sinew_ipc::Error),
    /// The address cannot be had.
    Address {
        /// The one asked for.
        address: SocketAddr,
        /// In the system's words.
        reason: String,
    },
    /// A thread has died without which what is sent would be a past that looks like the present.
    Died(Thread),
    /// No thread, or no event loop.
    System {
        /// In the system's words.
        reason: String,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Rig(error) => write!(f, "{}", error.message()),
            Error::Address { address, reason } => write!(f, "{address} cannot be listened at: {reason}"),
            Error::Died(thread) => write!(f, "the thread that {} has died", thread.row().does),
            Error::System { reason } => write!(f, "the server cannot be started: {reason}"),
        }
    }
}

impl std::error::Error for Error {}
