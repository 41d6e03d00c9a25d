//! A whole cycle: the latest state of everything, a cycle on its way to who reads every one, and the header of a batch of them.

use super::fields::ChannelState;
use super::{MAX_BATCH, MAX_CHANNELS};
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// What the driver as a whole is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum DriverState {
    /// Services are there, the loop does not run yet.
    Starting = 0,
    /// The loop runs.
    Running = 1,
    /// Outputs go to zero, the end is near.
    Stopping = 2,
    /// Outputs are zero and stay so; this was the last state.
    Stopped = 3,
}

impl DriverState {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The state with this number; unknown ones count as stopped.
    pub const fn from_code(code: u32) -> DriverState {
        match code {
            0 => DriverState::Starting,
            1 => DriverState::Running,
            2 => DriverState::Stopping,
            _ => DriverState::Stopped,
        }
    }
}

/// What holds for a whole cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::CycleHeader")]
#[repr(C)]
pub struct CycleHeader {
    /// Number of the cycle, from 1, consecutive over the cycles that ran: a gap in the stream is what the reader lost.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late. They have no cycle number.
    pub missed: u64,
}

/// A cycle in memory of its own: on its way through a ring, or kept.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldCycle {
    /// Its number and time.
    pub header: CycleHeader,
    /// All channels, in the rig's order.
    pub channels: Box<[ChannelState]>,
}

impl HeldCycle {
    /// Room for a cycle of so many channels.
    pub fn new(channels: usize) -> HeldCycle {
        HeldCycle { header: CycleHeader::default(), channels: vec![ChannelState::UNKNOWN; channels].into() }
    }

    /// Makes it a copy of this cycle, as far as there is room for channels. Allocates nothing.
    #[inline]
    pub fn copy_from(&mut self, header: CycleHeader, channels: &[ChannelState]) {
        self.header = header;
        let channels = &channels[..channels.len().min(self.channels.len())];
        self.channels[..channels.len()].copy_from_slice(channels);
    }
}

/// The latest state of everything: one consistent cycle.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Snapshot")]
#[repr(C)]
pub struct Snapshot {
    /// Number of the cycle, from 1; 0 before the first.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns; the driver's heartbeat.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late.
    pub missed: u64,
    /// How many of the channels are there.
    pub channels: u32,
    /// What the driver is doing: [`DriverState`].
    pub state: u32,
    /// The channels; [`Snapshot::channels`] of them are there.
    pub channel: [ChannelState; MAX_CHANNELS],
}

impl Snapshot {
    /// Before the first cycle.
    pub const fn new(channels: usize) -> Snapshot {
        Snapshot {
            cycle: 0,
            monotonic_ns: 0,
            missed: 0,
            channels: if channels < MAX_CHANNELS { channels as u32 } else { MAX_CHANNELS as u32 },
            state: DriverState::Starting as u32,
            channel: [ChannelState::UNKNOWN; MAX_CHANNELS],
        }
    }

    /// The channels that are there, in the rig's order.
    pub fn channels(&self) -> &[ChannelState] {
        &self.channel[..(self.channels as usize).min(MAX_CHANNELS)]
    }

    /// What holds for the whole cycle.
    pub fn header(&self) -> CycleHeader {
        CycleHeader { cycle: self.cycle, monotonic_ns: self.monotonic_ns, missed: self.missed }
    }

    /// What the driver is doing.
    pub fn state(&self) -> DriverState {
        DriverState::from_code(self.state)
    }

    /// Copies another one, without the channels that are not there.
    pub fn copy_from(&mut self, other: &Snapshot) {
        let n = (other.channels as usize).min(MAX_CHANNELS);
        self.cycle = other.cycle;
        self.monotonic_ns = other.monotonic_ns;
        self.missed = other.missed;
        self.channels = n as u32;
        self.state = other.state;
        self.channel[..n].copy_from_slice(&other.channel[..n]);
    }
}

impl Default for Snapshot {
    fn default() -> Self {
        Snapshot::new(0)
    }
}

/// Header of one batch of the stream; its payload is the channels of each cycle, one cycle after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::BatchHeader")]
#[repr(C)]
pub struct BatchHeader {
    /// Cycles in this batch.
    pub cycles: u32,
    /// Channels of each.
    pub channels: u32,
    /// The cycles; [`BatchHeader::cycles`] of them are there.
    pub cycle: [CycleHeader; MAX_BATCH],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        // A change here is a change of the protocol: raise PROTOCOL with it.
        assert_eq!(size_of::<Snapshot>(), 32 + size_of::<ChannelState>() * MAX_CHANNELS);
        assert_eq!(size_of::<BatchHeader>(), 8 + 24 * MAX_BATCH);
    }

    #[test]
    fn a_snapshot_never_claims_more_channels_than_fit() {
        assert_eq!(Snapshot::new(1000).channels().len(), MAX_CHANNELS);
        let mut foreign = Snapshot::new(3);
        foreign.channels = u32::MAX;
        assert_eq!(foreign.channels().len(), MAX_CHANNELS);
        let mut copy = Snapshot::new(0);
        copy.copy_from(&foreign);
        assert_eq!(copy.channels().len(), MAX_CHANNELS);
    }
}
