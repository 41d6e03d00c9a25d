//! Where: one equation at a time is given an unknown input that may wander through the recording, and the one with which
//! the recording is most probable — all sensors together, not one of them — is the guilty one. After Kristensen and
//! Madsen, who let each state equation carry its own noise; here without a filter, which would sit badly on hysteresis:
//! the input is a row of hats in time, simulated one by one.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sinew_physics::effects::Equation;
use sinew_physics::formulas::WORKING_EXCESS_K;
use sinew_physics::{Unknown, Wire, WireModel};
use sinew_recording::Column;

use crate::data::{Data, Part, Run};
use crate::derivatives;
use crate::fit::Fit;
use crate::products;
use crate::progress::each;
use crate::residuals::{self, Residuals};
use crate::simulate;

/// Most hats over all recordings, and their least distance, s.
const MOST_HATS: f64 = 150.0;
const LEAST_SPACING_S: f64 = 0.4;
/// A hat's effect is followed until it is this small, in units of noise, for as long as one hat.
const FORGOTTEN: f64 = 0.02;
/// Sizes of the unknown input that are tried, in units of its natural size.
const SIZES: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];

/// Difference of log evidence that is clear.
const CLEARLY: f64 = 10.0;

/// One kind of unknown input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Heat,
    Resistivity,
    Driving,
    Strain,
    Load,
    /// An error of one sensor: its index.
    Sensor(usize),
    /// A resistance inside V_3.
    Contact,
}

/// What an unknown input of one kind explains.
#[derive(Debug, Clone)]
pub(crate) struct Located {
    pub(crate) kind: Kind,
    pub(crate) equation: Equation,
    /// What it is, in words.
    pub(crate) what: String,
    pub(crate) unit: &'static str,
    /// Share of what is left that it explains.
    pub(crate) score: f64,
    /// Logarithm of the probability of the recording, up to what is common to all kinds.
    pub(crate) evidence: f64,
    /// By recording: times and values.
    pub(crate) input: Vec<(Vec<f64>, Vec<f64>)>,
}

/// A column of few samples: residuals over noise from one row on, by sensor.
struct Hat {
    run: usize,
    first: usize,
    /// By sensor.
    values: Vec<Vec<f32>>,
}

/// What every kind explains, the most probable first.
pub(crate) fn locate(data: &Data, fit: &Fit, progress: &(dyn Fn(f64) + Sync)) -> Vec<Located> {
    let Some(model) = fit.space.model(&fit.z) else { return Vec::new() };
    let Some(here) = fit.residuals(data) else { return Vec::new() };
    let Some(nuisances) = derivatives::one_sided(data, &fit.space, &fit.z) else { return Vec::new() };
    let own = products::gram(data, Part::Fitted, &nuisances);
    let along: Vec<f64> = nuisances.iter().map(|c| products::inner(data, Part::Fitted, c, &here)).collect();
    let score = residuals::score(data, &here);
    let fitted: Vec<usize> = (0..data.runs.len()).filter(|r| !data.runs[*r].held_out).collect();
    let total_s: f64 = fitted.iter().map(|r| data.runs[*r].duration_s()).sum();
    let least = fitted
        .iter()
        .map(|r| 4.0 * data.runs[*r].duration_s() / data.runs[*r].time_s.len() as f64)
        .fold(LEAST_SPACING_S, f64::max);
    let spacing = (total_s / MOST_HATS).max(least);
    let bases: Vec<Baseline> = fitted.iter().filter_map(|r| Baseline::new(data, fit, &model, *r, spacing)).collect();
    let kinds = kinds(data, &model);
    let mut located: Vec<Located> = each(kinds, 1.0, progress, |kind| {
        let hats: Vec<Hat> = bases
            .par_iter()
            .flat_map(|base| {
                let model = &model;
                (0..base.knots.len()).into_par_iter().map(move |k| base.hat(data, model, kind, k))
            })
            .collect();
        explain(data, fit, kind, &model, &bases, &hats, &here, &nuisances, &own, &along, score.fitted)
    });
    located.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    located
}

/// The share of what is left that the best unknown input to each equation explains.
pub(crate) fn scores(located: &[Located]) -> BTreeMap<String, f64> {
    let mut scores = BTreeMap::new();
    for l in located {
        let score: &mut f64 = scores.entry(l.equation.name().to_string()).or_insert(0.0);
        *score = score.max(l.score);
    }
    scores
}

