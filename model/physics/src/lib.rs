//! The physics of one shape-memory-alloy wire: pure functions and a step, no I/O, no clock, no allocation.
//!
//! [`WireModel`] holds the parameters, [`Wire`] the state; [`Wire::step`] advances it. [`formulas`] has each physical
//! formula once, for whoever measures, estimates or controls; [`Hysteresis`] and [`Fraction`] are the phase alone, for
//! estimators that need curves and slopes; [`effects`] is the catalogue of what the reference model leaves out.
//!
//! # Source
//! The equations are those of the thesis *Enabling Shape Memory Alloys as Actuators for Robotics* (the copy this was
//! written from names neither its author nor the institution nor the year). "Eq. n", "fig. n" and "chapter n" anywhere in
//! the project are its numbers.
//!
//! # A wire that is heated
//! ```
//! use sinew_physics::*;
//!
//! let model = WireModel {
//!     geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
//!     material: Material::default(),
//!     taps: None,
//!     drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
//!     load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96 },
//!     initial: Initial::default(),
//!     ambient_c: 25.0,
//!     effects: Effects::default(),
//! };
//! let mut wire = Wire::new(&model)?;
//! let long_m = wire.position_m();
//! for _ in 0..3000 {
//!     wire.step(&Inputs { drive: 0.5, ..model.rest_inputs() }, 1e-3);
//! }
//! // it has become austenite and lifted its load, and its energy adds up
//! assert!(wire.martensite() < 0.05 && wire.position_m() < long_m - 4e-3);
//! assert!(wire.energy().residual_j().abs() < 1e-9);
//!
//! // the current that the supply drives through it, by the formula
//! let current_a = model.drive.on_current_a(wire.resistance_ohm());
//! assert!((wire.outputs().current_a - current_a).abs() < 1e-12);
//! # Ok::<(), Error>(())
//! ```
#![forbid(unsafe_code)]

mod criteria;
pub mod effects;
mod error;
pub mod formulas;
mod joint;
mod kept_history;
mod kinetics;
mod model;
mod params;
mod rest;
mod signals;
mod step;
mod surroundings;
mod twins;
mod validate;
mod warp;

pub use effects::Effects;
pub use error::Error;
pub use joint::{Joint, JointEnergy, JointMotion, MOST_JOINT_HZ};
pub use kept_history::KeptHistory;
pub use kinetics::{Direction, Fraction, Hysteresis};
pub use model::WireModel;
pub use signals::{EnergyBalance, Inputs, Outputs};
pub use step::{Undefined, Unknown, Wire, cold_length_m, hot_length_m};
pub use surroundings::{Surroundings, drawn_meanwhile_a};
pub use warp::{Side, Warp};

pub use params::{
    Amplifier, Convection, Criterion, Detwinning, Drive, DriveKind, Geometry, Initial, Kinetics, Load, Material,
    Mixing, Taps,
};
