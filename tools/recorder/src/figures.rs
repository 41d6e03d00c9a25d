//! The loop's statistics in a recording.

use sinew_ipc::{Histogram, LoopStats};
use sinew_recording::session::{Durations, LoopFigures};

/// How the loop did up to this cycle.
pub fn loop_figures(stats: &LoopStats, cycle: u64, monotonic_ns: u64) -> LoopFigures {
    LoopFigures {
        cycle,
        monotonic_ns,
        cycles: stats.cycles,
        missed: stats.missed,
        overruns: stats.overruns,
        ring_drops: stats.ring_drops,
        allocations: stats.allocations,
        commands: stats.commands,
        refusals: stats.refusals,
        realtime: stats.realtime,
        priority: stats.priority,
        lateness: durations(&stats.lateness),
        cycle_time: durations(&stats.cycle_time),
        period: durations(&stats.period),
    }
}

fn durations(histogram: &Histogram) -> Durations {
    let mut durations = Durations { max_ns: histogram.max(), ..Durations::default() };
    for (_, last_ns, count) in histogram.filled() {
        durations.up_to_ns.push(last_ns);
        durations.count.push(count);
    }
    if histogram.overflow() > 0 {
        durations.up_to_ns.push(histogram.max());
        durations.count.push(histogram.overflow());
    }
    durations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_duration_is_counted_once() {
        let mut stats = LoopStats::new();
        for ns in [0, 5, 5, 70_000, 3_000_000_000] {
            stats.lateness.record(ns);
        }
        let found = loop_figures(&stats, 3, 9).lateness;
        assert_eq!(found.count.iter().sum::<u64>(), 5);
        assert_eq!((found.max_ns, found.up_to_ns.last()), (3_000_000_000, Some(&3_000_000_000)));
        assert!(found.up_to_ns.is_sorted());
    }
}
