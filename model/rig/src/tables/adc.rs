//! `[channel.adc]`: the converter that measures the wire.

use crate::declare::rows::*;

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
    "channel.adc":
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
