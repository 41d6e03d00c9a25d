//! The joint's observer and law on the simulated joint of the physics, without a driver between: estimates, tracking,
//! and that no input leads to an unsafe output.

use proptest::prelude::*;
use sinew_control::*;
use sinew_physics::*;

const DT: f64 = 1e-3;
const LENGTH: f64 = 0.16;

pub(crate) fn model(diameter_mm: f64, supply_v: f64) -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: diameter_mm * 1e-3, length_m: LENGTH },
        material: Material::default(),
        taps: None,
        drive: Drive { kind: DriveKind::Pwm, supply_v, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::ImposedPosition,
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

/// What is simulated and what looks at it; the truth may differ from what the observer was told.
pub(crate) struct Loop {
    truth: WireModel,
    pub motion: JointMotion,
    pub wires: [Wire; 2],
    observer: JointObserver,
    pub law: JointLaw,
    pub duty: [f64; 2],
    pub estimate: Option<JointEstimate>,
    pub stroke: f64,
    noise: u64,
    sigma_m: f64,
}

impl Loop {
    fn new(told: &WireModel, truth: WireModel, sigma_m: f64) -> Loop {
        Loop::under(JointAlgorithmKind::Decoupling, 0.0, told, truth, sigma_m)
    }

    /// Under a law with its own gains, on a joint with a spring of its own, N m a rad.
    pub fn under(
        algorithm: JointAlgorithmKind,
        spring_n_m: f64,
        told: &WireModel,
        truth: WireModel,
        sigma_m: f64,
    ) -> Loop {
        Loop::with(algorithm, JointGains::default(), spring_n_m, told, truth, sigma_m)
    }

    /// The same with gains.
    pub fn with(
        algorithm: JointAlgorithmKind,
        gains: JointGains,
        spring_n_m: f64,
        told: &WireModel,
        truth: WireModel,
        sigma_m: f64,
    ) -> Loop {
        let area = told.geometry.area_m2();
        let (radius_m, inertia_kg_m2) = (0.008, 2.5e-6);
        let stiffness = 2.0 * 75e9 * area / LENGTH;
        let joint = Joint {
            radius_m,
            inertia_kg_m2,
            damping_n_m_s: 0.6 * (radius_m * radius_m * stiffness * inertia_kg_m2).sqrt(),
            spring_n_m,
            torque_n_m: 0.0,
            pretension_n: 100e6 * area,
        };
        let nominal = WireModel { load: joint.nominal_load(), ..told.clone() };
        let settings = JointSettings {
            gains,
            joint,
            minimum_tension_n: 50e6 * area,
            tension_n: 200e6 * area,
            maximum_tension_n: 500e6 * area,
            minimum_duty: [0.02; 2],
            maximum_duty: [1.0; 2],
        };
        let motion = JointMotion::new(&joint, [told, told]).unwrap();
        Loop {
            wires: [motion.wire(0, &truth).unwrap(), motion.wire(1, &truth).unwrap()],
            motion,
            truth,
            observer: JointObserver::new(&joint, [&nominal, &nominal]).unwrap(),
            law: JointLaw::new(algorithm, [&nominal, &nominal], &settings).unwrap(),
            duty: [0.02; 2],
            estimate: None,
            stroke: StrokeRange::of(&nominal).unwrap().stroke_m() / radius_m,
            noise: 0x9e37_79b9_7f4a_7c15,
            sigma_m,
        }
    }

    /// About normal, standard deviation 1.
    fn noise(&mut self) -> f64 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        }
        sum * 3f64.sqrt()
    }

    /// One period towards an angle, rad.
    pub fn step(&mut self, reference_rad: f64) {
        self.step_with(reference_rad, f64::NAN);
    }

    /// One period towards an angle, rad, and a tension, N.
    pub fn step_with(&mut self, reference_rad: f64, tension_n: f64) {
        let inputs = self.duty.map(|duty| Inputs { drive: duty, ..self.truth.rest_inputs() });
        let before = self.wires.each_ref().map(|wire| wire.energy().heat_in_j);
        let [agonist, antagonist] = &mut self.wires;
        self.motion.step([agonist, antagonist], [&inputs[0], &inputs[1]], 0.0, DT);
        let noise = [0, 1].map(|_| (self.noise(), self.noise()));
        let seen = [0, 1].map(|side| {
            let wire = &self.wires[side];
            Observation {
                power_w: (wire.energy().heat_in_j - before[side]) / DT,
                duty: self.duty[side],
                length_m: LENGTH + wire.position_m() + self.sigma_m * noise[side].0,
                length_sigma_m: self.sigma_m.max(1e-7),
                resistance_ohm: wire.resistance_ohm() * (1.0 + 10.0 * self.sigma_m * noise[side].1),
                resistance_sigma_ohm: f64::NAN,
                tension_n: f64::NAN,
                dt_s: DT,
            }
        });
        let estimate = self.observer.update([&seen[0], &seen[1]]);
        let resistance_ohm = seen.map(|seen| seen.resistance_ohm);
        self.duty = self.law.duties(&JointDemand { tension_n, resistance_ohm, reference_rad, dt_s: DT, estimate });
        self.estimate = Some(estimate);
    }

    /// Follows a sine of a quarter of the stroke; RMS error over the last `judged` seconds, in strokes.
    pub fn follow(&mut self, hz: f64, seconds: f64, judged: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for tick in 0..(seconds / DT) as usize {
            let time = tick as f64 * DT;
            let reference = 0.125 * self.stroke * (std::f64::consts::TAU * hz * time).sin();
            self.step(reference);
            if time > seconds - judged {
                sum += ((self.motion.angle_rad() - reference) / self.stroke).powi(2);
                count += 1.0;
            }
        }
        (sum / count).sqrt()
    }
}

