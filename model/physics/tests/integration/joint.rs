//! Two wires on one joint, against closed forms, against the books of energy and against a far finer step.

use sinew_physics::*;

fn model(diameter_mm: f64, ambient_c: f64) -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: diameter_mm * 1e-3, length_m: 0.16 },
        material: Material::default(),
        taps: None,
        drive: Drive { kind: DriveKind::Power, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 },
        load: Load::ImposedPosition,
        initial: Initial::default(),
        ambient_c,
        effects: Effects::default(),
    }
}

fn joint() -> Joint {
    Joint {
        radius_m: 0.008,
        inertia_kg_m2: 2.5e-6,
        damping_n_m_s: 0.0,
        spring_n_m: 0.0,
        torque_n_m: 0.0,
        pretension_n: 1.5,
    }
}

/// A joint with its wires under constant powers.
struct Pair {
    models: [WireModel; 2],
    motion: JointMotion,
    wires: [Wire; 2],
}

impl Pair {
    fn new(joint: &Joint, models: [WireModel; 2]) -> Pair {
        let motion = JointMotion::new(joint, [&models[0], &models[1]]).unwrap();
        let wires = [motion.wire(0, &models[0]).unwrap(), motion.wire(1, &models[1]).unwrap()];
        Pair { models, motion, wires }
    }

    fn step(&mut self, power_w: [f64; 2], torque_n_m: f64, dt_s: f64) {
        let [a, b] = &self.models;
        let inputs = [Inputs { drive: power_w[0], ..a.rest_inputs() }, Inputs { drive: power_w[1], ..b.rest_inputs() }];
        let [agonist, antagonist] = &mut self.wires;
        self.motion.step([agonist, antagonist], [&inputs[0], &inputs[1]], torque_n_m, dt_s);
    }
}

/// Frequency of the joint by its upward zero crossings, Hz.
fn frequency_hz(pair: &mut Pair, dt_s: f64, seconds: f64) -> f64 {
    let mut crossings = Vec::new();
    let mut before = pair.motion.rate_rad_s();
    for tick in 0..(seconds / dt_s) as usize {
        pair.step([0.0; 2], 0.0, dt_s);
        let now = pair.motion.rate_rad_s();
        if before < 0.0 && now >= 0.0 {
            crossings.push((tick as f64 + before / (before - now)) * dt_s);
        }
        before = now;
    }
    (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0])
}

#[test]
fn oscillates_on_two_elastic_wires_as_the_closed_form_says() {
    // In air of 200 °C both wires are austenite and nothing but elastic.
    for (d1, d2, spring) in [(0.125, 0.125, 0.0), (0.05, 0.1, 0.0), (0.05, 0.05, 0.02)] {
        let joint = Joint { spring_n_m: spring, pretension_n: 0.4, ..joint() };
        let mut pair = Pair::new(&joint, [model(d1, 200.0), model(d2, 200.0)]);
        pair.step([0.0; 2], 1e-4, 2e-4);
        let stiffness = |m: &WireModel| 75e9 * m.geometry.area_m2() / m.geometry.length_m;
        let [a, b] = &pair.models;
        let lever = joint.radius_m * joint.radius_m * (stiffness(a) + stiffness(b)) + spring;
        let expected = (lever / joint.inertia_kg_m2).sqrt() / std::f64::consts::TAU;
        let found = frequency_hz(&mut pair, 5e-5, 0.5);
        assert!((found / expected - 1.0).abs() < 3e-3, "{found} Hz, expected {expected}");
        assert!(pair.wires.iter().all(|wire| wire.tension_n() > 0.1), "both taut throughout");
    }
}

