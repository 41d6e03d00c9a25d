//! The sensor on the wire and converter it is configured for, healthy and faulty.

use super::*;
use crate::converter::Converter;
use crate::line::{ResistanceLine, WireEnd};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;

const AREA: f64 = 1.2272e-8;
const HOT: WireEnd = WireEnd { resistance_ohm: 11.9, length_m: 0.1603 };
const COLD: WireEnd = WireEnd { resistance_ohm: 10.4, length_m: 0.1667 };

fn config(l0_m: f64, ls_m: f64) -> LengthSensorConfig {
    let method = Method::DualMeasurement { l0_m, ls_m };
    LengthSensorConfig::for_wire(method, AREA, 6.0, HOT, COLD, Converter::default())
}

fn sensor() -> LengthSensor {
    LengthSensor::new(config(0.0, 0.150)).unwrap()
}

fn line() -> ResistanceLine {
    ResistanceLine::through(HOT, COLD).unwrap()
}

fn resistance_sensor() -> LengthSensor {
    let method = Method::Resistance { line: line() };
    let config = LengthSensorConfig::for_wire(method, AREA, 6.0, HOT, COLD, Converter::default());
    LengthSensor::new(config).unwrap()
}

/// What a wire of this length and resistance shows on the given taps.
fn sample_of(l0: f64, ls: f64, length: f64, resistance: f64, v3: f64) -> Sample {
    Sample {
        v1_v: v3 * l0 / length,
        v2_v: v3 * (l0 + ls) / length,
        v3_v: v3,
        current_a: v3 / resistance,
        supply_v: 6.0,
    }
}

fn healthy() -> Sample {
    sample_of(0.0, 0.150, 0.163, 11.3, 5.9)
}

struct Adc {
    rng: SmallRng,
    converter: Converter,
}

impl Adc {
    fn new(seed: u64, converter: Converter) -> Adc {
        Adc { rng: SmallRng::seed_from_u64(seed), converter }
    }

    fn measure(&mut self, s: Sample) -> Sample {
        let c = self.converter;
        let mut code = |value: f64, noise: f64, range: f64, lsb: f64| {
            let noisy = value + noise * self.rng.sample::<f64, _>(StandardNormal);
            ((noisy / lsb).round() * lsb).clamp(-range, range - lsb)
        };
        let mut voltage = |value| code(value, c.voltage_noise_v, c.voltage_range_v, c.voltage_lsb_v());
        let (v1_v, v2_v, v3_v) = (voltage(s.v1_v), voltage(s.v2_v), voltage(s.v3_v));
        let supply_v = voltage(s.supply_v);
        let current_a = code(s.current_a, c.current_noise_a, c.current_range_a, c.current_lsb_a());
        Sample { v1_v, v2_v, v3_v, current_a, supply_v }
    }
}

const LOW_OHM: f64 = 0.12;
const LEAD_OHM: f64 = 0.05;

fn shared(l0: f64, ls: f64, converter: Converter) -> LengthSensor {
    let config = LengthSensorConfig { converter, ..config(l0, ls) };
    LengthSensor::new(config.sharing(LOW_OHM, LEAD_OHM)).unwrap()
}

/// What a wire shows on a shared input: the circuit solved from the supply down.
fn shared_sample(l0: f64, ls: f64, length: f64, resistance: f64, supply_v: f64) -> Sample {
    let current_a = supply_v / (LEAD_OHM + resistance + LOW_OHM);
    let (low, per_metre) = (current_a * LOW_OHM, current_a * resistance / length);
    Sample { v1_v: low + per_metre * l0, v2_v: low + per_metre * (l0 + ls), v3_v: f64::NAN, current_a, supply_v }
}

/// The shared input's current goes through a voltage input.
fn shared_adc(seed: u64) -> Adc {
    Adc::new(seed, Converter::default().sharing(LOW_OHM))
}

