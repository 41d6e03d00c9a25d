//! Simulated clocks, of which the truth is known.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::*;

/// The other clock: an offset, a rate, and a rate that wanders.
#[derive(Debug, Clone, Copy)]
struct Truth {
    offset_ns: i64,
    rate_ppm: f64,
    wander_ppm: f64,
    period_s: f64,
}

impl Truth {
    /// What it shows when the driver's clock shows this, ns.
    fn other(&self, driver_ns: u64) -> i64 {
        let t = driver_ns as f64 * 1e-9;
        let turn = std::f64::consts::TAU / self.period_s;
        let ahead_us = self.rate_ppm * t + self.wander_ppm / turn * (1.0 - (turn * t).cos());
        driver_ns as i64 + self.offset_ns + (1e3 * ahead_us).round() as i64
    }
}

fn truths(drift_ppm_per_s: f64) -> impl Strategy<Value = Truth> {
    (-1_000_000_000_000i64..1_700_000_000_000_000_000, -150.0..150.0, 0.0..1.0, 60.0..2000.0).prop_map(
        move |(offset_ns, rate_ppm, share, period_s): (i64, f64, f64, f64)| Truth {
            offset_ns,
            rate_ppm,
            wander_ppm: (0.95 * share * drift_ppm_per_s * period_s / std::f64::consts::TAU).min(40.0),
            period_s,
        },
    )
}

/// How long something takes.
#[derive(Debug, Clone, Copy)]
enum Delays {
    Uniform(f64),
    Exponential(f64),
    /// Heavy tails: a mean there is, a variance there is none.
    Pareto(f64),
    /// Hardly any come close to the least, which there is.
    LogNormal(f64),
    /// Prompt mostly, and now and then very late.
    Bursts(f64),
}

impl Delays {
    fn draw(self, rng: &mut TestRng) -> f64 {
        let u = rng.random::<f64>().max(1e-12);
        match self {
            Delays::Uniform(scale) => 2.0 * scale * u,
            Delays::Exponential(scale) => -scale * u.ln(),
            Delays::Pareto(scale) => scale * (u.powf(-1.0 / 1.6) - 1.0),
            Delays::LogNormal(scale) => {
                let normal = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * rng.random::<f64>()).cos();
                scale * (normal.exp() - 0.03).max(0.0)
            }
            Delays::Bursts(scale) if u < 0.03 => 200.0 * scale * rng.random::<f64>(),
            Delays::Bursts(scale) => 0.2 * scale * rng.random::<f64>(),
        }
    }
}

fn delays() -> impl Strategy<Value = Delays> {
    (0usize..5, 2_000.0..3_000_000.0).prop_map(|(kind, scale)| match kind {
        0 => Delays::Uniform(scale),
        1 => Delays::Exponential(scale),
        2 => Delays::Pareto(scale),
        3 => Delays::LogNormal(scale),
        _ => Delays::Bursts(scale),
    })
}

/// Answers beside the truth.
#[derive(Debug, Default)]
struct Judged {
    errors: Vec<f64>,
    bounds: Vec<f64>,
    outside: usize,
    unknown: usize,
}

impl Judged {
    fn add(&mut self, found: Option<(i128, u64)>, truth: i128) {
        let Some((ns, error_ns)) = found else { return self.unknown += 1 };
        let error = (ns - truth).unsigned_abs() as f64;
        self.errors.push(error);
        self.bounds.push(error_ns as f64);
        // what the truth here is rounded to
        self.outside += usize::from(error > error_ns as f64 + 1.0);
    }

    /// Of a driver's stamp, both ways.
    fn look(&mut self, map: &ClockMap, truth: &Truth, driver_ns: u64) {
        let other = truth.other(driver_ns);
        self.add(map.other_at(driver_ns).map(|at| (at.ns.into(), at.error_ns)), other.into());
        self.add(map.driver_at(other).map(|at| (at.ns.into(), at.error_ns)), driver_ns.into());
    }

    fn medians(&mut self) -> (f64, f64) {
        let middle = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        (middle(&mut self.errors), middle(&mut self.bounds))
    }

    fn share_outside(&self) -> f64 {
        self.outside as f64 / self.errors.len().max(1) as f64
    }
}

const S: f64 = 1e9;

