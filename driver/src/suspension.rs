//! Detects a suspended machine: time that CLOCK_BOOTTIME counted and CLOCK_MONOTONIC did not.

/// Notices that the machine was suspended: then CLOCK_BOOTTIME is further ahead of CLOCK_MONOTONIC than before. Nothing else
/// moves the one against the other; a step of the wall clock moves neither.
#[derive(Debug, Default)]
pub(crate) struct Wakefulness {
    ahead_ns: Option<u64>,
}

impl Wakefulness {
    /// Shorter than any suspension, longer than a thread may be kept from reading the second clock without missing
    /// [`crate::supervisor::OVERRUN_S`], which switches off as well.
    const SLEPT_NS: u64 = 250_000_000;

    /// How long the machine was suspended since the last call, s, if it was, by the clocks as read now: the monotonic one before the
    /// other.
    #[inline]
    pub fn slept_s(&mut self, monotonic_ns: u64, boottime_ns: u64) -> Option<f64> {
        let ahead_ns = boottime_ns.saturating_sub(monotonic_ns);
        let least_ns = *self.ahead_ns.get_or_insert(ahead_ns);
        let slept = ahead_ns > least_ns + Self::SLEPT_NS;
        // The delay between the two readings is never negative: the smallest difference is the most accurate.
        if slept || ahead_ns < least_ns {
            self.ahead_ns = Some(ahead_ns);
        }
        slept.then(|| (ahead_ns - least_ns) as f64 * 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use sinew_backend::clock::{boottime_ns, now_ns};

    use super::*;

    #[test]
    fn only_a_suspension_moves_the_one_clock_against_the_other() {
        let mut awake = Wakefulness::default();
        let ahead_ns = 3_600_000_000_000;
        let mut monotonic_ns = 1_000;
        for k in 0..1000 {
            monotonic_ns += 1_000_000;
            // now and then the thread is preempted between the two readings
            let between_ns = if k % 100 == 7 { 40_000_000 } else { 30 };
            assert_eq!(awake.slept_s(monotonic_ns, monotonic_ns + ahead_ns + between_ns), None, "cycle {k}");
        }
        // half a minute suspended
        let ahead_ns = ahead_ns + 30_000_000_000;
        let slept_s = awake.slept_s(monotonic_ns + 1_000_000, monotonic_ns + 1_000_000 + ahead_ns);
        assert!(slept_s.is_some_and(|s| (s - 30.0).abs() < 0.05), "{slept_s:?}");
        assert_eq!(awake.slept_s(monotonic_ns + 2_000_000, monotonic_ns + 2_000_000 + ahead_ns), None, "once");
        let mut this_machine = Wakefulness::default();
        assert_eq!(this_machine.slept_s(now_ns(), boottime_ns()), None);
    }
}