#[test]
fn with_perfect_lengths_the_thin_pair_follows_one_hertz_to_a_third_of_a_per_cent() {
    let told = model(0.05, 12.0);
    let rms = Loop::new(&told, told.clone(), 0.0).follow(1.0, 9.0, 4.0);
    assert!(rms < 0.0035, "{rms}");
}

/// A wire of 0.125 mm cannot shed the heat of 1 Hz in still air: from crossing 26 K and 7 K of latent heat twice a second
/// follows more than 70 K/s, and it cools with 57 K/s at 200 MPa. It follows a quarter of that.
#[test]
fn the_thick_pair_follows_as_fast_as_the_air_lets_it() {
    let told = model(0.125, 9.0);
    let slow = Loop::new(&told, told.clone(), 0.0).follow(0.25, 17.0, 8.0);
    let fast = Loop::new(&told, told.clone(), 0.0).follow(1.0, 9.0, 4.0);
    assert!(slow < 0.002 && fast > 0.03, "{slow} {fast}");
}

#[test]
fn tension_and_temperatures_are_believed_right_without_a_force_sensor() {
    let told = model(0.05, 12.0);
    let mut joint = Loop::new(&told, told.clone(), 30e-6);
    joint.follow(0.5, 8.0, 1.0);
    let (mut kelvins, mut newtons, mut count) = (0.0, 0.0, 0.0_f64);
    for tick in 0..4000 {
        let time = f64::from(tick) * DT;
        joint.step(0.125 * joint.stroke * (std::f64::consts::PI * time).sin());
        let estimate = joint.estimate.unwrap();
        for side in [0, 1] {
            kelvins += (estimate.wires[side].temperature_c - joint.wires[side].temperature_c()).powi(2);
            newtons += (estimate.tension_n[side] / joint.wires[side].tension_n() - 1.0).powi(2);
            count += 1.0;
        }
    }
    let (kelvins, share) = ((kelvins / count).sqrt(), (newtons / count).sqrt());
    assert!(kelvins < 1.5 && share < 0.05, "{kelvins} K, {share} of the tension");
}

