//! What publishing costs the loop and reading costs a client.

use sinew_ipc::*;
use std::sync::atomic::{AtomicU64, Ordering};

fn main() {
    divan::main();
}

fn server(channels: usize) -> (Server, String) {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let rig = format!("bench-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let info = vec![ChannelInfo { name: Name::new("c").unwrap(), ..ChannelInfo::EMPTY }; channels];
    let lock = RigLock::acquire(&rig).unwrap();
    (Server::create(lock, &Info::new(&rig, 5000.0, &info).unwrap()).unwrap(), rig)
}

#[divan::bench(args = [1, 18, 64])]
fn update(bencher: divan::Bencher, channels: usize) {
    let (mut server, _) = server(channels);
    let mut snapshot = Snapshot::new(channels);
    bencher.bench_local(|| {
        snapshot.cycle += 1;
        server.state.update(divan::black_box(&snapshot));
    });
}

/// With a client reading as fast as it can on the other core: the worst neighbour.
#[divan::bench(args = [18, 64], sample_count = 1000)]
fn update_while_read(bencher: divan::Bencher, channels: usize) {
    let (mut server, rig) = server(channels);
    let mut snapshot = Snapshot::new(channels);
    let done = std::sync::atomic::AtomicBool::new(false);
    let reads = AtomicU64::new(0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let client = Client::connect(&rig).unwrap();
            let mut seen = Snapshot::default();
            while !done.load(Ordering::Relaxed) {
                client.latest_into(divan::black_box(&mut seen));
                reads.fetch_add(1, Ordering::Relaxed);
            }
        });
        while reads.load(Ordering::Relaxed) < 1000 {
            std::hint::spin_loop();
        }
        bencher.bench_local(|| {
            snapshot.cycle += 1;
            server.state.update(divan::black_box(&snapshot));
        });
        done.store(true, Ordering::Relaxed);
    });
}

#[divan::bench]
fn update_stats(bencher: divan::Bencher) {
    let (mut server, _) = server(1);
    let stats = LoopStats::new();
    bencher.bench_local(|| server.state.update_stats(divan::black_box(&stats)));
}

#[divan::bench]
fn record(bencher: divan::Bencher) {
    let mut histogram = Histogram::new();
    let mut ns = 1u64;
    bencher.bench_local(|| {
        ns = ns.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        histogram.record(divan::black_box(ns >> 40));
    });
}

/// One field only: the compiler copies no more than is looked at.
#[divan::bench(args = [18, 64])]
fn with_latest(bencher: divan::Bencher, channels: usize) {
    let (_server, rig) = server(channels);
    let client = Client::connect(&rig).unwrap();
    bencher.bench_local(|| client.with_latest(|s| divan::black_box(s.cycle)));
}

#[divan::bench(args = [18, 64])]
fn latest_into(bencher: divan::Bencher, channels: usize) {
    let (_server, rig) = server(channels);
    let client = Client::connect(&rig).unwrap();
    let mut snapshot = Snapshot::default();
    bencher.bench_local(|| client.latest_into(divan::black_box(&mut snapshot)));
}

/// One batch (ordinary thread), with a reader that has fallen behind.
#[divan::bench(args = [18, 64])]
fn publish_a_batch(bencher: divan::Bencher, channels: usize) {
    let (mut server, rig) = server(channels);
    let client = Client::connect(&rig).unwrap();
    let _stream = client.stream().unwrap();
    let snapshot = Snapshot::new(channels);
    bencher.bench_local(|| {
        for _ in 0..server.cycles.cycles_per_batch() {
            server.cycles.push_snapshot(&snapshot);
        }
    });
}

/// From the moment a state is written to the moment a polling client has it: the two cores hand it back and forth.
#[divan::bench]
fn seen_and_answered(bencher: divan::Bencher) {
    let (mut server, rig) = server(64);
    let (mut back, back_rig) = self::server(64);
    let done = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        let answering = Client::connect(&rig).unwrap();
        let done = &done;
        scope.spawn(move || {
            let mut snapshot = Snapshot::new(64);
            while !done.load(Ordering::Relaxed) {
                let cycle = answering.with_latest(|s| s.cycle);
                if cycle != snapshot.cycle {
                    snapshot.cycle = cycle;
                    back.state.update(&snapshot);
                }
            }
        });
        let client = Client::connect(&back_rig).unwrap();
        let mut snapshot = Snapshot::new(64);
        bencher.bench_local(|| {
            snapshot.cycle += 1;
            server.state.update(&snapshot);
            while client.with_latest(|s| s.cycle) != snapshot.cycle {
                std::hint::spin_loop();
            }
        });
        done.store(true, Ordering::Relaxed);
    });
}
