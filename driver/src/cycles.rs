//! The real-time loop: one thread, one cycle a period, nothing blocking in it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use sinew_ipc::{ChannelState, DriverState, HeldCycle, LoopStats, Snapshot};
use sinew_ring::Producer;
use sinew_sensing::Sample;

use crate::claims::Shown;
use crate::emergency_stop::SupplySwitch;
use crate::engine::Engine;
use crate::grid::{Grid, Missed, Pace};
use crate::inbox::Inbox;
use crate::memory::Memory;
use crate::orders::{Beat, Event, Told};
use crate::report::Ending;
use crate::suspension::Wakefulness;
use sinew_backend::allocations;
use sinew_backend::clock;
use sinew_backend::{Backend, BackendError, Zero};
use sinew_threads::{Thread, caught};

/// Where the loop leaves what others are to see. Called in the loop: no allocation, no lock, no system call.
pub trait Outlet: Send {
    /// The latest state, once a cycle.
    fn latest(&mut self, snapshot: &Snapshot);
    /// The loop's own figures, some times a second.
    fn stats(&mut self, stats: &LoopStats);
}

/// An outlet without readers: for benchmarks and unobserved simulations.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoOutlet;

impl Outlet for NoOutlet {
    fn latest(&mut self, _: &Snapshot) {}
    fn stats(&mut self, _: &LoopStats) {}
}

/// What ordinary threads share with the loop, apart from the rings.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// Set to end the loop.
    pub stop: AtomicBool,
    /// Set when the emergency stop is reset at the terminal; the loop takes it.
    pub reset_stop: AtomicBool,
    /// Set, before `stop`, when a thread has died without which there is to be no driver.
    pub failed: AtomicBool,
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
    /// Who has claimed which channel, to be published.
    pub claims: Shown,
}

impl Shared {
    /// Ends the loop because of the death of another thread. Takes no lock and waits for nothing.
    pub fn fail(&self) {
        self.failed.store(true, Ordering::Release);
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Everything the loop's thread owns.
pub(crate) struct Cycles<B, O> {
    pub backend: B,
    pub engine: Engine,
    pub outlet: O,
    /// What outlives it.
    pub memory: Memory,
    pub orders: Inbox,
    pub events: Producer<Told>,
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
    pub missed: Missed,
    pub start_ns: u64,
    pub last_error: Option<BackendError>,
    /// Whether all outputs have confirmed zero at the end.
    pub zero: Zero,
}

impl Remains {
    /// Of a loop that never ran.
    pub fn nothing() -> Remains {
        Remains {
            ending: Ending::Panicked,
            stats: LoopStats::new(),
            last: Snapshot::new(0),
            missed: Missed::default(),
            start_ns: 0,
            last_error: None,
            zero: Zero::Confirmed,
        }
    }
}

/// Puts outputs to zero when it goes, on whichever way.
struct Stops<'a, B: Backend>(&'a mut B);

impl<B: Backend> Drop for Stops<'_, B> {
    fn drop(&mut self) {
        // Said by the call that follows.
        let _ = self.0.stop();
    }
}

impl<B: Backend, O: Outlet> Cycles<B, O> {
    /// Runs until stopped, its time is over or its code panics; outputs are zero afterwards, whatever happened.
    pub fn run(mut self, shared: &Shared) -> Remains {
        let last = Snapshot::new(self.engine.channels().len());
        let mut remains = Remains { stats: self.stats, last, start_ns: clock::now_ns(), ..Remains::nothing() };
        let result = caught(|| self.cycles(shared, &mut remains));
        if !matches!(result, Ok(Ending::Duration | Ending::Stopped)) {
            Thread::Loop.has_died();
        }
        // Again: the panic may have come from before the guard in there was set up, and only the last answer counts.
        remains.zero = self.backend.stop();
        self.memory.end(&self.engine, &self.backend, remains.zero);
        if let Ok(ending) = result
            && !shared.failed.load(Ordering::Acquire)
        {
            remains.ending = ending;
        }
        remains.last.state = DriverState::Stopped.code();
        remains.stats.dead = sinew_threads::dead();
        if self.pace == Pace::RealTime {
            // When the outputs were zero.
            remains.last.monotonic_ns = clock::now_ns();
        }
        for (index, channel) in remains.last.channel.iter_mut().enumerate() {
            channel.duty = 0.0;
            let unconfirmed = remains.zero == Zero::Unconfirmed && !self.backend.is_confirmed(index);
            channel.flags |= if unconfirmed { ChannelState::FLAG_UNCONFIRMED } else { 0 };
        }
        self.outlet.latest(&remains.last);
        self.outlet.stats(&remains.stats);
        shared.ended.store(true, Ordering::Release);
        let died = match result {
            Ok(Ending::Panicked) => Some("it ended by itself".into()),
            Ok(_) => None,
            Err(words) => Some(words),
        };
        if let Some(words) = died {
            let outputs = if remains.zero == Zero::Confirmed { "are zero" } else { "may be on" };
            tracing::error!("the loop has died; outputs {outputs}: {words}");
        }
        remains
    }

