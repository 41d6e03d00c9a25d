//! The cycles of the last seconds, in blocks, within a bound of memory.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use sinew_ipc::{ChannelState, CycleHeader};
use sinew_recorder::Block;

/// Bytes of a block; a cycle that is larger is a block of its own.
const BLOCK_BYTES: usize = 256 << 10;

/// A block that counts itself among the memory in use as long as anybody has it.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) block: Block,
    bytes: u64,
    in_use: Arc<AtomicU64>,
}

impl Drop for Kept {
    fn drop(&mut self) {
        self.in_use.fetch_sub(self.bytes, Ordering::AcqRel);
    }
}

/// The last cycles, oldest first.
#[derive(Debug)]
pub(crate) struct History {
    full: VecDeque<Arc<Kept>>,
    /// `None` only where there is no memory at all.
    filling: Option<Kept>,
    in_use: Arc<AtomicU64>,
    limit: u64,
    channels: usize,
    cycles_per_block: usize,
}

impl History {
    /// Of cycles of so many channels, in at most so many bytes.
    pub(crate) fn new(channels: usize, limit: u64) -> History {
        let cycles_per_block = (BLOCK_BYTES / (channels.max(1) * size_of::<ChannelState>())).max(1);
        History {
            full: VecDeque::new(),
            filling: None,
            in_use: Arc::new(AtomicU64::new(0)),
            limit,
            channels,
            cycles_per_block,
        }
    }

    /// Adds a cycle, and forgets those before `from_ns`, and older ones yet where there is no room.
    pub(crate) fn push(&mut self, header: &CycleHeader, channels: &[ChannelState], from_ns: u64) {
        if self.filling.as_ref().is_none_or(|kept| kept.block.cycles() >= self.cycles_per_block as u64) {
            if let Some(kept) = self.filling.take() {
                self.full.push_back(Arc::new(kept));
            }
            let mut spare = None;
            while self.full.front().is_some_and(|kept| is_before(kept, from_ns)) {
                spare = self.full.pop_front().and_then(Arc::into_inner).or(spare);
            }
            self.filling = self.empty(spare);
        }
        // Without any memory the cycle is not kept: a gap, which the next file counts.
        if let Some(kept) = &mut self.filling {
            kept.block.push(header, channels);
        }
    }

    /// A block to fill: one that is done with, a new one, or the oldest that nobody writes just now.
    fn empty(&mut self, spare: Option<Kept>) -> Option<Kept> {
        let reuse = |mut kept: Kept| {
            kept.block.clear();
            kept
        };
        if let Some(spare) = spare {
            return Some(reuse(spare));
        }
        let bytes =
            (self.cycles_per_block * (self.channels * size_of::<ChannelState>() + size_of::<CycleHeader>())) as u64;
        if self.in_use.load(Ordering::Acquire) + bytes <= self.limit
            && let Some(block) = Block::with_room(self.cycles_per_block, self.channels)
        {
            self.in_use.fetch_add(bytes, Ordering::AcqRel);
            return Some(Kept { block, bytes, in_use: self.in_use.clone() });
        }
        // What the writer still has becomes free when it has written it.
        while let Some(oldest) = self.full.pop_front() {
            if let Some(kept) = Arc::into_inner(oldest) {
                return Some(reuse(kept));
            }
        }
        None
    }

    /// All blocks that hold a cycle at or after this moment; the present one is closed for it.
    pub(crate) fn since(&mut self, from_ns: u64) -> Vec<Arc<Kept>> {
        if self.filling.as_ref().is_some_and(|kept| kept.block.cycles() > 0)
            && let Some(kept) = self.filling.take()
        {
            self.full.push_back(Arc::new(kept));
        }
        self.full.iter().filter(|kept| !is_before(kept, from_ns)).cloned().collect()
    }
}

/// Whether all of a block's cycles are before this moment.
fn is_before(kept: &Arc<Kept>, from_ns: u64) -> bool {
    kept.block.last().is_none_or(|head| head.monotonic_ns < from_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn fill(history: &mut History, cycles: std::ops::Range<u64>, keep_ns: u64) {
        for cycle in cycles {
            let header = CycleHeader { cycle, monotonic_ns: cycle * MS, missed: 0 };
            let channels = vec![ChannelState { duty: cycle as f64, ..ChannelState::UNKNOWN }; history.channels];
            history.push(&header, &channels, (cycle * MS).saturating_sub(keep_ns));
        }
    }

    fn numbers(blocks: &[Arc<Kept>]) -> Vec<u64> {
        blocks.iter().flat_map(|kept| kept.block.iter().map(|(head, _)| head.cycle)).collect()
    }

    #[test]
    fn it_holds_what_is_asked_for_and_little_more() {
        let mut history = History::new(8, 64 << 20);
        fill(&mut history, 1..20_001, 5000 * MS);
        let in_use = history.in_use.load(Ordering::Relaxed);
        let blocks = history.since(15_000 * MS);
        let found = numbers(&blocks);
        assert!(found[0] <= 15_000 && found[0] > 15_000 - 2 * history.cycles_per_block as u64, "{}", found[0]);
        assert!(found.windows(2).all(|pair| pair[1] == pair[0] + 1) && found.last() == Some(&20_000));
        // Five seconds of 8 channels are 6.7 MB; blocks are reused, not added.
        assert!(in_use < 5001 * 8 * 168 + 4 * (BLOCK_BYTES as u64 + 65_536), "{in_use}");
    }

    #[test]
    fn what_is_being_written_stays_whole_and_counts() {
        let limit = 16 * BLOCK_BYTES as u64;
        let mut history = History::new(8, limit);
        fill(&mut history, 1..1001, u64::MAX);
        let writing = history.since(0);
        let (before, bytes) = (numbers(&writing), history.in_use.load(Ordering::Relaxed));
        assert_eq!(before, (1..1001).collect::<Vec<_>>());
        fill(&mut history, 1001..9001, u64::MAX);
        assert_eq!(numbers(&writing), before, "nothing is written over");
        assert!(history.in_use.load(Ordering::Relaxed) <= limit);
        let left = numbers(&history.since(0));
        assert!(
            left.last() == Some(&9000) && left.windows(2).all(|pair| pair[1] == pair[0] + 1),
            "the newest are kept"
        );
        drop(writing);
        assert!(history.in_use.load(Ordering::Relaxed) <= limit - bytes + BLOCK_BYTES as u64);
        fill(&mut history, 9001..20_001, u64::MAX);
        assert!(numbers(&history.since(0)).len() > left.len(), "and its room is used again");
    }

    #[test]
    fn without_any_room_cycles_are_left_out_and_nothing_breaks() {
        let mut history = History::new(8, 10);
        fill(&mut history, 1..100, u64::MAX);
        assert!(history.since(0).is_empty());
    }
}
