//! The own user's way to a driver: iceoryx2's shared memory.

use crate::run::Attachment;
use crate::service::{
    BatchSubscriber, Entry, Ipc, IpcNode, KEY_INFO, KEY_SNAPSHOT, KEY_STATS, MAX_CLIENTS, MAX_STREAMS, PendingReplies,
    Requests, StateReader, TickListener, TickNotifier, failed, name, node,
};
use crate::{
    BatchHeader, ChannelState, Command, DriverState, Error, Info, LoopStats, MAX_CHANNELS, PROTOCOL, Reply, Snapshot,
    Terms,
};
use iceoryx2::port::listener::ListenerWaitError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use std::fmt::Debug;
use std::time::{Duration, Instant};

/// How often the answer is looked for: at first, as long as a loop of some hundred Hz takes, and then.
const QUICK: Duration = Duration::from_millis(5);
const SHORT_PAUSE: Duration = Duration::from_micros(50);
const LONG_PAUSE: Duration = Duration::from_micros(500);

/// A connection over shared memory. Fields are dropped in this order: the node behind every port, the hold on the run's files last.
pub(crate) struct Memory {
    stats: Entry<LoopStats>,
    snapshot: Entry<Snapshot>,
    _reader: StateReader,
    requests: Requests,
    /// Wakes the driver's desk.
    bell: TickNotifier,
    cycles: publish_subscribe::PortFactory<Ipc, [ChannelState], BatchHeader>,
    tick: event::PortFactory<Ipc>,
    _node: IpcNode,
    attachment: Attachment,
}

impl Memory {
    /// Opens the services of a run, and reads what does not change.
    pub fn open(attachment: Attachment) -> Result<(Memory, Info), Error> {
        let (rig, key) = (attachment.rig().to_string(), &attachment.key);
        let node = node(&attachment.run, &attachment.run_dir())?;
        let state = node
            .service_builder(&name("state", key)?)
            .blackboard_opener::<u64>()
            .open()
            .map_err(full_or_failed("state", &rig))?;
        let reader = state.reader_builder().create().map_err(full_or_failed("state", &rig))?;
        let info = *reader.entry::<Info>(&KEY_INFO).map_err(failed("state"))?.get();
        if info.protocol != PROTOCOL {
            return Err(Error::Protocol { rig, found: info.protocol, expected: PROTOCOL });
        }
        let snapshot = reader.entry::<Snapshot>(&KEY_SNAPSHOT).map_err(failed("state"))?;
        let stats = reader.entry::<LoopStats>(&KEY_STATS).map_err(failed("state"))?;
        let cycles = node
            .service_builder(&name("cycles", key)?)
            .publish_subscribe::<[ChannelState]>()
            .user_header::<BatchHeader>()
            .open()
            .map_err(full_or_failed("cycles", &rig))?;
        let tick = node.service_builder(&name("tick", key)?).event().open().map_err(full_or_failed("tick", &rig))?;
        let requests = node
            .service_builder(&name("command", key)?)
            .request_response::<[Command], [Reply]>()
            .request_user_header::<Terms>()
            .open()
            .map_err(full_or_failed("command", &rig))?
            .client_builder()
            .initial_max_slice_len(MAX_CHANNELS)
            .create()
            .map_err(full_or_failed("command", &rig))?;
        let bell = node
            .service_builder(&name("bell", key)?)
            .event()
            .open()
            .map_err(full_or_failed("bell", &rig))?
            .notifier_builder()
            .create()
            .map_err(full_or_failed("bell", &rig))?;
        let memory = Memory { stats, snapshot, _reader: reader, requests, bell, cycles, tick, _node: node, attachment };
        Ok((memory, info))
    }

    pub fn rig(&self) -> &str {
        self.attachment.rig()
    }

    pub fn driver_lives(&self) -> bool {
        self.attachment.driver_lives()
    }

    pub fn rig_text(&self) -> Result<Option<String>, Error> {
        self.attachment.rig_text()
    }

    pub fn with_latest<T>(&self, look: impl FnOnce(&Snapshot) -> T) -> T {
        look(&self.snapshot.get())
    }

    pub fn stats(&self) -> LoopStats {
        *self.stats.get()
    }