#[test]
fn a_shared_input_gives_the_same_length_and_knows_its_noise() {
    for (l0, ls) in [(0.0, 0.150), (0.091, 0.055)] {
        let mut sensor = shared(l0, ls, Converter::default());
        let exact = shared_sample(l0, ls, 0.163, 11.3, 6.0);
        let reading = sensor.read(&exact);
        assert_eq!(reading.health, Health::Ok);
        assert!((reading.length_m - 0.163).abs() < 1e-12, "{reading:?}");
        assert!((reading.resistance_ohm - 11.3).abs() < 1e-9 && reading.resistivity_ohm_m > 0.0);
        assert!((reading.resistivity_ohm_m - 11.3 * AREA / 0.163).abs() < 1e-15);
        let (mut adc, mut squares, n) = (shared_adc(1), 0.0, 200_000);
        for _ in 0..n {
            squares += (sensor.read(&adc.measure(exact)).length().unwrap() - 0.163).powi(2);
        }
        let seen = (squares / f64::from(n)).sqrt();
        assert!((seen / reading.length_sigma_m - 1.0).abs() < 0.02, "{seen} seen, {} told", reading.length_sigma_m);
    }
    // A first tap that is not sampled is the shared input itself.
    let mut sensor = shared(0.0, 0.150, Converter::default());
    let untapped = Sample { v1_v: f64::NAN, ..shared_sample(0.0, 0.150, 0.163, 11.3, 6.0) };
    assert!(sensor.read(&untapped).length_m.is_finite());
}

#[test]
fn a_shared_input_raises_no_false_alarm() {
    let mut dual = shared(0.0, 0.150, Converter::default());
    let mut thesis = shared(0.091, 0.055, Converter::default());
    let mut adc = shared_adc(4);
    for k in 0..1_000_000u32 {
        let at = (0.5 + 0.7 * (f64::from(k) * 1e-5).sin()).clamp(0.0, 1.0);
        let (length, resistance) = (
            HOT.length_m + at * (COLD.length_m - HOT.length_m),
            HOT.resistance_ohm + at * (COLD.resistance_ohm - HOT.resistance_ohm),
        );
        let supply = 5.5 + 0.5 * (f64::from(k) * 3e-6).cos();
        for (sensor, l0, ls) in [(&mut dual, 0.0, 0.150), (&mut thesis, 0.091, 0.055)] {
            let reading = sensor.read(&adc.measure(shared_sample(l0, ls, length, resistance, supply)));
            assert_eq!(reading.health, Health::Ok, "sample {k}: {reading:?}");
        }
    }
}

#[test]
fn a_shared_input_finds_faults_at_once() {
    let good = shared_sample(0.0, 0.150, 0.163, 11.3, 6.0);
    let full = Sample { v1_v: 10.0, v2_v: 10.0, v3_v: f64::NAN, current_a: 10.0 / LOW_OHM, supply_v: 10.0 };
    let bridged = shared_sample(0.0, 0.150, 0.163, 1.0, 6.0);
    let cases: [(Sample, &[Health]); 8] = [
        (Sample { v1_v: 0.0, v2_v: 0.0, current_a: 0.0, supply_v: 0.0, ..good }, &[Health::OpenWire]),
        (Sample { v1_v: 0.0, v2_v: 0.0, current_a: 0.0, ..good }, &[Health::NoCurrent]),
        (bridged, &[Health::ShortedWire]),
        (shared_sample(0.0, 0.150, 0.163, 11.3, 4.5), &[Health::SupplyDip]),
        (Sample { v2_v: 1.5, ..good }, &[Health::ProbeLost]),
        (Sample { v2_v: 6.0, ..good }, &[Health::ProbeLost]),
        (full, &[Health::Saturated, Health::ShortedWire]),
        (Sample::NONE, &[Health::NoSample]),
    ];
    for (seed, (bad, expected)) in cases.into_iter().enumerate() {
        let (mut sensor, mut adc) = (shared(0.0, 0.150, Converter::default()), shared_adc(seed as u64));
        for _ in 0..500 {
            assert_eq!(sensor.read(&adc.measure(good)).health, Health::Ok);
            let reading = sensor.read(&adc.measure(bad));
            assert!(expected.contains(&reading.health), "{reading:?}, expected one of {expected:?}");
        }
    }
    let mut sensor = shared(0.0, 0.150, Converter::default());
    assert_eq!(sensor.read(&Sample { supply_v: f64::NAN, ..good }).health, Health::NotFinite);
    let refused = LengthSensor::new(config(0.0, 0.150).sharing(0.0, 0.0)).unwrap_err();
    assert!(refused.to_string().contains("switch and shunt"), "{refused}");
}

