//! What the control laws know of a wire: its reference model boiled down to constants, and the algebra between length,
//! phase, stress and the temperatures of the two outer branches.
//!
//! The static part of the model only. Nothing here has a state, and every output is finite for finite inputs.

use crate::estimate::Estimate;
use sinew_physics::formulas::{self, WORKING_EXCESS_K};
use sinew_physics::{Load, WireModel};

/// Martensite fraction is kept this far from 0 and 1 where a branch temperature (a logarithm) is taken of it.
const EDGE: f64 = 0.01;

/// Flattest |∂ξ/∂T| that is divided by, 1/K: flatter ones ask for more heat than any supply has.
const LEAST_SLOPE: f64 = 1e-6;

/// Constants of one wire in its load and circuit, all SI.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WireMap {
    pub length: f64,
    pub area: f64,
    /// m c_p, J/K.
    pub heat_capacity: f64,
    /// Reciprocals of what is divided by every cycle.
    pub per_heat_capacity: f64,
    pub per_length: f64,
    pub per_area: f64,
    /// m ΔH, J.
    pub latent: f64,
    /// h A_s, W/K.
    pub loss: f64,
    pub ambient: f64,
    pub preload: f64,
    pub damping: f64,
    pub spring: f64,
    pub mass: f64,
    /// Whether the tension follows from a load at all; else the caller has to say it.
    pub load_known: bool,
    pub compliance_a: f64,
    pub compliance_m: f64,
    pub strain: f64,
    pub thermoelastic: f64,
    pub reference: f64,
    /// 1/α, K/Pa.
    pub shift: f64,
    pub heating_centre: f64,
    pub cooling_centre: f64,
    /// 1/k_A, 1/k_M, in K.
    pub heating_width: f64,
    pub cooling_width: f64,
    /// 1 − w: the slope inside the loop as a share of the outer curve's.
    pub inside: f64,
    /// Excess temperature that drives one metre per second against the load's damping, B/(α A_c), in K s/m.
    pub drag: f64,
    /// Power the wire takes at duty 1, in W, at mean resistance.
    pub full_power: f64,
    pub supply: f64,
    pub series: f64,
    rho_a0: f64,
    rho_m0: f64,
    rho_a1: f64,
    rho_m1: f64,
}

