//! What a rig file says, in SI: the types everything else in the project reads.

use std::collections::BTreeMap;

use sinew_physics::{Load, WireModel};

pub(crate) use crate::generated::KEYS_OF_LAWS;
pub use crate::generated::{Algorithm, Estimator};
use crate::parameters::Prior;

/// Most channels a rig can have.
pub const MAX_CHANNELS: usize = 64;
/// Longest name of a channel, in bytes.
pub const MAX_CHANNEL_NAME: usize = 32;
/// Longest name of a rig, in bytes.
pub const MAX_RIG_NAME: usize = 48;
/// Longest name of a device or file in a rig file, in bytes.
pub const MAX_PATH: usize = 255;
/// Longest name of a Unix group, in bytes.
pub const MAX_GROUP_NAME: usize = 32;
/// Slowest rate the driver runs a rig at, in Hz.
pub const MIN_DRIVEN_RATE_HZ: f64 = 10.0;
/// Fastest rate the driver runs a rig at, in Hz.
pub const MAX_DRIVEN_RATE_HZ: f64 = 20_000.0;

/// A whole rig: what a rig file says, with every default filled in.
///
/// Comes from [`Rig::load`](crate::Rig::load) or [`Rig::parse`](crate::Rig::parse); fields may be changed and
/// written back with [`Rig::to_toml`](crate::Rig::to_toml). Two rigs are equal when they say the same,
/// whatever the text they came from looks like.
#[derive(Debug, Clone)]
pub struct Rig {
    /// Name of the rig; the driver's services are found by it.
    pub name: String,
    /// Rate of PWM, sampling and control, in Hz.
    pub rate_hz: f64,
    /// Ambient temperature T_∞, in °C; every channel's model carries it too.
    pub ambient_c: f64,
    /// How hard the driver tries for real time.
    pub realtime: Realtime,
    /// Which other users may look and command.
    pub access: Access,
    /// The wires, in the order of the file; at most [`MAX_CHANNELS`].
    pub channels: Vec<Channel>,
    /// The joints that pairs of channels turn, in the order of the file.
    pub joints: Vec<Joint>,
    /// How a recording's foreign columns are named and scaled.
    pub columns: ColumnMap,
    /// What powers and measures the wires.
    pub backend: Backend,
    /// What is kept for the moment something breaks.
    pub black_box: BlackBox,
    /// The simulated backend.
    pub simulation: Simulation,
    /// The tensile testing machine a wire may be mounted in.
    pub machine: Machine,
    pub(crate) source: Source,
}

impl PartialEq for Rig {
    fn eq(&self, other: &Rig) -> bool {
        // Taken apart so that a new field cannot be forgotten here.
        let Rig {
            name,
            rate_hz,
            ambient_c,
            realtime,
            access,
            channels,
            joints,
            columns,
            backend,
            black_box,
            simulation,
            machine,
            source: _,
        } = self;
        *name == other.name
            && *rate_hz == other.rate_hz
            && *ambient_c == other.ambient_c
            && *realtime == other.realtime
            && *access == other.access
            && *channels == other.channels
            && *joints == other.joints
            && *columns == other.columns
            && *backend == other.backend
            && *black_box == other.black_box
            && *simulation == other.simulation
            && *machine == other.machine
    }
}

/// The text a rig came from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Source {
    pub file: String,
    pub text: String,
}

/// How hard the driver tries for real time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Realtime {
    /// What a refusal by the system means.
    pub mode: RealtimeMode,
    /// SCHED_FIFO priority of the loop, 1 to 98.
    pub priority: u32,
    /// Core the loop is pinned to; `None` = the driver chooses.
    pub cpu: Option<u32>,
}

/// Which users besides the driver's own may do what.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Access {
    /// Group whose members may command; `None` = nobody's.
    pub command_group: Option<String>,
    /// Group whose members may look, or [`Access::EVERYONE`]; `None` = those who may command.
    pub read_group: Option<String>,
}

impl Access {
    /// The word that lets every user look.
    pub const EVERYONE: &str = "everyone";

    /// Whether any other user may do anything.
    pub fn is_open(&self) -> bool {
        self.command_group.is_some() || self.read_group.is_some()
    }
}

/// What a refusal of real-time scheduling by the system means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RealtimeMode {
    /// Do not ask for any of it.
    Off,
    /// Ask, say what was refused, go on.
    Try,
    /// Ask, and refuse to start without.
    Strict,
}

