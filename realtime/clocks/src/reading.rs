//! Reads the clocks of this machine beside each other.
#![allow(unsafe_code)]

use crate::change::{Change, Reading};
use crate::mapped::Mapped;

/// So often each clock is read between two readings of CLOCK_MONOTONIC; the closest two count. What interrupts one (a scheduler, an
/// interrupt) hardly interrupts all.
const TRIES: usize = 12;

/// CLOCK_MONOTONIC now, ns: the clock of every stamp of a driver.
pub fn monotonic_ns() -> u64 {
    now_ns(libc::CLOCK_MONOTONIC) as u64
}

fn now_ns(clock: libc::clockid_t) -> i64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is a valid place for a timespec; the call writes nothing else, and leaves it alone where there is no such clock.
    unsafe { libc::clock_gettime(clock, &mut now) };
    // two's complement: also a system clock before 1970 comes out right
    (now.tv_sec as u64).wrapping_mul(1_000_000_000).wrapping_add(now.tv_nsec as u64) as i64
}

/// Another clock's time at an instant of CLOCK_MONOTONIC.
struct Beside {
    monotonic_ns: u64,
    other_ns: i64,
    /// Half of the bracket.
    error_ns: u64,
}

/// The closest of some brackets, two readings of CLOCK_MONOTONIC with one of the other between them.
fn beside(clock: libc::clockid_t) -> Beside {
    let mut best: Option<(u64, i64, u64)> = None;
    for _ in 0..TRIES {
        let (before, other, after) = (monotonic_ns(), now_ns(clock), monotonic_ns());
        if best.is_none_or(|(from, _, to)| after - before < to - from) {
            best = Some((before, other, after));
        }
    }
    let (before, other_ns, after) = best.unwrap_or_default();
    let error_ns = (after - before).div_ceil(2) + 1;
    Beside { monotonic_ns: before + (after - before) / 2, other_ns, error_ns }
}

/// What the synchronisation says of the system's clock: what it is off from UTC by at the most, ns; `None` where it is not synchronised.
fn utc_error_ns() -> Option<u64> {
    // SAFETY: timex is plain data for which all zeros are valid, and `modes` 0 asks without setting anything.
    let mut state: libc::timex = unsafe { std::mem::zeroed() };
    // SAFETY: `state` is a valid place for a timex; the call writes nothing else.
    let code = unsafe { libc::adjtimex(&mut state) };
    let is_synchronised = (0..libc::TIME_ERROR).contains(&code) && state.status & libc::STA_UNSYNC == 0;
    is_synchronised.then_some((state.maxerror as u64).saturating_mul(1000))
}

impl Reading {
    /// The clocks of this machine now. Takes some µs; no more than a few tens of reads of shared memory (vDSO) and one system call.
    pub fn now() -> Reading {
        let system = beside(libc::CLOCK_REALTIME);
        let tai = beside(libc::CLOCK_TAI);
        let boottime = beside(libc::CLOCK_BOOTTIME);
        let raw = beside(libc::CLOCK_MONOTONIC_RAW);
        let at = system.monotonic_ns;
        let moved = |beside: &Beside| beside.other_ns + (at as i64 - beside.monotonic_ns as i64);
        // TAI is UTC and whole seconds: what else the difference has is that of two readings
        let tai_offset_s = (moved(&tai) - system.other_ns + 500_000_000).div_euclid(1_000_000_000);
        Reading {
            monotonic_ns: at,
            system_ns: system.other_ns,
            system_error_ns: system.error_ns,
            // 0 where nobody has told the system; it was 10 s when UTC began
            tai_offset_s: i32::try_from(tai_offset_s).ok().filter(|seconds| (10..100).contains(seconds)),
            boottime_ns: moved(&boottime).max(0) as u64,
            boottime_error_ns: boottime.error_ns,
            raw_ns: moved(&raw).max(0) as u64,
            // it was moved by some µs at another rate: no more than 1000 ppm of that
            raw_error_ns: raw.error_ns + at.abs_diff(raw.monotonic_ns).div_ceil(1000),
            utc_error_ns: utc_error_ns(),
        }
    }
}

/// The clocks of this machine for the stamps of a driver on it: compared once, and anew whenever that is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Clocks {
    reading: Reading,
}

impl Clocks {
    /// Compares the clocks now.
    pub fn now() -> Clocks {
        Clocks { reading: Reading::now() }
    }

