//! The words of the control laws, of a wire and of a joint, and of the estimators, and which keys each law takes.
//!
//! Written from the tables in `control/src/laws/mod.rs`, `control/src/joint/mod.rs` and `control/src/estimators/mod.rs`, which own
//! them: do not edit.
//! `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::` writes it anew.

use crate::declare::rows::*;

#[rustfmt::skip]
laws! {
    /// The control law of a wire.
    pub enum Algorithm, default TimeOptimal;
    /// Sliding mode along the stopping distance, in the wire's estimated state.
    TimeOptimal = "time_optimal", takes ["lambda_per_s"];
    /// Sliding mode on a critically damped second-order surface, in the wire's estimated state.
    SlidingMode = "sliding_mode", takes ["lambda_per_s"];
    /// The same surface on the observed derivatives of the length: the thesis' law as it stands, for comparison.
    SlidingModePlain = "sliding_mode_plain", takes ["lambda_per_s"];
    /// Sliding mode on a first-order surface, switched.
    SlidingModeFirstOrder = "sliding_mode_first_order", takes ["lambda_per_s"];
    /// Sliding mode on a first-order surface, in the wire's estimated state.
    SlidingModeFirstOrderEquivalent = "sliding_mode_first_order_equivalent", takes ["lambda_per_s"];
    /// On and off with a band.
    Relay = "relay", takes ["relay_band_mm"];
    /// Proportional-integral with anti-windup.
    Pi = "pi", takes ["heat_loss_feedforward", "pi_proportional_per_mm", "pi_integral_per_mm_s"];
    /// Proportional-integral-derivative with anti-windup.
    Pid = "pid", takes ["heat_loss_feedforward", "pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Input–output linearisation with the estimated slope ∂ξ/∂T.
    InputOutputLinearised = "input_output_linearised", takes ["lambda_per_s", "heat_loss_feedforward"];
    /// Input–output linearisation with a constant slope.
    InputOutputLinearisedConstant = "input_output_linearised_constant", takes ["lambda_per_s", "heat_loss_feedforward"];
    /// Robust servo on the velocity linearisation with static gains.
    VelocityServo = "velocity_servo", takes ["lambda_per_s"];
    /// Robust servo on the velocity linearisation with scheduled gains.
    VelocityServoScheduled = "velocity_servo_scheduled", takes ["lambda_per_s"];
    /// Model predictive control: shooting over the wire's model within the limits of its power.
    ModelPredictive = "model_predictive", takes ["lambda_per_s"];
    /// Inverse of a modified Prandtl–Ishlinskii operator as feed-forward, with proportional-integral control.
    PrandtlIshlinskii = "prandtl_ishlinskii", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s"];
    /// Proportional-integral-derivative with gains tuned by fuzzy rules.
    FuzzyPid = "fuzzy_pid", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Proportional-integral-derivative control of the estimated temperature, to the one that the length wanted asks for.
    TemperaturePid = "temperature_pid", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Proportional-integral-derivative with a cubic proportional term.
    PidP3 = "pid_p3", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Feedback linearisation on polynomials of the length, fitted to the simulated wire.
    PolynomialLinearised = "polynomial_linearised", takes ["lambda_per_s"];
    /// Variable structure control on the stress that the wire should have to move its load as wanted.
    StressVariableStructure = "stress_variable_structure", takes ["lambda_per_s"];
    /// Inverse of the wire, learned by a neural network, as feed-forward, with proportional-integral-derivative control.
    NeuralFeedforward = "neural_feedforward", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// The same inverse as feed-forward, with a smoothed sliding mode.
    NeuralSliding = "neural_sliding", takes ["lambda_per_s", "pi_proportional_per_mm", "pid_derivative_s_per_mm"];
    /// H∞ loop shaping on the logistic model.
    LoopShaping = "h_infinity", takes ["lambda_per_s"];
    /// Fuzzy PID on the length that a polynomial makes of the resistance alone.
    ResistancePolynomial = "resistance_polynomial", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// PID on the length that a neural network makes of the resistance alone.
    ResistanceNetwork = "resistance_network", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// One of several pieces of doubled lengths, heated wholly or not at all.
    BinarySegment = "binary_segment", takes ["segment", "segments"];
}

#[rustfmt::skip]
laws! {
    /// The control law of a joint.
    pub enum JointAlgorithm, default Decoupling;
    /// Angle and tension decoupled on the model of both wires.
    Decoupling = "decoupling", takes [];
    /// Position over differential force, with anti-slack and rapid heating.
    DifferentialForce = "differential_force", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Position over differential force, the force switched by a relay of two stages.
    DifferentialForceRelay = "differential_force_relay", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Fuzzy PID on the angle that the difference of both resistances says.
    DifferentialResistanceFuzzy = "differential_resistance_fuzzy", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// Sliding mode and PID on the angle that the difference of both resistances says.
    DifferentialResistanceSliding = "differential_resistance_sliding", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
    /// PID with inverse hysteresis as feed-forward, on the angle that polynomials make of both resistances.
    ResistancePolynomials = "resistance_polynomials", takes ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];
}

words! {
    /// What the wire's temperature and phase are estimated by.
    pub enum Estimator, default Fused {
        /// Length, resistance, power and model weighed together.
        Fused = "fused",
        /// Enthalpy from the power, phase from the length.
        Enthalpy = "enthalpy",
        /// The thesis' linear state estimator with constant gains, for comparison.
        Luenberger = "luenberger",
        /// The same with gains scheduled by the slope of the phase.
        LuenbergerScheduled = "luenberger_scheduled",
    }
}
