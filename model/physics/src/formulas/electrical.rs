//! The heating circuit, the wire's resistance, and what taps say of the length (eq. 36–44).

use crate::params::{Amplifier, Drive, Geometry, Material, Taps};

impl Drive {
    /// Switch and shunt, between the wire's fixed end and ground, in Ω: what an input shared by supply and current reads
    /// the current over.
    #[inline]
    pub fn low_ohm(&self) -> f64 {
        self.shunt_ohm + self.switch_ohm
    }

    /// What is in series with the wire by the rig file: shunt, switch and leads, in Ω. Without the effects that add to
    /// it; see [`WireModel::outside_ohm`](crate::WireModel::outside_ohm).
    #[inline]
    pub fn series_ohm(&self) -> f64 {
        self.shunt_ohm + self.switch_ohm + self.lead_ohm
    }

    /// Current in the on-phase through a wire of `wire_ohm`, in A: the nominal supply over the whole circuit.
    #[inline]
    pub fn on_current_a(&self, wire_ohm: f64) -> f64 {
        current_a(self.supply_v, wire_ohm, self.series_ohm())
    }

    /// Power in a wire of `wire_ohm` in the on-phase, in W.
    #[inline]
    pub fn on_power_w(&self, wire_ohm: f64) -> f64 {
        heating_power_w(1.0, self.on_current_a(wire_ohm), wire_ohm)
    }
}

/// Current I = V_s/(R + R_series) while the switch is closed (the circuit of fig. 61), in A.
#[inline]
pub fn current_a(supply_v: f64, wire_ohm: f64, series_ohm: f64) -> f64 {
    supply_v / (wire_ohm + series_ohm)
}

impl Amplifier {
    /// What is left of a difference between the set current and the duty's after `dt_s`: e^(−2πf t).
    #[inline]
    pub fn left_after(&self, dt_s: f64) -> f64 {
        (-std::f64::consts::TAU * self.filter_hz * dt_s).exp()
    }

    /// What the set current, in A, is after `dt_s` at a duty, and the root of its mean square meanwhile, in A: what heats.
    #[inline]
    pub fn follow(&self, set_a: f64, duty: f64, dt_s: f64) -> (f64, f64) {
        let target = self.full_current_a * duty.clamp(0.0, 1.0);
        let (off, left, z) = (set_a - target, self.left_after(dt_s), std::f64::consts::TAU * self.filter_hz * dt_s);
        // the means of e^(−z) and of its square over the span
        let (mean, mean_square) = ((1.0 - left) / z, 0.5 * (1.0 - left * left) / z);
        let square = target * target + off * (2.0 * target * mean + off * mean_square);
        (target + off * left, square.max(0.0).sqrt())
    }
}

/// Current of an amplifier that is set to `set_a`, in A: that, or what its supply drives through the wire where that is less.
#[inline]
pub fn regulated_a(set_a: f64, supply_v: f64, wire_ohm: f64, series_ohm: f64) -> f64 {
    set_a.min(current_a(supply_v, wire_ohm, series_ohm))
}

/// Electrical power P = D I² R in the wire, in W: `duty` 1 is the on-phase itself, or a steady current (before eq. 31).
#[inline]
pub fn heating_power_w(duty: f64, current_a: f64, wire_ohm: f64) -> f64 {
    duty * current_a * current_a * wire_ohm
}

/// What a phase has at `warm_k` above T_0, ρ_0 + α (T − T_0) (eq. 37). In whatever unit both coefficients share: the
/// resistivity in Ω m, or the resistance in Ω of a wire that is all of this phase.
#[inline]
pub fn phase_resistivity(at_reference: f64, per_k: f64, warm_k: f64) -> f64 {
    at_reference + per_k * warm_k
}

/// What a mixture of both phases has, (1−ξ) ρ_A + ξ ρ_M (eq. 36), in the unit of the two; the parts need not add up to
/// 1, so that an estimator can weigh them.
#[inline]
pub fn mixture(austenite: f64, martensite: f64, of_austenite: f64, of_martensite: f64) -> f64 {
    austenite * of_austenite + martensite * of_martensite
}

/// Resistance R = ρL/A_c (eq. 39), in Ω.
#[inline]
pub fn resistance_ohm(resistivity_ohm_m: f64, length_m: f64, area_m2: f64) -> f64 {
    resistivity_ohm_m * length_m / area_m2
}

/// Resistivity ρ = R A_c/L (eq. 39 the other way; eq. 44 of the wire between the taps), in Ω m.
#[inline]
pub fn resistivity_ohm_m(resistance_ohm: f64, length_m: f64, area_m2: f64) -> f64 {
    resistance_ohm * area_m2 / length_m
}

/// How many times the piece between the taps fits between the first tap and the moving end: (V_3 − V_1)/(V_2 − V_1) of
/// eq. 42. Of the same wire under the same current, so that neither resistivity nor current is in it.
#[inline]
pub fn share_between_taps(v1_v: f64, v2_v: f64, v3_v: f64) -> f64 {
    (v3_v - v1_v) / (v2_v - v1_v)
}

