//! The estimates for a wire that a PI controller moves, compared with the truth: chapter 9's comparison.
#![allow(dead_code)]

use crate::rig::{Bench, Noise, figure_wire};
use sinew_control::{AlgorithmKind, Estimate, EstimatorKind, Settings, StateEstimator};
use sinew_physics::{Geometry, Load, Taps, WireModel};

/// The estimators compared, by the rig file's word.
pub const ESTIMATORS: [(&str, EstimatorKind); 4] = [
    ("luenberger", EstimatorKind::Luenberger),
    ("luenberger_scheduled", EstimatorKind::LuenbergerScheduled),
    ("enthalpy", EstimatorKind::Enthalpy),
    ("fused", EstimatorKind::Fused),
];

/// The thesis' rig of table 10, preloaded to 150 MPa, on 9 V.
pub fn table_10() -> WireModel {
    let mut model = figure_wire();
    model.geometry = Geometry { diameter_m: 0.1e-3, length_m: 0.233 };
    model.taps = Some(Taps { l0_m: 0.0, ls_m: 0.22 });
    model.drive.supply_v = 9.0;
    model.load =
        Load::SpringMassDamper { mass_kg: 0.13, damping_n_s_per_m: 0.915, spring_n_per_m: 18.0, preload_n: 1.2 };
    model
}

/// How far estimates are off, rms.
#[derive(Debug, Clone, Copy, Default)]
pub struct Off {
    /// Of the martensite fraction.
    pub martensite: f64,
    /// Of the temperature, K.
    pub temperature_k: f64,
    samples: f64,
}

impl Off {
    fn add(&mut self, estimate: &Estimate, bench: &Bench) {
        self.martensite += (estimate.martensite - bench.wire.martensite()).powi(2);
        self.temperature_k += (estimate.temperature_c - bench.wire.temperature_c()).powi(2);
        self.samples += 1.0;
    }

    fn rms(self) -> Off {
        Off {
            martensite: (self.martensite / self.samples).sqrt(),
            temperature_k: (self.temperature_k / self.samples).sqrt(),
            samples: self.samples,
        }
    }
}

/// A wire under PI, and the estimators that watch.
pub struct Watch {
    pub bench: Bench,
    pub estimators: Vec<StateEstimator>,
    pub estimates: Vec<Estimate>,
}

impl Watch {
    pub fn new(plant: &WireModel, believed: &WireModel, rate_hz: f64, noise: Noise, seed: u64) -> Watch {
        let settings = Settings { kind: AlgorithmKind::Pi, ..Settings::default() };
        let estimators: Vec<_> = ESTIMATORS.iter().map(|(_, kind)| StateEstimator::new(believed, *kind)).collect();
        let estimates = vec![Estimate::UNKNOWN; estimators.len()];
        Watch { bench: Bench::new(plant, believed, &settings, rate_hz, noise, seed), estimators, estimates }
    }

    pub fn cycle(&mut self, reference_m: f64) {
        self.bench.cycle(reference_m);
        let seen = self.bench.observation;
        for (estimate, estimator) in self.estimates.iter_mut().zip(&mut self.estimators) {
            *estimate = estimator.update(&seen);
        }
    }

    /// A reference over time in strokes, 0..1; errors while `counts` says so.
    pub fn follow(
        &mut self,
        seconds: f64,
        reference: impl Fn(f64) -> f64,
        counts: impl Fn(f64, &Bench) -> bool,
    ) -> Vec<Off> {
        let mut off = vec![Off::default(); self.estimators.len()];
        for k in 0..(seconds * self.bench.rate_hz) as usize {
            let t = k as f64 / self.bench.rate_hz;
            self.cycle(self.bench.range.length_m(reference(t)));
            if counts(t, &self.bench) {
                for (off, estimate) in off.iter_mut().zip(&self.estimates) {
                    off.add(estimate, &self.bench);
                }
            }
        }
        off.into_iter().map(Off::rms).collect()
    }
}

/// Steps between 30 % and 70 % of the stroke, every 2 s for 24 s; the first 4 s are for initial errors to go.
pub fn transients(watch: &mut Watch) -> Vec<Off> {
    watch.follow(24.0, |t| if t % 4.0 < 2.0 { 0.3 } else { 0.7 }, |t, _| t >= 4.0)
}

/// What a draught (h up by half) did to a wire, and to what is believed of it.
pub struct Blown {
    /// Change of the wire's temperature, mean over 2.0 to 2.5 s after the onset, K: the controller heats it back.
    pub truth_k: f64,
    /// The same as the estimators believe it.
    pub changes_k: Vec<f64>,
    /// Believed less true temperature 3 s after the onset, the wire back at its length, K.
    pub errors_k: Vec<f64>,
    /// Believed less true martensite fraction, then.
    pub martensite_errors: Vec<f64>,
}

/// Means over the next seconds: of the wire's temperature and phase, and of the estimates'.
fn means(watch: &mut Watch, seconds: f64) -> ((f64, f64), Vec<(f64, f64)>) {
    let cycles = (seconds * watch.bench.rate_hz) as usize;
    let share = 1.0 / cycles as f64;
    let (mut truth, mut believed) = ((0.0, 0.0), vec![(0.0, 0.0); watch.estimates.len()]);
    for _ in 0..cycles {
        watch.cycle(watch.bench.range.length_m(0.5));
        truth.0 += watch.bench.wire.temperature_c() * share;
        truth.1 += watch.bench.wire.martensite() * share;
        for (sum, estimate) in believed.iter_mut().zip(&watch.estimates) {
            sum.0 += estimate.temperature_c * share;
            sum.1 += estimate.martensite * share;
        }
    }
    (truth, believed)
}

/// A draught on a wire that has just been brought to half its stroke by heating, so that it has the loop to cool through.
pub fn draught(watch: &mut Watch) -> Blown {
    watch.follow(6.0, |t| 0.2 + 0.3 * (t / 5.8).min(1.0), |_, _| false);
    let (truth_before, before) = means(watch, 0.1);
    watch.bench.wire.set_draught(0.5);
    watch.follow(2.0, |_| 0.5, |_, _| false);
    let (truth, during) = means(watch, 0.5);
    watch.follow(0.3, |_| 0.5, |_, _| false);
    let (truth_late, late) = means(watch, 0.4);
    watch.bench.wire.set_draught(0.0);
    Blown {
        truth_k: truth.0 - truth_before.0,
        changes_k: during.iter().zip(&before).map(|(now, then)| now.0 - then.0).collect(),
        errors_k: late.iter().map(|now| now.0 - truth_late.0).collect(),
        martensite_errors: late.iter().map(|now| now.1 - truth_late.1).collect(),
    }
}