#[test]
fn length_and_resistivity_are_those_of_the_thesis() {
    // Table 7: taps at 91 mm and 146 mm of a wire of 160 mm.
    let mut sensor = LengthSensor::new(config(0.091, 0.055)).unwrap();
    let reading = sensor.read(&sample_of(0.091, 0.055, 0.1603, 11.3, 5.9));
    assert_eq!(reading.health, Health::Ok);
    assert!((reading.length_m - 0.1603).abs() < 1e-12);
    assert!((reading.resistance_ohm - 11.3).abs() < 1e-12);
    assert!((reading.resistivity_ohm_m - 11.3 * AREA / 0.1603).abs() < 1e-18);
    // Eq. 43: a first tap at the fixed end need not be sampled.
    let grounded = Sample { v1_v: f64::NAN, ..healthy() };
    assert!((super::tests::sensor().read(&grounded).length_m - 0.163).abs() < 1e-12);
}

#[test]
fn deviation_is_that_of_the_lengths() {
    for mut sensor in [sensor(), LengthSensor::new(config(0.091, 0.055)).unwrap(), resistance_sensor()] {
        let (l0, ls) = match sensor.config().method {
            Method::DualMeasurement { l0_m, ls_m } => (l0_m, ls_m),
            Method::Resistance { .. } => (0.0, 0.150),
        };
        let mut adc = Adc::new(1, Converter::default());
        let (mut sum, mut squares, n) = (0.0, 0.0, 200_000);
        let exact = sample_of(l0, ls, 0.163, 11.3, 5.9);
        let sigma = sensor.read(&exact).length_sigma_m;
        let expected = sensor.expected_sigma_m(0.163, 5.9, 5.9 / 11.3);
        assert!((sigma / expected - 1.0).abs() < 1e-9);
        for _ in 0..n {
            let length = sensor.read(&adc.measure(exact)).length().unwrap();
            sum += length - 0.163;
            squares += (length - 0.163).powi(2);
        }
        let mean: f64 = sum / f64::from(n);
        let seen = (squares / f64::from(n) - mean * mean).sqrt();
        assert!((seen / sigma - 1.0).abs() < 0.02, "{seen} seen, {sigma} told");
    }
}

#[test]
fn no_false_alarm_in_millions_of_samples() {
    for (seed, converter) in [
        (1, Converter::default()),
        // So coarse that codes repeat, and noise far below what was promised.
        (2, Converter { bits: 12, ..Converter::default() }),
        (3, Converter { bits: 24, ..Converter::default() }),
    ] {
        let mut dual = LengthSensor::new(LengthSensorConfig { converter, ..config(0.0, 0.150) }).unwrap();
        let mut thesis = LengthSensor::new(LengthSensorConfig { converter, ..config(0.091, 0.055) }).unwrap();
        let mut plain = LengthSensor::new(LengthSensorConfig { converter, ..*resistance_sensor().config() }).unwrap();
        let mut adc = Adc::new(seed, converter);
        for k in 0..1_000_000u32 {
            // Through the whole stroke and a sagging supply, and long rests at its ends.
            let at = (0.5 + 0.7 * (f64::from(k) * 1e-5).sin()).clamp(0.0, 1.0);
            let (length, resistance) = (
                HOT.length_m + at * (COLD.length_m - HOT.length_m),
                HOT.resistance_ohm + at * (COLD.resistance_ohm - HOT.resistance_ohm),
            );
            let supply = 5.5 + 0.5 * (f64::from(k) * 3e-6).cos();
            let v3 = supply * resistance / (resistance + 0.12);
            for (sensor, l0, ls) in [(&mut dual, 0.0, 0.150), (&mut thesis, 0.091, 0.055), (&mut plain, 0.0, 0.15)] {
                let sample = Sample { supply_v: supply, ..sample_of(l0, ls, length, resistance, v3) };
                let reading = sensor.read(&adc.measure(sample));
                assert_eq!(reading.health, Health::Ok, "sample {k}, converter {seed}: {reading:?}");
            }
        }
    }
}

