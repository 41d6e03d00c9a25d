//! The board: the latest state, the loop's figures, the recent cycles and the rig file's text, laid out in words of shared memory
//! that one process writes and any number read without a lock.
//!
//! - What is only the latest (`DoubleBuffer`) has two cells that are written in turn, and a count that says which one is whole. A reader
//!   copies, and looks at the count again; he has to copy once more only if the writer has finished another one
//!   meanwhile, so neither a slow nor a dead writer can hold him up.
//! - The cycles lie in a ring; `head` counts those that are complete. Who has copied one looks at `head` again: was the writer
//!   about to overwrite it, the copy is thrown away. The numbers of the cycles tell exactly what was lost.
//!
//! Every word is an atomic, so nothing here is a data race; the order is kept by fences, as in a sequence lock.

use super::pages::{Read, Written};
use crate::{ChannelState, CycleHeader, Info, LoopStats, MAX_CHANNELS, PROTOCOL, Snapshot};
use rustix::thread::futex;
use std::io;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};
use std::time::Duration;
use zerocopy::{FromBytes, FromZeros, Immutable, IntoBytes};

/// `sinewbrd`, and with it the order of bytes.
const MAGIC: u64 = u64::from_le_bytes(*b"sinewbrd");
/// What the ring of cycles may take, bytes: two seconds up to 64 channels at 3.1 kHz.
const RING_BYTES: usize = 68 << 20;
/// What the ring holds, s, where that fits.
const RING_S: f64 = 2.0;
/// Fewest cycles of a ring.
const FEWEST_SLOTS: usize = 64;
/// Longest text of a rig file, bytes.
const MAX_TEXT: usize = 4 << 20;

// Places, in words.
const AT_MAGIC: usize = 0;
const AT_PROTOCOL: usize = 1;
const AT_CHANNELS: usize = 2;
const AT_SLOTS: usize = 3;
const AT_TEXT_BYTES: usize = 4;
/// The wake-up counter: half a word, raised whenever something is new.
const AT_WAKES: usize = 5;
const AT_HEAD: usize = 6;
const AT_INFO: usize = 8;
const AT_STATE: DoubleBuffer = DoubleBuffer { at: AT_INFO + words_of::<Info>(), words: words_of::<Snapshot>() };
const AT_STATS: DoubleBuffer = DoubleBuffer { at: AT_STATE.end(), words: words_of::<LoopStats>() };
const AT_RING: usize = AT_STATS.end();

/// Words of a cycle's header, and of each of its channels.
const HEAD_WORDS: usize = words_of::<CycleHeader>();
const CHANNEL_WORDS: usize = words_of::<ChannelState>();

const fn words_of<T>() -> usize {
    assert!(size_of::<T>().is_multiple_of(size_of::<u64>()) && align_of::<T>() == align_of::<u64>());
    size_of::<T>() / size_of::<u64>()
}

/// What decides the size of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    channels: usize,
    slots: usize,
    text_bytes: usize,
}

impl Shape {
    /// For a rig.
    pub fn of(info: &Info, text: &str) -> Shape {
        let channels = info.channels().len();
        let fitting = RING_BYTES / (slot_words(channels) * size_of::<u64>());
        let wanted = (RING_S * info.rate_hz).ceil() as usize;
        Shape { channels, slots: wanted.min(fitting).max(FEWEST_SLOTS), text_bytes: text.len().min(MAX_TEXT) }
    }

    fn text_at(&self) -> usize {
        AT_RING + self.slots * slot_words(self.channels)
    }

    fn words(&self) -> usize {
        self.text_at() + self.text_bytes.div_ceil(size_of::<u64>())
    }

