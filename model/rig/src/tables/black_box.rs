//! `[black_box]`: what is kept for the moment something breaks.

use crate::declare::rows::*;

table! {
    "black_box":
    "The last seconds before a fault is latched, and what follows, in a file: \
     [black box](recording-sessions.md#the-black-box).";

    /// The black box: the last seconds before a fault, in a file.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BlackBox {
        /// Whether there is one.
        enabled: bool = "enabled", BOOLEAN, Boolean(true);
        /// Time before the fault; less where `memory_mb` does not hold it.
        before_s: f64 = "before_s", number(si("s"), 0.1, 600.0), Number(10.0);
        /// Time after it; faults latched meanwhile are in the same file.
        after_s: f64 = "after_s", number(si("s"), 0.0, 60.0), Number(1.0);
        /// Files of this rig that are kept, the newest.
        keep: u32 = "keep", integer(1, 10_000), Integer(20);
        /// Most memory it takes, MB: 11 s of 64 channels at 2 kHz are 237.
        memory_bytes: u64 = "memory_mb", Kind::Integer { low: 1, high: 65_536, times: 1_000_000 }, Integer(256);
    }
}
