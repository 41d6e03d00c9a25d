//! What a fit may move: parameters of the reference model within their priors, parameters of effects, and what is
//! nuisance of one recording alone. Every coordinate is counted in units of its own scale, 0 = where it is believed to be.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sinew_physics::effects::{self, Effect, EffectParameter, Nature};
use sinew_physics::{DriveKind, WireModel};
use sinew_recording::Column;
use sinew_rig::{Prior, Rig};

use crate::data::{Data, Run};
use crate::measured::Measured;
use crate::numbers::digits;

/// Steps of numerical derivatives, in scales: a hysteretic simulator is not smooth below that, and fits stall.
const STEP: f64 = 0.02;
/// The same of what is known to better than this share: its σ is so short that the simulator's own steps would show.
const FIRM_SHARE: f64 = 0.035;
const FIRM_STEP: f64 = 0.2;
/// How far a parameter with a prior may go, in σ; what a sensor is off by goes at least as far as rigs show.
const FARTHEST_SIGMA: f64 = 8.0;
/// Transformation temperatures this far above the room's are counted from it, K.
const LEAST_WARMTH_K: f64 = 10.0;
/// An effect may be this many times as large as rigs show.
const BEYOND_PLAUSIBLE: f64 = 4.0;
/// The wire that the plausible sizes of effects are told of: 0.2 m long.
const USUAL_DIAMETER_M: f64 = 0.15e-3;
const USUAL_OHM: f64 = 10.0;
const USUAL_J_PER_K: f64 = 0.0125;
const USUAL_W_PER_K: f64 = 0.0094;
/// Run-to-run scatter of a position's gain where its zero is arbitrary, 1 σ.
const GAIN_SCATTER: f64 = 0.03;
/// Run-to-run scatter of a position's zero where it is arbitrary, 1 σ, as a share of the wire's length.
const ZERO_SCATTER: f64 = 0.05;

/// What a coordinate moves.
#[derive(Debug, Clone)]
pub(crate) enum What {
    /// A key of the rig file.
    Key(String),
    /// Both moduli: the rig file says there is but one.
    BothModuli,
    /// A parameter of an effect.
    Effect(&'static Effect, &'static EffectParameter),
    /// The zero of the position in one recording, m.
    Zero(usize),
    /// The gain of the position in one recording.
    Gain(usize),
}

impl What {
    /// Whether another model's coordinate moves the same.
    pub(crate) fn is_the_same(&self, other: &What) -> bool {
        match (self, other) {
            (What::Key(a), What::Key(b)) => a == b,
            (What::BothModuli, What::BothModuli) => true,
            (What::Effect(a, p), What::Effect(b, q)) => a.id == b.id && p.key == q.key,
            (What::Zero(a), What::Zero(b)) | (What::Gain(a), What::Gain(b)) => a == b,
            _ => false,
        }
    }
}

/// One direction a fit can go.
#[derive(Debug, Clone)]
pub(crate) struct Coordinate {
    pub(crate) what: What,
    /// Value at 0, in the key's unit.
    pub(crate) origin: f64,
    /// Value per unit of the coordinate, at 0.
    pub(crate) scale: f64,
    /// Equal steps multiply the value's distance from here, where without it they add to the value. A wire that gets
    /// hotter by some factor, with a smaller loss and heat capacity and gentler curves, is nearly the same wire: in
    /// percentages, and temperatures above that of the room, the valley this makes is straight.
    pub(crate) pivot: Option<f64>,
    /// Bounds, in units of the coordinate.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Weight of the pull to 0: 1 = a normal prior of one scale, 0 = none.
    pub(crate) pull: f64,
    /// Step of numerical derivatives, in units of the coordinate.
    pub(crate) step: f64,
}

impl Coordinate {
    pub(crate) fn value(&self, z: f64) -> f64 {
        match self.pivot {
            Some(pivot) => {
                let distance = self.origin - pivot;
                pivot + distance * (self.scale / distance * z).exp()
            }
            None => self.origin + self.scale * z,
        }
    }

