//! Rapid heating (table 5): full power to a wire that has to shorten, until just below the temperature at which it would.
//!
//! Not a law but a phase before any law. Below its transformation a wire does not respond, and a law that waits for a response
//! wastes the time; how far full power is safe follows from the estimated temperature, or, with only a
//! calibrated model of the cold wire, from its resistance (resistance priming).

use crate::demand::Demand;
use crate::wire_map::WireMap;

/// How far below its heating curve a wire is handed over, in widths 1/k_A of the curve.
const SHORT_OF: f64 = 1.0;
/// How far below that it has to be to be taken back, in widths: noise of the phase is no reason.
const TAKEN_BACK: f64 = 4.0;
/// Where the transformation of a martensitic wire begins, in widths below the centre of its heating curve: 2 % has changed.
const BEGINS: f64 = 4.0;
/// Error, in strokes, below which a wire is left to its law.
const WORTH_IT: f64 = 0.02;

/// The condition to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Priming {
    /// The estimated temperature, against the heating curve at the estimated phase: also across the hysteresis.
    Temperature,
    /// The measured resistance, against that of the cold wire heated to where its transformation begins: from cold only.
    Resistance,
}

/// Where a wire is handed over to its law, and where it is taken back from it.
#[derive(Debug, Clone, Copy)]
struct Handover {
    to_law: f64,
    back: f64,
}

impl Handover {
    fn now(&self, acting: bool) -> f64 {
        if acting { self.to_law } else { self.back }
    }
}

/// Full power until just below the transformation.
#[derive(Debug, Clone)]
pub(crate) struct RapidHeating {
    by: Priming,
    /// Least error, m.
    worth: f64,
    /// Temperatures below the curve, K.
    margin_k: Handover,
    /// Resistances of a martensitic wire, Ω.
    resistance_ohm: Handover,
    /// Shorter than this, in m, a wire has begun to transform, and its resistance says nothing of its temperature.
    cold: f64,
    acting: bool,
}

impl RapidHeating {
    pub fn new(map: &WireMap, by: Priming, stroke: f64) -> RapidHeating {
        let stress = map.stress(map.length * map.strain, 0.0);
        let at = |below: f64| {
            let temperature = map.heating_centre - below * map.heating_width + stress * map.shift;
            map.resistance(1.0, temperature, map.elongation(1.0, stress, temperature))
        };
        RapidHeating {
            by,
            worth: WORTH_IT * stroke,
            margin_k: Handover { to_law: SHORT_OF * map.heating_width, back: TAKEN_BACK * map.heating_width },
            resistance_ohm: Handover { to_law: at(BEGINS + SHORT_OF), back: at(BEGINS + TAKEN_BACK) },
            cold: map.length + map.elongation(1.0, stress, map.ambient) - WORTH_IT * stroke,
            acting: false,
        }
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.acting = false;
    }

    /// Whether the wire is to be heated as fast as it can be, whatever its law says.
    #[inline]
    pub fn acts(&mut self, demand: &Demand) -> bool {
        let wanted = demand.length_m - demand.reference_m > self.worth;
        // no number is no reason to heat
        let below = match self.by {
            Priming::Temperature => {
                let short_of = demand.estimate.heating_curve_c - demand.estimate.temperature_c;
                short_of > self.margin_k.now(self.acting)
            }
            Priming::Resistance => {
                demand.resistance_ohm < self.resistance_ohm.now(self.acting) && demand.length_m > self.cold
            }
        };
        self.acting = wanted && below;
        self.acting
    }
}
