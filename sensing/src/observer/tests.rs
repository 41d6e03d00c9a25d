//! The observer against noise, missing lengths, and motions it has to follow exactly.

use super::*;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;

const DRIVE: Drive = Drive { natural_rad_s: 170.0, damping_ratio: 0.6, full_duty_m_s: -0.01 };

fn bare(rate_hz: f64, bandwidth_hz: f64) -> MotionObserver {
    MotionObserver::new(rate_hz, ObserverConfig { bandwidth_hz, ..ObserverConfig::default() }).unwrap()
}

fn driven(rate_hz: f64) -> MotionObserver {
    MotionObserver::new(rate_hz, ObserverConfig::with_drive(60e-6, DRIVE)).unwrap()
}

/// Rms error at rest of length, velocity and acceleration, after the gains have settled.
fn noise(mut observer: MotionObserver, rate_hz: f64, seconds: f64) -> Motion {
    let mut rng = SmallRng::seed_from_u64(3);
    let mut sums = [0.0; 3];
    let (settle, cycles) = (2.0 * rate_hz, seconds * rate_hz);
    for cycle in 0..(settle + cycles) as u32 {
        let length = 0.163 + 60e-6 * rng.sample::<f64, _>(StandardNormal);
        let m = observer.update(Some(length), 1.0 / rate_hz);
        if f64::from(cycle) >= settle {
            for (sum, e) in sums.iter_mut().zip([m.length_m - 0.163, m.velocity_m_s, m.acceleration_m_s2]) {
                *sum += e * e;
            }
        }
    }
    let [length_m, velocity_m_s, acceleration_m_s2] = sums.map(|sum: f64| (sum / cycles).sqrt());
    Motion { length_m, velocity_m_s, acceleration_m_s2 }
}

#[test]
fn gains_are_those_of_butterworth_when_sampled_fast() {
    let observer = bare(1e6, 20.0);
    let (omega, dt) = (std::f64::consts::TAU * 20.0, 1e-6);
    let expected = [2.0 * omega * dt, 2.0 * omega.powi(2) * dt, omega.powi(3) * dt];
    for (gain, expected) in observer.steady_gain.0.iter().zip(expected) {
        assert!((gain / expected - 1.0).abs() < 2e-3, "{gain} for {expected}");
    }
}

#[test]
fn settled_gains_are_where_the_covariance_goes() {
    for mut observer in [bare(1000.0, 7.0), driven(1000.0), driven(100.0), bare(10e3, 30.0)] {
        observer.update(Some(0.163), observer.nominal_dt);
        let mut p = observer.covariance;
        let r = observer.nominal_sigma.powi(2);
        let mut gain = Gain::default();
        for _ in 0..observer.settle + 20_000 {
            observer.nominal_step.predict(&mut p);
            gain = correct(&mut p, r);
        }
        for (limit, steady) in gain.0.iter().zip(observer.steady_gain.0) {
            assert!((limit - steady).abs() <= 1e-4 * steady.abs(), "{gain:?} {:?}", observer.steady_gain);
        }
    }
}

#[test]
fn noise_is_a_hundredth_of_what_differences_at_200_hz_have() {
    // Differences: √2 σ/T and √6 σ/T².
    let (velocity, acceleration) = (2f64.sqrt() * 60e-6 * 200.0, 6f64.sqrt() * 60e-6 * 200.0 * 200.0);
    for observer in [bare(1000.0, 7.0), driven(1000.0)] {
        let m = noise(observer, 1000.0, 20.0);
        assert!(m.length_m < 20e-6, "{m:?}");
        assert!(m.velocity_m_s < velocity / 20.0, "{m:?}");
        assert!(m.acceleration_m_s2 < acceleration / 300.0, "{m:?}");
    }
}

#[test]
fn noise_falls_with_the_square_root_of_the_rate() {
    let (slow, fast) = (noise(bare(1e3, 10.0), 1e3, 40.0), noise(bare(10e3, 10.0), 10e3, 40.0));
    let ratio = slow.acceleration_m_s2 / fast.acceleration_m_s2;
    assert!((ratio / 10f64.sqrt() - 1.0).abs() < 0.15, "{ratio}");
}

