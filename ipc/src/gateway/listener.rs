//! The listener: accepts clients, hands them the board, takes their requests and sends them the replies.
//!
//! It never waits: every call is a `poll` that returns at once and a bounded number of reads and writes. Who sends anything but
//! requests, or does not fetch his answers, is disconnected.

use super::access::{Access, Role};
use super::endpoint::Endpoint;
use super::messages::{Admission, CommandRequest, GREETING, Greeting, LARGEST_REQUEST};
use super::peer::Peer;
use super::{MAX_GATEWAY_CLIENTS, MAX_GATEWAY_CLIENTS_OF_A_USER};
use crate::{Command, CommandKind, Error, Outcome, PROTOCOL, Reply};
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

/// Connections accepted, and requests read of each session, in one round.
const CONNECTIONS_A_ROUND: usize = 8;
const REQUESTS_A_ROUND: usize = 4;
/// Requests a client may have unanswered.
pub const MAX_UNANSWERED: usize = crate::service::MAX_ACTIVE_REQUESTS;
/// Sent without waiting, and without a signal when nobody is there.
const AT_ONCE: SendFlags = SendFlags::DONTWAIT.union(SendFlags::NOSIGNAL);

/// A client that is connected.
#[derive(Debug)]
struct Session {
    socket: OwnedFd,
    peer: Peer,
    role: Role,
    unanswered: AtomicUsize,
    /// To be disconnected: a reply could not be sent.
    leaving: AtomicBool,
}

impl Session {
    fn send_replies(&self, replies: &[Reply]) {
        // What does not fit into the socket has not been fetched for dozens of answers.
        if send(&self.socket, replies.as_bytes(), AT_ONCE) != Ok(size_of_val(replies)) {
            self.leaving.store(true, Ordering::Relaxed);
        }
    }
}

/// A request of a client, to be answered.
#[derive(Debug)]
pub(crate) struct Answer {
    session: Arc<Session>,
}

impl Answer {
    /// Whether he may ask for this.
    pub fn may_ask(&self, kind: Option<CommandKind>) -> bool {
        match self.session.role {
            Role::Commander => true,
            Role::Stopper => kind == Some(CommandKind::Stop),
            Role::Reader | Role::Stranger => false,
        }
    }

    /// His process and user, as the kernel says.
    pub fn peer(&self) -> (u32, u32) {
        (self.session.peer.pid, self.session.peer.user)
    }

    /// Sends the replies, one for each command. A client that has gone meanwhile is nobody's loss.
    pub fn send_replies(self, replies: &[Reply]) {
        self.session.send_replies(replies);
    }
}