/// Whether an unknown input to the wire makes the recording more probable than an error of any one sensor does: noise of
/// sensors, whatever its colour, comes in each of them by itself. One sensor alone cannot say.
pub(crate) fn is_physical(located: &[Located]) -> bool {
    let best = |of_sensor: bool| {
        located
            .iter()
            .filter(|l| matches!(l.kind, Kind::Sensor(_)) == of_sensor)
            .map(|l| l.evidence)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    best(true).is_finite() && best(false) > best(true) + CLEARLY
}

/// The kinds that make sense here.
fn kinds(data: &Data, model: &WireModel) -> Vec<Kind> {
    use sinew_physics::DriveKind;
    let mut kinds = vec![Kind::Driving, Kind::Strain, Kind::Load];
    if model.drive.kind != DriveKind::Temperature {
        kinds.push(Kind::Heat);
    }
    let electrical = [Column::CurrentA, Column::V2V, Column::V3V];
    if data.sensors.iter().any(|s| electrical.contains(&s.column)) {
        kinds.push(Kind::Resistivity);
    }
    if data.sensors.iter().any(|s| s.column == Column::V3V) && data.sensors.len() > 1 {
        kinds.push(Kind::Contact);
    }
    // with one sensor, its error can never be distinguished from the wire's
    if data.sensors.len() > 1 {
        kinds.extend((0..data.sensors.len()).map(Kind::Sensor));
    }
    kinds
}

impl Kind {
    fn equation(self) -> Equation {
        match self {
            Kind::Heat => Equation::Thermal,
            Kind::Resistivity => Equation::Electrical,
            Kind::Driving => Equation::Kinetic,
            Kind::Strain | Kind::Load => Equation::Mechanical,
            Kind::Sensor(_) | Kind::Contact => Equation::Sensing,
        }
    }

    /// In words, and its unit.
    fn words(self, data: &Data) -> (String, &'static str) {
        match self {
            Kind::Heat => ("heat into the wire".into(), "W"),
            Kind::Resistivity => ("relative change of resistivity".into(), "1"),
            Kind::Driving => ("shift of the transformation".into(), "K"),
            Kind::Strain => ("strain without stress".into(), "1"),
            Kind::Load => ("force on the load".into(), "N"),
            Kind::Contact => ("resistance inside V3".into(), "Ω"),
            Kind::Sensor(s) => {
                let column = data.sensors[s].column;
                (format!("error of {}", column.name()), unit_of(column))
            }
        }
    }

    /// The size that is natural here: an input that would be called small.
    fn natural(self, data: &Data, model: &WireModel) -> f64 {
        let g = &model.geometry;
        match self {
            Kind::Heat => 0.1 * g.loss_w_per_k(model.material.convection_w_per_m2_k.max(20.0)) * WORKING_EXCESS_K,
            Kind::Resistivity => 0.01,
            Kind::Driving => 1.0,
            Kind::Strain => 3e-4,
            Kind::Load => 5e6 * g.area_m2(),
            Kind::Contact => 0.05,
            Kind::Sensor(s) => 3.0 * data.sensors[s].noise,
        }
    }

    fn unknown(self, amount: f64) -> Unknown {
        let mut unknown = Unknown::default();
        match self {
            Kind::Heat => unknown.heat_w = amount,
            Kind::Resistivity => unknown.resistivity = amount,
            Kind::Driving => unknown.driving_k = amount,
            Kind::Strain => unknown.strain = amount,
            Kind::Load => unknown.load_n = amount,
            Kind::Contact | Kind::Sensor(_) => {}
        }
        unknown
    }
}

/// The unit of a column.
pub(crate) fn unit_of(column: Column) -> &'static str {
    match column {
        Column::Duty => "1",
        Column::PowerW => "W",
        Column::TemperatureC | Column::AmbientC => "K",
        Column::SupplyV | Column::V1V | Column::V2V | Column::V3V => "V",
        Column::CurrentA => "A",
        Column::ForceN | Column::DisturbanceN => "N",
        Column::PositionM => "m",
    }
}

