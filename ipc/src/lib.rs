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
//! Which driver runs, and where its services are, stands in its lock file: see [`RigLock`].
//!
//! All that is the driver's user's alone. Other users come in by the [`gateway`], if the rig file opens one.
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
mod remains;
mod run;
mod server;
mod service;
mod stream;
mod sys;

pub use client::{Client, ClientOptions, DriverHealth, FaultChange, FaultWatch};
pub use error::{Error, Reason, Refusal};
pub use fault::{FAULT_TABLE, Fault, FaultRow, fault_table_markdown};
pub use histogram::Histogram;
pub use link::Waiter;
pub use messages::{
    ALL_CHANNELS, BatchHeader, ChannelField, ChannelInfo, ChannelState, Command, CommandKind, CycleHeader, Detail,
    DriverState, FieldKind, HeldCycle, Info, LoopStats, MAX_BATCH, MAX_CHANNELS, Mode, Name, Outcome, PROTOCOL, Replay,
    Reply, Snapshot, field_table_markdown,
};
pub use run::{MAX_RIG_NAME, RigLock, check_rig_name, running, runtime_dir};
pub use server::{CommandServer, CyclePublisher, Request, Server, StateWriter};
pub use stream::{Cycle, CycleStream};
pub use sys::monotonic_ns;
