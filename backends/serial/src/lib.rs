//! A front-end on a serial line as the driver's backend: USB or UART, a microcontroller with PWM and converters behind it.
//!
//! [`SerialBackend::connect`] opens the line, identifies the front-end, checks that it matches the rig file, and sends it
//! the limits of the wires. In the loop an exchange is one non-blocking read and one non-blocking write. When the line is lost, a separate
//! thread reconnects it, and meanwhile every exchange fails: the driver switches off and latches, and the
//! front-end switches off by itself. The protocol is in `docs/front-end.md`.
//!
//! ```no_run
//! use sinew_serial_backend::SerialBackend;
//!
//! let rig = sinew_rig::Rig::load("my-rig.toml".as_ref())?; // [backend] kind = "serial"
//! let backend = SerialBackend::connect(&rig)?;
//! println!("{}", backend.front_end());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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

/// Opens a serial line for this process alone, for whoever wants what is on it rather than a front-end: raw, non-blocking,
/// nothing left over of what came before.
///
/// # Errors
/// [`Error::Open`], [`Error::NotALine`], [`Error::Taken`], [`Error::Line`].
pub fn open_line(path: &str, baud_hz: u32) -> Result<std::os::fd::OwnedFd, Error> {
    port::Port::open(path, baud_hz).map(port::Port::into_fd)
}
