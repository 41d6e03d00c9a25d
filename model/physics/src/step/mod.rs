//! The simulation of one wire through time, from the bottom up:
//!
//! - `reference`: the reference model's parameters and its equations at one instant
//! - `air`: what is around the wire, and what it takes of the heat
//! - `ends`: the cold ends of a wire between clamps
//! - `own`: laws that users wrote
//! - `terms`: the effects as they act from piece to piece
//! - `balance`: heat, motion and strain solved for a trial of the driving temperature
//! - `wire`: the step in time

mod air;
mod balance;
mod ends;
mod own;
mod reference;
mod terms;
mod wire;

pub use own::Undefined;
pub use terms::Unknown;
pub use wire::{Wire, cold_length_m, hot_length_m};
