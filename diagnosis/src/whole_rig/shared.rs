//! What wires may share: effects of the catalogue that act through what others do, with one size for all of them.

use sinew_physics::effects::{Effect, EffectParameter};
use sinew_physics::{DriveKind, Surroundings};
use sinew_rig::{Channel, Rig};

use super::others::{self, Acts};
use super::wire::Wire;
use crate::data::Data;
use crate::diagnose::Found;
use crate::explanation::{Explanation, Turns};
use crate::fit::Fit;
use crate::starts;

/// Half-width of a 90 % interval, in standard deviations.
const Z90: f64 = 1.6449;
/// Supplies of voltages that differ by less than this share may be one.
const SAME_SUPPLY: f64 = 0.01;
/// A size has settled when it moves by less than this share of its interval.
const SETTLED: f64 = 0.15;
/// The most that is made of how slowly it settles.
const MOST_RATIO: f64 = 0.9;
/// What a wire knows at least, in one over the square of what rigs show: nothing is divided by nothing.
const LEAST_KNOWN: f64 = 1e-9;

/// How wires hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tie {
    /// All of them draw from one supply.
    Supply,
    /// Two are beside each other.
    Neighbours,
}

/// A kind of effect that wires share.
pub(crate) struct Kind {
    pub(crate) id: &'static str,
    /// The effect of the catalogue through which others act on each of them, and what says how much.
    effect: &'static str,
    tie: Tie,
}

/// All kinds.
pub(crate) const SHARED: [Kind; 2] = [
    Kind { id: "shared.supply_resistance", effect: "electrical.supply_sag", tie: Tie::Supply },
    Kind { id: "shared.neighbour_heating", effect: "thermal.neighbour", tie: Tie::Neighbours },
];

/// Something that certain wires may share.
#[derive(Clone)]
pub(crate) struct Shared {
    kind: &'static Kind,
    pub(crate) effect: &'static Effect,
    /// Its size.
    pub(crate) parameter: &'static EffectParameter,
    /// The wires, by index.
    pub(crate) members: Vec<usize>,
}

/// How large a shared effect is, by all of the wires it ties together.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// With its 90 % interval, in the unit of the rig file's key.
    pub(crate) value: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// What each wire says by itself: value, low, high.
    pub(crate) by_wire: Vec<[f64; 3]>,
    /// Rise of the sum of the log evidences over the wires without it.
    pub(crate) rise: f64,
    /// What its being free costs of the log evidence: it is integrated over.
    pub(crate) price: f64,
    /// Every wire as it was fitted for this, with the effect in its model.
    pub(crate) fits: Vec<Fit>,
}

impl Estimate {
    /// Rise of the log evidence by its being what it is and not null, everything else the same.
    pub(crate) fn weight(&self) -> f64 {
        let deviation = (self.high - self.low) / (2.0 * Z90);
        0.5 * (self.value / deviation).powi(2) + self.price
    }

    /// Takes into account that the size and what the wires do depend on each other: a turn that moves it by so much of
    /// what the turn before has done is on a way that is longer by the sum of all further ones, and so is any error.
    pub(crate) fn widen(&mut self, ratio: f64) {
        let longer = 1.0 / (1.0 - ratio.clamp(0.0, MOST_RATIO));
        let reach = 0.5 * longer * (self.high - self.low);
        (self.low, self.high) = (self.value - reach, self.value + reach);
    }

    /// Whether another estimate says the same as far as this one knows.
    pub(crate) fn agrees_with(&self, other: f64) -> bool {
        (self.value - other).abs() < SETTLED * (self.high - self.low)
    }
}

/// What one wire says of a size, in units of what rigs show.
struct Opinion {
    size: f64,
    /// One over the variance, by the data alone.
    known: f64,
    /// Log of the probability of the data at that size.
    peak: f64,
    fit: Fit,
}

/// Everything that wires of a rig may share and do not according to it.
pub(crate) fn candidates(rig: &Rig, wires: &[Wire]) -> Vec<Shared> {
    SHARED.iter().flat_map(|kind| kind.candidates(rig, wires)).collect()
}

