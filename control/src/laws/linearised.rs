//! Input–output linearisation (chapter 10, eq. 55–59): the power that makes length an integral of what is asked for.
//!
//! Differentiated until the power appears, the length obeys M x⃛ + B ẍ + (K + K_SMA) ẋ = K_SMA L ε_L (∂ξ/∂T) Ṫ with Q Ṫ = P − h A_s (T − T_∞).
//! P = α u + β with α the inverse of that gain and β the heat loss (eq. 58) leaves 1/s times the load's own modes (eq. 59), which a
//! proportional u = λ(x − x_ref) closes. Far from the transformation ∂ξ/∂T vanishes and α with it grows beyond use; the thesis
//! finds a constant slope to do as well, because β is what counts.

use crate::demand::Range;
use crate::wire_map::WireMap;
use crate::{Controller, Demand};

/// The thesis' constant |∂ξ/∂T|, 1/K.
pub const CONSTANT_SLOPE_PER_K: f64 = 0.05;

/// Which ∂ξ/∂T is inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slope {
    /// That of the branch of the hysteresis the wire is on, as estimated.
    Estimated,
    /// [`CONSTANT_SLOPE_PER_K`].
    Constant,
}

/// P = α λ(x − x_ref) + β.
#[derive(Debug, Clone)]
pub struct InputOutputLinearised {
    map: WireMap,
    lambda: f64,
    slope: Slope,
    /// Whether β is in: left out only to show what it is worth.
    feedforward: bool,
    range: Range,
    blind: bool,
}

impl InputOutputLinearised {
    pub(crate) fn new(map: WireMap, lambda: f64, slope: Slope, feedforward: bool, range: Range) -> Self {
        InputOutputLinearised { map, lambda, slope, feedforward, range, blind: false }
    }
}

impl Controller for InputOutputLinearised {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        let seen = &demand.estimate;
        self.blind = !demand.is_usable() || !seen.is_usable();
        if self.blind {
            return self.range.minimum;
        }
        let shorten = self.lambda * (seen.length_m - demand.reference_m);
        let slope = match self.slope {
            Slope::Estimated => self.map.slope_here(shorten > 0.0, seen),
            Slope::Constant => CONSTANT_SLOPE_PER_K,
        };
        let offset = if self.feedforward { seen.loss_w } else { 0.0 };
        self.range.give((self.map.heat_per_metre(slope, seen) * shorten + offset) / seen.full_power_w)
    }

    fn reset(&mut self) {
        self.range.reset();
        self.blind = false;
    }

    fn surface(&self) -> f64 {
        0.0
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}
