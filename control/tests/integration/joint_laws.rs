//! Table 5's laws of a pair in closed loop, each first on a pair like its paper's.

use sinew_control::*;
use sinew_physics::WireModel;

use crate::joint::{Loop, model};

/// Those that see the resistances alone.
const BLIND_TO_LENGTH: [JointAlgorithmKind; 3] = [
    JointAlgorithmKind::DifferentialResistanceFuzzy,
    JointAlgorithmKind::DifferentialResistanceSliding,
    JointAlgorithmKind::ResistancePolynomials,
];

/// Noise of a length, m, of the simulated converter on 0.05 mm wires.
const NOISE_M: f64 = 30e-6;

/// The 0.05 mm pair of a resistivity that does not change with temperature, which the papers on resistance take for granted.
fn athermal() -> WireModel {
    let mut told = model(0.05, 12.0);
    told.material.austenite_resistivity_slope_ohm_m_per_k = 0.0;
    told.material.martensite_resistivity_slope_ohm_m_per_k = 0.0;
    told
}

/// What the difference of both true tensions is off the one wanted, by time in s: RMS over the last four of six seconds, N.
fn off_n(joint: &mut Loop, rad_per_n: f64, wanted_n: impl Fn(f64) -> f64) -> f64 {
    let mut square = 0.0;
    for tick in 0..6000 {
        let wanted_n = wanted_n(f64::from(tick) * 1e-3);
        joint.step(wanted_n * rad_per_n);
        if tick >= 2000 {
            square += (joint.wires[0].tension_n() - joint.wires[1].tension_n() - wanted_n).powi(2) / 4000.0;
        }
    }
    square.sqrt()
}

/// Teh's and Grant's pairs pull at a load cell and hardly move: so does one whose joint has a spring five times as stiff as the wires, with
/// the position loop taken away. Table 5: 0.017 % of ±3 N and 2 Hz, and 2 % with limit cycles, 2 Hz. Here, by estimated tensions and with
/// noise, under 1 % of ±3 N; 2 Hz are beyond what still air lets 0.1 mm do.
#[test]
fn a_pair_that_is_held_pulls_as_asked() {
    let told = model(0.1, 12.0);
    let spring_n_m = 5.0 * 0.008f64.powi(2) * 2.0 * told.stiffest_n_per_m();
    let none = Some(0.0);
    let gains = JointGains { proportional_per_m: none, integral_per_m_s: none, derivative_s_per_m: none };
    for kind in [JointAlgorithmKind::DifferentialForce, JointAlgorithmKind::DifferentialForceRelay] {
        let mut joint = Loop::with(kind, gains, spring_n_m, &told, told.clone(), NOISE_M);
        (0..3000).for_each(|_| joint.step(0.0));
        for wanted_n in [0.5, -0.5, 1.0] {
            let off_n = off_n(&mut joint, 0.008 / spring_n_m, |_| wanted_n);
            println!("{} {wanted_n} N: {:.1} mN", kind.word(), 1e3 * off_n);
            assert!(off_n < 0.03, "{} {wanted_n} N: {off_n} N", kind.word());
        }
        for (hz, within_n) in [(0.5, 0.12), (1.0, 0.2), (2.0, 0.6)] {
            let sine = |time_s: f64| 0.5 * (std::f64::consts::TAU * hz * time_s).sin();
            let off_n = off_n(&mut joint, 0.008 / spring_n_m, sine);
            println!("{} ±0.5 N, {hz} Hz: {:.0} mN", kind.word(), 1e3 * off_n);
            assert!(off_n < within_n, "{} {hz} Hz: {off_n} N", kind.word());
        }
    }
}

/// Position by differential force: table 5 has nothing above 1 Hz.
#[test]
fn differential_force_follows_an_angle() {
    let told = model(0.05, 12.0);
    for kind in [JointAlgorithmKind::DifferentialForce, JointAlgorithmKind::DifferentialForceRelay] {
        let mut joint = Loop::under(kind, 0.0, &told, told.clone(), NOISE_M);
        let (slow, fast) = (joint.follow(0.25, 12.0, 8.0), joint.follow(1.0, 6.0, 4.0));
        println!("{}: {:.2} % at 0.25 Hz, {:.2} % at 1 Hz", kind.word(), 100.0 * slow, 100.0 * fast);
        assert!(slow < 0.006 && fast < 0.015, "{}: {slow} {fast}", kind.word());
    }
}

