//! Which time of another clock a time stamp of the driver's is, with its error.
//!
//! Every stamp of a driver is CLOCK_MONOTONIC in ns. [`Reading`] says what the clocks of the same machine show at such an instant;
//! [`ClockMap`] learns the clock of another device, a data acquisition's or a camera's, from pairs of times. Each answer is a
//! [`Mapped`]: a time and what it is off by at the most.
//!
//! | module | what it knows |
//! |---|---|
//! | `reading` | the clocks of this machine beside each other |
//! | `change` | what became of the system's clock between two readings: set, slewed, suspended |
//! | `map` | a device's clock from pairs of times |
//!
//! ```
//! use sinew_clocks::{ClockMap, ClockRules};
//!
//! let mut daq = ClockMap::new(ClockRules::default());
//! // its counter was asked twice, 10 s apart; the driver's clock was read before and after, ns
//! daq.bracket(5_000_000_000, 100_000, 5_000_040_000);
//! daq.bracket(15_000_000_000, 10_000_300_000, 15_000_040_000);
//! let when = daq.driver_at(5_000_200_000).unwrap();
//! assert!(when.ns.abs_diff(10_000_000_000 - 30_000) < 100_000 && when.error_ns < 300_000);
//! let (ppm, error_ppm) = daq.rate_ppm().unwrap();
//! assert!((ppm - 20.0).abs() <= error_ppm);
//! ```
#![deny(unsafe_code)]

mod change;
mod map;
mod mapped;
#[cfg(target_os = "linux")]
mod reading;

pub use change::{Change, History, Reading, Step};
pub use map::{Anew, ClockMap, ClockRules, Update};
pub use mapped::Mapped;
#[cfg(target_os = "linux")]
pub use reading::{Clocks, monotonic_ns};
