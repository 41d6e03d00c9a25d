//! What is around a wire in the piece under way: air, sleeve and neighbour, and what they take of its heat.

use super::reference::{Reference, State, fitted_implicitness};
use crate::effects::thermal::{Around, HeatFlow, Skin, Thermal};
use crate::formulas::WORKING_EXCESS_K;

/// Bound of (T − T∞)/60 K in the closed forms.
const MOST_WARM: f64 = 20.0;

/// The start or the end of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum At {
    Start,
    End,
}

/// A quantity at the start and at the end of a piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Both {
    pub(crate) start: f64,
    pub(crate) end: f64,
}

impl Both {
    /// The same at both.
    pub(crate) fn same(value: f64) -> Both {
        Both { start: value, end: value }
    }

    fn at(&self, at: At) -> f64 {
        match at {
            At::Start => self.start,
            At::End => self.end,
        }
    }
}

/// T_s as a straight line in the temperature T of the wire in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sleeve {
    /// At T = 0 °C, °C.
    pub(crate) base: f64,
    /// K per K of T.
    pub(crate) per_k: f64,
}

/// A loss besides the mechanisms': fixed + per_k T + linear τ + square τ², τ = (T − T∞)/60 K, in W.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extra {
    pub(crate) fixed: f64,
    pub(crate) per_k: f64,
    /// `None` where nothing depends on T.
    pub(crate) form: Option<ExtraForm>,
}

/// Its part that depends on T, in W.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExtraForm {
    pub(crate) linear: f64,
    pub(crate) square: f64,
}

/// What is around a wire, and how that has changed.
#[derive(Debug, Clone)]
pub(crate) struct Air {
    thermal: Thermal,
    /// Temperature of the neighbouring wire, °C; ambient where nobody says.
    pub(crate) neighbour_c: Option<f64>,
    /// Factor on h of air that moves because somebody says so, besides `thermal.draught`.
    pub(crate) stirred: f64,
    /// Temperature of the sleeve now and at the start of the simulation, °C.
    sleeve_c: f64,
    first_sleeve_c: f64,
    /// T∞ in the piece, °C.
    ambient: Both,
    /// Factor on h in the piece.
    draught: Both,
    /// T_s at the end of the piece.
    sleeve_ahead: Sleeve,
    /// What no mechanism explains of the loss.
    pub(crate) extra: Extra,
}

impl Air {
    pub(crate) fn new(thermal: Thermal) -> Air {
        Air {
            thermal,
            neighbour_c: None,
            stirred: 1.0,
            sleeve_c: 0.0,
            first_sleeve_c: 0.0,
            ambient: Both::same(0.0),
            draught: Both::same(1.0),
            sleeve_ahead: Sleeve { base: 0.0, per_k: 0.0 },
            extra: Extra { fixed: 0.0, per_k: 0.0, form: None },
        }
    }

    /// Starts beside a wire at rest.
    pub(crate) fn settle(&mut self, temperature: f64, ambient: f64) {
        self.ambient = Both::same(ambient);
        self.sleeve_c = self.thermal.sheath.settled(temperature, ambient);
        self.first_sleeve_c = self.sleeve_c;
    }

    /// T∞ over the piece from `t0` to `t1` s, where the recording has `ambient`.
    pub(crate) fn ambient_over(&self, ambient: f64, t0: f64, t1: f64) -> Both {
        Both { start: self.thermal.ambient(ambient, t0), end: self.thermal.ambient(ambient, t1) }
    }

    /// Prepares the piece from `t0` to `t1` s, `h` s long, that begins in `start`.
    pub(crate) fn begin(&mut self, start: &State, h: f64, (t0, t1): (f64, f64), ambient: Both, extra: Extra) {
        let draught = |t: f64| self.stirred * self.thermal.stirring(t);
        self.draught = Both { start: draught(t0), end: draught(t1) };
        self.ambient = ambient;
        self.sleeve_ahead = self.follow(start, h);
        self.extra = extra;
    }

