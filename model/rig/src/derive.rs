//! Lengths, currents, temperatures and energies that a channel cannot leave while everything is well: what computed
//! defaults and cross-checks of its tables follow from.

use sinew_physics::formulas::{SURELY_HOT_K, resistance_ohm};
use sinew_physics::{DriveKind, Load, WireModel};

use crate::tables::{Channel, Joint};

/// How far above A, at its stress, the wire may be by default, in K.
const HOTTEST_K: f64 = 60.0;

/// Length (m) and stress (Pa) at rest in one of the two pure phases: wholly austenite 40 K above A at its stress, or
/// wholly martensite at ambient temperature. Where position or force are inputs, those of the unloaded wire.
///
/// In a pure phase series and parallel mixing agree and everything is linear: ε = c σ + ε_0 against
/// A_c σ = F − K L_0 ε.
fn equilibrium(model: &WireModel, hot: bool) -> (f64, f64) {
    let m = &model.material;
    let warm = if hot { m.austenite_temperature_c + SURELY_HOT_K } else { model.ambient_c } - m.reference_temperature_c;
    let (compliance, shape) = if hot {
        // The temperature of a hot wire rises with its stress: A is shifted.
        let shift = 1.0 + m.thermoelastic_pa_per_k * m.stress_shift_k_per_pa;
        (shift / m.austenite_modulus_pa, 0.0)
    } else {
        (1.0 / m.martensite_modulus_pa, m.transformation_strain)
    };
    let modulus = if hot { m.austenite_modulus_pa } else { m.martensite_modulus_pa };
    let stress_free = shape + m.thermoelastic_pa_per_k * warm / modulus;
    let length = model.geometry.length_m;
    let stress = match model.load {
        Load::SpringMassDamper { spring_n_per_m, preload_n, .. } => {
            let pull = preload_n - spring_n_per_m * length * stress_free;
            // A wire cannot push.
            (pull / (model.geometry.area_m2() + spring_n_per_m * length * compliance)).max(0.0)
        }
        Load::ImposedPosition | Load::ImposedForce => 0.0,
    };
    (length * (1.0 + stress_free + compliance * stress), stress)
}

/// Resistances (Ω) the whole wire can have: least and largest over both phases, from ambient to `hot_c`.
fn resistances(model: &WireModel, hot_c: f64) -> (f64, f64) {
    let m = &model.material;
    let resistivities = |t: f64| [m.austenite_resistivity(t), m.martensite_resistivity(t)];
    let all = resistivities(model.ambient_c).into_iter().chain(resistivities(hot_c));
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)));
    let geometry = model.geometry;
    let longest = equilibrium(model, false).0.max(geometry.length_m);
    // A strongly negative slope could take a resistivity through zero; no metal gets near it.
    (geometry.resistance_ohm(low.max(1e-9)), resistance_ohm(high.max(1e-9), longest, geometry.area_m2()))
}

/// The wire while the switch is on: currents (A) and powers (W) the supply can drive through it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FullOn {
    pub least_current_a: f64,
    pub largest_current_a: f64,
    pub largest_power_w: f64,
}

/// `None` where the drive is not a supply that is switched.
pub(crate) fn full_on(channel: &Channel, hot_c: f64) -> Option<FullOn> {
    let drive = &channel.model.drive;
    if drive.kind != DriveKind::Pwm || drive.supply_v <= 0.0 {
        return None;
    }
    let (low, high) = resistances(&channel.model, hot_c);
    Some(FullOn {
        least_current_a: drive.on_current_a(high),
        largest_current_a: drive.on_current_a(low),
        // Power over resistance has its peak where the wire matches the rest of the circuit.
        largest_power_w: drive.on_power_w(drive.series_ohm().max(low).min(high)),
    })
}

/// Loss to the air at a wire temperature, in W.
fn loss_w(model: &WireModel, temperature_c: f64) -> f64 {
    let above = (temperature_c - model.ambient_c).max(0.0);
    model.loss_w_per_k(above) * above
}

