//! Backend on Linux's own interfaces: PWM by sysfs for the power stages, IIO for the converters.
//!
//! [`LinuxRig`] is the backend. [`pwm`] and [`iio`] enumerate the kernel's devices and find them by name, [`scan`] is the
//! layout of IIO's buffers, [`mod@line`] the lines beside the outputs, [`guard`] the process that sets the outputs to zero when the
//! driver cannot. `docs/linux-backend.md` has wiring, cost and tests.
//!
//! ```
//! use sinew_linux_backend::scan::{Format, Layout};
//!
//! // two inputs of 12 bits and a timestamp, as the kernel describes them in `scan_elements/*_type`
//! let input = Format::parse("be:s12/16>>4").ok_or("unknown format")?;
//! let timestamp = Format::parse("le:s64/64>>0").ok_or("unknown format")?;
//! let layout = Layout::of(&[(0, input), (1, input), (2, timestamp)]);
//! assert_eq!((layout.offsets, layout.bytes), (vec![0, 2, 8], 16));
//! assert_eq!(input.value(&[0xff, 0xf0]), Some(-1));
//! # Ok::<(), &str>(())
//! ```
//!
//! Driving the outputs of this machine:
//!
//! ```no_run
//! use sinew_linux_backend::{LinuxRig, Settings};
//!
//! let rig = sinew_rig::Rig::load("my-rig.toml".as_ref())?;
//! let backend = LinuxRig::new(Settings::of_rig(&rig))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod alone;
mod backend;
mod error;
pub mod guard;
pub mod iio;
pub mod line;
mod mender;
pub mod pwm;
mod sampler;
pub mod scan;
mod settings;
mod supply;
mod sysfs;

pub use backend::LinuxRig;
pub use error::Error;
pub use settings::{ChannelSettings, EnableSettings, Inputs, Settings, StopSettings};
