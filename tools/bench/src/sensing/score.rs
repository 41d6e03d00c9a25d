//! Estimators over the samples of a sweep: the converter, and each estimator's error of the length.

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use sinew_control::{EstimatorKind, Observation, StateEstimator};
use sinew_physics::formulas::resistance_ohm;
use sinew_physics::{WireModel, cold_length_m, hot_length_m};
use sinew_sensing::{
    Converter, LengthSensor, LengthSensorConfig, LineFit, Method, MotionObserver, ObserverConfig, Reading,
    ResistanceLine, Sample, WireEnd,
};

use super::report::{Noise, Row};
use super::sweep::{Condition, Heating, LEAST_A, PERIOD_S, Place, Point, SUPPLY_V, Sweep};

/// Steps and ranges of the converter: table 9's ranges in 16 bits.
const BITS: u32 = 16;

const VOLTAGE_RANGE_V: f64 = 16.0;

const CURRENT_RANGE_A: f64 = 3.2;

/// The converter: noise, then steps, then the ends of its range.
struct Adc {
    noise: Noise,
    random: Xoshiro256PlusPlus,
}

impl Adc {
    fn new(noise: Noise, seed: u64) -> Adc {
        Adc { noise, random: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    fn read(&mut self, value: f64, noise: f64, range: f64) -> f64 {
        let step = range / 2f64.powi(BITS as i32);
        let draw: f64 = StandardNormal.sample(&mut self.random);
        // A pedestal below zero, as the simulated rig's amplifiers have, so that noise about zero is not cut off.
        (((value + noise * draw) / step).round() * step).clamp(-range / 16.0, range - step)
    }

    fn sample(&mut self, point: &Point) -> Sample {
        let o = &point.outputs;
        let Noise { voltage_v, current_a, .. } = self.noise;
        // A tap that touches nothing is drawn to ground by the input.
        let v2 = if point.lost { 0.0 } else { o.v2_v };
        let mut volts = |value| self.read(value, voltage_v, VOLTAGE_RANGE_V);
        let (v1_v, v2_v, v3_v) = (volts(o.v1_v), volts(v2), volts(o.v3_v));
        let current_a = self.read(o.current_a, current_a, CURRENT_RANGE_A);
        Sample { v1_v, v2_v, v3_v, current_a, supply_v: f64::NAN }
    }
}

/// A sensor for the wire, with limits that leave the thesis' smallest current in.
fn sensor(model: &WireModel, method: Method, noise: Noise) -> LengthSensor {
    let end = |length: Result<f64, sinew_physics::Error>| length.unwrap_or(model.geometry.length_m);
    let (hot_m, cold_m) = (end(hot_length_m(model)), end(cold_length_m(model)));
    let (m, area_m2) = (&model.material, model.geometry.area_m2());
    let end = |resistivity: f64, length_m: f64| WireEnd {
        resistance_ohm: resistance_ohm(resistivity, length_m, area_m2),
        length_m,
    };
    let (hot, cold) = (end(m.austenite_resistivity(150.0), hot_m), end(m.martensite_resistivity_ohm_m, cold_m));
    let converter = Converter {
        // bits over 0 to the range there, over both signs here
        bits: BITS + 1,
        voltage_range_v: VOLTAGE_RANGE_V,
        current_range_a: CURRENT_RANGE_A,
        voltage_noise_v: noise.voltage_v,
        current_noise_a: noise.current_a,
    };
    let config = LengthSensorConfig::for_wire(method, area_m2, SUPPLY_V, hot, cold, converter);
    let config = LengthSensorConfig { min_current_a: 0.5 * LEAST_A, ..config };
    LengthSensor::new(config).unwrap_or_else(|error| panic!("the bench's own sensor: {error}"))
}

/// Running error of one estimator.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    count: u64,
    samples: u64,
    sum: f64,
    squares: f64,
    largest: f64,
    /// While the probe was off: how many had a length, and Σ of their squares, m².
    lost_count: u64,
    lost_squares: f64,
}

impl Errors {
    fn push(&mut self, estimate_m: f64, point: &Point) {
        self.samples += 1;
        let error = estimate_m - point.length_m;
        if !error.is_finite() {
            return;
        }
        self.count += 1;
        self.sum += error;
        self.squares += error * error;
        self.largest = self.largest.max(error.abs());
        if point.lost {
            self.lost_count += 1;
            self.lost_squares += error * error;
        }
    }

