//! Counts allocations by thread, so that "no allocation in the loop" is measured in every run.
//!
//! A binary installs it once:
//!
//! ```
//! #[global_allocator]
//! static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;
//! # fn main() {}
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator with a count, for each thread, of how often it was asked: allocate, grow, free, all count,
/// because each of them may take a lock or call the kernel. Costs about a nanosecond a call.
#[derive(Debug, Default, Clone, Copy)]
pub struct CountingAllocator;

thread_local! {
    // `const` and without a destructor: reading it neither allocates nor registers anything.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

#[inline]
fn note() {
    // A thread being torn down has no thread locals any more; its allocations are not counted.
    let _ = CALLS.try_with(|calls| calls.set(calls.get().wrapping_add(1)));
}

/// Calls to the allocator by this thread so far. Stays 0 where [`CountingAllocator`] is not installed.
pub fn calls_of_this_thread() -> u64 {
    CALLS.try_with(Cell::get).unwrap_or(0)
}

/// Whether [`CountingAllocator`] is the global allocator of this program, found out by asking it for a byte.
pub fn is_counting() -> bool {
    let before = calls_of_this_thread();
    drop(std::hint::black_box(Box::new(std::hint::black_box(1u8))));
    calls_of_this_thread() != before
}

// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract; the count has no part in it.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`, which is that of `System`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        note();
        // SAFETY: as above; `block` came from `System` because every allocation does.
        unsafe { System.realloc(block, layout, new_size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        note();
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}
