//! The second generator of concealed cases: a truth of another structure than any model of the project.
//!
//! | | reference model | first generator | here |
//! |---|---|---|---|
//! | phase | closed outer curves, memory of the last reversal | the same as a rate law | an ensemble of plays between ramps: Preisach ([`grains`]) |
//! | heat | T and ξ solved together | Heun, projected onto curves | enthalpy, exact to rounding at every step |
//! | load | implicit steps | leapfrog | trapezoidal, closed over the stress; a bristle for friction; a pulley's inertia |
//! | ends | lumped, or nodes | cells | cells, refined towards the clamps |
//! | air | h constant | h constant | h constant, or Churchill and Chu's correlation ([`air`]) |
//! | sensors | white noise | white, coloured, quantised | averages over the on-phase, a slow part, an encoder with lines |
//!
//! It is written from the physics, shares no code with the project's simulator, and takes from the first generator only
//! what a laboratory believes: benches, rig file, programme, format of tables.

mod air;
pub mod case;
mod grains;
pub mod mechanisms;
mod rod;
mod sensors;
mod world;
