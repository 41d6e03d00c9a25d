//! The ring against a queue of the standard library, and between two real threads.

use std::collections::VecDeque;

use proptest::prelude::*;
use sinew_ring::ring;

proptest! {
    #[test]
    fn it_is_a_bounded_queue(slots in 1usize..9, steps in prop::collection::vec(0u8..5, 0..400)) {
        let (mut producer, mut consumer) = ring(vec![0u32; slots]);
        let mut queue = VecDeque::new();
        for (number, step) in steps.into_iter().enumerate() {
            let number = number as u32 + 1;
            match step {
                0 | 1 => {
                    let room = queue.len() < slots;
                    prop_assert_eq!(producer.push(number), room);
                    if room {
                        queue.push_back(number);
                    }
                }
                2 => prop_assert_eq!(consumer.pop(), queue.pop_front()),
                3 => prop_assert_eq!(consumer.peek(|&found| found), queue.front().copied()),
                _ => prop_assert_eq!(producer.free(), slots - queue.len()),
            }
        }
    }
}

#[test]
fn between_two_threads_nothing_is_torn_reordered_or_lost_uncounted() {
    const CYCLES: u64 = 300_000;
    let (mut producer, mut consumer) = ring((0..7).map(|_| vec![0u64; 33]));
    let dropped = std::thread::scope(|scope| {
        let loops =
            scope.spawn(move || (1..=CYCLES).filter(|&cycle| !producer.put(|slot| slot.fill(cycle))).count() as u64);
        let (mut last, mut taken) = (0, 0);
        loop {
            let over = consumer.is_alone();
            while let Some(cycle) = consumer.take(|slot| {
                assert!(slot.iter().all(|&word| word == slot[0]), "torn: {slot:?}");
                slot[0]
            }) {
                assert!(cycle > last, "{cycle} after {last}");
                (last, taken) = (cycle, taken + 1);
            }
            if over {
                break;
            }
        }
        let dropped = loops.join().expect("no panic");
        assert_eq!(taken + dropped, CYCLES);
        dropped
    });
    assert!(dropped < CYCLES);
}

#[test]
fn an_end_knows_when_it_is_alone() {
    let (mut producer, mut consumer) = ring([0u8; 2]);
    assert!(producer.push(1) && !consumer.is_alone());
    drop(producer);
    assert!(consumer.is_alone());
    assert_eq!((consumer.pop(), consumer.pop()), (Some(1), None), "what was put in is still there");
    let (producer, consumer) = ring([0u8; 1]);
    drop(consumer);
    assert!(producer.is_alone());
}