/// One wire with its drive, load, limits and control.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name, unique within the rig.
    pub name: String,
    /// Wire, taps, drive, load, initial state and the effects beyond the reference model.
    pub model: WireModel,
    /// Whether an offset of the measured position means anything.
    pub position_zero: PositionZero,
    /// `[channel.sensors.noise]`: RMS by the name of a recording's column, in the column's unit; above 0.
    pub noise: BTreeMap<String, f64>,
    /// The rig file's own `[channel.priors]`; for those in force use [`Channel::priors_in_force`].
    pub priors: BTreeMap<String, Prior>,
    /// The converter that measures voltages and current.
    pub adc: Adc,
    /// Which channel of a serial front-end it is; `None` = its place in the rig.
    pub front_end_index: Option<u32>,
    /// Where it is among Linux's own outputs and inputs.
    pub linux: LinuxChannel,
    /// What the supervisor holds the channel within.
    pub limits: Limits,
    /// The controller.
    pub control: Control,
    /// Name of the channel whose wire is the neighbour of `thermal.neighbour`; `None` = a body at ambient temperature.
    /// All other effects are in the model.
    pub neighbour: Option<String>,
}

/// A joint that two channels turn against each other. Their wires have no other load.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique among joints and channels.
    pub name: String,
    /// Name of the channel whose wire turns it forward.
    pub agonist: String,
    /// Name of the channel whose wire turns it back.
    pub antagonist: String,
    /// What the wires pull at.
    pub mechanics: sinew_physics::Joint,
    /// Tension below which a wire counts as about to go slack, in N.
    pub min_tension_n: f64,
    /// Tension that is kept where the motion leaves it free, in N.
    pub tension_n: f64,
    /// Tension no wire is driven above, in N.
    pub max_tension_n: f64,
}

impl Joint {
    /// Which of the joint's two wires a channel is, 0 = agonist; `None` where it is neither.
    pub fn side(&self, channel: &str) -> Option<usize> {
        [&self.agonist, &self.antagonist].into_iter().position(|name| name == channel)
    }
}

impl Channel {
    /// The wire in the load that its stroke, limits and observers are reckoned with: its own, or, in a joint, the joint's
    /// at a tension kept at the pretension (see [`sinew_physics::Joint::nominal_load`]).
    pub fn nominal_model(&self, joint: Option<&Joint>) -> WireModel {
        let load = joint.map_or(self.model.load, |joint| joint.mechanics.nominal_load());
        WireModel { load, ..self.model.clone() }
    }

    /// Power in the on-phase with the wire at its most conductive, W: what bounds a duty of 1.
    pub fn full_power_w(&self) -> f64 {
        let drive = &self.model.drive;
        let m = &self.model.material;
        let ohm = m.martensite_resistivity_ohm_m.min(m.austenite_resistivity_ohm_m) * self.model.geometry.length_m
            / self.model.geometry.area_m2();
        let current_a = drive.supply_v / (ohm + drive.shunt_ohm + drive.switch_ohm + drive.lead_ohm);
        current_a * current_a * ohm
    }
}

/// The load of a joint's wire: the joint says where its end is.
pub(crate) const LOAD_IN_JOINT: Load = Load::ImposedPosition;

/// Whether the zero of `position_m` is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionZero {
    /// 0 is L_0.
    Known,
    /// The encoder's zero is arbitrary and may differ from recording to recording.
    Free,
}

/// How the converter is wired to the heating circuit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplingCircuit {
    /// V_3 and the shunt have inputs of their own, sampled in the on-phase; the wire's fixed end is ground.
    SeparateTaps,
    /// One input at the wire's low end, behind which switch and shunt lead to ground, is sampled twice a period (thesis,
    /// chapter 6): in the off-phase it sees the supply, in the on-phase what the current leaves on switch and shunt.
    Shared,
}

/// The analogue-to-digital converter of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adc {
    /// How it is wired.
    pub circuit: SamplingCircuit,
    /// Resolution, in bits over the range.
    pub bits: u32,
    /// Full scale of the voltages, in V: 0 to this.
    pub voltage_range_v: f64,
    /// Full scale of the current, in A: 0 to this.
    pub current_range_a: f64,
    /// Noise of a voltage sample, RMS, in V.
    pub voltage_noise_v: f64,
    /// Noise of a current sample, RMS, in A.
    pub current_noise_a: f64,
    /// Offset of the voltage samples, in V.
    pub voltage_offset_v: f64,
    /// Offset of the current samples, in A.
    pub current_offset_a: f64,
    /// Noise of the measured supply, RMS, in V.
    pub supply_noise_v: f64,
}