    fn rms_m(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

/// A sweep, and everything that stays the same over it.
#[derive(Clone, Copy)]
pub(super) struct Setup {
    pub(super) taps: Place,
    pub(super) heating: Heating,
    pub(super) condition: Condition,
    pub(super) load_gf: f64,
    pub(super) noise: Noise,
}

/// Runs every estimator over one sweep's samples.
pub(super) fn score(
    setup: &Setup,
    sweep: &Sweep,
    line: ResistanceLine,
    seed: u64,
    kinds: &[(String, EstimatorKind)],
) -> Vec<Row> {
    let taps = setup.taps.taps();
    let model = &sweep.model;
    let mut dual = sensor(model, Method::DualMeasurement { l0_m: taps.l0_m, ls_m: taps.ls_m }, setup.noise);
    let mut filter = {
        let mean = sweep.points.iter().map(|p| p.outputs.v3_v).sum::<f64>() / sweep.points.len() as f64;
        let sigma = dual.expected_sigma_m(model.geometry.length_m, mean, mean / sweep.points[0].outputs.resistance_ohm);
        let config = ObserverConfig { length_sigma_m: sigma, ..ObserverConfig::default() };
        MotionObserver::new(1.0 / PERIOD_S, config).unwrap_or_else(|error| panic!("the bench's own filter: {error}"))
    };
    let mut estimators: Vec<(StateEstimator, Errors)> =
        kinds.iter().map(|(_, kind)| (StateEstimator::new(model, *kind), Errors::default())).collect();
    let [mut by_dual, mut by_resistance, mut filtered] = [Errors::default(); 3];
    let mut adc = Adc::new(setup.noise, seed_of(seed, setup));
    for point in &sweep.points {
        let sample = adc.sample(point);
        let Reading { length_m, resistance_ohm, length_sigma_m, resistance_sigma_ohm, .. } = dual.read(&sample);
        let measured = length_m.is_finite();
        by_dual.push(length_m, point);
        // Resistance needs no taps: also where the dual measurement has no length.
        let resistance = if resistance_ohm.is_finite() { resistance_ohm } else { sample.v3_v / sample.current_a };
        by_resistance.push(line.length_m(resistance), point);
        let motion = filter.update_weighted(measured.then_some(length_m), length_sigma_m, PERIOD_S);
        filtered.push(motion.length_m, point);
        let on_power_w = sample.current_a * sample.v3_v;
        let seen = Observation {
            power_w: point.duty * on_power_w,
            duty: match setup.heating {
                Heating::Pulses => point.duty,
                Heating::Current => f64::NAN,
            },
            length_m,
            length_sigma_m,
            resistance_ohm: resistance,
            resistance_sigma_ohm,
            tension_n: f64::NAN,
            dt_s: PERIOD_S,
        };
        for (estimator, errors) in &mut estimators {
            errors.push(estimator.update(&seen).length_m, point);
        }
    }
    let stroke_m = sweep.stroke_m();
    let names = ["dual", "resistance", "dual_filtered"].map(String::from).into_iter();
    let names = names.chain(kinds.iter().map(|(name, _)| name.clone()));
    let errors = [by_dual, by_resistance, filtered].into_iter().chain(estimators.into_iter().map(|(_, errors)| errors));
    names
        .zip(errors)
        .map(|(estimator, e)| Row {
            estimator,
            condition: setup.condition,
            taps: setup.taps,
            heating: setup.heating,
            noise: setup.noise.name,
            load_gf: setup.load_gf,
            stroke_mm: 1e3 * stroke_m,
            rms_mm: 1e3 * e.rms_m(),
            max_mm: 1e3 * e.largest,
            bias_mm: 1e3 * e.sum / e.count as f64,
            rms_percent: 100.0 * e.rms_m() / stroke_m,
            max_percent: 100.0 * e.largest / stroke_m,
            lost_percent: 100.0 * (e.samples - e.count) as f64 / e.samples as f64,
            rms_while_lost_mm: (e.lost_count > 0).then(|| 1e3 * (e.lost_squares / e.lost_count as f64).sqrt()),
        })
        .collect()
}

/// Noise of its own for every sweep.
fn seed_of(seed: u64, setup: &Setup) -> u64 {
    let words = [
        setup.taps as u64,
        setup.heating as u64,
        setup.condition as u64,
        setup.load_gf.to_bits(),
        setup.noise.voltage_v.to_bits(),
    ];
    words
        .into_iter()
        .fold(seed ^ 0x5eed_0007, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23))
}

/// One straight line through the samples of all loads, as fig. 76 draws it, for each noise and way of heating, on noise of its
/// own. The taps do not matter to it.
pub(super) struct Lines(Vec<(Heating, Noise, ResistanceLine)>);

impl Lines {
    pub(super) fn calibrate(sweeps: &[(Setup, Sweep)], noises: &[Noise], seed: u64) -> Lines {
        let wanted: Vec<(Heating, Noise)> =
            Heating::ALL.into_iter().flat_map(|heating| noises.iter().map(move |noise| (heating, *noise))).collect();
        let line = |(heating, noise): (Heating, Noise)| {
            let mut fit = LineFit::new();
            let with = |s: &Setup| {
                (s.condition, s.taps, s.heating) == (Condition::Clean, Place::Long, heating) && s.noise == noise
            };
            for (setup, sweep) in sweeps.iter().filter(|(setup, _)| with(setup)) {
                let mut adc = Adc::new(noise, seed_of(!seed, setup));
                for point in &sweep.points {
                    let sample = adc.sample(point);
                    fit.push(sample.v3_v / sample.current_a, point.length_m);
                }
            }
            let line = fit.line().unwrap_or_else(|error| panic!("a wire that moves has a line: {error}"));
            (heating, noise, line)
        };
        Lines(wanted.into_par_iter().map(line).collect())
    }

    pub(super) fn of(&self, setup: &Setup) -> ResistanceLine {
        let found = self.0.iter().find(|(heating, noise, _)| (*heating, *noise) == (setup.heating, setup.noise));
        found.map(|(_, _, line)| *line).unwrap_or_else(|| panic!("every setup has a line"))
    }
}
