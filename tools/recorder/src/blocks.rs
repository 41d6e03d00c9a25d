//! The buffer between the two threads: blocks of cycles, bounded by the bytes they hold.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use sinew_ipc::{ChannelState, CycleHeader};
use sinew_recording::session::{Ended, Head, LoopFigures};

/// Cycles one after the other, as a recording takes them.
#[derive(Debug, Default)]
pub struct Block {
    heads: Vec<Head>,
    bytes: Vec<u8>,
}

impl Block {
    /// An empty one with room for so many cycles of so many channels; `None` where there is no memory for it.
    pub fn with_room(cycles: usize, channels: usize) -> Option<Block> {
        let mut block = Block::default();
        block.heads.try_reserve_exact(cycles).ok()?;
        block.bytes.try_reserve_exact(cycles * channels * size_of::<ChannelState>()).ok()?;
        Some(block)
    }

    /// Adds a copy of a cycle.
    pub fn push(&mut self, header: &CycleHeader, channels: &[ChannelState]) -> Head {
        let head = Head { cycle: header.cycle, monotonic_ns: header.monotonic_ns, missed: header.missed };
        self.heads.push(head);
        self.bytes.extend_from_slice(ChannelState::bytes_of(channels));
        head
    }

    /// Bytes of all its channels.
    pub fn bytes(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// How many cycles it holds.
    pub fn cycles(&self) -> u64 {
        self.heads.len() as u64
    }

    /// Number and time of the last one.
    pub fn last(&self) -> Option<&Head> {
        self.heads.last()
    }

    /// The cycles, each with the bytes of its channels.
    pub fn iter(&self) -> impl Iterator<Item = (&Head, &[u8])> {
        let stride = self.bytes.len() / self.heads.len().max(1);
        self.heads.iter().zip(self.bytes.chunks_exact(stride.max(1)))
    }

    /// Forgets them and keeps the room.
    pub fn clear(&mut self) {
        self.heads.clear();
        self.bytes.clear();
    }
}

/// What goes through the buffer.
#[derive(Debug)]
pub(crate) enum Item {
    /// Cycles.
    Cycles(Block),
    /// The loop's figures.
    Figures(Box<LoopFigures>),
    /// Nothing more comes; the last cycle there was.
    End(Ended, Head),
}

/// The end things are put into.
#[derive(Debug)]
pub(crate) struct Inlet {
    items: Sender<Item>,
    empty: Receiver<Block>,
    held: Arc<AtomicU64>,
    limit: u64,
}

/// The end things come out of.
#[derive(Debug)]
pub(crate) struct Outlet {
    items: Receiver<Item>,
    empty: Sender<Block>,
    held: Arc<AtomicU64>,
}

/// A buffer of at most so many bytes.
pub(crate) fn buffer(limit: u64, held: Arc<AtomicU64>) -> (Inlet, Outlet) {
    let (items, items_out) = mpsc::channel();
    let (empty_in, empty) = mpsc::channel();
    (Inlet { items, empty, held: held.clone(), limit }, Outlet { items: items_out, empty: empty_in, held })
}

impl Inlet {
    /// Puts a block in and takes an empty one in its place; false when it did not fit and its cycles are lost.
    pub(crate) fn put(&self, block: &mut Block) -> bool {
        let bytes = block.bytes();
        if block.cycles() == 0 {
            return true;
        }
        // Only the other end makes it less, so what fits now does.
        if self.held.load(Ordering::Acquire) + bytes > self.limit {
            block.clear();
            return false;
        }
        self.held.fetch_add(bytes, Ordering::AcqRel);
        let next = self.empty.try_recv().unwrap_or_default();
        // when the other end is gone the recording has failed, which is said elsewhere
        let _ = self.items.send(Item::Cycles(std::mem::replace(block, next)));
        true
    }

    /// Puts something else in, which always fits.
    pub(crate) fn send(&self, item: Item) {
        let _ = self.items.send(item);
    }
}

impl Outlet {
    /// The next thing; `None` when nothing came in time. Should the other end die without a word, that is the end.
    pub(crate) fn next(&self, timeout: Duration) -> Option<Item> {
        match self.items.recv_timeout(timeout) {
            Ok(item) => Some(item),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Item::End(Ended::Stopped, Head::default())),
        }
    }

    /// Gives a block back that has been dealt with.
    pub(crate) fn done(&self, mut block: Block) {
        self.held.fetch_sub(block.bytes(), Ordering::AcqRel);
        block.clear();
        let _ = self.empty.send(block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_holds_so_much_and_no_more() {
        let held = Arc::new(AtomicU64::new(0));
        let (inlet, outlet) = buffer(1000, held.clone());
        let mut block = Block::default();
        let header = CycleHeader { cycle: 1, monotonic_ns: 2, missed: 3 };
        let channels = [ChannelState::UNKNOWN; 2];
        let bytes = size_of_val(&channels) as u64;
        let mut put = |cycle: u64| {
            block.push(&CycleHeader { cycle, ..header }, &channels);
            inlet.put(&mut block)
        };
        assert!(put(1) && put(2));
        assert!(!put(3), "a third would be {} bytes", 3 * bytes);
        assert_eq!(held.load(Ordering::Relaxed), 2 * bytes);
        let Some(Item::Cycles(block)) = outlet.next(Duration::ZERO) else { panic!() };
        let found: Vec<_> = block.iter().map(|(head, bytes)| (head.cycle, bytes.len() as u64)).collect();
        assert_eq!(found, [(1, bytes)]);
        outlet.done(block);
        assert!(put(4));
        drop(inlet);
        let Some(Item::Cycles(block)) = outlet.next(Duration::ZERO) else { panic!() };
        assert_eq!(block.iter().next().unwrap().0.cycle, 2);
    }
}
