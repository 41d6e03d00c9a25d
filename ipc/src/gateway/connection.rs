//! The client's side of the gateway: a connection to another user's driver.

use super::board::BoardReader;
use super::endpoint::{self, Found};
use super::messages::{Admission, CommandRequest, GREETING, Greeting, LARGEST_ANSWER, replies};
use crate::{Command, CommandKind, DriverState, Error, Info, Name, Outcome, PROTOCOL, Reply, Terms, monotonic_ns};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendFlags, recv, recvmsg, send};
use std::io::IoSliceMut;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use zerocopy::FromBytes;

/// Answers that may wait for threads which have not looked yet; older ones are nobody's any more.
const KEPT_ANSWERS: usize = 64;

/// A connection through the gateway.
pub(crate) struct Connection {
    socket: OwnedFd,
    /// The driver's board.
    pub board: BoardReader,
    rig: String,
    /// Process id of the driver.
    pub pid: u32,
    command_group: Name,
    stop_group: Name,
    /// Answers read by one thread for another.
    answers: Mutex<Vec<Vec<Reply>>>,
}

impl Connection {
    /// Connects at a rig's socket; `None` when nobody is there. Waits to be let in up to `patience`.
    ///
    /// # Errors
    /// [`Error::Gateway`], [`Error::NotAdmitted`], [`Error::Full`], [`Error::Protocol`], [`Error::NoAnswer`].
    pub fn find(rig: &str, patience: Duration) -> Result<Option<Connection>, Error> {
        Connection::find_in(&endpoint::gateway_dir(), rig, patience)
    }

    pub(super) fn find_in(dir: &Path, rig: &str, patience: Duration) -> Result<Option<Connection>, Error> {
        let started = Instant::now();
        loop {
            match endpoint::find(dir, rig)? {
                Found::Nobody => return Ok(None),
                Found::Driver(socket, driver) => {
                    let left = patience.saturating_sub(started.elapsed());
                    let Some((welcome, board)) = greeting(&socket, rig, left)? else {
                        // It ended this instant, or whoever it is does not want to speak.
                        if started.elapsed() < patience {
                            std::thread::sleep(Duration::from_millis(2));
                            continue;
                        }
                        return Ok(None);
                    };
                    return Connection::of(rig, socket, driver.user, &welcome, board).map(Some);
                }
                Found::Busy if started.elapsed() < patience => std::thread::sleep(Duration::from_millis(2)),
                Found::Busy => return Err(Error::NoAnswer { rig: rig.into(), waited: started.elapsed() }),
            }
        }
    }

    pub(super) fn of(
        rig: &str,
        socket: OwnedFd,
        user: u32,
        welcome: &Greeting,
        board: Option<OwnedFd>,
    ) -> Result<Connection, Error> {
        if welcome.protocol != PROTOCOL {
            return Err(Error::Protocol { rig: rig.into(), found: welcome.protocol, expected: PROTOCOL });
        }
        let wrong = |reason: String| Error::Gateway { path: PathBuf::from(format!("the gate of rig {rig:?}")), reason };
        match Admission::from_code(welcome.verdict) {
            Some(Admission::Commander | Admission::Stopper | Admission::Reader) => {}
            Some(Admission::Full) => {
                return Err(Error::Full { rig: rig.into(), what: "clients through its gate", most: welcome.most });
            }
            _ => {
                return Err(Error::NotAdmitted {
                    rig: rig.into(),
                    user,
                    command_group: welcome.command_group.to_string(),
                    read_group: welcome.read_group.to_string(),
                });
            }
        }
        let board = board.ok_or_else(|| wrong("it handed no memory over".into()))?;
        Ok(Connection {
            socket,
            board: BoardReader::new(board).map_err(|e| wrong(e.to_string()))?,
            rig: rig.into(),
            pid: welcome.pid,
            command_group: welcome.command_group,
            stop_group: welcome.stop_group,
            answers: Mutex::new(Vec::new()),
        })
    }

    /// The group whose members may ask for this, by the last word of the rig file that says so.
    pub fn group_for(&self, kind: CommandKind) -> Name {
        if kind == CommandKind::Stop && self.stop_group != Name::EMPTY { self.stop_group } else { self.command_group }
    }

    pub fn info(&self) -> Info {
        self.board.info()
    }

