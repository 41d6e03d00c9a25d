//! Concealed cases: a rig file, which is what a laboratory believes of its rig, recordings of that rig with something in them that the
//! rig file does not know, and what that was, in an envelope.
//!
//! The recordings come from two simulators ([`generator`], [`second`]) that share no code with the one the diagnosis fits with: this
//! crate depends on nothing of the project, and nothing of the diagnosis on it. The proof scores the diagnosis on such cases, and
//! `sinew conceal` makes one for whoever wants to try.
#![forbid(unsafe_code)]

mod choice;
mod envelope;
pub mod generator;
pub mod judged;
pub mod reported;
#[allow(rustdoc::private_intra_doc_links)] // frozen with the plan, byte by byte
pub mod second;

pub use choice::{Choice, Order, effects, outside};
pub use envelope::{Broken, Sealed};
