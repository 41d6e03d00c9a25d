//! The driver's side: the blackboard its loop writes, the stream and the event of an ordinary thread, and the answers to commands.
//!
//! [`Server::create`] makes all of it; [`Server::split`] hands the parts to the threads that use them. The rig's name is
//! released when the last part is dropped.

use crate::gateway::{self, Access, Board, Endpoint, Listener};
use crate::janitor::Janitor;
use crate::memory::listen;
use crate::service::{
    ActiveRequest, BatchPublisher, Entry, EntryMut, KEY_INFO, KEY_SNAPSHOT, KEY_STATS, MAX_ACTIVE_REQUESTS,
    MAX_CLIENTS, MAX_STREAMS, Replies, Run, StatePort, StateReader, TickListener, TickNotifier, failed, name, node,
};
use crate::{
    BatchHeader, ChannelState, Command, CycleHeader, Error, Info, LoopStats, MAX_BATCH, MAX_CHANNELS, Outcome,
    PROTOCOL, Reply, RigLock, Snapshot, Terms,
};
use iceoryx2::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{Ordering, fence};
use std::time::{Duration, Instant};

/// How often the loop's figures are put on the board of the gateway.
const STATS_PERIOD: Duration = Duration::from_millis(100);
/// Commands answered in one call, so that a flood of them cannot keep the thread from its other work.
const REQUESTS_PER_CALL: usize = 256;
/// What the stream's buffers may take of shared memory, bytes, when they are full.
const STREAM_MEMORY: usize = 96 << 20;
/// Batches in use beside those in the readers' buffers: one each reader looks at, and some in between.
const EXTRA_SLOTS: usize = MAX_STREAMS + 4;
/// Fewest batches a reader may lag behind.
const FEWEST_SLOTS: usize = 16;

/// Everything a driver publishes and answers with.
pub struct Server {
    /// The latest state; for the real-time loop.
    pub state: StateWriter,
    /// The stream and the event; for an ordinary thread.
    pub cycles: CyclePublisher,
    /// The commands; for an ordinary thread.
    pub commands: CommandServer,
}

/// What the services of the smallest rig take of /dev/shm, bytes, and as much again.
const LEAST_SHARED_MEMORY: usize = 4 << 20;

impl Server {
    /// Creates the services of this run and tells clients where they are.
    ///
    /// # Errors
    /// [`Error::Service`] when shared memory cannot be had.
    pub fn create(lock: RigLock, info: &Info) -> Result<Server, Error> {
        Server::create_with_protocol(lock, info, PROTOCOL)
    }

    fn create_with_protocol(lock: RigLock, info: &Info, protocol: u32) -> Result<Server, Error> {
        // Shared memory is only taken when it is written, and running out of it then kills the process: look before the first write.
        if let Some(left) = crate::sys::shared_memory_left().filter(|left| *left < LEAST_SHARED_MEMORY) {
            let (left, least) = (left >> 10, LEAST_SHARED_MEMORY >> 10);
            let reason =
                format!("only {left} KiB of shared memory are left in /dev/shm, a driver needs {least} KiB at least");
            return Err(Error::Service { what: "state", reason });
        }
        let node = node(lock.run(), &lock.run_dir())?;
        lock.close_to_others()?;
        let run = Arc::new(Run { node, lock });
        let server = Server {
            state: StateWriter::new(&run, info)?,
            cycles: CyclePublisher::new(&run, info)?,
            commands: CommandServer::new(&run)?,
        };
        run.lock.publish(protocol)?;
        Ok(server)
    }

    /// Opens the gateway for other users: who may do what, and the rig file's text for them to read.
    ///
    /// # Errors
    /// [`Error::Gateway`] when there is no place for its socket, or no memory for its board.
    pub fn open_gateway(&mut self, info: &Info, access: &Access, rig_text: &str) -> Result<(), Error> {
        let board = Board::new(info, rig_text).map_err(|e| Error::Gateway {
            path: gateway::gateway_dir(),
            reason: format!("no memory for its board: {e}"),
        })?;
        let rig = self.commands.run.lock.rig();
        let listener = Listener::new(Endpoint::open(rig)?, access, board.read_only())?;
        self.cycles.feed = Some(BoardFeed::new(board, &self.commands.run)?);
        self.commands.listener = Some(listener);
        Ok(())
    }