impl WireMap {
    pub fn new(model: &WireModel) -> WireMap {
        let (g, m, d) = (&model.geometry, &model.material, &model.drive);
        let (mass, damping, spring, preload, load_known) = match model.load {
            Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } => {
                (mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n, true)
            }
            Load::ImposedPosition | Load::ImposedForce => (0.0, 0.0, 0.0, 0.0, false),
        };
        let mut map = WireMap {
            length: g.length_m,
            area: g.area_m2(),
            heat_capacity: model.heat_capacity_j_per_k(),
            per_heat_capacity: 1.0 / model.heat_capacity_j_per_k(),
            per_length: 1.0 / g.length_m,
            per_area: 1.0 / g.area_m2(),
            latent: model.latent_heat_j(),
            loss: model.loss_w_per_k(WORKING_EXCESS_K),
            ambient: model.ambient_c,
            preload,
            damping,
            spring,
            mass,
            load_known,
            compliance_a: 1.0 / m.austenite_modulus_pa,
            compliance_m: 1.0 / m.martensite_modulus_pa,
            strain: m.transformation_strain,
            thermoelastic: m.thermoelastic_pa_per_k,
            reference: m.reference_temperature_c,
            shift: m.stress_shift_k_per_pa,
            heating_centre: m.austenite_temperature_c,
            cooling_centre: m.martensite_temperature_c,
            heating_width: 1.0 / m.heating_steepness_per_k,
            cooling_width: 1.0 / m.cooling_steepness_per_k,
            inside: 1.0 - m.outer_loop_weight,
            drag: 0.0,
            full_power: 0.0,
            supply: d.supply_v,
            series: d.series_ohm(),
            rho_a0: m.austenite_resistivity_ohm_m,
            rho_m0: m.martensite_resistivity_ohm_m,
            rho_a1: m.austenite_resistivity_slope_ohm_m_per_k,
            rho_m1: m.martensite_resistivity_slope_ohm_m_per_k,
        };
        map.drag = map.damping * map.shift / map.area;
        let middle = 0.5 * (map.heating_centre + map.cooling_centre);
        map.full_power = map.power_at_full_duty(0.5, middle, 0.02 * map.length).max(1e-9);
        map
    }

    /// Wire tension over area with the load moving at `v`, in Pa; a wire cannot push (eq. 51 without inertia).
    pub fn stress(&self, elongation: f64, velocity: f64) -> f64 {
        let pull = formulas::load_pull_n(self.preload, self.spring, self.damping, elongation, velocity);
        (pull * self.per_area).max(0.0)
    }

    /// Martensite fraction at an elongation (eq. 6 and 23 solved for ξ), unclipped.
    pub fn fraction(&self, elongation: f64, stress: f64, temperature: f64) -> f64 {
        let s = stress + self.thermoelastic * (temperature - self.reference);
        (elongation * self.per_length - self.compliance_a * s) / self.strain_per_fraction(s)
    }

    /// Compliance of a phase mixture (eq. 4), in 1/Pa.
    pub fn compliance(&self, fraction: f64) -> f64 {
        formulas::compliance(self.compliance_a, self.compliance_m - self.compliance_a, fraction)
    }

    /// ∂ε/∂ξ at constant stress and temperature, kept away from 0; `s` = σ + θ(T − T_0).
    fn strain_per_fraction(&self, s: f64) -> f64 {
        (self.strain + (self.compliance_m - self.compliance_a) * s).max(1e-4)
    }

    /// Elongation at a phase, stress and temperature (eq. 6, 23).
    pub fn elongation(&self, fraction: f64, stress: f64, temperature: f64) -> f64 {
        let s = stress + self.thermoelastic * (temperature - self.reference);
        self.length * (self.compliance_a * s + fraction * (self.strain + (self.compliance_m - self.compliance_a) * s))
    }

    /// Heat and work a wire gives off when all of it turns martensite under this stress (eq. 48), in J; never 0.
    pub fn release(&self, stress: f64) -> f64 {
        (self.latent + self.area * self.length * stress * self.strain).max(1e-12)
    }

    /// ln((1−ξ)/ξ), the distance from a branch's centre in units of its width (eq. 20 inverted).
    pub fn logit(fraction: f64) -> f64 {
        let xi = fraction.clamp(EDGE, 1.0 - EDGE);
        formulas::logit(xi)
    }

    /// Resistance (eq. 37, 39), in Ω.
    pub fn resistance(&self, fraction: f64, temperature: f64, elongation: f64) -> f64 {
        let (austenite, martensite) = self.resistivities(temperature);
        let rho = formulas::mixture(1.0 - fraction, fraction, austenite, martensite);
        formulas::resistance_ohm(rho.max(1e-9), (self.length + elongation).max(0.5 * self.length), self.area)
    }

    /// Resistivity of austenite and martensite (eq. 37), in Ω m.
    pub fn resistivities(&self, temperature: f64) -> (f64, f64) {
        let t = temperature - self.reference;
        let of = formulas::phase_resistivity;
        (of(self.rho_a0, self.rho_a1, t), of(self.rho_m0, self.rho_m1, t))
    }

    /// Resistivity of the mixture (eq. 36) and its change with temperature, in Ω m and Ω m/K; `off` = by what share those
    /// of austenite and martensite are off.
    pub fn resistivity(&self, fraction: f64, temperature: f64, off: (f64, f64)) -> (f64, f64) {
        let (austenite, martensite) = self.resistivities(temperature);
        let (a, m) = ((1.0 - fraction) * (1.0 + off.0), fraction * (1.0 + off.1));
        let rho = formulas::mixture(a, m, austenite, martensite);
        (rho.max(1e-9), formulas::mixture(a, m, self.rho_a1, self.rho_m1))
    }

    /// Thermal strain of a phase mixture as a length per kelvin (eq. 6), in m/K.
    pub fn thermal_expansion(&self, fraction: f64) -> f64 {
        let xi = fraction.clamp(0.0, 1.0);
        self.length * self.thermoelastic * self.compliance(xi)
    }

    /// ∂ξ/∂ε at constant stress and temperature; `s` = σ + θ(T − T_0).
    pub fn per_strain(&self, s: f64) -> f64 {
        1.0 / self.strain_per_fraction(s)
    }

    /// What a branch is like at this phase; `s` = σ + θ(T − T_0).
    #[inline]
    pub fn branch(&self, fraction: f64, s: f64) -> Branch {
        let xi = fraction.clamp(0.03, 0.97);
        let compliance = self.compliance(xi);
        let per_strain = 1.0 / (xi * (1.0 - xi) * self.strain_per_fraction(s));
        Branch {
            drag: self.drag,
            stretch: self.damping * self.per_area * compliance * per_strain,
            spring: self.spring * self.shift * self.per_area,
            slope: per_strain * self.per_length,
        }
    }

    /// Heat that a metre of transformation takes, as the temperature it would warm the wire by, in K/m; `release_j` is what all
    /// of the wire takes.
    pub fn latent_kelvin_per_metre(&self, release_j: f64, s: f64) -> f64 {
        release_j * self.per_heat_capacity * self.per_length / self.strain_per_fraction(s)
    }

    /// Time in which the load's inertia follows its damping, in s; 0 where either is not known.
    pub fn inertia_s(&self) -> f64 {
        if self.damping > 0.0 { (self.mass / self.damping).min(1.0) } else { 0.0 }
    }

    /// Power in the wire during the on-phase, in W.
    pub fn power_at_full_duty(&self, fraction: f64, temperature: f64, elongation: f64) -> f64 {
        let r = self.resistance(fraction, temperature, elongation);
        formulas::heating_power_w(1.0, formulas::current_a(self.supply, r, self.series), r)
    }

    /// How fast the phase changes with temperature when heated (else cooled) from here, |∂ξ/∂T| in 1/K: k g (1 − g) on the outer
    /// curve (eq. 20), at least the weighted loop's (1 − w) k ξ (1 − ξ) inside it.
    pub fn slope(&self, heating: bool, fraction: f64, driving_temperature: f64) -> f64 {
        let (centre, width) =
            if heating { (self.heating_centre, self.heating_width) } else { (self.cooling_centre, self.cooling_width) };
        let outer = formulas::logistic(driving_temperature, centre, width);
        (outer * (1.0 - outer)).max(self.inside * fraction * (1.0 - fraction)) / width
    }

    /// [`WireMap::slope`] at the estimated state of the wire.
    pub fn slope_here(&self, heating: bool, seen: &Estimate) -> f64 {
        self.slope(heating, seen.martensite, seen.temperature_c - seen.stress_pa * self.shift)
    }

    /// Heat that shortens the wire by a metre against its load, J/m: α of eq. 58, Q/|∂ξ/∂T| · (K + K_SMA)/(K_SMA L ε_L), with
    /// Q = m c_p + H |∂ξ/∂T|.
    pub fn heat_per_metre(&self, slope: f64, seen: &Estimate) -> f64 {
        let s = seen.stress_pa + self.thermoelastic * (seen.temperature_c - self.reference);
        let heat = self.heat_capacity / slope.max(LEAST_SLOPE) + self.release(seen.stress_pa);
        heat * (1.0 + self.spring / self.stiffness(seen.martensite)) * self.per_length / self.strain_per_fraction(s)
    }

    /// Stiffness of the wire as a spring in series with its phase, K_SMA = A_c E(ξ)/L_0, in N/m.
    pub fn stiffness(&self, fraction: f64) -> f64 {
        self.area * self.per_length / self.compliance(fraction)
    }

    /// How much driving temperature one unit of elongation is worth on a branch of the given width at this phase, K/m:
    /// −dT_b/dx at rest, the slope of eq. 68's ∂ξ/∂T seen from the length.
    pub fn kelvin_per_metre(&self, fraction: f64, width: f64, s: f64) -> f64 {
        self.branch(fraction, s).kelvin_per_metre(width)
    }
}