    /// Change of the value per unit of the coordinate.
    pub(crate) fn slope(&self, z: f64) -> f64 {
        match self.pivot {
            Some(pivot) => self.scale * (self.value(z) - pivot) / (self.origin - pivot),
            None => self.scale,
        }
    }

    pub(crate) fn at(&self, value: f64) -> f64 {
        match self.pivot {
            Some(pivot) => {
                let distance = self.origin - pivot;
                ((value - pivot) / distance).max(f64::MIN_POSITIVE).ln() * distance / self.scale
            }
            None => (value - self.origin) / self.scale,
        }
    }

    pub(crate) fn is_of(&self, effect: &Effect) -> bool {
        matches!(&self.what, What::Effect(e, _) if e.id == effect.id)
    }

    /// Whether it is stated as known, and free within a tolerance only; or what a sensor is off by.
    pub(crate) fn is_tolerance(&self) -> bool {
        matches!(&self.what, What::Key(key) if sinew_rig::is_tolerance(key))
    }

    /// Whether it acts on what one recording's sensors show, not on the wire.
    pub(crate) fn is_of_run(&self) -> Option<usize> {
        match self.what {
            What::Zero(run) | What::Gain(run) => Some(run),
            _ => None,
        }
    }
}

/// The coordinates of one model, in their order: reference model, effects as they were added, recordings.
#[derive(Debug, Clone)]
pub(crate) struct Space {
    rig: Arc<Rig>,
    channel: usize,
    pub(crate) coordinates: Vec<Coordinate>,
    pub(crate) effects: Vec<&'static Effect>,
    /// What pulls coordinates together: places of two, and the weight of the product of both.
    ties: Vec<(usize, usize, f64)>,
}

impl Space {
    /// The reference model within its priors, and the nuisances of each recording.
    pub(crate) fn reference(rig: &Rig, channel: usize, data: &Data) -> Space {
        let c = &rig.channels[channel];
        let one_modulus =
            effects::effect("mechanical.phase_modulus").is_some_and(|phase_modulus| phase_modulus.is_null(&c.model));
        let mut coordinates = Vec::new();
        for (key, prior) in c.priors_in_force() {
            if one_modulus && key == "martensite_modulus_gpa" {
                continue;
            }
            let (Some(value), Some((_, lowest, highest))) = (rig.parameter(channel, &key), c.range_of(&key)) else {
                continue;
            };
            let sigma = prior.sigma(value);
            if sigma <= 0.0 || !acts(&key, &c.model, data) {
                continue;
            }
            let both = one_modulus && key == "austenite_modulus_gpa";
            let farthest = as_rigs_show(&key).map_or(FARTHEST_SIGMA, |(low, high)| {
                FARTHEST_SIGMA.max((high - value).abs().max((low - value).abs()) / sigma)
            });
            // a relative prior says that the sign is known
            let floor = if matches!(prior, Prior::Relative(_)) { 0.02 * value.abs() } else { f64::NEG_INFINITY };
            let (least, most) = if value > 0.0 { (lowest.max(floor), highest) } else { (lowest, highest) };
            let temperature = ["austenite_temperature_c", "martensite_temperature_c"].contains(&key.as_str());
            let pivot = match prior {
                Prior::Relative(_) if value > 0.0 => Some(0.0),
                _ if temperature && value - c.model.ambient_c > LEAST_WARMTH_K => Some(c.model.ambient_c),
                _ => None,
            };
            let mut coordinate = Coordinate {
                what: if both { What::BothModuli } else { What::Key(key) },
                origin: value,
                scale: sigma,
                pivot,
                low: 0.0,
                high: 0.0,
                pull: 1.0,
                step: if sigma < FIRM_SHARE * value.abs() { FIRM_STEP } else { STEP },
            };
            coordinate.low = coordinate.at(least).clamp(-farthest, 0.0);
            coordinate.high = coordinate.at(most).clamp(0.0, farthest);
            coordinates.push(coordinate);
        }
        let mut space =
            Space { rig: Arc::new(rig.clone()), channel, coordinates, effects: Vec::new(), ties: Vec::new() };
        space.add_runs(data);
        space
    }