    /// Whether the driver's end of the socket is open: the kernel closes it however the driver ends.
    pub fn driver_lives(&self) -> bool {
        let mut watched = [PollFd::new(&self.socket, PollFlags::IN)];
        match poll(&mut watched, Some(&Timespec::default())) {
            Ok(_) => !watched[0].revents().intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL),
            Err(e) => e == Errno::INTR,
        }
    }

    /// An error when the driver is gone.
    pub fn check(&self) -> Result<(), Error> {
        if self.driver_lives() {
            return Ok(());
        }
        let stopped = self.board.latest().state() == DriverState::Stopped;
        Err(Error::DriverGone { rig: self.rig.clone(), pid: self.pid, stopped })
    }

    /// Sends the commands of one request and waits for the replies, as many.
    pub fn ask(&self, commands: &[Command], patience: Duration) -> Result<Vec<Reply>, Error> {
        self.check()?;
        let started = Instant::now();
        let terms = Terms::within(patience);
        let sequence = commands.first().map_or(0, |command| command.sequence);
        let stops = commands.iter().any(|command| command.kind() == Some(CommandKind::Stop));
        let no_answer = || Error::NoAnswer { rig: self.rig.clone(), waited: started.elapsed() };
        while !self.send(commands, terms)? {
            if started.elapsed() >= patience {
                return Err(no_answer());
            }
            std::thread::sleep(Duration::from_micros(500));
        }
        let mut pause = Duration::from_micros(50);
        loop {
            if let Some(replies) = self.answer(sequence).filter(|replies| replies.len() == commands.len()) {
                if replies[0].outcome == Outcome::Taken.code() && !stops {
                    self.catch_up(patience.saturating_sub(started.elapsed()));
                }
                return Ok(replies);
            }
            self.check()?;
            if started.elapsed() >= patience {
                return Err(no_answer());
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_micros(500));
        }
    }

    /// Sends the commands of one request, and does not wait; `false` where the socket is full.
    pub fn send(&self, commands: &[Command], terms: Terms) -> Result<bool, Error> {
        match send(&self.socket, &CommandRequest::bytes(terms, commands), SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
            Ok(_) => Ok(true),
            Err(Errno::AGAIN | Errno::INTR) => Ok(false),
            Err(e) => {
                self.check()?;
                Err(Error::Service { what: "command", reason: e.to_string() })
            }
        }
    }

    /// Waits until the board shows a cycle from after this moment: what was acknowledged is then to be seen in the latest state. The board is
    /// a few milliseconds late.
    fn catch_up(&self, patience: Duration) {
        let now_ns = monotonic_ns();
        let end = Instant::now() + patience;
        loop {
            let seen = self.board.wakes();
            let latest = self.board.latest();
            if latest.monotonic_ns > now_ns || latest.state() != DriverState::Running || Instant::now() >= end {
                return;
            }
            if !self.driver_lives() {
                return;
            }
            self.board.sleep(seen, Duration::from_millis(5));
        }
    }

    /// The answer to the request of this number, if it has come. What has come for other threads is kept for them.
    pub fn answer(&self, sequence: u64) -> Option<Vec<Reply>> {
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        // One byte more than the largest there is, to notice what is larger.
        let mut bytes = [0; LARGEST_ANSWER + 1];
        while let Ok((_, length)) = recv(&self.socket, &mut bytes[..], RecvFlags::DONTWAIT) {
            let Some(answer) = replies(&bytes[..length.min(bytes.len())]) else { break };
            answers.push(answer);
        }
        let found = answers.iter().position(|answer| answer[0].sequence == sequence).map(|at| answers.remove(at));
        let excess = answers.len().saturating_sub(KEPT_ANSWERS);
        answers.drain(..excess);
        found
    }
}

/// The driver's first words, and the board; `None` when it has hung up without any.
pub(super) fn greeting(
    socket: &OwnedFd,
    rig: &str,
    patience: Duration,
) -> Result<Option<(Greeting, Option<OwnedFd>)>, Error> {
    let started = Instant::now();
    loop {
        let mut bytes = [0; size_of::<Greeting>()];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut beside = RecvAncillaryBuffer::new(&mut space);
        let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
        match recvmsg(socket, &mut [IoSliceMut::new(&mut bytes)], &mut beside, flags) {
            Ok(message) if message.bytes == bytes.len() => {
                let board = beside.drain().find_map(|message| match message {
                    RecvAncillaryMessage::ScmRights(mut descriptors) => descriptors.next(),
                    _ => None,
                });
                let welcome = Greeting::read_from_bytes(&bytes).ok().filter(|welcome| welcome.magic == GREETING);
                return Ok(welcome.map(|welcome| (welcome, board)));
            }
            Ok(_) => return Ok(None),
            Err(Errno::AGAIN | Errno::INTR) => {
                let left = patience.saturating_sub(started.elapsed());
                if left.is_zero() {
                    return Err(Error::NoAnswer { rig: rig.into(), waited: started.elapsed() });
                }
                let left = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: left.subsec_nanos().into() };
                let _ = poll(&mut [PollFd::new(socket, PollFlags::IN)], Some(&left));
            }
            Err(_) => return Ok(None),
        }
    }
}