#[test]
fn quieter_noise_than_promised_is_not_frozen() {
    let quiet = Converter { voltage_noise_v: 0.00075, current_noise_a: 0.0002, ..Converter::default() };
    let mut adc = Adc::new(9, quiet);
    let mut sensor = sensor();
    for k in 0..2_000_000u32 {
        assert_eq!(sensor.read(&adc.measure(healthy())).health, Health::Ok, "sample {k}");
    }
}

/// The verdicts on the first two samples of a fault, from a sensor that has run well, over many noises.
fn found(fault: impl Fn(&mut SmallRng, Sample) -> Sample, expected: &[Health]) {
    let mut rng = SmallRng::seed_from_u64(17);
    for seed in 0..500 {
        let (mut sensor, mut adc) = (sensor(), Adc::new(seed, Converter::default()));
        let at = rng.random_range(0.0..1.0);
        let (length, resistance) = (
            HOT.length_m + at * (COLD.length_m - HOT.length_m),
            HOT.resistance_ohm + at * (COLD.resistance_ohm - HOT.resistance_ohm),
        );
        let good = sample_of(0.0, 0.150, length, resistance, rng.random_range(4.9..5.9));
        for _ in 0..5 {
            assert_eq!(sensor.read(&adc.measure(good)).health, Health::Ok);
        }
        for _ in 0..2 {
            let reading = sensor.read(&adc.measure(fault(&mut rng, good)));
            assert!(expected.contains(&reading.health), "{reading:?}, expected one of {expected:?}");
            assert!(reading.length_m.is_nan() && reading.length().is_none());
            assert!(reading.length_sigma_m == f64::INFINITY);
        }
    }
}

#[test]
fn open_wires_are_found_at_once() {
    let open = [Health::OpenWire];
    // Between the taps, above them, below them, and a crimp that still leads a little.
    found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 0.0, v3_v: 6.0, ..s }, &open);
    found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 6.0, v3_v: 6.0, ..s }, &open);
    found(|_, s| Sample { current_a: 0.0, v1_v: 6.0, v2_v: 6.0, v3_v: 6.0, ..s }, &open);
    found(|_, s| Sample { current_a: s.current_a / 3.0, ..s }, &open);
    // Before the moving end no voltage is left to measure.
    found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 0.0, v3_v: 0.0, ..s }, &[Health::NoCurrent]);
}

#[test]
fn shorted_wires_are_found_at_once() {
    let short = [Health::ShortedWire];
    // The current runs out of range, or the supply gives way, or half the wire is bridged.
    found(|_, s| Sample { current_a: 50.0, v1_v: 0.0, v2_v: 0.2, v3_v: 0.25, ..s }, &short);
    let volts = |s: Sample, k: f64| Sample { v1_v: k * s.v1_v, v2_v: k * s.v2_v, v3_v: k * s.v3_v, ..s };
    found(|_, s| volts(s, 0.5), &short);
    found(|_, s| Sample { current_a: 2.0 * s.current_a, ..volts(s, 0.9) }, &short);
}

#[test]
fn lost_probes_are_found_at_once() {
    let lost = [Health::ProbeLost];
    found(|_, s| Sample { v2_v: 0.0, ..s }, &lost);
    found(|_, s| Sample { v2_v: s.v3_v, ..s }, &lost);
    found(|_, s| Sample { v2_v: s.v1_v, ..s }, &lost);
    found(|_, s| Sample { v2_v: 9.0, ..s }, &lost);
    found(|_, s| Sample { v2_v: -3.0, ..s }, &lost);
    // A weak contact shows once it takes more than the wire could have grown.
    let out = [Health::ProbeLost, Health::OutOfRange];
    found(|rng, s| Sample { v2_v: s.v2_v * rng.random_range(0.0..0.93), ..s }, &out);
    found(|_, s| Sample { v1_v: s.v2_v, ..s }, &lost);
    found(|_, s| Sample { v1_v: 0.2, ..s }, &lost);
}

