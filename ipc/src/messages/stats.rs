//! How the loop does: histograms of its timing, its counters, and which means of real time it was granted.

use crate::Histogram;
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// How the loop does: filled by the loop, published some times a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::LoopStats")]
#[repr(C)]
pub struct LoopStats {
    /// How late the loop woke up, ns.
    pub lateness: Histogram,
    /// How long a cycle took, ns.
    pub cycle_time: Histogram,
    /// Time between two cycles, ns.
    pub period: Histogram,
    /// Cycles that ran.
    pub cycles: u64,
    /// Periods skipped because the loop was late.
    pub missed: u64,
    /// Cycles that took longer than a period.
    pub overruns: u64,
    /// Cycles that did not fit into the ring to the publisher, so that no stream has them.
    pub ring_drops: u64,
    /// Allocations inside the loop; 0 unless something is wrong.
    pub allocations: u64,
    /// Commands taken.
    pub commands: u64,
    /// Commands refused.
    pub refusals: u64,
    /// Means of real time that were granted: bits of `LoopStats::RT_…`.
    pub realtime: u32,
    /// Priority under SCHED_FIFO, 0 without.
    pub priority: u32,
    /// Processor the loop is pinned to, −1 without.
    pub cpu: i32,
    /// Threads of the driver that have died, without which it goes on: see [`LoopStats::dead_threads`].
    pub dead: u32,
}

impl LoopStats {
    /// The loop runs under SCHED_FIFO.
    pub const RT_FIFO: u32 = 1;
    /// Memory is locked.
    pub const RT_LOCKED: u32 = 1 << 1;
    /// Stack and heap are prefaulted.
    pub const RT_PREFAULTED: u32 = 1 << 2;
    /// The loop is pinned to a processor.
    pub const RT_PINNED: u32 = 1 << 3;
    /// Timer slack is 1 ns.
    pub const RT_SLACK: u32 = 1 << 4;
    /// `/dev/cpu_dma_latency` is held.
    pub const RT_LATENCY: u32 = 1 << 5;

    /// Each means of real time: its bit and its name.
    pub const REALTIME: [(u32, &'static str); 6] = [
        (LoopStats::RT_FIFO, "SCHED_FIFO"),
        (LoopStats::RT_LOCKED, "memory locked"),
        (LoopStats::RT_PREFAULTED, "prefaulted"),
        (LoopStats::RT_PINNED, "pinned to a core"),
        (LoopStats::RT_SLACK, "timer slack 1 ns"),
        (LoopStats::RT_LATENCY, "cpu_dma_latency held"),
    ];

    /// The threads of the driver that have died, with what is lost by that; none unless something is wrong.
    pub fn dead_threads(&self) -> impl Iterator<Item = &'static sinew_threads::Row> {
        sinew_threads::rows(self.dead)
    }

    /// Before the first cycle.
    pub const fn new() -> LoopStats {
        LoopStats {
            lateness: Histogram::new(),
            cycle_time: Histogram::new(),
            period: Histogram::new(),
            cycles: 0,
            missed: 0,
            overruns: 0,
            ring_drops: 0,
            allocations: 0,
            commands: 0,
            refusals: 0,
            realtime: 0,
            priority: 0,
            cpu: -1,
            dead: 0,
        }
    }
}