/// Closed loop on a tension that nobody measures: true tension against what was asked for, and what it costs the angle. Now and
/// then noise sets a phase astray inside its hysteresis, and the tension with it, so this is counted and not only bounded.
#[test]
fn a_standing_joint_takes_the_tension_asked_for() {
    let told = model(0.05, 12.0);
    let area = told.geometry.area_m2();
    let mut off = Vec::new();
    for seed in 1..=6u64 {
        for share in [-0.2, 0.0, 0.2] {
            let mut joint = Loop::new(&told, told.clone(), 30e-6);
            joint.noise = joint.noise.wrapping_mul(seed);
            let reference = share * joint.stroke;
            (0..4000).for_each(|_| joint.step(reference));
            for mpa in [150.0, 300.0, 400.0, 200.0] {
                let asked = mpa * 1e6 * area;
                (0..9000).for_each(|_| joint.step_with(reference, asked));
                let (mut worst, mut angle) = (0.0_f64, 0.0_f64);
                for _ in 0..1000 {
                    joint.step_with(reference, asked);
                    worst = worst.max((joint.wires[0].tension_n() / asked - 1.0).abs());
                    angle = angle.max(((joint.motion.angle_rad() - reference) / joint.stroke).abs());
                }
                assert!(worst < 0.5 && angle < 0.035, "{seed}: {share}: {mpa} MPa: tension off {worst}, angle {angle}");
                off.push(worst);
            }
        }
    }
    off.sort_by(f64::total_cmp);
    let beyond = off.iter().filter(|worst| **worst > 0.12).count();
    println!(
        "{} places: median {:.3}, worst {:.3}, beyond 12 %: {beyond}",
        off.len(),
        off[off.len() / 2],
        off[off.len() - 1]
    );
    assert!(off[off.len() / 2] < 0.08 && beyond * 10 <= off.len(), "{off:.3?}");
}

/// Latent heat, convection and transformation temperatures are never those of the rig file.
#[test]
fn a_pair_that_is_not_its_model_is_still_followed() {
    let told = model(0.05, 12.0);
    for change in [
        |m: &mut Material| m.convection_w_per_m2_k *= 1.3,
        |m: &mut Material| m.convection_w_per_m2_k *= 0.7,
        |m: &mut Material| m.latent_heat_j_per_kg *= 1.3,
        |m: &mut Material| m.latent_heat_j_per_kg *= 0.7,
    ] {
        let mut truth = told.clone();
        change(&mut truth.material);
        let rms = Loop::new(&told, truth.clone(), 30e-6).follow(0.5, 14.0, 4.0);
        assert!(
            rms < 0.015,
            "{rms} with h {} H {}",
            truth.material.convection_w_per_m2_k,
            truth.material.latent_heat_j_per_kg
        );
    }
}

#[test]
fn a_standing_reference_is_reached_from_cold_and_held_within_the_tension_limits() {
    let told = model(0.05, 12.0);
    for share in [-0.2, 0.1, 0.25] {
        let mut joint = Loop::new(&told, told.clone(), 30e-6);
        let reference = share * joint.stroke;
        (0..4000).for_each(|_| joint.step(reference));
        let (mut square, mut worst) = (0.0, 0.0_f64);
        for _ in 0..4000 {
            joint.step(reference);
            let off = (joint.motion.angle_rad() - reference) / joint.stroke;
            square += off * off / 4000.0;
            worst = worst.max(off.abs());
        }
        assert!(square.sqrt() < 0.007 && worst < 0.02, "{share}: {} rms, {worst} at worst", square.sqrt());
        let mpa = joint.wires[0].stress_pa() * 1e-6;
        assert!(mpa > 50.0 && mpa < 510.0, "{share}: {mpa} MPa");
    }
}

#[test]
fn two_cold_wires_are_known_to_be_slack() {
    let told = model(0.05, 12.0);
    let mut joint = Loop::new(&told, told.clone(), 0.0);
    let seen = Observation {
        // a slack wire measures its own length, longer than the way it hangs in
        length_m: LENGTH * 1.042,
        length_sigma_m: 30e-6,
        ..Observation::nothing(0.02, DT)
    };
    let mut estimate = joint.observer.update([&seen, &seen]);
    for _ in 0..500 {
        estimate = joint.observer.update([&seen, &seen]);
    }
    assert!(estimate.is_slack && estimate.slack_m > 1e-3, "{estimate:?}");
    let demand =
        JointDemand { tension_n: f64::NAN, resistance_ohm: [f64::NAN; 2], reference_rad: 0.0, dt_s: DT, estimate };
    let duties = joint.law.duties(&demand);
    assert!(duties.iter().all(|duty| *duty > 0.05) && joint.law.is_limited(), "both are warmed: {duties:?}");
}

