//! Detects a jammed load: a wire that is surely hotter than its heating curve, and stands.
//!
//! A free wire that is hotter than its heating curve shortens: by its excess temperature over κ, the drag's share of the stress shift
//! (eq. 12, 51). One that is held goes up in stress instead, and its curves go up with it. From its length it looks like a wire on the
//! curve of its load's stress, tens of kelvins colder than it is.
//!
//! The temperature it is judged by is the least that power leaves in the wire, not an estimate that believes in the curve.

use sinew_control::StrokeRange;
use sinew_physics::formulas::{logit, stress_shift_k};
use sinew_physics::{Load, WireModel};

/// So much hotter than its curve, K, a wire has to be: what is not known of curve and air's temperature.
const MARGIN_K: f64 = 10.0;
/// Share of the stroke that a free wire would have moved by then, and within which one stands.
const EXPECTED: f64 = 0.1;
const STANDING: f64 = 0.05;
/// A phase this near to its end is taken for that, where its logarithm is.
const EDGE: f64 = 0.01;
/// Within this share of the stroke from its hot end a wire is as short as it gets.
const AT_END: f64 = 0.15;

/// What a period shows of a wire that may be jammed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// Temperature at the least, °C.
    pub least_c: f64,
    /// Temperature at the most, °C.
    pub most_c: f64,
    /// Martensite.
    pub martensite: f64,
    /// Observed length, m; NaN where none was measured.
    pub length_m: f64,
    /// Time since the last one, s.
    pub dt_s: f64,
}

/// Watches one wire whose load is known.
#[derive(Debug, Clone, Copy)]
pub struct JamWatch {
    /// Heating curve at half its phase and no stress, °C, its width, K, and what the load at rest adds, K: at the wire's own length, and per
    /// metre beyond it.
    centre_c: f64,
    width_k: f64,
    shift_k: f64,
    shift_k_per_m: f64,
    /// The wire's own length, m.
    length_m: f64,
    /// Excess temperature that drives one metre per second, K s/m.
    drag_k_s_per_m: f64,
    contracted_m: f64,
    expected_m: f64,
    standing_m: f64,
    /// Where it was when a free wire would have begun to move, how far that one would be, and whether this one is held.
    from_m: f64,
    moved_m: f64,
    is_held: bool,
}

impl JamWatch {
    /// The watch over a wire with this stroke; `None` where its load does not say when it has to move.
    pub fn of(model: &WireModel, stroke: &StrokeRange) -> Option<JamWatch> {
        let Load::SpringMassDamper { damping_n_s_per_m, spring_n_per_m, preload_n, .. } = model.load else {
            return None;
        };
        let (m, g, stroke_m) = (&model.material, &model.geometry, stroke.stroke_m().abs());
        let shift_k = |pull_n: f64| stress_shift_k(m.stress_shift_k_per_pa, pull_n / g.area_m2());
        Some(JamWatch {
            centre_c: m.austenite_temperature_c,
            width_k: 1.0 / m.heating_steepness_per_k,
            shift_k: shift_k(preload_n),
            shift_k_per_m: shift_k(spring_n_per_m),
            length_m: g.length_m,
            drag_k_s_per_m: shift_k(damping_n_s_per_m),
            contracted_m: stroke.hot_m + AT_END * stroke_m,
            expected_m: EXPECTED * stroke_m,
            standing_m: STANDING * stroke_m,
            from_m: f64::NAN,
            moved_m: 0.0,
            is_held: false,
        })
    }

    /// The heating curve (eq. 20) at this phase and the stress of the load at rest, as the rig file has it: what an estimator learns of it while a
    /// wire is jammed is the jam.
    #[inline]
    fn heating_curve_c(&self, martensite: f64, length_m: f64) -> f64 {
        let shift_k = self.shift_k + self.shift_k_per_m * (length_m - self.length_m);
        self.centre_c + self.width_k * logit(martensite.clamp(EDGE, 1.0 - EDGE)) + shift_k.max(0.0)
    }

    /// Whether the wire is held, by what was seen last.
    #[inline]
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// Takes one period in; whether the wire is held. Without a length nothing changes.
    #[inline]
    pub fn look(&mut self, stand: &Stand) -> bool {
        let &Stand { least_c, most_c, martensite, length_m, dt_s } = stand;
        if length_m.is_nan() {
            return self.is_held;
        }
        let heating_curve_c = self.heating_curve_c(martensite, length_m);
        let excess_k = least_c - heating_curve_c - MARGIN_K;
        let stands = (length_m - self.from_m).abs() < self.standing_m && length_m > self.contracted_m;
        // What is held stays so until it moves, or could not be hotter than its curve any more.
        self.is_held = self.is_held && stands && most_c > heating_curve_c;
        if !(self.is_held || (stands && excess_k > 0.0)) {
            (self.from_m, self.moved_m) = (length_m, 0.0);
            return false;
        }
        self.moved_m += excess_k.max(0.0) * dt_s / self.drag_k_s_per_m;
        self.is_held |= self.moved_m > self.expected_m;
        self.is_held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 K s/m, a stroke of 10 mm, a curve at 100 °C where it stands.
    const WATCH: JamWatch = JamWatch {
        centre_c: 70.0,
        width_k: 4.0,
        shift_k: 10.0,
        shift_k_per_m: 2500.0,
        length_m: 0.1,
        drag_k_s_per_m: 40.0,
        contracted_m: 0.1015,
        expected_m: 0.002,
        standing_m: 0.0005,
        from_m: f64::NAN,
        moved_m: 0.0,
        is_held: false,
    };
    const HOT: Stand = Stand { least_c: 150.0, most_c: 170.0, martensite: 0.5, length_m: 0.108, dt_s: 1e-3 };

    fn found_s(mut each: impl FnMut(f64) -> Stand) -> Option<f64> {
        let mut watch = WATCH;
        (0..1000).map(|k| f64::from(k) * 1e-3).find(|time_s| watch.look(&each(*time_s)))
    }

    #[test]
    fn a_hot_wire_that_stands_is_held_and_no_other() {
        // 2 mm at 1 m/s
        assert!(found_s(|_| HOT).is_some_and(|time_s| (1e-3..5e-3).contains(&time_s)));
        assert_eq!(found_s(|_| Stand { least_c: 109.0, ..HOT }), None, "not hot");
        assert_eq!(found_s(|_| Stand { length_m: 0.101, ..HOT }), None, "short");
        assert_eq!(found_s(|time_s| Stand { length_m: 0.11 - time_s.min(0.009), ..HOT }), None, "on its way");
        assert_eq!(found_s(|_| Stand { length_m: f64::NAN, ..HOT }), None, "not measured");
    }

    #[test]
    fn it_is_held_until_it_moves_or_must_be_cold() {
        let mut watch = WATCH;
        (0..100).for_each(|_| _ = watch.look(&HOT));
        assert!(watch.look(&Stand { least_c: 90.0, ..HOT }), "it may still be hot");
        assert!(watch.look(&Stand { length_m: f64::NAN, ..HOT }), "not seen");
        let mut moved = watch;
        assert!(!moved.look(&Stand { least_c: 90.0, length_m: 0.107, ..HOT }));
        assert!(!watch.look(&Stand { least_c: 90.0, most_c: 99.0, ..HOT }));
        assert!(!watch.look(&Stand { least_c: 90.0, ..HOT }), "and stays free");
    }
}
