//! The driver: the real-time loop, the safety supervisor, the contract of backends, publishing and commands.
//!
//! A sample's way through it, once a period and in one direction: [`Backend::exchange`] brings it in, [`channel`] makes a
//! length of it, [`supervisor`] decides whether the channel may be powered, its controller says how much, and the duty goes out
//! with the next exchange, while the cycle's state goes to the blackboard and into the ring.
//!
//! [`Driver::start`] puts it all together for a rig and a backend. The parts stand by themselves: [`Engine`] is a cycle without
//! clock, thread or backend; [`realtime`] asks Linux for what the loop needs; [`conformance`] is the suite a backend has to pass.
#![deny(unsafe_code)]

#[allow(unsafe_code)]
mod allocations;
mod backend;
pub mod baseline;
pub mod budget;
pub mod channel;
pub mod commands;
pub mod conformance;
mod cycles;
mod driver;
mod engine;
mod error;
pub mod joint;
mod program;
mod publish;
#[allow(unsafe_code)]
pub mod realtime;
pub mod report;
mod shutdown_notice;
pub mod stage;
pub mod standstill;
pub mod supervisor;

pub use allocations::{CountingAllocator, calls_of_this_thread, is_counting};
pub use backend::{Backend, BackendError, ChannelFault, Sample, Truth, check_exchange};
pub use cycles::{NoOutlet, Outlet, Pace};
pub use driver::{Driver, DriverHandle, Options, Stats, access_of, wish_of};
pub use engine::{Answer, Ask, Beat, Engine, Event, Occurrence, Order};
pub use error::Error;
pub use program::Program;
pub use publish::Tap;
pub use realtime::RealtimeReport;
pub use report::RunReport;
