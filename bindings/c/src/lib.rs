//! The client of `sinew-ipc` for C, and what C++ stands on: `include/sinew.h` is made from this crate.
//!
//! | file | what |
//! |---|---|
//! | `connection` | connect, close, what does not change |
//! | `state` | the latest state, the loop's figures, every cycle |
//! | `command` | setpoints, `off`, `reset`, `stop` |
//! | `setpoints` | streams of setpoints, which nobody waits for |
//! | `clocks` | the driver's clock, the system's, a device's |
//! | `faults` | faults as they come and go, their words |
//! | `last` | the words of the call that failed last |
//! | `border` | the one place where panics are held up and errors become codes |
//! | `handles` | what C holds of the client: a number, never the address of anything |
//! | `pointers` | what C hands over: looked at before it is used |
//! | `status`, `structs` | codes and plain data |
//!
//! Nothing is decided here: names, limits, refusals and remedies are those of `sinew-ipc`. Only what no Rust program can do (null,
//! text without an end, a handle that is closed) is judged here, and answered like everything else.
#![deny(unsafe_code)]

mod border;
#[allow(unsafe_code)]
mod clocks;
#[allow(unsafe_code)]
mod command;
#[allow(unsafe_code)]
mod connection;
#[allow(unsafe_code)]
mod faults;
mod handles;
#[allow(unsafe_code)]
mod last;
#[allow(unsafe_code)]
mod pointers;
#[allow(unsafe_code)]
mod setpoints;
#[allow(unsafe_code)]
mod state;
mod status;
mod structs;
