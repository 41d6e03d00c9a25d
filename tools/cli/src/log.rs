//! Words for people: warnings of the driver's ordinary threads, and what the commands print.
//!
//! Where a driver, a recording or a live view runs, no words may stand between a signal or a command and what it is for: a terminal that is
//! stopped, or a pipe nobody reads, must not make anybody wait. There they go through a [bounded queue](Queue), which a thread of its own
//! empties, and what finds no room is dropped and counted. Other commands write as commands do, and wait for their reader.

use std::io::{self, Write};
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use sinew_threads::Thread;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use crate::failure::Failure;

/// How many bytes wait for a terminal, or are kept back while the screen is up.
const MOST_HELD: usize = 256 << 10;
/// How long words that are left at the end are waited for while nobody takes any.
const PARTING: Duration = Duration::from_secs(1);
/// How often it is looked whether somebody has asked for the end meanwhile.
const LOOK: Duration = Duration::from_millis(20);

/// Whether words go through the queues.
static QUEUED: AtomicBool = AtomicBool::new(false);
/// Whether errors alone are wanted on stderr.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Set once somebody has asked this process to end.
static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// Set once what is left to be said is not to keep the process from ending.
static PARTS: AtomicBool = AtomicBool::new(false);
/// What came while the screen was up; `None` while it is not.
static HELD_BACK: Mutex<Option<Vec<u8>>> = Mutex::new(None);
static OUT: Queue = Queue::new();
static ERR: Queue = Queue::new();

/// Where words go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Results.
    Out,
    /// Everything else.
    Err,
}

/// Words on their way to a stream.
struct Queue {
    content: Mutex<Content>,
    changed: Condvar,
}

struct Content {
    words: Vec<u8>,
    /// Bytes that found no room since that was last said.
    dropped: u64,
    /// Bytes written so far.
    written: u64,
    /// What was taken out of it is being written.
    is_writing: bool,
    /// Somebody writes what is put in.
    is_emptied: bool,
    /// The stream cannot be written to, as one whose reader is gone.
    broken: Option<io::ErrorKind>,
}

impl Queue {
    const fn new() -> Queue {
        let content =
            Content { words: Vec::new(), dropped: 0, written: 0, is_writing: false, is_emptied: false, broken: None };
        Queue { content: Mutex::new(content), changed: Condvar::new() }
    }

    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts words in, whole, or drops them; they wait for room only where that is so at the end.
    fn put(&self, bytes: &[u8]) -> io::Result<()> {
        let mut content = self.content();
        if PARTS.load(Ordering::Relaxed) {
            content = self.while_it_goes_on(content, |content| content.words.len() + bytes.len() > MOST_HELD);
        }
        if let Some(kind) = content.broken {
            return Err(kind.into());
        }
        let has_room = content.words.is_empty() || content.words.len() + bytes.len() <= MOST_HELD;
        match content.is_emptied && has_room {
            true => content.words.extend_from_slice(bytes),
            false => content.dropped += bytes.len() as u64,
        }
        drop(content);
        self.changed.notify_all();
        Ok(())
    }

    /// Waits while this is so and words are written or nobody has asked for the end.
    fn while_it_goes_on<'a>(
        &'a self,
        mut content: MutexGuard<'a, Content>,
        is_so: impl Fn(&Content) -> bool,
    ) -> MutexGuard<'a, Content> {
        let (mut written, mut since) = (content.written, Instant::now());
        while content.is_emptied && content.broken.is_none() && is_so(&content) {
            if content.written != written {
                (written, since) = (content.written, Instant::now());
            } else if since.elapsed() >= PARTING && (PARTS.load(Ordering::Relaxed) || is_asked()) {
                break;
            }
            content = self.changed.wait_timeout(content, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
        content
    }

    /// Waits until everything is written, but for [`PARTING`] at the most while nobody takes any of it.
    fn settle(&self) {
        drop(self.while_it_goes_on(self.content(), |content| content.is_writing || !content.words.is_empty()));
    }

    /// Writes what is put in from now on.
    fn empty_into(&self, mut stream: impl Write) {
        let mut content = self.content();
        loop {
            while content.words.is_empty() && content.dropped == 0 {
                if sinew_threads::is_struck() {
                    return;
                }
                content = self.changed.wait_timeout(content, 10 * LOOK).unwrap_or_else(PoisonError::into_inner).0;
            }
            let mut words = std::mem::take(&mut content.words);
            let dropped = std::mem::take(&mut content.dropped);
            if dropped > 0 {
                // Behind what found room before it.
                words.extend_from_slice(format!("({dropped} bytes of messages found no room here)\n").as_bytes());
            }
            content.is_writing = true;
            drop(content);
            // Piece by piece, so that it shows whether anybody takes them.
            for piece in words.chunks(4096) {
                let done = stream.write_all(piece).and_then(|()| stream.flush());
                let mut content = self.content();
                match done {
                    Ok(()) => content.written += piece.len() as u64,
                    Err(error) => content.broken = Some(error.kind()),
                }
                drop(content);
                self.changed.notify_all();
            }
            content = self.content();
            content.is_writing = false;
            self.changed.notify_all();
        }
    }

    /// Starts the thread that empties it, once.
    fn start(&'static self, stream: impl Write + Send + 'static) -> io::Result<()> {
        if std::mem::replace(&mut self.content().is_emptied, true) {
            return Ok(());
        }
        let body = move || {
            let _gone = NobodyEmpties(self);
            self.empty_into(stream);
        };
        Thread::Words.start().ends_when(|| false).spawn(body).map(drop)
    }
}