/// A branch of the hysteresis at one phase, for either of the two widths 1/k.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Branch {
    drag: f64,
    stretch: f64,
    spring: f64,
    slope: f64,
}

impl Branch {
    /// Excess temperature that drives one metre per second against the load's damping, in K s/m: the drag's stress shifts the
    /// branch, and stretches the wire, so that at the same length less of it is martensite.
    pub fn drag(&self, width: f64) -> f64 {
        self.drag + width * self.stretch
    }

    /// −dT_b/dx at rest, K/m.
    pub fn kelvin_per_metre(&self, width: f64) -> f64 {
        width * self.slope + self.spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{hanging, wire};
    use sinew_physics::{Geometry, Initial, Wire};

    fn model() -> WireModel {
        WireModel {
            geometry: Geometry { diameter_m: 0.15e-3, length_m: 0.2 },
            load: hanging(0.2, 40.0, 120.0, 3.0),
            initial: Initial { temperature_c: Some(90.0), martensite: 0.6 },
            ..wire()
        }
    }

    /// The algebra here and the wire of the reference model agree at rest.
    #[test]
    fn agrees_with_the_wire_at_rest() {
        let (model, map) = (model(), WireMap::new(&model()));
        let wire = Wire::new(&model).unwrap();
        let (x, t) = (wire.position_m(), wire.temperature_c());
        let stress = map.stress(x, 0.0);
        assert!((stress / wire.stress_pa() - 1.0).abs() < 1e-6, "{stress} {}", wire.stress_pa());
        assert!((map.fraction(x, stress, t) - wire.martensite()).abs() < 1e-6);
        assert!((map.elongation(wire.martensite(), stress, t) - x).abs() < 1e-9);
        assert!((map.resistance(wire.martensite(), t, x) / wire.resistance_ohm() - 1.0).abs() < 1e-6);
    }

    /// The slope is the one a finite difference of the outer curve finds, and never that of nothing inside the loop.
    #[test]
    fn slope_is_the_derivative_of_the_curve() {
        let map = WireMap::new(&model());
        for (heating, centre, width) in
            [(true, map.heating_centre, map.heating_width), (false, 67.0, map.cooling_width)]
        {
            let curve = |t: f64| 1.0 / (1.0 + ((t - centre) / width).exp());
            for off in [-8.0, -1.0, 0.0, 3.0, 20.0] {
                let t = centre + off;
                let expected = (curve(t - 1e-4) - curve(t + 1e-4)) / 2e-4;
                assert!((map.slope(heating, curve(t), t) / expected - 1.0).abs() < 1e-5, "{off}");
            }
            assert!((map.slope(heating, 0.5, centre + 500.0) - 0.2 * 0.25 / width).abs() < 1e-9);
        }
        assert!(map.slope(true, 1.0, -1e9) == 0.0 && map.slope(false, 0.0, 1e300) < 1e-100);
    }

    #[test]
    fn logit_inverts_the_curve() {
        for xi in [0.02, 0.3, 0.5, 0.98] {
            assert!((1.0 / (1.0 + WireMap::logit(xi).exp()) - xi).abs() < 1e-12);
        }
        assert!(WireMap::logit(0.0).is_finite() && WireMap::logit(1.0).is_finite());
    }
}
