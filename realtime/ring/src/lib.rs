//! The ring between the real-time loop and ordinary threads: one end puts in, the other takes out, and neither ever waits.
//!
//! Its slots are made when it is, and filled and looked at where they lie: what goes through it needs no allocation, however large
//! it is. Nothing is overwritten: into a full ring nothing goes, and whoever put it in is told, so that a cycle that is lost is
//! counted. Both directions of the driver use it, cycles and events out of the loop and orders into it.
//!
//! `tests/model.rs` lets loom try every interleaving of the two ends on this very source file.
//!
//! ```
//! let (mut producer, mut consumer) = sinew_ring::ring([0u64; 4]);
//! assert!(producer.push(1));
//! assert!(producer.put(|slot| *slot = 2), "filled in place");
//! assert_eq!((consumer.pop(), consumer.pop(), consumer.pop()), (Some(1), Some(2), None));
//!
//! let fitted = (0..10).filter(|number| producer.push(*number)).count();
//! assert_eq!(fitted, 4, "nothing is overwritten: what does not fit is refused, and can be counted");
//! ```
#![deny(unsafe_code)]

#[allow(unsafe_code)]
mod spsc;
/// What the ring is made of; the model puts loom's in their place.
mod sync {
    pub(crate) use std::sync::Arc;
    pub(crate) use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    /// [`std::cell::UnsafeCell`] by loom's interface, which sees every access begin and end.
    #[derive(Debug)]
    pub(crate) struct UnsafeCell<T>(std::cell::UnsafeCell<T>);

    impl<T> UnsafeCell<T> {
        pub(crate) fn new(value: T) -> UnsafeCell<T> {
            UnsafeCell(std::cell::UnsafeCell::new(value))
        }

        #[inline]
        pub(crate) fn with<R>(&self, look: impl FnOnce(*const T) -> R) -> R {
            look(self.0.get())
        }

        #[inline]
        pub(crate) fn with_mut<R>(&self, change: impl FnOnce(*mut T) -> R) -> R {
            change(self.0.get())
        }
    }
}

pub use spsc::{Consumer, Producer, ring};
