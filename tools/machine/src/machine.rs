//! The interface of every testing machine, real or simulated: one exchange a period.

use sinew_rig::Machine as Spec;

/// Where the cross-head is to go. It accelerates and stops by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Travel {
    /// To this elongation of the wire, in m, at this speed, in m/s.
    To {
        /// Elongation L − L_0, the frame's own give taken into account.
        position_m: f64,
        /// Speed, above 0.
        speed_m_s: f64,
    },
    /// At this speed until commanded otherwise, in m/s, positive pulling the wire longer.
    At(f64),
    /// Wherever the wire's own load pulls it: of a rig, which has no cross-head. A cross-head stands.
    Left,
}

/// What the heater amplifier holds by its own feedback on current and voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heater {
    /// Nothing flows.
    Off,
    /// A voltage over the wire, in V.
    Voltage(f64),
    /// A current, in A.
    Current(f64),
    /// A power into the wire, in W.
    Power(f64),
    /// A share of the time that a supply is switched on, 0 to 1: of a rig, which switches one.
    Duty(f64),
    /// Whatever brings the wire to this elongation, in m: of a rig, whose driver has a law of its own.
    Length(f64),
}

/// What the machine is to do for the next period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// The cross-head.
    pub travel: Travel,
    /// The amplifier.
    pub heater: Heater,
    /// Air in the chamber, in °C; `None` = left to itself.
    pub chamber_c: Option<f64>,
}

impl Order {
    /// Nothing heats, nothing moves.
    pub const REST: Order = Order { travel: Travel::At(0.0), heater: Heater::Off, chamber_c: None };
}

/// What the machine measured in a period, at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// End of the period, s from the start.
    pub time_s: f64,
    /// Elongation L − L_0 of the wire, in m: the cross-head's travel less what the frame gives.
    pub position_m: f64,
    /// Travel of the cross-head by its counted steps, in m.
    pub crosshead_m: f64,
    /// The load cell's last conversion, in N.
    pub force_n: f64,
    /// Whether that conversion is of this period.
    pub force_is_new: bool,
    /// Current of the period, RMS, in A: what heats as the current did.
    pub current_a: f64,
    /// Voltage over the wire, RMS, in V.
    pub voltage_v: f64,
    /// Voltages of the two taps, RMS, in V, where the wire has some.
    pub taps_v: Option<[f64; 2]>,
    /// The thermocouple's last conversion, °C.
    pub chamber_c: f64,
    /// Whether that conversion is of this period.
    pub chamber_is_new: bool,
}

impl Reading {
    /// Mean power of the period into the wire, in W.
    pub fn power_w(&self) -> f64 {
        self.voltage_v * self.current_a
    }

    /// Resistance of the wire, in Ω; NaN where too little current flows to tell: `least_a`.
    pub fn resistance_ohm(&self, least_a: f64) -> f64 {
        if self.current_a > least_a { self.voltage_v / self.current_a } else { f64::NAN }
    }
}

/// Why a machine does not go on.
#[derive(Debug, Clone, PartialEq)]
pub enum MachineError {
    /// The wire or the frame it is mounted in cannot be simulated.
    Wire(sinew_physics::Error),
    /// The machine does not answer, or not as it should; with the reason in words.
    Lost(String),
    /// A running rig has ended it: a fault, a refusal, or its driver is gone.
    Ended {
        /// What happened.
        why: String,
        /// What to do.
        remedy: String,
    },
}

impl std::fmt::Display for MachineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MachineError::Wire(error) => write!(f, "the wire in the machine: {error}"),
            MachineError::Lost(why) => write!(f, "the machine does not answer: {why}"),
            MachineError::Ended { why, .. } => write!(f, "{why}"),
        }
    }
}

impl std::error::Error for MachineError {}

/// A tensile testing machine with a wire in it.
pub trait Machine {
    /// Its ranges and the noise of its sensors.
    fn spec(&self) -> &Spec;

    /// Whether wire and machine are computed.
    fn is_simulated(&self) -> bool;

    /// Carries an order out for one period, 1/[`Spec::rate_hz`], and gives what was measured.
    ///
    /// # Errors
    /// [`MachineError::Lost`] where the machine does not answer; it has to switch its outputs off by itself then.
    fn exchange(&mut self, order: &Order) -> Result<Reading, MachineError>;
}

/// How old the force is that an order answers to, on average and with the order's own period, s.
pub(crate) fn delay_s(spec: &sinew_rig::Machine) -> f64 {
    0.5 / spec.force_rate_hz + 1.5 / spec.rate_hz
}
