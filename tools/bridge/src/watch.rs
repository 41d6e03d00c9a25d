//! Watches a driver for whoever looks on: every cycle, every fault, and the loop's figures once a second, encoded as in recordings.

use std::sync::Arc;
use std::time::{Duration, Instant};

use sinew_ipc::{ChannelState, Client, Clocks, Cycle, CycleStream, Error};
use sinew_recorder::{FaultEvents, layout, loop_figures};
use sinew_recording::session::{CYCLES, EVENTS, Event, GAP, Head, LOOP, Layout, LoopFigures};

use crate::finder::{Finder, has_ended};

/// Between two attempts to find a driver again.
const RETRY: Duration = Duration::from_millis(300);
/// The longest wait for a cycle: somebody may want it to end.
const WAIT: Duration = Duration::from_millis(20);
/// Between two looks at the loop's figures.
const LOOK: Duration = Duration::from_secs(1);

/// Those for whom a driver is watched.
pub trait Audience {
    /// Whether it is time to end.
    fn is_over(&self) -> bool;

    /// There is a driver, with these channels.
    fn meet(&mut self, client: &Arc<Client>, layout: &Layout);

    /// It has gone.
    fn gone(&mut self);

    /// Whether anybody listens: else nothing is encoded.
    fn is_heard(&self) -> bool;

    /// A message of one of [`topics`](sinew_recording::session::topics), in CDR, with its time of day, ns since 1970.
    fn put(&mut self, topic: &'static str, unix_ns: u64, message: Vec<u8>);

    /// So many cycles have not come from the driver, whether anybody listens or not.
    fn lost(&mut self, _cycles: u64) {}
}

/// Watches until the audience says that it is over; of the cycles at most `rate_hz` a second, where that is given.
pub fn watch(audience: &mut impl Audience, mut finder: Finder, rate_hz: Option<f64>) {
    // as in a recording: the driver's clock, which never jumps, and one comparison of it with the time of day
    let boot_unix_ns = Clocks::now().system(0).ns.max(0) as u64;
    while !is_over(audience) {
        if let Some(client) = finder.find() {
            let followed = client.stream().and_then(|stream| follow(audience, &client, stream, boot_unix_ns, rate_hz));
            if let Err(error) = followed {
                tracing::info!("{}", error.message());
            }
            audience.gone();
        }
        let next = Instant::now() + RETRY;
        while !is_over(audience) && Instant::now() < next {
            std::thread::sleep(WAIT);
        }
    }
}

/// The latest cycle of a driver, in CDR as on [`CYCLES`].
pub fn latest_cycle(client: &Client) -> Vec<u8> {
    client.with_latest(|state| {
        let head = Head { cycle: state.cycle, monotonic_ns: state.monotonic_ns, missed: state.missed };
        let mut message = Vec::new();
        head.encode(ChannelState::bytes_of(state.channels()), &mut message);
        message
    })
}

/// The figures of a driver's loop as of now, as on [`LOOP`].
pub fn latest_figures(client: &Client) -> LoopFigures {
    let header = client.latest().header();
    loop_figures(&client.loop_stats(), header.cycle, header.monotonic_ns)
}

fn is_over(audience: &impl Audience) -> bool {
    audience.is_over() || sinew_threads::is_struck()
}

/// What is sent of one driver.
struct Sender<'a, A: Audience> {
    audience: &'a mut A,
    boot_unix_ns: u64,
    names: Vec<String>,
    faults: FaultEvents,
    /// Time between two cycles that are sent, ns.
    period_ns: u64,
    /// From when on the next one is sent.
    due_ns: u64,
}

/// Follows one driver to its end.
fn follow<A: Audience>(
    audience: &mut A,
    client: &Arc<Client>,
    mut stream: CycleStream,
    boot_unix_ns: u64,
    rate_hz: Option<f64>,
) -> Result<(), Error> {
    let names: Vec<String> = client.channels().iter().map(|channel| channel.name.to_string()).collect();
    let Ok(layout) = layout(names.clone()) else {
        // a driver has no two channels of one name
        return Ok(());
    };
    audience.meet(client, &layout);
    let faults = FaultEvents::new(names.len());
    let period_ns = rate_hz.map_or(0, |rate_hz| (1e9 / rate_hz) as u64);
    let mut sender = Sender { audience, boot_unix_ns, names, faults, period_ns, due_ns: 0 };
    let mut looked: Option<Instant> = None;
    while !is_over(sender.audience) {
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

impl<A: Audience> Sender<'_, A> {
    fn put(&mut self, topic: &'static str, monotonic_ns: u64, message: Vec<u8>) {
        self.audience.put(topic, self.boot_unix_ns.wrapping_add(monotonic_ns), message);
    }

    fn cycle(&mut self, cycle: &Cycle<'_>) {
        let head =
            Head { cycle: cycle.header.cycle, monotonic_ns: cycle.header.monotonic_ns, missed: cycle.header.missed };
        let bytes = ChannelState::bytes_of(cycle.channels);
        let events: Vec<Event> = self.faults.of(&head, bytes, &self.names).collect();
        if cycle.lost > 0 {
            self.audience.lost(cycle.lost);
        }
        if !self.audience.is_heard() {
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
            self.put(CYCLES, head.monotonic_ns, message);
        }
    }

    fn event(&mut self, event: &Event) {
        self.put(EVENTS, event.monotonic_ns, event.encode());
    }

    fn look(&mut self, client: &Client) {
        if self.audience.is_heard() {
            let figures = latest_figures(client);
            self.put(LOOP, figures.monotonic_ns, figures.encode());
        }
    }
}
