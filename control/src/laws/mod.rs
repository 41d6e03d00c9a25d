//! The laws from length to duty, one a file.

mod hold;
mod linearised;
mod optimal;
mod pid;
mod rapid_heating;
mod relay;
mod servo;
mod sliding;
mod sliding_first_order;
mod tension;

pub use linearised::{CONSTANT_SLOPE_PER_K, InputOutputLinearised, Slope};
pub use optimal::TimeOptimal;
pub use pid::{Pid, PidGains};
pub use rapid_heating::Priming;
pub(crate) use rapid_heating::RapidHeating;
pub use relay::Relay;
pub(crate) use servo::Schedule;
pub use servo::VelocityServo;
pub use sliding::{Law, SlidingMode2};
pub use sliding_first_order::SlidingMode1;
pub use tension::TensionLimits;
