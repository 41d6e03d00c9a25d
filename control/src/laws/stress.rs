//! Variable structure control on the wire's stress (table 5: "nonlinear stress-model based control VSC").
//!
//! After the work of Elahinia and Ahmadian on rotary manipulators (Elahinia, Seigler, Leo, Ahmadian, *Nonlinear stress-based control of a rotary
//! SMA-actuated manipulator*, J. Intelligent Material Systems and Structures 15, 2004), of which the text of the thesis gives the name only. Two
//! steps: the mechanics say which stress the wire has to have so that its load moves as it should, and a variable structure with a
//! boundary layer heats a wire that has less and lets one cool that has more.
//!
//! Ours is what the steps are made of. *Wanted*, by backstepping: with the velocity v_d = −λ(x − x_ref), z = ẋ − v_d and eq. 51,
//! A σ_d = F_preload − K x − B v_d − M v̇_d + λ M z leaves M ż = −(B + λ M) z. *Believed*, because nobody measures it: a wire that
//! transforms is on a line of the phase diagram, so that its temperature says its stress, σ = (T − T_b(ξ))/(dT/dσ) (eq. 12), on the heating
//! curve for a wire that is too long, on the cooling curve for one that is too short. The layer is the stress that shifts a curve by its
//! own width; within it power is proportional, about the estimated loss to the air.

use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;

/// σ_d − σ, switched.
#[derive(Debug, Clone)]
pub struct StressVariableStructure {
    map: WireMap,
    lambda: f64,
    range: Range,
    surface: f64,
}

impl StressVariableStructure {
    pub(crate) fn new(map: WireMap, lambda: f64, range: Range) -> StressVariableStructure {
        StressVariableStructure { map, lambda, range, surface: 0.0 }
    }

    /// The stress that makes the load move as it should, Pa, for a wire `error` too long at `elongation`, moving with `velocity`.
    #[inline]
    fn wanted(&self, elongation: f64, error: f64, velocity: f64) -> f64 {
        let (m, lambda) = (&self.map, self.lambda);
        let towards = -lambda * error;
        let pull = m.preload - m.spring * elongation - m.damping * towards;
        // v̇_d = −λẋ
        let inertia = m.mass * lambda * (velocity + (velocity - towards));
        (pull + inertia) * m.per_area
    }
}

impl Law for StressVariableStructure {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        self.surface = 0.0;
        let seen = &demand.estimate;
        if !demand.is_usable() || !seen.is_usable() {
            return None;
        }
        let m = &self.map;
        let error = seen.length_m - demand.reference_m;
        let elongation = seen.length_m - m.length;
        let (curve, width) =
            if error > 0.0 { (seen.heating_curve_c, m.heating_width) } else { (seen.cooling_curve_c, m.cooling_width) };
        // a load that nobody knows asks for the stress it has
        let wanted = if m.load_known {
            self.wanted(elongation, error, seen.velocity_m_s)
        } else {
            seen.stress_pa + error.signum()
        };
        // σ_d − σ as the temperature it is worth: the curve as it would be under the stress wanted, less the temperature
        let short_of_k = curve + m.shift * (wanted - seen.stress_pa) - seen.temperature_c;
        if m.mass > 0.0 {
            self.surface = short_of_k / m.shift * m.area / m.mass;
        }
        let share = (short_of_k / width).clamp(-1.0, 1.0);
        Some(self.range.give(seen.loss_w / seen.full_power_w + self.range.maximum * share))
    }

    fn reset(&mut self) {
        self.range.reset();
        self.surface = 0.0;
    }

    fn surface(&self) -> f64 {
        if self.surface.is_finite() { self.surface } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::Curves;
    use crate::demand::Modulation;
    use crate::estimate::Estimate;
    use crate::testing::{hanging, standing, wire};
    use sinew_physics::WireModel;

    fn law() -> StressVariableStructure {
        let model = WireModel { load: hanging(0.2, 12.0, 80.0, 2.5), ..wire() };
        StressVariableStructure::new(WireMap::new(&model), 8.0, Range::new(0.0, 1.0, Modulation::Switched))
    }

    /// A load that is pulled by the stress wanted approaches its reference by ẋ = −λ(x − x_ref) plus what decays with B/M + λ.
    #[test]
    fn the_stress_wanted_makes_the_load_approach() {
        let law = law();
        let m = &law.map;
        let (mut elongation, mut velocity, reference) = (4e-3, 0.03, 1e-3);
        let dt = 1e-5;
        let z = |elongation: f64, velocity: f64| velocity + law.lambda * (elongation - reference);
        let (start, e) = (z(elongation, velocity), elongation - reference);
        for _ in 0..20_000 {
            let stress = law.wanted(elongation, elongation - reference, velocity);
            let force = m.preload - m.spring * elongation - m.damping * velocity - stress * m.area;
            velocity += force / m.mass * dt;
            elongation += velocity * dt;
        }
        let (t, faster) = (0.2, m.damping / m.mass + law.lambda);
        // ė = −λe + z, z = z₀ exp(−(B/M + λ)t): in closed form
        let (slow, fast) = ((-law.lambda * t).exp(), (-faster * t).exp());
        let expected = e * slow + start * (slow - fast) / (faster - law.lambda);
        let error = elongation - reference;
        assert!((error / expected - 1.0).abs() < 2e-3, "{error} {expected}");
        assert!((z(elongation, velocity) - start * fast).abs() < 1e-3 * start, "{}", z(elongation, velocity));
    }

    /// At rest at its reference, on its curve, it has the stress it should: the loss is what is given. A kelvin short of it, and a
    /// megapascal short of it, are worth the same as the phase diagram has them.
    #[test]
    fn stress_is_temperature_on_the_curve() {
        let mut law = law();
        let elongation = 2e-3;
        let stress_pa = law.map.stress(elongation, 0.0);
        let curves = Curves::at(&law.map, 0.5, stress_pa);
        let mut given = |reference: f64, temperature_c: f64, velocity_m_s: f64| {
            let estimate = Estimate {
                temperature_c,
                martensite: 0.5,
                stress_pa,
                heating_curve_c: curves.heating_c,
                cooling_curve_c: curves.cooling_c,
                length_m: 0.16 + elongation,
                velocity_m_s,
                loss_w: 0.3,
                full_power_w: 3.0,
                ..Estimate::UNKNOWN
            };
            let demand = Demand { velocity_m_s, estimate, ..standing(0.16 + reference, 0.16 + elongation) };
            let duty = law.duty(&demand).unwrap();
            (duty, law.surface())
        };
        let just_short = 1e-12;
        let (at_rest, surface) = given(elongation - just_short, curves.heating_c, 0.0);
        assert!((at_rest - 0.1).abs() < 1e-6 && surface.abs() < 1e-3, "{at_rest} {surface}");
        // a tenth of the layer
        let width = WireMap::new(&wire()).heating_width;
        let (colder, _) = given(elongation - just_short, curves.heating_c - 0.1 * width, 0.0);
        assert!((colder - 0.2).abs() < 1e-6, "{colder}");
        let too_long =
            0.1 * width / WireMap::new(&wire()).shift * WireMap::new(&wire()).area / (8.0 * (12.0 + 0.2 * 8.0));
        let (longer, _) = given(elongation - too_long, curves.heating_c, 0.0);
        assert!((longer - 0.2).abs() < 1e-6, "{longer}");
        // outside of it all or nothing
        assert_eq!(given(elongation - 3e-3, curves.heating_c - 20.0, 0.0).0, 1.0);
        assert_eq!(given(elongation + 1e-3, curves.heating_c, 0.0).0, 0.0);
    }
}
