//! Backend on Linux's own interfaces: PWM by sysfs for the power stages, IIO for the converters.
//!
//! [`LinuxRig`] is the backend. [`pwm`] and [`iio`] enumerate the kernel's devices and find them by name, [`scan`] is the layout
//! of IIO's buffers, [`guard`] the process that sets the outputs to zero when the driver cannot. `docs/linux-backend.md` has
//! wiring, cost and tests.
#![forbid(unsafe_code)]

mod backend;
mod error;
pub mod guard;
pub mod iio;
mod mender;
pub mod pwm;
mod sampler;
pub mod scan;
mod settings;
mod sysfs;

pub use backend::LinuxRig;
pub use error::Error;
pub use settings::{ChannelSettings, Inputs, Settings};
