//! The gate for those who fuzz it (`hostile/`), with either end in the hands of anybody. No part of the interface.

use super::board::{self, Board};
use super::connection::{self, Visit};
use super::endpoint::{self, Door, Found};
use super::listener::{Answer, Porter};
use super::messages::{ASK, Ask, Verdict, WELCOME, Welcome};
use super::pages::Written;
use super::{Access, Readers};
use crate::link::Link;
use crate::{
    ChannelInfo, ChannelState, Client, ClientOptions, Command, CycleHeader, Error, Info, Name, PROTOCOL, Reply,
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
pub use super::{MAX_VISITORS, MAX_VISITORS_OF_A_USER};

/// The rig of this gate.
const RIG: &str = "hostile";

/// A door with its porter, and nobody behind it.
pub struct Entrance {
    porter: Porter,
    dir: PathBuf,
    _board: Board,
}

impl Entrance {
    /// In this folder.
    ///
    /// # Errors
    /// [`Error::Gate`].
    pub fn open(dir: &Path) -> Result<Entrance, Error> {
        let wrong = |reason: String| Error::Gate { path: dir.into(), reason };
        let board = Board::new(&Info::new(RIG, 1000.0, &[ChannelInfo::EMPTY; 2])?, "[rig]\n");
        let board = board.map_err(|e| wrong(e.to_string()))?;
        let access = Access::new(None, &Readers::Nobody)?;
        let porter = Porter::new(Door::open_in(dir, RIG)?, &access, board.glass())?;
        Ok(Entrance { porter, dir: dir.into(), _board: board })
    }

    /// Somebody of the own user's knocks; he is let in at the next look.
    ///
    /// # Errors
    /// [`Error::Gate`].
    pub fn knock(&self) -> Result<OwnedFd, Error> {
        match endpoint::find(&self.dir, RIG)? {
            Found::Driver(socket, _) => Ok(socket),
            Found::Busy | Found::Nobody => Err(Error::Gate { path: self.dir.clone(), reason: "nobody there".into() }),
        }
    }

    /// The next request; looks around once where none is left.
    pub fn receive(&mut self) -> Option<(Command, Asked)> {
        let (command, answer) = self.porter.receive()?;
        Some((command, Asked(answer)))
    }

    /// How many are inside.
    pub fn visitors(&self) -> usize {
        self.porter.visitors()
    }
}

/// A request that waits for its answer.
pub struct Asked(Answer);

impl Asked {
    /// Answers it.
    pub fn bring(self, reply: &Reply) {
        self.0.bring(reply);
    }
}

/// The bytes of a request.
pub fn request(until_ns: u64, command: Command) -> Vec<u8> {
    Ask { magic: ASK, until_ns, command }.as_bytes().to_vec()
}

/// Whether these bytes are a request, whatever it asks for.
pub fn is_request(bytes: &[u8]) -> bool {
    Ask::of(bytes).is_some()
}

/// The first words of a driver that lets one in.
pub fn welcome() -> Vec<u8> {
    let welcome = Welcome {
        magic: WELCOME,
        protocol: PROTOCOL,
        verdict: Verdict::Commander as u32,
        pid: std::process::id(),
        most: 0,
        command_group: Name::EMPTY,
        read_group: Name::EMPTY,
    };
    welcome.as_bytes().to_vec()
}

/// The memory of a good board with a few cycles in it.
///
/// # Errors
/// The kernel's.
pub fn board(channels: usize, cycles: u64) -> Result<Vec<u8>, Error> {
    let wrong = |e: std::io::Error| Error::Gate { path: RIG.into(), reason: e.to_string() };
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
        let written = written.map_err(|e| Error::Gate { path: RIG.into(), reason: e.to_string() })?;
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
    let wrong = |reason: String| Error::Gate { path: RIG.into(), reason };
    let failed = |errno: rustix::io::Errno| wrong(errno.to_string());
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    let (driver, visitor) =
        rustix::net::socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).map_err(failed)?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut beside = SendAncillaryBuffer::new(&mut space);
    let handed = memory.map(|memory| [memory.0.glass()]);
    if let Some(handed) = &handed {
        beside.push(SendAncillaryMessage::ScmRights(handed));
    }
    rustix::net::sendmsg(&driver, &[IoSlice::new(words)], &mut beside, SendFlags::NOSIGNAL).map_err(failed)?;
    for answer in answers {
        // What does not fit any more is not sent.
        let _ = rustix::net::send(&driver, answer, SendFlags::NOSIGNAL | SendFlags::DONTWAIT);
    }
    let Some((welcome, board)) = connection::greeting(&visitor, RIG, Duration::ZERO)? else {
        return Err(wrong("it does not speak".into()));
    };
    let visit = Visit::of(RIG, visitor, 0, &welcome, board)?;
    let (link, info) = Link::through(visit, RIG)?;
    let options = ClientOptions { connect: Duration::ZERO, answer: Duration::ZERO };
    Ok((Client::over(link, info, options), driver))
}
