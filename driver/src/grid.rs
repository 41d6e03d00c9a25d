//! The absolute time grid of the cycles, and the count of missed periods: a late cycle never makes the next one late.

use sinew_backend::clock;
use sinew_ipc::LoopStats;

/// When cycles happen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// One period of time a period.
    RealTime,
    /// By a simulated clock.
    Simulated {
        /// So many of its seconds pass in a second at most, if the machine gets so far; infinite: as fast as possible.
        speed: f64,
    },
}

/// Periods without a cycle, by what they were lost to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Missed {
    /// The loop's thread woke late, or the backend could not have sampled yet.
    pub by_wakeup: u64,
    /// The cycle itself took longer than a period.
    pub by_cycle: u64,
}

/// One point of the grid at which a cycle happens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wakeup {
    /// The cycle's time, ns: when the thread woke, or the simulated clock.
    pub now_ns: u64,
    /// From when on the cycle's own time counts, ns.
    busy_from_ns: u64,
}

/// The grid, from the loop's start on.
#[derive(Debug)]
pub(crate) struct Grid {
    period_ns: u64,
    pace: Pace,
    /// When the loop started, ns.
    start_ns: u64,
    /// The next point of the grid, ns.
    due_ns: u64,
    /// When the thread woke the last time, ns.
    woke_before_ns: Option<u64>,
    /// Periods that passed without a cycle since the last one.
    missed_since: u64,
}

impl Grid {
    /// A grid whose first point is one period after `start_ns`, so that the first cycle is on time.
    pub fn new(start_ns: u64, period_ns: u64, pace: Pace) -> Grid {
        Grid { period_ns, pace, start_ns, due_ns: start_ns + period_ns, woke_before_ns: None, missed_since: 0 }
    }

    /// Periods that passed without a cycle since the last one.
    #[inline]
    pub fn missed_since(&self) -> u64 {
        self.missed_since
    }

    /// Waits for the next point. Whole periods slept through are counted and passed over.
    #[inline]
    pub fn wait(&mut self, stats: &mut LoopStats, missed: &mut Missed) -> Wakeup {
        if let Pace::Simulated { speed } = self.pace {
            let since_start_ns = (self.due_ns - self.start_ns) as f64 / speed;
            if since_start_ns > 0.0 {
                clock::sleep_until_ns(self.start_ns + since_start_ns as u64);
            }
            return Wakeup { now_ns: self.due_ns, busy_from_ns: clock::now_ns() };
        }
        clock::sleep_until_ns(self.due_ns);
        let woke_ns = clock::now_ns();
        let late_ns = woke_ns.saturating_sub(self.due_ns);
        stats.lateness.record(late_ns);
        if let Some(before_ns) = self.woke_before_ns.replace(woke_ns) {
            stats.period.record(woke_ns - before_ns);
        }
        let gone = late_ns / self.period_ns;
        self.due_ns += gone * self.period_ns;
        missed.by_wakeup += gone;
        self.missed_since += gone;
        Wakeup { now_ns: woke_ns, busy_from_ns: woke_ns }
    }

    /// Lets the present point pass without a cycle.
    #[inline]
    pub fn skip(&mut self, missed: &mut Missed) {
        self.due_ns += self.period_ns;
        missed.by_wakeup += 1;
        self.missed_since += 1;
    }

    /// The cycle is done: on to the next point that is still ahead.
    #[inline]
    pub fn advance(&mut self, wakeup: &Wakeup, stats: &mut LoopStats, missed: &mut Missed) {
        let done_ns = clock::now_ns();
        let busy_ns = done_ns - wakeup.busy_from_ns;
        stats.cycle_time.record(busy_ns);
        self.due_ns += self.period_ns;
        self.missed_since = 0;
        if self.pace == Pace::RealTime && done_ns >= self.due_ns {
            let outlasted = busy_ns >= self.period_ns;
            stats.overruns += u64::from(outlasted);
            let gone = (done_ns - self.due_ns) / self.period_ns + 1;
            self.due_ns += gone * self.period_ns;
            // Woken late and then busy past the end of the period: counted as missed by the wake-up.
            *(if outlasted { &mut missed.by_cycle } else { &mut missed.by_wakeup }) += gone;
            self.missed_since = gone;
        }
    }
}
