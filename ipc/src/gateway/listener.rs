//! The porter: lets visitors in, hands them the board, takes their requests and brings them the answers.
//!
//! He never waits: every call is a `poll` that returns at once and a bounded number of reads and writes. Who sends anything but
//! requests, or does not fetch his answers, is shown out.

use super::access::{Access, Role};
use super::endpoint::Door;
use super::messages::{Ask, LARGEST, Verdict, WELCOME, Welcome};
use super::peer::Peer;
use super::{MAX_VISITORS, MAX_VISITORS_OF_A_USER};
use crate::{Command, Error, Outcome, PROTOCOL, Reply};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{
    RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, SocketFlags, accept_with, recv, send, sendmsg,
};
use std::collections::VecDeque;
use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use zerocopy::IntoBytes;

/// Visitors let in, and requests read of each, in one look.
const KNOCKS_A_LOOK: usize = 8;
const ASKS_A_LOOK: usize = 4;
/// Requests a visitor may have unanswered.
pub const MAX_UNANSWERED: usize = crate::service::MAX_ACTIVE_REQUESTS;
/// Sent without waiting, and without a signal when nobody is there.
const AT_ONCE: SendFlags = SendFlags::DONTWAIT.union(SendFlags::NOSIGNAL);

/// A visitor's place.
#[derive(Debug)]
struct Seat {
    socket: OwnedFd,
    peer: Peer,
    commands: bool,
    unanswered: AtomicUsize,
    /// To be shown out: an answer could not be brought.
    leaving: AtomicBool,
}

impl Seat {
    fn bring(&self, reply: &Reply) {
        // What does not fit into the socket has not been fetched for hundreds of answers.
        if send(&self.socket, reply.as_bytes(), AT_ONCE) != Ok(size_of::<Reply>()) {
            self.leaving.store(true, Ordering::Relaxed);
        }
    }
}

/// A request of a visitor, to be answered.
#[derive(Debug)]
pub(crate) struct Answer {
    seat: Arc<Seat>,
}

impl Answer {
    /// Whether he may command at all.
    pub fn may_command(&self) -> bool {
        self.seat.commands
    }

    /// Brings it. A visitor who has gone meanwhile is nobody's loss.
    pub fn bring(self, reply: &Reply) {
        self.seat.bring(reply);
    }
}

