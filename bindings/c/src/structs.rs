//! Plain data for C: what the client knows, with names that end with a zero byte.

use sinew_ipc::{self as ipc, Anew, Fault, Histogram, MAX_RIG_NAME, Reason, Update};
use std::ffi::c_char;

/// Most channels of a rig.
pub const MAX_CHANNELS: usize = 64;

/// Bytes of a name, with the zero byte at its end.
pub const NAME_SIZE: usize = 65;

/// A connection to a running driver. Threads may share it.
pub struct Client(());

/// Every cycle from the moment it was opened, in order. For one thread at a time.
pub struct CycleStream(());

/// Watches for faults. For one thread at a time.
pub struct FaultWatch(());

/// A stream of setpoints. For one thread at a time.
pub struct Setpoints(());

/// The clock of another device beside the driver's, learnt from pairs of times. For one thread at a time.
pub struct ClockMap(());

/// What does not change while the driver runs.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Info {
    /// Version of the driver's messages.
    pub protocol: u32,
    /// Process id of the driver.
    pub pid: u32,
    /// Name of the rig.
    pub rig: [c_char; NAME_SIZE],
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// When the driver started, CLOCK_MONOTONIC, ns.
    pub started_ns: u64,
    /// How many channels there are.
    pub channels: u32,
    /// 1 when the wires are simulated, 0 when they are real.
    pub simulated: u32,
    /// 1 when the driver is another user's, reached through its gateway.
    pub foreign: u32,
}

/// What does not change about a channel while the driver runs.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct ChannelInfo {
    /// Its name in the rig file.
    pub name: [c_char; NAME_SIZE],
    /// Shortest length that may be asked for, m.
    pub min_length_m: f64,
    /// Longest length that may be asked for, m.
    pub max_length_m: f64,
    /// Length at full stroke: hot, under the load at rest, m.
    pub hot_length_m: f64,
    /// Length without stroke: cold, under the load at rest, m.
    pub cold_length_m: f64,
    /// Hot, unloaded length L_0, m.
    pub rest_length_m: f64,
    /// Largest duty, 0..1.
    pub max_duty: f64,
    /// Largest current in the on-phase, A.
    pub max_current_a: f64,
    /// Largest mean power, W.
    pub max_power_w: f64,
    /// Highest estimated temperature, °C.
    pub max_temperature_c: f64,
    /// Lease of a setpoint that names none, s.
    pub lease_s: f64,
}

/// One cycle of a stream.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Cycle {
    /// Number of the cycle, from 1, consecutive over the cycles that ran.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late. They have no cycle number.
    pub missed: u64,
    /// Cycles lost between the one before and this one: this reader was too slow.
    pub lost: u64,
    /// How many of the channels are there.
    pub channels: u32,
    /// The channels, in the rig's order; those that are not there are left as they were.
    pub channel: [ipc::ChannelState; MAX_CHANNELS],
}

/// How long something took, ns.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Timing {
    /// How often it was measured.
    pub count: u64,
    /// Half of them took no longer, ns.
    pub p50_ns: u64,
    /// 99 of 100 took no longer, ns.
    pub p99_ns: u64,
    /// 999 of 1000 took no longer, ns.
    pub p999_ns: u64,
    /// The longest, ns.
    pub max_ns: u64,
}

/// How the loop does.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct LoopStats {
    /// How late the loop woke up.
    pub lateness: Timing,
    /// How long a cycle took.
    pub cycle_time: Timing,
    /// Time between two cycles.
    pub period: Timing,
    /// Cycles that ran.
    pub cycles: u64,
    /// Periods skipped because the loop was late.
    pub missed: u64,
    /// Cycles that took longer than a period.
    pub overruns: u64,
    /// Cycles that no stream has, because they did not fit on the way to the publisher.
    pub ring_drops: u64,
    /// Allocations inside the loop; 0 unless something is wrong.
    pub allocations: u64,
    /// Commands taken.
    pub commands: u64,
    /// Commands refused.
    pub refusals: u64,
    /// Priority under SCHED_FIFO, 0 without.
    pub priority: u32,
    /// Processor the loop is pinned to, -1 without.
    pub cpu: i32,
    /// Threads of the driver that have died and without which it goes on; `sinew status` names them.
    pub dead_threads: u32,
}

