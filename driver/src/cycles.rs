//! The loop itself: one thread, one cycle a period, nothing in it that could make it wait.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use sinew_ipc::{DriverState, HeldCycle, LoopStats, Snapshot};
use sinew_ring::{Consumer, Producer};
use sinew_sensing::Sample;

use crate::allocations;
use crate::backend::{Backend, BackendError};
use crate::engine::{Beat, Engine, Event, Occurrence, Order};
use crate::realtime;
use crate::report::Ending;
use crate::shutdown_notice::caught;

/// Most orders taken in one cycle: a flood of commands is spread over cycles instead of making one late.
const ORDERS_A_CYCLE: usize = 8;

/// Where the loop leaves what others are to see. Called in the loop: no allocation, no lock, no system call.
pub trait Outlet: Send {
    /// The latest state, once a cycle.
    fn latest(&mut self, snapshot: &Snapshot);
    /// The loop's own figures, some times a second.
    fn stats(&mut self, stats: &LoopStats);
}

/// An outlet that nobody sees: for benchmarks and for simulations nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoOutlet;

impl Outlet for NoOutlet {
    fn latest(&mut self, _: &Snapshot) {}
    fn stats(&mut self, _: &LoopStats) {}
}

/// What ordinary threads share with the loop, apart from the rings.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// Set by whoever wants the loop to end.
    pub stop: AtomicBool,
    /// Set, before `stop`, when a helper's thread has panicked.
    pub panicked: AtomicBool,
    /// Set by the loop when it has ended and outputs are zero.
    pub ended: AtomicBool,
    /// Events that did not fit into their ring.
    pub events_lost: AtomicU64,
    /// Cycles the publisher could not send.
    pub unsent: AtomicU64,
    /// Requests refused, by the desk or the loop.
    pub refusals: AtomicU64,
    /// Cycles so far, and periods missed: written by the loop alone.
    pub cycles: AtomicU64,
    pub missed: AtomicU64,
}

/// When cycles happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// One period of time a period.
    RealTime,
    /// As fast as possible, by a simulated clock.
    AsFastAsPossible,
}

/// Everything the loop's thread owns.
pub(crate) struct Cycles<B, O> {
    pub backend: B,
    pub engine: Engine,
    pub outlet: O,
    pub orders: Consumer<Order>,
    pub events: Producer<Event>,
    /// Every cycle, for the publisher.
    pub published: Producer<HeldCycle>,
    pub period_ns: u64,
    pub pace: Pace,
    /// Cycles (missed ones included) after which to end; `u64::MAX` = never.
    pub periods: u64,
    /// What was granted, in the form of the published figures.
    pub stats: LoopStats,
}

/// What is left of a loop that has ended.
#[derive(Debug)]
pub(crate) struct Remains {
    pub ending: Ending,
    pub stats: LoopStats,
    pub last: Snapshot,
    pub missed_by_wakeup: u64,
    pub missed_by_cycle: u64,
    pub start_ns: u64,
    pub last_error: Option<BackendError>,
}

impl Remains {
    /// Of a loop that never ran.
    pub fn nothing() -> Remains {
        Remains {
            ending: Ending::Panicked,
            stats: LoopStats::new(),
            last: Snapshot::new(0),
            missed_by_wakeup: 0,
            missed_by_cycle: 0,
            start_ns: 0,
            last_error: None,
        }
    }
}

/// Puts outputs to zero when it goes, on whichever way.
struct Stops<'a, B: Backend>(&'a mut B);

impl<B: Backend> Drop for Stops<'_, B> {
    fn drop(&mut self) {
        self.0.stop();
    }
}

impl<B: Backend, O: Outlet> Cycles<B, O> {
    /// Runs until told to end, its time is over or its code panics; outputs are zero afterwards, whatever happened.
    pub fn run(mut self, shared: &Shared) -> Remains {
        let last = Snapshot::new(self.engine.channels().len());
        let mut remains = Remains { stats: self.stats, last, start_ns: realtime::now_ns(), ..Remains::nothing() };
        let result = caught(|| self.cycles(shared, &mut remains));
        // Once more, should it have come from before the guard in there was set up.
        self.backend.stop();
        if let Ok(ending) = result
            && !shared.panicked.load(Ordering::Acquire)
        {
            remains.ending = ending;
        }
        remains.last.state = DriverState::Stopped.code();
        for channel in &mut remains.last.channel {
            channel.duty = 0.0;
        }
        self.outlet.latest(&remains.last);
        self.outlet.stats(&remains.stats);
        shared.ended.store(true, Ordering::Release);
        if let Err(words) = result {
            tracing::error!("the loop panicked; outputs are zero: {words}");
        }
        remains
    }