    /// What memory that somebody handed over says of itself, if that can be.
    fn found(words: &[AtomicU64]) -> io::Result<Shape> {
        let wrong = || io::Error::other("what it handed over is no board of this version");
        let number = |at: usize| usize::try_from(words[at].load(Ordering::Relaxed)).unwrap_or(usize::MAX);
        if words.len() < AT_RING || words[AT_MAGIC].load(Ordering::Relaxed) != MAGIC {
            return Err(wrong());
        }
        if number(AT_PROTOCOL) != PROTOCOL as usize {
            return Err(wrong());
        }
        let shape = Shape { channels: number(AT_CHANNELS), slots: number(AT_SLOTS), text_bytes: number(AT_TEXT_BYTES) };
        let possible = (1..=MAX_CHANNELS).contains(&shape.channels)
            && (1..=RING_BYTES).contains(&shape.slots)
            && shape.text_bytes <= MAX_TEXT
            && shape.words() <= words.len();
        if possible { Ok(shape) } else { Err(wrong()) }
    }
}

const fn slot_words(channels: usize) -> usize {
    HEAD_WORDS + channels * CHANNEL_WORDS
}

pub(super) fn store(words: &[AtomicU64], bytes: &[u8]) {
    for (word, bytes) in words.iter().zip(bytes.chunks(size_of::<u64>())) {
        let mut whole = [0; size_of::<u64>()];
        whole[..bytes.len()].copy_from_slice(bytes);
        word.store(u64::from_ne_bytes(whole), Ordering::Relaxed);
    }
}

fn load(words: &[AtomicU64], bytes: &mut [u8]) {
    for (word, bytes) in words.iter().zip(bytes.chunks_mut(size_of::<u64>())) {
        bytes.copy_from_slice(&word.load(Ordering::Relaxed).to_ne_bytes()[..bytes.len()]);
    }
}

/// A value of which only the latest matters.
#[derive(Clone, Copy)]
struct DoubleBuffer {
    at: usize,
    words: usize,
}

impl DoubleBuffer {
    const fn end(&self) -> usize {
        self.at + 1 + 2 * self.words
    }

    fn count<'a>(&self, all: &'a [AtomicU64]) -> &'a AtomicU64 {
        &all[self.at]
    }

    fn cell<'a>(&self, all: &'a [AtomicU64], count: u64) -> &'a [AtomicU64] {
        let at = self.at + 1 + (count % 2) as usize * self.words;
        &all[at..at + self.words]
    }

    fn write(&self, all: &[AtomicU64], value: &[u8]) {
        let count = self.count(all).load(Ordering::Relaxed) + 1;
        // Who sees any word of this cell changed sees the count of the write before as well.
        fence(Ordering::Release);
        store(self.cell(all, count), value);
        self.count(all).store(count, Ordering::Release);
    }

    fn read(&self, all: &[AtomicU64], value: &mut [u8]) {
        let mut count = self.count(all).load(Ordering::Acquire);
        loop {
            load(self.cell(all, count), value);
            fence(Ordering::Acquire);
            let now = self.count(all).load(Ordering::Relaxed);
            if now == count {
                return;
            }
            count = self.count(all).load(Ordering::Acquire);
        }
    }
}

/// The writer's side; for an ordinary thread.
pub(crate) struct Board {
    pages: Written,
    shape: Shape,
    /// Cycles written.
    head: u64,
}

impl Board {
    /// A new one, with everything on it that does not change.
    pub fn new(info: &Info, text: &str) -> io::Result<Board> {
        let shape = Shape::of(info, text);
        let pages = Written::new(shape.words())?;
        let words = pages.words();
        store(&words[AT_INFO..][..words_of::<Info>()], info.as_bytes());
        store(&words[shape.text_at()..], &text.as_bytes()[..shape.text_bytes]);
        let mut first = Snapshot::new(shape.channels);
        first.monotonic_ns = info.started_ns;
        AT_STATE.write(words, first.as_bytes());
        AT_STATS.write(words, LoopStats::new().as_bytes());
        for (at, value) in [
            (AT_PROTOCOL, u64::from(PROTOCOL)),
            (AT_CHANNELS, shape.channels as u64),
            (AT_SLOTS, shape.slots as u64),
            (AT_TEXT_BYTES, shape.text_bytes as u64),
            (AT_MAGIC, MAGIC),
        ] {
            words[at].store(value, Ordering::Release);
        }
        Ok(Board { pages, shape, head: 0 })
    }