/// One recording simulated once, with the wire kept at every knot to go on from.
struct Baseline<'a> {
    run: usize,
    /// The recording as the fit sees it.
    seen: Cow<'a, Run>,
    /// Rows of the knots.
    knots: Vec<usize>,
    wires: Vec<Wire>,
    /// By sensor.
    outputs: Vec<Vec<f64>>,
    spacing_s: f64,
}

impl<'a> Baseline<'a> {
    fn new(data: &'a Data, fit: &Fit, model: &WireModel, run: usize, spacing_s: f64) -> Option<Baseline<'a>> {
        let r = fit.space.run(data, run, &fit.z);
        let mut wire = simulate::wire(model, &r)?;
        let count = (r.duration_s() / spacing_s).floor().max(2.0);
        let spacing_s = r.duration_s() / count;
        let mut base = Baseline {
            run,
            seen: r.clone(),
            knots: Vec::new(),
            wires: Vec::new(),
            outputs: vec![Vec::new(); data.sensors.len()],
            spacing_s,
        };
        for (row, (inputs, dt_s)) in r.inputs_of(model).enumerate() {
            if r.time_s[row] - r.time_s[0] >= base.knots.len() as f64 * spacing_s - 1e-9 {
                base.knots.push(row);
                base.wires.push(wire.clone());
            }
            r.prepare(row, &mut wire);
            wire.step(&inputs, dt_s);
            let seen = wire.outputs();
            for (sensor, values) in data.sensors.iter().zip(&mut base.outputs) {
                values.push(sensor.column.of_outputs(&seen).unwrap_or(f64::NAN));
            }
        }
        Some(base)
    }

    /// The residuals' change by a hat of natural size centred on knot `k`.
    fn hat(&self, data: &Data, model: &WireModel, kind: Kind, k: usize) -> Hat {
        let run = &data.runs[self.run];
        let from = if k == 0 { 0 } else { k - 1 };
        let first = self.knots[from];
        let centre_s = run.time_s[self.knots[k]];
        let natural = kind.natural(data, model);
        let weight = |time_s: f64| (1.0 - (time_s - centre_s).abs() / self.spacing_s).max(0.0);
        let mut values: Vec<Vec<f32>> = vec![Vec::new(); data.sensors.len()];
        match kind {
            Kind::Sensor(_) | Kind::Contact => {
                for row in first..run.time_s.len() {
                    let w = weight(run.time_s[row]);
                    if w == 0.0 && run.time_s[row] > centre_s {
                        break;
                    }
                    for (s, sensor) in data.sensors.iter().enumerate() {
                        let change = match kind {
                            Kind::Sensor(of) if of == s => natural * w,
                            Kind::Contact if sensor.column == Column::V3V => {
                                let current = data
                                    .sensors
                                    .iter()
                                    .position(|s| s.column == Column::CurrentA)
                                    .map_or(1.0, |c| self.outputs[c][row]);
                                natural * w * current
                            }
                            _ => 0.0,
                        };
                        values[s].push((-change / sensor.noise) as f32);
                    }
                }
            }
            _ => {
                let mut wire = self.wires[from].clone();
                let mut quiet_since = f64::INFINITY;
                for (row, (inputs, dt_s)) in self.seen.inputs_of(model).enumerate().skip(first) {
                    let time_s = run.time_s[row];
                    wire.set_unknown(kind.unknown(natural * weight(time_s + 0.5 * dt_s)));
                    self.seen.prepare(row, &mut wire);
                    wire.step(&inputs, dt_s);
                    let seen = wire.outputs();
                    let mut largest = 0.0f64;
                    for (s, sensor) in data.sensors.iter().enumerate() {
                        let simulated = sensor.column.of_outputs(&seen).unwrap_or(f64::NAN);
                        let change = (self.outputs[s][row] - simulated) / sensor.noise;
                        largest = largest.max(change.abs());
                        values[s].push(change as f32);
                    }
                    if time_s > centre_s + self.spacing_s {
                        quiet_since = if largest > FORGOTTEN { f64::INFINITY } else { quiet_since.min(time_s) };
                        if time_s - quiet_since > self.spacing_s.max(1.0) {
                            break;
                        }
                    }
                }
            }
        }
        Hat { run: self.run, first, values }
    }
}

impl Hat {
    fn end(&self) -> usize {
        self.first + self.values.first().map_or(0, Vec::len)
    }