    fn add_runs(&mut self, data: &Data) {
        if !data.free_zero || data.position().is_none() && !data.position_imposed {
            return;
        }
        let length = self.rig.channels[self.channel].model.geometry.length_m;
        let fitted = data.runs.iter().filter(|run| !run.held_out).count();
        for (index, _) in data.runs.iter().enumerate().filter(|(_, run)| !run.held_out) {
            // the zero of a sensor may be anywhere; that of an imposed position says how tight the wire was mounted
            let (low, high, pull) = if data.position_imposed { (-4.0, 4.0, 1.0) } else { (-40.0, 40.0, 0.0) };
            let scale = ZERO_SCATTER * length;
            self.coordinates.push(Coordinate {
                what: What::Zero(index),
                origin: 0.0,
                scale,
                pivot: None,
                low,
                high,
                pull,
                step: STEP,
            });
            if fitted > 1 && !data.position_imposed {
                let (what, scale, pull) = (What::Gain(index), GAIN_SCATTER, 1.0);
                self.coordinates.push(Coordinate {
                    what,
                    origin: 1.0,
                    scale,
                    pivot: None,
                    low: -4.0,
                    high: 4.0,
                    pull,
                    step: STEP,
                });
            }
        }
    }

    /// The same with what was measured of the wire elsewhere as the belief in its keys: in the place of priors that hold where nothing is
    /// known, beside those that the rig file states. Before any effect is added.
    pub(crate) fn told(mut self, measured: &Measured) -> Space {
        let place = |key: &str| self.coordinates.iter().position(|c| matches!(&c.what, What::Key(name) if name == key));
        let known = measured.of(|key| place(key).is_some());
        let Some(belief) = known.beside_stated(&self.rig, self.channel) else { return self };
        let places: Vec<usize> = known.keys.iter().filter_map(|key| place(key)).collect();
        let sigma = |i: usize| belief.covariance[(i, i)].sqrt();
        for (i, &at) in places.iter().enumerate() {
            let before = self.coordinates[at].clone();
            let mut told = Coordinate {
                origin: belief.values[i],
                scale: sigma(i),
                pivot: None,
                pull: belief.precision[(i, i)] * sigma(i) * sigma(i),
                step: if sigma(i) < FIRM_SHARE * belief.values[i].abs() { FIRM_STEP } else { STEP },
                ..before.clone()
            };
            // what recordings may say against it goes as far as it did
            let farthest = FARTHEST_SIGMA * (before.scale / sigma(i)).max(1.0);
            let ends = [before.value(before.low), before.value(before.high)];
            told.low = told.at(ends[0]).clamp(-farthest, 0.0);
            told.high = told.at(ends[1]).clamp(0.0, farthest);
            self.coordinates[at] = told;
            for (j, &with) in places.iter().enumerate().take(i) {
                self.ties.push((at, with, belief.precision[(i, j)] * sigma(i) * sigma(j)));
            }
        }
        self
    }

    /// The same with an effect in it, its parameters free, from the values `start` gives (rig-file units).
    /// Gives the space and where in it the start is, from `z` in this one.
    pub(crate) fn with(&self, effect: &'static Effect, start: &Start, z: &[f64]) -> (Space, Vec<f64>) {
        let mut space = self.clone();
        let mut at = z.to_vec();
        let model = &self.rig.channels[self.channel].model;
        for (parameter, (value, scale, pull, step)) in effect.parameters.iter().zip(&start.parameters) {
            let origin = parameter.null(model).unwrap_or(*value);
            let (low, high) = start.bounds(effect, parameter, model);
            let coordinate = Coordinate {
                what: What::Effect(effect, parameter),
                origin,
                scale: *scale,
                pivot: None,
                low: (low - origin) / scale,
                high: (high - origin) / scale,
                pull: *pull,
                step: *step,
            };
            if *scale > 0.0 {
                at.push(coordinate.at(*value).clamp(coordinate.low, coordinate.high));
                space.coordinates.push(coordinate);
            }
        }
        if !space.effects.iter().any(|there| there.id == effect.id) {
            space.effects.push(effect);
        }
        (space, at)
    }

