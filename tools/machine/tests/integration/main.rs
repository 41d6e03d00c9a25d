//! The test machine's routines and what they are run for.

mod characterise;
mod routines;
