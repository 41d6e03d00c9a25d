//! Errors before the page is open. Later ones are shown on the page.

use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;

use sinew_threads::Thread;

/// Why there is no scope.
#[derive(Debug)]
pub enum Error {
    /// The driver cannot be watched.
    Driver(sinew_ipc::Error),
    /// The port cannot be had.
    Port {
        /// The one asked for.
        port: u16,
        /// In the system's words.
        reason: String,
    },
    /// The address on the network cannot be had.
    Address {
        /// The one asked for.
        address: SocketAddr,
        /// In the system's words.
        reason: String,
    },
    /// The certificate for the network can be neither read nor made.
    Certificate {
        /// The file it is kept in.
        path: PathBuf,
        /// In the system's words.
        reason: String,
    },
    /// The system has no random bits for the token.
    Random {
        /// In the system's words.
        reason: String,
    },
    /// A thread has died without which the pages would show a past that looks like the present.
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
            Error::Driver(error) => write!(f, "{}", error.message()),
            Error::Port { port, reason } => write!(f, "port {port} of 127.0.0.1 cannot be had: {reason}"),
            Error::Address { address, reason } => write!(f, "{address} cannot be had: {reason}"),
            Error::Certificate { path, reason } => write!(f, "{}: the certificate: {reason}", path.display()),
            Error::Random { reason } => write!(f, "no random bits for the token: {reason}"),
            Error::Died(thread) => write!(f, "the thread that {} has died", thread.row().does),
            Error::System { reason } => write!(f, "the server cannot be started: {reason}"),
        }
    }
}

impl std::error::Error for Error {}