    /// The parts, for the threads that use them.
    pub fn split(self) -> (StateWriter, CyclePublisher, CommandServer) {
        (self.state, self.cycles, self.commands)
    }
}

/// Writes the latest state for everybody to read. Made for the real-time loop: an update is one copy of the channels
/// that are there and one atomic add; it allocates nothing, takes no lock, makes no system call and never waits for a reader.
pub struct StateWriter {
    snapshot: Option<EntryMut<Snapshot>>,
    stats: Option<EntryMut<LoopStats>>,
    _port: StatePort,
    _run: Arc<Run>,
}

impl StateWriter {
    fn new(run: &Arc<Run>, info: &Info) -> Result<StateWriter, Error> {
        const WHAT: &str = "state";
        let mut first = Snapshot::new(info.channels as usize);
        first.monotonic_ns = info.started_ns;
        let service = run
            .node
            .service_builder(&name(WHAT, run.lock.key())?)
            .blackboard_creator::<u64>()
            .max_readers(MAX_CLIENTS + 1)
            .max_nodes(MAX_CLIENTS + 1)
            .add::<Info>(KEY_INFO, *info)
            .add::<Snapshot>(KEY_SNAPSHOT, first)
            .add::<LoopStats>(KEY_STATS, LoopStats::new())
            .create()
            .map_err(failed(WHAT))?;
        let port = service.writer_builder().create().map_err(failed(WHAT))?;
        let snapshot = port.entry::<Snapshot>(&KEY_SNAPSHOT).map_err(failed(WHAT))?;
        let stats = port.entry::<LoopStats>(&KEY_STATS).map_err(failed(WHAT))?;
        // The blackboard keeps two cells for each entry and writes them in turn. Filling both makes it right for an
        // update to write only what has changed, and touches every page before the loop does.
        for _ in 0..2 {
            snapshot.update_with_copy(first);
            stats.update_with_copy(LoopStats::new());
        }
        Ok(StateWriter { snapshot: Some(snapshot), stats: Some(stats), _port: port, _run: run.clone() })
    }

    /// Makes this the latest state.
    #[inline]
    pub fn update(&mut self, snapshot: &Snapshot) {
        update(&mut self.snapshot, |cell| cell.copy_from(snapshot));
    }

    /// Makes these the latest figures of the loop. About ten times as long as [`StateWriter::update`]: some times a second will do.
    #[inline]
    pub fn update_stats(&mut self, stats: &LoopStats) {
        update(&mut self.stats, |cell| *cell = *stats);
    }
}

/// Writes the cell readers are not pointed at, then points them at it.
#[allow(unsafe_code)]
#[inline]
fn update<T: Copy + ZeroCopySend + 'static>(entry: &mut Option<EntryMut<T>>, write: impl FnOnce(&mut T)) {
    let Some(handle) = entry.take() else { return };
    let mut cell = handle.loan_uninit();
    // SAFETY: both cells were filled when the writer was made and hold plain data ever since. A reader may be looking at this
    // one still, from before the last update; it finds the count changed afterwards and reads again.
    write(unsafe { cell.value_mut().assume_init_mut() });
    // SAFETY: the cell holds a complete value: the one it held before, changed by `write`.
    *entry = Some(unsafe { cell.assume_init_and_update() });
    // iceoryx2 orders the cell before the count, but nothing orders the count before the *next* update's writes. On x86 the
    // add does; on weaker machines a reader could see those first, and a torn state with it.
    fence(Ordering::SeqCst);
}