#[test]
fn nothing_is_heated_at_the_tension_limit() {
    let told = model(0.05, 12.0);
    let mut joint = Loop::new(&told, told.clone(), 0.0);
    joint.follow(0.5, 4.0, 1.0);
    let mut estimate = joint.estimate.unwrap();
    estimate.tension_n = [2.0; 2];
    for reference_rad in [-0.3, 0.0, 0.3] {
        let duties = joint.law.duties(&JointDemand {
            tension_n: f64::NAN,
            resistance_ohm: [f64::NAN; 2],
            reference_rad,
            dt_s: DT,
            estimate,
        });
        assert_eq!(duties, [0.02; 2]);
        assert!(joint.law.is_limited());
    }
}

/// A clock that hardly moves must not divide anything by nothing.
#[test]
fn an_instant_of_no_length_is_none() {
    let told = model(0.05, 12.0);
    let mut joint = Loop::new(&told, told.clone(), 30e-6);
    (0..50).for_each(|_| joint.step(0.1));
    let before = joint.estimate.unwrap();
    for dt_s in [f64::MIN_POSITIVE, 1.6270800186003e-311, 1e-300, 1e-12] {
        let seen = Observation::nothing(0.3, dt_s);
        let estimate = joint.observer.update([&seen, &seen]);
        for (wire, before) in estimate.wires.iter().zip(&before.wires) {
            assert!((wire.temperature_c - before.temperature_c).abs() < 1.0, "{dt_s}: {wire:?}");
            assert!((wire.martensite - before.martensite).abs() < 0.05, "{dt_s}: {wire:?}");
        }
        assert!((estimate.angle_rad - before.angle_rad).abs() < 0.05);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever comes in, duties are duties and beliefs are numbers.
    #[test]
    fn no_input_makes_it_unsafe(inputs in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>()), 1..20)) {
        let told = model(0.05, 12.0);
        let mut joint = Loop::new(&told, told.clone(), 30e-6);
        let mut others = JointAlgorithmKind::ALL.map(|kind| Loop::under(kind, 0.0, &told, told.clone(), 30e-6).law);
        (0..50).for_each(|_| joint.step(0.1));
        for (length_m, power_w, resistance_ohm, reference_rad, dt_s) in inputs {
            let odd = Observation {
                power_w, duty: power_w, length_m, length_sigma_m: length_m, resistance_ohm, resistance_sigma_ohm: power_w, tension_n: dt_s, dt_s,
            };
            let even = Observation::nothing(0.3, DT);
            let estimate = joint.observer.update([&odd, &even]);
            for wire in &estimate.wires {
                prop_assert!(wire.temperature_c.is_finite() && (0.0..=1.0).contains(&wire.martensite), "{wire:?}");
            }
            for demand in [
                JointDemand { tension_n: f64::NAN, resistance_ohm: [resistance_ohm, power_w], reference_rad, dt_s, estimate },
                JointDemand { tension_n: power_w, resistance_ohm: [74.0, resistance_ohm], reference_rad: 0.1, dt_s: DT, estimate },
            ] {
                for law in std::iter::once(&mut joint.law).chain(&mut others) {
                    let duties = law.duties(&demand);
                    prop_assert!(duties.iter().all(|duty| (0.02..=1.0).contains(duty)), "{law:?}: {duties:?}");
                }
            }
        }
        // and it comes back
        (0..3000).for_each(|_| joint.step(0.1));
        let estimate = joint.estimate.unwrap();
        prop_assert!((estimate.angle_rad - joint.motion.angle_rad()).abs() < 0.05, "{} {}", estimate.angle_rad, joint.motion.angle_rad());
    }
}
