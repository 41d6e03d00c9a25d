//! The test machine's routines and their results.

mod characterise;
mod reference;
mod routines;