/// Publishes every cycle, in batches, and wakes sleeping clients. For an ordinary thread.
///
/// A reader that is slow loses its oldest batches and can tell how many cycles; nobody ever waits for it.
pub struct CyclePublisher {
    port: BatchPublisher,
    tick: TickNotifier,
    batch: BatchHeader,
    states: Vec<ChannelState>,
    channels: usize,
    cycles_per_batch: usize,
    unsent: u64,
    feed: Option<BoardFeed>,
    _run: Arc<Run>,
}

/// Keeps the board of the gateway in step with the blackboard.
struct BoardFeed {
    board: Board,
    snapshot: Entry<Snapshot>,
    stats: Entry<LoopStats>,
    /// When the figures are to be copied the next time: they are large, and change some times a second.
    stats_due: Instant,
    _reader: StateReader,
}

impl BoardFeed {
    fn new(board: Board, run: &Run) -> Result<BoardFeed, Error> {
        const WHAT: &str = "state";
        let service = run
            .node
            .service_builder(&name(WHAT, run.lock.key())?)
            .blackboard_opener::<u64>()
            .open()
            .map_err(failed(WHAT))?;
        let reader = service.reader_builder().create().map_err(failed(WHAT))?;
        let snapshot = reader.entry::<Snapshot>(&KEY_SNAPSHOT).map_err(failed(WHAT))?;
        let stats = reader.entry::<LoopStats>(&KEY_STATS).map_err(failed(WHAT))?;
        Ok(BoardFeed { board, snapshot, stats, stats_due: Instant::now(), _reader: reader })
    }

    fn show(&mut self, now: Instant) {
        self.board.show(&self.snapshot.get());
        if now >= self.stats_due {
            self.board.show_stats(&self.stats.get());
            self.stats_due = now + STATS_PERIOD;
        }
    }
}

impl CyclePublisher {
    fn new(run: &Arc<Run>, info: &Info) -> Result<CyclePublisher, Error> {
        const WHAT: &str = "cycles";
        let channels = info.channels().len();
        let cycles_per_batch = cycles_per_batch(info.rate_hz);
        // Shared memory is only taken when it is written, and running out of it then kills the process: look first.
        let left = crate::sys::shared_memory_left().map_or(STREAM_MEMORY, |left| left / 2);
        let slots = slots(info.rate_hz, channels, left.min(STREAM_MEMORY)).ok_or_else(|| Error::Service {
            what: WHAT,
            reason: format!(
                "only {} MB are left in /dev/shm, of which the stream may take half and needs {:.1} MB",
                (2 * left) >> 20,
                (slot_bytes(info.rate_hz, channels) * (FEWEST_SLOTS + EXTRA_SLOTS)) as f64 / f64::from(1 << 20)
            ),
        })?;
        let service = run
            .node
            .service_builder(&name(WHAT, run.lock.key())?)
            .publish_subscribe::<[ChannelState]>()
            .user_header::<BatchHeader>()
            .max_publishers(1)
            .max_subscribers(MAX_STREAMS)
            .max_nodes(MAX_CLIENTS + 1)
            .subscriber_max_buffer_size(slots)
            .subscriber_max_borrowed_samples(1)
            .history_size(0)
            .enable_safe_overflow(true)
            .create()
            .map_err(failed(WHAT))?;
        let port = service
            .publisher_builder()
            .initial_max_slice_len(channels * cycles_per_batch)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            // By itself iceoryx2 reserves a full buffer for every subscriber. But all buffers hold the same samples, always some of
            // the last `slots` sent; apart from these only the one sample each subscriber is looking at can be in use.
            .override_sample_preallocation(move |worst| (slots + EXTRA_SLOTS).min(worst))
            .create()
            .map_err(failed(WHAT))?;
        const TICK: &str = "tick";
        let tick = run
            .node
            .service_builder(&name(TICK, run.lock.key())?)
            .event()
            .max_listeners(MAX_CLIENTS)
            .max_notifiers(1)
            .max_nodes(MAX_CLIENTS + 1)
            .event_id_max_value(0)
            .create()
            .map_err(failed(TICK))?
            .notifier_builder()
            .create()
            .map_err(failed(TICK))?;
        Ok(CyclePublisher {
            port,
            tick,
            batch: BatchHeader::default(),
            states: Vec::with_capacity(channels * cycles_per_batch),
            channels,
            cycles_per_batch,
            unsent: 0,
            feed: None,
            _run: run.clone(),
        })
    }