/// What the supervisor holds a channel within; leaving one is a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Shortest length a measurement may show, in m.
    pub min_length_m: f64,
    /// Longest length a measurement may show, in m.
    pub max_length_m: f64,
    /// Largest duty the controller may ask for, 0..1.
    pub max_duty: f64,
    /// Largest mean power into the wire, in W.
    pub max_power_w: f64,
    /// Largest current in the on-phase, in A.
    pub max_current_a: f64,
    /// Highest estimated wire temperature, in °C.
    pub max_temperature_c: f64,
    /// Current the wire bears for good, in A, rms over on- and off-phases.
    pub continuous_current_a: f64,
    /// Heat the wire may hold beyond what drains, in J: its account is full then.
    pub energy_budget_j: f64,
    /// The rate at which a full account drains, in W; in proportion where it is less full.
    pub energy_drain_w: f64,
    /// Tension, reckoned from the load, below which the wire is heated, in N; `None` = no limit.
    pub min_force_n: Option<f64>,
    /// Tension, reckoned from the load, above which it is not heated, in N; `None` = no limit.
    pub max_force_n: Option<f64>,
    /// Lease of a command that names none, in s.
    pub lease_s: f64,
    /// Longest lease a command may ask for, in s.
    pub max_lease_s: f64,
}

/// The controller of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// The control law.
    pub algorithm: Algorithm,
    /// What is believed of the wire, and how.
    pub estimator: Estimator,
    /// λ of the sliding surface, of the linearised loop or of the servo's integral, in 1/s; `None` = from the wire's heating and cooling limits.
    pub lambda_per_s: Option<f64>,
    /// Whether full power comes before the law.
    pub rapid_heating: RapidHeating,
    /// Whether the loss to the air is added to what the law asks for; `None` = as is usual with the law.
    pub heat_loss_feedforward: Option<bool>,
    /// What the length is measured by.
    pub sensing: Sensing,
    /// Duty that is always on so that there is something to measure, 0..1.
    pub minimum_duty: f64,
    /// Proportional gain of PI and PID, duty per m.
    pub pi_proportional_per_m: f64,
    /// Integral gain of PI and PID, duty per m and s.
    pub pi_integral_per_m_s: f64,
    /// Derivative gain of PID, duty per m/s.
    pub pid_derivative_s_per_m: f64,
    /// Half width of the relay's band, in m; `None` = from the wire's stroke.
    pub relay_band_m: Option<f64>,
}

impl Algorithm {
    /// Whether a key of `[channel.control]` means something with this law.
    pub fn takes(self, key: &str) -> bool {
        KEYS_OF_LAWS.iter().find(|(of_some, _)| *of_some == key).is_none_or(|(_, laws)| laws.contains(&self))
    }
}

/// Whether full power comes before the law, and what tells when to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RapidHeating {
    /// The law alone.
    Off,
    /// The estimated temperature.
    Temperature,
    /// The measured resistance.
    Resistance,
}

/// What the length is measured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensing {
    /// Two taps and the moving end: length and resistivity apart (eq. 42–44).
    Dual,
    /// The resistance of the whole wire by a calibrated line.
    Resistance,
}

/// Where a recording's columns come from, by the contract's column name; columns not listed keep their name.
pub type ColumnMap = BTreeMap<String, Column>;

/// A foreign column: value = `scale` · raw + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in the recording.
    pub column: String,
    /// Factor to the contract's unit; never 0.
    pub scale: f64,
    /// Added after scaling, in the contract's unit.
    pub offset: f64,
}

/// What powers and measures the wires: which kind, and what each kind needs to know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Backend {
    /// Which of them it is.
    pub kind: BackendKind,
    /// A front-end on a serial line.
    pub serial: SerialLine,
    /// Linux's own interfaces.
    pub linux: LinuxInterfaces,
}

/// The kinds of backend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackendKind {
    /// Simulated wires.
    Simulated,
    /// A front-end on a serial line.
    Serial,
    /// Linux's own interfaces: PWM by sysfs, converters by IIO.
    Linux,
}

/// The line to a front-end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SerialLine {
    /// The device it is on; `Some` where the kind is [`BackendKind::Serial`].
    pub port: Option<String>,
    /// Bits a second of a UART; USB takes no notice of it.
    pub baud_hz: u32,
    /// Periods without a good frame after which the front-end switches its outputs off, and the driver calls it silent.
    pub watchdog_periods: u32,
}

