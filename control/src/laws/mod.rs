//! The laws from length to duty, one a file, and the table they are registered in.
//!
//! **To add a law**: write its file here, with a type that is a [`Law`]; add its `mod` line and its row below; run
//! `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::`. Rig file, driver, bench, command line and docs follow from the row.

mod cubic;
mod curve;
pub(crate) mod fuzzy;
mod hold;
mod linearised;
mod loop_shaping;
mod network;
mod neural;
mod optimal;
mod pace;
pub(crate) mod pid;
mod polynomial;
mod prandtl_ishlinskii;
mod predictive;
mod rapid_heating;
mod relay;
mod resistance;
mod segment;
mod servo;
mod setup;
mod simulated;
mod sliding;
mod sliding_first_order;
#[macro_use]
mod table;
mod stress;
mod temperature;
mod tension;

pub(crate) use curve::{Polynomial, Scale, Side};
pub use pid::PidGains;
pub use rapid_heating::Priming;
pub(crate) use rapid_heating::RapidHeating;
pub use segment::Segment;
pub(crate) use setup::{Given, Setup};
pub use table::LawRow;
pub use tension::TensionLimits;

use crate::demand::{Demand, Law};
use crate::lpv::Coupling;
use linearised::Slope;
use servo::Schedule;
use sliding::SurfaceLaw;

/// Keys of `[channel.control]` that only some laws take.
pub const KEYS_OF_LAWS: [&str; 8] = [
    "lambda_per_s",
    "heat_loss_feedforward",
    "pi_proportional_per_mm",
    "pi_integral_per_mm_s",
    "pid_derivative_s_per_mm",
    "relay_band_mm",
    "segment",
    "segments",
];