/// Variance of a length by the dual measurement, in units of (l_s σ_V/(V_2 − V_1))² with σ_V the deviation of each of the
/// three voltages: 1 + q² + (q − 1)² with q of [`share_between_taps`] (eq. 42 to first order).
#[inline]
pub fn dual_variance(share: f64) -> f64 {
    let rest = share - 1.0;
    1.0 + share * share + rest * rest
}

impl Taps {
    /// Length of the wire, l_0 + l_s q with q of [`share_between_taps`] (eq. 42; with l_0 = 0 eq. 43), in m.
    #[inline]
    pub fn length_m(&self, share: f64) -> f64 {
        self.l0_m + self.ls_m * share
    }

    /// Where the second tap touches, counted from the fixed end, in m.
    #[inline]
    pub fn second_m(&self) -> f64 {
        self.l0_m + self.ls_m
    }
}

impl Material {
    /// Resistivity of austenite at a temperature (eq. 37), in Ω m.
    #[inline]
    pub fn austenite_resistivity(&self, temperature_c: f64) -> f64 {
        let warm_k = temperature_c - self.reference_temperature_c;
        phase_resistivity(self.austenite_resistivity_ohm_m, self.austenite_resistivity_slope_ohm_m_per_k, warm_k)
    }

    /// Resistivity of martensite at a temperature (eq. 37), in Ω m.
    #[inline]
    pub fn martensite_resistivity(&self, temperature_c: f64) -> f64 {
        let warm_k = temperature_c - self.reference_temperature_c;
        phase_resistivity(self.martensite_resistivity_ohm_m, self.martensite_resistivity_slope_ohm_m_per_k, warm_k)
    }

    /// The lower of both phases' resistivities at T_0, in Ω m: what the largest current is reckoned with.
    pub fn least_resistivity(&self) -> f64 {
        self.martensite_resistivity_ohm_m.min(self.austenite_resistivity_ohm_m)
    }

    /// The mean of both phases' resistivities at T_0, in Ω m: where one number has to stand for the wire.
    pub fn mean_resistivity(&self) -> f64 {
        0.5 * (self.austenite_resistivity_ohm_m + self.martensite_resistivity_ohm_m)
    }
}

impl Geometry {
    /// Resistance of the wire of this resistivity at its hot and unloaded length (eq. 39), in Ω.
    #[inline]
    pub fn resistance_ohm(&self, resistivity_ohm_m: f64) -> f64 {
        resistance_ohm(resistivity_ohm_m, self.length_m, self.area_m2())
    }

    /// Current a wire of this size bears for good by the thesis' rule of thumb, in A: 20 A per mm² and 40 mA on top
    /// (Table 3, eq. 8).
    pub fn safe_current_a(&self) -> f64 {
        20.0 * self.area_m2() * 1e6 + 0.04
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eq. 42–44 undo eq. 36–39 along a wire with taps.
    #[test]
    fn taps_say_the_length_and_the_resistivity_they_were_made_with() {
        let (taps, length, area, current) = (Taps { l0_m: 0.004, ls_m: 0.146 }, 0.1653, 1.2e-8, 0.4);
        let volts = |to_m: f64| current * resistance_ohm(81e-8, to_m, area);
        let share = share_between_taps(volts(taps.l0_m), volts(taps.second_m()), volts(length));
        assert!((taps.length_m(share) - length).abs() < 1e-12);
        assert!((resistivity_ohm_m(volts(length) / current, length, area) - 81e-8).abs() < 1e-18);
    }

    /// Against the low-pass in small steps.
    #[test]
    fn an_amplifier_follows_its_duty_as_its_low_pass_does() {
        let amplifier = Amplifier { full_current_a: 0.5, filter_hz: 40.0 };
        for (set_a, duty, dt_s) in [(0.0, 1.0, 0.004), (0.4, 0.1, 0.02), (0.2, 0.4, 1e-4), (0.3, 0.6, 10.0)] {
            let n = 200_000;
            let h = dt_s / f64::from(n);
            let (mut i, mut square) = (set_a, 0.0);
            for _ in 0..n {
                let next = i + h * std::f64::consts::TAU * 40.0 * (0.5 * duty - i);
                square += 0.5 * (i * i + next * next) / f64::from(n);
                i = next;
            }
            let (end, rms) = amplifier.follow(set_a, duty, dt_s);
            assert!((end - i).abs() < 1e-4 && (rms - square.sqrt()).abs() < 1e-4, "{end} {i} {rms} {}", square.sqrt());
        }
        assert_eq!(regulated_a(0.3, 6.0, 10.0, 0.0), 0.3);
        assert_eq!(regulated_a(0.9, 6.0, 10.0, 2.0), 0.5);
    }

    #[test]
    fn power_has_its_peak_where_the_wire_matches_the_circuit() {
        let power = |ohm: f64| heating_power_w(1.0, current_a(6.0, ohm, 0.5), ohm);
        assert!((power(0.5) - 36.0 / 2.0).abs() < 1e-12);
        assert!(power(0.45) < power(0.5) && power(0.55) < power(0.5));
    }
}