impl Drop for Answer {
    fn drop(&mut self) {
        self.session.unanswered.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Serves the socket of a rig.
pub(crate) struct Listener {
    endpoint: Endpoint,
    board: OwnedFd,
    access: Access,
    own_user: u32,
    sessions: Vec<Arc<Session>>,
    /// Whom to begin with in the next round, so that nobody comes first always.
    first: usize,
    asks: VecDeque<(CommandRequest, Answer)>,
}

impl Listener {
    /// On a socket, with the board to be handed out.
    ///
    /// # Errors
    /// [`Error::Gateway`].
    pub fn new(endpoint: Endpoint, access: &Access, board: BorrowedFd) -> Result<Listener, Error> {
        let board = board
            .try_clone_to_owned()
            .map_err(|e| Error::Gateway { path: super::gateway_dir(), reason: e.to_string() })?;
        Ok(Listener {
            endpoint,
            board,
            access: access.clone(),
            own_user: crate::sys::user_id(),
            sessions: Vec::new(),
            first: 0,
            asks: VecDeque::new(),
        })
    }

    /// The next request, if there is one. Makes a round when none is left from the last one.
    pub fn receive(&mut self) -> Option<(CommandRequest, Answer)> {
        if self.asks.is_empty() {
            self.round();
        }
        self.asks.pop_front()
    }

    /// How many are connected.
    pub fn clients(&self) -> usize {
        self.sessions.len()
    }

    /// One round: accepts who connects, reads requests, disconnects who has to go.
    fn round(&mut self) {
        let mut watched = Vec::with_capacity(1 + self.sessions.len());
        watched.push(PollFd::new(&self.endpoint.socket, PollFlags::IN));
        watched.extend(self.sessions.iter().map(|session| PollFd::new(&session.socket, PollFlags::IN)));
        match poll(&mut watched, Some(&Timespec::default())) {
            Ok(0) | Err(_) if self.sessions.iter().all(|session| !session.leaving.load(Ordering::Relaxed)) => return,
            _ => {}
        }
        let found: Vec<PollFlags> = watched.iter().map(PollFd::revents).collect();
        drop(watched);
        let (incoming, sessions) = (found[0], &found[1..]);

        let mut stays = vec![true; self.sessions.len()];
        for step in 0..self.sessions.len() {
            let i = (self.first + step) % self.sessions.len();
            let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
            let session = self.sessions[i].clone();
            stays[i] = if sessions[i].intersects(gone) {
                // What its sender has left behind is not carried out, unless it switches off. Bounded, though nothing is added to it any more.
                let _ = (0..MAX_UNANSWERED).all(|_| self.read_requests(&session, Command::only_switch_off));
                false
            } else {
                !session.leaving.load(Ordering::Relaxed)
                    && (!sessions[i].contains(PollFlags::IN) || self.read_requests(&session, |_| true))
            };
        }
        self.first = self.first.wrapping_add(1);
        let mut stays = stays.into_iter();
        self.sessions.retain(|_| stays.next().unwrap_or(true));

        if incoming.contains(PollFlags::IN) {
            for _ in 0..CONNECTIONS_A_ROUND {
                match accept_with(&self.endpoint.socket, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK) {
                    Ok(socket) => self.admit(socket),
                    Err(Errno::CONNABORTED | Errno::INTR) => {}
                    // Nobody else, or no descriptor left: they wait.
                    Err(_) => break,
                }
            }
        }
    }

    /// Reads a client's requests, and takes in those whose commands are wanted; false when he has to go.
    fn read_requests(&mut self, session: &Arc<Session>, is_wanted: impl Fn(&[Command]) -> bool) -> bool {
        // One byte more than the largest there is, to notice what is larger.
        let mut bytes = [0; LARGEST_REQUEST + 1];
        for _ in 0..REQUESTS_A_ROUND {
            let length = match recv(&session.socket, &mut bytes[..], RecvFlags::DONTWAIT) {
                // A message of nothing looks like the end of the connection, and is no request either.
                Ok((0, _)) => return false,
                Ok((_, length)) => length.min(bytes.len()),
                Err(Errno::AGAIN | Errno::INTR) => return true,
                // Said once of somebody who has gone without fetching all answers; what he has sent is still there.
                Err(Errno::CONNRESET) => continue,
                Err(_) => return false,
            };
            let Some(mut ask) = CommandRequest::of(&bytes[..length]) else { return false };
            if !is_wanted(&ask.commands) {
                continue;
            }
            // Who it is says the kernel, not he.
            for command in &mut ask.commands {
                command.client = u64::from(session.peer.pid) << 32 | command.client & 0xffff_ffff;
            }
            session.unanswered.fetch_add(1, Ordering::Relaxed);
            let answer = Answer { session: session.clone() };
            let has_too_many = session.unanswered.load(Ordering::Relaxed) > MAX_UNANSWERED;
            let late = ask.terms.is_late(&ask.commands, crate::monotonic_ns());
            match late.or(has_too_many.then_some(Outcome::Busy)) {
                Some(outcome) => {
                    let refused = |command| Reply::refused(command, outcome);
                    answer.send_replies(&ask.commands.iter().map(refused).collect::<Vec<_>>());
                }
                None => self.asks.push_back((ask, answer)),
            }
        }
        true
    }

    /// Finds out who it is, reports what he may do, and opens a session if he may do anything.
    fn admit(&mut self, socket: OwnedFd) {
        // Nobody of whom nothing is known.
        let Ok(peer) = Peer::of(&socket) else { return };
        let role = self.access.role(&peer, self.own_user);
        let of_this_user = self.sessions.iter().filter(|session| session.peer.user == peer.user).count();
        let (verdict, most) = match role {
            Role::Stranger => (Admission::Stranger, 0),
            _ if of_this_user >= MAX_GATEWAY_CLIENTS_OF_A_USER => (Admission::Full, MAX_GATEWAY_CLIENTS_OF_A_USER),
            _ if self.sessions.len() >= MAX_GATEWAY_CLIENTS => (Admission::Full, MAX_GATEWAY_CLIENTS),
            Role::Reader => (Admission::Reader, 0),
            Role::Stopper => (Admission::Stopper, 0),
            Role::Commander => (Admission::Commander, 0),
        };
        let welcome = Greeting {
            magic: GREETING,
            protocol: PROTOCOL,
            verdict: verdict as u32,
            pid: std::process::id(),
            most: most as u32,
            command_group: self.access.command_group(),
            stop_group: self.access.stop_group(),
            read_group: self.access.read_group(),
        };
        let admitted = matches!(verdict, Admission::Reader | Admission::Stopper | Admission::Commander);
        if self.greet(&socket, &welcome, admitted) && admitted {
            self.sessions.push(Arc::new(Session {
                socket,
                peer,
                role,
                unanswered: AtomicUsize::new(0),
                leaving: AtomicBool::new(false),
            }));
        }
    }

    fn greet(&self, socket: &OwnedFd, welcome: &Greeting, with_board: bool) -> bool {
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut beside = SendAncillaryBuffer::new(&mut space);
        let handed = [self.board.as_fd()];
        if with_board && !beside.push(SendAncillaryMessage::ScmRights(&handed)) {
            return false;
        }
        let sent = sendmsg(socket, &[IoSlice::new(welcome.as_bytes())], &mut beside, AT_ONCE);
        sent == Ok(size_of::<Greeting>())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Readers;
    use super::super::board::Board;
    use super::super::connection::Connection;
    use super::super::endpoint::{self, Found};
    use super::super::messages::CommandRequest;
    use super::*;
    use crate::{ChannelInfo, Command, CommandKind, Info, Terms};
    use std::time::{Duration, Instant};
    use tempfile::TempDir;

    struct Gateway {
        listener: Listener,
        board: Board,
        dir: TempDir,
    }

    impl Gateway {
        fn open() -> Gateway {
            let dir = tempfile::Builder::new().prefix("sinew-porter-").tempdir().unwrap();
            let info = Info::new("bench", 1000.0, &[ChannelInfo::EMPTY; 2]).unwrap();
            let board = Board::new(&info, "[rig]\n").unwrap();
            let access = Access::new(None, None, &Readers::Nobody).unwrap();
            let endpoint = Endpoint::open_in(dir.path(), "bench").unwrap();
            Gateway { listener: Listener::new(endpoint, &access, board.read_only()).unwrap(), board, dir }
        }

        /// Somebody who connects and is let in.
        fn connect(&mut self) -> OwnedFd {
            let Ok(Found::Driver(socket, _)) = endpoint::find(self.dir.path(), "bench") else { panic!("nobody there") };
            self.listener.round();
            socket
        }

        fn connection(&mut self) -> Connection {
            let dir = self.dir.path().to_path_buf();
            let connection = std::thread::spawn(move || Connection::find_in(&dir, "bench", Duration::from_secs(20)));
            while !connection.is_finished() {
                self.listener.round();
                std::thread::sleep(Duration::from_micros(200));
            }
            connection.join().unwrap().unwrap().expect("somebody is there")
        }
    }

    fn command(sequence: u64) -> Command {
        Command { client: 7, sequence, channel: 0, kind: CommandKind::Stroke.code(), value: 0.0, hold_s: 0.0 }
    }

    fn ask(sequence: u64) -> Vec<u8> {
        CommandRequest::bytes(Terms::default(), &[command(sequence)])
    }

    fn taken(commands: &[Command], hold_s: f64) -> Vec<Reply> {
        commands.iter().map(|command| Reply::taken(command, hold_s)).collect()
    }

    #[test]
    fn a_visitor_looks_asks_and_is_answered() {
        let mut gate = Gateway::open();
        let connection = gate.connection();
        assert_eq!((connection.info().rig.as_str(), connection.pid), ("bench", std::process::id()));
        assert_eq!(connection.board.text().as_deref(), Some("[rig]\n"));
        let (header, states) =
            (crate::CycleHeader { cycle: 9, ..Default::default() }, [crate::ChannelState::UNKNOWN; 2]);
        gate.board.push(header, &states);
        assert_eq!(connection.board.head(), 1);
        std::thread::scope(|scope| {
            let asked = scope
                .spawn(|| connection.ask(&[command(3), Command { channel: 1, ..command(3) }], Duration::from_secs(20)));
            let (CommandRequest { commands, .. }, answer) = loop {
                if let Some(found) = gate.listener.receive() {
                    break found;
                }
            };
            for command in &commands {
                assert_eq!(command.client, u64::from(std::process::id()) << 32 | 7, "who it is says the kernel");
                assert!(answer.may_ask(command.kind()));
            }
            answer.send_replies(&taken(&commands, 1.5));
            let replies = asked.join().unwrap().unwrap();
            assert_eq!(
                replies.iter().map(|reply| (reply.channel, reply.hold_s)).collect::<Vec<_>>(),
                [(0, 1.5), (1, 1.5)]
            );
        });
        drop(gate);
        assert!(!connection.driver_lives());
        assert!(matches!(connection.check(), Err(Error::DriverGone { stopped: false, .. })));
    }

    #[test]
    fn who_sends_rubbish_is_shown_out_and_the_others_stay() {
        let mut gate = Gateway::open();
        let good = gate.connection();
        let right = ask(1);
        let mut other_magic = right.clone();
        other_magic[0] ^= 1;
        let (longer, huge) = ([&right[..], &[0]].concat(), vec![0xa5; 100_000]);
        let rubbish: [&[u8]; 6] = [b"GET / HTTP/1.1\r\n", &right[..55], &longer, &huge, &other_magic, b""];
        for bytes in rubbish {
            let socket = gate.connect();
            assert_eq!(gate.listener.sessions.len(), 2);
            let sent = send(&socket, bytes, AT_ONCE);
            assert!(sent.is_ok(), "{sent:?}");
            assert!(gate.listener.receive().is_none(), "{} bytes", bytes.len());
            assert_eq!(gate.listener.sessions.len(), 1, "{} bytes", bytes.len());
        }
        // Any bits in the right frame are a request; the desk judges them.
        let socket = gate.connect();
        let wild = CommandRequest::bytes(Terms::default(), &[Command::from_bytes(&[0xff; 40]).unwrap()]);
        send(&socket, &wild, AT_ONCE).unwrap();
        let (CommandRequest { commands, .. }, _) = gate.listener.receive().expect("a request");
        assert!(commands[0].value.is_nan() && commands[0].kind().is_none());
        assert!(good.driver_lives());
    }

    #[test]
    fn what_visitors_attach_shut_or_leave_unread_stays_nowhere() {
        let mut gate = Gateway::open();
        let good = gate.connection();
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
            for (bytes, is_request) in [(ask(round), true), (vec![0xa5; 56], false)] {
                let socket = gate.connect();
                let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(253))];
                let mut beside = SendAncillaryBuffer::new(&mut space);
                let many = [attached.as_fd(); 253];
                assert!(beside.push(SendAncillaryMessage::ScmRights(&many)));
                sendmsg(&socket, &[IoSlice::new(&bytes)], &mut beside, AT_ONCE).unwrap();
                assert_eq!(gate.listener.receive().is_some(), is_request, "descriptors are no part of a request");
                assert_eq!(gate.listener.clients(), 1 + usize::from(is_request));
                assert_eq!(there("sinew-attached"), 1, "the porter takes nothing that is handed to him");
                drop(socket);
                gate.listener.round();
                assert_eq!(gate.listener.clients(), 1);
            }
            // Half of the connection shut, either half, with a request on its way.
            for how in [rustix::net::Shutdown::Read, rustix::net::Shutdown::Write, rustix::net::Shutdown::Both] {
                let socket = gate.connect();
                send(&socket, &ask(round), AT_ONCE).unwrap();
                rustix::net::shutdown(&socket, how).unwrap();
                while let Some((CommandRequest { commands, .. }, answer)) = gate.listener.receive() {
                    answer.send_replies(&taken(&commands, 0.0));
                }
                drop(socket);
                gate.listener.round();
                assert_eq!(gate.listener.clients(), 1, "{how:?}");
            }
        }
        // Connected and gone before anybody opened.
        for _ in 0..100 {
            let Ok(Found::Driver(socket, _)) = endpoint::find(gate.dir.path(), "bench") else { panic!("nobody there") };
            drop(socket);
            gate.listener.round();
        }
        assert_eq!(gate.listener.clients(), 1);
        assert!(good.driver_lives());
    }

