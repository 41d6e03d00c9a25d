//! Damages good files in the ways files are damaged: bits flip, bytes go, blocks are lost or doubled, lengths lie.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Values that lengths and counts are most dangerous with.
const EXTREMES: [u64; 8] = [0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, u64::MAX];

/// A seeded source of damage: the same seed gives the same files.
#[derive(Debug)]
pub struct Mutator {
    random: Xoshiro256PlusPlus,
}

impl Mutator {
    /// By a seed.
    pub fn new(seed: u64) -> Mutator {
        Mutator { random: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { self.random.random_range(0..end) }
    }

    /// A place in `bytes` and a length from there, mostly short.
    fn span(&mut self, bytes: &[u8]) -> std::ops::Range<usize> {
        let start = self.below(bytes.len());
        let most = bytes.len() - start;
        let most = if self.below(4) == 0 { most } else { most.min(64) };
        start..start + self.below(most + 1)
    }

    /// `good` with one to eight things wrong with it; parts of `words` (separators, keys, magic bytes) are strewn in.
    pub fn damage(&mut self, good: &[u8], words: &[&[u8]]) -> Vec<u8> {
        let mut bytes = good.to_vec();
        for _ in 0..1 + self.below(8) {
            let at = self.below(bytes.len());
            match self.below(8) {
                0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                1 if !bytes.is_empty() => bytes[at] = self.random.random(),
                2 => bytes.truncate(at),
                3 => {
                    let span = self.span(&bytes);
                    bytes.drain(span);
                }
                4 => {
                    let copy = bytes[self.span(&bytes)].to_vec();
                    bytes.splice(at..at, copy);
                }
                5 => {
                    let value = EXTREMES[self.below(EXTREMES.len())].to_le_bytes();
                    let width = [1, 2, 4, 8][self.below(4)].min(bytes.len() - at);
                    bytes[at..at + width].copy_from_slice(&value[..width]);
                }
                6 if !words.is_empty() => {
                    let word = words[self.below(words.len())];
                    let end = if self.below(2) == 0 { at } else { (at + word.len()).min(bytes.len()) };
                    bytes.splice(at..end, word.iter().copied());
                }
                _ => {
                    let (one, other) = (self.span(&bytes), at);
                    let moved: Vec<u8> = bytes.drain(one).collect();
                    let other = other.min(bytes.len());
                    bytes.splice(other..other, moved);
                }
            }
        }
        bytes
    }
}
