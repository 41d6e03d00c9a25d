//! Takes every cycle out of the loop's ring and publishes it, on an ordinary thread, so that the loop never pays for a
//! subscriber.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rtrb::Consumer;
use sinew_ipc::{ChannelState, CycleHeader, CyclePublisher};

use crate::cycles::Shared;

/// How often the ring is emptied.
const PERIOD: Duration = Duration::from_millis(2);
/// Longest that cycles wait for their batch to fill.
const BATCH_AGE: Duration = Duration::from_millis(10);
/// Waking sleepers may take this part of the thread's time: with very many of them they are woken less often.
const RING_SHARE: u32 = 20;

/// Publishes until the loop has ended and its ring is empty. `port` is `None` where nothing is to be published: then the ring is
/// only emptied.
pub(crate) fn publish(
    mut heads: Consumer<CycleHeader>,
    mut states: Consumer<ChannelState>,
    channels: usize,
    mut port: Option<CyclePublisher>,
    shared: &Shared,
) {
    let mut cycle = vec![ChannelState::UNKNOWN; channels];
    let mut next_ring = Instant::now();
    let mut next_flush = Instant::now() + BATCH_AGE;
    loop {
        // Asked before looking, so that the last cycles are not left behind.
        let ended = shared.ended.load(Ordering::Acquire);
        let mut news = false;
        while let Ok(head) = heads.pop() {
            news = true;
            // The loop pushes a head after its channels, so they are there.
            let Ok(chunk) = states.read_chunk(channels) else { break };
            let (first, rest) = chunk.as_slices();
            cycle[..first.len()].copy_from_slice(first);
            cycle[first.len()..].copy_from_slice(rest);
            chunk.commit_all();
            if let Some(port) = &mut port {
                port.push(head, &cycle);
            }
        }
        let now = Instant::now();
        if let Some(port) = &mut port {
            if now >= next_flush || ended {
                port.flush();
                shared.unsent.store(port.unsent(), Ordering::Relaxed);
                next_flush = now + BATCH_AGE;
            }
            if news && now >= next_ring {
                port.ring();
                next_ring = now + now.elapsed() * RING_SHARE;
            }
        }
        if ended {
            return;
        }
        std::thread::sleep(PERIOD);
    }
}
