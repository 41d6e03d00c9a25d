//! Detects heat without motion while derating keeps the wire too cool for [`SlideWatch`](sinew_sensing::SlideWatch).
//!
//! `SlideWatch` proves by bounds that a length cannot be the wire's, and for that the wire has to get
//! hotter than a derated one does. The remaining case is: a wire commanded to another length fills its budget until the
//! supervisor derates it, and since the command, or since the budget was last a third empty, its measured length has not moved
//! and is not contracted. A third of the budget takes a wire across its hysteresis. Either the length is not the wire's (a tap sticks), or the wire is held (its load is jammed, or
//! the air takes all its heat); from voltages alone these cannot be distinguished, because heat, stress and phase change the
//! resistance alike. A wire in a strong draught moves before it stops, which distinguishes it from these.

use sinew_control::StrokeRange;

/// Share of the heat budget below which a wire starts afresh.
const RESTED: f64 = 0.65;
/// So long it has to be derated without having moved, s.
const LASTS_S: f64 = 1.0;
/// Share of the stroke that is motion: ten times the noise of an observed length.
const MOVED: f64 = 0.05;
/// Within this share of the stroke from the hot end a length is contracted, and within this from its target it is there.
const AT_END: f64 = 0.15;

/// Watches one channel that is derated.
#[derive(Debug, Clone)]
pub struct Standstill {
    contracted_m: f64,
    moved_m: f64,
    near_m: f64,
    /// What it was told when the watch began, and where it has been since.
    target_m: f64,
    shortest_m: f64,
    longest_m: f64,
    derated_s: f64,
    /// Whether the watch began with a third of the budget left: else standing says nothing.
    began_rested: bool,
}

impl Standstill {
    /// A watch over a wire with this stroke.
    pub fn new(stroke: &StrokeRange) -> Standstill {
        let stroke_m = stroke.stroke_m().abs();
        Standstill {
            contracted_m: stroke.hot_m + AT_END * stroke_m,
            moved_m: MOVED * stroke_m,
            near_m: AT_END * stroke_m,
            target_m: f64::NAN,
            shortest_m: f64::NAN,
            longest_m: f64::NAN,
            derated_s: 0.0,
            began_rested: false,
        }
    }

    /// Takes one cycle: how full the heat budget is, whether the duty is derated, the observed length, and the length it is
    /// told to take (NaN where it is told a duty). True once the length cannot be a free wire's.
    #[inline]
    pub fn is_held(&mut self, filled: f64, derated: bool, length_m: f64, target_m: f64, dt_s: f64) -> bool {
        // NaN counts as a new command, but an unchanged duty does not.
        let told = !((target_m - self.target_m).abs() < self.moved_m || (target_m.is_nan() && self.target_m.is_nan()));
        if filled < RESTED || told || self.longest_m.is_nan() {
            (self.target_m, self.shortest_m, self.longest_m, self.derated_s) = (target_m, length_m, length_m, 0.0);
            self.began_rested = filled < RESTED;
            return false;
        }
        self.shortest_m = self.shortest_m.min(length_m);
        self.longest_m = self.longest_m.max(length_m);
        let stands = self.longest_m - self.shortest_m < self.moved_m;
        // A wire that is where it should be, or as short as it gets, has no reason to move.
        let there = length_m < self.contracted_m || (length_m - target_m).abs() < self.near_m;
        self.derated_s = if derated && self.began_rested && stands && !there { self.derated_s + dt_s } else { 0.0 };
        self.derated_s > LASTS_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_derated_wire_that_never_moved_and_is_not_there_is_held() {
        let stroke = StrokeRange { hot_m: 0.160, cold_m: 0.166 };
        let seconds = |derated: bool, target_m: f64, length_m: f64, drift_m_s: f64| {
            let mut watch = Standstill::new(&stroke);
            (0..10_000)
                .find(|k| {
                    let time_s = f64::from(*k) * 1e-3;
                    watch.is_held(0.3 + time_s, derated, length_m + drift_m_s * time_s, target_m, 1e-3)
                })
                .map(|k| f64::from(k) * 1e-3)
        };
        let soon = |s: f64| (1.1..1.4).contains(&s);
        assert!(seconds(true, 0.161, 0.164, 0.0).is_some_and(soon));
        assert!(seconds(true, f64::NAN, 0.164, 0.0).is_some_and(soon), "told a duty");
        assert_eq!(seconds(false, 0.161, 0.164, 0.0), None, "not derated");
        assert_eq!(seconds(true, 0.161, 0.1605, 0.0), None, "contracted");
        assert_eq!(seconds(true, 0.1645, 0.164, 0.0), None, "where it should be");
        assert_eq!(seconds(true, 0.161, 0.1655, -1e-3), None, "on its way");
        assert_eq!(seconds(true, 0.161, f64::NAN, 0.0), None, "not measured");
    }
}
