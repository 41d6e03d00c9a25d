//! What travels between the driver and other processes: plain data with a fixed layout, in SI units.
//!
//! | file | what |
//! |---|---|
//! | `fields` | the table of a channel's published fields, and with it [`ChannelState`] and [`PROTOCOL`] |
//! | `channel` | what its codes and flags mean |
//! | `cycle` | a whole cycle: [`Snapshot`], [`HeldCycle`], [`BatchHeader`] |
//! | `name` | [`Name`] |
//! | `info` | what does not change while the driver runs: [`Info`] |
//! | `stats` | how the loop does: [`LoopStats`] |
//! | `command` | [`Command`], [`Terms`] and [`Reply`] |
//!
//! Every change of a layout or of a meaning raises [`PROTOCOL`]. The name iceoryx2 knows a type by is fixed by its `type_name`,
//! whichever file it stands in.

mod channel;
mod command;
mod cycle;
mod fields;
mod info;
mod name;
mod stats;

pub use channel::Mode;
pub use command::{Command, CommandKind, Outcome, Reply, Terms};
pub use cycle::{BatchHeader, CycleHeader, DriverState, HeldCycle, Snapshot};
pub use fields::{ChannelField, ChannelState, Detail, FieldKind, PROTOCOL, Replay, field_table_markdown};
pub use info::{ChannelInfo, Info};
pub use name::Name;
pub use stats::LoopStats;

/// Most channels of a rig.
pub const MAX_CHANNELS: usize = 64;
/// Most cycles in one batch of the stream.
pub const MAX_BATCH: usize = 32;
/// The highest priority of a claim; the lowest is 0.
pub const MOST_PRIORITY: u32 = 9;
/// Channel number of a command that is meant for all of them (off, reset, stop).
pub const ALL_CHANNELS: u32 = u32::MAX;
