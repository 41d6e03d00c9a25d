//! What reading and observing one channel costs: `cargo bench -p sinew-sensing`.
//!
//! Each iteration runs one cycle over 64 channels; `items/s` and the time per item are those of one channel.

use divan::{Bencher, black_box, counter::ItemsCount};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;
use sinew_sensing::{
    Bounds, Converter, Drive, LengthSensor, LengthSensorConfig, Method, MotionObserver, ObserverConfig, ResistanceLine,
    Sample, SlideConfig, SlideWatch, WireEnd,
};

const CHANNELS: usize = 64;
const CYCLES: usize = 64;

fn main() {
    divan::main();
}

/// Noisy samples of a healthy wire: a row of all channels for each of a few cycles.
fn samples() -> Vec<[Sample; CHANNELS]> {
    let mut rng = SmallRng::seed_from_u64(1);
    let mut noisy = |value: f64, sigma: f64| value + sigma * rng.sample::<f64, _>(StandardNormal);
    (0..CYCLES)
        .map(|_| {
            std::array::from_fn(|_| Sample {
                v1_v: noisy(0.0, 0.0015),
                v2_v: noisy(5.43, 0.0015),
                v3_v: noisy(5.9, 0.0015),
                current_a: noisy(0.522, 0.0004),
                supply_v: noisy(6.0, 0.003),
            })
        })
        .collect()
}

fn sensors(method: Method) -> Vec<LengthSensor> {
    let (hot, cold) =
        (WireEnd { resistance_ohm: 11.9, length_m: 0.1603 }, WireEnd { resistance_ohm: 10.4, length_m: 0.1667 });
    let config = LengthSensorConfig::for_wire(method, 1.2272e-8, 6.0, hot, cold, Converter::default());
    vec![LengthSensor::new(config).expect("a valid configuration"); CHANNELS]
}

fn observers(drive: bool) -> Vec<MotionObserver> {
    let fast = Drive { natural_rad_s: 170.0, damping_ratio: 0.6, full_duty_m_s: 0.0 };
    let config = if drive { ObserverConfig::with_drive(60e-6, fast) } else { ObserverConfig::default() };
    vec![MotionObserver::new(1000.0, config).expect("a valid configuration"); CHANNELS]
}

const DUAL: Method = Method::DualMeasurement { l0_m: 0.0, ls_m: 0.150 };

#[divan::bench(args = ["dual", "resistance"])]
fn read(bencher: Bencher, method: &str) {
    let line = ResistanceLine::through(
        WireEnd { resistance_ohm: 11.9, length_m: 0.1603 },
        WireEnd { resistance_ohm: 10.4, length_m: 0.1667 },
    )
    .expect("two resistances");
    let mut sensors = sensors(if method == "dual" { DUAL } else { Method::Resistance { line } });
    let samples = samples();
    let mut cycle = 0;
    bencher.counter(ItemsCount::new(CHANNELS)).bench_local(|| {
        cycle = (cycle + 1) % CYCLES;
        for (sensor, sample) in sensors.iter_mut().zip(&samples[cycle]) {
            black_box(sensor.read(black_box(sample)));
        }
    });
}

/// The watch over the taps, on readings that are all well.
#[divan::bench]
fn slide(bencher: Bencher) {
    let config = SlideConfig {
        hot_length_m: 0.1603,
        cold_length_m: 0.1667,
        surely_short_c: 140.0,
        surely_long_c: 64.0,
        ambient_c: 25.0,
        hottest_c: 170.0,
        heat_capacity_j_per_k: Bounds { least: 0.009, most: 0.012 },
        loss_w_per_k: Bounds { least: 0.004, most: 0.015 },
        power_error: 0.05,
    };
    let mut watches = vec![SlideWatch::new(config).expect("a valid configuration"); CHANNELS];
    let reading = sensors(DUAL)[0].read(&samples()[0][0]);
    bencher.counter(ItemsCount::new(CHANNELS)).bench_local(|| {
        for watch in &mut watches {
            black_box(watch.sticks(black_box(&reading), black_box(0.7), 1e-3));
        }
    });
}

/// `steady`: gains settled. `jitter`: steps between 0.9 and 1.1 of nominal. `start`: the covariance is carried along.
#[divan::bench(args = ["chain steady", "drive steady", "drive jitter", "chain start", "drive start"])]
fn observe(bencher: Bencher, kind: &str) {
    let mut observers = observers(kind.starts_with("drive"));
    // A standard deviation far from nominal keeps the gains from settling.
    let sigma = if kind.ends_with("start") { 100e-6 } else { 60e-6 };
    for observer in &mut observers {
        for _ in 0..5000 {
            observer.update_weighted(Some(0.163), sigma, 1e-3);
        }
    }
    let mut cycle = 0;
    bencher.counter(ItemsCount::new(CHANNELS)).bench_local(|| {
        cycle = (cycle + 1) % CYCLES;
        let dt = if kind.ends_with("jitter") { 1e-3 * (0.9 + 0.2 * cycle as f64 / CYCLES as f64) } else { 1e-3 };
        for observer in &mut observers {
            black_box(observer.update_weighted(black_box(Some(0.16301)), sigma, black_box(dt)));
        }
    });
}

#[divan::bench(args = ["chain", "drive"])]
fn read_and_observe(bencher: Bencher, kind: &str) {
    let mut channels: Vec<_> = sensors(DUAL).into_iter().zip(observers(kind == "drive")).collect();
    let samples = samples();
    for row in samples.iter().cycle().take(2000) {
        for ((sensor, observer), sample) in channels.iter_mut().zip(row) {
            observer.update(sensor.read(sample).length(), 1e-3);
        }
    }
    let mut cycle = 0;
    bencher.counter(ItemsCount::new(CHANNELS)).bench_local(|| {
        cycle = (cycle + 1) % CYCLES;
        for ((sensor, observer), sample) in channels.iter_mut().zip(&samples[cycle]) {
            let reading = sensor.read(black_box(sample));
            black_box(observer.update_weighted(reading.length(), reading.length_sigma_m, black_box(1e-3)));
        }
    });
}