    /// To be handed out: nobody can write through it.
    pub fn read_only(&self) -> BorrowedFd<'_> {
        self.pages.read_only()
    }

    /// Makes this the latest state.
    pub fn show(&self, snapshot: &Snapshot) {
        AT_STATE.write(self.pages.words(), snapshot.as_bytes());
    }

    /// All of its memory.
    pub fn bytes(&self) -> Vec<u8> {
        let words = self.pages.words();
        let mut bytes = vec![0; size_of_val(words)];
        load(words, &mut bytes);
        bytes
    }

    /// Makes these the latest figures of the loop.
    pub fn show_stats(&self, stats: &LoopStats) {
        AT_STATS.write(self.pages.words(), stats.as_bytes());
    }

    /// Adds a cycle to the ring. There are as many channels as the rig has.
    pub fn push(&mut self, header: CycleHeader, channels: &[ChannelState]) {
        let words = self.pages.words();
        let at = AT_RING + (self.head % self.shape.slots as u64) as usize * slot_words(self.shape.channels);
        let slot = &words[at..at + slot_words(self.shape.channels)];
        // Who sees any word of this slot changed sees the head of the cycle before as well.
        fence(Ordering::Release);
        store(&slot[..HEAD_WORDS], header.as_bytes());
        store(&slot[HEAD_WORDS..], channels[..self.shape.channels].as_bytes());
        self.head += 1;
        words[AT_HEAD].store(self.head, Ordering::Release);
    }

    /// Wakes everybody who sleeps until something is new.
    pub fn wake(&self) {
        let counter = self.pages.half(AT_WAKES);
        counter.fetch_add(1, Ordering::Release);
        // Nobody sleeping is no error.
        let _ = futex::wake(counter, futex::Flags::empty(), i32::MAX as u32);
    }
}

/// A reader's side.
pub(crate) struct BoardReader {
    pages: Read,
    shape: Shape,
}

impl BoardReader {
    /// Of what a driver handed over.
    ///
    /// # Errors
    /// When it is not sealed or no board.
    pub fn new(memory: OwnedFd) -> io::Result<BoardReader> {
        let pages = Read::new(memory)?;
        let shape = Shape::found(pages.words())?;
        Ok(BoardReader { pages, shape })
    }

    fn copy<T: FromZeros + FromBytes + IntoBytes + Immutable>(&self, read: impl FnOnce(&[AtomicU64], &mut [u8])) -> T {
        let mut value = T::new_zeroed();
        read(self.pages.words(), value.as_mut_bytes());
        value
    }

    /// What does not change.
    pub fn info(&self) -> Info {
        self.copy(|words, bytes| load(&words[AT_INFO..][..words_of::<Info>()], bytes))
    }

    /// The latest state.
    pub fn latest(&self) -> Snapshot {
        self.copy(|words, bytes| AT_STATE.read(words, bytes))
    }

    /// The latest figures of the loop.
    pub fn stats(&self) -> LoopStats {
        self.copy(|words, bytes| AT_STATS.read(words, bytes))
    }

    /// The rig file's text; `None` where there is none.
    pub fn text(&self) -> Option<String> {
        let mut text = vec![0; self.shape.text_bytes];
        load(&self.pages.words()[self.shape.text_at()..], &mut text);
        (!text.is_empty()).then(|| String::from_utf8_lossy(&text).into_owned())
    }

    /// Channels of a cycle.
    pub fn channels(&self) -> usize {
        self.shape.channels
    }

    /// Cycles written so far; the next one to come has this index.
    pub fn head(&self) -> u64 {
        self.pages.words()[AT_HEAD].load(Ordering::Acquire)
    }