// For each type of law its words in the rig file. `takes`: which of KEYS_OF_LAWS mean something with it. `law` and
// `defaults`: its row in docs/control-laws.md, with e = x − x_ref, S the stroke, D duty. `needs_estimate`: whether it
// gives the least duty where no estimator says temperature and phase; the others make do with the length.
laws! {
    optimal::TimeOptimal {
        /// Sliding mode along the stopping distance, in the wire's estimated state.
        TimeOptimal {
            word: "time_optimal",
            takes: ["lambda_per_s"],
            needs_estimate: true,
            law: "full power or none as long as the wire can still be stopped, then along the stopping distance, see above",
            defaults: "λ as below",
            new: |s| TimeOptimal::new(s.map, s.lambda, s.hold_band(), s.range),
        }
    }
    sliding::SlidingMode {
        /// Sliding mode on a critically damped second-order surface, in the wire's estimated state.
        SlidingMode {
            word: "sliding_mode",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "P_eq of eq. 70 on σ = ẍ + 2λẋ + λ²e (chapter 11), in the estimated state, see above",
            defaults: "λ",
            new: |s| SlidingMode::new(s.map, s.lambda, SurfaceLaw::Equivalent, s.hold_band(), s.range),
        }
        /// The same surface on the observed derivatives of the length: the thesis' law as it stands, for comparison.
        SlidingModePlain {
            word: "sliding_mode_plain",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "maximum where σ > 0 of the measured derivatives, else minimum (chapter 11)",
            defaults: "λ",
            new: |s| SlidingMode::new(s.map, s.lambda, SurfaceLaw::Plain, s.hold_band(), s.range),
        }
    }
    sliding_first_order::SlidingModeFirstOrder {
        /// Sliding mode on a first-order surface, switched.
        SlidingModeFirstOrder {
            word: "sliding_mode_first_order",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "the same with σ = ẋ + λe; it limit-cycles (figure 113)",
            defaults: "λ",
            new: |s| SlidingModeFirstOrder::new(s.map, s.lambda, SurfaceLaw::Plain, s.stroke, s.range),
        }
        /// Sliding mode on a first-order surface, in the wire's estimated state.
        SlidingModeFirstOrderEquivalent {
            word: "sliding_mode_first_order_equivalent",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "P = P_eq + ½P_max sat(σ/(0.1 λS)); P_eq keeps σ = 0: eq. 70 one order lower, at ẋ = −λe",
            defaults: "λ",
            new: |s| SlidingModeFirstOrder::new(s.map, s.lambda, SurfaceLaw::Equivalent, s.stroke, s.range),
        }
    }
    relay::Relay {
        /// On and off with a band.
        Relay {
            word: "relay",
            takes: ["relay_band_mm"],
            needs_estimate: false,
            law: "maximum above x_ref + b, minimum below x_ref − b, between them as before",
            defaults: "b = `relay_band_mm` = 1 % of S",
            new: |s| Relay::new(s.relay_band(), s.range),
        }
    }
    pid::Pid {
        /// Proportional-integral with anti-windup.
        Pi {
            word: "pi",
            takes: ["heat_loss_feedforward", "pi_proportional_per_mm", "pi_integral_per_mm_s"],
            needs_estimate: false,
            law: "D = K_P e + ∫K_I e dt, anti-windup by back-calculation in 0.3 s",
            defaults: "K_P = 1/(0.3 S), T_i = 1 s",
            new: |s| Pid::new(s.pi_gains(), s.feeds_loss_forward(false), s.range),
        }
        /// Proportional-integral-derivative with anti-windup.
        Pid {
            word: "pid",
            takes: [
                "heat_loss_feedforward",
                "pi_proportional_per_mm",
                "pi_integral_per_mm_s",
                "pid_derivative_s_per_mm",
            ],
            needs_estimate: false,
            law: "the same + K_D ẋ through 10 ms: of the length, so a step of the reference does not kick",
            defaults: "T_d = 50 ms",
            new: |s| Pid::new(s.pid_gains(), s.feeds_loss_forward(false), s.range),
        }
    }
    linearised::InputOutputLinearised {
        /// Input–output linearisation with the estimated slope ∂ξ/∂T.
        InputOutputLinearised {
            word: "input_output_linearised",
            takes: ["lambda_per_s", "heat_loss_feedforward"],
            needs_estimate: true,
            law: "P = α λe + β, α = Q/\\|∂ξ/∂T\\| · (K + K_SMA)/(K_SMA L ε_L), β = the loss to the air, Q = m c_p + H\\|∂ξ/∂T\\| \
                  (eq. 58); ∂ξ/∂T of the estimated branch",
            defaults: "λ",
            new: |s| {
                InputOutputLinearised::new(s.map, s.lambda, Slope::Estimated, s.feeds_loss_forward(true), s.range)
            },
        }
        /// Input–output linearisation with a constant slope.
        InputOutputLinearisedConstant {
            word: "input_output_linearised_constant",
            takes: ["lambda_per_s", "heat_loss_feedforward"],
            needs_estimate: true,
            law: "the same with ∂ξ/∂T = −0.05 per K",
            defaults: "λ",
            new: |s| InputOutputLinearised::new(s.map, s.lambda, Slope::Constant, s.feeds_loss_forward(true), s.range),
        }
    }
    servo::VelocityServo {
        /// Robust servo on the velocity linearisation with static gains.
        VelocityServo {
            word: "velocity_servo",
            takes: ["lambda_per_s"],
            needs_estimate: true,
            law: "ΔP = −K (−e Δt, Δx, Δẋ, ΔT), K the linear-quadratic regulator of eq. 64 for ∂ξ/∂T = −0.05 per K, weight only \
                  on e",
            defaults: "K_e = λP_max/S",
            new: |s| {
                VelocityServo::new(
                    s.model,
                    s.map,
                    Schedule::Static,
                    Coupling::Thermal,
                    s.integral_w_per_m_s(),
                    s.range,
                )
            },
        }
        /// Robust servo on the velocity linearisation with scheduled gains.
        VelocityServoScheduled {
            word: "velocity_servo_scheduled",
            takes: ["lambda_per_s"],
            needs_estimate: true,
            law: "the same with K interpolated over the estimated ∂ξ/∂T, designed on all couplings of the reference model",
            defaults: "K_e = λP_max/S",
            new: |s| {
                VelocityServo::new(
                    s.model,
                    s.map,
                    Schedule::Scheduled,
                    Coupling::Full,
                    s.integral_w_per_m_s(),
                    s.range,
                )
            },
        }
    }
    predictive::ModelPredictive {
        /// Model predictive control: shooting over the wire's model within the limits of its power.
        ModelPredictive {
            word: "model_predictive",
            takes: ["lambda_per_s"],
            needs_estimate: true,
            law: "the power of the next block after which the wire's model, braked as it can be, comes to rest at the reference; \
                  within the limits, again every 2 ms, see below",
            defaults: "λ as below",
            new: |s| ModelPredictive::new(s.map, s.lambda, s.hold_band(), s.range),
        }
    }
    prandtl_ishlinskii::PrandtlIshlinskii {
        /// Inverse of a modified Prandtl–Ishlinskii operator as feed-forward, with proportional-integral control.
        PrandtlIshlinskii {
            word: "prandtl_ishlinskii",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s"],
            needs_estimate: false,
            law: "D = h A_s (P⁻¹(S⁻¹(x_ref)) − T_∞)/P_max + K_P e + ∫K_I e dt; P a sum of 16 plays of the temperature, S a curve, both \
                  taken from the simulated loop of the rig file's wire",
            defaults: "K_P and T_i as of `pi`",
            new: |s| PrandtlIshlinskii::new(s.model, s.map, s.pi_gains(), s.range),
        }
    }
    fuzzy::FuzzyPid {
        /// Proportional-integral-derivative with gains tuned by fuzzy rules.
        FuzzyPid {
            word: "fuzzy_pid",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "`pid` with K_P and K_D 1 to 1.9 times, T_i 1 to 2.5 times theirs, by 49 rules on e and ẋ (Zhao, Tomizuka, Isaka 1993; \
                  the ranges are ours)",
            defaults: "as `pid`; big is e = 0.1 S, ẋ = 0.5 S/s",
            new: |s| FuzzyPid::new(s.pid_gains(), s.stroke, s.range),
        }
    }
    temperature::TemperaturePid {
        /// Proportional-integral-derivative control of the estimated temperature, to the one that the length wanted asks for.
        TemperaturePid {
            word: "temperature_pid",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: true,
            law: "T_d = the temperature of x_ref on the curve of the way there; D = loss(T_d)/P_max + `pid` on k(e) e, e = (T_d − T)/\\|∂T/∂x\\|, \
                  k(e) = 2 − sech((T_d − T) k_A)",
            defaults: "as `pid`",
            new: |s| TemperaturePid::new(s.map, s.pid_gains(), s.stroke, s.range),
        }
    }
    cubic::PidP3 {
        /// Proportional-integral-derivative with a cubic proportional term.
        PidP3 {
            word: "pid_p3",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "`pid` + K_P3 e³ (Shameli, Alasty, Salaarieh 2005)",
            defaults: "as `pid`; K_P3 = K_P/(0.1 S)²",
            new: |s| PidP3::new(s.pid_gains(), s.stroke, s.range),
        }
    }
    polynomial::PolynomialLinearised {
        /// Feedback linearisation on polynomials of the length, fitted to the simulated wire.
        PolynomialLinearised {
            word: "polynomial_linearised",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "P = p₁(s) λe/S + p₀(s), s the share of the stroke; p₁ and p₀ of fourth degree, for shortening and lengthening each, fitted to the \
                  simulated ways of the rig file's wire (Arai, Aramaki, Yanagisawa 1995)",
            defaults: "λ",
            new: |s| PolynomialLinearised::new(s.model, s.map, s.lambda, s.range),
        }
    }
    stress::StressVariableStructure {
        /// Variable structure control on the stress that the wire should have to move its load as wanted.
        StressVariableStructure {
            word: "stress_variable_structure",
            takes: ["lambda_per_s"],
            needs_estimate: true,
            law: "P = loss + P_max sat((σ_d − σ)/φ); A σ_d = F_preload − K x − B v_d − M v̇_d + λM(ẋ − v_d), v_d = −λe; σ by eq. 12 from T and ξ; \
                  φ dT/dσ = 1/k (after Elahinia, Ahmadian and others 2004)",
            defaults: "λ",
            new: |s| StressVariableStructure::new(s.map, s.lambda, s.range),
        }
    }
    neural::Neural {
        /// Inverse of the wire, learned by a neural network, as feed-forward, with proportional-integral-derivative control.
        NeuralFeedforward {
            word: "neural_feedforward",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "D = loss(T_N)/P_max + `pid`; T_N of a network of 10 neurons from x_ref, its direction and its last reversal, trained on the \
                  simulated loop of the rig file's wire (after Song, Chaudhry, Batur 2003)",
            defaults: "as `pid`",
            new: |s| Neural::with_pid(s.model, s.map, s.pid_gains(), s.range),
        }
        /// The same inverse as feed-forward, with a smoothed sliding mode.
        NeuralSliding {
            word: "neural_sliding",
            takes: ["lambda_per_s", "pi_proportional_per_mm", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "D = loss(T_N)/P_max + K_P e + K_D ẋ + ½D_max tanh(σ/(0.1 λS)), σ = ẋ + λe",
            defaults: "λ; K_P and K_D as of `pid`",
            new: |s| Neural::with_sliding(s.model, s.map, s.pid_gains(), s.lambda, s.stroke, s.range),
        }
    }
    loop_shaping::LoopShaping {
        /// H∞ loop shaping on the logistic model.
        LoopShaping {
            word: "h_infinity",
            takes: ["lambda_per_s"],
            needs_estimate: false,
            law: "McFarlane and Glover's controller of G W₁, G the linearised logistic model at its slope k/4, W₁ = k_w (s + λ/10)/s, γ = 1.1 γ_min \
                  (after Jayender and others 2005, 2008)",
            defaults: "crosses 1 at λ",
            new: |s| LoopShaping::new(&s.map, s.lambda, s.stroke, s.range),
        }
    }
    resistance::ResistanceFeedback {
        /// Fuzzy PID on the length that a polynomial makes of the resistance alone.
        ResistancePolynomial {
            word: "resistance_polynomial",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "`fuzzy_pid` on x = p(R), p of fifth degree, fitted to the simulated loop of the rig file's wire (after Lan, Fan 2010); no other \
                  length is used",
            defaults: "as `fuzzy_pid`",
            new: |s| ResistanceFeedback::polynomial(s.model, &s.map, s.pid_gains(), s.stroke, s.range),
        }
        /// PID on the length that a neural network makes of the resistance alone.
        ResistanceNetwork {
            word: "resistance_network",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            needs_estimate: false,
            law: "`pid` on x = N(R, side of the loop), N a network of 8 neurons, trained on the same loop (after Ma, Song, Lee 2004)",
            defaults: "as `pid`",
            new: |s| ResistanceFeedback::network(s.model, &s.map, s.pid_gains(), s.range),
        }
    }
    segment::BinarySegment {
        /// One of several pieces of doubled lengths, heated wholly or not at all.
        BinarySegment {
            word: "binary_segment",
            takes: ["segment", "segments"],
            needs_estimate: true,
            law: "of n pieces in series the k-th heats, until surely austenite, where binary digit k of (2ⁿ − 1) s is one, s the \
                  stroke that all of them are told (fig. 66), see below",
            defaults: "one piece: on above half of S",
            new: |s| BinarySegment::new(s.model, s.map, s.segment, s.range),
        }
    }
}
