//! Cost per channel and cycle of estimator and law. Requirement: at most 300 ns together, by default.

use divan::{Bencher, black_box};
use sinew_control::{
    Algorithm, AlgorithmKind, Controller, Demand, Estimate, EstimatorKind, JointAlgorithmKind, JointDemand, JointGains,
    JointLaw, JointObserver, JointSettings, Observation, Settings, StateEstimator, default_lambda,
};
use sinew_physics::{Drive, DriveKind, Geometry, Initial, Inputs, Joint, JointMotion, Load, Material, WireModel};

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
                resistance_sigma_ohm: 0.01,
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
                resistance_ohm: reading.resistance_ohm,
                dt_s: reading.dt_s,
                estimate,
            });
        }
        estimate.temperature_c
    });
}

#[divan::bench(args = EstimatorKind::ALL, sample_size = 1000)]
fn estimator(bencher: Bencher, kind: EstimatorKind) {
    run(bencher, AlgorithmKind::SlidingMode, Some(kind), false);
}

#[divan::bench(args = AlgorithmKind::ALL)]
fn law(bencher: Bencher, kind: AlgorithmKind) {
    run(bencher, kind, None, true);
}

/// The dearest cycle of `model_predictive`: one in which it plans, and the power lies between its limits, so that it is searched for.
#[divan::bench]
fn a_plan_of_model_predictive(bencher: Bencher) {
    let settings = Settings { kind: AlgorithmKind::ModelPredictive, ..Settings::default() };
    let mut law = Algorithm::new(&wire(), &settings);
    let mut k = 0u32;
    bencher.bench_local(|| {
        k = (k + 1) % 32;
        // on its way, at the distance where it has to be braked
        let length_m = 0.16346 + 1e-6 * f64::from(k);
        let estimate = Estimate {
            temperature_c: 104.0,
            martensite: 0.5,
            hottest_c: 110.0,
            stress_pa: 160e6,
            heating_curve_c: 103.0,
            cooling_curve_c: 77.0,
            length_m,
            loss_w: 0.5,
            loss_sigma_w: 0.05,
            release_j: 0.35,
            full_power_w: 3.0,
            velocity_m_s: -5e-3,
        };
        law.duty(black_box(&Demand {
            reference_m: 0.16318,
            length_m,
            velocity_m_s: -5e-3,
            acceleration_m_s2: 0.0,
            resistance_ohm: f64::NAN,
            dt_s: 2e-3,
            estimate,
        }))
    });
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

/// A joint's whole cycle: what both wires cost together, on what a simulated pair measured while it followed 1 Hz.
#[divan::bench(args = JointAlgorithmKind::ALL)]
fn joint(bencher: Bencher, algorithm: JointAlgorithmKind) {
    let told = WireModel {
        geometry: Geometry { diameter_m: 0.05e-3, length_m: 0.16 },
        drive: Drive { supply_v: 12.0, ..wire().drive },
        load: Load::ImposedPosition,
        ..wire()
    };
    let area = told.geometry.area_m2();
    let joint = Joint {
        radius_m: 8e-3,
        inertia_kg_m2: 2.5e-6,
        damping_n_m_s: 3.3e-4,
        spring_n_m: 0.0,
        torque_n_m: 0.0,
        pretension_n: 100e6 * area,
    };
    let nominal = WireModel { load: joint.nominal_load(), ..told.clone() };
    let settings = JointSettings {
        gains: JointGains::default(),
        joint,
        minimum_tension_n: 50e6 * area,
        tension_n: 200e6 * area,
        maximum_tension_n: 500e6 * area,
        minimum_duty: [0.02; 2],
        maximum_duty: [1.0; 2],
    };
    let mut motion = JointMotion::new(&joint, [&told, &told]).expect("a valid joint");
    let mut wires = [0, 1].map(|side| motion.wire(side, &told).expect("a valid wire"));
    let mut observer = JointObserver::new(&joint, [&nominal, &nominal]).expect("a valid joint");
    let mut law = JointLaw::new(algorithm, [&nominal, &nominal], &settings).expect("a valid joint");
    let demand = |tick: usize, both: &[Observation; 2], estimate| JointDemand {
        reference_rad: 0.1 * (tick as f64 * 1e-3 * std::f64::consts::TAU).sin(),
        tension_n: f64::NAN,
        resistance_ohm: both.map(|seen| seen.resistance_ohm),
        dt_s: 1e-3,
        estimate,
    };
    let mut duty = [0.02; 2];
    let mut seen = Vec::new();
    for tick in 0..6000 {
        let inputs = duty.map(|duty| Inputs { drive: duty, ..told.rest_inputs() });
        let [agonist, antagonist] = &mut wires;
        motion.step([agonist, antagonist], [&inputs[0], &inputs[1]], 0.0, 1e-3);
        let noise = 30e-6 * (f64::from((tick as u32).wrapping_mul(2_654_435_761) >> 16) / 32768.0 - 1.0);
        let both = [0, 1].map(|side| Observation {
            power_w: f64::NAN,
            duty: duty[side],
            length_m: 0.16 + wires[side].position_m() + noise,
            length_sigma_m: 20e-6,
            resistance_ohm: wires[side].resistance_ohm(),
            resistance_sigma_ohm: 0.01,
            tension_n: f64::NAN,
            dt_s: 1e-3,
        });
        duty = law.duties(&demand(tick, &both, observer.update([&both[0], &both[1]])));
        seen.push(both);
    }
    bencher.counter(divan::counter::ItemsCount::new(1000_usize)).bench_local(|| {
        let mut sum = 0.0;
        for (tick, both) in seen[5000..].iter().enumerate() {
            let estimate = observer.update(black_box([&both[0], &both[1]]));
            sum += law.duties(&demand(tick, both, estimate))[0];
        }
        sum
    });
}
