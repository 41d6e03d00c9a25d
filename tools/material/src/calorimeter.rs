//! A calorimeter's curve fitted by the wire's own model: heat flows as the phase changes, over a base line, seen through the
//! calorimeter's lag.
//!
//! Each direction has a base line of its own (offset and slope, which take the sample's heat capacity with them) and a heat of its own;
//! the lag is the calorimeter's and the same for both. Centres and steepnesses are the model's, through whatever kinetics it has.

use nalgebra::{DMatrix, DVector};
use sinew_physics::Kinetics;
use sinew_rig::Rig;
use sinew_standards::{Calorimetry, Peak};

use crate::error::Error;
use crate::furnace::{USUAL_RATE_K_PER_S, sweep};
use crate::least_squares::{Least, Unknown, least};

/// A calorimeter's curve, in the order it was measured in.
#[derive(Debug, Clone, Copy)]
pub struct HeatFlow<'a> {
    /// The sample's temperature, °C.
    pub temperature_c: &'a [f64],
    /// Of any unit and sign.
    pub heat_flow: &'a [f64],
    /// How fast it was heated and cooled, K/s, where that is known.
    pub rates_k_per_s: Option<[f64; 2]>,
    /// What the heat flow is to be multiplied by for W/kg, where that is known.
    pub to_w_per_kg: Option<f64>,
}

/// What a curve says of the model.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Its figures by ASTM F2004, read off the curve itself.
    pub reading: Calorimetry,
    /// Keys of `[channel.material]`, …
    pub keys: Vec<&'static str>,
    /// … their values in the keys' units, …
    pub values: Vec<f64>,
    /// … and how far noise and what the model does not follow let them wander together. The errors of thermometer and of heat are not in it.
    pub covariance: DMatrix<f64>,
    /// Heats on heating and on cooling, J/kg, where mass and rate are known.
    pub heats_j_per_kg: Option<[f64; 2]>,
    /// How far the calorimeter lags behind, and 1 σ of that, K.
    pub lag_k: [f64; 2],
    /// What is left of the curve on heating and on cooling, RMS over the height of the peak.
    pub misfit: [f64; 2],
}

/// How far a calorimeter lags behind, 1 σ, K: some seconds at 10 K/min.
const LAG_K: f64 = 2.0;
const MOST_LAG_K: f64 = 20.0;
/// Base lines reach so far beyond the tangents' start and finish, in spans between these.
const BESIDE: f64 = 1.0;
/// Steps of the simulated sweep in a span, and how many there are at most.
const FINE: f64 = 120.0;
const MOST_STEPS: usize = 4000;
/// More points than this are averaged to so many: noise is as well known from them.
const MOST_POINTS: usize = 2000;
/// The model moves if at least so much of the phase changes on a sweep.
const MOVES: f64 = 0.5;

const HEATING: [&str; 3] = ["austenite_temperature_c", "heating_steepness_per_k", "heating_skew"];
const COOLING: [&str; 3] = ["martensite_temperature_c", "cooling_steepness_per_k", "cooling_skew"];
const LATENT_HEAT: &str = "latent_heat_j_per_kg";