/// Linux's own interfaces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinuxInterfaces {
    /// The folder `sys` and `dev` are in.
    pub root: String,
    /// How the converters are read.
    pub sampling: LinuxSampling,
    /// The trigger the converters are set to; `None` = the one they have, or need none.
    pub trigger: Option<String>,
    /// What moment of a period a conversion is of.
    pub phase: LinuxPhase,
    /// How long the guard bears the driver's silence before it puts the outputs to zero, in ms.
    pub guard_ms: u32,
}

/// How converters are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinuxSampling {
    /// From `/dev/iio:deviceN`: the converter runs by itself and the newest scan is taken.
    Buffer,
    /// From `in_…_raw` or `in_…_input` in sysfs: each input is converted when it is read, within the cycle.
    Sysfs,
}

/// What moment of a period a conversion is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinuxPhase {
    /// The hardware sees to it that it is of an on-phase: a trigger from the PWM, or a sample-and-hold gated by it.
    Synchronised,
    /// Any: the newest whose voltage or current shows the on-phase is taken.
    Free,
}

/// Where a channel is among Linux's own outputs and inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxChannel {
    /// Its output, `chip/number`; `Some` where the kind is [`BackendKind::Linux`].
    pub pwm: Option<String>,
    /// Which level heats.
    pub polarity: Polarity,
    /// First tap.
    pub v1: LinuxInput,
    /// Second tap.
    pub v2: LinuxInput,
    /// Moving end.
    pub v3: LinuxInput,
    /// Current.
    pub current: LinuxInput,
    /// Supply.
    pub supply: LinuxInput,
}

/// The level of an output that heats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarity {
    /// High.
    Normal,
    /// Low.
    Inversed,
}

/// An input of a converter: value = `gain` · what the kernel makes of it, in V or A, + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxInput {
    /// `device:input`; `None` = not measured.
    pub name: Option<String>,
    /// Of the divider or shunt before it, V/V or A/V; never 0.
    pub gain: f64,
    /// Added after it, in V or A.
    pub offset: f64,
}

/// The black box: the last seconds before a fault, in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlackBox {
    /// Whether there is one.
    pub enabled: bool,
    /// Time before the fault, s.
    pub before_s: f64,
    /// Time after the fault, s.
    pub after_s: f64,
    /// How many files of a rig are kept.
    pub keep: u32,
    /// Most memory it takes, bytes.
    pub memory_bytes: u64,
}

/// The simulated backend.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Seed of all noise.
    pub seed: u64,
    /// Whether simulated time keeps to the clock.
    pub pace: Pace,
    /// Faults to play, in the order of the file.
    pub faults: Vec<SimulatedFault>,
}

/// A tensile testing machine: a cross-head that pulls a wire against a load cell, a heater amplifier, a thermal chamber
/// (thesis, chapter 8, tables 8 and 9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Rate of its own loop and of its recordings, in Hz.
    pub rate_hz: f64,
    /// How far the cross-head travels, in m.
    pub travel_m: f64,
    /// Smallest motion of the cross-head, in m.
    pub microstep_m: f64,
    /// Fastest cross-head, in m/s.
    pub max_speed_m_s: f64,
    /// Quickest change of its speed, in m/s².
    pub max_acceleration_m_s2: f64,
    /// By how much the frame gives, in m/N; known, and taken out of the measured position.
    pub compliance_m_per_n: f64,
    /// Largest force of the load cell, in N.
    pub max_force_n: f64,
    /// Conversions of the load cell a second, in Hz.
    pub force_rate_hz: f64,
    /// Noise of a conversion, RMS, in N.
    pub force_noise_n: f64,
    /// Largest elongation of a wire, as a share of its length.
    pub max_strain: f64,
    /// Largest voltage of the heater amplifier, in V.
    pub heater_supply_v: f64,
    /// Cut-off of the filter before the amplifier, in Hz.
    pub heater_cutoff_hz: f64,
    /// Step of the measured current, in A.
    pub current_step_a: f64,
    /// Noise of the measured current, RMS, in A.
    pub current_noise_a: f64,
    /// Step of the measured voltages, in V.
    pub voltage_step_v: f64,
    /// Noise of the measured voltages, RMS, in V.
    pub voltage_noise_v: f64,
    /// Coldest the chamber gets, in °C.
    pub chamber_min_c: f64,
    /// Warmest it gets, in °C.
    pub chamber_max_c: f64,
    /// Heat its elements pump, in W.
    pub chamber_power_w: f64,
    /// Time constant of the chamber left to itself, in s.
    pub chamber_time_s: f64,
    /// Noise of its thermocouple, RMS, in K.
    pub chamber_noise_k: f64,
}