/// How the driver is.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum DriverHealth {
    /// Services are there, the loop does not run yet.
    Starting = 0,
    /// The loop runs.
    Running = 1,
    /// Its process lives but the loop has not written for a while.
    Stalled = 2,
    /// It is stopping or has stopped in order.
    Stopped = 3,
    /// It ended without stopping.
    Died = 4,
}

/// One setpoint of several.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Wanted {
    /// Number of the channel.
    pub channel: u32,
    /// What is asked for: length, stroke, duty, force or off of `SinewCommandKind`.
    pub kind: u32,
    /// Value in SI units; 0 for off.
    pub value: f64,
}

/// What became of a command.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Taken {
    /// Number of the cycle from which on it is in force.
    pub cycle: u64,
    /// The lease as granted, s; 0 where there is none.
    pub hold_s: f64,
}

/// What became of the messages of a stream of setpoints so far. Those in none of the other counts are on their way.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct SetpointProgress {
    /// Messages given to `sinew_setpoints_send`.
    pub sent: u64,
    /// In force.
    pub taken: u64,
    /// Not carried out because a later one of the stream, or an off, has overtaken them.
    pub overtaken: u64,
    /// Not carried out because they came after their deadline.
    pub late: u64,
    /// Refused for another reason.
    pub refused: u64,
    /// Not sent because too many were without an answer.
    pub held_back: u64,
    /// Number of the cycle in which the last one was taken; 0 = none yet.
    pub cycle: u64,
}

/// What is assumed of another clock; `sinew_clock_rules` has what is usual.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct ClockRules {
    /// What its rate and the driver's are apart by at the most, ppm.
    pub max_rate_ppm: f64,
    /// What that may change by in a second, ppm/s: temperature mostly.
    pub drift_ppm_per_s: f64,
    /// What its stamps are rounded to, ns.
    pub resolution_ns: u64,
    /// The least that late stamps are ever delayed by, ns. Nothing that only comes late can tell: at 0 all answers are too late by just that.
    pub least_delay_ns: u64,
    /// What that is off by, ns.
    pub least_delay_error_ns: u64,
    /// Late stamps must cover so much time before they say anything, s.
    pub settle_s: f64,
    /// Pairs older than this are forgotten, s.
    pub window_s: f64,
    /// Pairs that are kept at the most.
    pub pairs: u32,
}

/// What a pair of times says of the device's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum ClockNews {
    /// It goes on as before.
    None = 0,
    /// It shows an earlier time than before: it was reset. All pairs before are forgotten, as with those below.
    WentBack = 1,
    /// It was set.
    Jumped = 2,
    /// Its rate changed by more than is assumed of it.
    Unsteady = 3,
}

/// Whether a device's clock has been set.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct ClockChange {
    /// What has come to pass.
    pub news: ClockNews,
    /// By how much it was set, ns, forward where this is positive; 0 where that is not known.
    pub by_ns: i64,
}

/// What the driver refused, and why. What a reason has not is 0 for codes and NaN for numbers.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Refusal {
    /// The channel's name; "all channels" for commands that name none.
    pub channel: [c_char; NAME_SIZE],
    /// What was asked for: `SinewCommandKind`.
    pub kind: u32,
    /// Why not: `SinewOutcome`.
    pub outcome: u32,
    /// The fault in the way: `SinewFault`.
    pub fault: u32,
    /// The value asked for, in SI units.
    pub value: f64,
    /// Smallest value or hold that would have been taken.
    pub low: f64,
    /// Largest value or hold that would have been taken.
    pub high: f64,
    /// Too hot: after this long it has cooled, at the most, s.
    pub longest_s: f64,
    /// Too hot: what is believed of its temperature, °C.
    pub temperature_c: f64,
    /// Too hot: what that has to come down to, °C. Where it has, the heat account has to drain.
    pub below_c: f64,
    /// What is wrong. Valid until the next call of this thread that fails.
    pub message: *const c_char,
    /// What to do about it. Valid as long.
    pub remedy: *const c_char,
}