/// Fits the model of one channel to a curve.
///
/// # Errors
/// What the curve lacks, and where it would have to be measured; a model that no calorimeter's curve can tell of.
pub fn calorimeter(rig: &Rig, channel: usize, curve: &HeatFlow<'_>) -> Result<Fitted, Error> {
    let reading = sinew_standards::calorimetry(curve.temperature_c, curve.heat_flow)?;
    let [up, down] = sinew_standards::stretches(curve.temperature_c, curve.heat_flow)?;
    let rates = curve.rates_k_per_s.unwrap_or([USUAL_RATE_K_PER_S; 2]);
    let branches = [Branch::new(&up, &reading.heating, rates[0]), Branch::new(&down, &reading.cooling, rates[1])];
    let shapes = 2 + usize::from(matches!(rig.channels[channel].model.material.kinetics, Kinetics::Richards { .. }));
    let keys: Vec<&'static str> = HEATING[..shapes].iter().chain(&COOLING[..shapes]).copied().collect();
    let seen = Seen { rig, channel, keys: &keys, branches: &branches };

    let mut unknowns: Vec<Unknown> = [&reading.heating, &reading.cooling]
        .into_iter()
        .flat_map(|peak| {
            let (span_k, steepness) = (peak.span_k(), peak.steepness_per_k());
            let centre = Unknown { start: peak.middle_c(), step: 2e-3 * span_k, low: -200.0, high: 800.0 };
            let of_shape = |start: f64, low, high| Unknown { start, step: 2e-3 * start, low, high };
            [centre, of_shape(steepness, 0.005, 20.0), of_shape(1.0, 0.05, 20.0)].into_iter().take(shapes)
        })
        .collect();
    let span_k = reading.heating.span_k().min(reading.cooling.span_k());
    unknowns.push(Unknown { start: 0.02 * span_k, step: 2e-3 * span_k, low: 0.0, high: MOST_LAG_K });

    // by the height of the peaks first, then by what is left of each and how far that hangs together
    let heights = branches.each_ref().map(|branch| 1e2 / branch.height);
    let rough = seen.fit(&unknowns, heights)?;
    let mut from = unknowns.clone();
    from.iter_mut().zip(&rough.at).for_each(|(unknown, at)| unknown.start = *at);
    let weights = seen.weights(&rough, heights);
    let found = seen.fit(&from, weights)?;
    seen.describe(reading, &from, &found, weights, curve)
}

/// One direction: what is fitted of it.
struct Branch {
    /// From where to where it is simulated, in the order of the sweep, °C.
    way: [f64; 2],
    steps: usize,
    rate_k_per_s: f64,
    height: f64,
    /// In ascending order of temperature: temperatures, °C, and heat flow.
    at_c: Vec<f64>,
    flow: DVector<f64>,
}

impl Branch {
    fn new(points: &[(f64, f64)], peak: &Peak, rate_k_per_s: f64) -> Branch {
        let (start, finish, span) = (peak.start_c.value, peak.finish_c.value, peak.span_k());
        let [cold, hot] = [start.min(finish) - BESIDE * span, start.max(finish) + BESIDE * span];
        // a second peak is another transformation's: what is nearer to it than to this one is left out
        let is_other = |t: f64| peak.second_c.is_some_and(|c| (t - c).abs() < 0.5 * (c - peak.peak_c).abs());
        let inside: Vec<(f64, f64)> =
            points.iter().copied().filter(|(t, _)| (cold..=hot).contains(t) && !is_other(*t)).collect();
        let each = inside.len().div_ceil(MOST_POINTS).max(1);
        let mean =
            |chunk: &[(f64, f64)], of: fn(&(f64, f64)) -> f64| chunk.iter().map(of).sum::<f64>() / chunk.len() as f64;
        let thinned: Vec<(f64, f64)> =
            inside.chunks(each).map(|chunk| (mean(chunk, |p| p.0), mean(chunk, |p| p.1))).collect();
        let steps = ((3.0 + 2.0 * BESIDE) * FINE).min(MOST_STEPS as f64) as usize;
        let way = if start < finish { [cold - span, hot + span] } else { [hot + span, cold - span] };
        let (low, high) = thinned.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
        Branch {
            way,
            steps,
            rate_k_per_s,
            height: (high - low).max(f64::MIN_POSITIVE),
            at_c: thinned.iter().map(|p| p.0).collect(),
            flow: DVector::from_iterator(thinned.len(), thinned.iter().map(|p| p.1)),
        }
    }

