//! The laws from length to duty, one a file.

mod pi;
mod sliding;

pub use pi::{Pi, PiGains};
pub use sliding::{Law, SlidingMode1, SlidingMode2};
