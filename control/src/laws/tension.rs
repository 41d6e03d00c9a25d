//! Limits of the tension around any law (table 5: anti-slack, anti-overload [146, 147]).
//!
//! The tension is not measured; it follows from the load at the estimated length (eq. 51). A load with a spring pulls the harder
//! the shorter the wire is, so heat controls the tension: near the upper limit a wire is heated only to the
//! tension it will have at rest, below the lower limit it is heated without a setpoint. Where the load has no
//! spring heat cannot change the tension, and only the drag of a moving load can be limited.

use crate::estimate::Estimate;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Rate at which a limit is approached and a tension outside is brought back, 1/s.
const RATE: f64 = 10.0;
/// Rate at which a wire below its heating curve may be, or is, brought there, 1/s.
const CROSS_RATE: f64 = 50.0;
/// A spring softer than this changes no tension, N/m.
const LEAST_SPRING: f64 = 1e-3;

/// Bounds of the tension of one wire in its load.
#[derive(Debug, Clone)]
pub struct TensionLimits {
    map: WireMap,
    minimum_n: f64,
    maximum_n: f64,
    limited: bool,
}

impl TensionLimits {
    /// The limits of a wire; `None` where there are none.
    pub fn new(model: &WireModel, minimum_n: Option<f64>, maximum_n: Option<f64>) -> Option<TensionLimits> {
        if minimum_n.is_none() && maximum_n.is_none() {
            return None;
        }
        Some(TensionLimits {
            map: WireMap::new(model),
            minimum_n: minimum_n.unwrap_or(f64::NEG_INFINITY),
            maximum_n: maximum_n.unwrap_or(f64::INFINITY),
            limited: false,
        })
    }

    /// Whether a limit had a say in the last cycle.
    pub fn is_limited(&self) -> bool {
        self.limited
    }

    /// The duty to give where a law wants `wanted`: not above what the upper limit allows, else not below what the lower one
    /// asks for. If the estimate is not finite, the law's duty is returned.
    #[inline]
    pub fn limit(&mut self, wanted: f64, seen: &Estimate) -> f64 {
        let m = &self.map;
        let elongation = seen.length_m - m.length;
        let at_rest = m.stress(elongation, 0.0);
        // the heating curve where the wire stands still: without the drag's share of the stress
        let curve = seen.heating_curve_c + (at_rest - seen.stress_pa) * m.shift;
        let below = curve - seen.temperature_c;
        let s = at_rest + m.thermoelastic * (seen.temperature_c - m.reference);
        let kelvin_per_metre = m.kelvin_per_metre(seen.martensite, m.heating_width, s).max(1e-9);
        let newton_per_kelvin = m.spring / kelvin_per_metre;
        let moves = m.spring > LEAST_SPRING;

        // what is hotter than its curve goes on shortening until it meets it
        let coming = at_rest * m.area + newton_per_kelvin * (-below).max(0.0);
        let highest = coming.max(seen.stress_pa * m.area);
        let xi = seen.martensite.clamp(0.03, 0.97);
        let capacity = m.heat_capacity + seen.release_j * xi * (1.0 - xi) / m.heating_width;
        let duty_for = |missing_n: f64| {
            let along = if moves { RATE * missing_n / newton_per_kelvin } else { 0.0 };
            (seen.loss_w + capacity * along + m.heat_capacity * CROSS_RATE * below.max(0.0)) / seen.full_power_w
        };
        let most = match (moves, highest > self.maximum_n) {
            (true, _) if self.maximum_n.is_finite() => duty_for(self.maximum_n - highest),
            (false, true) => 0.0,
            _ => f64::INFINITY,
        };
        let least = if moves && coming < self.minimum_n { duty_for(self.minimum_n - coming) } else { 0.0 };
        // in this order a NaN bounds nothing
        let given = wanted.max(least).min(most).max(0.0);
        self.limited = given != wanted;
        given
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Observation;
    use crate::estimators::EnthalpyObserver;
    use crate::testing::{hanging, wire};
    use sinew_physics::{Inputs, Wire};

    fn model() -> WireModel {
        WireModel { load: hanging(0.1, 30.0, 300.0, 3.0), ..wire() }
    }

    /// Least and most tension, N, over the last second of four under a duty that knows no limits.
    fn run(wanted: f64, minimum_n: Option<f64>, maximum_n: Option<f64>) -> (f64, f64, bool) {
        let model = model();
        let mut wire = Wire::new(&model).unwrap();
        let mut estimator = EnthalpyObserver::new(&model);
        let mut limits = TensionLimits::new(&model, minimum_n, maximum_n).unwrap();
        let (mut duty, mut range, mut limited) = (0.02, (f64::INFINITY, 0.0_f64), false);
        for tick in 0..6000 {
            wire.step(&Inputs { drive: duty, ..model.rest_inputs() }, 1e-3);
            let seen = estimator.update(&Observation {
                power_w: wire.outputs().power_w,
                length_m: 0.16 + wire.position_m(),
                length_sigma_m: 1e-6,
                ..Observation::nothing(duty, 1e-3)
            });
            duty = limits.limit(wanted, &seen).clamp(0.02, 1.0);
            let tension = wire.tension_n();
            range.1 = range.1.max(tension);
            if tick > 5000 {
                range.0 = range.0.min(tension);
                limited |= limits.is_limited();
            }
        }
        (range.0, range.1, limited)
    }

    /// 0.94 N cold, 2.9 N hot: the way between is 2 N.
    #[test]
    fn full_power_stops_at_the_most_tension() {
        for most in [1.5, 2.0, 2.5] {
            let (last, highest, limited) = run(1.0, None, Some(most));
            assert!(highest < most + 0.06 && last > most - 0.12 && limited, "{last} to {highest} N, limit {most}");
        }
    }

    #[test]
    fn no_power_still_keeps_the_least_tension() {
        for least in [1.2, 1.8, 2.4] {
            let (last, highest, limited) = run(0.0, Some(least), None);
            assert!(last > least - 0.12 && highest < least + 0.15 && limited, "{last} to {highest} N, limit {least}");
        }
    }

    #[test]
    fn between_the_limits_the_law_has_its_way() {
        let mut limits = TensionLimits::new(&model(), Some(0.5), Some(2.9)).unwrap();
        let mut estimator = EnthalpyObserver::new(&model());
        let seen = estimator.update(&Observation { length_m: 0.1645, ..Observation::nothing(0.1, 1e-3) });
        assert_eq!(limits.limit(0.137, &seen), 0.137);
        assert!(!limits.is_limited());
        assert_eq!(limits.limit(0.137, &Estimate::UNKNOWN), 0.137);
        assert!(TensionLimits::new(&model(), None, None).is_none());
    }
}