/// One change of a channel's fault.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct FaultChange {
    /// Number of the channel.
    pub channel: u32,
    /// The fault before, 0 = none.
    pub before: u32,
    /// The fault from now on, 0 = cleared.
    pub after: u32,
    /// The cycle it was seen in.
    pub cycle: u64,
    /// When, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
}

/// A name with its zero byte; what is too long, which no name is, is cut.
pub(crate) fn name(text: &str) -> [c_char; NAME_SIZE] {
    let mut name = [0; NAME_SIZE];
    for (place, byte) in name[..NAME_SIZE - 1].iter_mut().zip(text.bytes()) {
        *place = byte as c_char;
    }
    name
}

// A number that the header can show.
const _: () = assert!(MAX_CHANNELS == ipc::MAX_CHANNELS);
const _: () = assert!(MAX_RIG_NAME < NAME_SIZE && size_of::<ipc::Name>() < NAME_SIZE);

impl Info {
    pub(crate) fn of(client: &ipc::Client) -> Info {
        let ipc::Info { protocol, pid, rig, rate_hz, started_ns, channels: _, simulated, channel: _ } = client.info();
        Info {
            protocol: *protocol,
            pid: *pid,
            rig: name(rig.as_str()),
            rate_hz: *rate_hz,
            started_ns: *started_ns,
            channels: client.channels().len() as u32,
            simulated: *simulated,
            foreign: client.is_foreign().into(),
        }
    }
}

impl From<&ipc::ChannelInfo> for ChannelInfo {
    fn from(info: &ipc::ChannelInfo) -> ChannelInfo {
        // taken apart as a whole, so that none is forgotten
        let &ipc::ChannelInfo {
            name: called,
            min_length_m,
            max_length_m,
            hot_length_m,
            cold_length_m,
            rest_length_m,
            max_duty,
            max_current_a,
            max_power_w,
            max_temperature_c,
            lease_s,
        } = info;
        ChannelInfo {
            name: name(called.as_str()),
            min_length_m,
            max_length_m,
            hot_length_m,
            cold_length_m,
            rest_length_m,
            max_duty,
            max_current_a,
            max_power_w,
            max_temperature_c,
            lease_s,
        }
    }
}

impl From<ipc::ClockRules> for ClockRules {
    fn from(rules: ipc::ClockRules) -> ClockRules {
        // taken apart as a whole, so that none is forgotten
        let ipc::ClockRules {
            max_rate_ppm,
            drift_ppm_per_s,
            resolution_ns,
            least_delay_ns,
            least_delay_error_ns,
            settle_s,
            window_s,
            pairs,
        } = rules;
        ClockRules {
            max_rate_ppm,
            drift_ppm_per_s,
            resolution_ns,
            least_delay_ns,
            least_delay_error_ns,
            settle_s,
            window_s,
            pairs: pairs.try_into().unwrap_or(u32::MAX),
        }
    }
}

impl From<ClockRules> for ipc::ClockRules {
    fn from(rules: ClockRules) -> ipc::ClockRules {
        let ClockRules {
            max_rate_ppm,
            drift_ppm_per_s,
            resolution_ns,
            least_delay_ns,
            least_delay_error_ns,
            settle_s,
            window_s,
            pairs,
        } = rules;
        ipc::ClockRules {
            max_rate_ppm,
            drift_ppm_per_s,
            resolution_ns,
            least_delay_ns,
            least_delay_error_ns,
            settle_s,
            window_s,
            pairs: pairs as usize,
        }
    }
}

impl From<Update> for ClockChange {
    fn from(update: Update) -> ClockChange {
        let (news, by_ns) = match update {
            Update::Kept | Update::Passed => (ClockNews::None, 0),
            Update::Anew(Anew::WentBack { by_ns }) => (ClockNews::WentBack, 0i64.saturating_sub_unsigned(by_ns)),
            Update::Anew(Anew::Jumped { by_ns }) => (ClockNews::Jumped, by_ns),
            Update::Anew(Anew::Unsteady) => (ClockNews::Unsteady, 0),
        };
        ClockChange { news, by_ns }
    }
}

