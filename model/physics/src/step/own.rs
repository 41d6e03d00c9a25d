//! Laws that users wrote, as they act from piece to piece: each a tangent at the start of the piece in what is solved with its
//! end, so that a term that pulls hard does not ring.

use crate::effects::own::{
    Entry, Law, MARTENSITE, MOST_KEYS, POSITION, QUANTITIES, Quantities, STRESS, TEMPERATURE, VELOCITY,
};
use crate::model::WireModel;
use crate::signals::Outputs;

/// No state of a law goes beyond this, in SI.
const MOST_STATE: f64 = 1e12;

/// The laws of one wire and what they remember.
#[derive(Debug, Clone)]
pub(crate) struct OwnTerms {
    laws: Vec<Running>,
    /// A_c in m², L_0 in m, d in m, A_s in m², m in kg.
    pub(crate) size: Size,
    /// At the start of the piece.
    start: Quantities,
    now: Sums,
    undefined: Option<Undefined>,
}

/// Size of the wire.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Size {
    pub(crate) area: f64,
    pub(crate) length: f64,
    pub(crate) diameter: f64,
    pub(crate) surface: f64,
    pub(crate) mass: f64,
}

/// A formula of a law that was not defined where the simulation went: no number came of it, and it counted as zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undefined {
    /// Its id.
    pub law: &'static str,
    /// When first, s since the start.
    pub time_s: f64,
}

/// A law with the values its formulas are over: quantities, parameters, states.
#[derive(Debug, Clone)]
struct Running {
    law: &'static Law,
    values: Vec<f64>,
    /// The states at the start of the piece; among `values` they are as far as the term wants them.
    states: Vec<f64>,
}

/// What the laws come to in a piece: sums at its start, and their derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// Heat into the wire, W, and per K of its temperature.
    pub(crate) heat: f64,
    pub(crate) heat_per_k: f64,
    /// Shift of the driving temperature, K.
    pub(crate) shift: f64,
    /// Strain, and per Pa and per ξ.
    pub(crate) strain: f64,
    pub(crate) strain_per_pa: f64,
    pub(crate) strain_per_fraction: f64,
    /// Force on the load, N, and per m and m/s.
    pub(crate) force: f64,
    pub(crate) force_per_m: f64,
    pub(crate) force_per_m_s: f64,
}

impl Sums {
    /// Strain at no stress and no martensite, in a piece that begins in `stress` and `martensite`.
    pub(crate) fn fixed_strain(&self, stress: f64, martensite: f64) -> f64 {
        self.strain - self.strain_per_pa * stress - self.strain_per_fraction * martensite
    }
}

impl OwnTerms {
    /// The laws of `model` that act; `None` where none does.
    pub(crate) fn of(model: &WireModel) -> Option<OwnTerms> {
        let laws: Vec<Running> = model
            .effects
            .own
            .acting()
            .in_si()
            .map(|(law, parameters)| {
                let start = law.definition.states.iter().zip(&law.states).map(|(state, (si, _))| state.start * si);
                let states: Vec<f64> = start.collect();
                let values = QUANTITIES.iter().map(|_| 0.0).chain(parameters).chain(states.iter().copied()).collect();
                Running { law, values, states }
            })
            .collect();
        let g = &model.geometry;
        let size = Size {
            area: g.area_m2(),
            length: g.length_m,
            diameter: g.diameter_m,
            surface: g.surface_m2(),
            mass: g.volume_m3() * model.material.density_kg_per_m3,
        };
        let nothing = [0.0; QUANTITIES.len()];
        (!laws.is_empty()).then(|| OwnTerms { laws, size, start: nothing, now: Sums::default(), undefined: None })
    }

    /// What they come to in the piece under way.
    pub(crate) fn now(&self) -> &Sums {
        &self.now
    }

    /// The first formula that was not defined.
    pub(crate) fn undefined(&self) -> Option<Undefined> {
        self.undefined
    }

    /// Prepares a piece of `h` s that begins with these quantities, its load moving at `velocity`.
    pub(crate) fn begin(&mut self, quantities: Quantities, velocity: f64, h: f64) {
        self.start = quantities;
        let mut now = Sums::default();
        for running in &mut self.laws {
            running.values[..QUANTITIES.len()].copy_from_slice(&quantities);
            // heat is of the whole piece, everything else is solved at its end
            running.look_ahead(if running.law.definition.enters == Entry::Heat { 0.5 * h } else { h });
            match running.law.definition.enters {
                Entry::Heat => {
                    let (value, per_k) = running.tangent(TEMPERATURE);
                    now.heat += value;
                    now.heat_per_k += per_k;
                }
                Entry::DrivingTemperature => now.shift += running.value(),
                Entry::Strain => {
                    let (value, per_pa) = running.tangent(STRESS);
                    now.strain += value;
                    now.strain_per_pa += per_pa;
                    // ξ and 1 − ξ move together
                    now.strain_per_fraction += running.tangent(MARTENSITE).1 - running.tangent(MARTENSITE + 1).1;
                }
                Entry::Force => {
                    running.values[VELOCITY] = velocity;
                    let (value, per_m) = running.tangent(POSITION);
                    now.force += value;
                    now.force_per_m += per_m;
                    now.force_per_m_s += running.tangent(VELOCITY).1;
                }
                Entry::Resistivity
                | Entry::ShownPosition
                | Entry::ShownForce
                | Entry::ShownCurrent
                | Entry::ShownV1
                | Entry::ShownV2
                | Entry::ShownV3 => {}
            }
        }
        self.now = now;
    }

