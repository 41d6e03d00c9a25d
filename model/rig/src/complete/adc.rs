//! The converter: its computed defaults, and its ranges against the limits.

use sinew_physics::DriveKind;

use crate::derive;
use crate::notes::{Reader, Stated, tidy};
use crate::tables::{Channel, SamplingCircuit};

/// Fills in the computed defaults; the limits are complete.
pub(super) fn fill(channel: &mut Channel, stated: &Stated<'_>) {
    if !stated.gives("adc", "voltage_range_v") {
        let supply = channel.model.drive.supply_v;
        channel.adc.voltage_range_v = if 1.25 * supply > 10.0 { 1.25 * supply } else { 10.0 };
    }
    if !stated.gives("adc", "current_range_a") {
        channel.adc.current_range_a = 1.1 * channel.limits.max_current_a;
    }
}

/// The ranges against the limits of a channel that is complete.
pub(super) fn relations(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let Channel { limits, adc, model, .. } = channel;
    if model.drive.kind != DriveKind::Pwm {
        return;
    }
    if adc.circuit == SamplingCircuit::Shared {
        shared_input(reader, channel, stated);
    } else if adc.current_range_a <= limits.max_current_a {
        reader.contradiction(
            stated,
            &[("adc", "current_range_a"), ("limits", "maximum_current_a")],
            format!(
                "hides an over-current: current_range_a {} must be above maximum_current_a {}",
                tidy(adc.current_range_a),
                tidy(limits.max_current_a)
            ),
        );
    }
}

/// What one input for supply and shunt needs: something to show the current by, room for the supply, and an off-phase.
fn shared_input(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    /// How far the current must stand clear of the input's noise, in standard deviations.
    const CLEAR: f64 = 16.0;
    let Channel { limits, adc, control, model, .. } = channel;
    let drive = &model.drive;
    let low_ohm = drive.low_ohm();
    let on_v = derive::full_on(channel, limits.max_temperature_c).map_or(0.0, |on| on.least_current_a * low_ohm);
    if on_v <= CLEAR * adc.voltage_noise_v {
        reader.contradiction(
            stated,
            &[("adc", "circuit"), ("drive", "shunt_ohm")],
            format!(
                "is \"shared\", but shunt_ohm + switch_ohm = {low_ohm} Ω show the current by {:.2} mV only, in {} mV of \
                 noise; expected more than {CLEAR} times the noise: a larger shunt, or a better converter",
                tidy(on_v * 1e3),
                tidy(adc.voltage_noise_v * 1e3)
            ),
        );
    }
    if adc.voltage_range_v <= drive.supply_v {
        reader.contradiction(
            stated,
            &[("adc", "voltage_range_v")],
            format!(
                "is {}, but the shared input sees the whole supply_v, {}; expected more",
                adc.voltage_range_v, drive.supply_v
            ),
        );
    }
    if limits.max_current_a * low_ohm >= adc.voltage_range_v {
        reader.contradiction(
            stated,
            &[("limits", "maximum_current_a")],
            format!(
                "is {}, but a shared input over {low_ohm} Ω ends at {} A; expected less",
                tidy(limits.max_current_a),
                tidy(adc.voltage_range_v / low_ohm)
            ),
        );
    }
    if limits.max_duty + control.minimum_duty > 1.0 {
        reader.contradiction(
            stated,
            &[("limits", "maximum_duty"), ("control", "sensing_duty")],
            format!(
                "leaves no off-phase to see the supply in: maximum_duty {} and sensing_duty {} must not be more than 1 together",
                limits.max_duty, control.minimum_duty
            ),
        );
    }
}
