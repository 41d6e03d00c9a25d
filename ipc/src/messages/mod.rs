//! What travels between the driver and other processes: plain data with a fixed layout, in SI units.
//!
//! Every change of a layout or of a meaning raises [`PROTOCOL`]; a client of another version is told so when it connects.

use crate::{Error, Fault, Histogram};
use iceoryx2::prelude::ZeroCopySend;
use std::fmt;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Version of these messages.
pub const PROTOCOL: u32 = 2;
/// Most channels of a rig.
pub const MAX_CHANNELS: usize = 64;
/// Most cycles in one batch of the stream.
pub const MAX_BATCH: usize = 32;
/// Channel number of a command that is meant for all of them (off, reset, stop).
pub const ALL_CHANNELS: u32 = u32::MAX;

/// What a channel is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Mode {
    /// Nothing is known about the wire yet: no complete sample has come.
    Waiting = 0,
    /// Only the sensing pulse.
    Off = 1,
    /// Length under control.
    Length = 2,
    /// Duty as commanded.
    Duty = 3,
    /// Force under control.
    Force = 4,
    /// The driver itself moves the wire (the built-in hexapod's walk).
    Program = 5,
    /// Switched off by a latched fault.
    Fault = 6,
}

impl Mode {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The mode with this number.
    pub const fn from_code(code: u32) -> Option<Mode> {
        Some(match code {
            0 => Mode::Waiting,
            1 => Mode::Off,
            2 => Mode::Length,
            3 => Mode::Duty,
            4 => Mode::Force,
            5 => Mode::Program,
            6 => Mode::Fault,
            _ => return None,
        })
    }

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Mode::Waiting => "waiting",
            Mode::Off => "off",
            Mode::Length => "length",
            Mode::Duty => "duty",
            Mode::Force => "force",
            Mode::Program => "program",
            Mode::Fault => "fault",
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One channel in one cycle. What is not known is NaN.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct ChannelState {
    /// Measured wire length, m, one sample with its noise; NaN while it is not measured.
    pub length_m: f64,
    /// The same as the observer has it, m: without the noise, a few ms late; NaN while it is not measured.
    pub observed_length_m: f64,
    /// Observed speed, m/s, positive when the wire gets longer.
    pub velocity_m_s: f64,
    /// Observed acceleration, m/s².
    pub acceleration_m_s2: f64,
    /// Length asked for, m; NaN when none is.
    pub target_m: f64,
    /// Duty given for the next period, 0..1.
    pub duty: f64,
    /// Measured resistance, Ω.
    pub resistance_ohm: f64,
    /// Estimated wire temperature, °C.
    pub temperature_c: f64,
    /// Estimated martensite fraction, 0..1.
    pub martensite: f64,
    /// Mean electrical power over the period just past, W.
    pub power_w: f64,
    /// The controller's surface σ (sliding mode, m/s²) or error; 0 without a controller.
    pub surface: f64,
    /// What is left of the setpoint's lease, s; infinite when the driver moves the channel by itself, NaN without a setpoint.
    pub lease_s: f64,
    /// Value of the client's setpoint as the loop took it: m for a length and for a force against a spring, N for the tension of
    /// a joint, a duty 0..1; NaN without one.
    pub asked: f64,
    /// Supply as sampled in the period just past, V; NaN = not sampled. This and the four below are the bits the backend delivered:
    /// what a recording is replayed from.
    pub supply_v: f64,
    /// First tap as sampled, V; NaN = not sampled.
    pub v1_v: f64,
    /// Second tap as sampled, V; NaN = not sampled.
    pub v2_v: f64,
    /// Moving end as sampled, V; NaN = not sampled.
    pub v3_v: f64,
    /// Current as sampled, A; NaN = not sampled.
    pub current_a: f64,
    /// What the channel is doing: [`Mode`].
    pub mode: u32,
    /// The latched fault: [`Fault`] or 0.
    pub fault: u32,
    /// Verdict on the present sample: the codes of `sinew_sensing::Health`, 0 = good.
    pub health: u32,
    /// Bits of `ChannelState::FLAG_…`.
    pub flags: u32,
    /// The request the loop took right before this cycle, 0 = none: see [`ChannelState::order`].
    pub order: u32,
    /// How the backend failed in this cycle: 0 = it did not, else the codes of `sinew_driver::BackendError`.
    pub backend: u32,
}

impl ChannelState {
    /// The controller is at one of its two limits.
    pub const FLAG_SATURATED: u32 = 1;
    /// The target has been reached.
    pub const FLAG_SETTLED: u32 = 1 << 1;
    /// A limit of power, duty or tension holds the duty from what the controller asks for.
    pub const FLAG_LIMITED: u32 = 1 << 2;
    /// And that limit is the heat budget: the duty is derated, so that the wire takes no more than it can give off.
    pub const FLAG_HEAT_BUDGET: u32 = 1 << 3;
    /// And that limit is the estimated temperature: the duty is derated, so that it stays below its maximum.
    pub const FLAG_TEMPERATURE_BUDGET: u32 = 1 << 4;
    /// The fault that is latched was the first of those latched now on any channel.
    pub const FLAG_FIRST: u32 = 1 << 5;
    /// The period ahead is dark: no duty, so that it shows whether the output stage switches off. Its sample has no length.
    pub const FLAG_DARK: u32 = 1 << 6;

