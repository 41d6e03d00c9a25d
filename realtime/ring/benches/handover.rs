//! What handing a cycle over costs: `cargo bench -p sinew-ring`.

use divan::{Bencher, black_box};
use sinew_ring::ring;

fn main() {
    divan::main();
}

/// Bytes of a channel in a cycle.
const CHANNEL: usize = 168;

/// Into the ring and out of it again, by one thread: two copies of so many channels and the ring's own work.
#[divan::bench(args = [1, 18, 64])]
fn there_and_out(bencher: Bencher, channels: usize) {
    let cycle = vec![7u8; channels * CHANNEL];
    let (mut producer, mut consumer) = ring(vec![cycle.clone(); 256]);
    bencher.bench_local(|| {
        producer.put(|slot| slot.copy_from_slice(black_box(&cycle)));
        consumer.take(|slot| {
            black_box(slot);
        });
    });
}

/// The same with another thread at the other end, which takes out what comes: the loop's share alone.
#[divan::bench(args = [1, 18, 64])]
fn into_a_ring_that_is_emptied(bencher: Bencher, channels: usize) {
    let cycle = vec![7u8; channels * CHANNEL];
    let (mut producer, mut consumer) = ring(vec![cycle.clone(); 4096]);
    let emptying = std::thread::spawn(move || {
        while !consumer.is_alone() {
            while consumer
                .take(|slot| {
                    black_box(slot);
                })
                .is_some()
            {}
            std::thread::sleep(std::time::Duration::from_micros(100));
        }
    });
    bencher.bench_local(|| while !producer.put(|slot| slot.copy_from_slice(black_box(&cycle))) {});
    drop(producer);
    let _ = emptying.join();
}
