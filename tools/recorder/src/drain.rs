//! The thread that reads the driver's stream. It waits for the driver only.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::{Client, CycleStream, Error};
use sinew_recording::session::{Ended, Head};

use crate::blocks::{Block, Inlet, Item};
use crate::figures::loop_figures;
use crate::shared::Shared;

/// How often the stream is emptied; it holds a second and more.
const PERIOD: Duration = Duration::from_millis(10);
/// A block is handed on from this size on, bytes, or when it is so old.
const BLOCK_BYTES: u64 = 256 << 10;
const BLOCK_AGE: Duration = Duration::from_millis(50);
/// How often the loop's figures are asked for.
const FIGURES: Duration = Duration::from_secs(1);
/// A driver that stands still does not keep a recording from ending so long after its time.
const GRACE: Duration = Duration::from_secs(1);

/// Empties the stream into the buffer until something ends it, and says there what did. `from_ns` is when the recording's time
/// begins, `length_ns` how long it is to be.
pub(crate) fn drain(
    client: &Client,
    mut stream: CycleStream,
    inlet: &Inlet,
    shared: &Shared,
    from_ns: u64,
    length_ns: Option<u64>,
) {
    let started = Instant::now();
    let end_ns = length_ns.map(|length| from_ns.saturating_add(length));
    let latest = length_ns.map(|length| started + Duration::from_nanos(length) + GRACE);
    let (mut next_figures, mut next_block) = (started, started + BLOCK_AGE);
    let mut block = Block::default();
    let mut last = Head::default();
    let ended = loop {
        if sinew_threads::is_struck() {
            return;
        }
        let found = loop {
            match stream.next() {
                Ok(Some(cycle)) if end_ns.is_some_and(|end| cycle.header.monotonic_ns > end) => {
                    break Some(Ended::Complete);
                }
                Ok(Some(cycle)) => {
                    last = block.push(cycle.header, cycle.channels);
                    if block.bytes() >= BLOCK_BYTES {
                        hand_on(&mut block, inlet, shared);
                    }
                }
                Ok(None) => break None,
                Err(Error::DriverGone { stopped: true, .. }) => break Some(Ended::DriverStopped),
                Err(Error::DriverGone { .. }) => break Some(Ended::DriverDied),
                Err(error) => {
                    shared.fail(error.into());
                    break Some(Ended::Stopped);
                }
            }
        };
        let now = Instant::now();
        if now >= next_block || found.is_some() {
            hand_on(&mut block, inlet, shared);
            next_block = now + BLOCK_AGE;
        }
        shared.lost_in_stream.store(stream.lost(), Ordering::Relaxed);
        if last.cycle > 0 && (now >= next_figures || found.is_some()) {
            inlet.send(Item::Figures(Box::new(loop_figures(&client.loop_stats(), last.cycle, last.monotonic_ns))));
            next_figures = now + FIGURES;
        }
        match found {
            Some(ended) => break ended,
            None if shared.stop.load(Ordering::Relaxed) => {
                hand_on(&mut block, inlet, shared);
                break Ended::Stopped;
            }
            None if latest.is_some_and(|latest| now >= latest) => break Ended::Complete,
            None => std::thread::sleep(PERIOD),
        }
    };
    inlet.send(Item::End(ended, last));
    shared.drained.store(true, Ordering::Release);
}

fn hand_on(block: &mut Block, inlet: &Inlet, shared: &Shared) {
    let cycles = block.cycles();
    shared.received.fetch_add(cycles, Ordering::Relaxed);
    if !inlet.put(block) {
        shared.dropped.fetch_add(cycles, Ordering::Relaxed);
    }
}