impl Drop for Answer {
    fn drop(&mut self) {
        self.seat.unanswered.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Stands at the door of a rig.
pub(crate) struct Porter {
    door: Door,
    board: OwnedFd,
    access: Access,
    own_user: u32,
    seats: Vec<Arc<Seat>>,
    /// Whom to begin with at the next look, so that nobody comes first always.
    first: usize,
    asks: VecDeque<(Command, Answer)>,
}

impl Porter {
    /// At a door, with the board to be handed out.
    ///
    /// # Errors
    /// [`Error::Gate`].
    pub fn new(door: Door, access: &Access, board: BorrowedFd) -> Result<Porter, Error> {
        let board =
            board.try_clone_to_owned().map_err(|e| Error::Gate { path: super::gate_dir(), reason: e.to_string() })?;
        Ok(Porter {
            door,
            board,
            access: access.clone(),
            own_user: crate::sys::user_id(),
            seats: Vec::new(),
            first: 0,
            asks: VecDeque::new(),
        })
    }

    /// The next request, if there is one. Looks around once when none is left from the last look.
    pub fn receive(&mut self) -> Option<(Command, Answer)> {
        if self.asks.is_empty() {
            self.look();
        }
        self.asks.pop_front()
    }

    /// How many are inside.
    pub fn visitors(&self) -> usize {
        self.seats.len()
    }

    /// Lets in who knocks, reads what is asked, shows out who has to go.
    fn look(&mut self) {
        let mut watched = Vec::with_capacity(1 + self.seats.len());
        watched.push(PollFd::new(&self.door.socket, PollFlags::IN));
        watched.extend(self.seats.iter().map(|seat| PollFd::new(&seat.socket, PollFlags::IN)));
        match poll(&mut watched, Some(&Timespec::default())) {
            Ok(0) | Err(_) if self.seats.iter().all(|seat| !seat.leaving.load(Ordering::Relaxed)) => return,
            _ => {}
        }
        let found: Vec<PollFlags> = watched.iter().map(PollFd::revents).collect();
        drop(watched);
        let (knocks, seats) = (found[0], &found[1..]);

        let mut stays = vec![true; self.seats.len()];
        for step in 0..self.seats.len() {
            let i = (self.first + step) % self.seats.len();
            let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
            // A command whose sender has gone is not carried out.
            stays[i] = !self.seats[i].leaving.load(Ordering::Relaxed)
                && !seats[i].intersects(gone)
                && (!seats[i].contains(PollFlags::IN) || self.listen_to(&self.seats[i].clone()));
        }
        self.first = self.first.wrapping_add(1);
        let mut stays = stays.into_iter();
        self.seats.retain(|_| stays.next().unwrap_or(true));

        if knocks.contains(PollFlags::IN) {
            for _ in 0..KNOCKS_A_LOOK {
                match accept_with(&self.door.socket, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK) {
                    Ok(socket) => self.admit(socket),
                    Err(Errno::CONNABORTED | Errno::INTR) => {}
                    // Nobody else, or no descriptor left: they wait.
                    Err(_) => break,
                }
            }
        }
    }

    /// Reads a visitor's requests; false when he has to go.
    fn listen_to(&mut self, seat: &Arc<Seat>) -> bool {
        // One byte more than the largest there is, to notice what is larger.
        let mut bytes = [0; LARGEST + 1];
        for _ in 0..ASKS_A_LOOK {
            let length = match recv(&seat.socket, &mut bytes[..], RecvFlags::DONTWAIT) {
                // A message of nothing looks like the end of the connection, and is no request either.
                Ok((0, _)) => return false,
                Ok((_, length)) => length.min(bytes.len()),
                Err(Errno::AGAIN | Errno::INTR) => return true,
                Err(_) => return false,
            };
            let Some(ask) = Ask::of(&bytes[..length]) else { return false };
            // Who it is says the kernel, not he.
            let client = u64::from(seat.peer.pid) << 32 | ask.command.client & 0xffff_ffff;
            let command = Command { client, ..ask.command };
            seat.unanswered.fetch_add(1, Ordering::Relaxed);
            let answer = Answer { seat: seat.clone() };
            if crate::monotonic_ns() > ask.until_ns || seat.unanswered.load(Ordering::Relaxed) > MAX_UNANSWERED {
                answer.bring(&Reply::refused(&command, Outcome::Busy));
            } else {
                self.asks.push_back((command, answer));
            }
        }
        true
    }

    /// Finds out who it is, tells him what he may do, and gives him a seat if he may do anything.
    fn admit(&mut self, socket: OwnedFd) {
        // Nobody of whom nothing is known.
        let Ok(peer) = Peer::of(&socket) else { return };
        let role = self.access.role(&peer, self.own_user);
        let of_this_user = self.seats.iter().filter(|seat| seat.peer.user == peer.user).count();
        let (verdict, most) = match role {
            Role::Stranger => (Verdict::Stranger, 0),
            _ if of_this_user >= MAX_VISITORS_OF_A_USER => (Verdict::Full, MAX_VISITORS_OF_A_USER),
            _ if self.seats.len() >= MAX_VISITORS => (Verdict::Full, MAX_VISITORS),
            Role::Reader => (Verdict::Reader, 0),
            Role::Commander => (Verdict::Commander, 0),
        };
        let welcome = Welcome {
            magic: WELCOME,
            protocol: PROTOCOL,
            verdict: verdict as u32,
            pid: std::process::id(),
            most: most as u32,
            command_group: self.access.command_group(),
            read_group: self.access.read_group(),
        };
        let admitted = matches!(verdict, Verdict::Reader | Verdict::Commander);
        if self.greet(&socket, &welcome, admitted) && admitted {
            self.seats.push(Arc::new(Seat {
                socket,
                peer,
                commands: verdict == Verdict::Commander,
                unanswered: AtomicUsize::new(0),
                leaving: AtomicBool::new(false),
            }));
        }
    }

    fn greet(&self, socket: &OwnedFd, welcome: &Welcome, with_board: bool) -> bool {
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut beside = SendAncillaryBuffer::new(&mut space);
        let handed = [self.board.as_fd()];
        if with_board && !beside.push(SendAncillaryMessage::ScmRights(&handed)) {
            return false;
        }
        let sent = sendmsg(socket, &[IoSlice::new(welcome.as_bytes())], &mut beside, AT_ONCE);
        sent == Ok(size_of::<Welcome>())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Readers;
    use super::super::board::Board;
    use super::super::connection::Visit;
    use super::super::endpoint::{self, Found};
    use super::super::messages::{ASK, Ask};
    use super::*;
    use crate::{ChannelInfo, CommandKind, Info};
    use std::time::{Duration, Instant};
    use tempfile::TempDir;

    struct Gate {
        porter: Porter,
        board: Board,
        dir: TempDir,
    }

    impl Gate {
        fn open() -> Gate {
            let dir = tempfile::Builder::new().prefix("sinew-porter-").tempdir().unwrap();
            let info = Info::new("bench", 1000.0, &[ChannelInfo::EMPTY; 2]).unwrap();
            let board = Board::new(&info, "[rig]\n").unwrap();
            let access = Access::new(None, &Readers::Nobody).unwrap();
            let door = Door::open_in(dir.path(), "bench").unwrap();
            Gate { porter: Porter::new(door, &access, board.glass()).unwrap(), board, dir }
        }

        /// Somebody who knocks and is let in.
        fn knock(&mut self) -> OwnedFd {
            let Ok(Found::Driver(socket, _)) = endpoint::find(self.dir.path(), "bench") else { panic!("nobody there") };
            self.porter.look();
            socket
        }

        fn visit(&mut self) -> Visit {
            let dir = self.dir.path().to_path_buf();
            let visit = std::thread::spawn(move || Visit::find_in(&dir, "bench", Duration::from_secs(20)));
            while !visit.is_finished() {
                self.porter.look();
                std::thread::sleep(Duration::from_micros(200));
            }
            visit.join().unwrap().unwrap().expect("somebody is there")
        }
    }

    fn ask(sequence: u64) -> Ask {
        let command =
            Command { client: 7, sequence, channel: 0, kind: CommandKind::Off.code(), value: 0.0, hold_s: 0.0 };
        Ask { magic: ASK, until_ns: u64::MAX, command }
    }

    #[test]
    fn a_visitor_looks_asks_and_is_answered() {
        let mut gate = Gate::open();
        let visit = gate.visit();
        assert_eq!((visit.info().rig.as_str(), visit.pid), ("bench", std::process::id()));
        assert_eq!(visit.board.text().as_deref(), Some("[rig]\n"));
        let (header, states) =
            (crate::CycleHeader { cycle: 9, ..Default::default() }, [crate::ChannelState::UNKNOWN; 2]);
        gate.board.push(header, &states);
        assert_eq!(visit.board.head(), 1);
        std::thread::scope(|scope| {
            let asked = scope.spawn(|| visit.ask(ask(3).command, Duration::from_secs(20)));
            let (command, answer) = loop {
                if let Some(found) = gate.porter.receive() {
                    break found;
                }
            };
            assert_eq!(command.client, u64::from(std::process::id()) << 32 | 7, "who it is says the kernel");
            assert!(answer.may_command());
            answer.bring(&Reply::taken(&command, 1.5));
            assert_eq!(asked.join().unwrap().unwrap().hold_s, 1.5);
        });
        drop(gate);
        assert!(!visit.driver_lives());
        assert!(matches!(visit.check(), Err(Error::DriverGone { stopped: false, .. })));
    }

    #[test]
    fn who_sends_rubbish_is_shown_out_and_the_others_stay() {
        let mut gate = Gate::open();
        let good = gate.visit();
        let right = ask(1);
        let mut other_magic = right;
        other_magic.magic ^= 1;
        let right = right.as_bytes();
        let (longer, huge) = ([right, &[0]].concat(), vec![0xa5; 100_000]);
        let rubbish: [&[u8]; 6] = [b"GET / HTTP/1.1\r\n", &right[..55], &longer, &huge, other_magic.as_bytes(), b""];
        for bytes in rubbish {
            let socket = gate.knock();
            assert_eq!(gate.porter.seats.len(), 2);
            let sent = send(&socket, bytes, AT_ONCE);
            assert!(sent.is_ok(), "{sent:?}");
            assert!(gate.porter.receive().is_none(), "{} bytes", bytes.len());
            assert_eq!(gate.porter.seats.len(), 1, "{} bytes", bytes.len());
        }
        // Any bits in the right frame are a request; the desk judges them.
        let socket = gate.knock();
        let mut wild = ask(5);
        wild.command = Command::from_bytes(&[0xff; 40]).unwrap();
        send(&socket, wild.as_bytes(), AT_ONCE).unwrap();
        let (command, _) = gate.porter.receive().expect("a request");
        assert!(command.value.is_nan() && command.kind().is_none());
        assert!(good.driver_lives());
    }

    #[test]
    fn what_visitors_attach_shut_or_leave_unread_stays_nowhere() {
        let mut gate = Gate::open();
        let good = gate.visit();
        // Whatever tests of other threads have open: these are counted by the memory they are of.
        let attached = rustix::fs::memfd_create("sinew-attached", rustix::fs::MemfdFlags::CLOEXEC).unwrap();
        let there = |name: &str| {
            let links = std::fs::read_dir("/proc/self/fd").unwrap().flatten();
            links
                .filter_map(|entry| std::fs::read_link(entry.path()).ok())
                .filter(|to| to.to_string_lossy().contains(name))
                .count()
        };
        assert_eq!(there("sinew-attached"), 1);
        for round in 0..40 {
            // Descriptors on a request, as many as a message takes, and on rubbish.
            for (bytes, is_request) in [(ask(round).as_bytes().to_vec(), true), (vec![0xa5; 56], false)] {
                let socket = gate.knock();
                let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(253))];
                let mut beside = SendAncillaryBuffer::new(&mut space);
                let many = [attached.as_fd(); 253];
                assert!(beside.push(SendAncillaryMessage::ScmRights(&many)));
                sendmsg(&socket, &[IoSlice::new(&bytes)], &mut beside, AT_ONCE).unwrap();
                assert_eq!(gate.porter.receive().is_some(), is_request, "descriptors are no part of a request");
                assert_eq!(gate.porter.visitors(), 1 + usize::from(is_request));
                assert_eq!(there("sinew-attached"), 1, "the porter takes nothing that is handed to him");
                drop(socket);
                gate.porter.look();
                assert_eq!(gate.porter.visitors(), 1);
            }
            // Half of the connection shut, either half, with a request on its way.
            for how in [rustix::net::Shutdown::Read, rustix::net::Shutdown::Write, rustix::net::Shutdown::Both] {
                let socket = gate.knock();
                send(&socket, ask(round).as_bytes(), AT_ONCE).unwrap();
                rustix::net::shutdown(&socket, how).unwrap();
                while let Some((command, answer)) = gate.porter.receive() {
                    answer.bring(&Reply::taken(&command, 0.0));
                }
                drop(socket);
                gate.porter.look();
                assert_eq!(gate.porter.visitors(), 1, "{how:?}");
            }
        }
        // Knocked and gone before anybody opened.
        for _ in 0..100 {
            let Ok(Found::Driver(socket, _)) = endpoint::find(gate.dir.path(), "bench") else { panic!("nobody there") };
            drop(socket);
            gate.porter.look();
        }
        assert_eq!(gate.porter.visitors(), 1);
        assert!(good.driver_lives());
    }

    #[test]
    fn who_does_not_fetch_his_answers_or_floods_is_held_off() {
        let mut gate = Gate::open();
        let socket = gate.knock();
        // Requests without end, and nobody fetches an answer.
        let (mut taken, mut sequence) = (Vec::new(), 0);
        let started = Instant::now();
        while !gate.porter.seats.is_empty() {
            sequence += 1;
            let _ = send(&socket, ask(sequence).as_bytes(), AT_ONCE);
            while let Some(found) = gate.porter.asks.pop_front() {
                taken.push(found);
            }
            gate.porter.look();
            assert!(started.elapsed() < Duration::from_secs(30), "he is never shown out");
        }
        assert!(taken.len() <= MAX_UNANSWERED, "{} at once", taken.len());
        // He is gone; answering him is no trouble.
        for (command, answer) in taken {
            answer.bring(&Reply::taken(&command, 0.0));
        }
    }

    #[test]
    fn a_request_nobody_waits_for_any_more_is_not_carried_out() {
        let mut gate = Gate::open();
        let socket = gate.knock();
        send(&socket, Ask { until_ns: 1, ..ask(1) }.as_bytes(), AT_ONCE).unwrap();
        assert!(gate.porter.receive().is_none(), "too late");
        send(&socket, ask(2).as_bytes(), AT_ONCE).unwrap();
        drop(socket);
        assert!(gate.porter.receive().is_none(), "its sender has gone");
        assert!(gate.porter.seats.is_empty());
    }

    #[test]
    fn one_user_cannot_take_all_places() {
        let mut gate = Gate::open();
        let mut sockets: Vec<OwnedFd> = (0..MAX_VISITORS_OF_A_USER).map(|_| gate.knock()).collect();
        assert_eq!(gate.porter.seats.len(), MAX_VISITORS_OF_A_USER);
        let dir = gate.dir.path().to_path_buf();
        let one_more = std::thread::spawn(move || Visit::find_in(&dir, "bench", Duration::from_secs(20)).map(|_| ()));
        while !one_more.is_finished() {
            gate.porter.look();
            std::thread::sleep(Duration::from_micros(200));
        }
        let refused = one_more.join().unwrap();
        assert!(matches!(refused, Err(Error::Full { most: 256, .. })), "{refused:?}");
        sockets.pop();
        gate.porter.look();
        gate.visit();
    }
}
