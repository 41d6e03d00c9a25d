//! One producer, one consumer, slots in a circle.
//!
//! Two counters say it all: how many were put in, written by the producer alone, and how many were taken out, written by the
//! consumer alone. Their difference is what is inside. Each end keeps the last it saw of the other's counter and looks again only
//! when that says full or empty, so that the two cores do not fight over a cache line once a cycle.

use crossbeam_utils::CachePadded;

use crate::sync::{Arc, AtomicBool, AtomicUsize, Ordering, UnsafeCell};

#[derive(Debug)]
struct Ring<T> {
    /// How many were put in, wrapping: slots before it are the consumer's.
    put: CachePadded<AtomicUsize>,
    /// How many were taken out, wrapping: slots before it are the producer's again.
    taken: CachePadded<AtomicUsize>,
    /// One of the two ends is gone.
    alone: AtomicBool,
    slots: Box<[UnsafeCell<T>]>,
}

// SAFETY: a slot is touched by one end at a time. The producer has those from `put` to `taken` + slots, the consumer those from
// `taken` to `put`; each gives slots over by a release store to its own counter, which the other reads with acquire.
unsafe impl<T: Send> Sync for Ring<T> {}
// SAFETY: as above; nothing in it belongs to a thread.
unsafe impl<T: Send> Send for Ring<T> {}

/// The end things are put into.
#[derive(Debug)]
pub struct Producer<T> {
    ring: Arc<Ring<T>>,
    /// The slot that is filled next.
    at: usize,
    /// What `Ring::put` stands at.
    put: usize,
    /// What `Ring::taken` stood at when last seen.
    taken: usize,
}

/// The end things are taken out of.
#[derive(Debug)]
pub struct Consumer<T> {
    ring: Arc<Ring<T>>,
    /// The slot that is looked at next.
    at: usize,
    /// What `Ring::taken` stands at.
    taken: usize,
    /// What `Ring::put` stood at when last seen.
    put: usize,
}

/// A ring of these slots. What they hold is overwritten before anybody sees it; it is given so that all memory is there, and
/// touched, from the start.
///
/// # Panics
/// Without a single slot.
pub fn ring<T: Send>(slots: impl IntoIterator<Item = T>) -> (Producer<T>, Consumer<T>) {
    let slots: Box<[UnsafeCell<T>]> = slots.into_iter().map(UnsafeCell::new).collect();
    assert!(!slots.is_empty(), "a ring needs at least one slot");
    let counter = || CachePadded::new(AtomicUsize::new(0));
    let ring = Arc::new(Ring { put: counter(), taken: counter(), alone: AtomicBool::new(false), slots });
    (Producer { ring: ring.clone(), at: 0, put: 0, taken: 0 }, Consumer { ring, at: 0, taken: 0, put: 0 })
}

impl<T> Producer<T> {
    /// Lets a slot be filled and hands it over; false, and nothing done, when all are taken. The slot holds what some earlier round
    /// left in it.
    #[inline]
    pub fn put(&mut self, fill: impl FnOnce(&mut T)) -> bool {
        if self.put.wrapping_sub(self.taken) == self.ring.slots.len() && self.free() == 0 {
            return false;
        }
        // SAFETY: fewer than all slots are the consumer's, so this one, the next in the circle, is the producer's; there is one
        // producer, and it is borrowed.
        self.ring.slots[self.at].with_mut(|slot| fill(unsafe { &mut *slot }));
        self.at = next(self.at, self.ring.slots.len());
        self.put = self.put.wrapping_add(1);
        self.ring.put.store(self.put, Ordering::Release);
        true
    }

    /// Puts a value in; false, and it is gone, when all slots are taken.
    #[inline]
    pub fn push(&mut self, value: T) -> bool {
        self.put(|slot| *slot = value)
    }

    /// How many slots are free; the consumer may make them more at any time.
    #[inline]
    pub fn free(&mut self) -> usize {
        self.taken = self.ring.taken.load(Ordering::Acquire);
        self.ring.slots.len() - self.put.wrapping_sub(self.taken)
    }

    /// Whether the consumer is gone: what is put in now nobody will take.
    pub fn is_alone(&self) -> bool {
        self.ring.alone.load(Ordering::Acquire)
    }
}

impl<T> Consumer<T> {
    /// Lets the oldest be looked at and gives its slot back; `None` when there is none.
    #[inline]
    pub fn take<R>(&mut self, look: impl FnOnce(&mut T) -> R) -> Option<R> {
        if !self.has_one() {
            return None;
        }
        // SAFETY: this slot was handed over and not given back, so it is the consumer's; there is one consumer, and it is borrowed.
        let found = self.ring.slots[self.at].with_mut(|slot| look(unsafe { &mut *slot }));
        self.at = next(self.at, self.ring.slots.len());
        self.taken = self.taken.wrapping_add(1);
        self.ring.taken.store(self.taken, Ordering::Release);
        Some(found)
    }

    /// Takes the oldest out.
    #[inline]
    pub fn pop(&mut self) -> Option<T>
    where
        T: Copy,
    {
        self.take(|slot| *slot)
    }

    /// Looks at the oldest and leaves it there.
    #[inline]
    pub fn peek<R>(&mut self, look: impl FnOnce(&T) -> R) -> Option<R> {
        if !self.has_one() {
            return None;
        }
        // SAFETY: as in `take`.
        Some(self.ring.slots[self.at].with(|slot| look(unsafe { &*slot })))
    }

    #[inline]
    fn has_one(&mut self) -> bool {
        if self.put == self.taken {
            self.put = self.ring.put.load(Ordering::Acquire);
        }
        self.put != self.taken
    }

    /// Whether the producer is gone: what is inside is all there will be. Ask before looking, or what it put in in between is missed.
    pub fn is_alone(&self) -> bool {
        self.ring.alone.load(Ordering::Acquire)
    }
}

impl<T> Drop for Producer<T> {
    fn drop(&mut self) {
        // Behind all it put in. The count of an Arc would not do: nothing is ordered by reading that.
        self.ring.alone.store(true, Ordering::Release);
    }
}

impl<T> Drop for Consumer<T> {
    fn drop(&mut self) {
        self.ring.alone.store(true, Ordering::Release);
    }
}

/// The slot after this one. Compared and not divided: a division would cost as much as all the rest.
#[inline]
fn next(at: usize, slots: usize) -> usize {
    if at + 1 == slots { 0 } else { at + 1 }
}
