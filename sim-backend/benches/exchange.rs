//! What one period of the virtual rig costs, by number of channels: divide by it for the cost per channel.

use divan::Bencher;
use sinew_backend::{Backend, Sample};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

fn main() {
    divan::main();
}

/// The hexapod's wires over and over until there are `channels`.
fn rig(channels: usize, rate_hz: f64) -> Rig {
    let mut rig = Rig::hexapod();
    rig.rate_hz = rate_hz;
    let pattern = rig.channels.clone();
    rig.channels = pattern.into_iter().cycle().take(channels).collect();
    for (i, channel) in rig.channels.iter_mut().enumerate() {
        channel.name = format!("wire{i}");
    }
    rig
}

fn run(bencher: Bencher, channels: usize, rate_hz: f64) {
    let mut backend = SimulatedRig::new(&rig(channels, rate_hz)).expect("the hexapod can be driven");
    backend.start().expect("simulated rigs start");
    let mut duty = vec![0.0; channels];
    let mut samples = vec![Sample::NONE; channels];
    let mut period = 0u64;
    // heating and cooling in turns, so that transformation, reversals and idling are all in
    let half_cycle = (2.0 * rate_hz) as u64;
    bencher.bench_local(|| {
        period += 1;
        for (i, duty) in duty.iter_mut().enumerate() {
            let heating = ((period + i as u64 * 97) / half_cycle).is_multiple_of(2);
            *duty = if heating { 0.4 } else { 0.02 };
        }
        backend.exchange(&duty, &mut samples)
    });
}

#[divan::bench(args = [1, 18, 64], sample_count = 2000, sample_size = 50)]
fn exchange_at_1_khz(bencher: Bencher, channels: usize) {
    run(bencher, channels, 1000.0);
}

#[divan::bench(args = [1, 18, 64], sample_count = 2000, sample_size = 50)]
fn exchange_at_5_khz(bencher: Bencher, channels: usize) {
    run(bencher, channels, 5000.0);
}