/// Says that nobody writes what is put in any more.
struct NobodyEmpties(&'static Queue);

impl Drop for NobodyEmpties {
    fn drop(&mut self) {
        self.0.content().is_emptied = false;
        self.0.changed.notify_all();
    }
}

/// How much is said on stderr beside what a command is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wordiness {
    /// Errors alone.
    Quiet,
    /// Our own information, everybody's warnings.
    Usual,
    /// Everybody's information, our own details.
    Wordy,
    /// All there is.
    Everything,
}

impl Wordiness {
    fn targets(self) -> Targets {
        let (ours, others) = match self {
            Wordiness::Quiet => (LevelFilter::ERROR, LevelFilter::ERROR),
            Wordiness::Usual => (LevelFilter::INFO, LevelFilter::WARN),
            Wordiness::Wordy => (LevelFilter::DEBUG, LevelFilter::INFO),
            Wordiness::Everything => (LevelFilter::TRACE, LevelFilter::TRACE),
        };
        Targets::new().with_default(others).with_target("sinew", ours)
    }
}

/// Sets up logging, of panics among what is logged. `RUST_LOG`, where it is set and can be read, has the last word.
pub fn start(wordiness: Wordiness) {
    QUIET.store(wordiness == Wordiness::Quiet, Ordering::Relaxed);
    let asked = std::env::var("RUST_LOG").ok().filter(|asked| !asked.is_empty());
    let (targets, misread) = match asked.map(|asked| asked.parse::<Targets>()) {
        Some(Ok(targets)) => (targets, None),
        Some(Err(error)) => (wordiness.targets(), Some(error)),
        None => (wordiness.targets(), None),
    };
    let layer =
        tracing_subscriber::fmt::layer().with_writer(|| Writer).with_ansi(false).with_target(false).without_time();
    tracing_subscriber::registry().with(layer).with(targets).init();
    if let Some(error) = misread {
        tracing::warn!("RUST_LOG cannot be read: {error}; write it like `info` or `sinew_driver=debug,warn`");
    }
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |info| match QUEUED.load(Ordering::Relaxed) {
        true => drop(Writer.write(format!("{info}\n").as_bytes())),
        false => before(info),
    }));
}

/// From now on no words wait. Nor does the terminal stop this process: one in the background that writes to it (`stty tostop`) or reads from it
/// would be, and a driver that stands still leaves its wires as they are. What it writes is shown, what it reads an error.
///
/// # Errors
/// No thread is to be had.
pub fn never_wait() -> Result<(), Failure> {
    let failed = |error: io::Error| Failure::own(format!("no thread to write messages: {error}"));
    OUT.start(io::stdout()).map_err(failed)?;
    ERR.start(io::stderr()).map_err(failed)?;
    #[cfg(driver)]
    for signal in [libc::SIGTTOU, libc::SIGTTIN] {
        // SAFETY: takes plain numbers; nothing here handles these signals.
        unsafe { libc::signal(signal, libc::SIG_IGN) };
    }
    QUEUED.store(true, Ordering::Relaxed);
    Ok(())
}

/// Whether errors alone are wanted on stderr.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Set by the signals that ask this process to end.
pub fn asked() -> &'static Arc<AtomicBool> {
    &ASKED
}

fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// The driver's outputs are zero: words may wait for a moment, but not keep the process from ending.
pub fn part() {
    PARTS.store(true, Ordering::Relaxed);
}

/// Waits for what is left to be written.
pub fn finish() {
    if QUEUED.load(Ordering::Relaxed) {
        OUT.settle();
        ERR.settle();
    }
}

/// Whether all words for stdout have been taken.
pub fn is_through() -> bool {
    let content = OUT.content();
    content.words.is_empty() && !content.is_writing
}

/// Whether nobody can read stdout any more.
pub fn is_gone() -> bool {
    OUT.content().broken.is_some()
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
        // Behind what takes the screen away.
        part();
        finish();
        let held = HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner).take();
        say(&held.unwrap_or_default());
    }
}

/// Drops messages until the guard is dropped, unless more of them is wanted than usual: for whoever tells what happens in words of its own.
pub fn hush() -> Hush {
    let is_wordy = LevelFilter::current() >= LevelFilter::DEBUG;
    if !is_wordy {
        *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
    }
    Hush
}

/// Messages are dropped while this lives.
pub struct Hush;

impl Drop for Hush {
    fn drop(&mut self) {
        *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Writes to stderr. Where nobody listens any more nothing is lost.
pub fn say(bytes: &[u8]) {
    let _ = put(Stream::Err, bytes);
}

/// Writes everything.
///
/// # Errors
/// The stream's own; where words are queued, that of earlier ones.
pub fn put(stream: Stream, bytes: &[u8]) -> io::Result<()> {
    match (QUEUED.load(Ordering::Relaxed), stream) {
        (true, Stream::Out) => OUT.put(bytes),
        (true, Stream::Err) => ERR.put(bytes),
        (false, Stream::Out) => {
            let mut stdout = io::stdout().lock();
            stdout.write_all(bytes).and_then(|()| stdout.flush())
        }
        (false, Stream::Err) => io::stderr().write_all(bytes),
    }
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
                    ERR.content().dropped += over as u64;
                }
            }
            None => put(Stream::Err, bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};
    use std::thread;

    use super::*;

    /// A stream that takes a piece only when it is let.
    struct Gate {
        open: Receiver<()>,
        taken: Sender<Vec<u8>>,
    }

    impl Write for Gate {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.open.recv().map_err(|_| io::ErrorKind::BrokenPipe)?;
            let _ = self.taken.send(bytes.to_vec());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn nobody_waits_for_a_stream_nobody_reads_and_what_found_no_room_is_counted_behind_what_did() {
        let queue: &'static Queue = Box::leak(Box::new(Queue::new()));
        let ((open, is_open), (taken, words)) = (channel(), channel());
        queue.content().is_emptied = true;
        thread::spawn(move || queue.empty_into(Gate { open: is_open, taken }));
        let piece = vec![b'.'; 4096];
        // Whoever empties it stands before the closed gate with the first piece: what follows meets one queue, whenever that thread was woken.
        assert!(queue.put(&piece).is_ok());
        while !queue.content().words.is_empty() {
            thread::sleep(Duration::from_millis(1));
        }
        let began = Instant::now();
        for _ in 1..200 {
            assert!(queue.put(&piece).is_ok());
        }
        assert!(began.elapsed() < PARTING, "{:?}", began.elapsed());
        let held = queue.content().words.len();
        assert!((MOST_HELD - 4096..=MOST_HELD).contains(&held), "{held}");

        // The reader is back: everything that had room, in order, then how much had none.
        let mut read = Vec::new();
        while !read.ends_with(b"here)\n") {
            open.send(()).expect("it is being emptied");
            read.extend(words.recv_timeout(Duration::from_secs(10)).expect("words"));
        }
        let said = String::from_utf8_lossy(&read);
        let said = said.trim_start_matches('.');
        let dropped: usize = said
            .strip_prefix('(')
            .and_then(|said| said.strip_suffix(" bytes of messages found no room here)\n"))
            .and_then(|count| count.parse().ok())
            .expect(said);
        let dots = read.iter().filter(|byte| **byte == b'.').count();
        assert_eq!(dots + dropped, 200 * piece.len());

        // It is gone: whoever writes is told, and does not wait.
        drop(open);
        let _ = queue.put(b"more");
        while queue.content().broken.is_none() {
            thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(queue.put(b"more").unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
