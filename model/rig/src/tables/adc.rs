//! `[channel.adc]`: the converter that measures the wire.

use sinew_physics::DriveKind;

use crate::declare::rows::*;
use crate::derive;
use crate::notes::{Reader, Stated, tidy};
use crate::tables::Channel;

words! {
    /// How the converter is wired to the heating circuit.
    pub enum SamplingCircuit, default SeparateTaps {
        /// V_3 and the shunt have inputs of their own, sampled in the on-phase; the wire's fixed end is ground.
        SeparateTaps = "separate_taps",
        /// One input at the wire's low end, behind which switch and shunt lead to ground, is sampled twice a period
        /// (thesis, chapter 6): in the off-phase it sees the supply, in the on-phase what the current leaves on switch
        /// and shunt.
        Shared = "shared",
    }
}

table! {
    "channel.adc" of Channel, at (adc):
    "The converter that measures the wire, as the simulated backend plays it and the driver expects it.";

    /// The analogue-to-digital converter of one channel; its voltages and its current begin at 0.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Adc {
        /// V_3 and shunt on inputs of their own, or one input for the supply in the off-phase and shunt and switch in
        /// the on-phase: [sensing](sensing.md#the-two-circuits).
        circuit: SamplingCircuit = "circuit", SamplingCircuit::KIND, SamplingCircuit::DEFAULT;
        /// Resolution over the range.
        bits: u32 = "bits", integer(4, 32), Integer(16);
        /// Full scale of the voltages.
        voltage_range_v: f64 = "voltage_range_v", number(si("V"), 0.001, 1e5),
            Computed("10, or 1.25 × `supply_v` where that is more");
        /// Full scale of the current; above `maximum_current_a`; not for a shared input.
        current_range_a: f64 = "current_range_a", number(si("A"), 1e-6, 1e5), Computed("1.1 × `maximum_current_a`");
        /// RMS noise of a voltage sample.
        voltage_noise_v: f64 = "voltage_noise_v", number(si("V"), 0.0, 100.0), Number(0.0015);
        /// RMS noise of a current sample; not for a shared input.
        current_noise_a: f64 = "current_noise_a", number(si("A"), 0.0, 100.0), Number(0.0004);
        /// Offset of the voltage samples.
        voltage_offset_v: f64 = "voltage_offset_v", number(si("V"), -100.0, 100.0), Number(0.0);
        /// Offset of the current samples; not for a shared input.
        current_offset_a: f64 = "current_offset_a", number(si("A"), -100.0, 100.0), Number(0.0);
        /// RMS noise of the measured supply; not for a shared input.
        supply_noise_v: f64 = "supply_noise_v", number(si("V"), 0.0, 100.0), Number(0.003);
    }
}

/// Fills in the computed defaults; the limits are complete.
pub(crate) fn fill(channel: &mut Channel, stated: &Stated<'_>) {
    if !stated.gives("adc", "voltage_range_v") {
        let supply = channel.model.drive.supply_v;
        channel.adc.voltage_range_v = if 1.25 * supply > 10.0 { 1.25 * supply } else { 10.0 };
    }
    if !stated.gives("adc", "current_range_a") {
        channel.adc.current_range_a = 1.1 * channel.limits.max_current_a;
    }
}

/// The ranges against the limits of a channel that is complete.
pub(crate) fn relations(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
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