    /// The same without an effect, and `z` in it.
    pub(crate) fn without(&self, effect: &Effect, z: &[f64]) -> (Space, Vec<f64>) {
        let mut space = self.clone();
        space.effects.retain(|e| e.id != effect.id);
        let keep: Vec<bool> = self.coordinates.iter().map(|c| !c.is_of(effect)).collect();
        let mut kept = keep.iter();
        space.coordinates.retain(|_| *kept.next().unwrap_or(&true));
        (space, z.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(z, _)| *z).collect())
    }

    /// What drives this wire.
    pub(crate) fn drive(&self) -> DriveKind {
        self.rig.channels[self.channel].model.drive.kind
    }

    /// The effect with this id that there is for this wire.
    pub(crate) fn effect(&self, id: &str) -> Option<&'static Effect> {
        self.rig.channels[self.channel].model.effect(id)
    }

    /// Unit of a key of this wire; nothing where there is none.
    pub(crate) fn unit_of(&self, key: &str) -> &'static str {
        self.rig.channels[self.channel].range_of(key).map_or("", |(unit, ..)| unit)
    }

    /// The wire's model at `z`.
    pub(crate) fn model(&self, z: &[f64]) -> Option<WireModel> {
        let mut rig = Rig::clone(&self.rig);
        self.put(z, &mut rig, |value| value).ok()?;
        Some(rig.channels.swap_remove(self.channel).model)
    }

    /// Writes what belongs to the wire at `z` into a rig that people read: in digits that no interval is narrower than.
    pub(crate) fn apply(&self, z: &[f64], rig: &mut Rig) -> Result<(), sinew_rig::Error> {
        self.put(z, rig, digits)
    }

    /// Sets what belongs to the wire at `z`, every value as `digits` makes it.
    fn put(&self, z: &[f64], rig: &mut Rig, digits: impl Fn(f64) -> f64) -> Result<(), sinew_rig::Error> {
        for (coordinate, z) in self.coordinates.iter().zip(z) {
            let value = digits(coordinate.value(*z));
            match &coordinate.what {
                What::Key(key) => rig.set_parameter(self.channel, key, value)?,
                What::BothModuli => {
                    rig.set_parameter(self.channel, "austenite_modulus_gpa", value)?;
                    rig.set_parameter(self.channel, "martensite_modulus_gpa", value)?;
                }
                What::Effect(_, parameter) => {
                    if let Some(channel) = rig.channels.get_mut(self.channel) {
                        parameter.set(&mut channel.model, value);
                    }
                }
                What::Zero(_) | What::Gain(_) => {}
            }
        }
        Ok(())
    }

    /// Value of a key of the rig file at `z`, in its unit.
    pub(crate) fn value(&self, key: &str, z: &[f64]) -> Option<f64> {
        let free = self.coordinates.iter().zip(z).find(|(c, _)| matches!(&c.what, What::Key(name) if name == key));
        free.map(|(c, z)| c.value(*z)).or_else(|| self.rig.parameter(self.channel, key))
    }

    /// A recording as the wire at `z` is driven by it: an imposed position counts from its own zero there, or, where that was not
    /// fitted, from the mean of the others.
    pub(crate) fn run<'a>(&self, data: &'a Data, index: usize, z: &[f64]) -> Cow<'a, Run> {
        let run = &data.runs[index];
        if !(data.position_imposed && data.free_zero) {
            return Cow::Borrowed(run);
        }
        let zeros: Vec<(usize, f64)> = self
            .coordinates
            .iter()
            .zip(z)
            .filter_map(|(c, z)| match c.what {
                What::Zero(of) => Some((of, c.value(*z))),
                _ => None,
            })
            .collect();
        let own = zeros.iter().find(|(of, _)| *of == index).map(|(_, zero)| *zero);
        let mean = zeros.iter().map(|(_, zero)| zero).sum::<f64>() / zeros.len().max(1) as f64;
        Cow::Owned(run.counted_from(own.unwrap_or(mean)))
    }

    /// Zero and gain of the position in a recording at `z`.
    pub(crate) fn position_of(&self, run: usize, z: &[f64]) -> (f64, f64) {
        let mut zero = 0.0;
        let mut gain = 1.0;
        for (coordinate, z) in self.coordinates.iter().zip(z) {
            match coordinate.what {
                What::Zero(of) if of == run => zero = coordinate.value(*z),
                What::Gain(of) if of == run => gain = coordinate.value(*z),
                _ => {}
            }
        }
        (zero, gain)
    }

    /// Weight of each coordinate's pull to where it is believed to be, beside the squared residuals.
    pub(crate) fn pulls(&self) -> impl Iterator<Item = f64> + '_ {
        self.coordinates.iter().map(|c| c.pull)
    }

    /// What the priors add to the squared residuals: Σ z², and what ties coordinates.
    pub(crate) fn resistance(&self, z: &[f64]) -> f64 {
        let alone: f64 = self.coordinates.iter().zip(z).map(|(c, z)| c.pull * z * z).sum();
        alone + self.ties.iter().map(|(i, j, weight)| 2.0 * weight * z[*i] * z[*j]).sum::<f64>()
    }

    /// Adds the priors' curvature to that of the squared residuals.
    pub(crate) fn add_pulls(&self, information: &mut DMatrix<f64>) {
        for (i, pull) in self.pulls().enumerate() {
            information[(i, i)] += pull;
        }
        for &(i, j, weight) in &self.ties {
            information[(i, j)] += weight;
            information[(j, i)] += weight;
        }
    }

    /// Adds half of the priors' derivative at `z` to that of the squared residuals.
    pub(crate) fn add_pulls_at(&self, z: &[f64], gradient: &mut DVector<f64>) {
        for (i, (pull, z)) in self.pulls().zip(z).enumerate() {
            gradient[i] += pull * z;
        }
        for &(i, j, weight) in &self.ties {
            gradient[i] += weight * z[j];
            gradient[j] += weight * z[i];
        }
    }

    /// Whether what is believed of a coordinate was measured elsewhere together with others.
    pub(crate) fn is_tied(&self, place: usize) -> bool {
        self.ties.iter().any(|(i, j, _)| *i == place || *j == place)
    }

    /// Whether what switches an effect on is a nuisance here already.
    pub(crate) fn has_as_nuisance(&self, effect: &Effect) -> bool {
        let is_there =
            |name: String| self.coordinates.iter().any(|c| matches!(&c.what, What::Key(key) if *key == name));
        effect.parameters.iter().filter(|p| p.is_switch()).any(|p| is_there(format!("{}.{}", effect.id, p.key)))
    }

    /// Logarithm of the density of the priors at their best, up to what is common to all models: what a free parameter costs
    /// by having been free.
    pub(crate) fn log_prior(&self) -> f64 {
        let of = |c: &Coordinate| match c.what {
            _ if c.pull > 0.0 => 0.5 * c.pull.ln(),
            // anywhere between its bounds
            What::Effect(..) => 0.5 * std::f64::consts::TAU.ln() - (c.high - c.low).ln(),
            _ => 0.0,
        };
        self.coordinates.iter().map(of).sum()
    }

    pub(crate) fn len(&self) -> usize {
        self.coordinates.len()
    }
}

