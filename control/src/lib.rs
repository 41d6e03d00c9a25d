//! Control of shape-memory-alloy wires: laws from length to duty, the state estimate they share, and design calculations.
//!
//! Pure functions and small structs: no I/O, no clock, no thread, no allocation, no panic on any input.
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
mod rules;
mod sizing;
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
pub use joint::{JointDemand, JointEstimate, JointLaw, JointObserver, JointSettings};
pub use lambda::{Lambda, MARGIN, default_lambda};
pub use laws::{AlgorithmKind, KEYS_OF_LAWS, LawRow, PidGains, Priming, TensionLimits};
pub use lpv::{Coupling, LpvError, LpvModel, OperatingPoint, StateSpace};
pub use reach::{Holding, Limits, Reach, ReachConfig, Shares};
pub use rules::WireRules;
pub use sizing::{
    Candidate, Motion, Prediction, Requirement, STOCK_DIAMETERS_M, Shortfall, best, candidates, load_of, predict,
};
pub use stroke::{CommandError, StrokeRange, length_for_force};
