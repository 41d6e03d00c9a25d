//! What the board says of itself, and what it bears.

use sinew_front_end::{ChannelLimits, ChannelRange, FULL_DUTY, Features, Identification, MAX_CHANNELS, ResetCause};

use sinew_front_end::frame::NAME_BYTES;

use crate::CHANNELS;
use crate::scale::{CURRENT_UA, FULL_CODE, SUPPLY_UV, VOLTAGE_UV};

/// The microcontroller's own watchdog, fed by the loop that polls, and the longest silence: the former is the shorter.
pub const WATCHDOG_NS: u32 = 200_000_000;
/// Longest time without a good frame.
pub const MAX_SILENCE_NS: u32 = 600_000_000;

/// 500 Hz at the most: USB at full speed transfers once a millisecond, and four wires on a UART of 2 Mbaud take a quarter of the period.
/// 10 Hz at the least: it has to be within [`MAX_SILENCE_NS`] a few times.
const MIN_PERIOD_NS: u32 = 2_000_000;
const MAX_PERIOD_NS: u32 = 100_000_000;

/// What a stage and its shunt (0.5 Ω, 1 W) bear: 1.4 A for ever, 2 A for a while.
const LIMITS: ChannelLimits =
    ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 2_000, heat_ma2_s: 4_000_000, drain_ma2: 2_000_000 };
const RANGE: ChannelRange =
    ChannelRange { voltage_uv: VOLTAGE_UV, current_ua: CURRENT_UA, supply_uv: SUPPLY_UV, limits: LIMITS };

/// A board's identification, by its firmware's name and version.
///
/// # Panics
/// Where the name is longer than 16 bytes.
pub const fn identification(called: &str, version: [u8; 3], serial: u64, reset: ResetCause) -> Identification {
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
    while index < called.len() {
        name[index] = called.as_bytes()[index];
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

/// The version of a package, by cargo's words for it; what is no number counts as 0.
pub const fn version(major: &str, minor: &str, patch: &str) -> [u8; 3] {
    const fn number(text: &str) -> u8 {
        let (text, mut value, mut index) = (text.as_bytes(), 0u8, 0);
        while index < text.len() && text[index].is_ascii_digit() {
            value = value.wrapping_mul(10).wrapping_add(text[index] - b'0');
            index += 1;
        }
        value
    }
    [number(major), number(minor), number(patch)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_bears_is_within_its_converters_and_its_watchdog_is_the_shorter() {
        let who = identification("sinew-rp2040", [1, 2, 3], 42, ResetCause::PowerOn);
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
    fn a_version_is_its_numbers() {
        assert_eq!(version("0", "12", "255"), [0, 12, 255]);
        assert_eq!(version("1", "", "3-rc1"), [1, 0, 3]);
    }
}
