//! What travels over the socket. Every message is one datagram (SOCK_SEQPACKET) of a fixed size, or of a fixed head and a number of equal parts,
//! so there is nothing to parse and nothing that could come in halves.

use crate::{Command, MAX_CHANNELS, Name, Reply, Terms};
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

/// The head of a client's request; its commands follow, 1 to [`MAX_CHANNELS`].
#[derive(Debug, Clone, Copy, PartialEq, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
struct RequestHead {
    /// [`REQUEST`].
    magic: u64,
    terms: Terms,
}

/// A client's request.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CommandRequest {
    /// How it is meant.
    pub terms: Terms,
    /// What is asked for, 1 to [`MAX_CHANNELS`].
    pub commands: Vec<Command>,
}

/// Largest request, and largest answer, bytes.
pub(crate) const LARGEST_REQUEST: usize = size_of::<RequestHead>() + MAX_CHANNELS * size_of::<Command>();
pub(crate) const LARGEST_ANSWER: usize = MAX_CHANNELS * size_of::<Reply>();

impl CommandRequest {
    /// As a datagram.
    pub fn bytes(terms: Terms, commands: &[Command]) -> Vec<u8> {
        [RequestHead { magic: REQUEST, terms }.as_bytes(), commands.as_bytes()].concat()
    }

    /// The request in a datagram; `None` where it is anything else. Its contents may be any bits: the desk judges those.
    pub fn of(bytes: &[u8]) -> Option<CommandRequest> {
        let (head, rest) = RequestHead::read_from_prefix(bytes).ok().filter(|(head, _)| head.magic == REQUEST)?;
        let commands = all(rest)?;
        Some(CommandRequest { terms: head.terms, commands })
    }
}

/// The replies in a datagram; `None` where it is anything else.
pub(crate) fn replies(bytes: &[u8]) -> Option<Vec<Reply>> {
    all(bytes)
}

/// 1 to [`MAX_CHANNELS`] equal parts and nothing else.
fn all<T: FromBytes>(bytes: &[u8]) -> Option<Vec<T>> {
    let parts = bytes.chunks_exact(size_of::<T>());
    let fits = parts.remainder().is_empty() && (1..=MAX_CHANNELS).contains(&parts.len());
    if fits { parts.map(|part| T::read_from_bytes(part).ok()).collect() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        assert_eq!((size_of::<Greeting>(), size_of::<RequestHead>()), (216, 32));
        assert_eq!((LARGEST_REQUEST, LARGEST_ANSWER), (2592, 4096));
        for code in 0..9 {
            assert!(Admission::from_code(code).is_none_or(|verdict| verdict as u32 == code));
        }
    }

    #[test]
    fn a_request_is_taken_as_a_whole_or_not_at_all() {
        let command = Command { client: 1, sequence: 2, channel: 3, kind: 4, value: 5.0, hold_s: 6.0 };
        let terms = Terms { until_ns: 7, over_s: 8.0, stream: 9 };
        for count in [1, 2, MAX_CHANNELS] {
            let commands = vec![command; count];
            let bytes = CommandRequest::bytes(terms, &commands);
            assert_eq!(CommandRequest::of(&bytes), Some(CommandRequest { terms, commands }));
            assert_eq!(CommandRequest::of(&[&bytes[..], &[0]].concat()), None);
            assert_eq!(CommandRequest::of(&bytes[..bytes.len() - 1]), None);
        }
        assert_eq!(CommandRequest::of(&CommandRequest::bytes(terms, &[command; MAX_CHANNELS + 1])), None);
        assert_eq!(CommandRequest::of(&CommandRequest::bytes(terms, &[])), None);
        let mut other = CommandRequest::bytes(terms, &[command]);
        other[..8].copy_from_slice(&GREETING.to_le_bytes());
        assert_eq!(CommandRequest::of(&other), None);
        assert_eq!(CommandRequest::of(&[]), None);
    }

    #[test]
    fn an_answer_has_as_many_replies_as_it_has_bytes_for() {
        let command = Command { client: 1, sequence: 2, channel: 3, kind: 4, value: 5.0, hold_s: 6.0 };
        let reply = Reply { low: 0.0, high: 0.0, ..Reply::taken(&command, 1.0) };
        assert_eq!(replies([reply; 3].as_bytes()), Some(vec![reply; 3]));
        assert_eq!(replies(&[reply; 3].as_bytes()[1..]), None);
        assert_eq!(replies(&[]), None);
    }
}