    /// Closes the piece for a wire that got to `temperature`; returns the heat the sleeve kept of it, J.
    pub(crate) fn finish(&mut self, temperature: f64) -> Option<f64> {
        self.thermal.sheath.is_on().then(|| {
            let sleeve = self.sleeve(temperature, At::End).base;
            let kept = self.thermal.sheath.heat_capacity_j_per_k * (sleeve - self.sleeve_c);
            self.sleeve_c = sleeve;
            kept
        })
    }

    /// Heat in the sleeve since the start, J.
    pub(crate) fn sheath_j(&self) -> f64 {
        self.thermal.sheath.heat_capacity_j_per_k * (self.sleeve_c - self.first_sleeve_c)
    }

    /// T_s at the end of the piece as a straight line in T: the fitted method on C Ṫ_s = k_i (T − T_s) − k_o (T_s − T∞).
    fn follow(&self, start: &State, h: f64) -> Sleeve {
        let sheath = &self.thermal.sheath;
        if !sheath.is_on() {
            return Sleeve { base: 0.0, per_k: 0.0 };
        }
        let sleeve = self.sleeve_c;
        let stirred = self.thermal.convection(sleeve - self.ambient.start);
        let inner = sheath.inner_w_per_k;
        let outer = |draught: f64| sheath.outer_w_per_k * draught * stirred;
        let (outer_start, outer_end) = (outer(self.draught.start), outer(self.draught.end));
        let capacity = sheath.heat_capacity_j_per_k;
        let late = fitted_implicitness(h * (inner + outer_end) / capacity) * h;
        let flow = inner * (start.temperature - sleeve) - outer_start * (sleeve - self.ambient.start);
        let whole = capacity + late * (inner + outer_end);
        Sleeve {
            base: (capacity * sleeve + (h - late) * flow + late * outer_end * self.ambient.end) / whole,
            per_k: late * inner / whole,
        }
    }

    /// T_s at the start or the end of the piece, where the wire is at `temperature`, as [`Air::surface`] wants it.
    pub(crate) fn sleeve(&self, temperature: f64, at: At) -> Sleeve {
        let base = match at {
            At::Start => self.sleeve_c,
            At::End => self.sleeve_ahead.base + self.sleeve_ahead.per_k * temperature,
        };
        Sleeve { base, per_k: 0.0 }
    }

    /// T_s at the end of the piece, in whatever way the wire's temperature goes.
    pub(crate) fn sleeve_ahead(&self) -> Sleeve {
        self.sleeve_ahead
    }

    /// T∞ at the start or the end of the piece, °C.
    pub(crate) fn ambient(&self, at: At) -> f64 {
        self.ambient.at(at)
    }

    /// Loss through the film of a wire `above` its air.
    pub(crate) fn film(&self, reference: &Reference, above: f64, at: At) -> HeatFlow {
        self.thermal.film(&reference.skin, above, self.draught.at(at))
    }

    /// All that a wire at `temperature` loses through its surface, with the sleeve as given.
    pub(crate) fn surface(&self, skin: &Skin, temperature: f64, at: At, sleeve: Sleeve) -> HeatFlow {
        let around = Around {
            ambient: self.ambient.at(at),
            stirred: self.draught.at(at),
            sleeve: sleeve.base,
            sleeve_per_k: sleeve.per_k,
            neighbour: self.neighbour_c,
        };
        let mut flow = self.thermal.losses(skin, temperature, &around);
        flow.watts += self.extra.fixed + self.extra.per_k * temperature;
        flow.per_k += self.extra.per_k;
        let Some(ExtraForm { linear, square }) = self.extra.form else { return flow };
        let tau = (temperature - around.ambient) / WORKING_EXCESS_K;
        let bounded = tau.clamp(-MOST_WARM, MOST_WARM);
        flow.watts += (linear + square * bounded) * bounded;
        if bounded == tau {
            flow.per_k += (linear + 2.0 * square * tau) / WORKING_EXCESS_K;
        }
        flow
    }
}