    /// Copies the cycle of this index, or where that one is overwritten already the oldest one that is whole. Returns the index
    /// of the one copied; `None` where the index has not been written yet.
    pub fn cycle(&self, index: u64, header: &mut CycleHeader, channels: &mut [ChannelState]) -> Option<u64> {
        let (words, slots) = (self.pages.words(), self.shape.slots as u64);
        let mut index = index;
        loop {
            let head = self.head();
            if index >= head {
                return None;
            }
            // The slot of `head` may be being written, and it is also that of `head - slots`. Some more are given up, or the writer
            // would be there again before the first one is read.
            if head - index >= slots {
                index = head - (slots - slots / 8 - 1);
            }
            let at = AT_RING + (index % slots) as usize * slot_words(self.shape.channels);
            let slot = &words[at..at + slot_words(self.shape.channels)];
            load(&slot[..HEAD_WORDS], header.as_mut_bytes());
            load(&slot[HEAD_WORDS..], channels.as_mut_bytes());
            fence(Ordering::Acquire);
            if words[AT_HEAD].load(Ordering::Relaxed).wrapping_sub(index) < slots {
                return Some(index);
            }
        }
    }

    /// How often readers have been woken.
    pub fn wakes(&self) -> u32 {
        self.pages.half(AT_WAKES).load(Ordering::Acquire)
    }

    /// Sleeps until readers have been woken more often than `seen`, up to `timeout`. May wake too early.
    pub fn sleep(&self, seen: u32, timeout: Duration) {
        let timeout = futex::Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        // Rung meanwhile, interrupted, timed out: all the same here.
        let _ = futex::wait(self.counter(), futex::Flags::empty(), seen, Some(&timeout));
    }

