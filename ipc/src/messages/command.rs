//! What a client may request of a driver, and what it is answered.

use crate::Fault;
use iceoryx2::prelude::ZeroCopySend;
use std::time::Duration;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// What a command asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum CommandKind {
    /// Hold a wire length, m.
    Length = 1,
    /// Hold a share of the stroke, 0 (cold) .. 1 (hot).
    Stroke = 2,
    /// Give a duty, 0..1.
    Duty = 3,
    /// Hold a tension, N.
    Force = 4,
    /// Only the sensing pulse.
    Off = 5,
    /// Clear a latched fault whose cause has gone.
    Reset = 6,
    /// Stop the driver.
    Stop = 7,
    /// Have the channel to oneself, with a priority, 0..9: others' setpoints and resets are refused.
    Claim = 8,
    /// Let go of a claim.
    Release = 9,
}

impl CommandKind {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The kind with this number.
    pub const fn from_code(code: u32) -> Option<CommandKind> {
        Some(match code {
            1 => CommandKind::Length,
            2 => CommandKind::Stroke,
            3 => CommandKind::Duty,
            4 => CommandKind::Force,
            5 => CommandKind::Off,
            6 => CommandKind::Reset,
            7 => CommandKind::Stop,
            8 => CommandKind::Claim,
            9 => CommandKind::Release,
            _ => return None,
        })
    }

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            CommandKind::Length => "length",
            CommandKind::Stroke => "stroke",
            CommandKind::Duty => "duty",
            CommandKind::Force => "force",
            CommandKind::Off => "off",
            CommandKind::Reset => "reset",
            CommandKind::Stop => "stop",
            CommandKind::Claim => "claim",
            CommandKind::Release => "release",
        }
    }

    /// Unit of its value.
    pub const fn unit(self) -> &'static str {
        match self {
            CommandKind::Length => "m",
            CommandKind::Force => "N",
            _ => "",
        }
    }
}

/// What is asked of one channel. A request of a client is one of these, or up to [`MAX_CHANNELS`](crate::MAX_CHANNELS) setpoints (or claims, or
/// releases), each for another channel and with the same `sequence`: all of them are carried out in one cycle, or none.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Command")]
#[repr(C)]
pub struct Command {
    /// Who asks: process id in the upper half, a count inside that process in the lower.
    pub client: u64,
    /// Number of the request, counted by the client; the reply repeats it.
    pub sequence: u64,
    /// Number of the channel, or [`ALL_CHANNELS`](crate::ALL_CHANNELS) (off, reset, stop).
    pub channel: u32,
    /// What is asked for: [`CommandKind`].
    pub kind: u32,
    /// Value in SI units; 0 where the kind has none.
    pub value: f64,
    /// For how long the setpoint holds unless it is renewed, s; 0 = the channel's own default.
    pub hold_s: f64,
}

impl Command {
    /// From bytes as a client may send them: any bits at all are a command, and what it means is judged at the driver's desk.
    /// `None` where there are not as many as a command has.
    pub fn from_bytes(bytes: &[u8]) -> Option<Command> {
        Command::read_from_bytes(bytes).ok()
    }

    /// What is asked for, if this version knows it.
    pub fn kind(&self) -> Option<CommandKind> {
        CommandKind::from_code(self.kind)
    }

    /// Whether all that these ask for is less power: then they are carried out however late they come, whoever has stopped waiting for them.
    pub fn only_switch_off(commands: &[Command]) -> bool {
        commands.iter().all(|command| matches!(command.kind(), Some(CommandKind::Off | CommandKind::Stop)))
    }
}

/// How the commands of a request are meant, all of them.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Terms")]
#[repr(C)]
pub struct Terms {
    /// Not to be carried out after this time (CLOCK_MONOTONIC, ns): nobody waits for it any more.
    pub until_ns: u64,
    /// The time in which its setpoints are approached in a straight line from what was wanted before, s; 0 = they hold at once.
    pub over_s: f64,
    /// 0 for a request of its own; else the number of a [stream of setpoints](crate::Setpoints), counted by its client: each of its requests
    /// overtakes those before it that still wait.
    pub stream: u64,
}

impl Terms {
    /// Of a request of its own.
    pub const fn until(until_ns: u64) -> Terms {
        Terms { until_ns, over_s: 0.0, stream: 0 }
    }

    /// Of a request of its own that is not to be carried out later than so long from now.
    pub fn within(patience: Duration) -> Terms {
        let patience_ns = u64::try_from(patience.as_nanos()).unwrap_or(u64::MAX);
        Terms::until(crate::monotonic_ns().saturating_add(patience_ns))
    }

    /// What a request for these commands is answered that comes too late, if it does at this time. What only switches off never does.
    pub fn is_late(&self, commands: &[Command], now_ns: u64) -> Option<Outcome> {
        let outcome = if self.stream == 0 { Outcome::Busy } else { Outcome::Late };
        (now_ns > self.until_ns && !Command::only_switch_off(commands)).then_some(outcome)
    }
}

impl Default for Terms {
    /// A request of its own, whenever it comes.
    fn default() -> Terms {
        Terms::until(u64::MAX)
    }
}

