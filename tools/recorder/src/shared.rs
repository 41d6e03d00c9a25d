//! State shared by the reading thread, the writing thread and the caller.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use sinew_recording::session::{Ended, Ending, Head, SessionWriter};

use crate::error::Error;
use crate::retention::Whole;
use crate::warning::Warning;

/// Older files that were removed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Removed {
    /// How many.
    pub files: u64,
    /// Cycles in them.
    pub cycles: u64,
    /// Bytes of them.
    pub bytes: u64,
}

impl Removed {
    pub(crate) fn add(&mut self, file: &Whole) {
        self.files += 1;
        self.cycles += file.cycles;
        self.bytes += file.bytes;
    }
}

/// All files together.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) files: Vec<PathBuf>,
    pub(crate) removed: Removed,
    pub(crate) ended: Option<Ended>,
    pub(crate) total: Ending,
    pub(crate) first: Option<Head>,
    pub(crate) last: Option<Head>,
    pub(crate) bytes: u64,
    pub(crate) payload: u64,
    pub(crate) failure: Option<Error>,
}

/// What both threads and the outside share.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) stop: AtomicBool,
    pub(crate) ended: AtomicBool,
    /// Set by the thread that writes when there is no more to be written, or nothing can be.
    pub(crate) is_written: AtomicBool,
    /// Set by the thread that reads the stream when it has said why it ends.
    pub(crate) drained: AtomicBool,
    pub(crate) received: AtomicU64,
    pub(crate) dropped: AtomicU64,
    pub(crate) lost_in_stream: AtomicU64,
    pub(crate) held: Arc<AtomicU64>,
    pub(crate) cycles: AtomicU64,
    pub(crate) bytes: AtomicU64,
    pub(crate) payload: AtomicU64,
    pub(crate) first_ns: AtomicU64,
    pub(crate) last_ns: AtomicU64,
    pub(crate) part: AtomicU64,
    pub(crate) file: Mutex<PathBuf>,
    pub(crate) failure: Mutex<Option<Error>>,
    pub(crate) warnings: Mutex<Vec<Warning>>,
}

impl Shared {
    /// Takes note of a failure, the first one.
    pub(crate) fn fail(&self, error: Error) {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    pub(crate) fn warn(&self, warning: Warning) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(warning);
    }

    /// What was warned of since this was asked last.
    pub(crate) fn take_warnings(&self) -> Vec<Warning> {
        std::mem::take(&mut *self.warnings.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(crate) fn set_file(&self, path: &Path) {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        if !file.as_os_str().is_empty() {
            self.part.fetch_add(1, Ordering::Relaxed);
        }
        path.clone_into(&mut file);
    }

    pub(crate) fn progress(&self, written: &Written, session: &SessionWriter<std::fs::File>) {
        self.cycles.fetch_add(1, Ordering::Relaxed);
        self.bytes.store(written.bytes + session.bytes(), Ordering::Relaxed);
        self.payload.store(written.payload + session.payload(), Ordering::Relaxed);
        let ns = |head: &Option<sinew_recording::session::Head>| head.map_or(0, |head| head.monotonic_ns);
        self.first_ns.store(ns(&written.first), Ordering::Relaxed);
        self.last_ns.store(ns(&written.last), Ordering::Relaxed);
    }
}