    /// Adds one cycle; sends the batch when it is full. Of `channels` as many as the rig has are taken, in the rig's order;
    /// missing ones are filled with [`ChannelState::UNKNOWN`].
    pub fn push(&mut self, header: CycleHeader, channels: &[ChannelState]) {
        let n = channels.len().min(self.channels);
        self.states.extend_from_slice(&channels[..n]);
        self.states.resize(self.states.len() + self.channels - n, ChannelState::UNKNOWN);
        if let Some(feed) = &mut self.feed {
            feed.board.push(header, &self.states[self.states.len() - self.channels..]);
        }
        self.batch.cycle[self.batch.cycles as usize] = header;
        self.batch.cycles += 1;
        if self.batch.cycles as usize >= self.cycles_per_batch {
            self.flush();
        }
    }

    /// Adds one cycle.
    pub fn push_snapshot(&mut self, snapshot: &Snapshot) {
        self.push(snapshot.header(), snapshot.channels());
    }

    /// Sends what has been added so far. Call it when the last batch is some 10 ms old, and before the end; not for each cycle, for
    /// a reader's buffer holds a number of batches.
    pub fn flush(&mut self) {
        if self.batch.cycles == 0 {
            return;
        }
        self.batch.channels = self.channels as u32;
        let sent = self.port.loan_slice_uninit(self.states.len()).is_ok_and(|mut sample| {
            *sample.user_header_mut() = self.batch;
            sample.write_from_slice(&self.states).send().is_ok()
        });
        if !sent {
            // Readers see the gap in the cycle numbers.
            self.unsent += u64::from(self.batch.cycles);
        }
        self.batch.cycles = 0;
        self.states.clear();
    }

    /// Puts the latest state on the board of the gateway, where there is one. Each time there is something new.
    pub fn show(&mut self) {
        if let Some(feed) = &mut self.feed {
            feed.show(Instant::now());
        }
    }

    /// Wakes the clients that sleep until something is new. 12–18 µs for each of them.
    pub fn ring(&mut self) {
        if let Some(feed) = &self.feed {
            feed.board.wake();
        }
        // A sleeper whose queue of wake-ups is full wakes anyway; one that has died is dropped by iceoryx2.
        let _ = self.tick.notify();
    }

    /// How many cycles a batch holds.
    pub fn cycles_per_batch(&self) -> usize {
        self.cycles_per_batch
    }

    /// Cycles that could not be sent at all; 0 unless shared memory is broken.
    pub fn unsent(&self) -> u64 {
        self.unsent
    }
}

impl Drop for CyclePublisher {
    fn drop(&mut self) {
        self.flush();
        if let Some(feed) = &mut self.feed {
            feed.stats_due = Instant::now();
        }
        self.show();
        self.ring();
    }
}

/// A batch each 10 ms.
fn cycles_per_batch(rate_hz: f64) -> usize {
    ((rate_hz / 100.0) as usize).clamp(1, MAX_BATCH)
}

/// Bytes of a batch.
fn slot_bytes(rate_hz: f64, channels: usize) -> usize {
    cycles_per_batch(rate_hz) * channels * size_of::<ChannelState>() + size_of::<BatchHeader>()
}

/// Batches a reader may lag behind: two seconds where `memory` (bytes) allows; `None` when not even a few fit.
fn slots(rate_hz: f64, channels: usize, memory: usize) -> Option<usize> {
    let two_seconds = (2.0 * rate_hz / cycles_per_batch(rate_hz) as f64).ceil() as usize;
    let fitting = (memory / slot_bytes(rate_hz, channels)).saturating_sub(EXTRA_SLOTS);
    (fitting >= FEWEST_SLOTS).then(|| two_seconds.clamp(FEWEST_SLOTS, 1024).min(fitting))
}