    /// Closes the piece of `h` s that ended with these quantities, at `time` s: what is remembered goes on by exponential Euler
    /// steps at the mean of both ends.
    pub(crate) fn finish(&mut self, quantities: &Quantities, h: f64, time: f64) {
        for running in &mut self.laws {
            let mean = self.start.iter().zip(quantities).map(|(start, end)| 0.5 * (start + end));
            running.values.iter_mut().zip(mean).for_each(|(value, mean)| *value = mean);
            let defined = running.look_ahead(h) & running.law.formula.value(&running.values).is_finite();
            running.arrive();
            if !defined && self.undefined.is_none() {
                self.undefined = Some(Undefined { law: running.law.id(), time_s: time });
            }
        }
    }

    /// Whether some law enters there.
    pub(crate) fn enters(&self, entry: Entry) -> bool {
        self.laws.iter().any(|running| running.law.definition.enters == entry)
    }

    /// Sum of the laws that enter there, at these quantities.
    pub(crate) fn sum(&self, entry: Entry, quantities: &Quantities) -> f64 {
        let of = self.laws.iter().filter(|running| running.law.definition.enters == entry);
        of.map(|running| running.value_at(quantities)).sum()
    }

    /// Adds what sensors show too much, at these quantities.
    pub(crate) fn show(&self, quantities: &Quantities, o: &mut Outputs) {
        for running in &self.laws {
            let shown = match running.law.definition.enters {
                Entry::ShownPosition => &mut o.position_m,
                Entry::ShownForce => &mut o.force_n,
                Entry::ShownCurrent => &mut o.current_a,
                Entry::ShownV1 => &mut o.v1_v,
                Entry::ShownV2 => &mut o.v2_v,
                Entry::ShownV3 => &mut o.v3_v,
                Entry::Heat | Entry::DrivingTemperature | Entry::Strain | Entry::Force | Entry::Resistivity => continue,
            };
            *shown += running.value_at(quantities);
        }
    }
}

impl Running {
    fn value(&self) -> f64 {
        self.bounded(self.law.formula.value(&self.values), 0.0).0
    }

    /// The term and its derivative by one of the quantities.
    fn tangent(&self, by: usize) -> (f64, f64) {
        match self.law.formula.uses(by) {
            true => {
                let (value, slope) = self.law.formula.tangent(&self.values, by);
                self.bounded(value, slope)
            }
            false => (self.value(), 0.0),
        }
    }

    /// The term at other quantities, with the present states.
    fn value_at(&self, quantities: &Quantities) -> f64 {
        let mut values = [0.0; MOST_VALUES];
        let values = &mut values[..self.values.len()];
        values.copy_from_slice(&self.values);
        values[..QUANTITIES.len()].copy_from_slice(quantities);
        self.bounded(self.law.formula.value(values), 0.0).0
    }

    /// A term that is a number within its bounds: beyond them it is constant, and none is zero.
    fn bounded(&self, value: f64, slope: f64) -> (f64, f64) {
        let most = self.law.definition.enters.most();
        match (value.is_finite(), value.abs() <= most && slope.is_finite()) {
            (false, _) => (0.0, 0.0),
            (true, true) => (value, slope),
            (true, false) => (value.clamp(-most, most), 0.0),
        }
    }

    /// Where the states go in `h` s at the present quantities; false where a rate is no number, and the state stays.
    fn look_ahead(&mut self, h: f64) -> bool {
        if self.states.is_empty() {
            return true;
        }
        let first = self.values.len() - self.states.len();
        self.values[first..].copy_from_slice(&self.states);
        let mut ahead = [0.0; MOST_KEYS];
        let mut defined = true;
        for (i, (_, rate)) in self.law.states.iter().enumerate() {
            let (speed, per_state) = rate.tangent(&self.values, first + i);
            // s' = speed + per_state (s − s_0), solved as it is; what grows by itself is taken to grow in a straight line
            let growth = (if per_state.is_finite() { per_state } else { 0.0 }).min(0.0) * h;
            let factor = if growth.abs() < 1e-8 { 1.0 } else { growth.exp_m1() / growth };
            let moved = self.states[i] + h * factor * speed;
            defined &= moved.is_finite();
            ahead[i] = if moved.is_finite() { moved.clamp(-MOST_STATE, MOST_STATE) } else { self.states[i] };
        }
        self.values[first..].copy_from_slice(&ahead[..self.states.len()]);
        defined
    }

    /// The states are where they were going.
    fn arrive(&mut self) {
        let first = self.values.len() - self.states.len();
        self.states.copy_from_slice(&self.values[first..]);
    }
}

/// Quantities, parameters and states of a law, at most.
const MOST_VALUES: usize = QUANTITIES.len() + MOST_KEYS;
