//! Defaults that follow from the rest of the channel: lengths, currents, temperatures and energies it cannot leave
//! while everything is well.

use sinew_physics::formulas::{STANDARD_GRAVITY_M_S2, SURELY_HOT_K, heating_power_w, resistance_ohm};
use sinew_physics::{DriveKind, Load, WireModel};

use crate::types::{Channel, Joint, SamplingCircuit, Sensing};

/// How far above A, at its stress, the wire may be by default, in K.
const HOTTEST_K: f64 = 60.0;
/// What an unpowered or unknown drive is given as full-on current (A) and power (W): no rig is driven with it.
const UNKNOWN: f64 = 1.0;

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

/// Current (A, rms) the wire bears for good: the thesis' rule of thumb (eq. 8) between what the model says of two
/// temperatures. That rule grows with the area, the heat that the air takes from a hot wire only with the diameter: it says less
/// than what keeps a wire of 0.1 mm contracted, and what takes one of 0.5 mm far beyond its limit.
fn continuous_current_a(model: &WireModel, contracted_c: f64, hottest_c: f64, hot_ohm: f64) -> f64 {
    let holds = |temperature_c: f64| (loss_w(model, temperature_c) / hot_ohm).sqrt();
    model.geometry.safe_current_a().max(holds(contracted_c)).min(holds(hottest_c)).max(1e-6)
}

/// Resistance (Ω) of the wholly austenite wire at a temperature.
fn hot_ohm(model: &WireModel, hot_m: f64, temperature_c: f64) -> f64 {
    resistance_ohm(model.material.austenite_resistivity(temperature_c).max(1e-9), hot_m, model.geometry.area_m2())
}

/// Heat to bring the wire from ambient to a temperature, all of it transforming, in J.
fn heat_j(model: &WireModel, temperature_c: f64) -> f64 {
    model.heat_capacity_j_per_k() * (temperature_c - model.ambient_c).max(0.0) + model.latent_heat_j()
}

/// Stress at which wires are mounted and kept taut by default, in Pa.
const TAUT_PA: f64 = 100e6;
/// Stress in the thinner wire of a joint that is not exceeded by default, in Pa: short of what wears a wire out in a day.
const MOST_PA: f64 = 500e6;
/// Damping of a joint where nothing is said, as a share of what is critical on its wires at their stiffest.
const DAMPING: f64 = 0.3;

/// Fills in every computed default of a joint; `given(key)` says what the file gives itself.
pub(crate) fn fill_joint(joint: &mut Joint, wires: [&WireModel; 2], given: &dyn Fn(&str) -> bool) {
    let area = wires[0].geometry.area_m2().min(wires[1].geometry.area_m2());
    let mechanics = &mut joint.mechanics;
    if !given("damping_n_mm_s") {
        mechanics.damping_n_m_s = DAMPING * 2.0 * mechanics.inertia_kg_m2 * mechanics.fastest_rad_s(wires);
    }
    if !given("pretension_n") {
        mechanics.pretension_n = TAUT_PA * area;
    }
    if !given("minimum_tension_n") {
        joint.min_tension_n = 0.5 * mechanics.pretension_n;
    }
    if !given("maximum_tension_n") {
        joint.max_tension_n = MOST_PA * area;
    }
    if !given("tension_n") {
        joint.tension_n = (2.0 * mechanics.pretension_n).min(joint.max_tension_n);
    }
}

/// Fills in every computed default of a channel, which may be a wire of a joint; `given(table, key)` says what the file
/// gives itself.
pub(crate) fn fill(channel: &mut Channel, joint: Option<&Joint>, given: &dyn Fn(&str, &str) -> bool) {
    if let Load::SpringMassDamper { mass_kg, preload_n, .. } = &mut channel.model.load
        && !given("load", "preload_n")
    {
        *preload_n = *mass_kg * STANDARD_GRAVITY_M_S2;
    }
    if !given("control", "sensing") {
        channel.control.sensing = if channel.model.taps.is_some() { Sensing::Dual } else { Sensing::Resistance };
    }

    let model = &channel.nominal_model(joint);
    let nominal = model.geometry.length_m;
    let (hot, hot_stress) = equilibrium(model, true);
    let hot_stress = joint.map_or(hot_stress, |joint| joint.max_tension_n / model.geometry.area_m2());
    let (cold, _) = equilibrium(model, false);
    let stroke = (cold - hot).abs();
    let margin = 0.1 * stroke + 0.005 * nominal;
    let limits = &mut channel.limits;
    if !given("limits", "minimum_length_mm") {
        limits.min_length_m = (hot.min(cold) - margin).max(0.0);
    }
    if !given("limits", "maximum_length_mm") {
        limits.max_length_m = hot.max(cold) + margin;
    }
    let m = &model.material;
    let stressed_c = m.austenite_at_c(hot_stress);
    if !given("limits", "maximum_temperature_c") {
        limits.max_temperature_c = stressed_c + HOTTEST_K;
    }
    let hottest = limits.max_temperature_c;
    let hot_ohm = hot_ohm(model, hot, hottest);
    if !given("limits", "continuous_current_a") {
        limits.continuous_current_a = continuous_current_a(model, stressed_c + SURELY_HOT_K, hottest, hot_ohm);
    }
    if !given("limits", "energy_drain_w") {
        limits.energy_drain_w = heating_power_w(1.0, limits.continuous_current_a, hot_ohm);
    }
    if !given("limits", "energy_budget_j") {
        limits.energy_budget_j = (1.25 * heat_j(model, hottest)).max(1e-9);
    }
    if !given("limits", "default_hold_s") {
        limits.lease_s = 0.5_f64.min(limits.max_lease_s);
    }

    let on = full_on(channel, hottest);
    let (largest_current, largest_power) =
        on.map_or((UNKNOWN, UNKNOWN), |on| (on.largest_current_a, on.largest_power_w));
    let limits = &mut channel.limits;
    if !given("limits", "maximum_current_a") {
        limits.max_current_a = 1.15 * largest_current;
    }
    if !given("limits", "maximum_power_w") {
        limits.max_power_w = 1.1 * largest_power;
    }
    if !given("limits", "maximum_duty") {
        // Where the supply is measured in the off-phase, that phase must never be shorter than the sensing pulse.
        let longest = match channel.adc.circuit {
            SamplingCircuit::SeparateTaps => 1.0,
            SamplingCircuit::Shared => 1.0 - channel.control.minimum_duty,
        };
        limits.max_duty = (limits.max_power_w / largest_power).min(longest);
    }
    if !given("adc", "voltage_range_v") {
        let supply = channel.model.drive.supply_v;
        channel.adc.voltage_range_v = if 1.25 * supply > 10.0 { 1.25 * supply } else { 10.0 };
    }
    if !given("adc", "current_range_a") {
        channel.adc.current_range_a = 1.1 * channel.limits.max_current_a;
    }

    let stroke = stroke.max(0.001 * nominal);
    if !given("control", "pi_proportional_per_mm") {
        channel.control.pi_proportional_per_m = 1.0 / (0.3 * stroke);
    }
    if !given("control", "pi_integral_per_mm_s") {
        channel.control.pi_integral_per_m_s = 1.0 / (0.3 * stroke);
    }
    if !given("control", "pid_derivative_s_per_mm") {
        channel.control.pid_derivative_s_per_m = 0.05 / (0.3 * stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rig;
    use sinew_physics::Convection;

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