    /// Of a channel nothing is known about.
    pub const UNKNOWN: ChannelState = ChannelState {
        length_m: f64::NAN,
        observed_length_m: f64::NAN,
        velocity_m_s: f64::NAN,
        acceleration_m_s2: f64::NAN,
        target_m: f64::NAN,
        duty: 0.0,
        resistance_ohm: f64::NAN,
        temperature_c: f64::NAN,
        martensite: f64::NAN,
        power_w: 0.0,
        surface: 0.0,
        lease_s: f64::NAN,
        asked: f64::NAN,
        supply_v: f64::NAN,
        v1_v: f64::NAN,
        v2_v: f64::NAN,
        v3_v: f64::NAN,
        current_a: f64::NAN,
        mode: Mode::Waiting as u32,
        fault: 0,
        health: 0,
        flags: 0,
        order: 0,
        backend: 0,
    };

    /// Its floats in the order of their bytes, each with its unit.
    pub const FLOATS: [(&'static str, &'static str); 18] = [
        ("length_m", "m"),
        ("observed_length_m", "m"),
        ("velocity_m_s", "m/s"),
        ("acceleration_m_s2", "m/s²"),
        ("target_m", "m"),
        ("duty", ""),
        ("resistance_ohm", "Ω"),
        ("temperature_c", "°C"),
        ("martensite", ""),
        ("power_w", "W"),
        ("surface", "m/s²"),
        ("lease_s", "s"),
        ("asked", ""),
        ("supply_v", "V"),
        ("v1_v", "V"),
        ("v2_v", "V"),
        ("v3_v", "V"),
        ("current_a", "A"),
    ];
    /// The codes and flags behind them, in the order of their bytes.
    pub const CODES: [&'static str; 6] = ["mode", "fault", "health", "flags", "order", "backend"];

    /// Its floats and its codes, in the order of [`ChannelState::FLOATS`] and [`ChannelState::CODES`].
    #[inline]
    pub const fn parts(&self) -> ([f64; 18], [u32; 6]) {
        let s = self;
        (
            [
                s.length_m,
                s.observed_length_m,
                s.velocity_m_s,
                s.acceleration_m_s2,
                s.target_m,
                s.duty,
                s.resistance_ohm,
                s.temperature_c,
                s.martensite,
                s.power_w,
                s.surface,
                s.lease_s,
                s.asked,
                s.supply_v,
                s.v1_v,
                s.v2_v,
                s.v3_v,
                s.current_a,
            ],
            [s.mode, s.fault, s.health, s.flags, s.order, s.backend],
        )
    }

    /// The state with these parts: the inverse of [`ChannelState::parts`].
    #[inline]
    pub const fn from_parts(floats: &[f64; 18], codes: &[u32; 6]) -> ChannelState {
        ChannelState {
            length_m: floats[0],
            observed_length_m: floats[1],
            velocity_m_s: floats[2],
            acceleration_m_s2: floats[3],
            target_m: floats[4],
            duty: floats[5],
            resistance_ohm: floats[6],
            temperature_c: floats[7],
            martensite: floats[8],
            power_w: floats[9],
            surface: floats[10],
            lease_s: floats[11],
            asked: floats[12],
            supply_v: floats[13],
            v1_v: floats[14],
            v2_v: floats[15],
            v3_v: floats[16],
            current_a: floats[17],
            mode: codes[0],
            fault: codes[1],
            health: codes[2],
            flags: codes[3],
            order: codes[4],
            backend: codes[5],
        }
    }

    /// The number for a request taken as the `place`th (from 1) of its cycle.
    pub const fn order_code(kind: CommandKind, place: u32) -> u32 {
        kind.code() | place << 8
    }

    /// The request taken right before this cycle, and as which one (from 1) of all channels'. A channel takes at most one a
    /// cycle, so that a recording has every one; its value is [`ChannelState::asked`], its lease the one that is left.
    pub fn order(&self) -> Option<(CommandKind, u32)> {
        Some((CommandKind::from_code(self.order & 0xff)?, self.order >> 8))
    }

    /// The bytes of these, one after the other, as they lie in memory: what a recording holds.
    pub fn bytes_of(channels: &[ChannelState]) -> &[u8] {
        channels.as_bytes()
    }

    /// The latched fault, if any.
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.fault)
    }