    #[test]
    fn who_does_not_fetch_his_answers_or_floods_is_held_off() {
        let mut gate = Gateway::open();
        let socket = gate.connect();
        // Requests without end, and nobody fetches an answer.
        let (mut waiting, mut sequence) = (Vec::new(), 0);
        let started = Instant::now();
        while !gate.listener.sessions.is_empty() {
            sequence += 1;
            let _ = send(&socket, &ask(sequence), AT_ONCE);
            while let Some(found) = gate.listener.asks.pop_front() {
                waiting.push(found);
            }
            gate.listener.round();
            assert!(started.elapsed() < Duration::from_secs(30), "he is never shown out");
        }
        assert!(waiting.len() <= MAX_UNANSWERED, "{} at once", waiting.len());
        // He is gone; answering him is no trouble.
        for (CommandRequest { commands, .. }, answer) in waiting {
            answer.send_replies(&taken(&commands, 0.0));
        }
    }

    #[test]
    fn a_request_nobody_waits_for_any_more_is_not_carried_out() {
        let mut gate = Gateway::open();
        let socket = gate.connect();
        send(&socket, &CommandRequest::bytes(Terms::until(1), &[command(1)]), AT_ONCE).unwrap();
        assert!(gate.listener.receive().is_none(), "too late");
        send(&socket, ask(2).as_bytes(), AT_ONCE).unwrap();
        drop(socket);
        assert!(gate.listener.receive().is_none(), "its sender has gone");
        assert!(gate.listener.sessions.is_empty());
    }

