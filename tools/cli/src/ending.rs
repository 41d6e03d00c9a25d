//! What asks a process to end: Ctrl-C, SIGTERM, or the terminal is gone.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::failure::Failure;
use crate::log;

/// The signals that do.
#[cfg(unix)]
pub const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
pub const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// Set once somebody asks this process to end.
///
/// # Errors
/// A signal cannot be handled.
pub fn asked() -> Result<Arc<AtomicBool>, Failure> {
    let asked = Arc::clone(log::asked());
    for signal in SIGNALS {
        signal_hook::flag::register(signal, Arc::clone(&asked))
            .map_err(|error| Failure::own(format!("signal {signal} cannot be handled: {error}")))?;
    }
    Ok(asked)
}
