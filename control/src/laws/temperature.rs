//! PID on the wire's temperature (table 5: "nonlinear PID temperature-feedback, heat transfer feed-forward").
//!
//! What is controlled is not the length but the temperature, to that at which the wire has the length wanted: the model's inverse,
//! on the heating curve for a wire that has to shorten and on the cooling curve for one that has to lengthen, as the estimator has
//! learned them. The loss to the air at the wanted temperature is fed forward. The table's scheme has a thermometer on the wire; here
//! there is the estimate.
//!
//! The table names no gains. Ours: the error is counted as the length that it is worth halfway along the heating curve, so that the gains
//! are those of [`super::pid`]; what makes it nonlinear is Seraji's gain in front of it, k(e) = 1 + (1 − sech(e/e₁)) (*A new class of
//! nonlinear PID controllers with robotic applications*, J. Robotic Systems 15, 1998), with e₁ the width 1/k of the heating curve.

use super::pid::{Pid, PidGains};
use crate::demand::{Demand, Law, Range};
use crate::estimate::Estimate;
use crate::wire_map::WireMap;

/// By how much the gain grows far from the temperature wanted, as a share of what it is near it.
const GROWTH: f64 = 1.0;
/// Error beyond which a wire that is on the wrong side is brought over to the other curve, in strokes. A kelvin is worth six of these.
const TURN: f64 = 0.01;
/// Least temperature above the air from which the learned loss is scaled to another, K.
const LEAST_EXCESS_K: f64 = 1.0;

/// k(e) of an error in units of e₁.
#[inline]
fn gain(error: f64) -> f64 {
    1.0 + GROWTH * (1.0 - 1.0 / error.abs().min(50.0).cosh())
}

/// PID on the temperature that the model's inverse asks for.
#[derive(Debug, Clone)]
pub struct TemperaturePid {
    map: WireMap,
    gains: PidGains,
    pid: Pid,
    /// Temperature that a metre is worth halfway along the heating curve, K/m, and one over the width of that curve, 1/K.
    kelvin_per_metre: f64,
    per_width: f64,
    /// Error that asks for full power by itself, m: more would only fill the integrator the wrong way.
    most: f64,
    /// Error that makes the wire change curves, m.
    turn: f64,
    shortens: bool,
    /// The last cycle's estimate, °C; NaN in the first.
    temperature: f64,
}

impl TemperaturePid {
    pub(crate) fn new(map: WireMap, gains: PidGains, stroke_m: f64, range: Range) -> TemperaturePid {
        let stress = map.stress(0.5 * map.length * map.strain, 0.0);
        TemperaturePid {
            map,
            gains,
            pid: Pid::new(gains, true, range),
            kelvin_per_metre: map.kelvin_per_metre(0.5, map.heating_width, stress).max(1e-9),
            per_width: 1.0 / map.heating_width,
            most: if gains.proportional_per_m > 0.0 { 1.0 / gains.proportional_per_m } else { stroke_m },
            turn: TURN * stroke_m,
            shortens: true,
            temperature: f64::NAN,
        }
    }

    /// The temperature at which the wire stands at a length on one of its curves, °C. The curves are where the estimate has them at
    /// its own phase and stress; from there on the way to the wanted ones is the model's.
    #[inline]
    fn wanted(&self, length_m: f64, shortens: bool, seen: &Estimate) -> f64 {
        let m = &self.map;
        let elongation = length_m - m.length;
        let stress = if m.load_known { m.stress(elongation, 0.0) } else { seen.stress_pa };
        let (curve, width) =
            if shortens { (seen.heating_curve_c, m.heating_width) } else { (seen.cooling_curve_c, m.cooling_width) };
        let here = curve - width * WireMap::logit(seen.martensite) + m.shift * (stress - seen.stress_pa);
        // the phase at that length depends, by thermal strain, a little on the temperature that is looked for
        let mut wanted = here;
        for _ in 0..2 {
            wanted = here + width * WireMap::logit(m.fraction(elongation, stress, wanted));
        }
        wanted
    }
}

