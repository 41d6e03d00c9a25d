//! What C holds of a client, a stream or a watch: a number that looks like a pointer and is never followed. So a handle that has been closed,
//! twice or while another thread is in a call, or that was never one, is an error and not a crash. So is one that a forked process has
//! inherited: what it is for is shared memory of the process before, which goes on using it.

use crate::border::Failure;
use crate::pointers::after_fork;
use crate::status::Status;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError, RwLock, TryLockError};

/// All open handles of one kind, each with the [`forks`] it was opened after.
pub(crate) struct Handles<T> {
    what: &'static str,
    open: RwLock<BTreeMap<usize, (u32, Arc<T>)>>,
}

/// Numbers are never given twice, whatever kind they are for.
static NEXT: AtomicUsize = AtomicUsize::new(1);

/// How often this process and those before it have forked, since the first handle was opened.
fn forks() -> u32 {
    static FORKS: AtomicU32 = AtomicU32::new(0);
    static COUNTED: Once = Once::new();
    extern "C" fn count() {
        FORKS.fetch_add(1, Ordering::Relaxed);
    }
    COUNTED.call_once(|| after_fork(count));
    FORKS.load(Ordering::Relaxed)
}

impl<T> Handles<T> {
    pub const fn of(what: &'static str) -> Handles<T> {
        Handles { what, open: RwLock::new(BTreeMap::new()) }
    }

    /// A new handle for this. `H` is only the name C knows it by.
    pub fn open<H>(&self, value: T) -> *mut H {
        // Numbers that no pointer to data can have, were one handed over by mistake: odd ones.
        let number = 2 * NEXT.fetch_add(1, Ordering::Relaxed) + 1;
        self.open.write().unwrap_or_else(PoisonError::into_inner).insert(number, (forks(), Arc::new(value)));
        std::ptr::without_provenance_mut(number)
    }

    /// What the handle is for. It lives on while it is used, even if another thread closes the handle.
    pub fn get<H>(&self, handle: *const H) -> Result<Arc<T>, Failure> {
        let open = self.open.read().unwrap_or_else(PoisonError::into_inner);
        let (opened, value) = open.get(&handle.addr()).ok_or_else(|| self.none(handle))?;
        if *opened != forks() {
            return Err(self.inherited());
        }
        Ok(value.clone())
    }

    /// Closes the handle; null is closed already.
    pub fn close<H>(&self, handle: *mut H) -> Result<Status, Failure> {
        if handle.is_null() {
            return Ok(Status::SINEW_OK);
        }
        // Not closed where it is not this process's: that would take away what the process before is using.
        drop(self.get(handle)?);
        let removed = self.open.write().unwrap_or_else(PoisonError::into_inner).remove(&handle.addr());
        // Dropped only now, without the lock: closing takes a while.
        removed.map(|_| Status::SINEW_OK).ok_or_else(|| self.none(handle))
    }

    fn inherited(&self) -> Failure {
        let Handles { what, .. } = self;
        let message = format!("this {what} was opened by the process that this one was forked from");
        Failure::new(Status::SINEW_ERROR_HANDLE, message, "connect anew after fork, in the process that commands")
    }

    fn none<H>(&self, handle: *const H) -> Failure {
        let Handles { what, .. } = self;
        match handle.is_null() {
            true => Failure::argument(
                format!("the {what} is null"),
                format!("open a {what} first, and see that it was opened"),
            ),
            false => Failure::new(
                Status::SINEW_ERROR_HANDLE,
                format!("this is no open {what}"),
                format!("use a {what} only between opening and closing it, and close it once"),
            ),
        }
    }
}

/// Takes what one thread at a time may use.
pub(crate) fn alone<'a, T>(what: &'static str, shared: &'a Mutex<T>) -> Result<MutexGuard<'a, T>, Failure> {
    shared.try_lock().map_err(|error| match error {
        TryLockError::WouldBlock => Failure::new(
            Status::SINEW_ERROR_IN_USE,
            format!("another thread is using this {what}"),
            format!("open a {what} for each thread"),
        ),
        TryLockError::Poisoned(_) => Failure::new(
            Status::SINEW_ERROR_PANIC,
            format!("a mistake of the sinew library itself has left this {what} unfinished"),
            format!("close it and open another {what}"),
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Name;

    #[test]
    fn a_handle_is_good_from_opening_to_closing_and_never_again() {
        static THINGS: Handles<u32> = Handles::of("thing");
        static OTHERS: Handles<u32> = Handles::of("other");
        let handle: *mut Name = THINGS.open(7);
        let kept = THINGS.get(handle).unwrap();
        assert!(OTHERS.get(handle).is_err(), "of another kind");
        assert!(THINGS.close(handle).is_ok());
        assert_eq!(*kept, 7, "a call that has begun goes on");
        for closed in [handle, std::ptr::null_mut(), std::ptr::dangling_mut(), (&raw const THINGS).cast_mut().cast()] {
            assert!(THINGS.get(closed).is_err());
        }
        assert!(THINGS.close(handle).is_err());
        assert!(THINGS.close(std::ptr::null_mut::<Name>()).is_ok());
        assert_ne!(THINGS.open::<Name>(8), handle);
    }

    #[test]
    fn what_is_for_one_thread_is_refused_to_the_second() {
        let shared = Mutex::new(1);
        let first = alone("thing", &shared).unwrap();
        std::thread::scope(|scope| scope.spawn(|| assert!(alone("thing", &shared).is_err())).join().unwrap());
        drop(first);
        assert!(alone("thing", &shared).is_ok());
    }
}