    #[test]
    fn what_switches_off_is_carried_out_though_nobody_waits_for_it_any_more() {
        let mut gate = Gateway::open();
        let socket = gate.connect();
        let off = |sequence| Command { kind: CommandKind::Off.code(), ..command(sequence) };
        send(&socket, &CommandRequest::bytes(Terms::until(1), &[off(1)]), AT_ONCE).unwrap();
        let (late, _) = gate.listener.receive().expect("an off is never too late");
        assert_eq!(late.commands[0].kind(), Some(CommandKind::Off));
        // Between two setpoints, by a program that ends at once.
        let mixed = CommandRequest::bytes(Terms::default(), &[off(2), command(3)]);
        for request in
            [ask(4).as_bytes(), &CommandRequest::bytes(Terms::until(1), &[off(5)]), &mixed, ask(6).as_bytes()]
        {
            send(&socket, request, AT_ONCE).unwrap();
        }
        drop(socket);
        let left: Vec<u64> =
            std::iter::from_fn(|| gate.listener.receive()).map(|(ask, _)| ask.commands[0].sequence).collect();
        assert_eq!(left, [5]);
        assert!(gate.listener.sessions.is_empty());
    }

    #[test]
    fn one_user_cannot_take_all_places() {
        let mut gate = Gateway::open();
        let mut sockets: Vec<OwnedFd> = (0..MAX_GATEWAY_CLIENTS_OF_A_USER).map(|_| gate.connect()).collect();
        assert_eq!(gate.listener.sessions.len(), MAX_GATEWAY_CLIENTS_OF_A_USER);
        let dir = gate.dir.path().to_path_buf();
        let one_more =
            std::thread::spawn(move || Connection::find_in(&dir, "bench", Duration::from_secs(20)).map(|_| ()));
        while !one_more.is_finished() {
            gate.listener.round();
            std::thread::sleep(Duration::from_micros(200));
        }
        let refused = one_more.join().unwrap();
        assert!(matches!(refused, Err(Error::Full { most: 256, .. })), "{refused:?}");
        sockets.pop();
        gate.listener.round();
        gate.connection();
    }
}
