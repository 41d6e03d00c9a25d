//! The report of a run: `sinew run --report` (`sinew.run/1`).

use std::path::PathBuf;

use serde::Serialize;
use sinew_ipc::Histogram;

use sinew_realtime::RealtimeReport;

/// Name and version of the report's form.
pub const SCHEMA: &str = "sinew.run/1";

/// Everything worth knowing of a run, in the form of `sinew run --report`.
#[derive(Debug, Clone, Serialize)]
pub struct RunReport {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Name of the rig.
    pub rig: String,
    /// Why the loop ended.
    pub ended: Ending,
    /// How long the loop ran, s; simulated time when as fast as possible.
    pub seconds: f64,
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// Number of channels.
    pub channels: usize,
    /// Cycles carried out.
    pub cycles: u64,
    /// Periods without a cycle.
    pub missed: u64,
    /// Of these, the ones the machine took: the loop was woken so late that the period was over before its cycle.
    pub missed_by_wakeup: u64,
    /// Of these, the ones lost after waking up: the cycle alone took longer than its period.
    pub missed_by_cycle: u64,
    /// How late the loop was woken, µs.
    pub lateness_us: Quantiles,
    /// How long a cycle took from wake-up to the last word published, µs.
    pub cycle_us: Quantiles,
    /// From one wake-up to the next, µs.
    pub period_us: Quantiles,
    /// Wake-up latency of a bare timer loop, same thread, same settings, right before the run; where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor: Option<BareLoop>,
    /// Calls to the allocator by the loop's thread while it looped; `null` when the program does not count them.
    pub allocations_in_loop: Option<u64>,
    /// Cycles that no subscriber could get: the ring to the publisher was full, or shared memory could not be had.
    pub unpublished: u64,
    /// What Linux granted.
    pub rt: RealtimeReport,
    /// Faults, in the order they were latched.
    pub faults: Vec<FaultRecord>,
    /// Faults beyond those listed, which is the first [`MAX_FAULTS`].
    pub faults_not_listed: u64,
    /// How often the lease of a setpoint ran out.
    pub leases_lapsed: u64,
    /// Threads of the program that have died, by their names in [`sinew_threads::TABLE`].
    pub threads_died: Vec<&'static str>,
    /// The backend's last complaint, in its own words.
    pub backend_error: Option<String>,
    /// Whether every output has confirmed zero at the end.
    pub outputs_confirmed_zero: bool,
    /// Files the black box has written; filled in by the caller that runs one.
    pub black_boxes: Vec<PathBuf>,
    /// Why a black box could not be written, the last one that could not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub black_box_error: Option<String>,
    /// The last state of each channel.
    pub channel: Vec<ChannelReport>,
}

/// Most faults listed in a report.
pub const MAX_FAULTS: usize = 1000;

/// Why the loop ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Its time was over.
    Duration,
    /// It was requested.
    Stopped,
    /// The loop or a thread without which there is to be no driver has died, by a panic or by an end nobody had asked for; outputs
    /// were put to zero.
    Panicked,
}

/// A distribution in four numbers; `null` where there is nothing to tell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantiles {
    /// Half are at or below.
    pub p50: f64,
    /// 99 % are at or below.
    pub p99: f64,
    /// 99.9 % are at or below.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

impl Quantiles {
    /// Of a histogram of ns.
    pub fn of(histogram: &Histogram) -> Quantiles {
        if histogram.count() == 0 {
            return Quantiles { p50: f64::NAN, p99: f64::NAN, p999: f64::NAN, max: f64::NAN };
        }
        let us = |ns: u64| ns as f64 * 1e-3;
        Quantiles {
            p50: us(histogram.quantile(0.5)),
            p99: us(histogram.quantile(0.99)),
            p999: us(histogram.quantile(0.999)),
            max: us(histogram.max()),
        }
    }
}

/// A bare timer loop's figures: what this machine does to the simplest possible loop.
#[derive(Debug, Clone, Serialize)]
pub struct BareLoop {
    /// How long it ran, s.
    pub seconds: f64,
    /// Its rate, Hz.
    pub rate_hz: f64,
    /// Wake-ups.
    pub cycles: u64,
    /// Periods slept through.
    pub missed: u64,
    /// How late it was woken, µs.
    pub lateness_us: Quantiles,
    /// The same in full, ns; too long for a report.
    #[serde(skip)]
    pub lateness: Histogram,
}

/// One fault of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultRecord {
    /// When, s from the loop's start.
    pub time_s: f64,
    /// Name of the channel.
    pub channel: String,
    /// Short name of the fault, stable for programs.
    pub flag: &'static str,
    /// What happened, in words.
    pub cause: &'static str,
}

/// The last state of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelReport {
    /// Its name.
    pub name: String,
    /// Length, m; `null` when not measured.
    pub length_m: f64,
    /// Target length, m; `null` when it has none.
    pub target_m: f64,
    /// Duty, 0 ..= 1.
    pub duty: f64,
    /// The latched fault's flag, if any.
    pub fault: Option<&'static str>,
}
