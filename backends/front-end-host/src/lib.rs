//! The front-end's firmware as a process, with simulated wires, on a pseudo-terminal or a real line.
//!
//! The same [`Firmware`](sinew_front_end::Firmware) a microcontroller runs, so that the driver and a front-end can be tested as
//! two processes. [`Host`] runs it on a thread; [`Order`]s damage bytes on the line, disconnect it, break a power stage;
//! [`Told`] is an event with its time. [`Wrong`] is a mistake in the wiring of the board, [`Mount`] what is at its terminals: what
//! `sinew bringup` is tried against.
//!
//! ```no_run
//! use sinew_front_end_host::{Host, Options};
//!
//! // the built-in hexapod's wires behind a front-end, for a driver with `port = "/tmp/front-end"`
//! let options = Options { link: Some("/tmp/front-end".into()), ..Options::default() };
//! let host = Host::start(&sinew_rig::Rig::hexapod(), options)?;
//! println!("on {}", host.path().display());
//! # Ok::<(), sinew_front_end_host::Error>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod host;
mod line;
mod port;
mod truth;
mod wires;
mod wiring;

pub use error::Error;
pub use host::{Figures, Host, Options, Order, Told, What, run};
pub use line::Spoilt;
pub use wiring::{Input, Mount, Wrong};
