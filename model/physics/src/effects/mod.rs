//! The catalogue of physics a simulation may have left out: one table, from which the rig file, the documentation and
//! the diagnosis are made.
//!
//! Every effect is one term of the model with a null at which it vanishes, so the reference model is nested in every
//! extension of it.
//!
//! # Adding an effect
//! All of it stands in the file of its equation, `effects/thermal.rs` and so on: a struct with its parameters in SI, a
//! field of that in the group's struct, its term in the group's function that sums such terms (the losses, what is in the
//! circuit, the permanent strain, …), and its row. Rig file, checks, `docs/effects.md` and diagnosis follow from the row;
//! `tests/effects/explicit.rs` holds the row to the contract and the term to an explicit integration of its equation. Only an effect that acts where none
//! did before needs a new function in the step.
//!
//! Users add theirs without a compiler: [`Law`] is an effect whose term is a formula.

pub(crate) mod all;
pub(crate) mod catalogue;
mod coefficients;
pub(crate) mod electrical;
pub(crate) mod empirical;
pub(crate) mod kinetic;
pub(crate) mod mechanical;
pub(crate) mod own;
pub(crate) mod row;
pub(crate) mod sensing;
pub(crate) mod thermal;

pub use all::Effects;
pub use catalogue::{Effect, EffectParameter, Role, catalogue, effect, row_of};
pub use electrical::*;
pub use empirical::*;
pub use kinetic::*;
pub use mechanical::*;
pub use own::{Definition, Entry, Law, Own, OwnParameter, OwnRole, OwnState, QUANTITIES, Undefined};
pub use row::{Equation, Has, Home, Nature, Needs, Null};
pub use sensing::*;
pub use thermal::*;
