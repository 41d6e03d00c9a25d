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
//!
//! # Example
//! ```
//! use sinew_backend::{Backend, Sample};
//! use sinew_sim_backend::SimulatedRig;
//!
//! let rig = sinew_rig::Rig::hexapod();
//! let mut backend = SimulatedRig::new(&rig)?;
//! let mut samples = vec![Sample::NONE; backend.channels()];
//! backend.start()?;
//! for _ in 0..500 {
//!     backend.exchange(&[0.3; 18], &mut samples)?; // half a second of 30 % duty
//! }
//! assert!(samples[0].current_a > 0.1 && samples[0].v3_v > 1.0);
//! assert!(backend.wire(0).is_some_and(|wire| wire.temperature_c() > 40.0), "the true wire, which no driver sees");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
