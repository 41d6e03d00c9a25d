//! Every interleaving of the two ends that the memory model allows, tried by loom: on the source file the driver is built from,
//! with loom's atomics and cells in the place of the standard library's. Loom reports every access to a slot that races with
//! another one, and every order of stores a thread may see.
//!
//! The three hand-overs of the driver: cycles from the loop to the publisher, orders from the desk to the loop, and the flag by
//! which the publisher knows that it has seen the last cycle.
//!
//! A binary of its own: the source file finds loom's cells and atomics under `crate::sync`, where the library has the real ones.

mod sync {
    pub(crate) use loom::cell::UnsafeCell;
    pub(crate) use loom::sync::Arc;
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
}
// Not everything in it is of use to every test.
#[allow(dead_code)]
#[path = "../src/spsc.rs"]
mod spsc;

use loom::sync::Arc;
use loom::sync::atomic::{AtomicBool, Ordering};
use loom::thread;
use spsc::ring;

/// A cycle: its head and its channels. It is whole when they are all of one number.
#[derive(Debug, Clone, Copy, Default)]
struct Cycle {
    head: u32,
    channels: [u32; 2],
}

impl Cycle {
    fn fill(&mut self, number: u32) {
        // in the order the loop writes them, channels last: a reader that comes too early sees a head without its channels
        self.head = number;
        self.channels = [number; 2];
    }

    fn number(&self) -> u32 {
        assert_eq!(self.channels, [self.head; 2], "a head without its channels");
        self.head
    }
}

/// The loop runs `cycles` cycles into a ring of `slots` and ends; the publisher takes what there is `looks` times, then waits for
/// the end and takes the rest. What came out and what was dropped is every cycle once, in order.
fn hand_over(slots: usize, cycles: u32, looks: usize) {
    loom::model(move || {
        let (mut producer, mut consumer) = ring(vec![Cycle::default(); slots]);
        let ended = Arc::new(AtomicBool::new(false));
        let looping = {
            let ended = ended.clone();
            thread::spawn(move || {
                let mut dropped = Vec::new();
                for number in 1..=cycles {
                    if !producer.put(|slot| slot.fill(number)) {
                        dropped.push(number);
                    }
                }
                ended.store(true, Ordering::Release);
                dropped
            })
        };
        let mut found = Vec::new();
        for _ in 0..looks {
            // Asked before looking, as the publisher does.
            let over = ended.load(Ordering::Acquire);
            while let Some(number) = consumer.take(|cycle| cycle.number()) {
                found.push(number);
            }
            if over {
                assert!(consumer.pop().is_none(), "the publisher left a cycle behind");
            }
        }
        let dropped = looping.join().unwrap();
        while let Some(number) = consumer.take(|cycle| cycle.number()) {
            found.push(number);
        }
        assert!(found.is_sorted(), "{found:?}");
        let mut all = [found, dropped].concat();
        all.sort_unstable();
        assert_eq!(all, (1..=cycles).collect::<Vec<_>>(), "lost and not counted, or twice");
    });
}

#[test]
fn a_ring_of_one_slot_hands_over_whole_cycles() {
    hand_over(1, 3, 2);
}

#[test]
fn a_ring_of_two_slots_hands_over_whole_cycles() {
    hand_over(2, 4, 1);
}

/// Half a minute: `cargo test -p sinew-ring --test model -- --ignored`.
#[test]
#[ignore = "long"]
fn a_ring_that_goes_round_three_times_hands_over_whole_cycles() {
    hand_over(2, 4, 2);
    hand_over(2, 6, 1);
}

/// Whoever finds the other end gone finds all it had put in: by this a replay knows that a recording is over.
#[test]
fn an_end_that_is_gone_has_left_everything_behind() {
    loom::model(|| {
        let (mut producer, mut consumer) = ring(vec![Cycle::default(); 2]);
        let reading = thread::spawn(move || (1..=2).for_each(|number| assert!(producer.put(|slot| slot.fill(number)))));
        let over = consumer.is_alone();
        let mut found = 0;
        while consumer.take(|cycle| cycle.number()).is_some() {
            found += 1;
        }
        assert!(!over || found == 2, "over, and {found} of 2 were there");
        reading.join().unwrap();
    });
}

/// The desk puts orders in only when there is room for all of a request; the loop looks at the oldest before it takes it. None is
/// lost, and what is looked at is what is taken.
#[test]
fn the_desks_orders_reach_the_loop_whole_and_in_order() {
    loom::model(|| {
        let (mut desk, mut orders) = ring(vec![Cycle::default(); 2]);
        let asking = thread::spawn(move || {
            let mut sent = 0;
            for request in 0..2 {
                if desk.free() >= 2 {
                    for part in 1..=2 {
                        assert!(desk.put(|slot| slot.fill(2 * request + part)), "there was room for it");
                    }
                    sent += 2;
                }
            }
            sent
        });
        let mut taken = Vec::new();
        for _ in 0..2 {
            if let Some(seen) = orders.peek(Cycle::number) {
                assert_eq!(orders.take(|order| order.number()), Some(seen), "another one than was looked at");
                taken.push(seen);
            }
        }
        let sent = asking.join().unwrap();
        while let Some(number) = orders.take(|order| order.number()) {
            taken.push(number);
        }
        assert_eq!(taken.len(), sent);
        assert!(taken.is_sorted() && taken.iter().all(|number| (1..=4).contains(number)), "{taken:?}");
    });
}

/// A model that cannot fail proves nothing: a ring that forgets to release what it hands over is found out.
#[test]
#[should_panic(expected = "Causality violation")]
fn a_hand_over_without_release_is_found_out() {
    loom::model(|| {
        let slot = Arc::new((loom::cell::UnsafeCell::new(0u32), AtomicBool::new(false)));
        let other = slot.clone();
        let writer = thread::spawn(move || {
            // SAFETY: it is not safe; that is what loom is to say.
            other.0.with_mut(|place| unsafe { *place = 1 });
            other.1.store(true, Ordering::Relaxed);
        });
        if slot.1.load(Ordering::Acquire) {
            // SAFETY: as above.
            slot.0.with(|place| assert_eq!(unsafe { *place }, 1));
        }
        writer.join().unwrap();
    });
}
