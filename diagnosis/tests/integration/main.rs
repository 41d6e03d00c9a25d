//! The diagnosis as a whole.

mod answers;
mod shared;
