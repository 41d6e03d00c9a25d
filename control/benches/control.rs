//! What a channel pays per cycle for its estimate and its law. The figure: at most 300 ns together, by default.

use divan::{Bencher, black_box};
use sinew_control::{
    Algorithm, AlgorithmKind, Controller, Demand, Estimate, EstimatorKind, Observation, Settings, StateEstimator,
    default_lambda,
};
use sinew_physics::{Drive, DriveKind, Geometry, Initial, Load, Material, WireModel};

fn main() {
    divan::main();
}

fn wire() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: None,
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96133 },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: sinew_physics::Effects::default(),
    }
}

/// Readings that wander over the stroke like a wire's, so that no branch is always the same.
fn readings() -> Vec<Observation> {
    (0..256u32)
        .map(|k| {
            let swing = (f64::from(k) * std::f64::consts::TAU / 256.0).sin();
            let noise = f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5;
            Observation {
                power_w: 0.6 + 0.4 * swing,
                duty: 0.2,
                length_m: 0.1635 + 2e-3 * swing + 2e-4 * noise,
                tension_n: f64::NAN,
                length_sigma_m: 60e-6,
                resistance_ohm: 11.3 + 0.1 * swing + 0.01 * noise,
                dt_s: 1e-3,
            }
        })
        .collect()
}

fn run(bencher: Bencher, kind: AlgorithmKind, estimating: Option<EstimatorKind>, regulating: bool) {
    let model = wire();
    let mut estimator = StateEstimator::new(&model, estimating.unwrap_or(EstimatorKind::Enthalpy));
    let mut law = Algorithm::new(&model, &Settings { kind, ..Settings::default() });
    let readings = readings();
    let mut estimate = readings.iter().fold(Estimate::UNKNOWN, |_, reading| estimator.update(reading));
    let mut k = 0;
    bencher.bench_local(|| {
        k = (k + 1) & 255;
        let reading = black_box(&readings[k]);
        if estimating.is_some() {
            estimate = estimator.update(reading);
        }
        if regulating {
            return law.duty(&Demand {
                reference_m: 0.163,
                length_m: reading.length_m,
                velocity_m_s: 1e-3,
                acceleration_m_s2: 0.0,
                resistance_ohm: f64::NAN,
                dt_s: reading.dt_s,
                estimate,
            });
        }
        estimate.temperature_c
    });
}

#[divan::bench(args = EstimatorKind::ALL, sample_size = 1000)]
fn estimator(bencher: Bencher, kind: EstimatorKind) {
    run(bencher, AlgorithmKind::SlidingMode2, Some(kind), false);
}

#[divan::bench(args = AlgorithmKind::ALL)]
fn law(bencher: Bencher, kind: AlgorithmKind) {
    run(bencher, kind, None, true);
}

/// The default: what a channel pays for both.
#[divan::bench(sample_size = 1000)]
fn fused_and_time_optimal(bencher: Bencher) {
    run(bencher, AlgorithmKind::TimeOptimal, Some(EstimatorKind::Fused), true);
}

#[divan::bench]
fn lambda_by_default() -> f64 {
    default_lambda(black_box(&wire()), 3.0).value
}