    /// The comparison.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Compares anew, and says what became of the clocks since the last time.
    pub fn refresh(&mut self) -> Change {
        let before = std::mem::replace(&mut self.reading, Reading::now());
        before.change_to(&self.reading)
    }

    /// System time of a driver's stamp, ns since 1970 (UTC). True while nobody sets the system's clock: see [`Clocks::refresh`].
    pub fn system(&self, monotonic_ns: u64) -> Mapped<i64> {
        self.reading.system(monotonic_ns)
    }

    /// TAI of a driver's stamp, ns since 1970; `None` where the system does not know it.
    pub fn tai(&self, monotonic_ns: u64) -> Option<Mapped<i64>> {
        self.reading.tai(monotonic_ns)
    }

    /// Boot time of a driver's stamp, ns.
    pub fn boottime(&self, monotonic_ns: u64) -> Mapped<u64> {
        self.reading.boottime(monotonic_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{ClockMap, ClockRules};

    #[test]
    fn the_clocks_of_this_machine_agree_with_themselves() {
        let mut clocks = Clocks::now();
        let first = *clocks.reading();
        // by the standard library, independently: between two of its readings lies what is mapped
        for _ in 0..200 {
            let before = std::time::SystemTime::now();
            let stamp = monotonic_ns();
            let after = std::time::SystemTime::now();
            let unix = |time: std::time::SystemTime| {
                time.duration_since(std::time::UNIX_EPOCH).unwrap_or_default().as_nanos() as i64
            };
            let at = clocks.system(stamp);
            let error = at.error_ns as i64;
            assert!(unix(before) - error <= at.ns && at.ns <= unix(after) + error, "{at:?}");
        }
        std::thread::sleep(std::time::Duration::from_millis(300));
        let change = clocks.refresh();
        assert!(change.passed_ns >= 300_000_000, "{change:?}");
        assert_eq!(change.suspended_ns, 0, "{change:?}");
        // 500 ppm is what Linux corrects by at the most without a step (adjtimex), chrony a little more
        assert!(change.slew_ppm.abs() < 1000.0 + change.slew_error_ppm, "{change:?}");
        assert!(first.system_error_ns < 100_000 && first.boottime_ns >= first.monotonic_ns - 1000, "{first:?}");
        if let Some(tai) = first.tai_offset_s {
            assert!((10..100).contains(&tai), "{tai}");
        }
    }

    /// A clock of this machine that runs at another rate than CLOCK_MONOTONIC wherever that is corrected.
    fn counter_ns() -> i64 {
        now_ns(libc::CLOCK_MONOTONIC_RAW)
    }

    /// What it shows, independently: the closest of a thousand brackets.
    fn looked_at() -> (u64, i64, u64) {
        (0..1000)
            .map(|_| (monotonic_ns(), counter_ns(), monotonic_ns()))
            .min_by_key(|(before, _, after)| after - before)
            .unwrap_or_default()
    }

    #[test]
    fn a_real_clock_is_learnt_by_asking_it_and_by_stamps_of_another_thread() {
        let (mut asked, mut received) = (ClockMap::new(ClockRules::default()), ClockMap::new(ClockRules::default()));
        let (sender, stamps) = std::sync::mpsc::channel();
        let device = std::thread::spawn(move || {
            for _ in 0..600 {
                let _ = sender.send(counter_ns());
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        });
        for (i, stamp) in stamps.into_iter().enumerate() {
            received.late(monotonic_ns(), stamp);
            if i % 20 == 0 {
                let before = monotonic_ns();
                let other = counter_ns();
                asked.bracket(before, other, monotonic_ns());
            }
        }
        device.join().unwrap();
        let (before, other, after) = looked_at();
        for (map, least_delay_ns) in [(&asked, 0), (&received, 1_000_000)] {
            let at = map.driver_at(other).unwrap();
            // how long a thread takes to wake at the least nobody knows here: the answer is late by that
            assert!(
                at.ns + at.error_ns >= before && at.ns <= after + at.error_ns + least_delay_ns,
                "{before} {at:?} {after}"
            );
            assert!(at.error_ns < 200_000_000, "{at:?}");
            let (ppm, error_ppm) = map.rate_ppm().unwrap();
            assert!(ppm.abs() <= 500.0 + error_ppm, "{ppm} ± {error_ppm}");
        }
    }
}