    /// What the channel is doing.
    pub fn mode(&self) -> Mode {
        Mode::from_code(self.mode).unwrap_or(Mode::Waiting)
    }
}

impl Default for ChannelState {
    fn default() -> Self {
        ChannelState::UNKNOWN
    }
}

/// What the driver as a whole is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum DriverState {
    /// Services are there, the loop does not run yet.
    Starting = 0,
    /// The loop runs.
    Running = 1,
    /// Outputs go to zero, the end is near.
    Stopping = 2,
    /// Outputs are zero and stay so; this was the last state.
    Stopped = 3,
}

impl DriverState {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The state with this number; unknown ones count as stopped.
    pub const fn from_code(code: u32) -> DriverState {
        match code {
            0 => DriverState::Starting,
            1 => DriverState::Running,
            2 => DriverState::Stopping,
            _ => DriverState::Stopped,
        }
    }
}

/// What holds for a whole cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct CycleHeader {
    /// Number of the cycle, from 1, consecutive over the cycles that ran: a gap in the stream is what the reader lost.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late. They have no cycle number.
    pub missed: u64,
}

/// A cycle in memory of its own: on its way through a ring, or kept.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldCycle {
    /// Its number and time.
    pub header: CycleHeader,
    /// All channels, in the rig's order.
    pub channels: Box<[ChannelState]>,
}

impl HeldCycle {
    /// Room for a cycle of so many channels.
    pub fn new(channels: usize) -> HeldCycle {
        HeldCycle { header: CycleHeader::default(), channels: vec![ChannelState::UNKNOWN; channels].into() }
    }

    /// Makes it a copy of this cycle, as far as there is room for channels. Allocates nothing.
    #[inline]
    pub fn copy_from(&mut self, header: CycleHeader, channels: &[ChannelState]) {
        self.header = header;
        let channels = &channels[..channels.len().min(self.channels.len())];
        self.channels[..channels.len()].copy_from_slice(channels);
    }
}