#[test]
fn other_faults_are_found_at_once() {
    found(|_, s| Sample { supply_v: 4.5, ..s }, &[Health::SupplyDip]);
    found(|_, s| Sample { v3_v: 11.0, v2_v: 10.2, current_a: 0.95, ..s }, &[Health::Saturated]);
    found(|_, s| Sample { current_a: 1.2, v1_v: 0.0, v2_v: 8.6, v3_v: 9.3, ..s }, &[Health::Saturated]);
}

#[test]
fn missing_inputs_are_told_from_broken_ones() {
    let mut sensor = sensor();
    assert_eq!(sensor.read(&Sample::NONE).health, Health::NoSample);
    assert_eq!(sensor.read(&Sample { supply_v: 6.0, ..Sample::NONE }).health, Health::NoSample);
    let infinite = Sample { v3_v: f64::INFINITY, ..healthy() };
    for broken in [Sample { v2_v: f64::NAN, ..healthy() }, Sample { current_a: f64::NAN, ..healthy() }, infinite] {
        assert_eq!(sensor.read(&broken).health, Health::NotFinite);
    }
    assert_eq!(sensor.read(&Sample { supply_v: f64::NAN, ..healthy() }).health, Health::Ok);
    // Resistance alone needs no taps, and is not disturbed by lost ones.
    let mut plain = resistance_sensor();
    let untapped = Sample { v1_v: f64::NAN, v2_v: f64::NAN, ..healthy() };
    let reading = plain.read(&untapped);
    assert_eq!(reading.health, Health::Ok);
    assert!((reading.length_m - line().length_m(11.3)).abs() < 1e-12);
    assert_eq!(plain.read(&Sample::NONE).health, Health::NoSample);
}

#[test]
fn a_frozen_input_is_found() {
    type Freeze = fn(&Sample, &mut Sample);
    let freezes: [Freeze; 4] = [
        |held, s| *s = *held,
        |held, s| s.v2_v = held.v2_v,
        |held, s| s.v3_v = held.v3_v,
        |held, s| s.current_a = held.current_a,
    ];
    let limits = StuckAfter { all: Some(6), voltage: Some(19), current: Some(13) };
    assert_eq!(sensor().stuck_after(), limits);
    for (freeze, limit) in freezes.into_iter().zip([limits.all, limits.voltage, limits.voltage, limits.current]) {
        let (mut sensor, mut adc) = (sensor(), Adc::new(2, Converter::default()));
        let held = adc.measure(healthy());
        sensor.read(&held);
        let after = (1..100u32).find(|_| {
            let mut sample = adc.measure(healthy());
            freeze(&held, &mut sample);
            sensor.read(&sample).health == Health::Stuck
        });
        // A little sooner where noise happens to repeat another input's code as well.
        assert!(after.is_some_and(|n| n <= limit.unwrap() && n + 2 >= limit.unwrap()), "{after:?} of {limit:?}");
        // And it is well again with the first fresh code.
        assert_eq!(sensor.read(&adc.measure(healthy())).health, Health::Ok);
    }
}

#[test]
fn without_noise_nothing_is_frozen() {
    let silent = Converter { voltage_noise_v: 0.0, current_noise_a: 0.0, ..Converter::default() };
    let mut sensor = LengthSensor::new(LengthSensorConfig { converter: silent, ..config(0.0, 0.150) }).unwrap();
    assert_eq!(sensor.stuck_after(), StuckAfter { all: None, voltage: None, current: None });
    for _ in 0..10_000 {
        assert_eq!(sensor.read(&healthy()).health, Health::Ok);
    }
}

