//! The limits: their computed defaults, and what they need of each other and of the drive.

use sinew_physics::DriveKind;
use sinew_physics::formulas::heating_power_w;

use crate::derive::{self, Reach};
use crate::notes::{Reader, Stated, tidy};
use crate::tables::{Channel, SamplingCircuit};

pub(super) fn duty_belongs_to_pwm(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    if channel.model.drive.kind != DriveKind::Pwm {
        let message = "makes no sense: duty belongs to drive kind \"pwm\"; take it out or change the drive";
        reader.out_of_place(stated, ("limits", "maximum_duty"), message);
    }
}

/// Fills in the computed defaults: what the wire cannot leave while everything is well.
pub(super) fn fill(channel: &mut Channel, reach: &Reach, stated: &Stated<'_>) {
    let given = |key| stated.gives("limits", key);
    let limits = &mut channel.limits;
    if !given("minimum_length_mm") {
        limits.min_length_m = reach.shortest_m();
    }
    if !given("maximum_length_mm") {
        limits.max_length_m = reach.longest_m();
    }
    if !given("maximum_temperature_c") {
        limits.max_temperature_c = reach.hottest_c();
    }
    let hottest_c = limits.max_temperature_c;
    if !given("continuous_current_a") {
        limits.continuous_current_a = reach.continuous_current_a(hottest_c);
    }
    if !given("energy_drain_w") {
        limits.energy_drain_w = heating_power_w(1.0, limits.continuous_current_a, reach.hot_ohm(hottest_c));
    }
    if !given("energy_budget_j") {
        limits.energy_budget_j = (1.25 * reach.heat_j(hottest_c)).max(1e-9);
    }
    if !given("default_hold_s") {
        limits.lease_s = 0.5_f64.min(limits.max_lease_s);
    }
    fill_electrical(channel, stated);
}

/// Current, power and duty, which follow from the hottest wire.
fn fill_electrical(channel: &mut Channel, stated: &Stated<'_>) {
    /// What an unpowered or unknown drive is given as full-on current (A) and power (W): no rig is driven with it.
    const UNKNOWN: f64 = 1.0;
    let given = |key| stated.gives("limits", key);
    let on = derive::full_on(channel, channel.limits.max_temperature_c);
    let largest_current_a = on.map_or(UNKNOWN, |on| on.largest_current_a);
    let largest_power_w = on.map_or(UNKNOWN, |on| on.largest_power_w);
    let limits = &mut channel.limits;
    if !given("maximum_current_a") {
        limits.max_current_a = 1.15 * largest_current_a;
    }
    if !given("maximum_power_w") {
        limits.max_power_w = 1.1 * largest_power_w;
    }
    if !given("maximum_duty") {
        // Where the supply is measured in the off-phase, that phase must never be shorter than the sensing pulse.
        let longest = match channel.adc.circuit {
            SamplingCircuit::SeparateTaps => 1.0,
            SamplingCircuit::Shared => 1.0 - channel.control.minimum_duty,
        };
        limits.max_duty = (limits.max_power_w / largest_power_w).min(longest);
    }
}

/// Limits of a complete channel that stand against each other.
pub(super) fn relations(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let Channel { limits, model, .. } = channel;
    if limits.min_length_m >= limits.max_length_m {
        reader.contradiction(
            stated,
            &[("limits", "minimum_length_mm"), ("limits", "maximum_length_mm")],
            format!(
                "leaves no length: minimum_length_mm is {}, maximum_length_mm {}; expected the minimum below the maximum",
                tidy(limits.min_length_m * 1e3),
                tidy(limits.max_length_m * 1e3)
            ),
        );
    }
    if limits.max_temperature_c <= model.ambient_c {
        let (hottest, ambient) = (limits.max_temperature_c, model.ambient_c);
        reader.contradiction(
            stated,
            &[("limits", "maximum_temperature_c")],
            format!("is {hottest}, expected more than the ambient temperature, {ambient}"),
        );
    }
    if let (Some(least), Some(most)) = (limits.min_force_n, limits.max_force_n)
        && least >= most
    {
        reader.contradiction(
            stated,
            &[("limits", "minimum_force_n"), ("limits", "maximum_force_n")],
            format!(
                "leaves no tension: minimum_force_n is {least}, maximum_force_n {most}; expected the minimum below the maximum"
            ),
        );
    }
    if limits.lease_s > limits.max_lease_s {
        reader.contradiction(
            stated,
            &[("limits", "default_hold_s"), ("limits", "maximum_hold_s")],
            format!(
                "leaves no lease: default_hold_s {} is above maximum_hold_s {}",
                limits.lease_s, limits.max_lease_s
            ),
        );
    }
}

/// The largest current of a complete channel against what its supply drives.
pub(super) fn relations_to_supply(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let limits = &channel.limits;
    if let Some(on) = derive::full_on(channel, limits.max_temperature_c)
        && limits.max_current_a < on.least_current_a
    {
        reader.contradiction(
            stated,
            &[("limits", "maximum_current_a")],
            format!(
                "is {}, but this supply drives {:.3} to {:.3} A through this wire whenever it is on; expected more",
                tidy(limits.max_current_a),
                on.least_current_a,
                on.largest_current_a
            ),
        );
    }
}
