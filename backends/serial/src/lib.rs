//! A front-end on a serial line as the driver's backend: USB or UART, a microcontroller with PWM and converters behind it.
//!
//! [`SerialBackend::connect`] opens the line, asks who is there, checks that it is what the rig file describes, and tells it
//! what the wires may have. In the loop an exchange is one read and one write that never wait. Should the line go, a thread of
//! the backend's own tries to have it back, and meanwhile every exchange fails: the driver switches off and latches, and the
//! front-end switches off by itself. The protocol is in `docs/front-end.md`.
#![forbid(unsafe_code)]

mod backend;
mod error;
mod figures;
mod keeper;
mod link;
mod plan;
mod port;

pub use backend::SerialBackend;
pub use error::Error;
pub use figures::LineFigures;