/// Receives requests and sends replies. For an ordinary thread, which looks after them some hundred times a second at least.
pub struct CommandServer {
    port: Replies,
    bell: TickListener,
    listener: Option<Listener>,
    _janitor: Janitor,
    run: Arc<Run>,
}

impl CommandServer {
    fn new(run: &Arc<Run>) -> Result<CommandServer, Error> {
        const WHAT: &str = "command";
        let port = run
            .node
            .service_builder(&name(WHAT, run.lock.key())?)
            .request_response::<[Command], [Reply]>()
            .request_user_header::<Terms>()
            .max_servers(1)
            .max_clients(MAX_CLIENTS)
            .max_nodes(MAX_CLIENTS + 1)
            .max_active_requests_per_client(MAX_ACTIVE_REQUESTS)
            .max_response_buffer_size(1)
            // A command whose sender has given up waiting is not carried out.
            .enable_fire_and_forget_requests(false)
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(true)
            .create()
            .map_err(failed(WHAT))?
            .server_builder()
            .initial_max_slice_len(MAX_CHANNELS)
            .create()
            .map_err(failed(WHAT))?;
        const BELL: &str = "bell";
        let bell = run
            .node
            .service_builder(&name(BELL, run.lock.key())?)
            .event()
            .max_listeners(1)
            .max_notifiers(MAX_CLIENTS)
            .max_nodes(MAX_CLIENTS + 1)
            .event_id_max_value(0)
            .create()
            .map_err(failed(BELL))?
            .listener_builder()
            .create()
            .map_err(failed(BELL))?;
        Ok(CommandServer { port, bell, listener: None, _janitor: Janitor::start(run)?, run: run.clone() })
    }

    /// Sleeps until one of the own user's clients has asked something, up to `timeout`. Others are not heard: look after them now and then.
    pub fn wait(&self, timeout: Duration) {
        if listen(&self.bell, timeout).is_err() {
            // A bell that is broken: nobody hears anything, and looks all the same.
            std::thread::sleep(timeout);
        }
    }

    /// The next request that waits, if any: the own user's first, then those that come through the gateway.
    pub fn receive(&mut self) -> Option<Request> {
        // A client that died while it was connecting may leave a connection that cannot be opened: its trouble only.
        while let Ok(Some(request)) = self.port.receive() {
            // A copy: who sent it may still write into what he sent.
            let commands = request.payload().iter().take(MAX_CHANNELS + 1).copied().collect::<Vec<_>>();
            if (1..=MAX_CHANNELS).contains(&commands.len()) {
                let terms = *request.user_header();
                return Some(Request { commands, terms, way: Way::Memory(Box::new(request)) });
            }
        }
        let (ask, answer) = self.listener.as_mut()?.receive()?;
        Some(Request { commands: ask.commands, terms: ask.terms, way: Way::Gateway(answer) })
    }

    /// Answers every request that waits by `decide`, command by command. Returns how many were answered.
    pub fn serve(&mut self, mut decide: impl FnMut(&Command) -> Reply) -> usize {
        let mut answered = 0;
        while answered < REQUESTS_PER_CALL
            && let Some(request) = self.receive()
        {
            let is_permitted = request.is_permitted();
            let replies = request.commands.iter().map(|command| match is_permitted {
                true => decide(command),
                false => Reply::refused(command, Outcome::NotPermitted),
            });
            let replies = replies.collect();
            request.reply(replies);
            answered += 1;
        }
        answered
    }
}

/// One request, waiting for its answer. Dropping it without one lets its client wait until its patience ends.
pub struct Request {
    commands: Vec<Command>,
    terms: Terms,
    way: Way,
}

/// Who asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asker {
    /// The number its client has given itself.
    pub client: u64,
    /// Its process: of the own user's as it says, of another user's as the kernel says.
    pub pid: u32,
    /// Another user, who comes through the gateway.
    pub user: Option<u32>,
}