/// Table 5: 0.4 % at 1 Hz [173], nothing in numbers [123], and 1.093 % at 0.15 Hz [172]. On wires whose resistance is their phase the pair is
/// held and followed; on the thesis' wires, where it is their temperature as well, it is lost, as chapter 7 says.
#[test]
fn resistances_tell_the_angle_as_far_as_they_are_the_phase() {
    for (kind, within) in BLIND_TO_LENGTH.into_iter().zip([0.015, 0.015, 0.015]) {
        let told = athermal();
        let mut joint = Loop::under(kind, 0.0, &told, told.clone(), NOISE_M);
        (0..4000).for_each(|_| joint.step(0.0));
        let (slow, fast) = (joint.follow(0.15, 26.7, 13.3), joint.follow(1.0, 6.0, 4.0));
        println!("{}: {:.2} % at 0.15 Hz, {:.2} % at 1 Hz", kind.word(), 100.0 * slow, 100.0 * fast);
        assert!(slow < within && fast < 0.05, "{}: {slow} {fast}", kind.word());

        let told = model(0.05, 12.0);
        let mut joint = Loop::under(kind, 0.0, &told, told.clone(), NOISE_M);
        (0..4000).for_each(|_| joint.step(0.0));
        let lost = joint.follow(0.25, 12.0, 8.0);
        assert!(lost > 0.08, "{}: {lost}", kind.word());
    }
}

/// Anti-slack by the true tension, under every law: once the pair is taut, it stays above its least, with noise, through steps and sines, on
/// a pair with a fifth more loss to the air than is believed; and below the upper limit but for what the estimate is off.
#[test]
fn no_law_lets_a_wire_go_slack() {
    let told = model(0.05, 12.0);
    let area = told.geometry.area_m2();
    let mut truth = told.clone();
    truth.material.convection_w_per_m2_k *= 1.2;
    for kind in JointAlgorithmKind::ALL {
        let mut joint = Loop::under(kind, 0.0, &told, truth.clone(), NOISE_M);
        (0..4000).for_each(|_| joint.step(0.1 * joint.stroke));
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        let mut see = |joint: &Loop| {
            let tensions = joint.wires.each_ref().map(|wire| wire.tension_n() / area * 1e-6);
            (least, most) = (least.min(tensions[0]).min(tensions[1]), most.max(tensions[0]).max(tensions[1]));
        };
        for share in [0.3, -0.3, 0.0, 0.25, 0.2, -0.1] {
            for _ in 0..2500 {
                joint.step(share * joint.stroke);
                see(&joint);
            }
        }
        for tick in 0..8000 {
            let hz = if tick < 4000 { 0.5 } else { 2.0 };
            joint.step(0.2 * joint.stroke * (std::f64::consts::TAU * hz * f64::from(tick) * 1e-3).sin());
            see(&joint);
        }
        println!("{}: {least:.0} to {most:.0} MPa", kind.word());
        assert!(least > 50.0 && most < 560.0, "{}: {least} to {most} MPa", kind.word());
    }
}

/// A law that keeps a tension keeps that which is asked for; slack never.
#[test]
fn differential_force_keeps_the_tension_asked_for() {
    let told = model(0.05, 12.0);
    let area = told.geometry.area_m2();
    for kind in [JointAlgorithmKind::DifferentialForce, JointAlgorithmKind::DifferentialForceRelay] {
        assert!(kind.takes_tension());
        let mut joint = Loop::under(kind, 0.0, &told, told.clone(), NOISE_M);
        for mpa in [150.0, 300.0, 400.0] {
            (0..5000).for_each(|_| joint.step_with(0.0, mpa * 1e6 * area));
            let found = joint.wires[0].stress_pa() * 1e-6;
            println!("{} {mpa}: {found:.0} MPa", kind.word());
            assert!(found > 0.9 * mpa, "{} {mpa}: {found} MPa", kind.word());
        }
    }
    assert!(BLIND_TO_LENGTH.iter().all(|kind| !kind.takes_tension()));
}
