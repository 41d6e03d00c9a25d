//! The noise table of docs/sensing.md: `cargo run --release -p sinew-sensing --example noise`.
//!
//! For each way to differentiate: the rms noise of length, velocity, acceleration and of the sliding surface (as a
//! length, σ/λ²) on a wire at rest whose lengths go through taps, converter and eq. 42; and by how much a slow motion (a sine
//! of 2 Hz without noise) comes late. All are read at the full rate, so holding a value between two samples costs its time.

#[path = "common/estimator.rs"]
mod estimator;

use estimator::Estimator;
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;
use sinew_sensing::{
    Converter, Drive, LengthSensor, LengthSensorConfig, Method, Motion, ObserverConfig, Sample, WireEnd,
};

const LAMBDA: f64 = 10.0;
const LENGTH_M: f64 = 0.1630;
const LS_M: f64 = 0.150;
const V3_V: f64 = 5.9;
const RESISTANCE_OHM: f64 = 11.3;

fn sensor() -> LengthSensor {
    let area_m2 = std::f64::consts::FRAC_PI_4 * 0.125e-3f64.powi(2);
    let method = Method::DualMeasurement { l0_m: 0.0, ls_m: LS_M };
    let config = LengthSensorConfig::for_wire(
        method,
        area_m2,
        6.0,
        WireEnd { resistance_ohm: 11.9, length_m: 0.1603 },
        WireEnd { resistance_ohm: 10.4, length_m: 0.1667 },
        Converter::default(),
    );
    LengthSensor::new(config).expect("a valid configuration")
}

/// Root mean square of the deviation from rest over 20 s, after 3 s to settle.
fn noise(rate_hz: f64, mut estimator: Estimator) -> [f64; 4] {
    let mut rng = SmallRng::seed_from_u64(7);
    let mut sensor = sensor();
    let lsb = |range: f64| 2.0 * range / 65536.0;
    let mut measure = |value: f64, sigma: f64, range: f64| {
        let noisy = value + sigma * rng.sample::<f64, _>(StandardNormal);
        (noisy / lsb(range)).round() * lsb(range)
    };
    let mut sums = [0.0; 4];
    let cycles = (23.0 * rate_hz) as u32;
    let settle = (3.0 * rate_hz) as u32;
    for cycle in 0..cycles {
        let sample = Sample {
            v1_v: measure(0.0, 0.0015, 10.0),
            v2_v: measure(V3_V * LS_M / LENGTH_M, 0.0015, 10.0),
            v3_v: measure(V3_V, 0.0015, 10.0),
            current_a: measure(V3_V / RESISTANCE_OHM, 0.0004, 1.0),
            supply_v: f64::NAN,
        };
        let length = sensor.read(&sample).length().expect("a healthy sample");
        let motion = estimator.update(length, 1.0 / rate_hz);
        if cycle >= settle {
            let errors = [
                motion.length_m - LENGTH_M,
                motion.velocity_m_s,
                motion.acceleration_m_s2,
                motion.surface(LAMBDA, LENGTH_M) / (LAMBDA * LAMBDA),
            ];
            for (sum, error) in sums.iter_mut().zip(errors) {
                *sum += error * error;
            }
        }
    }
    sums.map(|sum| (sum / f64::from(cycles - settle)).sqrt())
}

/// Lag of velocity, acceleration and surface behind a sine of 2 Hz, in s, from the phase of their fundamental.
fn lag(rate_hz: f64, mut estimator: Estimator) -> [f64; 3] {
    let omega = std::f64::consts::TAU * 2.0;
    let cycles = (6.0 * rate_hz) as u32;
    let settle = (3.0 * rate_hz) as u32;
    let mut sums = [(0.0, 0.0); 3];
    for cycle in 0..cycles {
        let phase = omega * f64::from(cycle) / rate_hz;
        let truth = |phase: f64| Motion {
            length_m: LENGTH_M + 1e-3 * phase.sin(),
            velocity_m_s: 1e-3 * omega * phase.cos(),
            acceleration_m_s2: -1e-3 * omega * omega * phase.sin(),
        };
        let values = |m: Motion| [m.velocity_m_s, m.acceleration_m_s2, m.surface(LAMBDA, LENGTH_M)];
        let seen = values(estimator.update(truth(phase).length_m, 1.0 / rate_hz));
        // The true signal and the one a quarter period before it span every phase.
        let (now, before) = (values(truth(phase)), values(truth(phase - std::f64::consts::FRAC_PI_2)));
        if cycle >= settle {
            for (index, sum) in sums.iter_mut().enumerate() {
                sum.0 += seen[index] * now[index];
                sum.1 += seen[index] * before[index];
            }
        }
    }
    sums.map(|(now, before)| before.atan2(now) / omega)
}

fn main() {
    let drive = Drive { natural_rad_s: 130.0, damping_ratio: 0.77, full_duty_m_s: 0.0 };
    println!("noise of one length: {:.1} µm rms", 1e6 * sensor().expected_sigma_m(LENGTH_M, V3_V, 0.5));
    println!();
    println!(
        "| lengths at | motion by | length µm | velocity mm/s | acceleration m/s² | σ/λ² mm | lag: ẋ ms | ẍ ms | σ ms |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    let show = |rate_hz: f64, name: &str, estimator: Estimator| {
        let [length, velocity, acceleration, surface] = noise(rate_hz, estimator.clone());
        let [late_v, late_a, late_s] = lag(rate_hz, estimator).map(|seconds| 1e3 * seconds);
        println!(
            "| {} Hz | {name} | {:.1} | {:.2} | {:.3} | {:.2} | {late_v:.1} | {late_a:.1} | {late_s:.1} |",
            rate_hz,
            1e6 * length,
            1e3 * velocity,
            acceleration,
            1e3 * surface
        );
    };
    show(200.0, "differences (the thesis)", Estimator::differences(200.0, 200.0, false));
    for rate_hz in [1e3, 5e3, 10e3] {
        show(rate_hz, "differences at full rate", Estimator::differences(rate_hz, rate_hz, false));
        show(rate_hz, "differences of means at 200 Hz", Estimator::differences(rate_hz, 200.0, true));
        let bare = ObserverConfig::default();
        for bandwidth_hz in [bare.bandwidth_hz, 20.0] {
            let config = ObserverConfig { bandwidth_hz, ..bare };
            show(rate_hz, &format!("observer, {bandwidth_hz} Hz"), Estimator::observer(rate_hz, config));
        }
        let driven = ObserverConfig::with_drive(bare.length_sigma_m, drive);
        for bandwidth_hz in [5.0, driven.bandwidth_hz, 20.0] {
            let config = ObserverConfig { bandwidth_hz, ..driven };
            let name = format!("observer with drive, {bandwidth_hz} Hz");
            show(rate_hz, &name, Estimator::observer(rate_hz, config));
        }
    }
}
