//! What every bridge is told.

use std::net::SocketAddr;

/// What every bridge is told.
#[derive(Debug, Clone)]
pub struct Options {
    /// The rig whose driver is watched, through all its restarts.
    pub rig: String,
    /// Where to listen; port 0 = any that is free.
    pub listen: SocketAddr,
}