    fn cycles(&mut self, shared: &Shared, remains: &mut Remains) -> Ending {
        let Cycles { backend, engine, outlet, orders, events, published, .. } = self;
        let (period_ns, pace) = (self.period_ns, self.pace);
        let channels = engine.channels().len();
        let mut duty = vec![0.0; channels];
        let mut samples = vec![Sample::NONE; channels];
        let Remains { stats, last, missed_by_wakeup, missed_by_cycle, last_error, .. } = remains;
        let publish_stats = (250_000_000 / period_ns).max(1);
        let backend = Stops(backend);

        let start_ns = realtime::now_ns();
        remains.start_ns = start_ns;
        // The grid all cycles lie on; one period ahead, so that the first one is on time.
        let mut due_ns = start_ns + period_ns;
        let mut woke_before_ns = None;
        let mut missed_since = 0;
        let mut held_back = false;
        let mut elapsed = 0u64;
        let mut awake = realtime::Wakefulness::default();
        let allocations_before = allocations::calls_of_this_thread();

        let ending = loop {
            // Tick.
            let now_ns = match pace {
                Pace::RealTime => {
                    realtime::sleep_until_ns(due_ns);
                    let woke_ns = realtime::now_ns();
                    let late_ns = woke_ns.saturating_sub(due_ns);
                    stats.lateness.record(late_ns);
                    if let Some(before_ns) = woke_before_ns.replace(woke_ns) {
                        stats.period.record(woke_ns - before_ns);
                    }
                    // Slept through whole periods: go on at the present point of the grid.
                    let gone = late_ns / period_ns;
                    due_ns += gone * period_ns;
                    *missed_by_wakeup += gone;
                    missed_since += gone;
                    woke_ns
                }
                Pace::AsFastAsPossible => due_ns,
            };
            let busy_from_ns = if pace == Pace::RealTime { now_ns } else { realtime::now_ns() };
            if shared.stop.load(Ordering::Relaxed) {
                break Ending::Stopped;
            }
            // A late exchange: what it asked for cannot have been measured by now. Only once, so that no backend stops the loop.
            held_back = pace == Pace::RealTime && !held_back && !backend.0.is_due();
            if held_back {
                due_ns += period_ns;
                *missed_by_wakeup += 1;
                missed_since += 1;
                continue;
            }
            elapsed += 1 + missed_since;

            // A machine that wakes up must not go on where it fell asleep: the first thing it puts out is nothing.
            if pace == Pace::RealTime && awake.slept(now_ns, realtime::boottime_ns()) {
                engine.was_suspended();
                duty.fill(0.0);
            }

            // Exchange.
            if missed_since > 0 {
                backend.0.missed(missed_since);
                stats.missed += missed_since;
            }
            // What the backend leaves unwritten is not measured, and must not pass for the sample of the period before.
            samples.fill(Sample::NONE);
            let exchanged = backend.0.exchange(&duty, &mut samples);
            if let Err(error) = exchanged {
                *last_error = Some(error);
            }

            // Sense, supervise, control.
            let mut tell = |event: Event| {
                if !events.push(event) {
                    shared.events_lost.fetch_add(1, Ordering::Relaxed);
                }
            };
            for _ in 0..ORDERS_A_CYCLE {
                // A second one for the same channel waits for the next cycle: a recording has room for one.
                if orders.peek(|order| engine.has_order(order.channel)) == Some(true) {
                    break;
                }
                let Some(order) = orders.pop() else { break };
                stats.commands += 1;
                if let Some(answer) = engine.take(&order, now_ns) {
                    let what = Occurrence::Answered { ticket: order.ticket, answer };
                    tell(Event { at_ns: now_ns, channel: order.channel as u32, what });
                }
            }
            engine.cycle(Beat { now_ns, missed: missed_since }, exchanged, &samples, &mut duty, tell);
            if engine.must_cut() {
                backend.0.cut();
            }

            // Publish.
            stats.cycles += 1;
            last.cycle = stats.cycles;
            last.monotonic_ns = now_ns;
            last.missed = stats.missed;
            engine.describe(now_ns, DriverState::Running, last);
            outlet.latest(last);
            loop {
                if published.put(|cycle| cycle.copy_from(last.header(), last.channels())) {
                    break;
                }
                if pace == Pace::RealTime || shared.stop.load(Ordering::Relaxed) {
                    stats.ring_drops += 1;
                    break;
                }
                // Nobody waits for us on a simulated clock: rather wait for the publisher than lose a cycle.
                std::thread::yield_now();
            }
            stats.allocations = allocations::calls_of_this_thread() - allocations_before;
            shared.cycles.store(stats.cycles, Ordering::Relaxed);
            shared.missed.store(stats.missed, Ordering::Relaxed);
            if stats.cycles % publish_stats == 1 % publish_stats {
                stats.refusals = shared.refusals.load(Ordering::Relaxed);
                outlet.stats(stats);
            }

            // Until the next point of the grid that is still ahead.
            let done_ns = realtime::now_ns();
            stats.cycle_time.record(done_ns - busy_from_ns);
            due_ns += period_ns;
            missed_since = 0;
            if pace == Pace::RealTime && done_ns >= due_ns {
                stats.overruns += u64::from(done_ns - busy_from_ns >= period_ns);
                let gone = (done_ns - due_ns) / period_ns + 1;
                due_ns += gone * period_ns;
                // Woken late and then busy past the end of the period: it is the wake-up that cost it.
                let lost_by =
                    if done_ns - busy_from_ns >= period_ns { &mut *missed_by_cycle } else { &mut *missed_by_wakeup };
                *lost_by += gone;
                missed_since = gone;
            }
            if elapsed >= self.periods {
                break Ending::Duration;
            }
        };
        // Zero first, then everything else.
        drop(backend);
        ending
    }
}
