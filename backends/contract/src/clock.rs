//! The clocks of loop and backends: CLOCK_MONOTONIC and CLOCK_BOOTTIME.

/// CLOCK_MONOTONIC now, ns. A read of shared memory (vDSO), no system call.
#[inline]
pub fn now_ns() -> u64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is a valid, writable timespec that outlives the call; CLOCK_MONOTONIC always exists.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut now) };
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// CLOCK_BOOTTIME now, ns: like CLOCK_MONOTONIC, but it goes on while the machine is suspended. Through the vDSO too.
#[inline]
pub fn boottime_ns() -> u64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is a valid, writable timespec that outlives the call; CLOCK_BOOTTIME exists since Linux 2.6.39.
    unsafe { libc::clock_gettime(libc::CLOCK_BOOTTIME, &mut now) };
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Sleeps until CLOCK_MONOTONIC shows `at_ns`; returns at once when that has passed. Signals do not shorten the sleep.
#[inline]
pub fn sleep_until_ns(at_ns: u64) {
    let at = libc::timespec {
        tv_sec: (at_ns / 1_000_000_000) as libc::time_t,
        tv_nsec: (at_ns % 1_000_000_000) as libc::c_long,
    };
    loop {
        // SAFETY: `at` is a valid timespec that outlives the call; the remaining time is not asked for (absolute sleep).
        let code =
            unsafe { libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &at, std::ptr::null_mut()) };
        if code != libc::EINTR {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_absolute_sleep_never_ends_early() {
        for _ in 0..20 {
            let at = now_ns() + 200_000;
            sleep_until_ns(at);
            assert!(now_ns() >= at);
        }
        let past = now_ns() - 1;
        sleep_until_ns(past);
        assert!(now_ns() > past);
    }
}
