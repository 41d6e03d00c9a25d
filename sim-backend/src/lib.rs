//! A virtual rig behind the driver's backend contract: every channel of a rig file as a simulated wire with its load,
//! its power stage, its taps and its converter, with fault injection.
//!
//! [`SimulatedRig`] replaces power stage and converter; the driver cannot distinguish them. [`FaultHandle`] injects faults
//! while it runs, the rig file's `[[simulation.fault]]` at set times.
//!
//! # One period
//! The power stage closes the switch for the *last* part of the period, duty × period long, and the converter samples
//! just before it opens: so the sample that [`exchange`](sinew_backend::Backend::exchange) returns is as recent as the
//! call, and a row of a recording made of it (duty of the period, sample at its end) matches `sinew_recording`'s definition
//! of a row. The converter needs the switch closed for [`MIN_ON_TIME_S`] to settle; with a shorter on-phase, or none, it
//! samples a wire without current: offset and noise. The supply is always sampled.
//!
//! Current flows, and heats, only in the on-phase: a sensing pulse of 2 % heats the wire by 2 % of full power, and
//! [`SimulatedRig::energy`] accounts for it.
//!
//! # Noise
//! Every channel draws from a generator of its own, seeded by the rig's seed and the channel's name: the same seed gives
//! the same samples, whatever other channels the rig has and in whatever order.
#![forbid(unsafe_code)]

mod channel;
mod circuit;
mod converter;
mod fault;
mod rig;

pub use channel::World;
pub use converter::MIN_ON_TIME_S;
pub use fault::FaultHandle;
pub use rig::{Error, SimulatedRig};
