//! The board with a NUCLEO-G474RE: which pin is what, what its timers count, and what its reset flags mean. The table in `docs/board.md` is
//! this one; a test compares them.

use core::fmt;

use sinew_front_end::ResetCause;

use crate::CHANNELS;
use crate::period::{cycles, on_ns};

/// What it calls itself.
pub const NAME: &str = "sinew-stm32g4";
/// The processor's clock, which its timers count, MHz.
pub const CLOCK_MHZ: u32 = 120;
/// Bits a second on the line: what a rig file has where it says nothing.
pub const BAUD_HZ: u32 = 2_000_000;

/// A pin of the STM32: its port and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    /// The port, 0 = A.
    pub port: u8,
    /// The number.
    pub number: u8,
    /// The alternate function by which a peripheral has it.
    pub function: Option<u8>,
}

impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{}{}", char::from(b'A' + self.port), self.number)
    }
}

const fn pin(port: char, number: u8) -> Pin {
    Pin { port: port as u8 - b'A', number, function: None }
}

const fn of(pin: Pin, function: u8) -> Pin {
    Pin { function: Some(function), ..pin }
}

/// Gates of the wires' stages, by channel: TIM1's four outputs.
pub const GATES: [Pin; CHANNELS] = [of(pin('C', 0), 2), of(pin('C', 1), 2), of(pin('C', 2), 2), of(pin('C', 3), 2)];
/// The master switch of the wires' supply: TIM8's first output.
pub const ENABLE: Pin = of(pin('C', 6), 4);
/// Second contact of the emergency stop, to ground: TIM1's break input. Low = closed.
pub const STOP: Pin = of(pin('B', 10), 12);
/// The same contact once more: TIM8's break input.
pub const STOP_ENABLE: Pin = of(pin('B', 7), 5);
/// Reset button of the emergency stop, to ground: low = pressed.
pub const STOP_RESET: Pin = pin('C', 4);
/// The converter's trigger: TIM2's fourth output.
pub const CONVST: Pin = of(pin('B', 11), 1);
/// High while it converts.
pub const BUSY: Pin = pin('B', 1);
/// Low resets it.
pub const ADC_RESET: Pin = pin('B', 2);
/// SPI 2, with the chip select in hardware.
pub const CS: Pin = of(pin('B', 12), 5);
/// Clock.
pub const SCLK: Pin = of(pin('B', 13), 5);
/// From the converter.
pub const SDOA: Pin = of(pin('B', 14), 5);
/// To the converter.
pub const SDI: Pin = of(pin('B', 15), 5);
/// The line, LPUART1: to the ST-LINK, and from it.
pub const TX: Pin = of(pin('A', 2), 12);
/// From the ST-LINK.
pub const RX: Pin = of(pin('A', 3), 12);
/// The Nucleo's own light, LD2.
pub const LED: Pin = pin('A', 5);
/// The wires' supply by its divider, on the STM32's own converter.
pub const SUPPLY: Pin = pin('A', 0);

/// Every pin, its name, and what holds it while the STM32 is reset or not there.
pub const TABLE: [(Pin, &str, &str); 19] = [
    (GATES[0], "gate 0", "10 kΩ to ground"),
    (GATES[1], "gate 1", "10 kΩ to ground"),
    (GATES[2], "gate 2", "10 kΩ to ground"),
    (GATES[3], "gate 3", "10 kΩ to ground"),
    (ENABLE, "enable", "10 kΩ to ground"),
    (STOP, "emergency stop, contact", "10 kΩ to 3.3 V: open"),
    (STOP_ENABLE, "emergency stop, contact", "the same"),
    (STOP_RESET, "emergency stop, reset button", "pull-up: released"),
    (CONVST, "CONVST", "10 kΩ to ground"),
    (BUSY, "BUSY", "–"),
    (ADC_RESET, "RESET", "10 kΩ to ground: in reset"),
    (CS, "CS", "10 kΩ to 3.3 V"),
    (SCLK, "SCLK", "–"),
    (SDOA, "SDOA", "–"),
    (SDI, "SDI", "–"),
    (TX, "line, to the ST-LINK", "–"),
    (RX, "line, from the ST-LINK", "–"),
    (LED, "light", "–"),
    (SUPPLY, "supply ÷ 4", "–"),
];

/// What TIM1 makes of a period: it counts once to its end and stops, and each output is on until its compare value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulses {
    /// Cycles of the clock a count, less one.
    pub prescaler: u16,
    /// Counts of the period, less one.
    pub reload: u16,
    /// Counts of each output's on-phase; 0 for none. One more than `reload` is all of the period.
    pub compare: [u16; CHANNELS],
}

impl Pulses {
    /// Of the duties of a period, as finely as sixteen bits count it.
    pub fn new(duty: &[u16], period_ns: u32) -> Pulses {
        let of_period = cycles(period_ns, CLOCK_MHZ).max(2);
        let divisor = of_period.div_ceil(u16::MAX.into()).min(u32::from(u16::MAX) + 1);
        let count = |cycles: u32| (cycles / divisor).min(u16::MAX.into()) as u16;
        let mut compare = [0; CHANNELS];
        for (compare, duty) in compare.iter_mut().zip(duty) {
            *compare = count(cycles(on_ns(*duty, period_ns), CLOCK_MHZ));
        }
        Pulses { prescaler: (divisor - 1) as u16, reload: count(of_period) - 1, compare }
    }
}