impl From<&Histogram> for Timing {
    fn from(histogram: &Histogram) -> Timing {
        Timing {
            count: histogram.count(),
            p50_ns: histogram.quantile(0.5),
            p99_ns: histogram.quantile(0.99),
            p999_ns: histogram.quantile(0.999),
            max_ns: histogram.max(),
        }
    }
}

impl From<&ipc::LoopStats> for LoopStats {
    fn from(stats: &ipc::LoopStats) -> LoopStats {
        LoopStats {
            lateness: (&stats.lateness).into(),
            cycle_time: (&stats.cycle_time).into(),
            period: (&stats.period).into(),
            cycles: stats.cycles,
            missed: stats.missed,
            overruns: stats.overruns,
            ring_drops: stats.ring_drops,
            allocations: stats.allocations,
            commands: stats.commands,
            refusals: stats.refusals,
            priority: stats.priority,
            cpu: stats.cpu,
            dead_threads: stats.dead_threads().count() as u32,
        }
    }
}

impl From<ipc::DriverHealth> for DriverHealth {
    fn from(health: ipc::DriverHealth) -> DriverHealth {
        match health {
            ipc::DriverHealth::Starting => DriverHealth::Starting,
            ipc::DriverHealth::Running => DriverHealth::Running,
            ipc::DriverHealth::Stalled { .. } => DriverHealth::Stalled,
            ipc::DriverHealth::Stopped => DriverHealth::Stopped,
            ipc::DriverHealth::Died => DriverHealth::Died,
        }
    }
}

impl From<ipc::Progress> for SetpointProgress {
    fn from(progress: ipc::Progress) -> SetpointProgress {
        let ipc::Progress { sent, taken, overtaken, late, refused, held_back, cycle } = progress;
        SetpointProgress { sent, taken, overtaken, late, refused, held_back, cycle }
    }
}

impl From<ipc::Taken> for Taken {
    fn from(ipc::Taken { cycle, hold_s }: ipc::Taken) -> Taken {
        Taken { cycle, hold_s }
    }
}

impl From<ipc::Reply> for Taken {
    fn from(reply: ipc::Reply) -> Taken {
        Taken { cycle: reply.cycle, hold_s: reply.hold_s }
    }
}

impl From<&ipc::FaultChange> for FaultChange {
    fn from(change: &ipc::FaultChange) -> FaultChange {
        FaultChange {
            channel: change.channel as u32,
            before: change.before.map_or(0, Fault::code),
            after: change.after.map_or(0, Fault::code),
            cycle: change.cycle,
            monotonic_ns: change.monotonic_ns,
        }
    }
}

impl Refusal {
    pub(crate) fn of(refusal: &ipc::Refusal, message: *const c_char, remedy: *const c_char) -> Refusal {
        let mut told = Refusal {
            channel: name(&refusal.channel),
            kind: refusal.kind.code(),
            outcome: refusal.reason.outcome(),
            fault: 0,
            value: refusal.value,
            low: f64::NAN,
            high: f64::NAN,
            longest_s: f64::NAN,
            temperature_c: f64::NAN,
            below_c: f64::NAN,
            message,
            remedy,
        };
        match refusal.reason {
            Reason::OutOfRange { low, high }
            | Reason::HoldOutOfRange { low, high }
            | Reason::ApproachOutOfRange { low, high } => {
                (told.low, told.high) = (low, high);
            }
            Reason::Faulted(fault) | Reason::CauseRemains(fault) => told.fault = fault.code(),
            Reason::TooHot { fault, longest_s, temperature_c, below_c } => {
                told.fault = fault.code();
                (told.longest_s, told.temperature_c, told.below_c) = (longest_s, temperature_c, below_c);
            }
            _ => {}
        }
        told
    }
}