    /// An error when the driver is gone.
    pub fn check(&self) -> Result<(), Error> {
        if self.driver_lives() {
            return Ok(());
        }
        Err(Error::DriverGone {
            rig: self.rig().into(),
            pid: self.attachment.pid,
            stopped: self.snapshot.get().state() == DriverState::Stopped,
        })
    }

    /// Every batch from now on.
    pub fn batches(&self) -> Result<BatchSubscriber, Error> {
        self.cycles.subscriber_builder().create().map_err(|e| match e {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                Error::Full { rig: self.rig().into(), what: "streams", most: MAX_STREAMS as u32 }
            }
            e => failed("cycles")(e),
        })
    }

    /// A sleeper's ear.
    pub fn listener(&self) -> Result<TickListener, Error> {
        self.tick.listener_builder().create().map_err(full_or_failed("tick", self.rig()))
    }

    /// Sends the commands of one request and waits for the replies, as many.
    pub fn ask(&self, commands: &[Command], patience: Duration) -> Result<Vec<Reply>, Error> {
        self.check()?;
        let started = Instant::now();
        let terms = Terms::within(patience);
        let no_answer = |waited| match self.check() {
            Err(gone) => gone,
            Ok(()) => Error::NoAnswer { rig: self.rig().into(), waited },
        };
        // All requests this client may have unanswered can be taken, by other threads: theirs will be answered soon.
        let pending = loop {
            match self.send(commands, terms) {
                Ok(pending) => break pending,
                Err(e) if started.elapsed() >= patience => {
                    self.check()?;
                    return Err(e);
                }
                Err(_) => std::thread::sleep(Duration::from_micros(500)),
            }
        };
        let mut next_check = Duration::from_millis(20);
        loop {
            if let Some(replies) = pending.poll() {
                return Ok(replies);
            }
            let waited = started.elapsed();
            if waited >= patience {
                return Err(no_answer(waited));
            }
            if waited >= next_check {
                self.check()?;
                next_check = waited + Duration::from_millis(20);
            }
            std::thread::sleep(if waited < QUICK { SHORT_PAUSE } else { LONG_PAUSE });
        }
    }

    /// Sends the commands of one request, and does not wait; an error where this client has as many unanswered as it may.
    pub fn send(&self, commands: &[Command], terms: Terms) -> Result<Pending, Error> {
        let mut request = self.requests.loan_slice_uninit(commands.len()).map_err(failed("command"))?;
        *request.user_header_mut() = terms;
        let replies = request.write_from_slice(commands).send().map_err(failed("command"))?;
        // A desk that nobody wakes looks by itself, a little later.
        let _ = self.bell.notify();
        let sequence = commands.first().map_or(0, |command| command.sequence);
        Ok(Pending { replies, sequence, count: commands.len() })
    }
}

/// A request that was sent. Dropped, it is not carried out where the driver has not begun with it.
pub(crate) struct Pending {
    replies: PendingReplies,
    sequence: u64,
    count: usize,
}

impl Pending {
    /// The replies to its commands, if they have come.
    pub fn poll(&self) -> Option<Vec<Reply>> {
        let replies = self.replies.receive().ok()??;
        (replies.len() == self.count && replies[0].sequence == self.sequence).then(|| replies.to_vec())
    }
}

/// Whether an error of iceoryx2 says that there is no room for one more. Its enums have no common type, but all say it alike.
fn full_or_failed<E: Debug>(what: &'static str, rig: &str) -> impl Fn(E) -> Error {
    move |e| {
        if format!("{e:?}").contains("ExceedsMax") {
            return Error::Full { rig: rig.into(), what: "clients", most: MAX_CLIENTS as u32 };
        }
        failed(what)(e)
    }
}

/// Sleeps until the driver notifies, up to `timeout`; how often it did.
pub(crate) fn listen(port: &TickListener, timeout: Duration) -> Result<usize, Error> {
    const SHORTEST: Duration = Duration::from_micros(10);
    // iceoryx2 hands the time to SO_RCVTIMEO in microseconds, where 0 means "for ever".
    let woken = if timeout < SHORTEST { port.try_wait(|_| {}) } else { port.timed_wait(|_| {}, timeout) };
    match woken {
        Ok(rings) => Ok(rings as usize),
        Err(ListenerWaitError::InterruptSignal) => Ok(0),
        Err(e) => Err(failed("tick")(e)),
    }
}
