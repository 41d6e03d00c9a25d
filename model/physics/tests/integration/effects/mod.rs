//! Every effect of the catalogue: its row against the contract, its null against the reference model, and its term
//! against an independent computation of the same equation.

mod catalogue;
mod common;
mod comparisons;
mod ends;
mod explicit;
mod friction;
mod own;
mod sensors;
mod unknown;
