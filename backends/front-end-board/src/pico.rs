//! The board with a Raspberry Pi Pico: which pin is what, what its PIO counts, and what its reset flags mean. The table in `docs/board.md` is
//! this one; a test compares them.

use sinew_front_end::ResetCause;

use crate::CHANNELS;
use crate::period::{Plan, cycles, on_ns};

/// What it calls itself.
pub const NAME: &str = "sinew-rp2040";
/// The RP2040's clock, which its PIO counts, MHz.
pub const CLOCK_MHZ: u32 = 125;

/// Cycles that the pulse's program takes beside its count, and a trigger's between two counts.
const PULSE_CYCLES: u32 = 2;
const TRIGGER_CYCLES: u32 = 20;

/// Gates of the wires' stages, by channel.
pub const GATES: [u8; CHANNELS] = [2, 3, 4, 5];
/// The master switch of the wires' supply.
pub const ENABLE: u8 = 6;
/// Second contact of the emergency stop, to ground: low = closed.
pub const STOP: u8 = 7;
/// Reset button of the emergency stop, to ground: low = pressed.
pub const STOP_RESET: u8 = 8;
/// The converter's pins beside its SPI.
pub const CONVST: u8 = 10;
/// High while it converts.
pub const BUSY: u8 = 11;
/// Low resets it.
pub const ADC_RESET: u8 = 12;
/// SPI 0, with the chip select in hardware.
pub const SDOA: u8 = 16;
/// Chip select.
pub const CS: u8 = 17;
/// Clock.
pub const SCLK: u8 = 18;
/// To the converter.
pub const SDI: u8 = 19;
/// The Pico's own light.
pub const LED: u8 = 25;
/// The wires' supply by its divider, on the RP2040's own converter.
pub const SUPPLY: u8 = 26;

/// Every pin: number, name, and what holds it while the RP2040 is reset or not there.
pub const TABLE: [(u8, &str, &str); 16] = [
    (GATES[0], "gate 0", "10 kΩ to ground"),
    (GATES[1], "gate 1", "10 kΩ to ground"),
    (GATES[2], "gate 2", "10 kΩ to ground"),
    (GATES[3], "gate 3", "10 kΩ to ground"),
    (ENABLE, "enable", "10 kΩ to ground"),
    (STOP, "emergency stop, contact", "pull-up: open"),
    (STOP_RESET, "emergency stop, reset button", "pull-up: released"),
    (CONVST, "CONVST", "10 kΩ to ground"),
    (BUSY, "BUSY", "–"),
    (ADC_RESET, "RESET", "10 kΩ to ground: in reset"),
    (SDOA, "SDOA", "–"),
    (CS, "CS", "10 kΩ to 3.3 V"),
    (SCLK, "SCLK", "–"),
    (SDI, "SDI", "–"),
    (LED, "light", "–"),
    (SUPPLY, "supply ÷ 4", "–"),
];

/// The count that makes an output's pulse of `duty` of a period, `None` for none. The output goes off by itself when it is over.
pub fn pulse(duty: u16, period_ns: u32) -> Option<u32> {
    let cycles = cycles(on_ns(duty, period_ns), CLOCK_MHZ);
    (cycles > PULSE_CYCLES).then(|| cycles - PULSE_CYCLES)
}

/// The counts that make the trigger's pulses: the first from the beginning of the period, each other from the one before.
pub fn triggers(plan: &Plan) -> impl Iterator<Item = u32> + '_ {
    let before = core::iter::once(0).chain(plan.sweeps().iter().map(|sweep| sweep.at_ns));
    plan.sweeps()
        .iter()
        .zip(before)
        .map(|(sweep, before)| cycles(sweep.at_ns - before, CLOCK_MHZ).saturating_sub(TRIGGER_CYCLES))
}

/// Why it started, by the flags of the RP2040's watchdog (time-out, forced) and of its chip reset (power-on, pin RUN, debugger). The
/// watchdog's come first: a reset by it leaves the others as they were. The chip has one flag for power-on and brown-out, and the pin RUN may
/// be anybody's.
pub const fn reset_cause(timed_out: bool, forced: bool, power_on: bool, run: bool, debugger: bool) -> ResetCause {
    match (timed_out, forced) {
        (true, _) => ResetCause::Watchdog,
        (_, true) => ResetCause::Software,
        _ if debugger => ResetCause::Software,
        _ if run => ResetCause::Unknown,
        _ if power_on => ResetCause::PowerOn,
        _ => ResetCause::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use sinew_front_end::FULL_DUTY;

    use super::*;

    const PERIOD_NS: u32 = 2_000_000;

    #[test]
    fn a_pulse_is_its_duty_and_never_longer_than_the_period() {
        assert_eq!(pulse(0, PERIOD_NS), None);
        assert_eq!(pulse(1, 2_000), None, "shorter than the program");
        assert_eq!(pulse(FULL_DUTY, PERIOD_NS), Some(250_000 - 2));
        for duty in (0..=FULL_DUTY).step_by(77) {
            let ns = pulse(duty, PERIOD_NS).map_or(0, |count| (count + 2) * 8);
            let wanted = f64::from(PERIOD_NS) * f64::from(duty) / f64::from(FULL_DUTY);
            assert!((wanted - f64::from(ns)) < 32.0 && f64::from(ns) <= wanted, "{duty}: {ns} ns for {wanted}");
        }
        assert_eq!(pulse(FULL_DUTY, u32::MAX), Some((u64::from(u32::MAX) * 125 / 1000) as u32 - 2));
    }

    #[test]
    fn triggers_add_up() {
        let plan = Plan::new(&[16_384, 16_384, 0, 62_000], PERIOD_NS);
        assert_eq!(plan.sweeps().len(), 3);
        let mut cycles = 0;
        for (count, sweep) in triggers(&plan).zip(plan.sweeps()) {
            cycles += count + TRIGGER_CYCLES;
            assert!((sweep.at_ns / 8).abs_diff(cycles) <= 3, "{plan:?}");
        }
    }

    #[test]
    fn a_watchdog_reset_is_one_although_the_supply_came_before() {
        assert_eq!(reset_cause(true, false, true, false, false), ResetCause::Watchdog);
        assert_eq!(reset_cause(false, true, true, false, false), ResetCause::Software);
        assert_eq!(reset_cause(false, false, true, false, false), ResetCause::PowerOn);
        assert_eq!(reset_cause(false, false, false, true, false), ResetCause::Unknown);
        assert_eq!(reset_cause(false, false, false, false, true), ResetCause::Software);
    }
}