    fn cycles(&mut self, shared: &Shared, remains: &mut Remains) -> Ending {
        let Cycles { backend, engine, outlet, memory, orders, events, published, .. } = self;
        let channels = engine.channels().len();
        let mut duty = vec![0.0; channels];
        let mut samples = vec![Sample::NONE; channels];
        let Remains { stats, last, missed, last_error, .. } = remains;
        let publish_stats = (250_000_000 / self.period_ns).max(1);
        let backend = Stops(backend);

        remains.start_ns = clock::now_ns();
        let mut grid = Grid::new(remains.start_ns, self.period_ns, self.pace);
        let is_real_time = self.pace == Pace::RealTime;
        let mut held_back = false;
        let mut elapsed = 0u64;
        let mut awake = Wakefulness::default();
        let mut supply = SupplySwitch::default();
        supply.begin(backend.0);
        let allocations_before = allocations::calls_of_this_thread();

        let ending = loop {
            // Tick.
            if sinew_threads::is_struck() {
                break Ending::Panicked;
            }
            let tick = grid.wait(stats, missed);
            if shared.stop.load(Ordering::Relaxed) {
                // No further cycle will count the periods skipped since the last one.
                stats.missed += grid.missed_since();
                last.missed = stats.missed;
                shared.missed.store(stats.missed, Ordering::Relaxed);
                break Ending::Stopped;
            }
            // A late exchange: its duty cannot have been measured yet. Skipped only once, so that no backend stops the loop.
            held_back = is_real_time && !held_back && !backend.0.is_due();
            if held_back {
                grid.skip(missed);
                continue;
            }
            elapsed += 1 + grid.missed_since();

            if grid.missed_since() > 0 {
                engine.come_late(grid.missed_since(), &mut duty);
            }
            // A machine that resumes from suspension must not continue: its first output is zero.
            if is_real_time && let Some(slept_s) = awake.slept_s(tick.now_ns, clock::boottime_ns()) {
                engine.was_suspended(slept_s);
                duty.fill(0.0);
            }

            // Exchange.
            if grid.missed_since() > 0 {
                backend.0.missed(grid.missed_since());
                stats.missed += grid.missed_since();
            }
            // A sample the backend does not write counts as not measured, not as the sample of the period before.
            samples.fill(Sample::NONE);
            let exchanged = backend.0.exchange(&duty, &mut samples);
            if let Err(error) = exchanged {
                *last_error = Some(error);
            }

            engine.note_outputs(backend.0);
            let was_reset =
                shared.reset_stop.load(Ordering::Relaxed) && shared.reset_stop.swap(false, Ordering::Relaxed);
            supply.look(backend.0, engine, was_reset);

            // Sense, supervise, control.
            let cycle = stats.cycles + 1;
            let mut tell = |event: Event| {
                if !events.push(Told { cycle, event }) {
                    shared.events_lost.fetch_add(1, Ordering::Relaxed);
                }
            };
            stats.commands += orders.hand_over(engine, tick.now_ns, &mut tell);
            engine.clear(backend.0);
            let beat = Beat { now_ns: tick.now_ns, missed: grid.missed_since() };
            engine.cycle(beat, exchanged, &samples, &mut duty, tell);
            supply.switch(engine, backend.0);

            // Publish.
            stats.cycles += 1;
            (last.cycle, last.monotonic_ns, last.missed) = (stats.cycles, tick.now_ns, stats.missed);
            memory.keep(engine, backend.0);
            engine.describe(tick.now_ns, DriverState::Running, last);
            shared.claims.describe(&mut last.channel[..last.channels as usize]);
            outlet.latest(last);
            if !hand_over(published, last, is_real_time, shared) {
                stats.ring_drops += 1;
            }
            stats.allocations = allocations::calls_of_this_thread() - allocations_before;
            shared.cycles.store(stats.cycles, Ordering::Relaxed);
            shared.missed.store(stats.missed, Ordering::Relaxed);
            if stats.cycles % publish_stats == 1 % publish_stats {
                stats.refusals = shared.refusals.load(Ordering::Relaxed);
                stats.dead = sinew_threads::dead();
                outlet.stats(stats);
            }

            grid.advance(&tick, stats, missed);
            if elapsed >= self.periods {
                break Ending::Duration;
            }
        };
        // Zero first, then everything else.
        drop(backend);
        ending
    }
}

/// Puts a cycle into the publisher's ring; `false` where there is no room for it and it is lost.
#[inline]
fn hand_over(published: &mut Producer<HeldCycle>, last: &Snapshot, is_real_time: bool, shared: &Shared) -> bool {
    loop {
        if published.put(|cycle| cycle.copy_from(last.header(), last.channels())) {
            return true;
        }
        if is_real_time || shared.stop.load(Ordering::Relaxed) {
            return false;
        }
        // A simulated clock has no deadline: wait for the publisher instead of losing a cycle.
        std::thread::yield_now();
    }
}
