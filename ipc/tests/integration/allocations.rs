//! Writing the latest state allocates nothing.

use crate::common::*;
use sinew_ipc::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: everything is passed on to the system's allocator unchanged; counting touches a constant-initialised thread-local only.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: as our caller promises.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: as our caller promises.
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: as our caller promises.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn counted(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.with(Cell::get);
    work();
    ALLOCATIONS.with(Cell::get) - before
}

#[test]
fn writing_and_reading_the_latest_state_allocates_nothing() {
    assert!(counted(|| drop(std::hint::black_box(vec![1]))) > 0, "the counter counts");
    let rig = rig("alloc");
    let mut server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 64, 5000.0)).unwrap();
    let client = Client::connect(&rig).unwrap();
    let mut s = state(1, 64);
    let mut stats = LoopStats::new();
    let mut seen = Snapshot::default();
    let work = |server: &mut Server, s: &mut Snapshot, stats: &mut LoopStats, seen: &mut Snapshot| {
        s.cycle += 1;
        s.monotonic_ns = monotonic_ns();
        server.state.update(s);
        stats.lateness.record(s.cycle * 37 % 2_000_000_000);
        stats.cycles += 1;
        if s.cycle.is_multiple_of(100) {
            server.state.update_stats(stats);
        }
        client.latest_into(seen);
    };
    for _ in 0..100 {
        work(&mut server, &mut s, &mut stats, &mut seen);
    }
    let n = counted(|| {
        for _ in 0..100_000 {
            work(&mut server, &mut s, &mut stats, &mut seen);
        }
    });
    assert_eq!(n, 0);
    assert_eq!(seen.cycle, s.cycle);
}
