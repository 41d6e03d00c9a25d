//! Message types, services, and the client a robot program links.
//!
//! A driver publishes what it knows and takes commands over shared memory (iceoryx2); a robot program connects with
//! [`Client`]. `docs/client.md` is the guided tour, `examples/gait.rs` a complete program.
//!
//! | service | pattern | carries | written by |
//! |---|---|---|---|
//! | `state` | blackboard | [`Info`], the latest [`Snapshot`], [`LoopStats`] | the real-time loop ([`StateWriter`]) |
//! | `cycles` | publish–subscribe | every cycle, in batches ([`BatchHeader`], [`ChannelState`]) | an ordinary thread ([`CyclePublisher`]) |
//! | `tick` | event | "something new is there" | the same |
//! | `command` | request–response | [`Command`] and [`Reply`] | clients; answered by an ordinary thread ([`CommandServer`]) |
//!
//! What a channel publishes is one table, [`ChannelState::FIELDS`]; what can go wrong with it another, [`FAULT_TABLE`].
//!
//! Which driver runs, and where its services are, stands in its lock file: see [`RigLock`].
//!
//! All that is the driver's user's alone. Other users come in by the [`gateway`], if the rig file opens one.
//!
//! # Example
//! A robot program, with a driver running (`sinew run`):
//!
//! ```no_run
//! use sinew_ipc::Client;
//! use std::time::Duration;
//!
//! let driver = Client::connect("hexapod")?;
//! // 40 % of the stroke; the wire goes off half a second later unless this is sent again
//! driver.set_stroke("front_left_coxa", 0.4, Duration::from_millis(500))?;
//! for (info, state) in driver.channels().iter().zip(driver.latest().channels()) {
//!     println!("{}: {:.2} mm, {}", info.name, 1e3 * state.length_m, state.mode());
//!     if let Some(fault) = state.fault() {
//!         println!("  {}; {}", fault.cause(), fault.remedy());
//!     }
//! }
//! # Ok::<(), sinew_ipc::Error>(())
//! ```
//!
//! The published fields, as a program that writes them into columns finds them:
//!
//! ```
//! use sinew_ipc::ChannelState;
//!
//! let state = ChannelState { resistance_ohm: 9.5, ..ChannelState::UNKNOWN };
//! let resistance = ChannelState::field("resistance_ohm").unwrap();
//! assert_eq!((resistance.unit, resistance.of(&state)), ("Ω", 9.5));
//! ```
#![deny(unsafe_code)]

mod client;
pub mod descriptors;
mod error;
pub mod fault;
pub mod gateway;
mod histogram;
mod janitor;
mod link;
mod memory;
mod messages;
mod names;
mod ours;
mod remains;
mod run;
mod server;
mod service;
mod setpoints;
mod stream;
mod sys;

/// Clocks beside the driver's: see [`Client::clocks`] for those of this machine, [`ClockMap`] for a device's.
pub use sinew_clocks::{Anew, Change, ClockMap, ClockRules, Clocks, Mapped, Reading, Update, monotonic_ns};

pub use client::{Client, ClientOptions, DriverHealth, FaultChange, FaultWatch, Taken, Wanted};
pub use error::{Error, Reason, Refusal};
pub use fault::{FAULT_TABLE, Fault, FaultRow, fault_table_markdown};
pub use histogram::Histogram;
pub use link::Waiter;
pub use messages::{
    ALL_CHANNELS, BatchHeader, ChannelField, ChannelInfo, ChannelState, Command, CommandKind, CycleHeader, Detail,
    DriverState, FieldKind, HeldCycle, Info, LoopStats, MAX_BATCH, MAX_CHANNELS, MOST_PRIORITY, Mode, Name, Outcome,
    PROTOCOL, Replay, Reply, Snapshot, Terms, field_table_markdown,
};
pub use names::{MAX_RIG_NAME, check_rig_name};
pub use ours::own_folder_among;
pub use run::{RigLock, running, runtime_dir};
pub use server::{Asker, CommandServer, CyclePublisher, Request, Server, StateWriter};
pub use setpoints::{Progress, SetpointOptions, Setpoints};
pub use stream::{Cycle, CycleStream};