impl Law for TemperaturePid {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        let seen = &demand.estimate;
        if !demand.is_usable() || !seen.is_usable() {
            return None;
        }
        let error = seen.length_m - demand.reference_m;
        if error.abs() > self.turn {
            self.shortens = error > 0.0;
        }
        let wanted = self.wanted(demand.reference_m, self.shortens, seen);
        if !wanted.is_finite() {
            return None;
        }
        let short_of = wanted - seen.temperature_c;
        let rate = if self.temperature.is_nan() { 0.0 } else { (seen.temperature_c - self.temperature) / demand.dt_s };
        self.temperature = seen.temperature_c;
        let per_metre = self.kelvin_per_metre;
        let (excess, now) = (wanted - self.map.ambient, seen.temperature_c - self.map.ambient);
        let loss = if now > LEAST_EXCESS_K { seen.loss_w / now * excess } else { self.map.loss * excess };
        let error = (gain(short_of * self.per_width) * short_of / per_metre).max(-self.most).min(self.most);
        let answer = self.pid.answer(&self.gains, error, -rate / per_metre, demand.dt_s, loss / seen.full_power_w);
        Some(answer.given)
    }

    fn reset(&mut self) {
        self.pid.reset();
        self.shortens = true;
        self.temperature = f64::NAN;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::Curves;
    use crate::demand::Modulation;
    use crate::testing::{by_power, hanging, standing, wire};
    use sinew_physics::{Inputs, Wire, WireModel};

    fn model() -> WireModel {
        WireModel { drive: by_power(), load: hanging(0.1, 30.0, 100.0, 2.0), ..wire() }
    }

    fn law(model: &WireModel) -> TemperaturePid {
        let map = WireMap::new(model);
        TemperaturePid::new(map, PidGains::for_stroke(6e-3), 6e-3, Range::new(0.0, 1.0, Modulation::Switched))
    }

    /// What a perfect estimator would say of the wire.
    fn believed(map: &WireMap, wire: &Wire) -> Estimate {
        let (martensite, stress_pa) = (wire.martensite(), wire.stress_pa());
        let curves = Curves::at(map, martensite, stress_pa);
        Estimate {
            temperature_c: wire.temperature_c(),
            martensite,
            stress_pa,
            heating_curve_c: curves.heating_c,
            cooling_curve_c: curves.cooling_c,
            length_m: map.length + wire.position_m(),
            velocity_m_s: wire.velocity_m_s(),
            loss_w: map.loss * (wire.temperature_c() - map.ambient),
            full_power_w: 3.0,
            ..Estimate::UNKNOWN
        }
    }

    /// The inverse is that of the reference model: taken slowly through its loop, the wire has at every length the temperature that the
    /// law asks for at it, on both curves, whatever the state it is asked in.
    #[test]
    fn the_temperature_asked_for_is_the_one_the_wire_has() {
        let model = model();
        let (law, mut wire) = (law(&model), Wire::new(&model).unwrap());
        let cold = believed(&law.map, &wire);
        let mut checked = [0, 0];
        for (shortens, to_c) in [(true, 170.0), (false, 30.0)] {
            let from_c = wire.temperature_c();
            for k in 0..200_000 {
                let wanted = from_c + (to_c - from_c) * f64::from(k) / 200_000.0;
                let now = wire.temperature_c();
                let power = law.map.loss * (now - 25.0) + law.map.heat_capacity * 50.0 * (wanted - now);
                wire.step(&Inputs { drive: power.max(0.0), ..model.rest_inputs() }, 1e-3);
                // on the outer curve only, and where its logarithm is not cut off
                if k % 500 == 0 && (0.05..0.95).contains(&wire.martensite()) {
                    let length = law.map.length + wire.position_m();
                    let asked = law.wanted(length, shortens, &cold);
                    assert!((asked - wire.temperature_c()).abs() < 0.5, "{asked} {}", wire.temperature_c());
                    let asked = law.wanted(length, shortens, &believed(&law.map, &wire));
                    assert!((asked - wire.temperature_c()).abs() < 0.5, "{asked} {}", wire.temperature_c());
                    checked[usize::from(shortens)] += 1;
                }
            }
        }
        assert!(checked[0] > 20 && checked[1] > 20, "{checked:?}");
    }

    /// Once near its temperature, twice that far from it, the same on both sides.
    #[test]
    fn the_gain_grows_with_the_error() {
        assert_eq!(gain(0.0), 1.0);
        assert!((gain(1.0) - (2.0 - 1.0 / 1f64.cosh())).abs() < 1e-15);
        assert!((gain(1e300) - 2.0).abs() < 1e-12 && gain(-3.0) == gain(3.0));
        assert!(gain(2.0) > gain(1.0));
    }

    /// With the state known the temperature settles on what was asked for, and the wire stands where that puts it.
    #[test]
    fn brings_the_wire_to_its_temperature_and_so_to_its_length() {
        let model = model();
        let (mut law, mut wire) = (law(&model), Wire::new(&model).unwrap());
        for reference_m in [0.1630, 0.1620, 0.1638] {
            let (mut last, mut asked) = (f64::NAN, f64::NAN);
            for _ in 0..8000 {
                let estimate = believed(&law.map, &wire);
                let demand = Demand { estimate, ..standing(reference_m, estimate.length_m) };
                let duty = law.duty(&demand).unwrap();
                asked = law.wanted(reference_m, law.shortens, &estimate);
                wire.step(&Inputs { drive: 3.0 * duty, ..model.rest_inputs() }, 1e-3);
                last = 0.16 + wire.position_m() - reference_m;
            }
            assert!((wire.temperature_c() - asked).abs() < 0.5, "{} {asked}", wire.temperature_c());
            assert!(last.abs() < law.turn, "{last} at {reference_m}");
        }
    }
}