/// What rigs show of a gain or an offset of a sensor, by its key in the rig file.
fn as_rigs_show(key: &str) -> Option<(f64, f64)> {
    let (id, of) = key.rsplit_once('.').filter(|(id, _)| id.starts_with("sensing."))?;
    Some(effects::effect(id)?.parameters.iter().find(|p| p.key == of)?.plausible)
}

/// What rigs show of a parameter of an effect, least and largest. Ohms, newtons and what a sleeve holds are told of a usual wire: one of
/// a hundred ohms has joints of more, a thick one slides with more force and has thicker sleeves.
pub(crate) fn plausible(effect: &Effect, parameter: &EffectParameter, model: &WireModel) -> (f64, f64) {
    if effect.nature != Nature::Mechanism || effect.id.starts_with("own.") {
        // told of this very rig
        return parameter.plausible;
    }
    let geometry = &model.geometry;
    let area = geometry.area_m2() / (0.25 * std::f64::consts::PI * USUAL_DIAMETER_M * USUAL_DIAMETER_M);
    let times = match parameter.unit {
        "Ω" => model.material.martensite_resistivity_ohm_m * geometry.length_m / geometry.area_m2() / USUAL_OHM,
        "N" => area,
        "m/N" => 1.0 / area,
        "J/K" => model.heat_capacity_j_per_k() / USUAL_J_PER_K,
        "W/K" => model.constant_loss_w_per_k() / USUAL_W_PER_K,
        _ => 1.0,
    };
    let null = parameter.null(model).unwrap_or(0.0);
    let (low, high) = parameter.plausible;
    // a short thick wire has the same joints as any
    let scaled = |end: f64| null + times.max(1.0) * (end - null);
    (scaled(low).max(parameter.low), scaled(high).min(parameter.high))
}