/// The latest state of everything: one consistent cycle.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Snapshot {
    /// Number of the cycle, from 1; 0 before the first.
    pub cycle: u64,
    /// When its samples were taken, CLOCK_MONOTONIC, ns; the driver's heartbeat.
    pub monotonic_ns: u64,
    /// Periods skipped since the start because the loop was late.
    pub missed: u64,
    /// How many of the channels are there.
    pub channels: u32,
    /// What the driver is doing: [`DriverState`].
    pub state: u32,
    /// The channels; [`Snapshot::channels`] of them are there.
    pub channel: [ChannelState; MAX_CHANNELS],
}

impl Snapshot {
    /// Before the first cycle.
    pub const fn new(channels: usize) -> Snapshot {
        Snapshot {
            cycle: 0,
            monotonic_ns: 0,
            missed: 0,
            channels: if channels < MAX_CHANNELS { channels as u32 } else { MAX_CHANNELS as u32 },
            state: DriverState::Starting as u32,
            channel: [ChannelState::UNKNOWN; MAX_CHANNELS],
        }
    }

    /// The channels that are there, in the rig's order.
    pub fn channels(&self) -> &[ChannelState] {
        &self.channel[..(self.channels as usize).min(MAX_CHANNELS)]
    }

    /// What holds for the whole cycle.
    pub fn header(&self) -> CycleHeader {
        CycleHeader { cycle: self.cycle, monotonic_ns: self.monotonic_ns, missed: self.missed }
    }

    /// What the driver is doing.
    pub fn state(&self) -> DriverState {
        DriverState::from_code(self.state)
    }

    /// Copies another one, without the channels that are not there.
    pub fn copy_from(&mut self, other: &Snapshot) {
        let n = (other.channels as usize).min(MAX_CHANNELS);
        self.cycle = other.cycle;
        self.monotonic_ns = other.monotonic_ns;
        self.missed = other.missed;
        self.channels = n as u32;
        self.state = other.state;
        self.channel[..n].copy_from_slice(&other.channel[..n]);
    }
}

impl Default for Snapshot {
    fn default() -> Self {
        Snapshot::new(0)
    }
}

/// Bytes of a [`Name`].
const NAME_BYTES: usize = 64;

/// A name of at most 64 bytes, UTF-8, padded with zeros.
#[derive(Clone, Copy, PartialEq, Eq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Name {
    bytes: [u8; NAME_BYTES],
}

impl Name {
    /// No name.
    pub const EMPTY: Name = Name { bytes: [0; NAME_BYTES] };

    /// From text of 1 to 64 bytes without a zero byte.
    ///
    /// # Errors
    /// [`Error::Name`] otherwise.
    pub fn new(text: &str) -> Result<Name, Error> {
        if text.is_empty() || text.len() > NAME_BYTES || text.bytes().any(|b| b == 0) {
            return Err(Error::Name { name: text.to_string() });
        }
        let mut name = Name::EMPTY;
        name.bytes[..text.len()].copy_from_slice(text.as_bytes());
        Ok(name)
    }