    /// Σ over the fitted samples of this column times dense residuals.
    fn with(&self, data: &Data, dense: &Residuals) -> f64 {
        let run = &data.runs[self.run];
        let mut sum = 0.0;
        for (own, other) in self.values.iter().zip(&dense[self.run]) {
            for (i, v) in own.iter().enumerate() {
                let row = self.first + i;
                let product = v * other[row];
                if run.part[row] == Part::Fitted && !product.is_nan() {
                    sum += f64::from(product);
                }
            }
        }
        sum
    }

    fn with_hat(&self, data: &Data, other: &Hat, measured: &Residuals) -> f64 {
        if self.run != other.run {
            return 0.0;
        }
        let (from, to) = (self.first.max(other.first), self.end().min(other.end()));
        let run = &data.runs[self.run];
        let mut sum = 0.0;
        for (s, (a, b)) in self.values.iter().zip(&other.values).enumerate() {
            for row in from..to {
                let product = a[row - self.first] * b[row - other.first];
                if run.part[row] == Part::Fitted && !product.is_nan() && !measured[self.run][s][row].is_nan() {
                    sum += f64::from(product);
                }
            }
        }
        sum
    }
}

/// How probable the recording is with this input of unknown size, and what the input then is.
#[allow(clippy::too_many_arguments)]
fn explain(
    data: &Data,
    fit: &Fit,
    kind: Kind,
    model: &WireModel,
    bases: &[Baseline],
    hats: &[Hat],
    here: &Residuals,
    nuisances: &[Residuals],
    own: &DMatrix<f64>,
    along: &[f64],
    before: f64,
) -> Option<Located> {
    let (n, k) = (nuisances.len(), hats.len());
    let pulls: Vec<f64> = fit.space.pulls().collect();
    let mut gram = DMatrix::zeros(n + k, n + k);
    gram.view_mut((0, 0), (n, n)).copy_from(own);
    let mut b = DVector::zeros(n + k);
    for i in 0..n {
        b[i] = along[i] + pulls[i] * fit.z[i];
    }
    for (i, hat) in hats.iter().enumerate() {
        b[n + i] = hat.with(data, here);
        for (j, column) in nuisances.iter().enumerate() {
            let product = hat.with(data, column);
            gram[(n + i, j)] = product;
            gram[(j, n + i)] = product;
        }
        for (j, other) in hats.iter().enumerate().take(i + 1) {
            let product = hat.with_hat(data, other, here);
            gram[(n + i, n + j)] = product;
            gram[(n + j, n + i)] = product;
        }
    }
    let mut best: Option<(f64, DVector<f64>)> = None;
    for size in SIZES {
        let mut a = gram.clone();
        for i in 0..n + k {
            a[(i, i)] += if i < n { pulls[i].max(1e-4) } else { 1.0 / (size * size) };
        }
        let Some(factor) = a.cholesky() else { continue };
        let solution = factor.solve(&(-&b));
        // ln det of the prior's and of the posterior's precision, and what the fit gains
        let determinant: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
        let prior = -2.0 * (k as f64) * f64::ln(size);
        let evidence = 0.5 * (-b.dot(&solution) - determinant + prior);
        if best.as_ref().is_none_or(|(e, _)| evidence > *e) {
            best = Some((evidence, solution));
        }
    }
    let (evidence, solution) = best?;
    let change = 2.0 * b.dot(&solution) + (&gram * &solution).dot(&solution)
        - 2.0 * (0..n).map(|i| pulls[i] * fit.z[i] * solution[i]).sum::<f64>();
    let count = fit.score.fitted_count;
    let excess = before - count;
    let score = if excess > 0.0 { (-change / excess).clamp(0.0, 1.0) } else { 0.0 };
    let natural = kind.natural(data, model);
    let (what, unit) = kind.words(data);
    let mut input = Vec::new();
    let mut at = n;
    for base in bases {
        let run = &data.runs[base.run];
        let count = base.knots.len();
        input.push((
            base.knots.iter().map(|row| run.time_s[*row]).collect(),
            (at..at + count).map(|i| natural * solution[i]).collect(),
        ));
        at += count;
    }
    Some(Located { kind, equation: kind.equation(), what, unit, score, evidence, input })
}
