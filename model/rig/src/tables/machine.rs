//! `[machine]`: the tensile testing machine that `sinew test` mounts a wire in.

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};

table! {
    "machine", check chamber:
    "The tensile testing machine that `sinew test` mounts a wire in: cross-head, load cell, heater amplifier, thermal \
     chamber. The defaults are those of the thesis' machine (chapter 8, table 9).";

    /// A tensile testing machine: a cross-head that pulls a wire against a load cell, a heater amplifier, a thermal
    /// chamber (thesis, chapter 8, tables 8 and 9).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Machine {
        /// Rate of the machine's own loop and of its recordings. A multiple of the load cell's gives every conversion a
        /// row of its own.
        rate_hz: f64 = "rate_hz", number(si("Hz"), 10.0, 1000.0), Number(160.0);
        /// How far the cross-head travels; the wire is mounted so that half of it is left.
        travel_m: f64 = "travel_mm", number(milli("mm"), 1.0, 2000.0), Number(250.0);
        /// Smallest motion of the cross-head.
        microstep_m: f64 = "microstep_um", number(micro("µm"), 0.001, 1000.0), Number(0.625);
        /// Fastest cross-head.
        max_speed_m_s: f64 = "max_speed_mm_per_s", number(milli("mm/s"), 0.01, 5000.0), Number(400.0);
        /// Quickest change of its speed.
        max_acceleration_m_s2: f64 = "max_acceleration_mm_per_s2", number(milli("mm/s²"), 1.0, 1_000_000.0),
            Number(5000.0);
        /// By how much the frame gives: 0.01 mm under 5 kg. Known, and taken out of the measured position.
        compliance_m_per_n: f64 = "compliance_um_per_n", number(micro("µm/N"), 0.0, 1000.0), Number(0.204);
        /// Largest force of the load cell; a routine ends above it.
        max_force_n: f64 = "max_force_n", number(si("N"), 0.01, 10_000.0), Number(49.0);
        /// Conversions of the load cell a second.
        force_rate_hz: f64 = "force_rate_hz", number(si("Hz"), 1.0, 10_000.0), Number(80.0);
        /// Noise of a conversion, RMS: 0.75 g for the cell of 5 kg, 0.15 g (0.00147) for that of 1 kg.
        force_noise_n: f64 = "force_noise_n", number(si("N"), 0.0, 100.0), Number(0.00736);
        /// Largest elongation as a share of the wire's length; a routine ends above it.
        max_strain: f64 = "max_strain", number(si("1"), 0.0001, 1.0), Number(0.08);
        /// Largest voltage of the heater amplifier.
        heater_supply_v: f64 = "heater_supply_v", number(si("V"), 0.1, 1000.0), Number(12.0);
        /// Cut-off of the filter before the amplifier.
        heater_cutoff_hz: f64 = "heater_cutoff_hz", number(si("Hz"), 0.1, 100_000.0), Number(40.0);
        /// Step of the measured current.
        current_step_a: f64 = "current_step_a", number(si("A"), 0.0, 1.0), Number(0.0001);
        /// Noise of the measured current, averaged over a row, RMS.
        current_noise_a: f64 = "current_noise_a", number(si("A"), 0.0, 1.0), Number(0.00005);
        /// Step of the measured voltages.
        voltage_step_v: f64 = "voltage_step_v", number(si("V"), 0.0, 1.0), Number(0.004);
        /// Noise of the measured voltages, averaged over a row, RMS.
        voltage_noise_v: f64 = "voltage_noise_v", number(si("V"), 0.0, 1.0), Number(0.002);
        /// Coldest the thermal chamber gets.
        chamber_min_c: f64 = "chamber_min_c", number(si("°C"), -200.0, 800.0), Number(0.0);
        /// Warmest it gets.
        chamber_max_c: f64 = "chamber_max_c", number(si("°C"), -200.0, 800.0), Number(95.0);
        /// Heat that its thermo-electric elements pump either way.
        chamber_power_w: f64 = "chamber_power_w", number(si("W"), 0.0, 100_000.0), Number(80.0);
        /// Time constant of the chamber left to itself.
        chamber_time_s: f64 = "chamber_time_s", number(si("s"), 0.1, 100_000.0), Number(150.0);
        /// Noise of its thermocouple, which is read 10 times a second in steps of 0.25 K, RMS.
        chamber_noise_k: f64 = "chamber_noise_k", number(si("K"), 0.0, 10.0), Number(0.1);
    }
}

fn chamber(reader: &mut Reader<'_>, machine: &Machine, stated: &Stated<'_>) {
    let (low, high) = (machine.chamber_min_c, machine.chamber_max_c);
    if low > high {
        let message = format!("is {high}, below chamber_min_c = {low}, expected a warmer one");
        let line = stated.line_of_first(&[("machine", "chamber_max_c"), ("machine", "chamber_min_c")]);
        reader.problem(line, None, "machine.chamber_max_c", What::Contradiction { message });
    }
}