/// What TIM2 counts from the beginning of a period to a sweep.
pub fn trigger(at_ns: u32) -> u32 {
    cycles(at_ns, CLOCK_MHZ)
}

/// Flags of the STM32's resets, as RCC_CSR has them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ResetFlags {
    /// The independent watchdog, or the window watchdog.
    pub watchdog: bool,
    /// By software.
    pub software: bool,
    /// The option bytes were loaded, or the processor went into a low-power mode that it may not.
    pub other: bool,
    /// Its supply: power-on and brown-out have one flag.
    pub supply: bool,
}

/// Why it started. Flags gather until they are cleared: the watchdog's says more than one of the supply that came before. The pin NRST is set
/// by every cause: alone, it was a debugger or a button.
pub const fn reset_cause(flags: ResetFlags) -> ResetCause {
    match flags {
        ResetFlags { watchdog: true, .. } => ResetCause::Watchdog,
        ResetFlags { software: true, .. } => ResetCause::Software,
        ResetFlags { other: true, .. } => ResetCause::Unknown,
        ResetFlags { supply: true, .. } => ResetCause::PowerOn,
        _ => ResetCause::Unknown,
    }
}

/// A number of 64 bits of the chip's unique one of 96: its place on the wafer and the wafer's number, with the lot's text folded into them.
pub const fn serial(unique: [u32; 3]) -> u64 {
    let [place, wafer, lot] = unique;
    ((place ^ lot.rotate_left(16)) as u64) << 32 | (wafer ^ lot) as u64
}

#[cfg(test)]
mod tests {
    use sinew_front_end::FULL_DUTY;

    use super::*;

    /// ns of so many counts.
    fn ns(pulses: &Pulses, counts: u32) -> f64 {
        f64::from(counts) * (f64::from(pulses.prescaler) + 1.0) * 1000.0 / f64::from(CLOCK_MHZ)
    }

    #[test]
    fn pulses_are_their_duty_and_end_with_the_period() {
        for period_ns in [2_000_000, 4_000_000, 10_000_000, 100_000_000] {
            for duty in (0..=FULL_DUTY).step_by(97).chain([1, FULL_DUTY]) {
                let pulses = Pulses::new(&[duty, 0, FULL_DUTY], period_ns);
                let count_ns = ns(&pulses, 1);
                let wanted = f64::from(period_ns) * f64::from(duty) / f64::from(FULL_DUTY);
                let found = ns(&pulses, pulses.compare[0].into());
                assert!(found <= wanted && wanted - found < count_ns + 10.0, "{duty}: {found} ns for {wanted}");
                assert_eq!(pulses.compare[1], 0);
                assert_eq!(pulses.compare[2], pulses.reload + 1, "all of the period");
                assert_eq!(pulses.compare[3], 0, "a channel that is not used");
                let all = ns(&pulses, u32::from(pulses.reload) + 1);
                assert!(all <= f64::from(period_ns) && all > f64::from(period_ns) - count_ns - 10.0);
            }
        }
        let pulses = Pulses::new(&[FULL_DUTY], 2_000_000);
        assert_eq!((pulses.prescaler, pulses.reload, pulses.compare[0]), (3, 59_999, 60_000));
    }

    #[test]
    fn no_period_overflows() {
        for period_ns in [0, 1, 17, 546_125, u32::MAX] {
            let pulses = Pulses::new(&[FULL_DUTY; CHANNELS], period_ns);
            assert!(pulses.compare.iter().all(|compare| *compare <= pulses.reload.saturating_add(1)), "{pulses:?}");
        }
    }

    #[test]
    fn a_watchdog_reset_is_one_although_the_supply_came_before() {
        let all = ResetFlags { watchdog: true, software: true, other: true, supply: true };
        assert_eq!(reset_cause(all), ResetCause::Watchdog);
        assert_eq!(reset_cause(ResetFlags { watchdog: false, ..all }), ResetCause::Software);
        assert_eq!(reset_cause(ResetFlags { other: true, ..ResetFlags::default() }), ResetCause::Unknown);
        assert_eq!(reset_cause(ResetFlags { supply: true, ..ResetFlags::default() }), ResetCause::PowerOn);
        assert_eq!(reset_cause(ResetFlags::default()), ResetCause::Unknown);
    }

    #[test]
    fn chips_of_one_lot_or_one_place_have_numbers_of_their_own() {
        let one = [0x0021_0043, 0x5648_500e, 0x2034_3831];
        let numbers =
            [one, [0x0021_0044, one[1], one[2]], [one[0], 0x5648_5010, one[2]], [one[0], one[1], 0x2034_3832]];
        for (index, number) in numbers.iter().enumerate() {
            assert!(numbers[..index].iter().all(|other| serial(*other) != serial(*number)));
        }
    }
}