/// Whether simulated time keeps to the clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// One simulated second takes one second.
    RealTime,
    /// As fast as the machine can.
    AsFastAsPossible,
}

/// A fault the simulated backend plays.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedFault {
    /// Index of the channel it strikes; `None` = all.
    pub channel: Option<usize>,
    /// What breaks.
    pub kind: FaultKind,
    /// When it begins, in s of simulated time.
    pub start_s: f64,
    /// When it ends, in s of simulated time; infinite = never.
    pub end_s: f64,
    /// Its size in the unit of its kind, see [`FaultKind::value_key`]; `None` = the kind's default.
    pub value: Option<f64>,
}

impl SimulatedFault {
    /// Whether it acts at `time_s`.
    pub fn acts_at(&self, time_s: f64) -> bool {
        self.start_s <= time_s && time_s < self.end_s
    }

    /// Its size in the unit of its kind, the kind's default where the file gives none; 0 where the kind has no size.
    pub fn size(&self) -> f64 {
        self.value.or(self.kind.value_range().map(|(_, _, default)| default)).unwrap_or(0.0)
    }
}

/// What breaks in a simulated fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// No current flows.
    OpenWire,
    /// The wire is bridged by `value` Ω.
    ShortedWire,
    /// Tap `value` (1, 2 or 3 for the moving end) touches nothing.
    ProbeLost,
    /// `value` Ω at the moving end, inside V_3.
    ContactResistance,
    /// Tap `value` (1 or 2) no longer slides: it sticks to its place on the wire and moves with it.
    ProbeStuck,
    /// The supply falls to the fraction `value` of itself.
    SupplyDip,
    /// The supply rises to `value` times itself.
    SupplyHigh,
    /// The output stage conducts through the whole period, whatever its duty.
    StageOn,
    /// The output stage conducts only through `value` Ω more; by default so many that it does not conduct.
    StageWeak,
    /// The load stands still, however the wire pulls; not in a joint.
    Jammed,
    /// Every sample repeats the last one.
    AdcStuck,
    /// Every sample is at full scale.
    AdcSaturated,
    /// Every sample is NaN.
    AdcNan,
    /// The backend's exchange fails.
    BackendError,
}

impl FaultKind {
    /// Every kind with its word in the rig file.
    pub const ALL: [(&'static str, FaultKind); 14] = [
        ("open_wire", FaultKind::OpenWire),
        ("shorted_wire", FaultKind::ShortedWire),
        ("probe_lost", FaultKind::ProbeLost),
        ("contact_resistance", FaultKind::ContactResistance),
        ("probe_stuck", FaultKind::ProbeStuck),
        ("supply_dip", FaultKind::SupplyDip),
        ("supply_high", FaultKind::SupplyHigh),
        ("stage_on", FaultKind::StageOn),
        ("stage_weak", FaultKind::StageWeak),
        ("jammed", FaultKind::Jammed),
        ("adc_stuck", FaultKind::AdcStuck),
        ("adc_saturated", FaultKind::AdcSaturated),
        ("adc_nan", FaultKind::AdcNan),
        ("backend_error", FaultKind::BackendError),
    ];

    /// What `value` means for this kind, in words; `None` where it has no size.
    pub fn value_key(self) -> Option<&'static str> {
        match self {
            FaultKind::ShortedWire => Some("Ω that bridge the wire"),
            FaultKind::ProbeLost => Some("the tap: 1, 2, or 3 for the moving end"),
            FaultKind::ContactResistance => Some("Ω inside V_3"),
            FaultKind::ProbeStuck => Some("the tap: 1 or 2"),
            FaultKind::SupplyDip => Some("fraction of the supply that is left"),
            FaultKind::SupplyHigh => Some("the supply as a multiple of itself"),
            FaultKind::StageWeak => Some("Ω more in the output stage"),
            _ => None,
        }
    }

    /// Least, largest and default `value` of this kind; `None` where it has no size.
    pub fn value_range(self) -> Option<(f64, f64, f64)> {
        match self {
            FaultKind::ShortedWire => Some((0.0, 1000.0, 0.05)),
            FaultKind::ProbeLost => Some((1.0, 3.0, 2.0)),
            FaultKind::ContactResistance => Some((0.0, 1000.0, 0.5)),
            FaultKind::ProbeStuck => Some((1.0, 2.0, 2.0)),
            FaultKind::SupplyDip => Some((0.0, 1.0, 0.5)),
            FaultKind::SupplyHigh => Some((1.0, 3.0, 1.4)),
            FaultKind::StageWeak => Some((0.0, 1e6, 1e6)),
            _ => None,
        }
    }
}
