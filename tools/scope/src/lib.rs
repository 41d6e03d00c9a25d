//! A running driver in a browser: a live page on loopback.
//!
//! An ordinary thread (`watch`) reads every cycle as any client does, so the driver notices no more of it than of a
//! second monitor. It keeps the last while of everything in a ring of bins (`history`). Each open page says which
//! channels and quantities it shows, and gets these, what is new some sixty times a second and what was before when it
//! asks (`session`). A page that cannot keep up gets fewer and longer frames; what falls out of the ring meanwhile is
//! counted and shown as a gap. Nothing it does, or does not, reaches back to the thread that reads.
//!
//! The page commands only if it was opened by the address with the token, and only with leases it keeps renewing
//! (`door`, `command`).
//!
//! # Example
//! ```no_run
//! use sinew_scope::{Options, Scope};
//!
//! let options = Options { rig: "hexapod".into(), port: 0, record_dir: ".".into(), commands: false };
//! let scope = Scope::open(options)?;
//! println!("open {}", scope.url(false));
//! scope.serve(|| false)?; // until the closure says that it is time
//! # Ok::<(), sinew_scope::Error>(())
//! ```
#![forbid(unsafe_code)]

mod command;
mod door;
mod error;
mod history;
mod page;
mod quantity;
mod record;
mod server;
mod session;
mod shared;
mod view;
mod watch;

use std::path::PathBuf;

pub use error::Error;
pub use server::Scope;

/// What kind of scope.
#[derive(Debug, Clone)]
pub struct Options {
    /// The rig whose driver is watched, through all its restarts.
    pub rig: String,
    /// Port of 127.0.0.1; 0 = any that is free.
    pub port: u16,
    /// Where the page's recordings go.
    pub record_dir: PathBuf,
    /// Whether a page with the token may command and record.
    pub commands: bool,
}
