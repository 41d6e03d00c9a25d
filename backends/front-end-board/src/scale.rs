//! Codes of the converters to those of the protocol.

use crate::ad7616::WireCodes;

/// The largest code that goes up the line.
pub const FULL_CODE: u16 = 65_534;
/// The shunt between each wire's fixed end and ground, Ω.
pub const SHUNT_OHM: f64 = 0.5;
/// The supply's divider before the microcontroller's own converter.
pub const SUPPLY_DIVIDER: u32 = 4;

/// Full scales of the protocol's codes: the converter's ±10 V, ±2.5 V over the shunt, and 3.3 V behind the divider.
pub(crate) const VOLTAGE_UV: u32 = 10_000_000;
pub(crate) const CURRENT_UA: u32 = (2_500_000.0 / SHUNT_OHM) as u32;
pub(crate) const SUPPLY_UV: u32 = 3_300_000 * SUPPLY_DIVIDER;

/// A tap's voltage against the wire's fixed end, which stands on the shunt: a code of 10 V, 0 below 0 V. An input at the end of its range
/// stays at the end.
pub fn voltage_code(wire: &WireCodes, tap: i16) -> u16 {
    if tap == i16::MAX {
        return FULL_CODE;
    }
    // A code of the shunt's range is a quarter of one of the tap's; half of the latter is one of the line's.
    let quarters = 4 * i32::from(tap) - i32::from(wire.shunt);
    (quarters / 2).clamp(0, FULL_CODE.into()) as u16
}

/// The current: a code of 2.5 V over the shunt.
pub fn current_code(wire: &WireCodes) -> u16 {
    2 * wire.shunt.max(0) as u16
}

/// The supply, from 12 bits of the microcontroller's own converter.
pub fn supply_code(code: u16) -> u16 {
    (u32::from(code.min(4095)) * u32::from(FULL_CODE) / 4095) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wire(v1_v: f64, v2_v: f64, v3_v: f64, shunt_v: f64) -> WireCodes {
        let code = |volts: f64, range: f64| (volts / range * 32768.0).round() as i16;
        WireCodes { v1: code(v1_v, 10.0), v2: code(v2_v, 10.0), v3: code(v3_v, 10.0), shunt: code(shunt_v, 2.5) }
    }

    #[test]
    fn voltages_stand_on_the_fixed_end() {
        // 0.5 A through 0.5 Ω below the wire.
        let wire = wire(0.25, 5.25, 5.75, 0.25);
        let volts = |code: u16| f64::from(code) * 10.0 / f64::from(FULL_CODE);
        assert!(volts(voltage_code(&wire, wire.v1)) < 0.000_4);
        assert!((volts(voltage_code(&wire, wire.v2)) - 5.0).abs() < 0.000_5);
        assert!((volts(voltage_code(&wire, wire.v3)) - 5.5).abs() < 0.000_5);
        let amperes = f64::from(current_code(&wire)) * f64::from(CURRENT_UA) * 1e-6 / f64::from(FULL_CODE);
        assert!((amperes - 0.5).abs() < 0.000_2, "{amperes}");
    }

    #[test]
    fn ends_of_ranges_stay_ends_and_nothing_is_not_sampled() {
        let top = WireCodes { v1: i16::MIN, v2: i16::MAX, v3: 32_766, shunt: i16::MAX };
        assert_eq!(voltage_code(&top, top.v1), 0);
        assert_eq!(voltage_code(&top, top.v2), FULL_CODE);
        assert_eq!(current_code(&top), FULL_CODE);
        let dark = WireCodes { shunt: -7, ..WireCodes::default() };
        assert_eq!((voltage_code(&dark, dark.v3), current_code(&dark)), (3, 0));
        assert_eq!((supply_code(0), supply_code(4095), supply_code(u16::MAX)), (0, FULL_CODE, FULL_CODE));
    }
}