    /// The text; what is not UTF-8 (a foreign writer's) is cut off.
    pub fn as_str(&self) -> &str {
        let end = self.bytes.iter().position(|&b| b == 0).unwrap_or(NAME_BYTES);
        match std::str::from_utf8(&self.bytes[..end]) {
            Ok(text) => text,
            Err(e) => std::str::from_utf8(&self.bytes[..e.valid_up_to()]).unwrap_or(""),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

/// What does not change about a channel while the driver runs.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct ChannelInfo {
    /// Its name in the rig file.
    pub name: Name,
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

impl ChannelInfo {
    /// Without name and limits.
    pub const EMPTY: ChannelInfo = ChannelInfo {
        name: Name::EMPTY,
        min_length_m: f64::NAN,
        max_length_m: f64::NAN,
        hot_length_m: f64::NAN,
        cold_length_m: f64::NAN,
        rest_length_m: f64::NAN,
        max_duty: f64::NAN,
        max_current_a: f64::NAN,
        max_power_w: f64::NAN,
        max_temperature_c: f64::NAN,
        lease_s: f64::NAN,
    };

    /// Length at a stroke, m: 0 = cold, 1 = hot. A stroke of 40 % is 0.4.
    pub fn length_at_stroke(&self, stroke: f64) -> f64 {
        self.cold_length_m + stroke * (self.hot_length_m - self.cold_length_m)
    }

    /// Stroke at a length: the inverse of [`ChannelInfo::length_at_stroke`]; NaN for a channel without stroke.
    pub fn stroke_at_length(&self, length_m: f64) -> f64 {
        let stroke_m = self.cold_length_m - self.hot_length_m;
        if stroke_m > 0.0 { (self.cold_length_m - length_m) / stroke_m } else { f64::NAN }
    }
}

/// What does not change while the driver runs.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Info {
    /// Version of the messages: [`PROTOCOL`] of the driver.
    pub protocol: u32,
    /// Process id of the driver.
    pub pid: u32,
    /// Name of the rig.
    pub rig: Name,
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// When the driver started, CLOCK_MONOTONIC, ns.
    pub started_ns: u64,
    /// How many of the channels are there.
    pub channels: u32,
    /// 1 when the wires are simulated, 0 when they are real.
    pub simulated: u32,
    /// The channels; [`Info::channels`] of them are there.
    pub channel: [ChannelInfo; MAX_CHANNELS],
}

impl Info {
    /// Of this process, with the channels as given.
    ///
    /// # Errors
    /// [`Error::RigName`] for a rig name outside the allowed characters, [`Error::Channels`] for none or too many channels.
    pub fn new(rig: &str, rate_hz: f64, channels: &[ChannelInfo]) -> Result<Info, Error> {
        crate::run::check_rig_name(rig)?;
        if channels.is_empty() || channels.len() > MAX_CHANNELS {
            return Err(Error::Channels { found: channels.len() });
        }
        let mut channel = [ChannelInfo::EMPTY; MAX_CHANNELS];
        channel[..channels.len()].copy_from_slice(channels);
        Ok(Info {
            protocol: PROTOCOL,
            pid: std::process::id(),
            rig: Name::new(rig)?,
            rate_hz,
            started_ns: crate::sys::monotonic_ns(),
            channels: channels.len() as u32,
            simulated: 0,
            channel,
        })
    }

    /// The channels that are there, in the rig's order.
    pub fn channels(&self) -> &[ChannelInfo] {
        &self.channel[..(self.channels as usize).min(MAX_CHANNELS)]
    }

    /// The number of the channel with this name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.channels().iter().position(|c| c.name.as_str() == name)
    }
}

/// How the loop does: filled by the loop, published some times a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct LoopStats {
    /// How late the loop woke up, ns.
    pub lateness: Histogram,
    /// How long a cycle took, ns.
    pub cycle_time: Histogram,
    /// Time between two cycles, ns.
    pub period: Histogram,
    /// Cycles that ran.
    pub cycles: u64,
    /// Periods skipped because the loop was late.
    pub missed: u64,
    /// Cycles that took longer than a period.
    pub overruns: u64,
    /// Cycles that did not fit into the ring to the publisher, so that no stream has them.
    pub ring_drops: u64,
    /// Allocations inside the loop; 0 unless something is wrong.
    pub allocations: u64,
    /// Commands taken.
    pub commands: u64,
    /// Commands refused.
    pub refusals: u64,
    /// Means of real time that were granted: bits of `LoopStats::RT_…`.
    pub realtime: u32,
    /// Priority under SCHED_FIFO, 0 without.
    pub priority: u32,
    /// Processor the loop is pinned to, −1 without.
    pub cpu: i32,
    /// Unused, 0.
    pub reserved: u32,
}

impl LoopStats {
    /// The loop runs under SCHED_FIFO.
    pub const RT_FIFO: u32 = 1;
    /// Memory is locked.
    pub const RT_LOCKED: u32 = 1 << 1;
    /// Stack and heap are prefaulted.
    pub const RT_PREFAULTED: u32 = 1 << 2;
    /// The loop is pinned to a processor.
    pub const RT_PINNED: u32 = 1 << 3;
    /// Timer slack is 1 ns.
    pub const RT_SLACK: u32 = 1 << 4;
    /// `/dev/cpu_dma_latency` is held.
    pub const RT_LATENCY: u32 = 1 << 5;