    /// −dξ/dT along the sweep as a calorimeter shows it that lags so many kelvins behind, at the points: an area of 1.
    fn seen(&self, model: &sinew_physics::WireModel, lag_k: f64) -> Result<DVector<f64>, Error> {
        let swept = sweep(model, self.way, self.steps, 0.0, self.rate_k_per_s)?;
        let ends = [swept.martensite[0], swept.martensite[self.steps]];
        if (ends[1] - ends[0]).abs() < MOVES {
            return Err(Error::NothingMoves);
        }
        let step_k = (self.way[1] - self.way[0]) / self.steps as f64;
        let left = if lag_k > 0.0 { (-step_k.abs() / lag_k).exp() } else { 0.0 };
        let (mut shown, mut before) = (Vec::with_capacity(self.steps), 0.0);
        for pair in swept.martensite.windows(2) {
            let now = (pair[1] - pair[0]).abs() / step_k.abs();
            // a first-order lag behind what goes straight from one middle of a step to the next
            let slope = (now - before) / step_k.abs();
            let last = shown.last().copied().unwrap_or(0.0);
            shown.push(now - slope * lag_k + (last - before + slope * lag_k) * left);
            before = now;
        }
        let at = |t: f64| {
            let place = (t - self.way[0]) / step_k - 0.5;
            let i = (place.max(0.0) as usize).min(self.steps - 2);
            shown[i] + (shown[i + 1] - shown[i]) * (place - i as f64)
        };
        Ok(DVector::from_iterator(self.at_c.len(), self.at_c.iter().map(|t| at(*t))))
    }

    /// Offset, slope and area: what belongs to each.
    fn design(&self, seen: &DVector<f64>) -> DMatrix<f64> {
        let (middle, half) = (0.5 * (self.way[0] + self.way[1]), 0.5 * (self.way[1] - self.way[0]).abs());
        DMatrix::from_fn(self.at_c.len(), 3, |row, column| match column {
            0 => 1.0,
            1 => (self.at_c[row] - middle) / half,
            _ => seen[row],
        })
    }

    /// Offset, slope and area that leave least.
    fn linear(&self, design: &DMatrix<f64>) -> Result<DVector<f64>, Error> {
        let square = design.tr_mul(design);
        square.cholesky().map(|factor| factor.solve(&design.tr_mul(&self.flow))).ok_or(Error::NoFit)
    }
}

/// Both directions as the model of a rig file shows them.
struct Seen<'a> {
    rig: &'a Rig,
    channel: usize,
    keys: &'a [&'static str],
    branches: &'a [Branch; 2],
}

