//! Every cycle in order, with an exact count of those this reader has lost.

use crate::client::{Link, Waiter};
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
/// It buffers about two seconds (less for large and fast rigs: 1.4 s at 64 channels and 5 kHz); a reader that falls behind further loses the oldest
/// cycles and is told how many.
pub struct CycleStream {
    batch: Option<Batch>,
    port: BatchSubscriber,
    waiter: Option<Waiter>,
    /// Next cycle of `batch`.
    index: usize,
    /// The latest cycle when the stream was opened: what came before is not its business, though a batch may bring it.
    opened_after: u64,
    /// Number the next cycle should have; 0 before the first.
    expected: u64,
    received: u64,
    lost: u64,
    link: Arc<Link>,
}

impl CycleStream {
    pub(crate) fn new(link: &Arc<Link>, opened_after: u64) -> Result<CycleStream, Error> {
        let port = link.cycles.subscriber_builder().create().map_err(failed("cycles"))?;
        Ok(CycleStream {
            batch: None,
            port,
            waiter: None,
            index: 0,
            opened_after,
            expected: 0,
            received: 0,
            lost: 0,
            link: link.clone(),
        })
    }

    /// The next cycle, if one is there; never waits.
    ///
    /// # Errors
    /// [`Error::DriverGone`] when everything the driver had sent is read and no more can come.
    // Not an iterator: a cycle lies in shared memory and must be let go before the next.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<Cycle<'_>>, Error> {
        if !self.take_batch()? {
            return Ok(None);
        }
        let Some(batch) = &self.batch else { return Ok(None) };
        let header = batch.user_header();
        let channels = header.channels as usize;
        let i = self.index;
        let (Some(cycle), Some(states)) = (header.cycle.get(i), batch.payload().get(i * channels..(i + 1) * channels))
        else {
            return Ok(None);
        };
        let lost = if self.expected == 0 { 0 } else { cycle.cycle.saturating_sub(self.expected) };
        self.index += 1;
        self.expected = cycle.cycle + 1;
        self.received += 1;
        self.lost += lost;
        Ok(Some(Cycle { header: cycle, channels: states, lost }))
    }

    /// The next cycle, waiting for it up to `timeout`; `None` when none came in time.
    ///
    /// # Errors
    /// As [`CycleStream::next`].
    pub fn next_within(&mut self, timeout: Duration) -> Result<Option<Cycle<'_>>, Error> {
        let end = Instant::now() + timeout;
        while !self.take_batch()? {
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

    /// Sees to it that `index` points to the next cycle of a batch; false when none is there yet.
    fn take_batch(&mut self) -> Result<bool, Error> {
        loop {
            if let Some(batch) = &self.batch {
                let header = batch.user_header();
                while self.index < cycles_in(batch) && header.cycle[self.index].cycle <= self.opened_after {
                    self.index += 1;
                }
                if self.index < cycles_in(batch) {
                    return Ok(true);
                }
            }
            // Let go of the old batch first: only one may be held.
            self.batch = None;
            self.index = 0;
            // Asked before looking, so that what is sent between the two is not lost.
            let alive = self.link.check();
            self.batch = self.port.receive().map_err(failed("cycles"))?;
            if self.batch.is_none() {
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

fn cycles_in(batch: &Batch) -> usize {
    let header = batch.user_header();
    (header.cycles as usize).min(crate::MAX_BATCH)
}