    /// Each means of real time: its bit and its name.
    pub const REALTIME: [(u32, &'static str); 6] = [
        (LoopStats::RT_FIFO, "SCHED_FIFO"),
        (LoopStats::RT_LOCKED, "memory locked"),
        (LoopStats::RT_PREFAULTED, "prefaulted"),
        (LoopStats::RT_PINNED, "pinned to a core"),
        (LoopStats::RT_SLACK, "timer slack 1 ns"),
        (LoopStats::RT_LATENCY, "cpu_dma_latency held"),
    ];

    /// Before the first cycle.
    pub const fn new() -> LoopStats {
        LoopStats {
            lateness: Histogram::new(),
            cycle_time: Histogram::new(),
            period: Histogram::new(),
            cycles: 0,
            missed: 0,
            overruns: 0,
            ring_drops: 0,
            allocations: 0,
            commands: 0,
            refusals: 0,
            realtime: 0,
            priority: 0,
            cpu: -1,
            reserved: 0,
        }
    }
}

/// What a command asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum CommandKind {
    /// Hold a wire length, m.
    Length = 1,
    /// Hold a share of the stroke, 0 (cold) .. 1 (hot).
    Stroke = 2,
    /// Give a duty, 0..1.
    Duty = 3,
    /// Hold a tension, N.
    Force = 4,
    /// Only the sensing pulse.
    Off = 5,
    /// Clear a latched fault whose cause has gone.
    Reset = 6,
    /// Stop the driver.
    Stop = 7,
}

impl CommandKind {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The kind with this number.
    pub const fn from_code(code: u32) -> Option<CommandKind> {
        Some(match code {
            1 => CommandKind::Length,
            2 => CommandKind::Stroke,
            3 => CommandKind::Duty,
            4 => CommandKind::Force,
            5 => CommandKind::Off,
            6 => CommandKind::Reset,
            7 => CommandKind::Stop,
            _ => return None,
        })
    }

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            CommandKind::Length => "length",
            CommandKind::Stroke => "stroke",
            CommandKind::Duty => "duty",
            CommandKind::Force => "force",
            CommandKind::Off => "off",
            CommandKind::Reset => "reset",
            CommandKind::Stop => "stop",
        }
    }

    /// Unit of its value.
    pub const fn unit(self) -> &'static str {
        match self {
            CommandKind::Length => "m",
            CommandKind::Force => "N",
            _ => "",
        }
    }
}

/// One request of a client.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Command {
    /// Who asks: process id in the upper half, a count inside that process in the lower.
    pub client: u64,
    /// Number of the request, counted by the client; the reply repeats it.
    pub sequence: u64,
    /// Number of the channel, or [`ALL_CHANNELS`] (off, reset, stop).
    pub channel: u32,
    /// What is asked for: [`CommandKind`].
    pub kind: u32,
    /// Value in SI units; 0 where the kind has none.
    pub value: f64,
    /// For how long the setpoint holds unless it is renewed, s; 0 = the channel's own default.
    pub hold_s: f64,
}

impl Command {
    /// From bytes as a client may send them: any bits at all are a command, and what it means is judged at the driver's desk.
    /// `None` where there are not as many as a command has.
    pub fn from_bytes(bytes: &[u8]) -> Option<Command> {
        Command::read_from_bytes(bytes).ok()
    }

    /// What is asked for, if this version knows it.
    pub fn kind(&self) -> Option<CommandKind> {
        CommandKind::from_code(self.kind)
    }
}

