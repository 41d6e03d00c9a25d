//! What a channel's codes and flags mean: its mode, its latched fault, the request it took.

use super::command::CommandKind;
use super::fields::ChannelState;
use crate::Fault;
use std::fmt;

/// What a channel is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Mode {
    /// Nothing is known about the wire yet: no complete sample has come.
    Waiting = 0,
    /// Only the sensing pulse.
    Off = 1,
    /// Length under control.
    Length = 2,
    /// Duty as commanded.
    Duty = 3,
    /// Force under control.
    Force = 4,
    /// The driver itself moves the wire (the built-in hexapod's walk).
    Program = 5,
    /// Switched off by a latched fault.
    Fault = 6,
    /// Off, because its setpoint's lease ended and nothing else moves it. No fault: the next setpoint is taken.
    Lapsed = 7,
}

impl Mode {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The mode with this number.
    pub const fn from_code(code: u32) -> Option<Mode> {
        Some(match code {
            0 => Mode::Waiting,
            1 => Mode::Off,
            2 => Mode::Length,
            3 => Mode::Duty,
            4 => Mode::Force,
            5 => Mode::Program,
            6 => Mode::Fault,
            7 => Mode::Lapsed,
            _ => return None,
        })
    }

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Mode::Waiting => "waiting",
            Mode::Off => "off",
            Mode::Length => "length",
            Mode::Duty => "duty",
            Mode::Force => "force",
            Mode::Program => "program",
            Mode::Fault => "fault",
            Mode::Lapsed => "lapsed",
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl ChannelState {
    /// The controller is at one of its two limits.
    pub const FLAG_SATURATED: u32 = 1;
    /// The target has been reached.
    pub const FLAG_SETTLED: u32 = 1 << 1;
    /// A limit of power, duty or tension holds the duty from what the controller asks for.
    pub const FLAG_LIMITED: u32 = 1 << 2;
    /// And that limit is the heat budget: the duty is derated, so that the wire takes no more than it can give off.
    pub const FLAG_HEAT_BUDGET: u32 = 1 << 3;
    /// And that limit is the estimated temperature: the duty is derated, so that it stays below its maximum.
    pub const FLAG_TEMPERATURE_BUDGET: u32 = 1 << 4;
    /// The fault that is latched was the first of those latched now on any channel.
    pub const FLAG_FIRST: u32 = 1 << 5;
    /// The period ahead is dark: no duty, so that it shows whether the output stage switches off. Its sample has no length.
    pub const FLAG_DARK: u32 = 1 << 6;
    /// The output has not confirmed its duty: it may be at any that it was given since it last did.
    pub const FLAG_UNCONFIRMED: u32 = 1 << 7;
    /// An emergency stop holds everything off: it is open, or has not been reset since.
    pub const FLAG_STOPPED: u32 = 1 << 8;

    /// Each of the flags: its bit and its name.
    pub const FLAGS: [(u32, &'static str); 9] = [
        (ChannelState::FLAG_SATURATED, "saturated"),
        (ChannelState::FLAG_SETTLED, "settled"),
        (ChannelState::FLAG_LIMITED, "limited"),
        (ChannelState::FLAG_HEAT_BUDGET, "heat_budget"),
        (ChannelState::FLAG_TEMPERATURE_BUDGET, "temperature_budget"),
        (ChannelState::FLAG_FIRST, "first"),
        (ChannelState::FLAG_DARK, "dark"),
        (ChannelState::FLAG_UNCONFIRMED, "unconfirmed"),
        (ChannelState::FLAG_STOPPED, "stopped"),
    ];

    /// The number for a request taken as the `place`th (from 1) of its cycle.
    pub const fn order_code(kind: CommandKind, place: u32) -> u32 {
        kind.code() | place << 8
    }

    /// The request taken right before this cycle, and as which one (from 1) of all channels'. A channel takes at most one a
    /// cycle, so that a recording has every one; its value is [`ChannelState::asked`], its lease the one that is left.
    pub fn order(&self) -> Option<(CommandKind, u32)> {
        Some((CommandKind::from_code(self.order & 0xff)?, self.order >> 8))
    }

    /// The latched fault, if any.
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.fault)
    }

    /// What the channel is doing.
    pub fn mode(&self) -> Mode {
        Mode::from_code(self.mode).unwrap_or(Mode::Waiting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_modes_code_survives_the_way_there_and_back_and_the_table_names_it() {
        let meaning = ChannelState::field("mode").unwrap().meaning;
        for code in 0..64 {
            assert!(Mode::from_code(code).is_none_or(|mode| mode.code() == code));
            assert!(Mode::from_code(code).is_none_or(|mode| meaning.contains(&format!("{code} {mode}"))), "{code}");
        }
        assert_eq!((0..64).filter(|c| Mode::from_code(*c).is_some()).count(), 8);
    }

    #[test]
    fn every_flag_has_a_bit_and_a_name_of_its_own_and_the_table_says_what_it_means() {
        let meaning = ChannelState::field("flags").unwrap().meaning;
        for (place, (bit, name)) in ChannelState::FLAGS.into_iter().enumerate() {
            assert_eq!(bit, 1 << place, "{name}");
            assert!(meaning.contains(&format!(" {bit} ")), "{name}");
            assert_eq!(ChannelState::FLAGS.iter().filter(|(_, other)| *other == name).count(), 1);
        }
    }

    #[test]
    fn a_request_is_found_again_in_the_state() {
        for kind in (0..64).filter_map(CommandKind::from_code) {
            let state = ChannelState { order: ChannelState::order_code(kind, 8), ..ChannelState::UNKNOWN };
            assert_eq!(state.order(), Some((kind, 8)));
        }
    }
}
