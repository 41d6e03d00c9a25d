//! The bench of controllers and what physics allows.

mod bench;
mod bound;
