//! The physics of one shape-memory-alloy wire: pure functions and a step, no I/O, no clock, no allocation.
//!
//! [`WireModel`] holds the parameters, [`Wire`] the state; [`Wire::step`] advances it. [`Hysteresis`] and [`Fraction`]
//! are the phase alone, for estimators that need curves and slopes.
#![forbid(unsafe_code)]

mod balance;
pub mod effects;
pub mod formulas;
mod joint;
mod kinetics;
mod params;
mod signals;
mod wire;

pub use effects::{Effects, Unknown};
pub use joint::{Joint, JointEnergy, JointMotion, MOST_JOINT_HZ};
pub use kinetics::{Direction, Fraction, Hysteresis};
pub use signals::{EnergyBalance, Inputs, Outputs};
pub use wire::{Wire, cold_length_m, hot_length_m};

pub use params::{Convection, Drive, DriveKind, Geometry, Initial, Kinetics, Load, Material, Mixing, Taps, WireModel};

/// What can be wrong with a wire's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error {
    /// A parameter is outside its physical range (NaN included).
    OutOfRange {
        /// The rig-file key, in whose unit the numbers are.
        key: &'static str,
        /// What was given.
        found: f64,
        /// Least value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Error::OutOfRange { key, found, low, high } => write!(f, "{key} is {found}, expected {low} to {high}"),
        }
    }
}

impl std::error::Error for Error {}
