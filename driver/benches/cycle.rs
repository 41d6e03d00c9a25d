//! Cost of a cycle without its sleep: one channel, a whole rig, publishing.
//!
//! `cargo bench -p sinew-driver`. Figures to hold: 100 ns for sensing, supervisor and control of a channel (so 1.8 µs for
//! `engine` at 18 channels and 6.4 µs at 64), 2 µs for `blackboard` at 64.

#[path = "../tests/integration/common.rs"]
mod common;

use common::{Fake, rig};
use divan::{Bencher, black_box};
use sinew_backend::{Backend, Sample};
use sinew_driver::{Ask, Beat, Engine, Order};
use sinew_ipc::{DriverState, RigLock, Server, Snapshot};

fn main() {
    divan::main();
}

const RATE_HZ: f64 = 1000.0;
const PERIOD_NS: u64 = 1_000_000;

/// A rig under sliding-mode control, warm, with a second of its samples recorded: what is measured is the engine alone.
struct Warm {
    engine: Engine,
    recorded: Vec<Vec<Sample>>,
    duty: Vec<f64>,
    now_ns: u64,
    at: usize,
}

impl Warm {
    fn new(channels: usize) -> Warm {
        let rig = rig("bench", channels, RATE_HZ);
        let mut engine = Engine::at_rest(&rig, None).expect("a good rig");
        let mut fake = Fake::new(&rig);
        fake.start().expect("the scripted backend starts");
        let mut duty = vec![0.0; channels];
        let mut samples = vec![Sample::NONE; channels];
        let mut recorded = Vec::new();
        let mut now_ns = 0;
        for period in 0..4000u32 {
            now_ns += PERIOD_NS;
            let exchanged = fake.exchange(&duty, &mut samples);
            if period == 50 {
                for channel in 0..channels {
                    let length_m = engine.channels()[channel].stroke_range().length_m(0.4);
                    let order = Order { ticket: 0, channel, ask: Ask::Length(length_m), hold_ns: u64::MAX };
                    engine.take(&order, now_ns);
                }
            }
            engine.cycle(Beat { now_ns, missed: 0 }, exchanged, &samples, &mut duty, |_| {});
            if period >= 3000 {
                recorded.push(samples.clone());
            }
        }
        assert!(engine.channels().iter().all(|channel| channel.is_powered()), "every channel is under control");
        Warm { engine, recorded, duty, now_ns, at: 0 }
    }

    fn cycle(&mut self) {
        self.now_ns += PERIOD_NS;
        self.at = if self.at + 1 == self.recorded.len() { 0 } else { self.at + 1 };
        let beat = Beat { now_ns: self.now_ns, missed: 0 };
        self.engine.cycle(beat, Ok(()), &self.recorded[self.at], &mut self.duty, |_| {});
        black_box(&self.duty);
    }
}

/// Sensing, observer, estimator, supervisor and controller of all channels: divide by their number.
#[divan::bench(args = [1, 18, 64])]
fn engine(bencher: Bencher, channels: usize) {
    let mut warm = Warm::new(channels);
    bencher.bench_local(|| warm.cycle());
}

/// The same with the state written into a snapshot, to the blackboard and into the ring: all of a cycle but exchange and sleep.
#[divan::bench(args = [18, 64])]
fn cycle(bencher: Bencher, channels: usize) {
    let mut warm = Warm::new(channels);
    let mut outlet = Outlet::new(channels);
    bencher.bench_local(|| {
        warm.cycle();
        warm.engine.describe(warm.now_ns, DriverState::Running, &mut outlet.snapshot);
        outlet.publish();
    });
}

/// The snapshot alone.
#[divan::bench(args = [18, 64])]
fn describe(bencher: Bencher, channels: usize) {
    let warm = Warm::new(channels);
    let mut snapshot = Snapshot::new(channels);
    bencher.bench_local(|| {
        warm.engine.describe(warm.now_ns, DriverState::Running, &mut snapshot);
        black_box(&snapshot);
    });
}

/// The blackboard alone.
#[divan::bench(args = [18, 64])]
fn blackboard(bencher: Bencher, channels: usize) {
    let mut outlet = Outlet::new(channels);
    bencher.bench_local(|| outlet.publish());
}

struct Outlet {
    server: Server,
    snapshot: Snapshot,
}

impl Outlet {
    fn new(channels: usize) -> Outlet {
        let name = format!("bench-{channels}-{}", std::process::id());
        let info = vec![sinew_ipc::ChannelInfo::EMPTY; channels];
        let info = sinew_ipc::Info::new(&name, RATE_HZ, &info).expect("a good name");
        let lock = RigLock::acquire(&name).expect("a name nobody else has");
        let server = Server::create(lock, &info).expect("shared memory");
        Outlet { server, snapshot: Snapshot::new(channels) }
    }

    fn publish(&mut self) {
        self.snapshot.cycle += 1;
        self.server.state.update(&self.snapshot);
    }
}