/// The way its answer goes.
enum Way {
    Memory(Box<ActiveRequest>),
    Gateway(gateway::Answer),
}

impl Request {
    /// What is asked for: 1 to [`MAX_CHANNELS`] commands.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// How they are meant: any bits at all, as the commands.
    pub fn terms(&self) -> Terms {
        self.terms
    }

    /// Whether it only switches off: then it is never late, nor overtaken.
    pub fn only_switches_off(&self) -> bool {
        Command::only_switch_off(&self.commands)
    }

    /// What it is answered if it is too late by now to be carried out.
    pub fn is_late(&self, now_ns: u64) -> Option<Outcome> {
        self.terms.is_late(&self.commands, now_ns)
    }

    /// Who asks: all commands of a request are of one client.
    pub fn asker(&self) -> Asker {
        let client = self.commands.first().map_or(0, |command| command.client);
        match &self.way {
            Way::Memory(_) => Asker { client, pid: (client >> 32) as u32, user: None },
            Way::Gateway(answer) => {
                let (pid, user) = answer.peer();
                Asker { client, pid, user: Some(user) }
            }
        }
    }

    /// Whether whoever asks may ask for that; else the answer is [`Outcome::NotPermitted`].
    pub fn is_permitted(&self) -> bool {
        match &self.way {
            Way::Memory(_) => true,
            Way::Gateway(answer) => self.commands.iter().all(|command| answer.may_ask(command.kind())),
        }
    }

    /// Answers it, with a reply for each command. A client that has gone meanwhile is nobody's loss.
    pub fn reply(self, mut replies: Vec<Reply>) {
        for (reply, command) in replies.iter_mut().zip(&self.commands) {
            reply.sequence = command.sequence;
        }
        match self.way {
            Way::Memory(request) => {
                if let Ok(answer) = request.loan_slice_uninit(replies.len()) {
                    let _ = answer.write_from_slice(&replies).send();
                }
            }
            Way::Gateway(answer) => answer.send_replies(&replies),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_of_another_version_is_told_so() {
        let rig = format!("t-{}-protocol", std::process::id());
        let info = Info::new(&rig, 100.0, &[crate::ChannelInfo::EMPTY]).unwrap();
        let wrong = Error::Protocol { rig: rig.clone(), found: PROTOCOL + 1, expected: PROTOCOL };
        let connect = || crate::Client::connect(&rig).map(|_| ());
        // By the lock file, before anything of another layout is touched ...
        let server = Server::create_with_protocol(RigLock::acquire(&rig).unwrap(), &info, PROTOCOL + 1).unwrap();
        assert_eq!(connect(), Err(wrong.clone()));
        drop(server);
        // ... and by what the driver says of itself.
        let other = Info { protocol: PROTOCOL + 1, ..info };
        let server = Server::create(RigLock::acquire(&rig).unwrap(), &other).unwrap();
        assert_eq!(connect(), Err(wrong));
        drop(server);
        let _server = Server::create(RigLock::acquire(&rig).unwrap(), &info).unwrap();
        assert_eq!(connect(), Ok(()));
    }

    #[test]
    fn a_reader_may_lag_by_a_second_at_the_figures_the_driver_is_built_for() {
        for (rate, channels) in [(1000.0, 18), (5000.0, 64), (100.0, 1), (10_000.0, 18)] {
            let slots = slots(rate, channels, STREAM_MEMORY).unwrap();
            let seconds = (slots * cycles_per_batch(rate)) as f64 / rate;
            assert!(seconds >= 1.0, "{rate} Hz, {channels} channels: {seconds} s");
            assert!((slots + EXTRA_SLOTS) * slot_bytes(rate, channels) <= STREAM_MEMORY);
        }
        // With little memory less, and with too little an error at the start and not a signal later.
        let little = slots(5000.0, 64, STREAM_MEMORY / 3).unwrap();
        assert!((FEWEST_SLOTS..60).contains(&little), "{little}");
        assert_eq!(slots(5000.0, 64, STREAM_MEMORY / 4), None);
    }
}
