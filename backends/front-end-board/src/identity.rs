//! What the board says of itself, and what it bears.

use sinew_front_end::{ChannelLimits, ChannelRange, FULL_DUTY, Features, Identification, MAX_CHANNELS, ResetCause};

use sinew_front_end::frame::NAME_BYTES;

use crate::pins::CHANNELS;
use crate::scale::{CURRENT_UA, FULL_CODE, SUPPLY_UV, VOLTAGE_UV};

/// The RP2040's own watchdog, fed by the loop that polls, and the longest silence: the former is the shorter.
pub const WATCHDOG_NS: u32 = 200_000_000;
/// Longest time without a good frame.
pub const MAX_SILENCE_NS: u32 = 600_000_000;

/// 500 Hz at the most: USB at full speed transfers once a millisecond. 10 Hz at the least: it has to be within [`MAX_SILENCE_NS`] a few
/// times.
const MIN_PERIOD_NS: u32 = 2_000_000;
const MAX_PERIOD_NS: u32 = 100_000_000;
const NAME: &[u8] = b"sinew-rp2040";

/// What a stage and its shunt (0.5 Ω, 1 W) bear: 1.4 A for ever, 2 A for a while.
const LIMITS: ChannelLimits =
    ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 2_000, heat_ma2_s: 4_000_000, drain_ma2: 2_000_000 };
const RANGE: ChannelRange =
    ChannelRange { voltage_uv: VOLTAGE_UV, current_ua: CURRENT_UA, supply_uv: SUPPLY_UV, limits: LIMITS };

/// The board's identification; `version` is the firmware's.
pub const fn identification(version: [u8; 3], serial: u64, reset: ResetCause) -> Identification {
    let mut channel = [ChannelRange {
        voltage_uv: 0,
        current_ua: 0,
        supply_uv: 0,
        limits: ChannelLimits { max_duty: 0, max_current_ma: 0, heat_ma2_s: 0, drain_ma2: 0 },
    }; MAX_CHANNELS];
    let mut index = 0;
    while index < CHANNELS {
        channel[index] = RANGE;
        index += 1;
    }
    let mut name = [0; NAME_BYTES];
    let mut index = 0;
    while index < NAME.len() {
        name[index] = NAME[index];
        index += 1;
    }
    Identification {
        nonce: 0,
        name,
        version,
        serial,
        min_period_ns: MIN_PERIOD_NS,
        max_period_ns: MAX_PERIOD_NS,
        max_silence_ns: MAX_SILENCE_NS,
        full_code: FULL_CODE,
        features: Features { enable: true, stop: true },
        reset,
        user: 0,
        unused_ms: 0,
        channels: CHANNELS as u8,
        channel,
    }
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
    use super::*;

    #[test]
    fn what_it_bears_is_within_its_converters_and_its_watchdog_is_the_shorter() {
        let who = identification([1, 2, 3], 42, ResetCause::PowerOn);
        assert_eq!((who.channels, who.version, who.serial), (4, [1, 2, 3], 42));
        assert!(who.name.starts_with(b"sinew-rp2040\0"));
        for range in &who.channel[..CHANNELS] {
            assert!(u32::from(range.limits.max_current_ma) * 1000 < range.current_ua, "seen before it saturates");
            assert!(u32::from(range.limits.max_current_ma).pow(2) > range.limits.drain_ma2);
        }
        assert_eq!(who.channel[CHANNELS], ChannelRange::default());
        const { assert!(WATCHDOG_NS < MAX_SILENCE_NS) };
        const { assert!(MAX_PERIOD_NS < WATCHDOG_NS) };
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
