//! What is said at the door. Every message has a fixed size and one datagram (SOCK_SEQPACKET), so there is nothing to parse and
//! nothing that could come in halves.

use crate::{Command, Name, Reply};
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Opens what the driver says first.
pub(crate) const WELCOME: u64 = u64::from_le_bytes(*b"sinewdoo");
/// Opens a request.
pub(crate) const ASK: u64 = u64::from_le_bytes(*b"sinewask");

/// The driver's first words; with them comes the board, to who may look.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub(crate) struct Welcome {
    /// [`WELCOME`].
    pub magic: u64,
    /// [`crate::PROTOCOL`] of the driver. This and what stands above is the same in every version.
    pub protocol: u32,
    /// [`Verdict`].
    pub verdict: u32,
    /// Process id of the driver.
    pub pid: u32,
    /// Visitors there may be, where there are too many.
    pub most: u32,
    /// Whose members may command; empty = nobody's.
    pub command_group: Name,
    /// Whose members may look; empty = nobody's.
    pub read_group: Name,
}

/// What the porter says to who knocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Verdict {
    /// Look and command.
    Commander = 0,
    /// Look.
    Reader = 1,
    /// Neither.
    Stranger = 2,
    /// There are too many visitors, of this user or of all.
    Full = 3,
}

impl Verdict {
    pub const fn from_code(code: u32) -> Option<Verdict> {
        Some(match code {
            0 => Verdict::Commander,
            1 => Verdict::Reader,
            2 => Verdict::Stranger,
            3 => Verdict::Full,
            _ => return None,
        })
    }
}

/// A visitor's request.
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub(crate) struct Ask {
    /// [`ASK`].
    pub magic: u64,
    /// Not to be carried out after this time (CLOCK_MONOTONIC, ns): nobody waits for the answer any more.
    pub until_ns: u64,
    /// What is asked for.
    pub command: Command,
}

/// Largest message either side sends, bytes.
pub(crate) const LARGEST: usize = {
    let (a, b, c) = (size_of::<Welcome>(), size_of::<Ask>(), size_of::<Reply>());
    let larger = if a > b { a } else { b };
    if larger > c { larger } else { c }
};

impl Ask {
    /// The request in a datagram; `None` where it is anything else. Its contents may be any bits: the desk judges those.
    pub fn of(bytes: &[u8]) -> Option<Ask> {
        Ask::read_from_bytes(bytes).ok().filter(|ask| ask.magic == ASK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        assert_eq!((size_of::<Welcome>(), size_of::<Ask>(), LARGEST), (152, 56, 152));
        for code in 0..9 {
            assert!(Verdict::from_code(code).is_none_or(|verdict| verdict as u32 == code));
        }
    }

    #[test]
    fn a_request_is_taken_as_a_whole_or_not_at_all() {
        let command = Command { client: 1, sequence: 2, channel: 3, kind: 4, value: 5.0, hold_s: 6.0 };
        let ask = Ask { magic: ASK, until_ns: 7, command };
        assert_eq!(Ask::of(ask.as_bytes()), Some(ask));
        let mut longer = ask.as_bytes().to_vec();
        longer.push(0);
        assert_eq!(Ask::of(&longer), None);
        assert_eq!(Ask::of(&ask.as_bytes()[..55]), None);
        assert_eq!(Ask::of(Ask { magic: WELCOME, ..ask }.as_bytes()), None);
        assert_eq!(Ask::of(&[]), None);
    }
}
