//! The alloy of a rig file as material laboratories see it: [`calorimeter`] fits the wire's own model to the curve of a calorimeter,
//! [`together`] says what that tells a fit of recordings, and [`temperatures`] gives of any model what the standards name of it.
//!
//! The model is simulated in a furnace, at constant force; figures are read off what it shows by the same tangents as off what is measured
//! ([`sinew_standards`]).
#![forbid(unsafe_code)]

mod calorimeter;
mod error;
mod furnace;
mod least_squares;
mod measured;
mod temperatures;

pub use calorimeter::{Fitted, HeatFlow, calorimeter};
pub use error::Error;
pub use measured::{DIRECTION_K, HEAT_ERROR, STEEPNESS_ERROR, THERMOMETER_K, together};
pub use temperatures::{Temperature, Temperatures, temperatures};
