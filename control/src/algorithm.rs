//! Which law runs on a channel, with which numbers; chosen once, dispatched without indirection.

use crate::demand::Range;
use crate::laws::{RapidHeating, Schedule};
use crate::wire_map::WireMap;
use crate::{
    Controller, Coupling, Demand, InputOutputLinearised, Law, Modulation, Pid, PidGains, Priming, Relay, SlidingMode1,
    SlidingMode2, Slope, TimeOptimal, VelocityServo, lambda,
};
use sinew_physics::WireModel;

/// The laws to choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlgorithmKind {
    /// Second-order sliding mode along the stopping distance.
    TimeOptimal,
    /// Second-order surface, eq. 70's equivalent control (the default).
    SlidingMode2,
    /// Second-order surface, the thesis' switching law on measured derivatives.
    SlidingMode2Plain,
    /// First-order surface, switched.
    SlidingMode1,
    /// First-order surface with its equivalent control.
    SlidingMode1Equivalent,
    /// On and off with a band.
    Relay,
    /// Proportional-integral with anti-windup.
    Pi,
    /// The same with a filtered derivative of the length.
    Pid,
    /// Input–output linearisation, ∂ξ/∂T as estimated.
    InputOutputLinearised,
    /// Input–output linearisation, ∂ξ/∂T constant.
    InputOutputLinearisedConstant,
    /// Robust servo on the velocity linearisation, gains for one ∂ξ/∂T.
    VelocityServo,
    /// The same with gains scheduled over ∂ξ/∂T.
    VelocityServoScheduled,
}

impl AlgorithmKind {
    /// Every law.
    pub const ALL: [AlgorithmKind; 12] = [
        AlgorithmKind::TimeOptimal,
        AlgorithmKind::SlidingMode2,
        AlgorithmKind::SlidingMode2Plain,
        AlgorithmKind::SlidingMode1,
        AlgorithmKind::SlidingMode1Equivalent,
        AlgorithmKind::Relay,
        AlgorithmKind::Pi,
        AlgorithmKind::Pid,
        AlgorithmKind::InputOutputLinearised,
        AlgorithmKind::InputOutputLinearisedConstant,
        AlgorithmKind::VelocityServo,
        AlgorithmKind::VelocityServoScheduled,
    ];

    /// Whether it is blind without an estimate of the wire's state; the others make do with the length.
    pub fn needs_estimate(self) -> bool {
        matches!(
            self,
            AlgorithmKind::TimeOptimal
                | AlgorithmKind::InputOutputLinearised
                | AlgorithmKind::InputOutputLinearisedConstant
                | AlgorithmKind::VelocityServo
                | AlgorithmKind::VelocityServoScheduled
        )
    }

    /// Its word in the rig file.
    pub fn word(self) -> &'static str {
        match self {
            AlgorithmKind::TimeOptimal => "time_optimal",
            AlgorithmKind::SlidingMode2 => "sliding_mode",
            AlgorithmKind::SlidingMode2Plain => "sliding_mode_plain",
            AlgorithmKind::SlidingMode1 => "sliding_mode_first_order",
            AlgorithmKind::SlidingMode1Equivalent => "sliding_mode_first_order_equivalent",
            AlgorithmKind::Relay => "relay",
            AlgorithmKind::Pi => "pi",
            AlgorithmKind::Pid => "pid",
            AlgorithmKind::InputOutputLinearised => "input_output_linearised",
            AlgorithmKind::InputOutputLinearisedConstant => "input_output_linearised_constant",
            AlgorithmKind::VelocityServo => "velocity_servo",
            AlgorithmKind::VelocityServoScheduled => "velocity_servo_scheduled",
        }
    }
}

/// Numbers of a channel's law. `None` = from the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which law.
    pub kind: AlgorithmKind,
    /// Bandwidth λ of a sliding surface or of the linearised loop, in 1/s; for the velocity servo, the rate at which an error of
    /// the whole stroke is integrated to full power. What is not within 0.001 and 10 000 counts as none.
    pub lambda_per_s: Option<f64>,
    /// Least duty: the sensing pulse.
    pub minimum_duty: f64,
    /// Most duty.
    pub maximum_duty: f64,
    /// Half width of the band around the reference in which the wire is left standing, in m; default 0.25 % of the stroke.
    pub hold_band_m: Option<f64>,
    /// When power is switched; the plain sliding modes and the relay always switch whole periods, PI and PID never do.
    pub modulation: Modulation,
    /// Gains of PI and PID; PI takes no notice of the derivative's.
    pub pid: Option<PidGains>,
    /// Half width of the relay's band, in m; default 1 % of the stroke.
    pub relay_band_m: Option<f64>,
    /// Whether the estimated loss to the air is added to what the law asks for: with PI and PID, by default not, and with
    /// input–output linearisation, whose offset β it is, by default yes.
    pub heat_loss_feedforward: Option<bool>,
    /// Whether full power comes before the law, and by what it knows when to stop; `None` = the law alone.
    pub rapid_heating: Option<Priming>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            kind: AlgorithmKind::TimeOptimal,
            lambda_per_s: None,
            minimum_duty: 0.02,
            maximum_duty: 1.0,
            hold_band_m: None,
            modulation: Modulation::Switched,
            pid: None,
            relay_band_m: None,
            heat_loss_feedforward: None,
            rapid_heating: None,
        }
    }
}

