//! Clocks beside the driver's: those of this machine, and a device's learnt from pairs of times.

use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use sinew_clocks::{ClockRules, Mapped, Update};

/// A time and what it is off by at the most, ns.
type Pair<T> = (T, u64);

fn pair<T>(mapped: Mapped<T>) -> Pair<T> {
    (mapped.ns, mapped.error_ns)
}

/// The clocks of this machine, compared when it is made and by `refresh`.
#[cfg(target_os = "linux")]
#[pyclass(module = "sinew._sinew")]
pub struct Clocks {
    clocks: sinew_clocks::Clocks,
}

#[cfg(target_os = "linux")]
#[pymethods]
impl Clocks {
    #[new]
    fn new() -> Clocks {
        Clocks { clocks: sinew_clocks::Clocks::now() }
    }

    /// Compares anew: what the system's clock was set by since the last time, where it was, ns; what CLOCK_MONOTONIC was corrected by and
    /// what that is off by, ppm; how long the machine was suspended, ns; all of it in words.
    fn refresh(&mut self) -> (Option<i64>, f64, f64, i64, String) {
        let change = self.clocks.refresh();
        (change.step(), change.slew_ppm, change.slew_error_ppm, change.suspended_ns, change.to_string())
    }

    fn system(&self, monotonic_ns: u64) -> Pair<i64> {
        pair(self.clocks.system(monotonic_ns))
    }

    fn tai(&self, monotonic_ns: u64) -> Option<Pair<i64>> {
        self.clocks.tai(monotonic_ns).map(pair)
    }

    fn boottime(&self, monotonic_ns: u64) -> Pair<u64> {
        pair(self.clocks.boottime(monotonic_ns))
    }

    fn driver_at_system(&self, system_ns: i64) -> Pair<u64> {
        pair(self.clocks.reading().driver_at_system(system_ns))
    }

    /// What system time is off from UTC by at the most, ns; `None` where it is not synchronised.
    fn utc_error_ns(&self) -> Option<u64> {
        self.clocks.reading().utc_error_ns
    }
}

/// A device's clock.
#[pyclass(frozen, module = "sinew._sinew")]
pub struct ClockMap {
    map: Mutex<sinew_clocks::ClockMap>,
}

/// Why it has begun anew, where it has.
fn why(update: Update) -> Option<String> {
    match update {
        Update::Anew(why) => Some(why.to_string()),
        Update::Kept | Update::Passed => None,
    }
}

impl ClockMap {
    fn with<T>(&self, act: impl FnOnce(&mut sinew_clocks::ClockMap) -> T) -> T {
        act(&mut self.map.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl ClockMap {
    /// `None` where what is usual is to be assumed.
    #[new]
    #[pyo3(signature = (max_rate_ppm=None, drift_ppm_per_s=None, resolution_ns=0, least_delay_ns=0, least_delay_error_ns=0,
                        settle_s=None, window_s=None, pairs=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        max_rate_ppm: Option<f64>,
        drift_ppm_per_s: Option<f64>,
        resolution_ns: u64,
        least_delay_ns: u64,
        least_delay_error_ns: u64,
        settle_s: Option<f64>,
        window_s: Option<f64>,
        pairs: Option<usize>,
    ) -> ClockMap {
        let usual = ClockRules::default();
        let map = sinew_clocks::ClockMap::new(ClockRules {
            max_rate_ppm: max_rate_ppm.unwrap_or(usual.max_rate_ppm),
            drift_ppm_per_s: drift_ppm_per_s.unwrap_or(usual.drift_ppm_per_s),
            resolution_ns,
            least_delay_ns,
            least_delay_error_ns,
            settle_s: settle_s.unwrap_or(usual.settle_s),
            window_s: window_s.unwrap_or(usual.window_s),
            pairs: pairs.unwrap_or(usual.pairs),
        });
        ClockMap { map: Mutex::new(map) }
    }

    fn bracket(&self, before_ns: u64, other_ns: i64, after_ns: u64) -> Option<String> {
        why(self.with(|map| map.bracket(before_ns, other_ns, after_ns)))
    }

    fn pair(&self, driver_ns: u64, other_ns: i64, error_ns: u64) -> Option<String> {
        why(self.with(|map| map.pair(driver_ns, other_ns, error_ns)))
    }

    fn late(&self, received_ns: u64, other_ns: i64) -> Option<String> {
        why(self.with(|map| map.late(received_ns, other_ns)))
    }

    fn driver_at(&self, other_ns: i64) -> Option<Pair<u64>> {
        self.with(|map| map.driver_at(other_ns)).map(pair)
    }

    fn other_at(&self, driver_ns: u64) -> Option<Pair<i64>> {
        self.with(|map| map.other_at(driver_ns)).map(pair)
    }

    fn rate_ppm(&self) -> Option<(f64, f64)> {
        self.with(|map| map.rate_ppm())
    }

    fn pairs(&self) -> usize {
        self.with(|map| map.pairs())
    }

    fn clear(&self) {
        self.with(|map| map.clear());
    }
}
