//! The words of the control laws and estimators, and which keys each law takes.
//!
//! Written from the tables in `control/src/laws/mod.rs` and `control/src/estimators/mod.rs`, which own them: do not edit.
//! `SINEW_BLESS=1 cargo test -p sinew-control --test tables` writes it anew.

/// The control law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Algorithm {
    /// Sliding mode along the stopping distance, in the wire's estimated state.
    TimeOptimal,
    /// Sliding mode on a critically damped second-order surface, in the wire's estimated state.
    SlidingMode,
    /// The same surface on the observed derivatives of the length: the thesis' law as it stands, for comparison.
    SlidingModePlain,
    /// Sliding mode on a first-order surface, switched.
    SlidingModeFirstOrder,
    /// Sliding mode on a first-order surface, in the wire's estimated state.
    SlidingModeFirstOrderEquivalent,
    /// On and off with a band.
    Relay,
    /// Proportional-integral with anti-windup.
    Pi,
    /// Proportional-integral-derivative with anti-windup.
    Pid,
    /// Input–output linearisation with the estimated slope ∂ξ/∂T.
    InputOutputLinearised,
    /// Input–output linearisation with a constant slope.
    InputOutputLinearisedConstant,
    /// Robust servo on the velocity linearisation with static gains.
    VelocityServo,
    /// Robust servo on the velocity linearisation with scheduled gains.
    VelocityServoScheduled,
}

#[rustfmt::skip]
impl Algorithm {
    /// Every one with its word in the rig file.
    pub const ALL: [(&'static str, Algorithm); 12] = [
        ("time_optimal", Algorithm::TimeOptimal),
        ("sliding_mode", Algorithm::SlidingMode),
        ("sliding_mode_plain", Algorithm::SlidingModePlain),
        ("sliding_mode_first_order", Algorithm::SlidingModeFirstOrder),
        ("sliding_mode_first_order_equivalent", Algorithm::SlidingModeFirstOrderEquivalent),
        ("relay", Algorithm::Relay),
        ("pi", Algorithm::Pi),
        ("pid", Algorithm::Pid),
        ("input_output_linearised", Algorithm::InputOutputLinearised),
        ("input_output_linearised_constant", Algorithm::InputOutputLinearisedConstant),
        ("velocity_servo", Algorithm::VelocityServo),
        ("velocity_servo_scheduled", Algorithm::VelocityServoScheduled),
    ];

    pub(crate) const WORDS: [&'static str; 12] = [
        "time_optimal",
        "sliding_mode",
        "sliding_mode_plain",
        "sliding_mode_first_order",
        "sliding_mode_first_order_equivalent",
        "relay",
        "pi",
        "pid",
        "input_output_linearised",
        "input_output_linearised_constant",
        "velocity_servo",
        "velocity_servo_scheduled",
    ];

    /// Its word in the rig file.
    pub fn word(self) -> &'static str {
        Algorithm::WORDS[self as usize]
    }
}

/// Keys of `[channel.control]` that only some laws take, and those.
#[rustfmt::skip]
pub(crate) const KEYS_OF_LAWS: [(&str, &[Algorithm]); 6] = [
    ("lambda_per_s", &[
        Algorithm::TimeOptimal,
        Algorithm::SlidingMode,
        Algorithm::SlidingModePlain,
        Algorithm::SlidingModeFirstOrder,
        Algorithm::SlidingModeFirstOrderEquivalent,
        Algorithm::InputOutputLinearised,
        Algorithm::InputOutputLinearisedConstant,
        Algorithm::VelocityServo,
        Algorithm::VelocityServoScheduled,
    ]),
    ("heat_loss_feedforward", &[
        Algorithm::Pi,
        Algorithm::Pid,
        Algorithm::InputOutputLinearised,
        Algorithm::InputOutputLinearisedConstant,
    ]),
    ("pi_proportional_per_mm", &[
        Algorithm::Pi,
        Algorithm::Pid,
    ]),
    ("pi_integral_per_mm_s", &[
        Algorithm::Pi,
        Algorithm::Pid,
    ]),
    ("pid_derivative_s_per_mm", &[
        Algorithm::Pid,
    ]),
    ("relay_band_mm", &[
        Algorithm::Relay,
    ]),
];

/// What the wire's temperature and phase are estimated by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// Length, resistance, power and model weighed together.
    Fused,
    /// Enthalpy from the power, phase from the length.
    Enthalpy,
    /// The thesis' linear state estimator with constant gains, for comparison.
    Luenberger,
    /// The same with gains scheduled by the slope of the phase.
    LuenbergerScheduled,
}

#[rustfmt::skip]
impl Estimator {
    /// Every one with its word in the rig file.
    pub const ALL: [(&'static str, Estimator); 4] = [
        ("fused", Estimator::Fused),
        ("enthalpy", Estimator::Enthalpy),
        ("luenberger", Estimator::Luenberger),
        ("luenberger_scheduled", Estimator::LuenbergerScheduled),
    ];

    pub(crate) const WORDS: [&'static str; 4] = [
        "fused",
        "enthalpy",
        "luenberger",
        "luenberger_scheduled",
    ];

    /// Its word in the rig file.
    pub fn word(self) -> &'static str {
        Estimator::WORDS[self as usize]
    }
}
