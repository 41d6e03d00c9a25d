//! The bench of controllers and the physical bounds.

mod bench;
mod bound;
mod exact;