#[test]
fn its_own_deviation_bounds_the_noise_at_rest() {
    for observer in [bare(1000.0, 7.0), driven(1000.0)] {
        let own = {
            let mut settled = observer.clone();
            for _ in 0..5000 {
                settled.update(Some(0.163), 1e-3);
            }
            assert!(settled.settled());
            settled.deviation()
        };
        let m = noise(observer, 1000.0, 20.0);
        assert!(m.length_m < own.length_m && m.length_m > 0.3 * own.length_m, "{m:?} {own:?}");
        assert!(m.velocity_m_s < own.velocity_m_s && m.acceleration_m_s2 < own.acceleration_m_s2, "{m:?} {own:?}");
    }
}

#[test]
fn knows_the_load_it_was_told() {
    // Eq. 68 itself, integrated finely: the observer with the right drive and duty is far nearer than the bare chain.
    let truth_drive = Drive { natural_rad_s: 40.0, damping_ratio: 0.3, full_duty_m_s: -0.04 };
    let config = ObserverConfig::with_drive(60e-6, truth_drive);
    let mut observers = [MotionObserver::new(1000.0, config).unwrap(), bare(1000.0, 7.0)];
    let mut rng = SmallRng::seed_from_u64(5);
    let (mut x, mut v, mut a) = (0.165f64, 0.0f64, 0.0f64);
    let mut worst = [0.0f64; 2];
    for cycle in 0..3000u32 {
        // Some heating, in pulses, about the duty that would hold the wire; the rest is constant.
        let duty = if (cycle / 40) % 5 == 0 { 1.0 } else { 0.0 };
        for _ in 0..100 {
            let j = 1600.0 * (0.008 - 0.04 * duty - v) - 24.0 * a;
            (x, v, a) = (x + 1e-5 * v, v + 1e-5 * a, a + 1e-5 * j);
        }
        let length = x + 60e-6 * rng.sample::<f64, _>(StandardNormal);
        for (observer, worst) in observers.iter_mut().zip(&mut worst) {
            observer.set_duty(duty);
            let m = observer.update(Some(length), 1e-3);
            if cycle > 1000 {
                *worst = worst.max((m.acceleration_m_s2 - a).abs());
            }
        }
    }
    assert!(worst[0] < 0.05 && worst[0] < 0.1 * worst[1], "{worst:?}");
}

#[test]
fn an_overdamped_load_keeps_its_slow_pole() {
    let light = Drive::of_load(1e-4, 40.0, 4e3, 0.0);
    let observer = MotionObserver::new(1000.0, ObserverConfig::with_drive(60e-6, light)).unwrap();
    assert!((observer.plant.stiffness / observer.plant.damping / 100.0 - 1.0).abs() < 1e-9);
}

#[test]
fn predicts_while_lengths_are_missing_and_says_how_old_it_is() {
    let mut observer = bare(1000.0, 20.0);
    assert_eq!(observer.age_s(), f64::INFINITY);
    assert_eq!(observer.update(None, 1e-3), Motion::default());
    let at = |t: f64| 0.16 + 0.02 * t;
    for k in 0..2000 {
        observer.update(Some(at(1e-3 * f64::from(k))), 1e-3);
    }
    let before = observer.deviation();
    for k in 2000..2020 {
        let length = [None, Some(f64::NAN), Some(f64::INFINITY)][k as usize % 3];
        let m = observer.update(length, 1e-3);
        assert!((m.length_m - at(1e-3 * f64::from(k))).abs() < 1e-6, "{m:?}");
        assert_eq!(observer.missed(), k as u32 - 1999);
    }
    assert!((observer.age_s() - 0.020).abs() < 1e-9);
    assert!(observer.deviation().length_m > 2.0 * before.length_m, "covariance grows");
    // Having lost some, it trusts the next length more than a settled observer would.
    let estimate = observer.motion().length_m;
    let m = observer.update(Some(at(2.020) + 1e-3), 1e-3);
    assert!(m.length_m - estimate > 1e-3 * observer.steady_gain.of_length() * 2.0);
    assert_eq!((observer.missed(), observer.age_s()), (0, 0.0));
    // Too long: it stands still, and starts anew with the next length.
    for _ in 0..60 {
        observer.update(None, 1e-3);
    }
    assert_eq!(observer.motion().velocity_m_s, 0.0);
    let m = observer.update(Some(0.2), 1e-3);
    assert_eq!(m, Motion { length_m: 0.2, velocity_m_s: 0.0, acceleration_m_s2: 0.0 });
}

