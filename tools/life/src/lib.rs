//! The account of a wire's life: its cycles counted, what they used of it by the law of
//! [`sinew_physics::formulas::cycles_to_failure`], kept in a file across runs of the driver.
//!
//! A [`Counter`] finds cycles in the transformation (rainflow, ASTM E1049) sample by sample, each with the peaks of stress and heat it went
//! through; an [`Account`] adds up what they used (Miner), and what else is known of the wire: hours powered, the hottest it was, seconds over
//! its limit. [`Accounts::start`] gives a [`sinew_driver::Tap`] to put into a driver, and an ordinary thread that writes; [`of_recording`] reckons
//! with a file; [`Store`] is where the accounts are.
//!
//! Rainflow counting is our own because nothing else carries the peaks of a cycle with it, or can stop in the middle and go on after the next
//! start: what is open is part of the account.
//!
//! # Example
//! ```
//! use sinew_life::{Account, Sample, Wire};
//! use sinew_rig::Rig;
//!
//! let rig = Rig::hexapod();
//! let wire = Wire::of(&rig, 0);
//! let mut account = Account::new(&rig.name, &rig.channels[0].name, true, &wire);
//! // ten times hot and cold again, under 170 MPa and over the whole transformation
//! for step in 0..2000 {
//!     let martensite = 0.5 + 0.5 * (step as f64 / 200.0 * std::f64::consts::TAU).cos();
//!     account.see(&wire, &Sample {
//!         seconds: 0.01,
//!         powered: true,
//!         power_w: 2.0,
//!         martensite,
//!         strain: 0.04 * martensite,
//!         stress_pa: 170e6,
//!         temperature_c: 90.0,
//!     });
//! }
//! let report = account.report();
//! assert!((report.cycles - 10.0).abs() < 0.6, "{}", report.cycles);
//! // table 3: 10^5 to 10^6 of them
//! assert!((report.used.middle / (report.cycles / 10f64.powf(5.5)) - 1.0).abs() < 0.02);
//! ```
#![forbid(unsafe_code)]

mod account;
mod counter;
mod error;
mod keep;
mod recording;
mod store;
mod wire;

pub use account::{Account, BrokenIn, Report, SCHEMA, Share};
pub use counter::{Counter, Cycle, LEAST_SHARE, MOST_OPEN, Moment};
pub use error::Error;
pub use keep::{Accounts, Kept};
pub use recording::of_recording;
pub use store::Store;
pub use wire::{Identity, Sample, Wire};