/// What became of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Outcome {
    /// The loop has it.
    Taken = 0,
    /// There is no channel of that number.
    UnknownChannel = 1,
    /// This driver does not know that kind of command.
    UnknownCommand = 2,
    /// Value or hold is NaN or infinite.
    NotFinite = 3,
    /// The value is outside `low..=high`.
    OutOfRange = 4,
    /// The hold is outside `low..=high`, s.
    HoldOutOfRange = 5,
    /// The channel is off by a latched fault: reset it first.
    Faulted = 6,
    /// The cause of the fault is still there: a reset is refused.
    CauseRemains = 7,
    /// The channel has not proved its sensors yet.
    Waiting = 8,
    /// This channel cannot do that (no force control, say).
    Unsupported = 9,
    /// Too many commands at once: try again.
    Busy = 10,
    /// The driver is stopping.
    Stopping = 11,
    /// Who asks may look but not command.
    NotPermitted = 12,
    /// Not carried out: an `off` that was asked for later has overtaken it.
    Overtaken = 13,
    /// The fault cannot be cleared yet: the wire has to cool first.
    TooHot = 14,
    /// Not carried out because another one of the same request was refused.
    WithOthers = 15,
    /// The request names the channel twice, or asks beside others for what is asked for alone (a reset, a stop).
    NotTogether = 16,
    /// Another client has claimed the channel.
    Claimed = 17,
    /// Not carried out: the setpoint of a stream came after its deadline.
    Late = 18,
    /// The time to approach a setpoint in is outside `low..=high`, s.
    ApproachOutOfRange = 19,
}

impl Outcome {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The outcome with this number.
    pub const fn from_code(code: u32) -> Option<Outcome> {
        Some(match code {
            0 => Outcome::Taken,
            1 => Outcome::UnknownChannel,
            2 => Outcome::UnknownCommand,
            3 => Outcome::NotFinite,
            4 => Outcome::OutOfRange,
            5 => Outcome::HoldOutOfRange,
            6 => Outcome::Faulted,
            7 => Outcome::CauseRemains,
            8 => Outcome::Waiting,
            9 => Outcome::Unsupported,
            10 => Outcome::Busy,
            11 => Outcome::Stopping,
            12 => Outcome::NotPermitted,
            13 => Outcome::Overtaken,
            14 => Outcome::TooHot,
            15 => Outcome::WithOthers,
            16 => Outcome::NotTogether,
            17 => Outcome::Claimed,
            18 => Outcome::Late,
            19 => Outcome::ApproachOutOfRange,
            _ => return None,
        })
    }
}

/// The driver's answer to a [`Command`]. A request gets as many as it has commands, in their order.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Reply")]
#[repr(C)]
pub struct Reply {
    /// Number of the request this answers.
    pub sequence: u64,
    /// What became of it: [`Outcome`].
    pub outcome: u32,
    /// The fault in the way: [`Fault`] or 0.
    pub fault: u32,
    /// Number of the channel this is about.
    pub channel: u32,
    /// For [`Outcome::Claimed`] the process id of whoever has claimed it, else 0.
    pub owner: u32,
    /// The value as taken, in the command's unit; for [`Outcome::TooHot`] the temperature that is believed of the wire, °C; for
    /// [`Outcome::Claimed`] the claim's priority.
    pub value: f64,
    /// Smallest value or hold that would have been taken; NaN where it does not matter.
    pub low: f64,
    /// Largest value or hold that would have been taken; NaN where it does not matter. For [`Outcome::TooHot`] the temperature the wire has to
    /// come down to, °C.
    pub high: f64,
    /// The lease as granted, s; 0 where there is none. For [`Outcome::TooHot`] how long that takes at the most, s; NaN where it is not known.
    /// For [`Outcome::Claimed`] how long the claim holds unless it is renewed, s.
    pub hold_s: f64,
    /// Number of the cycle in which the loop took it; 0 where it did not.
    pub cycle: u64,
}

impl Reply {
    /// The command was taken, with this lease, s.
    pub fn taken(command: &Command, hold_s: f64) -> Reply {
        Reply {
            sequence: command.sequence,
            outcome: Outcome::Taken.code(),
            fault: 0,
            channel: command.channel,
            owner: 0,
            value: command.value,
            low: f64::NAN,
            high: f64::NAN,
            hold_s,
            cycle: 0,
        }
    }

    /// Taken in this cycle.
    pub fn in_cycle(self, cycle: u64) -> Reply {
        Reply { cycle, ..self }
    }

    /// The command was refused.
    pub fn refused(command: &Command, outcome: Outcome) -> Reply {
        Reply { outcome: outcome.code(), ..Reply::taken(command, 0.0) }
    }

    /// With the range that would have been taken.
    pub fn range(self, low: f64, high: f64) -> Reply {
        Reply { low, high, ..self }
    }

    /// With how long it takes at the most until it would be taken, s, what is believed of the wire's temperature, °C, and what that has to come
    /// down to, °C.
    pub fn until(self, longest_s: f64, temperature_c: f64, below_c: f64) -> Reply {
        Reply { hold_s: longest_s, value: temperature_c, high: below_c, ..self }
    }

    /// With the claim in the way: whose it is (process id), its priority, and how long it holds unless it is renewed, s.
    pub fn claimed_by(self, owner: u32, priority: u32, left_s: f64) -> Reply {
        Reply { owner, value: priority.into(), hold_s: left_s, ..self }
    }

    /// With the fault in the way.
    pub fn because(self, fault: Fault) -> Reply {
        Reply { fault: fault.code(), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        // A change here is a change of the protocol: raise PROTOCOL with it.
        assert_eq!(size_of::<Command>(), 40);
        assert_eq!(size_of::<Terms>(), 24);
        assert_eq!(size_of::<Reply>(), 64);
    }

    #[test]
    fn codes_survive_the_way_there_and_back() {
        for code in 0..64 {
            assert!(CommandKind::from_code(code).is_none_or(|k| k.code() == code));
            assert!(Outcome::from_code(code).is_none_or(|o| o.code() == code));
        }
        assert_eq!((0..64).filter(|c| CommandKind::from_code(*c).is_some()).count(), 9);
        assert_eq!((0..64).filter(|c| Outcome::from_code(*c).is_some()).count(), 20);
    }
}