/// What became of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Outcome {
    /// The loop has it.
    Taken = 0,
    /// There is no channel of that number.
    UnknownChannel = 1,
    /// This driver does not know that kind of command.
    UnknownCommand = 2,
    /// Value or hold is NaN or infinite.
    NotFinite = 3,
    /// The value is outside `low..=high`.
    OutOfRange = 4,
    /// The hold is outside `low..=high`, s.
    HoldOutOfRange = 5,
    /// The channel is off by a latched fault: reset it first.
    Faulted = 6,
    /// The cause of the fault is still there: a reset is refused.
    CauseRemains = 7,
    /// The channel has not proved its sensors yet.
    Waiting = 8,
    /// This channel cannot do that (no force control, say).
    Unsupported = 9,
    /// Too many commands at once: try again.
    Busy = 10,
    /// The driver is stopping.
    Stopping = 11,
    /// Who asks may look but not command.
    NotPermitted = 12,
}

impl Outcome {
    /// The number that stands for it in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The outcome with this number.
    pub const fn from_code(code: u32) -> Option<Outcome> {
        Some(match code {
            0 => Outcome::Taken,
            1 => Outcome::UnknownChannel,
            2 => Outcome::UnknownCommand,
            3 => Outcome::NotFinite,
            4 => Outcome::OutOfRange,
            5 => Outcome::HoldOutOfRange,
            6 => Outcome::Faulted,
            7 => Outcome::CauseRemains,
            8 => Outcome::Waiting,
            9 => Outcome::Unsupported,
            10 => Outcome::Busy,
            11 => Outcome::Stopping,
            12 => Outcome::NotPermitted,
            _ => return None,
        })
    }
}

/// The driver's answer to a [`Command`].
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct Reply {
    /// Number of the request this answers.
    pub sequence: u64,
    /// What became of it: [`Outcome`].
    pub outcome: u32,
    /// The fault in the way: [`Fault`] or 0.
    pub fault: u32,
    /// Number of the channel this is about.
    pub channel: u32,
    /// Unused, 0.
    pub reserved: u32,
    /// The value as taken, in the command's unit.
    pub value: f64,
    /// Smallest value or hold that would have been taken; NaN where it does not matter.
    pub low: f64,
    /// Largest value or hold that would have been taken; NaN where it does not matter.
    pub high: f64,
    /// The lease as granted, s; 0 where there is none.
    pub hold_s: f64,
}

impl Reply {
    /// The command was taken, with this lease, s.
    pub fn taken(command: &Command, hold_s: f64) -> Reply {
        Reply {
            sequence: command.sequence,
            outcome: Outcome::Taken.code(),
            fault: 0,
            channel: command.channel,
            reserved: 0,
            value: command.value,
            low: f64::NAN,
            high: f64::NAN,
            hold_s,
        }
    }

    /// The command was refused.
    pub fn refused(command: &Command, outcome: Outcome) -> Reply {
        Reply { outcome: outcome.code(), ..Reply::taken(command, 0.0) }
    }

    /// With the range that would have been taken.
    pub fn range(self, low: f64, high: f64) -> Reply {
        Reply { low, high, ..self }
    }

    /// With the fault in the way.
    pub fn because(self, fault: Fault) -> Reply {
        Reply { fault: fault.code(), ..self }
    }
}

/// Header of one batch of the stream; its payload is the channels of each cycle, one cycle after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[repr(C)]
pub struct BatchHeader {
    /// Cycles in this batch.
    pub cycles: u32,
    /// Channels of each.
    pub channels: u32,
    /// The cycles; [`BatchHeader::cycles`] of them are there.
    pub cycle: [CycleHeader; MAX_BATCH],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_of_protocol_2() {
        // A change here is a change of the protocol: raise PROTOCOL with it.
        assert_eq!(PROTOCOL, 2);
        assert_eq!(size_of::<ChannelState>(), 168);
        assert_eq!(size_of::<Snapshot>(), 32 + 168 * MAX_CHANNELS);
        assert_eq!(size_of::<ChannelInfo>(), 144);
        assert_eq!(size_of::<Info>(), 8 + 64 + 24 + 144 * MAX_CHANNELS);
        assert_eq!(size_of::<Command>(), 40);
        assert_eq!(size_of::<Reply>(), 56);
        assert_eq!(size_of::<BatchHeader>(), 8 + 24 * MAX_BATCH);
    }

