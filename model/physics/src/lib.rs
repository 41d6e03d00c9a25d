//! The physics of one shape-memory-alloy wire: pure functions and a step, no I/O, no clock, no allocation.
//!
//! [`WireModel`] holds the parameters, [`Wire`] the state; [`Wire::step`] advances it. [`Hysteresis`] and [`Fraction`]
//! are the phase alone, for estimators that need curves and slopes.
#![forbid(unsafe_code)]

pub mod effects;
mod error;
pub mod formulas;
mod joint;
mod kinetics;
mod model;
mod params;
mod signals;
mod step;
mod validate;

pub use effects::Effects;
pub use error::Error;
pub use joint::{Joint, JointEnergy, JointMotion, MOST_JOINT_HZ};
pub use kinetics::{Direction, Fraction, Hysteresis};
pub use model::WireModel;
pub use signals::{EnergyBalance, Inputs, Outputs};
pub use step::{Unknown, Wire, cold_length_m, hot_length_m};

pub use params::{Convection, Drive, DriveKind, Geometry, Initial, Kinetics, Load, Material, Mixing, Taps};