#[test]
fn a_second_tap_close_to_the_moving_end_still_tells_a_lost_probe() {
    let config = config(0.0, 0.158);
    let mut sensor = LengthSensor::new(config).unwrap();
    assert_eq!(sensor.read(&sample_of(0.0, 0.158, 0.1603, 11.9, 5.9)).health, Health::Ok);
    assert_eq!(sensor.read(&Sample { v2_v: 5.9, ..healthy() }).health, Health::ProbeLost);
}

#[test]
fn configurations_that_cannot_work_are_refused_by_name() {
    let bad = |change: fn(&mut LengthSensorConfig)| {
        let mut config = config(0.0, 0.150);
        change(&mut config);
        LengthSensor::new(config).unwrap_err().to_string()
    };
    assert!(bad(|c| c.area_m2 = f64::NAN).contains("cross-section"));
    assert!(bad(|c| c.min_length_m = 0.2).contains("length range"));
    assert!(bad(|c| c.max_resistance_ohm = f64::INFINITY).contains("resistance range"));
    assert!(bad(|c| c.min_current_a = 0.001).contains("smallest current"));
    assert!(bad(|c| c.converter.bits = 0).contains("bits"));
    assert!(bad(|c| c.method = Method::DualMeasurement { l0_m: -0.1, ls_m: 0.1 }).contains("l0"));
}

fn any_input() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -12.0f64..12.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 10.0, 5e-324]),
    ]
}

proptest! {
    #[test]
    fn nothing_but_a_plausible_length_is_ok(
        inputs in prop::collection::vec((any_input(), any_input(), any_input(), any_input(), any_input()), 1..20),
        plain: bool,
    ) {
        let mut sensor = if plain { resistance_sensor() } else { sensor() };
        let (min, max) = (sensor.config().min_length_m, sensor.config().max_length_m);
        for (v1_v, v2_v, v3_v, current_a, supply_v) in inputs {
            let r = sensor.read(&Sample { v1_v, v2_v, v3_v, current_a, supply_v });
            if r.health.is_ok() {
                prop_assert!(r.length_m > 0.9 * min && r.length_m < 1.1 * max, "{r:?}");
                prop_assert!(r.resistance_ohm > 0.0 && r.resistivity_ohm_m > 0.0, "{r:?}");
                prop_assert!(r.length_sigma_m > 0.0 && r.length_sigma_m < 0.01, "{r:?}");
            } else {
                prop_assert!(r.length_m.is_nan() && r.resistivity_ohm_m.is_nan(), "{r:?}");
            }
        }
    }

    #[test]
    fn the_dual_measurement_needs_neither_scale_nor_zero_of_the_voltages(
        l0 in 0.0f64..0.09, length in 0.1603f64..0.1667, resistance in 10.4f64..11.9, v3 in 3.5f64..6.0,
        scale in 0.9f64..1.5, shift in -0.02f64..0.02,
    ) {
        let ls = 0.150 - l0;
        let mut sensor = LengthSensor::new(config(l0, ls)).unwrap();
        let s = sample_of(l0, ls, length, resistance, v3);
        let plain = sensor.read(&s);
        prop_assert_eq!(plain.health, Health::Ok);
        prop_assert!((plain.length_m - length).abs() < 1e-12);
        // More current through the same wire; the same wire on a converter with an offset.
        let scaled = Sample {
            v1_v: scale * s.v1_v, v2_v: scale * s.v2_v, v3_v: scale * s.v3_v, current_a: scale * s.current_a, ..s
        };
        let scaled = sensor.read(&scaled);
        prop_assert!((scaled.length_m - length).abs() < 1e-12);
        prop_assert!((scaled.resistance_ohm - resistance).abs() < 1e-9);
        prop_assert!((scaled.length_sigma_m * scale / plain.length_sigma_m - 1.0).abs() < 1e-9);
        let shifted = Sample { v1_v: s.v1_v + shift, v2_v: s.v2_v + shift, v3_v: s.v3_v + shift, ..s };
        prop_assert!((sensor.read(&shifted).length_m - length).abs() < 1e-12);
    }
}
