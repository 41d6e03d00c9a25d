//! Bytes for the readers of sessions.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use sinew_recording::session::{Session, check, recover};
use sinew_recording::{Error, Options, read};

use crate::{HEXAPOD, MOST_ROWS, consistent};

/// Checksums are taken out first: else a single damaged byte is all that is ever found.
const WITHOUT_CHECKSUMS: u8 = 1;
/// What is left of the file is recovered, too.
const RECOVER: u8 = 2;
/// Read as a recording of a wire.
const WITH_MODEL: u8 = 4;

/// Errors that are met before the rest of a file is given up: every chunk may have one.
const MOST_ERRORS: usize = 100;

/// Where files are put for readers that want one: in memory where there is such a place.
static SCRATCH: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    folder.join(format!("sinew-hostile-{}", std::process::id()))
});

/// A file that goes when it is done with.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Scratch {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Scratch(PathBuf::from(format!("{}-{number}.mcap", SCRATCH.display())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// Bytes for the readers of sessions: the first is a set of options, the rest the file.
///
/// # Panics
/// Where a reader breaks a promise.
pub fn mcap(bytes: &[u8]) {
    let Some((&choice, file)) = bytes.split_first() else { return };
    let mut file = file.to_vec();
    if choice & WITHOUT_CHECKSUMS != 0 {
        without_checksums(&mut file);
    }
    let (scratch, mended) = (Scratch::new(), Scratch::new());
    if let Err(error) = fs::write(&scratch.0, &file) {
        panic!("{}: {error}", scratch.0.display());
    }
    match Session::open(&scratch.0) {
        Ok(session) => look_through(&session),
        Err(error) => has_remedy(&error),
    }
    let checked = check(&scratch.0, |_, _| {});
    checked.as_ref().err().into_iter().for_each(has_remedy);

    let model = (choice & WITH_MODEL != 0).then_some(&HEXAPOD.channels[0].model);
    match read(&scratch.0, &Options { model, max_rows: MOST_ROWS, ..Options::default() }) {
        Ok(recording) => consistent(&recording),
        Err(error) => has_remedy(&error),
    }
    if choice & RECOVER != 0 {
        match recover(&scratch.0, &mended.0, |_, _| {}) {
            Ok(recovered) => {
                let checkup = check(&mended.0, |_, _| {}).unwrap_or_else(|e| panic!("recovered: {e}"));
                // nothing says that what no checksum holds for is right
                let vouched_for = choice & WITHOUT_CHECKSUMS == 0 && recovered.unchecked == 0;
                assert!(checkup.is_whole() || !vouched_for, "recovered, and still damaged: {checkup:?}");
                assert_eq!(checkup.cycles, recovered.cycles);
            }
            Err(error) => has_remedy(&error),
        }
    }
}

/// Reads all there is, past damaged chunks.
fn look_through(session: &Session) {
    let channels = session.layout().channels.len();
    let mut errors = 0;
    let mut cycles = session.cycles();
    while errors < MOST_ERRORS {
        match cycles.next() {
            Ok(Some(cycle)) => {
                assert_eq!(cycle.bytes().len(), session.layout().bytes());
                let _ = cycle.get(channels - 1, session.layout().fields.len() - 1);
                assert!(cycle.get(channels, 0).is_nan(), "a channel there is none of");
            }
            Ok(None) => break,
            Err(error) => {
                has_remedy(&error);
                errors += 1;
            }
        }
    }
    let mut part = session.cycles_between(0.001, 0.01);
    while let Ok(Some(cycle)) = part.next() {
        assert!((0.001..0.01).contains(&session.time_s(&cycle.head)));
    }
    for found in [session.span().err(), session.events().err(), session.loop_figures().err()] {
        found.iter().for_each(has_remedy);
    }
}

fn has_remedy(error: &Error) {
    assert!(!error.hint().is_empty() && error.to_string().len() < 4096, "{error:?}");
}

/// Sets the checksums of all records that can be walked to 0, which stands for none.
fn without_checksums(file: &mut [u8]) {
    let mut at = 8usize;
    while let Some(head) = file.get(at..at.saturating_add(9)) {
        let op = head[0];
        let Some(length) = head[1..].first_chunk().map(|bytes| u64::from_le_bytes(*bytes) as usize) else { return };
        let body = at + 9;
        let end = body.saturating_add(length);
        let place = match op {
            // footer, chunk, data end; an attachment's is its last
            0x02 => Some(body + 16),
            0x06 => Some(body + 24),
            0x0f => Some(body),
            0x09 => end.checked_sub(4),
            _ => None,
        };
        if let Some(checksum) = place.and_then(|place| file.get_mut(place..place.saturating_add(4))) {
            checksum.fill(0);
        }
        at = end;
    }
}
