//! The reconnection thread: looks for unplugged devices, so that the loop need not.
//!
//! The loop hands over its dead files here and gets open ones later. Both are behind locks that the loop only tries: if
//! this thread holds one, the loop tries again in the next period. Closing and opening, which block and allocate, are done here.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::thread::{CpuSet, sched_setaffinity};
use sinew_threads::Thread;

use crate::Error;

/// How often it looks whether there is something to do, and how often for what is gone.
const LOOK: Duration = Duration::from_millis(50);

/// Of what is open between start and stop, whatever that is.
#[derive(Debug)]
pub(crate) struct Mender<T> {
    shared: Arc<Shared<T>>,
    thread: Option<JoinHandle<Option<()>>>,
}

#[derive(Debug)]
struct Shared<T> {
    lost: Mutex<Option<T>>,
    found: Mutex<Option<T>>,
    stop: AtomicBool,
}

impl<T: Send + 'static> Mender<T> {
    /// Starts the thread; `open` is how what was lost is opened anew, and `what` that is.
    pub fn start(what: &'static str, open: impl Fn() -> Result<T, Error> + Send + 'static) -> Result<Mender<T>, Error> {
        let shared = Arc::new(Shared { lost: Mutex::new(None), found: Mutex::new(None), stop: AtomicBool::new(false) });
        let (theirs, over) = (shared.clone(), shared.clone());
        let start = Thread::Mender.start().ends_when(move || over.stop.load(Ordering::Acquire));
        let thread = start.spawn(move || theirs.mend(what, &open));
        let thread = thread.map_err(|error: io::Error| Error::Guard { reason: format!("a thread: {error}") })?;
        Ok(Mender { shared, thread: Some(thread) })
    }

    /// Leaves what is dead; it stays where it is while the mender is just looking.
    pub fn lost(&self, running: &mut Option<T>) {
        if let Ok(mut lost) = self.shared.lost.try_lock()
            && lost.is_none()
        {
            *lost = running.take();
        }
    }

    /// What was opened anew since, if anything.
    pub fn found(&self) -> Option<T> {
        self.shared.found.try_lock().ok()?.take()
    }
}

impl<T> Shared<T> {
    fn mend(&self, what: &str, open: &impl Fn() -> Result<T, Error>) {
        // Keep off the loop's core.
        let mut all = CpuSet::new();
        (0..CpuSet::MAX_CPU).for_each(|cpu| all.set(cpu));
        let _ = sched_setaffinity(None, &all);
        let mut missing = false;
        let mut told = String::new();
        while !self.stop.load(Ordering::Acquire) && !sinew_threads::is_struck() {
            thread::park_timeout(LOOK);
            let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner).take();
            missing |= lost.is_some();
            // Closes the files and ends the guard, which would keep the outputs locked.
            drop(lost);
            if !missing {
                continue;
            }
            match open() {
                Ok(running) => {
                    *self.found.lock().unwrap_or_else(PoisonError::into_inner) = Some(running);
                    missing = false;
                    told.clear();
                    tracing::info!("{what} are back");
                }
                Err(error) => {
                    let words = error.to_string();
                    // once, not twenty times a second
                    if words != told {
                        tracing::warn!("{words}; looking for it again");
                        told = words;
                    }
                }
            }
        }
    }
}

impl<T> Drop for Mender<T> {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}