/// How far a wire goes while everything is well, in the load it is reckoned with: its lengths and temperatures, from
/// which its computed limits follow.
pub(crate) struct Reach {
    model: WireModel,
    hot_m: f64,
    cold_m: f64,
    /// Stress of the hot and of the cold wire, in Pa.
    hot_pa: f64,
    cold_pa: f64,
    /// A at the stress of the hot wire, in °C.
    stressed_c: f64,
}

impl Reach {
    /// Of a channel's wire, which may be one of a joint's.
    pub(crate) fn of(channel: &Channel, joint: Option<&Joint>) -> Reach {
        let model = channel.nominal_model(joint);
        let (hot_m, hot_pa) = equilibrium(&model, true);
        let hot_pa = joint.map_or(hot_pa, |joint| joint.max_tension_n / model.geometry.area_m2());
        let (cold_m, cold_pa) = equilibrium(&model, false);
        let stressed_c = model.material.austenite_at_c(hot_pa);
        Reach { model, hot_m, cold_m, hot_pa, cold_pa, stressed_c }
    }

    /// Way between hot and cold, in m.
    pub(crate) fn stroke_m(&self) -> f64 {
        (self.cold_m - self.hot_m).abs()
    }

    /// What a measured length may be beyond hot and cold, in m.
    fn margin_m(&self) -> f64 {
        0.1 * self.stroke_m() + 0.005 * self.model.geometry.length_m
    }

    /// Shortest length, in m.
    pub(crate) fn shortest_m(&self) -> f64 {
        (self.hot_m.min(self.cold_m) - self.margin_m()).max(0.0)
    }

    /// Longest length, in m.
    pub(crate) fn longest_m(&self) -> f64 {
        self.hot_m.max(self.cold_m) + self.margin_m()
    }

    /// How hot the wire may be by default, in °C.
    pub(crate) fn hottest_c(&self) -> f64 {
        self.stressed_c + HOTTEST_K
    }

    /// Current (A, rms) the wire bears for good, where it may be this hot: the thesis' rule of thumb (eq. 8) between
    /// what the model says of two temperatures. That rule grows with the area, the heat that the air takes from a hot
    /// wire only with the diameter: it says less than what keeps a wire of 0.1 mm contracted, and what takes one of
    /// 0.5 mm far beyond its limit.
    pub(crate) fn continuous_current_a(&self, hottest_c: f64) -> f64 {
        let hot_ohm = self.hot_ohm(hottest_c);
        let holds = |temperature_c: f64| (loss_w(&self.model, temperature_c) / hot_ohm).sqrt();
        let contracted_c = self.stressed_c + SURELY_HOT_K;
        self.model.geometry.safe_current_a().max(holds(contracted_c)).min(holds(hottest_c)).max(1e-6)
    }

    /// Resistance (Ω) of the wholly austenite wire at a temperature.
    pub(crate) fn hot_ohm(&self, temperature_c: f64) -> f64 {
        let resistivity = self.model.material.austenite_resistivity(temperature_c).max(1e-9);
        resistance_ohm(resistivity, self.hot_m, self.model.geometry.area_m2())
    }

    /// The most its load pulls at rest, hot or cold, in N.
    pub(crate) fn largest_pull_n(&self) -> f64 {
        self.hot_pa.max(self.cold_pa) * self.model.geometry.area_m2()
    }

    /// What its load pulls with at rest while the wire is cold, in N; 0 where it has gone slack before.
    pub(crate) fn cold_pull_n(&self) -> f64 {
        self.cold_pa.max(0.0) * self.model.geometry.area_m2()
    }

    /// How much longer than hot and unloaded the wire is once its load has stretched it as far as its martensite goes, in m.
    pub(crate) fn stretched_m(&self) -> f64 {
        self.model.material.transformation_strain * self.model.geometry.length_m
    }

