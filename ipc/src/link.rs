//! A connection to a driver, whichever way: what is common to a client, its streams and its waiters.

use crate::gateway::{BoardReader, Connection};
use crate::memory::{self, Memory};
use crate::run::Attachment;
use crate::service::TickListener;
use crate::{Command, CommandKind, Error, Info, LoopStats, Name, PROTOCOL, Reply, Snapshot, Terms};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The two ways to a driver.
pub(crate) enum Link {
    /// The own user's.
    Memory(Box<Memory>),
    /// Another user's.
    Gateway(Box<Connection>),
}

impl Link {
    /// Finds a rig's driver: the own user's first, then at the gateway.
    pub fn find(rig: &str, patience: Duration) -> Result<(Link, Info), Error> {
        let own = own(rig, patience);
        // A driver of one's own that is starting or ailing is not passed over for somebody else's.
        let Err(none @ (Error::NotRunning { .. } | Error::RuntimeDir { .. })) = own else { return own };
        let Some(connection) = Connection::find(rig, patience)? else { return Err(none) };
        Link::through(connection, rig)
    }

    /// Through the gateway of another user's driver.
    pub fn through(connection: Connection, rig: &str) -> Result<(Link, Info), Error> {
        let info = connection.info();
        if info.protocol != PROTOCOL {
            return Err(Error::Protocol { rig: rig.into(), found: info.protocol, expected: PROTOCOL });
        }
        Ok((Link::Gateway(Box::new(connection)), info))
    }

    pub fn driver_lives(&self) -> bool {
        match self {
            Link::Memory(memory) => memory.driver_lives(),
            Link::Gateway(connection) => connection.driver_lives(),
        }
    }

    /// An error when the driver is gone.
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Link::Memory(memory) => memory.check(),
            Link::Gateway(connection) => connection.check(),
        }
    }

    pub fn with_latest<T>(&self, look: impl FnOnce(&Snapshot) -> T) -> T {
        match self {
            Link::Memory(memory) => memory.with_latest(look),
            Link::Gateway(connection) => look(&connection.board.latest()),
        }
    }

    pub fn stats(&self) -> LoopStats {
        match self {
            Link::Memory(memory) => memory.stats(),
            Link::Gateway(connection) => connection.board.stats(),
        }
    }

    pub fn rig_text(&self) -> Result<Option<String>, Error> {
        match self {
            Link::Memory(memory) => memory.rig_text(),
            Link::Gateway(connection) => Ok(connection.board.text()),
        }
    }

    /// Sends the commands of one request, 1 to [`MAX_CHANNELS`](crate::MAX_CHANNELS), and waits for the replies, as many.
    pub fn ask(&self, commands: &[Command], patience: Duration) -> Result<Vec<Reply>, Error> {
        match self {
            Link::Memory(memory) => memory.ask(commands, patience),
            Link::Gateway(connection) => connection.ask(commands, patience),
        }
    }

    /// Sends the commands of one request, 1 to [`MAX_CHANNELS`](crate::MAX_CHANNELS), and does not wait. `None`: there is no room now.
    pub fn send(&self, commands: &[Command], terms: Terms) -> Result<Option<Sent>, Error> {
        let sequence = commands.first().map_or(0, |command| command.sequence);
        match self {
            // With as many unanswered as it may have a client has no room, and iceoryx2 has an error.
            Link::Memory(memory) => match memory.send(commands, terms) {
                Ok(pending) => Ok(Some(Sent::Memory(Box::new(pending)))),
                Err(_) => memory.check().map(|()| None),
            },
            Link::Gateway(connection) => Ok(connection.send(commands, terms)?.then_some(Sent::Gateway(sequence))),
        }
    }

    /// The replies to a request that was sent, if they have come.
    pub fn poll(&self, sent: &Sent) -> Option<Vec<Reply>> {
        match (sent, self) {
            (Sent::Memory(pending), _) => pending.poll(),
            (Sent::Gateway(sequence), Link::Gateway(connection)) => connection.answer(*sequence),
            (Sent::Gateway(_), Link::Memory(_)) => None,
        }
    }

    /// The group whose members may ask this of the driver from other accounts; empty where that does not matter.
    pub fn group_for(&self, kind: CommandKind) -> Name {
        match self {
            Link::Memory(_) => Name::EMPTY,
            Link::Gateway(connection) => connection.group_for(kind),
        }
    }

    /// Whether the driver is another user's.
    pub fn is_foreign(&self) -> bool {
        matches!(self, Link::Gateway(_))
    }
}

/// A request on its way.
pub(crate) enum Sent {
    Memory(Box<memory::Pending>),
    /// The number of the request.
    Gateway(u64),
}

fn own(rig: &str, patience: Duration) -> Result<(Link, Info), Error> {
    let end = Instant::now() + patience;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        let attachment = Attachment::find(rig, left)?;
        match Memory::open(attachment) {
            Ok((memory, info)) => return Ok((Link::Memory(Box::new(memory)), info)),
            // A driver that is just ending, or many clients at once: worth another look while there is time.
            Err(Error::Service { .. } | Error::Full { .. }) if !left.is_zero() => {
                std::thread::sleep(Duration::from_millis(10));
            }
            Err(e) => return Err(e),
        }
    }
}

/// Sleeps until the driver rings. Made by [`crate::Client::waiter`].
pub struct Waiter {
    source: WakeSource,
    link: Arc<Link>,
}

enum WakeSource {
    Memory(Box<TickListener>),
    /// The count of wake-ups seen last.
    Gateway(u32),
}

impl Waiter {
    pub(crate) fn new(link: &Arc<Link>) -> Result<Waiter, Error> {
        let source = match &**link {
            Link::Memory(memory) => WakeSource::Memory(Box::new(memory.listener()?)),
            Link::Gateway(connection) => WakeSource::Gateway(connection.board.wakes()),
        };
        Ok(Waiter { source, link: link.clone() })
    }

    /// Sleeps until something is new, up to `timeout`; false when nothing came.
    ///
    /// # Errors
    /// [`Error::DriverGone`], [`Error::Service`].
    pub fn wait(&mut self, timeout: Duration) -> Result<bool, Error> {
        /// A dead driver does not ring: look after it now and then.
        const SLICE: Duration = Duration::from_millis(100);
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let woken = match (&mut self.source, &*self.link) {
                (WakeSource::Memory(port), _) => memory::listen(port, left.min(SLICE))? > 0,
                (WakeSource::Gateway(seen), Link::Gateway(connection)) => {
                    listen(&connection.board, seen, left.min(SLICE))
                }
                (WakeSource::Gateway(_), Link::Memory(_)) => false,
            };
            if woken {
                return Ok(true);
            }
            self.link.check()?;
            if left.is_zero() {
                return Ok(false);
            }
        }
    }
}

fn listen(board: &BoardReader, seen: &mut u32, timeout: Duration) -> bool {
    if board.wakes() == *seen && !timeout.is_zero() {
        board.sleep(*seen, timeout);
    }
    let wakes = board.wakes();
    std::mem::replace(seen, wakes) != wakes
}