impl Kind {
    fn candidates(&'static self, rig: &Rig, wires: &[Wire]) -> Vec<Shared> {
        let effect_of = |channel: &Channel| channel.model.effect(self.effect);
        let is_free = |index: &usize| {
            let channel = &rig.channels[wires[*index].channel];
            effect_of(channel).is_some_and(|effect| effect.is_null(&channel.model) && effect.applies_to(&channel.model))
        };
        let free: Vec<usize> = (0..wires.len()).filter(is_free).collect();
        let groups: Vec<Vec<usize>> = match self.tie {
            Tie::Supply => by_supply(rig, wires, &free),
            Tie::Neighbours => {
                let pairs = free.iter().enumerate().flat_map(|(i, a)| free[i + 1..].iter().map(|b| vec![*a, *b]));
                pairs.collect()
            }
        };
        let shared = |members: Vec<usize>| {
            let effect = effect_of(&rig.channels[wires[members[0]].channel])?;
            let parameter = effect.parameters.iter().find(|parameter| parameter.is_switch())?;
            Some(Shared { kind: self, effect, parameter, members })
        };
        groups.into_iter().filter_map(shared).collect()
    }
}

/// Wires that are switched, by what their supplies are stated to have.
fn by_supply(rig: &Rig, wires: &[Wire], free: &[usize]) -> Vec<Vec<usize>> {
    let drive = |index: usize| &rig.channels[wires[index].channel].model.drive;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for index in free.iter().copied().filter(|index| drive(*index).kind == DriveKind::Pwm) {
        let supply_v = drive(index).supply_v;
        let fits = |group: &&mut Vec<usize>| (drive(group[0]).supply_v - supply_v).abs() <= SAME_SUPPLY * supply_v;
        match groups.iter_mut().find(fits) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups
}

impl Shared {
    pub(crate) fn id(&self) -> &'static str {
        self.kind.id
    }

    /// Says in a rig which wires hang together.
    pub(crate) fn tie(&self, rig: &mut Rig, wires: &[Wire]) {
        let channels: Vec<usize> = self.members.iter().map(|index| wires[*index].channel).collect();
        match self.kind.tie {
            Tie::Supply => {
                let named = |name: &str| rig.channels.iter().any(|channel| channel.supply.as_deref() == Some(name));
                let name = std::iter::once("shared".to_string())
                    .chain((2..).map(|number| format!("shared-{number}")))
                    .find(|name| !named(name));
                channels.iter().for_each(|channel| rig.channels[*channel].supply.clone_from(&name));
            }
            Tie::Neighbours => {
                for (channel, other) in channels.iter().zip(channels.iter().rev()) {
                    rig.channels[*channel].neighbour = Some(rig.channels[*other].name.clone());
                }
            }
        }
    }

    /// Writes its size into a rig.
    pub(crate) fn set(&self, rig: &mut Rig, wires: &[Wire], value: f64) {
        for index in &self.members {
            self.parameter.set(&mut rig.channels[wires[*index].channel].model, value);
        }
    }

    /// Estimates its size, the wires among what `around` says of each: beside the parameters alone, and beside what
    /// each wire has found for itself, whichever raises the evidence more.
    pub(crate) fn estimate(
        &self,
        wires: &[Wire],
        around: &dyn Fn(&Wire) -> Vec<Vec<Surroundings>>,
    ) -> Option<Estimate> {
        let of = |beside: &dyn Fn(&Found) -> Explanation| {
            let mut opinions = Vec::new();
            let mut before = 0.0;
            for index in &self.members {
                let wire = &wires[*index];
                let base = beside(&wire.found);
                let data = wire.found.searched.among(&wire.found.data, &around(wire));
                before += base.evidence;
                opinions.push(self.opinion(&data, &base)?);
            }
            Some(self.combined(opinions, before))
        };
        let alone = of(&|found| found.selection.reference.clone());
        let beside_others = of(&|found| found.selection.chosen.clone());
        alone.into_iter().chain(beside_others).max_by(|a, b| a.rise.total_cmp(&b.rise))
    }

    /// Estimates its size once more where the wires were searched with it in their models, each among what `around`
    /// says.
    pub(crate) fn again(
        &self,
        found: &[(usize, Found)],
        around: &dyn Fn(usize, &Data) -> Vec<Vec<Surroundings>>,
        before: f64,
    ) -> Option<Estimate> {
        let acts = match self.kind.tie {
            Tie::Supply => Acts::Current,
            Tie::Neighbours => Acts::Warmth,
        };
        let doubts = found
            .iter()
            .map(|(_, found)| others::uncertainty(&found.searched, &found.selection.chosen.fit, acts))
            .collect::<Option<Vec<f64>>>()?;
        let opinions: Vec<Opinion> = found
            .iter()
            .enumerate()
            .map(|(number, (index, found))| {
                let data = found.searched.among(&found.data, &around(*index, &found.data));
                let opinion = self.opinion_from(&data, &found.selection.chosen, before)?;
                // what it knows is no better than what the others are known to do to it
                let others = doubts.iter().enumerate().filter(|(other, _)| *other != number);
                let doubt = others.map(|(_, doubt)| *doubt).fold(0.0, f64::max) * opinion.size;
                Some(Opinion { known: 1.0 / (1.0 / opinion.known + doubt * doubt), ..opinion })
            })
            .collect::<Option<_>>()?;
        Some(self.combined(opinions, 0.0))
    }

    /// What a wire says of the size, in place of the same effect of its own.
    fn opinion(&self, data: &Data, base: &Explanation) -> Option<Opinion> {
        self.opinion_from(data, &base.bared_of(self.effect), self.parameter.plausible.0)
    }

    fn opinion_from(&self, data: &Data, base: &Explanation, value: f64) -> Option<Opinion> {
        let model = base.fit.space.model(&base.fit.z)?;
        let mut start = starts::starts(self.effect, &model, &[], data.longest_s()).into_iter().next()?.start;
        for (parameter, start) in self.effect.parameters.iter().zip(&mut start.parameters) {
            if parameter.key == self.parameter.key {
                start.0 = value;
            }
        }
        let (space, z) = base.fit.space.with(self.effect, &start, &base.fit.z);
        let found = Explanation::of(data, &space, &z, &base.discrepancy, Turns::SOME)?;
        let place = space.coordinates.iter().position(|coordinate| coordinate.is_of(self.effect))?;
        let (coordinate, deviation) = (&space.coordinates[place], found.fit.deviations()[place]);
        let information = 1.0 / (deviation * deviation).max(f64::MIN_POSITIVE);
        let size = found.fit.z[place];
        Some(Opinion {
            size,
            known: (information - coordinate.pull).max(LEAST_KNOWN),
            // what the wire's own prior and integral over it have put in is taken out again
            fit: found.fit.clone(),
            peak: found.evidence + 0.5 * (information / coordinate.pull).ln() + 0.5 * coordinate.pull * size * size,
        })
    }

    /// The size that all wires agree on best.
    fn combined(&self, opinions: Vec<Opinion>, before: f64) -> Estimate {
        let (low, high) = self.parameter.plausible;
        let scale = high.max(-low);
        // as the search for effects believes of any of them
        let pull = 0.05;
        let known: f64 = opinions.iter().map(|opinion| opinion.known).sum();
        let size = opinions.iter().map(|opinion| opinion.known * opinion.size).sum::<f64>() / (known + pull);
        let apart: f64 = opinions.iter().map(|opinion| opinion.known * (opinion.size - size).powi(2)).sum();
        let price = 0.5 * (pull / (known + pull)).ln() - 0.5 * pull * size * size;
        let peaks: f64 = opinions.iter().map(|opinion| opinion.peak).sum();
        // wires that disagree know less than each of them says
        let doubt = (apart / (opinions.len().max(2) - 1) as f64).max(1.0);
        let reach = Z90 * (doubt / known).sqrt();
        let interval = |size: f64, reach: f64| [size, size - reach, size + reach].map(|size| scale * size);
        let [value, low, high] = interval(size, reach);
        let estimate = Estimate {
            value,
            low,
            high,
            by_wire: opinions.iter().map(|opinion| interval(opinion.size, Z90 / opinion.known.sqrt())).collect(),
            rise: peaks - 0.5 * apart + price - before,
            price,
            fits: opinions.into_iter().map(|opinion| opinion.fit).collect(),
        };
        // a refit may end better for other reasons
        Estimate { rise: estimate.rise.min(estimate.weight()), ..estimate }
    }
}