/// A channel's law, and the rapid heating that may come before it.
#[derive(Debug, Clone)]
pub struct Algorithm {
    law: AnyLaw,
    rapid_heating: Option<RapidHeating>,
    maximum_duty: f64,
    /// Whether the last duty was rapid heating's.
    priming: bool,
}

// Lies by value in the channel's struct, where the loop touches it: a box would cost more than the bytes.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum AnyLaw {
    TimeOptimal(TimeOptimal),
    SlidingMode2(SlidingMode2),
    SlidingMode1(SlidingMode1),
    Relay(Relay),
    Pid(Pid),
    InputOutputLinearised(InputOutputLinearised),
    VelocityServo(VelocityServo),
}

/// Does with the law what is said of it, whichever it is.
macro_rules! with {
    ($law:ident in $algorithm:expr => $what:expr) => {
        match $algorithm {
            AnyLaw::TimeOptimal($law) => $what,
            AnyLaw::SlidingMode2($law) => $what,
            AnyLaw::SlidingMode1($law) => $what,
            AnyLaw::Relay($law) => $what,
            AnyLaw::Pid($law) => $what,
            AnyLaw::InputOutputLinearised($law) => $what,
            AnyLaw::VelocityServo($law) => $what,
        }
    };
}

impl Algorithm {
    /// The law for a wire.
    pub fn new(model: &WireModel, settings: &Settings) -> Algorithm {
        let map = WireMap::new(model);
        let range = Range::new(settings.minimum_duty, settings.maximum_duty, settings.modulation);
        let limits = lambda::limits(&map, map.full_power * range.maximum);
        let lambda = match settings.lambda_per_s {
            Some(value) if (1e-3..=1e4).contains(&value) => value,
            _ => limits.value,
        };
        let stroke = lambda::speeds(&map, map.full_power).stroke;
        let band = |given: Option<f64>, share: f64| match given {
            Some(value) if value >= 0.0 && value.is_finite() => value,
            _ => share * stroke,
        };
        let fed_forward = |by_default: bool| settings.heat_loss_feedforward.unwrap_or(by_default);
        let second_order = |law| {
            let hold = band(settings.hold_band_m, 0.0025);
            AnyLaw::SlidingMode2(SlidingMode2::new(map, lambda, law, hold, range))
        };
        let first_order = |law| AnyLaw::SlidingMode1(SlidingMode1::new(map, lambda, law, stroke, range));
        let linearised = |slope| {
            AnyLaw::InputOutputLinearised(InputOutputLinearised::new(map, lambda, slope, fed_forward(true), range))
        };
        let gains = settings.pid.unwrap_or_else(|| PidGains::for_stroke(stroke));
        let pid = |gains| AnyLaw::Pid(Pid::new(gains, fed_forward(false), range));
        let integral = lambda * map.full_power * range.maximum / stroke;
        let servo = |schedule, coupling| {
            AnyLaw::VelocityServo(VelocityServo::new(model, map, schedule, coupling, integral, range))
        };
        let law = match settings.kind {
            AlgorithmKind::TimeOptimal => {
                AnyLaw::TimeOptimal(TimeOptimal::new(map, lambda, band(settings.hold_band_m, 0.0025), range))
            }
            AlgorithmKind::SlidingMode2 => second_order(Law::Equivalent),
            AlgorithmKind::SlidingMode2Plain => second_order(Law::Plain),
            AlgorithmKind::SlidingMode1 => first_order(Law::Plain),
            AlgorithmKind::SlidingMode1Equivalent => first_order(Law::Equivalent),
            AlgorithmKind::Relay => AnyLaw::Relay(Relay::new(band(settings.relay_band_m, 0.01), range)),
            AlgorithmKind::Pi => pid(PidGains { derivative_s_per_m: 0.0, ..gains }),
            AlgorithmKind::Pid => pid(gains),
            AlgorithmKind::InputOutputLinearised => linearised(Slope::Estimated),
            AlgorithmKind::InputOutputLinearisedConstant => linearised(Slope::Constant),
            AlgorithmKind::VelocityServo => servo(Schedule::Static, Coupling::Thermal),
            AlgorithmKind::VelocityServoScheduled => servo(Schedule::Scheduled, Coupling::Full),
        };
        Algorithm {
            law,
            rapid_heating: settings.rapid_heating.map(|by| RapidHeating::new(&map, by, stroke)),
            maximum_duty: range.maximum,
            priming: false,
        }
    }

    /// Whether the last duty was not the law's but rapid heating's.
    pub fn is_priming(&self) -> bool {
        self.priming
    }
}

impl Controller for Algorithm {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.priming = demand.is_usable() && self.rapid_heating.as_mut().is_some_and(|rapid| rapid.acts(demand));
        // Asked in any case: a law that takes over has to have seen how the wire came there.
        let duty = with!(law in &mut self.law => law.duty(demand));
        if self.priming { self.maximum_duty } else { duty }
    }

    fn reset(&mut self) {
        self.priming = false;
        if let Some(rapid) = &mut self.rapid_heating {
            rapid.reset();
        }
        with!(law in &mut self.law => law.reset());
    }

    fn surface(&self) -> f64 {
        if self.priming { 0.0 } else { with!(law in &self.law => law.surface()) }
    }

    fn is_blind(&self) -> bool {
        !self.priming && with!(law in &self.law => law.is_blind())
    }
}
