//! The driver: the real-time loop, the safety supervisor, publishing and commands.
//!
//! The data flow of a sample, once a period: [`Backend::exchange`](sinew_backend::Backend::exchange) returns it, [`channel`] computes a
//! length from it, [`supervisor`] decides whether the channel may be powered, its controller computes the duty, which is output
//! with the next exchange, while the cycle's state goes to the blackboard and into the ring.
//!
//! [`Driver::start`] starts all of it for a rig and a backend. The parts can be used alone: [`Engine`] is a cycle without
//! clock, thread or backend.
//!
//! ```
//! use sinew_backend::Sample;
//! use sinew_driver::{Beat, Engine};
//! use sinew_rig::Rig;
//!
//! let mut engine = Engine::at_rest(&Rig::hexapod(), None)?;
//! let samples = [Sample::NONE; 18]; // nothing was sampled yet
//! let mut duty = [1.0; 18];
//! engine.cycle(Beat { now_ns: 0, missed: 0 }, Ok(()), &samples, &mut duty, |_| {});
//! assert_eq!(duty, [0.02; 18], "nothing but the sensing pulse before a sensor has reported");
//! # Ok::<(), sinew_driver::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod baseline;
pub mod budget;
pub mod channel;
mod claims;
pub mod cold;
pub mod commands;
mod cycles;
mod driver;
mod emergency_stop;
mod engine;
mod error;
mod fault_log;
mod grid;
pub mod heat;
mod inbox;
pub mod jam;
pub mod joint;
mod memory;
mod orders;
mod program;
mod publish;
mod ramps;
pub mod report;
pub mod setup;
pub mod stage;
pub mod standstill;
pub mod supervisor;
mod suspension;

pub use cycles::{NoOutlet, Outlet};
pub use driver::{Driver, DriverHandle, Options, Progress, Stats, Stopper, access_of, wish_of};
pub use emergency_stop::{EmergencyStop, SupplySwitch};
pub use engine::Engine;
pub use error::Error;
pub use grid::Pace;
pub use orders::{Answer, Ask, Beat, Event, Occurrence, Order};
pub use program::Program;
pub use publish::Tap;
pub use report::RunReport;