#[test]
fn a_cold_start_on_a_moving_wire_is_caught_up_with_soon() {
    // In 0.1 s, not in the several 1/ω that constant gains would take from a wrong velocity.
    let mut observer = bare(1000.0, 3.0);
    let mut m = Motion::default();
    for k in 0..100 {
        m = observer.update(Some(0.16 + 0.02 * 1e-3 * f64::from(k)), 1e-3);
    }
    assert!((m.velocity_m_s - 0.02).abs() < 0.02 * 0.1, "{m:?}");
}

#[test]
fn looks_ahead_without_moving() {
    let mut observer = bare(1000.0, 20.0);
    for k in 0..3000 {
        observer.update(Some(0.16 + 0.02 * 1e-3 * f64::from(k)), 1e-3);
    }
    let now = observer.motion();
    assert!((observer.ahead(0.004).length_m - now.length_m - 0.02 * 0.004).abs() < 1e-8);
    assert_eq!(observer.ahead(f64::NAN), now);
    assert_eq!(observer.motion(), now);
}

#[test]
fn rejects_what_it_cannot_use() {
    assert!(MotionObserver::new(0.0, ObserverConfig::default()).is_err());
    assert!(MotionObserver::new(f64::NAN, ObserverConfig::default()).is_err());
    let config = ObserverConfig { bandwidth_hz: f64::NAN, ..ObserverConfig::default() };
    assert!(MotionObserver::new(1000.0, config).is_err());
    let drive = Drive { damping_ratio: -1.0, ..DRIVE };
    assert!(MotionObserver::new(1000.0, ObserverConfig::with_drive(60e-6, drive)).is_err());
}

#[test]
fn the_bandwidth_of_a_jerk_is_the_one_of_its_density() {
    let hz = ObserverConfig::bandwidth_for_jerk(400.0, 0.005, 60e-6, 1000.0);
    let density = (std::f64::consts::TAU * hz).powi(6) * 60e-6f64.powi(2) * 1e-3;
    assert!((density / (2.0 * 400.0 * 400.0 * 0.005) - 1.0).abs() < 1e-9);
}