/// A clock that is asked now and then for some minutes, looked at meanwhile: now, shortly before and long ago.
fn asked(truth: &Truth, delays: Delays, every_s: f64, rng: &mut TestRng, judged: &mut Judged) -> ClockMap {
    let mut map = ClockMap::new(ClockRules::default());
    let mut t = 1000.0 * S;
    let end = t + 400.0 * every_s * S;
    while t < end {
        t += every_s * S * (0.5 + rng.random::<f64>());
        let (there, back) = (2000.0 + delays.draw(rng), 2000.0 + delays.draw(rng));
        let update = map.bracket((t - there) as u64, truth.other(t as u64), (t + back) as u64);
        assert!(!matches!(update, Update::Anew(_)), "{update:?} at {t}");
        t += back;
        for ago_s in [0.0, every_s * rng.random::<f64>(), 60.0 * rng.random::<f64>()] {
            if t - ago_s * S > 1000.0 * S {
                judged.look(&map, truth, (t - ago_s * S) as u64);
            }
        }
    }
    // long after the last one
    judged.look(&map, truth, (t + 300.0 * S) as u64);
    map
}

proptest! {
    #![proptest_config(Config::with_cases(40))]

    #[test]
    fn the_truth_is_within_what_is_stated_of_a_clock_that_is_asked(
        truth in truths(0.02), delays in delays(), every_s in 0.01f64..2.0, seed in any::<[u8; 32]>(),
    ) {
        let mut rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut judged = Judged::default();
        let map = asked(&truth, delays, every_s, &mut rng, &mut judged);
        // by what is assumed it cannot be outside
        prop_assert_eq!(judged.outside, 0, "{:?}", judged.medians());
        prop_assert_eq!(judged.unknown, 0);
        let (ppm, error_ppm) = map.rate_ppm().unwrap();
        prop_assert!((ppm - truth.rate_ppm).abs() <= error_ppm + truth.wander_ppm + 0.001, "{ppm} ± {error_ppm}");
    }

    #[test]
    fn a_clock_that_is_reset_is_begun_anew_and_one_that_jumps_is_too(
        truth in truths(0.02), ahead in any::<bool>(), by_ms in 20i64..5000, at in 20usize..180, seed in any::<[u8; 32]>(),
        to_zero in any::<bool>(),
    ) {
        let mut rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut map = ClockMap::new(ClockRules::default());
        let (mut now, mut t, mut judged) = (truth, 1000.0 * S, Judged::default());
        for i in 0..200 {
            t += 0.3 * S;
            if i == at {
                let by = if ahead { by_ms } else { -by_ms } * 1_000_000;
                now.offset_ns = if to_zero { -(t as i64) } else { truth.offset_ns + by };
            }
            let (there, back) = (Delays::Exponential(1e5).draw(&mut rng), Delays::Exponential(1e5).draw(&mut rng));
            let update = map.bracket((t - there) as u64, now.other(t as u64), (t + back) as u64);
            prop_assert_eq!(matches!(update, Update::Anew(_)), i == at, "{:?} at {}", update, i);
            if let (Update::Anew(Anew::Jumped { by_ns }), false) = (update, to_zero) {
                prop_assert!((by_ns / 1_000_000 - if ahead { by_ms } else { -by_ms }).abs() < 10, "{by_ns}");
            }
            judged.look(&map, &now, t as u64);
        }
        prop_assert_eq!(judged.outside, 0);
        // before it was reset nothing is known any more
        prop_assert_eq!(map.driver_at(now.other((1000.0 * S) as u64) - 1), None);
        prop_assert_eq!(map.anew().1, 1);
    }

    #[test]
    fn no_pairs_whatever_make_it_panic(
        pairs in prop::collection::vec((any::<u64>(), any::<i64>(), any::<u64>(), any::<bool>()), 0..200),
        rate in any::<f64>(), drift in any::<f64>(), asked in any::<u64>(), resolution in any::<u64>(),
    ) {
        let mut map = ClockMap::new(ClockRules {
            max_rate_ppm: rate, drift_ppm_per_s: drift, resolution_ns: resolution, least_delay_ns: asked, ..ClockRules::default()
        });
        for (driver, other, error, is_late) in pairs {
            let _ = if is_late { map.late(driver, other) } else { map.pair(driver, other, error) };
            let _ = (map.other_at(asked), map.driver_at(other), map.rate_ppm());
        }
    }
}

