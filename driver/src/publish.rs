//! Takes every cycle out of the loop's ring and publishes it, on an ordinary thread, so that subscribers cost the loop
//! nothing.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::{ChannelState, CycleHeader, CyclePublisher, HeldCycle};
use sinew_ring::Consumer;

use crate::cycles::Shared;

/// An observer of every cycle inside the driver's own process, before it is published. Called on an ordinary thread, which
/// publishes for everybody: nothing in it may take long. Dropped when the loop has ended and every cycle has been seen.
pub trait Tap: Send {
    /// A cycle of all channels, in order. A number that is left out was dropped by the ring, see `unpublished` in the report.
    fn cycle(&mut self, header: &CycleHeader, channels: &[ChannelState]);
}

/// How often the ring is emptied.
const PERIOD: Duration = Duration::from_millis(2);
/// Longest that cycles wait for their batch to fill.
const BATCH_AGE: Duration = Duration::from_millis(10);
/// Waking sleepers may take this part of the thread's time: with very many of them they are woken less often.
const RING_SHARE: u32 = 20;

/// Publishes until the loop has ended and its ring is empty. `port` is `None` where nothing is to be published: then the ring is
/// only emptied. `taps` are dropped at the end, when they have seen every cycle.
pub(crate) fn publish(
    mut cycles: Consumer<HeldCycle>,
    mut port: Option<CyclePublisher>,
    mut taps: Vec<Box<dyn Tap>>,
    shared: &Shared,
) {
    let mut next_ring = Instant::now();
    let mut next_flush = Instant::now() + BATCH_AGE;
    loop {
        // Read before the ring, so that the last cycles are not left behind.
        let ended = shared.ended.load(Ordering::Acquire);
        let mut news = false;
        while cycles
            .take(|cycle| {
                for tap in &mut taps {
                    tap.cycle(&cycle.header, &cycle.channels);
                }
                if let Some(port) = &mut port {
                    port.push(cycle.header, &cycle.channels);
                }
            })
            .is_some()
        {
            news = true;
        }
        let now = Instant::now();
        if let Some(port) = &mut port {
            if now >= next_flush || ended {
                port.flush();
                shared.unsent.store(port.unsent(), Ordering::Relaxed);
                next_flush = now + BATCH_AGE;
            }
            if news || ended {
                port.show();
            }
            if news && now >= next_ring {
                port.ring();
                next_ring = now + now.elapsed() * RING_SHARE;
            }
        }
        if ended || sinew_threads::is_struck() {
            return;
        }
        std::thread::sleep(PERIOD);
    }
}