    #[test]
    fn parts_stand_in_the_order_of_the_bytes_and_under_their_names() {
        let state =
            ChannelState::from_parts(&std::array::from_fn(|i| i as f64 + 0.5), &std::array::from_fn(|i| i as u32));
        let (floats, codes) = state.parts();
        assert_eq!(ChannelState::from_parts(&floats, &codes), state);
        let text = format!("{state:?}");
        let names = ChannelState::FLOATS.iter().map(|(name, _)| *name).chain(ChannelState::CODES);
        let values = floats.iter().map(|v| format!("{v:?}")).chain(codes.iter().map(|v| v.to_string()));
        let told: Vec<String> = names.zip(values).map(|(name, value)| format!("{name}: {value}")).collect();
        assert_eq!(text, format!("ChannelState {{ {} }}", told.join(", ")), "Debug tells of the fields in their order");
        assert_eq!(size_of::<ChannelState>(), 8 * floats.len() + 4 * codes.len(), "without holes");
    }

    #[test]
    fn codes_survive_the_way_there_and_back() {
        for code in 0..64 {
            assert!(Mode::from_code(code).is_none_or(|m| m.code() == code));
            assert!(CommandKind::from_code(code).is_none_or(|k| k.code() == code));
            assert!(Outcome::from_code(code).is_none_or(|o| o.code() == code));
            if let Some(kind) = CommandKind::from_code(code) {
                let state = ChannelState { order: ChannelState::order_code(kind, 8), ..ChannelState::UNKNOWN };
                assert_eq!(state.order(), Some((kind, 8)));
            }
        }
        assert_eq!((0..64).filter(|c| Mode::from_code(*c).is_some()).count(), 7);
        assert_eq!((0..64).filter(|c| CommandKind::from_code(*c).is_some()).count(), 7);
        assert_eq!((0..64).filter(|c| Outcome::from_code(*c).is_some()).count(), 13);
    }

    #[test]
    fn names_are_kept_whole_or_refused() {
        assert_eq!(Name::new("front_left_coxa").unwrap().as_str(), "front_left_coxa");
        assert_eq!(Name::new(&"x".repeat(64)).unwrap().as_str().len(), 64);
        for bad in ["", &"x".repeat(65), "a\0b"] {
            assert!(Name::new(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn stroke_and_length_are_each_others_inverse() {
        let c = ChannelInfo { hot_length_m: 0.160, cold_length_m: 0.166, ..ChannelInfo::EMPTY };
        assert!((c.length_at_stroke(0.4) - 0.1636).abs() < 1e-12);
        assert!((c.stroke_at_length(c.length_at_stroke(0.4)) - 0.4).abs() < 1e-9);
        assert!(ChannelInfo::EMPTY.stroke_at_length(0.16).is_nan());
    }

    #[test]
    fn a_snapshot_never_claims_more_channels_than_fit() {
        assert_eq!(Snapshot::new(1000).channels().len(), MAX_CHANNELS);
        let mut foreign = Snapshot::new(3);
        foreign.channels = u32::MAX;
        assert_eq!(foreign.channels().len(), MAX_CHANNELS);
        let mut copy = Snapshot::new(0);
        copy.copy_from(&foreign);
        assert_eq!(copy.channels().len(), MAX_CHANNELS);
    }

    #[test]
    fn a_rig_has_a_proper_name_and_at_least_one_channel() {
        let one = [ChannelInfo::EMPTY];
        assert!(Info::new("bench", 1000.0, &one).is_ok());
        assert!(matches!(Info::new("be nch", 1000.0, &one), Err(Error::RigName { .. })));
        assert!(matches!(Info::new("bench", 1000.0, &[]), Err(Error::Channels { found: 0 })));
        assert!(matches!(Info::new("bench", 1000.0, &[ChannelInfo::EMPTY; 65]), Err(Error::Channels { found: 65 })));
    }
}