/// Where a fit of an effect starts, by parameter: value, scale (0 = held there), pull and step of the derivative in
/// scales; and bounds that are narrower than the catalogue's.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) parameters: Vec<(f64, f64, f64, f64)>,
    /// Bounds of times, s.
    pub(crate) times_s: (f64, f64),
}

impl Start {
    /// What the catalogue allows, and not much beyond what rigs show: a size that no rig has is no explanation.
    fn bounds(&self, effect: &Effect, parameter: &EffectParameter, model: &WireModel) -> (f64, f64) {
        if is_time(parameter) {
            return self.times_s;
        }
        let (low, high) = plausible(effect, parameter, model);
        let null = parameter.null(model).unwrap_or(0.5 * (low + high));
        // rigs show one sign of most; where the catalogue allows the other, it is as likely to be that large
        let reach = BEYOND_PLAUSIBLE * (high - null).abs().max((low - null).abs());
        ((null - reach).max(parameter.low), (null + reach).min(parameter.high))
    }
}

/// A parameter that is a time of the recording, s.
pub(crate) fn is_time(parameter: &EffectParameter) -> bool {
    matches!(parameter.key, "start_s" | "end_s")
}

/// Step of a derivative with respect to an effect's parameter, in scales.
pub(crate) const EFFECT_STEP: f64 = STEP;

/// The column of the sensor whose gain or offset this is, by its key in `sensing.gain` and `sensing.offset`.
pub(crate) fn amplified(key: &str) -> Option<Column> {
    match key {
        "v1_v" => Some(Column::V1V),
        "v2_v" => Some(Column::V2V),
        "v3" | "v3_v" => Some(Column::V3V),
        "current" | "current_a" => Some(Column::CurrentA),
        "force" | "force_n" => Some(Column::ForceN),
        "position" | "position_m" => Some(Column::PositionM),
        _ => None,
    }
}

/// Whether a parameter can make a difference to what was measured at all.
fn acts(key: &str, model: &WireModel, data: &Data) -> bool {
    use sinew_physics::{DriveKind, Load};
    let is_sensor = |column: Column| data.sensors.iter().any(|sensor| sensor.column == column);
    if let Some(name) = key.strip_prefix("sensing.gain.").or(key.strip_prefix("sensing.offset.")) {
        return match (amplified(name), name) {
            (Some(column), _) if !is_sensor(column) => false,
            // an arbitrary zero is a nuisance of each recording, and so is the gain where there are several
            (_, "position") => !(data.free_zero && data.runs.len() > 1),
            (_, "position_m") => !data.free_zero,
            _ => true,
        };
    }
    let furnace = model.drive.kind == DriveKind::Temperature;
    match key {
        "convection_w_per_m2_k" | "specific_heat_j_per_kg_k" | "latent_heat_j_per_kg" => !furnace,
        "ambient_c" => !furnace && data.runs.iter().any(|run| run.ambient_of_model),
        "supply_v" => !furnace && data.runs.iter().any(|run| run.supply_of_model),
        "shunt_ohm" | "switch_ohm" | "lead_ohm" => !furnace,
        "l0_mm" => is_sensor(Column::V1V) || is_sensor(Column::V2V),
        "ls_mm" => is_sensor(Column::V2V),
        "damping_n_s_per_m" => matches!(model.load, Load::SpringMassDamper { .. }),
        _ => true,
    }
}