#[test]
fn an_undamped_joint_keeps_its_energy() {
    let mut pair = Pair::new(&joint(), [model(0.125, 200.0), model(0.125, 200.0)]);
    pair.step([0.0; 2], 1e-4, 1e-3);
    let swing = |pair: &mut Pair| {
        (0..200).for_each(|_| pair.step([0.0; 2], 0.0, 1e-4));
        (0..400).fold(0.0_f64, |most, _| {
            pair.step([0.0; 2], 0.0, 5e-5);
            most.max(pair.motion.rate_rad_s().abs())
        })
    };
    let first = swing(&mut pair);
    for _ in 0..30 {
        swing(&mut pair);
    }
    let last = swing(&mut pair);
    assert!(first > 1e-3 && (last / first - 1.0).abs() < 5e-3, "{first} rad/s, later {last}");
}

#[test]
fn electrical_energy_is_heat_and_work_to_the_joule() {
    let joint = Joint { damping_n_m_s: 2e-3, spring_n_m: 0.01, torque_n_m: 2e-3, ..joint() };
    let mut pair = Pair::new(&joint, [model(0.125, 25.0), model(0.1, 25.0)]);
    // one sub-step each, so that the sums here are the model's own trapezoids
    let dt = 2e-4;
    let mut elastic = [0.0; 2];
    let mut pulled = [0.0; 2];
    let state = |wire: &Wire, model: &WireModel| {
        let m = &model.material;
        let xi = wire.martensite();
        let compliance = (1.0 - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
        let warm = m.thermoelastic_pa_per_k * (wire.temperature_c() - m.reference_temperature_c);
        (wire.stress_pa(), compliance * (wire.stress_pa() + warm), wire.position_m())
    };
    let mut travel = (0.0_f64, 0.0_f64);
    for tick in 0..30_000 {
        let time = f64::from(tick) * dt;
        let phase = (std::f64::consts::PI * time).sin();
        let power = [1.3 + 1.1 * phase, 1.0 - 0.8 * phase];
        let before = [0, 1].map(|i| state(&pair.wires[i], &pair.models[i]));
        pair.step(power, 0.0, dt);
        for side in [0, 1] {
            let after = state(&pair.wires[side], &pair.models[side]);
            let stress = 0.5 * (before[side].0 + after.0);
            let volume = pair.models[side].geometry.volume_m3();
            let area = pair.models[side].geometry.area_m2();
            if before[side].0 > 0.0 && after.0 > 0.0 {
                elastic[side] += volume * stress * (after.1 - before[side].1);
            }
            pulled[side] -= area * stress * (after.2 - before[side].2);
        }
        travel = (travel.0.min(pair.motion.angle_rad()), travel.1.max(pair.motion.angle_rad()));
    }
    assert!(travel.1 - travel.0 > 0.2, "it moves: {travel:?}");
    let energy = pair.motion.energy();
    let moved = energy.wires_j[0].abs() + energy.damping_j;
    assert!(moved > 1e-3, "{energy:?}");
    assert!(energy.residual_j().abs() < 1e-3 * moved, "{energy:?}, residual {}", energy.residual_j());
    for side in [0, 1] {
        let wire = pair.wires[side].energy();
        assert!(wire.residual_j().abs() < 1e-9 * wire.heat_in_j, "{wire:?}");
        assert!((energy.wires_j[side] - pulled[side]).abs() < 1e-9 * moved, "{side}");
        // work of transformation = work on the joint + what is kept in, or lost by, the wire's elasticity
        let off = wire.work_j - pulled[side] - elastic[side];
        assert!(off.abs() < 2e-3 * wire.work_j.abs().max(moved), "{side}: {off} J of {}", wire.work_j);
    }
}

#[test]
fn a_control_period_at_once_is_as_good_as_in_a_hundred_pieces() {
    let joint = Joint { damping_n_m_s: 2e-3, ..joint() };
    let models = || [model(0.125, 25.0), model(0.125, 25.0)];
    let (mut coarse, mut fine) = (Pair::new(&joint, models()), Pair::new(&joint, models()));
    let mut worst = (0.0_f64, 0.0_f64);
    for tick in 0..6000 {
        let time = f64::from(tick) * 1e-3;
        let phase = (3.0 * time).sin();
        let power = [1.2 + 1.0 * phase, 1.2 - 1.0 * phase];
        coarse.step(power, 0.0, 1e-3);
        for _ in 0..100 {
            fine.step(power, 0.0, 1e-5);
        }
        worst.0 = worst.0.max((coarse.motion.angle_rad() - fine.motion.angle_rad()).abs());
        worst.1 = worst.1.max((coarse.wires[0].tension_n() - fine.wires[0].tension_n()).abs());
    }
    // of a travel of 0.8 rad and a tension of several N
    assert!(worst.0 < 4e-4 && worst.1 < 0.02, "{worst:?}");
}

#[test]
fn the_pair_is_at_its_pretension_at_both_ends() {
    let joint = Joint { damping_n_m_s: 2e-3, ..joint() };
    for hot in [0, 1] {
        let models = [model(0.125, 25.0), model(0.125, 25.0)];
        let mut pair = Pair::new(&joint, models);
        // 40 K above its shifted A, as the hot length is defined
        let m = &pair.models[0].material;
        let shifted = m.austenite_temperature_c
            + joint.pretension_n / pair.models[0].geometry.area_m2() * m.stress_shift_k_per_pa;
        let loss = m.convection_w_per_m2_k * pair.models[0].geometry.surface_m2();
        let mut power = [0.0; 2];
        power[hot] = loss * (shifted + 40.0 - 25.0);
        for _ in 0..20_000 {
            pair.step(power, 0.0, 1e-3);
        }
        for wire in &pair.wires {
            assert!((wire.tension_n() / joint.pretension_n - 1.0).abs() < 0.02, "{} N", wire.tension_n());
        }
        let stroke = {
            let alone = WireModel { load: joint.nominal_load(), ..pair.models[0].clone() };
            cold_length_m(&alone).unwrap() - hot_length_m(&alone).unwrap()
        };
        let expected = (1.0 - 2.0 * hot as f64) * 0.5 * stroke / joint.radius_m;
        assert!((pair.motion.angle_rad() / expected - 1.0).abs() < 0.01, "{} rad", pair.motion.angle_rad());
    }
}

#[test]
fn slack_wires_do_not_push() {
    let mut pair = Pair::new(&joint(), [model(0.125, 25.0), model(0.125, 25.0)]);
    assert_eq!(pair.wires.each_ref().map(Wire::tension_n), [0.0; 2], "both cold");
    // free fall under a small torque until a wire comes taut
    let torque = 1e-5;
    pair.step([0.0; 2], torque, 0.05);
    let expected = 0.5 * torque / joint().inertia_kg_m2 * 0.05 * 0.05;
    assert!((pair.motion.angle_rad() / expected - 1.0).abs() < 1e-6, "{}", pair.motion.angle_rad());
    let mut most = 0.0_f64;
    for _ in 0..2000 {
        pair.step([0.0; 2], torque, 1e-3);
        assert!(pair.wires.iter().all(|wire| wire.tension_n() >= 0.0));
        assert!(pair.wires.iter().any(|wire| wire.tension_n() == 0.0), "one is always slack");
        most = most.max(pair.wires[1].tension_n());
    }
    assert!(most > 0.0, "the antagonist catches it");
}

#[test]
fn a_joint_too_light_to_follow_is_refused_with_the_least_inertia() {
    let models = [model(0.125, 25.0), model(0.125, 25.0)];
    let light = Joint { inertia_kg_m2: 1e-10, ..joint() };
    let Err(Error::OutOfRange { key, low, .. }) = JointMotion::new(&light, [&models[0], &models[1]]).map(|_| ()) else {
        panic!("accepted")
    };
    assert_eq!(key, "inertia_kg_mm2");
    let least = Joint { inertia_kg_m2: low * 1e-6 * 1.000_001, ..light };
    let hz = least.fastest_rad_s([&models[0], &models[1]]) / std::f64::consts::TAU;
    assert!((hz / MOST_JOINT_HZ - 1.0).abs() < 1e-5, "{hz}");
    assert_eq!(least.validate([&models[0], &models[1]]), Ok(()));
}
