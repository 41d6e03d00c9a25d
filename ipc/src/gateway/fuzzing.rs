//! The gateway for those who fuzz it (`hostile/`), with either end in the hands of anybody. No part of the interface.

use super::board::{self, Board};
use super::connection::{self, Connection};
use super::endpoint::{self, Endpoint, Found};
use super::listener::{Answer, Listener};
use super::messages::{Admission, CommandRequest, GREETING, Greeting};
use super::pages::Written;
use super::{Access, Readers};
use crate::link::Link;
use crate::{
    ChannelInfo, ChannelState, Client, ClientOptions, Command, CycleHeader, Error, Info, Name, PROTOCOL, Reply, Terms,
};
use rustix::net::{AddressFamily, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, SocketFlags, SocketType};
use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::time::Duration;
use zerocopy::IntoBytes;

pub use super::listener::MAX_UNANSWERED;
pub use super::{MAX_GATEWAY_CLIENTS, MAX_GATEWAY_CLIENTS_OF_A_USER};

/// The rig of this gateway.
const RIG: &str = "hostile";

/// A socket with its listener, and nobody behind it.
pub struct TestListener {
    listener: Listener,
    dir: PathBuf,
    _board: Board,
}

impl TestListener {
    /// In this folder.
    ///
    /// # Errors
    /// [`Error::Gateway`].
    pub fn open(dir: &Path) -> Result<TestListener, Error> {
        let wrong = |reason: String| Error::Gateway { path: dir.into(), reason };
        let board = Board::new(&Info::new(RIG, 1000.0, &[ChannelInfo::EMPTY; 2])?, "[rig]\n");
        let board = board.map_err(|e| wrong(e.to_string()))?;
        let access = Access::new(None, None, &Readers::Nobody)?;
        let listener = Listener::new(Endpoint::open_in(dir, RIG)?, &access, board.read_only())?;
        Ok(TestListener { listener, dir: dir.into(), _board: board })
    }

    /// Somebody of the own user's connects; he is let in at the next look.
    ///
    /// # Errors
    /// [`Error::Gateway`].
    pub fn connect(&self) -> Result<OwnedFd, Error> {
        match endpoint::find(&self.dir, RIG)? {
            Found::Driver(socket, _) => Ok(socket),
            Found::Busy | Found::Nobody => {
                Err(Error::Gateway { path: self.dir.clone(), reason: "nobody there".into() })
            }
        }
    }

    /// The next request; looks around once where none is left.
    pub fn receive(&mut self) -> Option<(Vec<Command>, PendingReply)> {
        let (ask, answer) = self.listener.receive()?;
        Some((ask.commands, PendingReply(answer)))
    }

    /// How many are inside.
    pub fn clients(&self) -> usize {
        self.listener.clients()
    }
}

/// A request that waits for its answer.
pub struct PendingReply(Answer);

impl PendingReply {
    /// Answers it.
    pub fn send_replies(self, replies: &[Reply]) {
        self.0.send_replies(replies);
    }
}

/// The bytes of a request.
pub fn request(terms: Terms, commands: &[Command]) -> Vec<u8> {
    CommandRequest::bytes(terms, commands)
}

/// Whether these bytes are a request, whatever it asks for.
pub fn is_request(bytes: &[u8]) -> bool {
    CommandRequest::of(bytes).is_some()
}

/// The first words of a driver that lets one in.
pub fn welcome() -> Vec<u8> {
    let welcome = Greeting {
        magic: GREETING,
        protocol: PROTOCOL,
        verdict: Admission::Commander as u32,
        pid: std::process::id(),
        most: 0,
        command_group: Name::EMPTY,
        stop_group: Name::EMPTY,
        read_group: Name::EMPTY,
    };
    welcome.as_bytes().to_vec()
}

/// The memory of a good board with a few cycles in it.
///
/// # Errors
/// The kernel's.
pub fn board(channels: usize, cycles: u64) -> Result<Vec<u8>, Error> {
    let wrong = |e: std::io::Error| Error::Gateway { path: RIG.into(), reason: e.to_string() };
    let info = Info::new(RIG, 1.0, &vec![ChannelInfo::EMPTY; channels])?;
    let mut board = Board::new(&info, "[rig]\nname = \"hostile\"\n").map_err(wrong)?;
    for cycle in 1..=cycles {
        let header = CycleHeader { cycle, monotonic_ns: cycle * 1_000_000, missed: 0 };
        board.push(header, &vec![ChannelState::UNKNOWN; channels]);
    }
    Ok(board.bytes())
}

/// A driver's memory with anything in it.
pub struct Memory(Written);

impl Memory {
    /// With these contents, sealed as that of a driver is.
    ///
    /// # Errors
    /// The kernel's.
    pub fn of(bytes: &[u8]) -> Result<Memory, Error> {
        let written = Written::new(bytes.len().div_ceil(size_of::<u64>()).max(1));
        let written = written.map_err(|e| Error::Gateway { path: RIG.into(), reason: e.to_string() })?;
        board::store(written.words(), bytes);
        Ok(Memory(written))
    }

    /// All of it, as the driver may change it at any time.
    pub fn words(&self) -> &[AtomicU64] {
        self.0.words()
    }
}

/// A client of a driver whose first words, memory and answers are these; the other end of its connection comes along.
///
/// # Errors
/// What [`Client::connect`] would say.
pub fn client(words: &[u8], memory: Option<&Memory>, answers: &[&[u8]]) -> Result<(Client, OwnedFd), Error> {
    let wrong = |reason: String| Error::Gateway { path: RIG.into(), reason };
    let failed = |errno: rustix::io::Errno| wrong(errno.to_string());
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    let (driver, client) =
        rustix::net::socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).map_err(failed)?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut beside = SendAncillaryBuffer::new(&mut space);
    let handed = memory.map(|memory| [memory.0.read_only()]);
    if let Some(handed) = &handed {
        beside.push(SendAncillaryMessage::ScmRights(handed));
    }
    rustix::net::sendmsg(&driver, &[IoSlice::new(words)], &mut beside, SendFlags::NOSIGNAL).map_err(failed)?;
    for answer in answers {
        // What does not fit any more is not sent.
        let _ = rustix::net::send(&driver, answer, SendFlags::NOSIGNAL | SendFlags::DONTWAIT);
    }
    let Some((welcome, board)) = connection::greeting(&client, RIG, Duration::ZERO)? else {
        return Err(wrong("it does not speak".into()));
    };
    let connection = Connection::of(RIG, client, 0, &welcome, board)?;
    let (link, info) = Link::through(connection, RIG)?;
    let options = ClientOptions { connect: Duration::ZERO, answer: Duration::ZERO };
    Ok((Client::over(link, info, options), driver))
}
