//! Words for people: warnings of the driver's ordinary threads, and what the commands print.
//!
//! While a driver runs no words may stand between a signal or a command and its outputs: a terminal that is stopped, or a pipe nobody
//! reads, must not make anybody wait. Then what does not fit is dropped and counted. Otherwise words wait for their reader, as
//! everywhere.

use std::io::{self, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// A pipe that has room has room for so many bytes (PIPE_BUF), and a write of no more does not wait.
const AT_ONCE: usize = 4096;
/// How many bytes are kept back while the screen is up; the oldest go first.
const MOST_HELD: usize = 256 << 10;
/// How long words are waited for once outputs are zero, ms.
const PARTING_MS: i32 = 1000;
const FOR_EVER: i32 = -1;

/// How long words may wait for room, ms.
static PATIENCE_MS: AtomicI32 = AtomicI32::new(FOR_EVER);
/// What was dropped since that was last said.
static DROPPED: AtomicU64 = AtomicU64::new(0);
/// What came while the screen was up; `None` while it is not.
static HELD_BACK: Mutex<Option<Vec<u8>>> = Mutex::new(None);

/// Sets up logging of warnings and errors.
pub fn start() {
    tracing_subscriber::fmt()
        .with_max_level(tracing::Level::WARN)
        .with_writer(|| Writer)
        .with_ansi(false)
        .with_target(false)
        .without_time()
        .init();
}

/// From now on no words wait: a driver runs.
pub fn never_wait() {
    PATIENCE_MS.store(0, Ordering::Relaxed);
}

/// The driver's outputs are zero: words may wait for a moment, but not keep the process from ending.
pub fn part() {
    PATIENCE_MS.store(PARTING_MS, Ordering::Relaxed);
}

/// Keeps messages back until the guard is dropped, then prints them.
pub fn hold_back() -> HoldBack {
    *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
    HoldBack
}

/// Messages are kept back while this lives.
pub struct HoldBack;

impl Drop for HoldBack {
    fn drop(&mut self) {
        let held = HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner).take();
        let _ = put(&mut io::stderr(), &held.unwrap_or_default());
    }
}

/// Writes to stderr.
pub fn say(bytes: &[u8]) {
    // One at a time: between the look whether there is room and the write nobody else may take it.
    let _alone = HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = put(&mut io::stderr(), bytes);
}

/// Writes everything, or as much as there is room for where nothing waits; whether that was everything.
///
/// # Errors
/// The stream's own.
pub fn put<S: Write + AsFd>(stream: &mut S, bytes: &[u8]) -> io::Result<bool> {
    let patience_ms = PATIENCE_MS.load(Ordering::Relaxed);
    if patience_ms == FOR_EVER {
        return stream.write_all(bytes).map(|()| true);
    }
    let missing = DROPPED.load(Ordering::Relaxed);
    if missing > 0 && has_room(stream.as_fd(), patience_ms) {
        DROPPED.fetch_sub(missing, Ordering::Relaxed);
        stream.write_all(format!("({missing} bytes of messages found no room here)\n").as_bytes())?;
    }
    for (number, part) in bytes.chunks(AT_ONCE).enumerate() {
        if !has_room(stream.as_fd(), patience_ms) {
            let left = bytes.len() - number * AT_ONCE;
            DROPPED.fetch_add(left as u64, Ordering::Relaxed);
            return Ok(false);
        }
        stream.write_all(part)?;
    }
    Ok(true)
}

/// Whether a write of [`AT_ONCE`] bytes would not wait, or would fail at once.
fn has_room(stream: BorrowedFd<'_>, patience_ms: i32) -> bool {
    let mut streams = [PollFd::new(&stream, PollFlags::OUT)];
    let timeout =
        Timespec { tv_sec: i64::from(patience_ms / 1000), tv_nsec: i64::from(patience_ms % 1000) * 1_000_000 };
    matches!(poll(&mut streams, Some(&timeout)), Ok(1..))
}

struct Writer;

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(held) => {
                held.extend_from_slice(bytes);
                let over = held.len().saturating_sub(MOST_HELD);
                if over > 0 {
                    held.drain(..over);
                    DROPPED.fetch_add(over as u64, Ordering::Relaxed);
                }
            }
            None => drop(put(&mut io::stderr(), bytes)?),
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
