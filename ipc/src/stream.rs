//! Every cycle in order, with an exact count of those this reader has lost.

use crate::gateway::Connection;
use crate::link::{Link, Waiter};
use crate::service::{Batch, BatchSubscriber, failed};
use crate::{ChannelState, CycleHeader, Error};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// One cycle of the stream, in shared memory: copy what is to be kept.
#[derive(Debug, Clone, Copy)]
pub struct Cycle<'a> {
    /// Number and time of the cycle.
    pub header: &'a CycleHeader,
    /// All channels, in the rig's order.
    pub channels: &'a [ChannelState],
    /// Cycles lost between the one before and this one.
    pub lost: u64,
}

/// All cycles from the moment it was opened, in order. Made by [`crate::Client::stream`].
///
/// It buffers about two seconds (less for large and fast rigs: 1.3 s at 64 channels and 5 kHz); a reader that falls behind further loses the oldest
/// cycles and is told how many.
pub struct CycleStream {
    source: Source,
    waiter: Option<Waiter>,
    /// The latest cycle when the stream was opened: what came before is not its business, though a batch may bring it.
    opened_after: u64,
    /// Number the next cycle should have; 0 before the first.
    expected: u64,
    received: u64,
    lost: u64,
    link: Arc<Link>,
}

/// Where the cycles come from.
enum Source {
    /// Batches in shared memory, of which one may be held at a time.
    Memory { port: Box<BatchSubscriber>, batch: Option<Batch>, index: usize },
    /// The ring on the board of a gateway, from which each cycle is copied.
    Gateway { next: u64, copied: bool, header: CycleHeader, channels: Vec<ChannelState> },
}

impl CycleStream {
    pub(crate) fn new(link: &Arc<Link>, opened_after: u64) -> Result<CycleStream, Error> {
        let source = match &**link {
            Link::Memory(memory) => Source::Memory { port: Box::new(memory.batches()?), batch: None, index: 0 },
            Link::Gateway(connection) => Source::Gateway {
                next: connection.board.head(),
                copied: false,
                header: CycleHeader::default(),
                channels: vec![ChannelState::UNKNOWN; connection.board.channels()],
            },
        };
        Ok(CycleStream { source, waiter: None, opened_after, expected: 0, received: 0, lost: 0, link: link.clone() })
    }

    /// The next cycle, if one is there; never waits.
    ///
    /// # Errors
    /// [`Error::DriverGone`] when everything the driver had sent is read and no more can come.
    // Not an iterator: a cycle lies in shared memory and must be let go before the next.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<Cycle<'_>>, Error> {
        if !self.is_there()? {
            return Ok(None);
        }
        let Some((header, channels)) = self.source.take() else { return Ok(None) };
        let lost = if self.expected == 0 { 0 } else { header.cycle.saturating_sub(self.expected) };
        self.expected = header.cycle.saturating_add(1);
        self.received += 1;
        self.lost = self.lost.saturating_add(lost);
        Ok(Some(Cycle { header, channels, lost }))
    }

    /// The next cycle, waiting for it up to `timeout`; `None` when none came in time.
    ///
    /// # Errors
    /// As [`CycleStream::next`].
    pub fn next_within(&mut self, timeout: Duration) -> Result<Option<Cycle<'_>>, Error> {
        let end = Instant::now() + timeout;
        while !self.is_there()? {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            let waiter = match &mut self.waiter {
                Some(waiter) => waiter,
                none => none.insert(Waiter::new(&self.link)?),
            };
            waiter.wait(left)?;
        }
        self.next()
    }

    /// Sees to it that the source has the next cycle ready; false when none is there yet.
    fn is_there(&mut self) -> Result<bool, Error> {
        loop {
            while let Some(cycle) = self.source.ready() {
                if cycle > self.opened_after {
                    return Ok(true);
                }
                self.source.take();
            }
            // Asked before looking, so that what is sent between the two is not lost.
            let alive = self.link.check();
            let found = match &*self.link {
                Link::Memory(_) => self.source.receive()?,
                Link::Gateway(connection) => self.source.copy(connection),
            };
            if !found {
                return alive.map(|()| false);
            }
        }
    }

    /// Cycles received so far.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Cycles lost since the first one received: exactly those the driver ran and this reader did not get.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

impl Source {
    /// Number of the cycle that is ready, if one is.
    fn ready(&self) -> Option<u64> {
        match self {
            Source::Memory { batch, index, .. } => {
                let batch = batch.as_ref()?;
                (*index < cycles_in(batch)).then(|| batch.user_header().cycle[*index].cycle)
            }
            Source::Gateway { copied, header, .. } => copied.then_some(header.cycle),
        }
    }

    /// Gives it away.
    fn take(&mut self) -> Option<(&CycleHeader, &[ChannelState])> {
        match self {
            Source::Memory { batch, index, .. } => {
                let header = batch.as_ref()?.user_header();
                let (i, channels) = (*index, header.channels as usize);
                *index += 1;
                // What a foreign writer may have put there leads nowhere.
                let states = i.checked_mul(channels).zip((i + 1).checked_mul(channels));
                let states = states.and_then(|(from, to)| batch.as_ref()?.payload().get(from..to));
                Some((header.cycle.get(i)?, states?))
            }
            Source::Gateway { copied, header, channels, .. } => {
                std::mem::take(copied).then_some((&*header, channels.as_slice()))
            }
        }
    }

    /// Fetches the next batch; false when none has come.
    fn receive(&mut self) -> Result<bool, Error> {
        let Source::Memory { port, batch, index } = self else { return Ok(false) };
        // Let go of the old batch first: only one may be held.
        *batch = None;
        *index = 0;
        *batch = port.receive().map_err(failed("cycles"))?;
        Ok(batch.is_some())
    }

    /// Copies the next cycle off the board; false when it has not come.
    fn copy(&mut self, connection: &Connection) -> bool {
        let Source::Gateway { next, copied, header, channels } = self else { return false };
        let found = connection.board.cycle(*next, header, channels);
        *next = found.map_or(*next, |index| index + 1);
        *copied = found.is_some();
        *copied
    }
}

fn cycles_in(batch: &Batch) -> usize {
    let header = batch.user_header();
    (header.cycles as usize).min(crate::MAX_BATCH)
}