/// Stamps that come so often and late; looked at as they come and once a second some way back.
fn received(
    truth: &Truth,
    delays: Delays,
    every_s: f64,
    least_ns: f64,
    rng: &mut TestRng,
    judged: &mut Judged,
) -> ClockMap {
    let rules = ClockRules { least_delay_ns: least_ns as u64, ..ClockRules::default() };
    let mut map = ClockMap::new(rules);
    let mut t = 1000.0 * S;
    let mut free = 0.0f64;
    for i in 0..3000 {
        t += every_s * S;
        // in order, as a serial line or a socket has them
        free = free.max(t + least_ns + delays.draw(rng));
        map.late(free as u64, truth.other(t as u64));
        if i % 10 == 0 {
            judged.look(&map, truth, t as u64);
            let back_s = 30.0f64.min(0.9 * every_s * i as f64) * rng.random::<f64>();
            judged.look(&map, truth, (t - back_s * S) as u64);
        }
    }
    map
}

/// One-way delays leave the truth to chance: judged over all cases together.
#[test]
fn the_truth_is_within_what_is_stated_of_stamps_that_come_late() {
    let mut runner = TestRunner::new_with_rng(Config::default(), TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let mut all = Judged::default();
    let mut worst = (0.0, None);
    for _ in 0..60 {
        let strategy =
            (truths(0.02), delays(), prop::sample::select(vec![0.005f64, 0.02, 0.1, 0.5]), any::<[u8; 32]>());
        let (truth, delays, every_s, seed) = strategy.new_tree(&mut runner).unwrap().current();
        let mut rng = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
        let mut judged = Judged::default();
        let map = received(&truth, delays, every_s, 50_000.0, &mut rng, &mut judged);
        let (error, bound) = judged.medians();
        assert!(bound < 6.0 * error + 3000.0, "idle: {error} ns, {bound} ns, {delays:?} every {every_s} s");
        assert_eq!(map.anew().1, 0, "{delays:?} every {every_s} s");
        if judged.share_outside() > worst.0 {
            worst = (judged.share_outside(), Some((truth, delays, every_s)));
        }
        all.errors.extend(&judged.errors);
        all.bounds.extend(&judged.bounds);
        all.outside += judged.outside;
        all.unknown += judged.unknown;
    }
    assert!(all.share_outside() <= 0.001, "{}: {worst:?}", all.share_outside());
    assert!(all.unknown < all.errors.len() / 5, "{} unknown of {}", all.unknown, all.errors.len());
}

#[test]
fn a_clock_asked_rarely_and_promptly_is_known_much_better_than_to_its_delays() {
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let truth = Truth { offset_ns: 77, rate_ppm: 31.0, wander_ppm: 0.2, period_s: 600.0 };
    let mut judged = Judged::default();
    asked(&truth, Delays::Exponential(100_000.0), 0.5, &mut rng, &mut judged);
    let (error, bound) = judged.medians();
    assert!(judged.outside == 0 && bound < 6.0 * error && bound < 50_000.0, "{error} {bound}");
}

#[test]
fn late_stamps_of_a_clock_set_back_begin_anew_and_a_short_delay_of_all_does_not() {
    let truth = Truth { offset_ns: 0, rate_ppm: 10.0, wander_ppm: 0.0, period_s: 100.0 };
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let run = |from_s: f64, to_s: f64, set_back_ms: i64, delay_ms: f64, rng: &mut TestRng| {
        let mut map = ClockMap::new(ClockRules::default());
        let mut judged = Judged::default();
        for i in 0..4000 {
            let t = 1000.0 * S + 0.01 * S * i as f64;
            let is_then = (from_s..to_s).contains(&(0.01 * i as f64));
            let now = Truth { offset_ns: if is_then { -set_back_ms * 1_000_000 } else { 0 }, ..truth };
            let delay = Delays::Exponential(50_000.0).draw(rng) + if is_then { 1e6 * delay_ms } else { 0.0 };
            map.late((t + delay) as u64, now.other(t as u64));
            if i > 3900 {
                judged.look(&map, &now, t as u64);
            }
        }
        (map.anew(), judged)
    };
    // shorter than the interval between two stamps, so that they do not go back
    let ((why, times), judged) = run(10.0, f64::INFINITY, 6, 0.0, &mut rng);
    assert!(matches!(why, Some(Anew::Jumped { by_ns }) if by_ns < 0) && times == 1, "{why:?} {times}");
    assert_eq!((judged.outside, judged.unknown), (0, 0));
    let ((why, times), judged) = run(10.0, 11.0, 0, 6.0, &mut rng);
    assert_eq!((why, times, judged.outside), (None, 0, 0), "a second of congestion");
    let ((why, times), judged) = run(10.0, f64::INFINITY, 2000, 0.0, &mut rng);
    assert!(matches!(why, Some(Anew::WentBack { .. })) && times == 1, "{why:?}");
    assert_eq!(judged.outside, 0);
    let ((why, times), _) = run(10.0, f64::INFINITY, -6, 0.0, &mut rng);
    assert!(matches!(why, Some(Anew::Jumped { by_ns }) if (4_000_000..7_000_000).contains(&by_ns)), "{why:?} {times}");
}

#[test]
fn what_is_not_known_is_said_so() {
    let mut map = ClockMap::new(ClockRules::default());
    assert_eq!((map.driver_at(0), map.other_at(0), map.rate_ppm()), (None, None, None));
    map.late(5, 3);
    assert_eq!((map.driver_at(3), map.other_at(5)), (None, None), "one late stamp bounds nothing from below");
    let update = map.pair(1_000_000_000, 500, 100);
    assert!(matches!(update, Update::Anew(Anew::Jumped { by_ns: -1_000_000_000..-999_000_000 })), "{update:?}");
    let near = map.other_at(1_000_000_000).unwrap();
    assert!(near.ns.abs_diff(500) <= 1 && (100..105).contains(&near.error_ns), "{near:?}");
    // by the rate alone, 200 ppm
    let far = map.other_at(11_000_000_000).unwrap();
    assert!((2_000_000..2_010_000).contains(&far.error_ns), "{far:?}");
}

#[test]
fn both_kinds_of_pairs_are_kept_for_as_long_as_there_is_room_without_an_allocation() {
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let truth = Truth { offset_ns: -5, rate_ppm: -40.0, wander_ppm: 0.5, period_s: 300.0 };
    let rules = ClockRules { pairs: 40, ..ClockRules::default() };
    let (mut map, mut judged) = (ClockMap::new(rules), Judged::default());
    let room = map.kept.capacity();
    for i in 0..30_000 {
        let t = 1000.0 * S + 0.01 * S * i as f64;
        let delay = Delays::Exponential(50_000.0).draw(&mut rng);
        if i % 2 == 0 {
            map.late((t + delay) as u64, truth.other(t as u64));
        } else {
            map.bracket((t - delay) as u64, truth.other(t as u64), (t + 10_000.0) as u64);
        }
        if i % 100 == 99 {
            judged.look(&map, &truth, t as u64);
        }
    }
    assert_eq!((judged.outside, judged.unknown, map.kept.capacity()), (0, 0, room));
    assert!(map.kept.is_sorted_by(|a, b| a.at <= b.at) && map.pairs() > 20);
    let late = map.kept.iter().filter(|pair| pair.is_late()).count();
    assert!(late > 8 && map.pairs() - late > 8, "{late} of {}", map.pairs());
    assert!(span_s(&map.kept) > 100.0, "{} s", span_s(&map.kept));
}

#[test]
fn a_busy_machine_makes_late_stamps_unsure_and_begins_nothing_anew() {
    let truth = Truth { offset_ns: 3, rate_ppm: 25.0, wander_ppm: 0.0, period_s: 100.0 };
    let mut rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let (mut map, mut judged) = (ClockMap::new(ClockRules::default()), Judged::default());
    for i in 0..6000 {
        let seconds = 0.005 * i as f64;
        let t = 1000.0 * S + S * seconds;
        // all of the first three seconds, and once more for four: by milliseconds, together
        let busy = seconds < 3.0 || (12.0..16.0).contains(&seconds);
        let delay = Delays::Exponential(40_000.0).draw(&mut rng)
            + if busy { 2e6 + Delays::Exponential(3e6).draw(&mut rng) } else { 0.0 };
        map.late((t + delay) as u64, truth.other(t as u64));
        // while it was busy from the start nobody could know what it does otherwise
        if i % 10 == 0 && seconds > 3.1 {
            judged.look(&map, &truth, t as u64);
        }
    }
    assert_eq!((map.anew().1, judged.outside, judged.unknown), (0, 0, 0));
    let (error, bound) = judged.medians();
    assert!(bound < 6.0 * error + 3000.0 && bound < 200_000.0, "{error} {bound}");
}
