//! The thread that watches the driver: every cycle, every fault, and the loop's figures once a second, encoded as in recordings.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::{ChannelState, Client, Clocks, Cycle, CycleStream, Error};
use sinew_recorder::{FaultEvents, layout, loop_figures};
use sinew_recording::session::{Event, GAP, Head};

use super::feed::{Feed, Item};
use crate::finder::{Finder, has_ended};

/// Between two attempts to find a driver again.
const RETRY: Duration = Duration::from_millis(300);
/// The longest wait for a cycle: somebody may want it to end.
const WAIT: Duration = Duration::from_millis(20);
/// Between two looks at the loop's figures.
const LOOK: Duration = Duration::from_secs(1);

/// Watches until the bridge is to stop; of the cycles at most `rate_hz` a second, where that is given.
pub fn watch(feed: &Feed, mut finder: Finder, rate_hz: Option<f64>) {
    // as in a recording: the driver's clock, which never jumps, and one comparison of it with the time of day
    let boot_unix_ns = Clocks::now().system(0).ns.max(0) as u64;
    while !is_over(feed) {
        if let Some(client) = finder.find() {
            let followed = client.stream().and_then(|stream| follow(feed, &client, stream, boot_unix_ns, rate_hz));
            if let Err(error) = followed {
                tracing::info!("{}", error.message());
            }
            feed.gone();
        }
        let next = Instant::now() + RETRY;
        while !is_over(feed) && Instant::now() < next {
            std::thread::sleep(WAIT);
        }
    }
}

fn is_over(feed: &Feed) -> bool {
    feed.stop.load(Ordering::Relaxed) || sinew_threads::is_struck()
}

/// What is sent of one driver.
struct Sender<'a> {
    feed: &'a Feed,
    boot_unix_ns: u64,
    /// Numbers of the topics.
    cycles: u32,
    events: u32,
    figures: u32,
    names: Vec<String>,
    faults: FaultEvents,
    /// Time between two cycles that are sent, ns.
    period_ns: u64,
    /// From when on the next one is sent.
    due_ns: u64,
}

/// Follows one driver to its end.
fn follow(
    feed: &Feed,
    client: &Client,
    mut stream: CycleStream,
    boot_unix_ns: u64,
    rate_hz: Option<f64>,
) -> Result<(), Error> {
    let names: Vec<String> = client.channels().iter().map(|channel| channel.name.to_string()).collect();
    let Ok(layout) = layout(names.clone()) else {
        // a driver has no two channels of one name
        return Ok(());
    };
    let [cycles, events, figures] = feed.meet(&layout);
    let faults = FaultEvents::new(names.len());
    let period_ns = rate_hz.map_or(0, |rate_hz| (1e9 / rate_hz) as u64);
    let mut sender = Sender { feed, boot_unix_ns, cycles, events, figures, names, faults, period_ns, due_ns: 0 };
    let mut looked: Option<Instant> = None;
    while !is_over(feed) {
        let mut waited = stream.next_within(WAIT)?.map(|cycle| sender.cycle(&cycle)).is_some();
        while waited {
            waited = stream.next()?.map(|cycle| sender.cycle(&cycle)).is_some();
        }
        if looked.is_none_or(|at| at.elapsed() >= LOOK) {
            looked = Some(Instant::now());
            sender.look(client);
        }
        if has_ended(client) {
            return Ok(());
        }
    }
    Ok(())
}

impl Sender<'_> {
    fn put(&self, channel: u32, monotonic_ns: u64, message: Vec<u8>) {
        let unix_ns = self.boot_unix_ns.wrapping_add(monotonic_ns);
        self.feed.put(Item { channel, unix_ns, message: message.into() });
    }

    fn cycle(&mut self, cycle: &Cycle<'_>) {
        let head =
            Head { cycle: cycle.header.cycle, monotonic_ns: cycle.header.monotonic_ns, missed: cycle.header.missed };
        let bytes = ChannelState::bytes_of(cycle.channels);
        let events: Vec<Event> = self.faults.of(&head, bytes, &self.names).collect();
        if !self.feed.is_heard() {
            return;
        }
        if cycle.lost > 0 {
            self.event(&Event {
                cycle: head.cycle,
                monotonic_ns: head.monotonic_ns,
                kind: GAP.into(),
                from_cycle: head.cycle.saturating_sub(cycle.lost),
                to_cycle: head.cycle.saturating_sub(1),
                text: format!("{} cycles lost", cycle.lost),
                ..Event::default()
            });
        }
        events.iter().for_each(|event| self.event(event));
        if head.monotonic_ns >= self.due_ns {
            // on a grid, so that the rate on average is the one asked for
            let next_ns = self.due_ns.saturating_add(self.period_ns);
            self.due_ns =
                if next_ns > head.monotonic_ns { next_ns } else { head.monotonic_ns.saturating_add(self.period_ns) };
            let mut message = Vec::new();
            head.encode(bytes, &mut message);
            self.put(self.cycles, head.monotonic_ns, message);
        }
    }

    fn event(&self, event: &Event) {
        self.put(self.events, event.monotonic_ns, event.encode());
    }

    fn look(&self, client: &Client) {
        if self.feed.is_heard() {
            let header = client.latest().header();
            let figures = loop_figures(&client.loop_stats(), header.cycle, header.monotonic_ns);
            self.put(self.figures, header.monotonic_ns, figures.encode());
        }
    }
}
