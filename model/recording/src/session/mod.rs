//! Recordings of many channels, every cycle of them: MCAP files that the usual viewers and plain Python open as well.
//!
//! [`SessionWriter`] writes one, [`Session`] reads it. A file has these topics:
//!
//! | topic | a message | |
//! |---|---|---|
//! | [`CYCLES`] | each cycle | its number and time, and every channel by name with the fields of the [`Layout`] |
//! | [`LOOP`] | about a second | [`LoopFigures`]: how the driver's loop did |
//! | [`EVENTS`] | now and then | [`Event`]: faults, gaps, notes |
//!
//! Schemas are ROS 2 message definitions, messages CDR, little endian. Beside them stand the metadata `sinew` ([`About`]) and
//! `sinew.end` ([`Ending`]) and the rig file as the attachment `rig.toml`. Readers go by the schema in the file: files with other
//! fields, those of a later version or of a test machine, are read the same way.
//!
//! A message's `log_time` is the time of day, made of the driver's monotonic clock by one comparison of the two at the start, so it
//! never jumps. Nothing a file claims is believed: lengths are capped ([`MAX_CHUNK`]) and memory grows only with what is there.

mod about;
mod check;
mod chunk;
mod contents;
mod error;
mod file;
mod layout;
mod message;
mod read;
mod recover;
mod size;
mod write;

pub use about::{About, Ended, Ending, Gap};
pub use check::{Checkup, Finding, check};
pub use chunk::MAX_CHUNK;
pub use error::Trouble;
pub use layout::{Field, Kind, Layout, MAX_CHANNELS, MAX_FIELDS};
pub use message::{Durations, Event, FAULT, GAP, LoopFigures, NOTE};
pub use read::{CycleView, Cycles, Session, Size};
pub use recover::{Recovered, recover};
pub use sinew_clocks::{History, Reading, Step};
pub use size::size;
pub use write::{Abandoned, SessionWriter, WriteOptions, close_off};

/// Topic of the cycles.
pub const CYCLES: &str = "/cycles";
/// Topic of what happened.
pub const EVENTS: &str = "/events";
/// Topic of the loop's figures.
pub const LOOP: &str = "/loop";

/// Topic of the clocks of the recording machine beside each other.
pub const CLOCKS: &str = "/clocks";

/// How the schemas of topics are written: ROS 2 message definitions.
pub const SCHEMA_ENCODING: &str = "ros2msg";
/// How messages are encoded: CDR, little endian.
pub const MESSAGE_ENCODING: &str = "cdr";

/// A topic: what its messages are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: &'static str,
    /// The type of its messages.
    pub kind: &'static str,
    /// That type's definition.
    pub schema: String,
}

/// The topics of these channels that a running driver is watched by: [`CYCLES`], [`EVENTS`], [`LOOP`]. A recording has [`CLOCKS`] besides.
pub fn topics(layout: &Layout) -> [Topic; 3] {
    [
        Topic { name: CYCLES, kind: layout::CYCLE_TYPE, schema: layout.text() },
        Topic { name: EVENTS, kind: Event::TYPE, schema: Event::SCHEMA.into() },
        Topic { name: LOOP, kind: LoopFigures::TYPE, schema: LoopFigures::SCHEMA.into() },
    ]
}

/// The topic [`CLOCKS`].
fn clocks_topic() -> Topic {
    Topic { name: CLOCKS, kind: message::CLOCKS_TYPE, schema: message::CLOCKS_SCHEMA.into() }
}

/// Number and time of a cycle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Head {
    /// Number of the cycle, from 1, consecutive over the cycles that ran: a gap is what the recorder lost.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late. They have no cycle number.
    pub missed: u64,
}

impl Head {
    /// Adds the message on [`CYCLES`]: of this cycle, whose channels are `bytes`, one after the other as the layout's fields say,
    /// little endian.
    pub fn encode(&self, bytes: &[u8], message: &mut Vec<u8>) {
        message.extend(message::CDR_LE);
        for value in [self.cycle, self.monotonic_ns, self.missed] {
            message.extend(value.to_le_bytes());
        }
        message.extend_from_slice(bytes);
    }

    fn of_bytes(bytes: &[u8; layout::HEAD_BYTES]) -> Head {
        let (words, _) = bytes.as_chunks::<8>();
        let word = |at: usize| u64::from_le_bytes(words[at]);
        Head { cycle: word(0), monotonic_ns: word(1), missed: word(2) }
    }
}

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Compression {
    /// Not at all.
    None,
    /// LZ4: fast.
    #[default]
    Lz4,
    /// Zstandard: smaller.
    Zstd,
}

impl Compression {
    /// Its name in files and on the command line; that of [`Compression::None`] is empty in files.
    pub const fn name(self) -> &'static str {
        match self {
            Compression::None => "none",
            Compression::Lz4 => "lz4",
            Compression::Zstd => "zstd",
        }
    }

    fn of_name(name: &[u8]) -> Option<Compression> {
        match name {
            b"" => Some(Compression::None),
            b"lz4" => Some(Compression::Lz4),
            b"zstd" => Some(Compression::Zstd),
            _ => None,
        }
    }

    fn of_mcap(self) -> Option<mcap::Compression> {
        match self {
            Compression::None => None,
            Compression::Lz4 => Some(mcap::Compression::Lz4),
            Compression::Zstd => Some(mcap::Compression::Zstd),
        }
    }

    /// The fastest that still is worth it: a recorder has a share of one core.
    const fn level(self) -> u32 {
        match self {
            Compression::None | Compression::Lz4 => 0,
            Compression::Zstd => 1,
        }
    }
}

#[cfg(test)]
mod tests;
