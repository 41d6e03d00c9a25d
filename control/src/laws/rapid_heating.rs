//! Rapid heating (table 5): full power to a wire that has to shorten, until just below the temperature at which it would.
//!
//! Not a law but what any law can be preceded by. Below its transformation a wire answers nothing, and a law that waits for an answer, or
//! is afraid of one, wastes the time; how far full power is safe can be told from the estimated temperature, or, with nothing but a
//! calibrated model of the cold wire, from its resistance (resistance priming).

use crate::Demand;
use crate::wire_map::WireMap;

/// How far below its heating curve a wire is handed over, in widths 1/k_A of the curve.
const SHORT_OF: f64 = 1.0;
/// Where the transformation of a martensitic wire begins, in widths below the centre of its heating curve: 2 % has changed.
const BEGINS: f64 = 4.0;
/// Error, in strokes, below which a wire is left to its law.
const WORTH_IT: f64 = 0.02;

/// What tells when to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Priming {
    /// The estimated temperature, against the heating curve at the estimated phase: also across the hysteresis.
    Temperature,
    /// The measured resistance, against that of the cold wire heated to where its transformation begins: from cold only.
    Resistance,
}

/// Full power until just below the transformation.
#[derive(Debug, Clone)]
pub(crate) struct RapidHeating {
    by: Priming,
    /// Least error, m.
    worth: f64,
    /// Temperature kept below the curve, K.
    margin: f64,
    /// Resistance at which a martensitic wire is handed over, Ω.
    resistance: f64,
    /// Its length without a load that moves, m: what is shorter has begun to transform.
    cold: f64,
}

impl RapidHeating {
    pub fn new(map: &WireMap, by: Priming, stroke: f64) -> RapidHeating {
        let elongation = map.length * map.strain;
        let stress = map.stress(elongation, 0.0);
        let begins = map.heating_centre - BEGINS * map.heating_width + stress * map.shift;
        let elongation = map.elongation(1.0, stress, begins);
        RapidHeating {
            by,
            worth: WORTH_IT * stroke,
            margin: SHORT_OF * map.heating_width,
            resistance: map.resistance(1.0, begins, elongation),
            cold: map.length + elongation - WORTH_IT * stroke,
        }
    }

    /// Whether the wire is to be heated as fast as it can be, whatever its law says.
    #[inline]
    pub fn acts(&self, demand: &Demand) -> bool {
        demand.length_m - demand.reference_m > self.worth
            && match self.by {
                // no number is no reason to heat
                Priming::Temperature => demand.estimate.temperature_c < demand.estimate.heating_curve_c - self.margin,
                Priming::Resistance => demand.resistance_ohm < self.resistance && demand.length_m > self.cold,
            }
    }
}