    fn counter(&self) -> &AtomicU32 {
        self.pages.half(AT_WAKES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ChannelInfo;
    use std::sync::atomic::AtomicBool;

    fn board(channels: usize, rate_hz: f64, text: &str) -> (Board, BoardReader, Info) {
        let info =
            Info::new("bench", rate_hz, &vec![ChannelInfo { max_duty: 0.5, ..ChannelInfo::EMPTY }; channels]).unwrap();
        let board = Board::new(&info, text).unwrap();
        let follower = BoardReader::new(board.read_only().try_clone_to_owned().unwrap()).unwrap();
        (board, follower, info)
    }

    /// A cycle of which every number says its own number.
    fn cycle(number: u64, channels: usize) -> (CycleHeader, Vec<ChannelState>) {
        let header = CycleHeader { cycle: number, monotonic_ns: number * 1000, missed: number };
        let state =
            ChannelState::from_parts(&[number as f64; ChannelState::FLOATS], &[number as u32; ChannelState::CODES]);
        (header, vec![state; channels])
    }

    fn check(header: &CycleHeader, channels: &[ChannelState]) {
        let (expected, states) = cycle(header.cycle, channels.len());
        assert_eq!(*header, expected);
        assert_eq!(channels, states);
    }

    #[test]
    fn what_does_not_change_and_what_is_latest() {
        let text = "[rig]\nname = \"bänch\"\n";
        let (board, follower, info) = board(3, 100.0, text);
        let known = follower.info();
        assert_eq!((known.rig, known.pid, known.channels, known.rate_hz), (info.rig, info.pid, 3, 100.0));
        assert_eq!(known.channels()[2].max_duty, 0.5);
        assert_eq!(follower.text().as_deref(), Some(text));
        assert_eq!(follower.latest().state(), crate::DriverState::Starting);
        let mut snapshot = Snapshot::new(3);
        for n in 1..5 {
            snapshot.cycle = n;
            snapshot.channel[2].duty = n as f64;
            board.show(&snapshot);
            let latest = follower.latest();
            assert_eq!((latest.cycle, latest.channels().len(), latest.channel[2].duty), (n, 3, n as f64));
        }
        let mut stats = LoopStats::new();
        stats.cycles = 17;
        board.show_stats(&stats);
        assert_eq!(follower.stats(), stats);
        assert_eq!(super::BoardReader::text(&self::board(1, 100.0, "").1), None);
    }

    #[test]
    fn a_follower_that_keeps_up_gets_all_and_one_that_sleeps_knows_where_it_stands() {
        let (mut board, follower, _) = board(2, 100.0, "");
        let slots = board.shape.slots as u64;
        assert_eq!(slots, 200);
        let (mut header, mut channels) = (CycleHeader::default(), vec![ChannelState::UNKNOWN; 2]);
        assert_eq!(follower.cycle(0, &mut header, &mut channels), None);
        for n in 0..1000 {
            let (head, states) = cycle(n, 2);
            board.push(head, &states);
            assert_eq!(follower.cycle(n, &mut header, &mut channels), Some(n));
            assert_eq!(header.cycle, n);
            check(&header, &channels);
            assert_eq!(follower.cycle(n + 1, &mut header, &mut channels), None);
        }
        // The oldest that can be had is the one after that of the next slot to be written.
        assert_eq!(follower.cycle(1000 - slots + 1, &mut header, &mut channels), Some(801));
        let oldest = follower.cycle(0, &mut header, &mut channels).unwrap();
        assert!((801..=830).contains(&oldest), "{oldest}");
        check(&header, &channels);
    }

    #[test]
    fn nothing_torn_is_ever_seen() {
        let (mut board, follower, _) = board(8, 1.0, "");
        let over = AtomicBool::new(false);
        let writer = |board: &mut Board| {
            for n in 1..60_000 {
                let (head, states) = cycle(n, 8);
                board.push(head, &states);
                let mut snapshot = Snapshot::new(8);
                (snapshot.cycle, snapshot.monotonic_ns, snapshot.missed) = (n, n * 1000, n);
                snapshot.channel[..8].copy_from_slice(&states);
                board.show(&snapshot);
                board.wake();
            }
        };
        let reader = || {
            let (mut header, mut channels) = (CycleHeader::default(), vec![ChannelState::UNKNOWN; 8]);
            let (mut next, mut last, mut received, mut lost) = (0, 0, 0, 0);
            loop {
                let ended = over.load(Ordering::Acquire);
                let seen = follower.wakes();
                while let Some(index) = follower.cycle(next, &mut header, &mut channels) {
                    check(&header, &channels);
                    assert!(header.cycle > last);
                    lost += header.cycle - last - 1;
                    received += 1;
                    (next, last) = (index + 1, header.cycle);
                }
                let latest = follower.latest();
                if latest.cycle > 0 {
                    check(&latest.header(), latest.channels());
                }
                if ended {
                    assert_eq!((last, received + lost), (59_999, 59_999));
                    return;
                }
                follower.sleep(seen, Duration::from_millis(20));
            }
        };
        std::thread::scope(|scope| {
            let readers = [scope.spawn(reader), scope.spawn(reader)];
            writer(&mut board);
            over.store(true, Ordering::Release);
            readers.into_iter().for_each(|r| r.join().unwrap());
        });
    }

    #[test]
    fn boards_hold_two_seconds_within_their_memory() {
        for (channels, rate_hz, least_s) in [(18, 1000.0, 2.0), (64, 2000.0, 2.0), (64, 5000.0, 1.2), (1, 10.0, 2.0)] {
            let info = Info::new("bench", rate_hz, &vec![ChannelInfo::EMPTY; channels]).unwrap();
            let shape = Shape::of(&info, "");
            assert!(shape.slots as f64 / rate_hz >= least_s, "{shape:?}");
            assert!(shape.words() * 8 <= RING_BYTES + (64 << 10), "{shape:?}");
        }
    }

    #[test]
    fn what_is_no_board_is_not_believed() {
        let (board, _, _) = board(2, 100.0, "text");
        let words = board.pages.words();
        let again = || BoardReader::new(board.read_only().try_clone_to_owned().unwrap()).is_ok();
        for at in [AT_MAGIC, AT_PROTOCOL, AT_CHANNELS, AT_SLOTS, AT_TEXT_BYTES] {
            let right = words[at].load(Ordering::Relaxed);
            for wrong in [u64::MAX, 1 << 40, 0] {
                words[at].store(wrong, Ordering::Relaxed);
                assert!(!again() || (at == AT_TEXT_BYTES && wrong == 0), "{at} {wrong}");
            }
            words[at].store(right, Ordering::Relaxed);
        }
        assert!(again());
    }
}
