//! A running driver in a browser: a live page on loopback, and on the network if it is asked for ([`Network`]). Or, in the same page, a
//! stream of numbers ([`Stream`]).
//!
//! An ordinary thread (`watch`) reads every cycle as any client does, so it loads the driver no more than a second
//! monitor. It keeps the recent history in a ring of bins (`history`). Each open page subscribes to channels and
//! quantities, and receives new samples sixty times a second and the history on request (`session`). A page that cannot
//! keep up gets fewer and longer frames; bins overwritten meanwhile are counted and shown as a gap. A page never blocks
//! the reading thread.
//!
//! A page may command only if it was opened with the token, and only with leases it keeps renewing
//! (`access`, `command`). On the network a page is shown nothing before its user has typed the PIN (`lock`, `entrance`).
//!
//! Whoever opens a scope may say what the machine looks like: it is drawn above the curves ([`Scope::with_picture`]).
//!
//! Clients, bytes and rates are bounded: connections as they come in (`sinew_server`), pages while they are open
//! (`session`). Every refusal is counted.
//!
//! # Example
//! ```no_run
//! use sinew_scope::{Options, Scope};
//!
//! let options = Options { port: 0, record_dir: ".".into(), commands: false, network: None };
//! let scope = Scope::open("hexapod", options)?;
//! println!("open {}", scope.url(false));
//! let figures = scope.figures();
//! scope.serve(|| false)?; // until the closure says that it is time
//! eprintln!("{}", figures());
//! # Ok::<(), sinew_scope::Error>(())
//! ```
#![forbid(unsafe_code)]

mod access;
mod command;
mod entrance;
mod error;
mod history;
mod lock;
mod page;
mod quantity;
mod record;
mod server;
mod session;
mod shared;
mod stream;
mod view;
mod watch;

use std::net::SocketAddr;
use std::path::PathBuf;

pub use entrance::{Event, Invitation};
pub use error::Error;
pub use server::Scope;
pub use sinew_server::Figures;
pub use stream::Stream;
pub use stream::columns::{Came, Column, Columns};
pub use stream::lines::Lines;

/// What kind of scope.
#[derive(Debug, Clone)]
pub struct Options {
    /// Port of 127.0.0.1; 0 = any that is free.
    pub port: u16,
    /// Where the page's recordings go.
    pub record_dir: PathBuf,
    /// Whether a page with the token may command and record.
    pub commands: bool,
    /// Whether it is on the network as well.
    pub network: Option<Network>,
}

/// A scope that others on the network may open: with TLS, and with a PIN before they are shown anything.
#[derive(Debug, Clone)]
pub struct Network {
    /// Where it listens, besides loopback; port 0 = any that is free.
    pub listen: SocketAddr,
    /// The file in which its certificate is kept.
    pub certificate: PathBuf,
    /// Whether a page that had the PIN may command and record, where [`Options::commands`] lets any.
    pub commands: bool,
}
