//! Binary segments (chapter 6, fig. 66): one of several pieces of a wire, of doubled lengths, that is heated wholly or not at all.
//!
//! n pieces in series, each twice as long as the one before, give 2ⁿ lengths. Each is surely austenite or surely martensite, so
//! nothing has to be balanced and no length has to be measured: a stepper motor where a controlled wire is a servo. Every piece
//! is a channel with this law and is told the same stroke of the whole; it heats if its binary digit of that stroke is one.

use crate::demand::{Demand, Law, Range};
use crate::stroke::StrokeRange;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Which piece a wire is of, and of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment {
    /// Its binary digit: 0 = the shortest piece, the last of them the longest.
    pub digit: u32,
    /// How many pieces there are.
    pub digits: u32,
}

impl Default for Segment {
    /// The only one.
    fn default() -> Segment {
        Segment { digit: 0, digits: 1 }
    }
}

impl Segment {
    /// Most pieces: more are shorter than the error of the longest.
    pub const MOST: u32 = 12;
}

/// How far above the centre of its heating curve a piece is heated, in widths 1/k_A: 0.1 % of it is left martensite.
const SURELY_AUSTENITE: f64 = 7.0;
/// A stroke must be so far beyond the middle between two lengths before the other one is taken, in steps: noise is no reason.
const BEYOND: f64 = 0.1;
/// How fast the temperature is brought to where it is held, in s.
const SETTLES_S: f64 = 0.05;

/// Full power until a piece is surely austenite, then what keeps it so; or nothing.
#[derive(Debug, Clone)]
pub struct BinarySegment {
    segment: Segment,
    stroke: StrokeRange,
    map: WireMap,
    range: Range,
    /// The length that is taken, in steps of the shortest piece; `None` before the first.
    level: Option<f64>,
}

impl BinarySegment {
    pub(crate) fn new(model: &WireModel, map: WireMap, segment: Segment, range: Range) -> BinarySegment {
        let digits = segment.digits.clamp(1, Segment::MOST);
        let segment = Segment { digit: segment.digit.min(digits - 1), digits };
        // a model that is no wire has no stroke, and is never heated
        let stroke = StrokeRange::of(model).unwrap_or(StrokeRange { cold_m: f64::NAN, hot_m: f64::NAN });
        BinarySegment { segment, stroke, map, range, level: None }
    }

    /// The length that this reference asks for, in steps of the shortest piece.
    fn level(&mut self, reference_m: f64) -> f64 {
        let most = f64::from((1u32 << self.segment.digits) - 1);
        let exact = (self.stroke.stroke(reference_m) * most).clamp(0.0, most);
        let level = match self.level {
            Some(level) if (exact - level).abs() <= 0.5 + BEYOND => level,
            _ => exact.round(),
        };
        self.level = Some(level);
        level
    }
}

impl Law for BinarySegment {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        let seen = &demand.estimate;
        if !demand.is_usable() || !(seen.temperature_c + seen.stress_pa + seen.loss_w + seen.full_power_w).is_finite() {
            return None;
        }
        let level = self.level(demand.reference_m);
        if level.is_nan() || (level as u32 >> self.segment.digit) & 1 == 0 {
            return Some(self.range.give(self.range.minimum));
        }
        let map = &self.map;
        let hot = map.heating_centre + seen.stress_pa * map.shift + SURELY_AUSTENITE * map.heating_width;
        let power = seen.loss_w + (hot - seen.temperature_c) * map.heat_capacity / SETTLES_S;
        Some(self.range.give(power / seen.full_power_w.max(1e-9)))
    }

    fn reset(&mut self) {
        self.level = None;
        self.range.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::estimate::Estimate;
    use crate::testing::{standing, wire};

    fn piece(digit: u32, digits: u32) -> BinarySegment {
        let range = Range::new(0.02, 0.7, Modulation::Switched);
        BinarySegment::new(&wire(), WireMap::new(&wire()), Segment { digit, digits }, range)
    }

    /// Duty at this stroke of the whole, of a piece at this temperature.
    fn duty(piece: &mut BinarySegment, stroke: f64, temperature_c: f64) -> Option<f64> {
        let reference_m = piece.stroke.length_m(stroke);
        let estimate =
            Estimate { temperature_c, stress_pa: 1.6e8, loss_w: 0.3, full_power_w: 3.0, ..Estimate::UNKNOWN };
        piece.duty(&Demand { estimate, ..standing(reference_m, 0.16) })
    }

    #[test]
    fn a_stroke_is_the_sum_of_its_digits() {
        for level in 0..16u32 {
            let sum: u32 = (0..4)
                .map(|digit| u32::from(duty(&mut piece(digit, 4), f64::from(level) / 15.0, 25.0) == Some(0.7)) << digit)
                .sum();
            assert_eq!(sum, level);
        }
    }

    #[test]
    fn it_is_held_where_it_is_surely_austenite_and_not_beyond() {
        let mut piece = piece(0, 1);
        let hot = piece.map.heating_centre + 1.6e8 * piece.map.shift + 7.0 * piece.map.heating_width;
        assert!(hot > piece.map.heating_centre + 15.0 && hot < 140.0, "{hot}");
        assert_eq!(duty(&mut piece, 1.0, hot - 20.0), Some(0.7));
        let held = duty(&mut piece, 1.0, hot).unwrap();
        assert!((held - 0.1).abs() < 1e-9, "{held}");
        assert_eq!(duty(&mut piece, 1.0, hot + 5.0), Some(0.02));
        assert_eq!(duty(&mut piece, 1.0, f64::NAN), None, "what is not known is not heated");
    }

    #[test]
    fn noise_between_two_lengths_changes_nothing() {
        let mut piece = piece(0, 2);
        assert_eq!(duty(&mut piece, 0.49 / 3.0, 25.0), Some(0.02));
        assert_eq!(duty(&mut piece, 0.55 / 3.0, 25.0), Some(0.02));
        assert_eq!(duty(&mut piece, 0.65 / 3.0, 25.0), Some(0.7));
        assert_eq!(duty(&mut piece, 0.45 / 3.0, 25.0), Some(0.7));
        assert_eq!(duty(&mut piece, 0.35 / 3.0, 25.0), Some(0.02));
    }
}
