//! A line with faults: it loses, damages, swaps and delays frames, or stops.

use std::collections::VecDeque;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// What is wrong with a line; each is a share of the frames, 0 ..= 1. The default is nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spoilt {
    /// Frames that never arrive.
    pub lost: f64,
    /// Frames in which a bit is turned.
    pub damaged: f64,
    /// Frames that arrive after the next one.
    pub swapped: f64,
    /// How much later every frame arrives, ns.
    pub delay_ns: u64,
}

/// One direction of a line.
#[derive(Debug)]
pub(crate) struct Direction {
    pub spoilt: Spoilt,
    rng: SmallRng,
    /// The frame that is coming in.
    partial: Vec<u8>,
    /// Held back to come after the next.
    held: Option<Vec<u8>>,
    queue: VecDeque<(u64, Vec<u8>)>,
    stalled_until_ns: u64,
}

impl Direction {
    pub fn new(spoilt: Spoilt, seed: u64) -> Direction {
        Direction {
            spoilt,
            rng: SmallRng::seed_from_u64(seed),
            partial: Vec::new(),
            held: None,
            queue: VecDeque::new(),
            stalled_until_ns: 0,
        }
    }

    /// Nothing arrives until then; after that everything at once.
    pub fn stall(&mut self, until_ns: u64) {
        self.stalled_until_ns = until_ns;
    }

    /// Nothing that was under way arrives.
    pub fn clear(&mut self) {
        self.partial.clear();
        self.queue.clear();
        self.held = None;
    }

    /// Puts bytes in.
    pub fn put(&mut self, bytes: &[u8], now_ns: u64) {
        for byte in bytes {
            self.partial.push(*byte);
            if *byte == 0 && self.partial.len() > 1 {
                let frame = std::mem::take(&mut self.partial);
                self.frame(frame, now_ns);
            }
        }
    }

    fn frame(&mut self, mut frame: Vec<u8>, now_ns: u64) {
        let Spoilt { lost, damaged, swapped, delay_ns } = self.spoilt;
        if self.rng.random_bool(lost) {
            return;
        }
        if self.rng.random_bool(damaged) {
            let place = self.rng.random_range(0..frame.len());
            frame[place] ^= 1 << self.rng.random_range(0..8);
        }
        let due_ns = now_ns + delay_ns;
        if self.held.is_none() && self.rng.random_bool(swapped) {
            self.held = Some(frame);
            return;
        }
        self.queue.push_back((due_ns, frame));
        if let Some(held) = self.held.take() {
            self.queue.push_back((due_ns, held));
        }
    }

    /// The next frame that has arrived.
    pub fn arrived(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        if self.due_ns()? > now_ns {
            return None;
        }
        self.queue.pop_front().map(|(_, frame)| frame)
    }

    /// When the next one arrives.
    pub fn due_ns(&self) -> Option<u64> {
        self.queue.front().map(|(due_ns, _)| (*due_ns).max(self.stalled_until_ns))
    }
}
