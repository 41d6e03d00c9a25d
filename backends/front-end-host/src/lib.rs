//! The front-end's firmware as a process: simulated wires behind it, a pseudo-terminal or a real line before it.
//!
//! The same [`Firmware`](sinew_front_end::Firmware) a microcontroller runs, so that the driver and a front-end can be tested as
//! two processes. [`Host`] runs it on a thread; [`Order`]s spoil the line, take it away, break a power stage; [`Told`] is
//! what happened, with the time it did.
#![forbid(unsafe_code)]

mod error;
mod host;
mod line;
mod port;
mod wires;

pub use error::Error;
pub use host::{Figures, Host, Options, Order, Told, What, run};
pub use line::Spoilt;
