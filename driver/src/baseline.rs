//! A bare timer loop: the lateness this machine causes in an empty loop, the baseline for the lateness of the real
//! loop.

use sinew_backend::clock;
use sinew_ipc::Histogram;

use crate::report::{BareLoop, Quantiles};
use sinew_realtime as realtime;
use sinew_realtime::Wish;

/// Sleeps to an absolute grid of `rate_hz` for `seconds` in the calling thread and does nothing else. The caller has made the
/// thread real-time or has not: the figures are of the thread as it is.
pub fn bare_loop(rate_hz: f64, seconds: f64) -> BareLoop {
    let period_ns = (1e9 / rate_hz).round().max(1.0) as u64;
    let mut lateness = Histogram::new();
    let (mut cycles, mut missed) = (0, 0);
    let start_ns = clock::now_ns();
    let end_ns = start_ns + (seconds.max(0.0) * 1e9) as u64;
    let mut next_ns = start_ns + period_ns;
    while next_ns <= end_ns {
        clock::sleep_until_ns(next_ns);
        let late_ns = clock::now_ns().saturating_sub(next_ns);
        lateness.record(late_ns);
        cycles += 1;
        // The grid stays where it is: periods slept through are gone, not made up for.
        let gone = late_ns / period_ns;
        missed += gone;
        next_ns += (gone + 1) * period_ns;
    }
    BareLoop { seconds, rate_hz, cycles, missed, lateness_us: Quantiles::of(&lateness), lateness }
}

/// The same in a thread of its own with all that `wish` asks for: for `sinew bench loop`.
pub fn bare_loop_with(wish: &Wish, rate_hz: f64, seconds: f64) -> BareLoop {
    let (held, mut report) = realtime::prepare_process(wish);
    let figures = std::thread::scope(|scope| {
        let bare = scope.spawn(|| {
            realtime::prepare_thread(wish, &mut report);
            bare_loop(rate_hz, seconds)
        });
        // The loop does not panic; if its thread could not run, its figures are those of no cycle at all.
        bare.join().unwrap_or_else(|_| bare_loop(rate_hz, 0.0))
    });
    drop(held);
    figures
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_period_is_either_a_wakeup_or_missed() {
        let figures = bare_loop(1000.0, 0.1);
        let periods = figures.cycles + figures.missed;
        // The last wake-up may itself overshoot the end by what it is late.
        assert!(periods >= 100, "{figures:?}");
        assert!(figures.cycles >= 1 && figures.lateness_us.max >= figures.lateness_us.p50);
    }
}
