//! What travels over the socket. Every message has a fixed size and one datagram (SOCK_SEQPACKET), so there is nothing to parse and
//! nothing that could come in halves.

use crate::{Command, Name, Reply};
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Opens what the driver says first.
pub(crate) const GREETING: u64 = u64::from_le_bytes(*b"sinewdoo");
/// Opens a request.
pub(crate) const REQUEST: u64 = u64::from_le_bytes(*b"sinewask");

/// The driver's first words; with them comes the board, to who may look.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub(crate) struct Greeting {
    /// [`GREETING`].
    pub magic: u64,
    /// [`crate::PROTOCOL`] of the driver. This and what stands above is the same in every version.
    pub protocol: u32,
    /// [`Admission`].
    pub verdict: u32,
    /// Process id of the driver.
    pub pid: u32,
    /// Clients there may be, where there are too many.
    pub most: u32,
    /// Whose members may command; empty = nobody's.
    pub command_group: Name,
    /// Whose members may stop the driver; empty = nobody's.
    pub stop_group: Name,
    /// Whose members may look; empty = nobody's.
    pub read_group: Name,
}

/// What the listener says to who connects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Admission {
    /// Look and command.
    Commander = 0,
    /// Look.
    Reader = 1,
    /// Neither.
    Stranger = 2,
    /// There are too many clients, of this user or of all.
    Full = 3,
    /// Look, and stop the driver.
    Stopper = 4,
}

impl Admission {
    pub const fn from_code(code: u32) -> Option<Admission> {
        Some(match code {
            0 => Admission::Commander,
            1 => Admission::Reader,
            2 => Admission::Stranger,
            3 => Admission::Full,
            4 => Admission::Stopper,
            _ => return None,
        })
    }
}

/// A client's request.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub(crate) struct CommandRequest {
    /// [`REQUEST`].
    pub magic: u64,
    /// Not to be carried out after this time (CLOCK_MONOTONIC, ns): nobody waits for the answer any more.
    pub until_ns: u64,
    /// What is asked for.
    pub command: Command,
}

/// Largest message either side sends, bytes.
pub(crate) const LARGEST: usize = {
    let (a, b, c) = (size_of::<Greeting>(), size_of::<CommandRequest>(), size_of::<Reply>());
    let larger = if a > b { a } else { b };
    if larger > c { larger } else { c }
};

impl CommandRequest {
    /// The request in a datagram; `None` where it is anything else. Its contents may be any bits: the desk judges those.
    pub fn of(bytes: &[u8]) -> Option<CommandRequest> {
        CommandRequest::read_from_bytes(bytes).ok().filter(|ask| ask.magic == REQUEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        assert_eq!((size_of::<Greeting>(), size_of::<CommandRequest>(), LARGEST), (216, 56, 216));
        for code in 0..9 {
            assert!(Admission::from_code(code).is_none_or(|verdict| verdict as u32 == code));
        }
    }

    #[test]
    fn a_request_is_taken_as_a_whole_or_not_at_all() {
        let command = Command { client: 1, sequence: 2, channel: 3, kind: 4, value: 5.0, hold_s: 6.0 };
        let ask = CommandRequest { magic: REQUEST, until_ns: 7, command };
        assert_eq!(CommandRequest::of(ask.as_bytes()), Some(ask));
        let mut longer = ask.as_bytes().to_vec();
        longer.push(0);
        assert_eq!(CommandRequest::of(&longer), None);
        assert_eq!(CommandRequest::of(&ask.as_bytes()[..55]), None);
        assert_eq!(CommandRequest::of(CommandRequest { magic: GREETING, ..ask }.as_bytes()), None);
        assert_eq!(CommandRequest::of(&[]), None);
    }
}