impl Seen<'_> {
    /// What each direction shows at the unknowns: the keys, and the lag.
    fn at(&self, unknowns: &[f64]) -> Result<[DVector<f64>; 2], Error> {
        let mut rig = self.rig.clone();
        for (key, value) in self.keys.iter().zip(unknowns) {
            rig.set_parameter(self.channel, key, *value).map_err(|_| Error::NoFit)?;
        }
        let model = &rig.channels[self.channel].model;
        let lag_k = unknowns[self.keys.len()];
        Ok([self.branches[0].seen(model, lag_k)?, self.branches[1].seen(model, lag_k)?])
    }

    /// The unknowns that leave least where offsets, slopes and areas are the best for them; what each direction leaves counts by its weight.
    fn fit(&self, unknowns: &[Unknown], weights: [f64; 2]) -> Result<Least, Error> {
        least(unknowns, |at| {
            let seen = self.at(at)?;
            let mut all = Vec::new();
            for ((branch, seen), weight) in self.branches.iter().zip(&seen).zip(weights) {
                let design = branch.design(seen);
                let left = &design * branch.linear(&design)? - &branch.flow;
                all.extend(left.iter().map(|left| weight * left));
            }
            all.push(at[self.keys.len()] / LAG_K);
            Ok(DVector::from_vec(all))
        })
    }

    /// What is left of each direction, not weighted.
    fn left(&self, found: &Least, weights: [f64; 2]) -> [DVector<f64>; 2] {
        let first = self.branches[0].at_c.len();
        let of = |from: usize, count: usize, weight: f64| found.left.rows(from, count) / weight;
        [of(0, first, weights[0]), of(first, self.branches[1].at_c.len(), weights[1])]
    }

    /// How much a point of each direction counts: by what is left, and by how many points hang together.
    fn weights(&self, found: &Least, weights: [f64; 2]) -> [f64; 2] {
        let left = self.left(found, weights);
        std::array::from_fn(|i| {
            let free = left[i].len().saturating_sub(3 + self.keys.len() / 2).max(1) as f64;
            let sigma = (left[i].norm_squared() / free).sqrt().max(1e-9 * self.branches[i].height);
            1.0 / (sigma * hanging_together(&left[i]).sqrt())
        })
    }

    fn describe(
        &self,
        reading: Calorimetry,
        unknowns: &[Unknown],
        found: &Least,
        weights: [f64; 2],
        curve: &HeatFlow<'_>,
    ) -> Result<Fitted, Error> {
        let here = self.at(&found.at)?;
        let designs: [DMatrix<f64>; 2] = std::array::from_fn(|i| self.branches[i].design(&here[i]));
        let linear = [self.branches[0].linear(&designs[0])?, self.branches[1].linear(&designs[1])?];
        let (n, first) = (found.at.len(), self.branches[0].at_c.len());
        // derivatives by all that is free: what was searched, and offset, slope and area of either direction
        let starts = [0, first];
        let mut slopes = DMatrix::zeros(found.left.len(), n + 6);
        for (k, unknown) in unknowns.iter().enumerate() {
            let mut moved = found.at.clone();
            let step = if moved[k] + unknown.step <= unknown.high { unknown.step } else { -unknown.step };
            moved[k] += step;
            let there = self.at(&moved)?;
            for i in 0..2 {
                let slope = (&there[i] - &here[i]) * (weights[i] * linear[i][2] / step);
                slopes.view_mut((starts[i], k), slope.shape()).copy_from(&slope);
            }
        }
        slopes[(found.left.len() - 1, n - 1)] = 1.0 / LAG_K;
        for i in 0..2 {
            slopes.view_mut((starts[i], n + 3 * i), designs[i].shape()).copy_from(&(&designs[i] * weights[i]));
        }
        let covariance = slopes.tr_mul(&slopes).cholesky().ok_or(Error::NoFit)?.inverse();

        let mut keys = self.keys.to_vec();
        let mut values = found.at[..keys.len()].to_vec();
        let rates = curve.rates_k_per_s;
        let heats = rates.zip(curve.to_w_per_kg).map(|(rates, to_w_per_kg)| {
            let per_area: [f64; 2] = std::array::from_fn(|i| linear[i][2].signum() * to_w_per_kg / rates[i]);
            (per_area, std::array::from_fn::<f64, 2, _>(|i| linear[i][2] * per_area[i]))
        });
        let mut of = DMatrix::identity(keys.len(), n + 6);
        if let Some((per_area, heats)) = heats {
            keys.push(LATENT_HEAT);
            values.push(0.5 * (heats[0] + heats[1]));
            of = of.insert_row(keys.len() - 1, 0.0);
            of[(keys.len() - 1, n + 2)] = 0.5 * per_area[0];
            of[(keys.len() - 1, n + 5)] = 0.5 * per_area[1];
        }
        let mut of_keys = &of * &covariance * of.transpose();
        if let Some((_, heats)) = heats {
            // the model has one heat for both
            let last = keys.len() - 1;
            of_keys[(last, last)] += (0.5 * (heats[0] - heats[1])).powi(2);
        }
        let lag = n - 1;
        let left = self.left(found, weights);
        let misfit = std::array::from_fn(|i| {
            let rms = (left[i].norm_squared() / left[i].len() as f64).sqrt();
            rms / (linear[i][2] * here[i].max()).abs()
        });
        Ok(Fitted {
            reading,
            keys,
            values,
            covariance: of_keys,
            heats_j_per_kg: heats.map(|(_, heats)| heats),
            lag_k: [found.at[lag], covariance[(lag, lag)].sqrt()],
            misfit,
        })
    }
}

/// How many points in a row say the same of what is left: 1 + 2 Σ ρ, up to where the correlation ends.
fn hanging_together(left: &DVector<f64>) -> f64 {
    let all = left.norm_squared();
    let with = |lag: usize| left.iter().zip(left.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>() / all;
    let correlated = (1..left.len() / 4).map(with).take_while(|rho| *rho > 0.0).sum::<f64>();
    if correlated.is_finite() { 1.0 + 2.0 * correlated } else { 1.0 }
}