    /// Where half of the hot wire has shortened, in °C, and the power that holds it there, in W.
    pub(crate) fn shortened_c(&self) -> f64 {
        self.stressed_c
    }

    pub(crate) fn shortens_w(&self) -> f64 {
        loss_w(&self.model, self.stressed_c)
    }

    /// Where half of the wire has become martensite again under its load, in °C, and the power that holds it there, in W.
    pub(crate) fn relaxed_c(&self) -> f64 {
        let m = &self.model.material;
        m.martensite_temperature_c + m.austenite_at_c(self.cold_pa) - m.austenite_temperature_c
    }

    pub(crate) fn relaxed_w(&self) -> f64 {
        loss_w(&self.model, self.relaxed_c())
    }

    /// Heat to bring the wire from ambient to a temperature, all of it transforming, in J.
    pub(crate) fn heat_j(&self, temperature_c: f64) -> f64 {
        let above_k = (temperature_c - self.model.ambient_c).max(0.0);
        self.model.heat_capacity_j_per_k() * above_k + self.model.latent_heat_j()
    }
}

#[cfg(test)]
mod tests {
    use sinew_physics::Convection;

    use super::*;
    use crate::Rig;

    fn hexapod_wire() -> Channel {
        Rig::hexapod().channels.swap_remove(0)
    }

    #[test]
    fn lengths_are_those_of_the_simulated_wire() {
        for channel in Rig::hexapod().channels {
            let hot = sinew_physics::hot_length_m(&channel.model).unwrap();
            let cold = sinew_physics::cold_length_m(&channel.model).unwrap();
            assert!((equilibrium(&channel.model, true).0 - hot).abs() < 1e-6, "{hot}");
            assert!((equilibrium(&channel.model, false).0 - cold).abs() < 1e-6, "{cold}");
        }
    }

    #[test]
    fn a_wire_does_not_push() {
        let mut channel = hexapod_wire();
        let Load::SpringMassDamper { preload_n, .. } = &mut channel.model.load else { panic!() };
        *preload_n = -5.0;
        assert_eq!(equilibrium(&channel.model, true).1, 0.0);
    }

    #[test]
    fn full_on_power_is_the_greatest_over_resistance() {
        let mut channel = hexapod_wire();
        for series in [0.0, 5.0, 11.0, 40.0] {
            channel.model.drive.lead_ohm = series;
            let on = full_on(&channel, 150.0).unwrap();
            let (low, high) = resistances(&channel.model, 150.0);
            let total = series + channel.model.drive.shunt_ohm + channel.model.drive.switch_ohm;
            for i in 0..=1000 {
                let r = low + (high - low) * f64::from(i) / 1000.0;
                let current = channel.model.drive.supply_v / (r + total);
                assert!(current * current * r <= on.largest_power_w * (1.0 + 1e-12));
                assert!((on.least_current_a - 1e-12..=on.largest_current_a + 1e-12).contains(&current));
            }
        }
    }

    #[test]
    fn full_power_exhausts_the_energy_budget_before_it_ruins_the_wire() {
        // The account is cruder than the temperature estimate and its only job is to end full power in time.
        let channel = hexapod_wire();
        let on = full_on(&channel, channel.limits.max_temperature_c).unwrap();
        let seconds = channel.limits.energy_budget_j / (on.largest_power_w - channel.limits.energy_drain_w);
        assert!((0.3..3.0).contains(&seconds), "{seconds} s");
    }

    #[test]
    fn natural_convection_drains_by_equation_34() {
        let mut channel = hexapod_wire();
        channel.model.material.convection = Convection::Natural;
        let h = 65.5 * (-0.125_f64 / 4.0).exp() * 60.0_f64.powf(1.0 / 6.0);
        let expected = h * std::f64::consts::PI * 0.125e-3 * 0.160 * 60.0;
        assert!((loss_w(&channel.model, 85.0) / expected - 1.0).abs() < 1e-12);
        assert_eq!(loss_w(&channel.model, 20.0), 0.0);
    }
}