fn any_observer() -> impl Strategy<Value = (f64, MotionObserver)> {
    let drive = (0.0f64..5.0, -2.0f64..2.0, -0.1f64..0.1).prop_map(|(natural, damping, full_duty_m_s)| Drive {
        natural_rad_s: 10f64.powf(natural),
        damping_ratio: 10f64.powf(damping),
        full_duty_m_s,
    });
    (2.0f64..4.0, 0.0f64..1.6, proptest::option::of(drive)).prop_map(|(rate, bandwidth, drive)| {
        let rate_hz = 10f64.powf(rate);
        let bandwidth_hz = 10f64.powf(bandwidth);
        let config = ObserverConfig { bandwidth_hz, drive, ..ObserverConfig::default() };
        (rate_hz, MotionObserver::new(rate_hz, config).unwrap())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn exact_for_constant_acceleration_at_any_rate_and_step(
        rate in 2.0f64..4.0, bandwidth_hz in 3.0f64..30.0, v in -0.05f64..0.05, a in -0.5f64..0.5, seed: u64,
    ) {
        let rate_hz = 10f64.powf(rate);
        // a run of missing lengths must not be taken for a new start
        let config = ObserverConfig { bandwidth_hz, max_age_s: 1.0, ..ObserverConfig::default() };
        let mut observer = MotionObserver::new(rate_hz, config).unwrap();
        let mut rng = SmallRng::seed_from_u64(seed);
        let (mut t, mut m) = (0.0, Motion::default());
        let until = 30.0 / bandwidth_hz;
        while t < until {
            let dt = rng.random_range(0.3..1.9) / rate_hz;
            t += dt;
            // One in ten does not arrive.
            let length = (rng.random_range(0..10) != 0).then_some(0.16 + t * (v + 0.5 * a * t));
            m = observer.update(length, dt);
        }
        prop_assert!((m.length_m - (0.16 + t * (v + 0.5 * a * t))).abs() < 1e-9, "{m:?}");
        prop_assert!((m.velocity_m_s - (v + a * t)).abs() < 1e-7, "{m:?}");
        prop_assert!((m.acceleration_m_s2 - a).abs() < 1e-5, "{m:?} {a}");
    }

    #[test]
    fn exact_for_constant_velocity_with_any_drive(
        (rate_hz, mut observer) in any_observer(), v in -0.05f64..0.05, duty in 0.0f64..1.0,
    ) {
        // As slow as the slowest of observer and load, with margin; unknown loads may be slower than any run.
        let plant = observer.plant;
        let slow = if plant.driven { plant.stiffness.sqrt().min(plant.stiffness / plant.damping) } else { f64::INFINITY };
        let slow = slow.min(observer.config.bandwidth_hz);
        prop_assume!(slow > 1.0);
        observer.set_duty(duty);
        let cycles = (200.0 * rate_hz / slow) as u32;
        prop_assume!(cycles < 200_000);
        let mut m = Motion::default();
        for k in 0..cycles {
            m = observer.update(Some(0.16 + v * f64::from(k) / rate_hz), 1.0 / rate_hz);
        }
        prop_assert!((m.velocity_m_s - v).abs() < 1e-5, "{m:?} {v} {plant:?}");
        prop_assert!(m.acceleration_m_s2.abs() < 1e-2, "{m:?} {plant:?}");
    }

    #[test]
    fn stable_and_finite_whatever_comes((rate_hz, mut observer) in any_observer(), seed: u64) {
        let mut rng = SmallRng::seed_from_u64(seed);
        for _ in 0..5000 {
            let dt = match rng.random_range(0..50) {
                0 => rng.random_range(0.0..100.0) / rate_hz,
                1 => [f64::NAN, -1.0, 0.0, f64::INFINITY, 1e300][rng.random_range(0..5)],
                _ => rng.random_range(0.5..1.5) / rate_hz,
            };
            observer.set_duty(if rng.random_range(0..20) == 0 { f64::NAN } else { rng.random_range(0.0..1.0) });
            let length = match rng.random_range(0..20) {
                0 => Some(f64::NAN),
                1 | 2 => None,
                _ => Some(0.163 + 60e-6 * rng.sample::<f64, _>(StandardNormal)),
            };
            let m = observer.update_weighted(length, 60e-6 * rng.random_range(0.5..3.0), dt);
            let d = observer.deviation();
            for value in [m.length_m, m.velocity_m_s, m.acceleration_m_s2, d.length_m, d.velocity_m_s] {
                prop_assert!(value.is_finite(), "{m:?} {d:?}");
            }
        }
        // A second of good lengths corrects any state.
        for _ in 0..(2.0 * rate_hz) as u32 {
            observer.set_duty(0.0);
            let m = observer.update(Some(0.163), 1.0 / rate_hz);
            prop_assert!(m.length_m.is_finite());
        }
        prop_assert!((observer.motion().length_m - 0.163).abs() < 1e-3, "{:?}", observer.motion());
    }

    #[test]
    fn shifted_and_scaled_lengths_give_shifted_and_scaled_motion(
        (rate_hz, observer) in any_observer(), shift in -0.1f64..0.1, scale in 0.1f64..10.0, seed: u64,
    ) {
        let mut rng = SmallRng::seed_from_u64(seed);
        let (mut plain, mut other) = (observer.clone(), observer);
        for _ in 0..500 {
            let length = 0.16 + 1e-3 * rng.sample::<f64, _>(StandardNormal);
            let dt = rng.random_range(0.5..1.5) / rate_hz;
            let a = plain.update(Some(length), dt);
            let b = other.update(Some(scale * length + shift), dt);
            prop_assert!((scale * a.length_m + shift - b.length_m).abs() < 1e-9 * scale);
            prop_assert!((scale * a.velocity_m_s - b.velocity_m_s).abs() < 1e-7 * scale * rate_hz);
        }
    }
}
