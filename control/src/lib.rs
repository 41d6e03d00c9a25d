//! Control of shape-memory-alloy wires: laws from length to duty, the state estimate they share, and how fast a wire can be.
//!
//! Pure functions and small structs: no I/O, no clock, no thread, no allocation after construction, no panic on any input.
//!
//! - [`Algorithm`] runs one of the laws of [`AlgorithmKind`], [`StateEstimator`] one of the estimators of [`EstimatorKind`]. Each
//!   of both has a file and a row in a table (`src/laws/mod.rs`, `src/estimators/mod.rs`), from which all else follows.
//! - [`TensionLimits`] stand around any law; [`JointObserver`] and [`JointLaw`] are for two wires that turn one joint, with a table of
//!   laws of its own (`src/joint/mod.rs`).
//! - [`default_lambda`] and [`Reach`] are for tuning, [`LpvModel`] is chapter 9's linear wire.
//!
//! ```
//! use sinew_control::{
//!     Algorithm, Controller, Demand, EstimatorKind, Observation, Settings, StateEstimator, StrokeRange,
//! };
//! use sinew_physics::*;
//!
//! // 0.125 mm × 160 mm at 6 V that lift 0.2 kg, simulated at 1 kHz.
//! let model = WireModel {
//!     geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
//!     material: Material::default(),
//!     taps: None,
//!     drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.0, lead_ohm: 0.0 },
//!     load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96 },
//!     initial: Initial::default(),
//!     ambient_c: 25.0,
//!     effects: Effects::default(),
//! };
//! let mut wire = Wire::new(&model)?;
//! let mut estimator = StateEstimator::new(&model, EstimatorKind::Fused);
//! let mut law = Algorithm::new(&model, &Settings::default());
//! let reference_m = StrokeRange::of(&model)?.length_m(0.4);
//!
//! let (mut duty, dt_s) = (0.02, 1e-3);
//! for _ in 0..2000 {
//!     wire.step(&Inputs { drive: duty, ..model.rest_inputs() }, dt_s);
//!     let length_m = model.geometry.length_m + wire.position_m();
//!     let resistance_ohm = wire.resistance_ohm();
//!     let seen = Observation { length_m, length_sigma_m: 1e-6, resistance_ohm, ..Observation::nothing(duty, dt_s) };
//!     duty = law.duty(&Demand {
//!         reference_m,
//!         length_m,
//!         velocity_m_s: wire.velocity_m_s(),
//!         acceleration_m_s2: 0.0,
//!         resistance_ohm,
//!         dt_s,
//!         estimate: estimator.update(&seen),
//!     });
//! }
//! let error_m = model.geometry.length_m + wire.position_m() - reference_m;
//! assert!(error_m.abs() < 0.05e-3, "{error_m}");
//! # Ok::<(), sinew_physics::Error>(())
//! ```
#![forbid(unsafe_code)]

mod algorithm;
mod cycle;
mod demand;
mod estimate;
mod estimators;
mod joint;
mod lambda;
mod laws;
mod lpv;
mod reach;
mod stroke;
#[cfg(test)]
mod testing;
mod wire_map;

pub use algorithm::{Algorithm, Settings};
pub use demand::{Controller, Demand, Modulation};
pub use estimate::{Estimate, Observation};
pub use estimators::{
    EnthalpyObserver, EstimatorKind, EstimatorRow, FusedEstimator, LuenbergerObserver, StateEstimator,
};
pub use joint::{
    JointAlgorithmKind, JointDemand, JointEstimate, JointGains, JointLaw, JointLawRow, JointObserver, JointSettings,
    KEYS_OF_JOINT_LAWS, TensionKept,
};
pub use lambda::{Lambda, MARGIN, default_lambda};
pub use laws::{AlgorithmKind, KEYS_OF_LAWS, LawRow, PidGains, Priming, Segment, TensionLimits};
pub use lpv::{Coupling, LpvError, LpvModel, OperatingPoint, StateSpace};
pub use reach::{Holding, Limits, Reach, ReachConfig, Shares};
pub use stroke::{CommandError, StrokeRange, length_for_force};
