//! How a test lets a thread of a program die: a file says which one and how. Programs without debug assertions know nothing of it.

use crate::table::Thread;

/// Names the file in which a test says which thread is to die, and how (`desk panic`, `desk end`). Programs built without debug
/// assertions know nothing of it.
pub const STRIKE_FILE: &str = "SINEW_STRIKE_THREADS";

/// Called by a thread in every round of its work: whether it is to end by itself, as if by a mistake, because a test says so; where
/// that says that it is to panic, it does. Costs nothing in programs built without debug assertions: there it is always false.
#[inline]
pub fn is_struck() -> bool {
    hook::is_struck()
}

/// The present thread is this one.
pub(crate) fn this_is(thread: Option<Thread>) {
    hook::this_is(thread);
}

/// Looks into the file from now on, if there is one.
pub(crate) fn watch() {
    hook::watch();
}

#[cfg(not(debug_assertions))]
mod hook {
    pub(super) fn is_struck() -> bool {
        false
    }
    pub(super) fn this_is(_: Option<super::Thread>) {}
    pub(super) fn watch() {}
}

#[cfg(debug_assertions)]
mod hook {
    use std::cell::Cell;
    use std::ffi::OsStr;
    use std::sync::Once;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

    use super::Thread;
    use crate::table::TABLE;

    const LOOK: Duration = Duration::from_millis(5);

    /// Which threads are to panic, and which to end: their bits.
    static PANICS: AtomicU32 = AtomicU32::new(0);
    static ENDS: AtomicU32 = AtomicU32::new(0);

    thread_local! {
        static THIS: Cell<u32> = const { Cell::new(0) };
    }

    pub(super) fn this_is(thread: Option<Thread>) {
        THIS.set(thread.map_or(0, Thread::bit));
    }

    /// Allocates and locks nothing but in a panic.
    pub(super) fn is_struck() -> bool {
        let this = THIS.get();
        assert!(PANICS.load(Ordering::Relaxed) & this == 0, "struck by a test");
        ENDS.load(Ordering::Relaxed) & this != 0
    }

    pub(super) fn watch() {
        static WATCH: Once = Once::new();
        WATCH.call_once(|| {
            let Some(path) = std::env::var_os(super::STRIKE_FILE) else { return };
            // What is there before the first thread is started holds from its first round on.
            look(&path);
            std::thread::spawn(move || {
                loop {
                    std::thread::sleep(LOOK);
                    look(&path);
                }
            });
        });
    }

    fn look(path: &OsStr) {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        for line in text.lines() {
            let Some((name, how)) = line.split_once(' ') else { continue };
            let Some(row) = TABLE.iter().find(|row| row.name == name) else { continue };
            match how {
                "panic" => PANICS.fetch_or(row.thread.bit(), Ordering::Relaxed),
                "end" => ENDS.fetch_or(row.thread.bit(), Ordering::Relaxed),
                _ => 0,
            };
        }
    }
}
