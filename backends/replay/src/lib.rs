//! A recording as a backend.
//!
//! [`ReplayBackend`] replaces power stage and converter: it returns the recorded voltages. It reads a
//! [`Source`]; a recorded [`Cycle`] has only the data a backend needs, independent of files and messages.
//!
//! ```
//! use sinew_backend::{Backend, BackendError, Sample};
//! use sinew_replay_backend::{Cycle, Cycles, ReplayBackend, Source};
//!
//! /// Three cycles of one channel, that were recorded somewhere.
//! #[derive(Debug, Clone, Copy)]
//! struct Recorded {
//!     number: u64,
//!     volts: f64,
//! }
//!
//! impl Cycle for Recorded {
//!     fn new(_channels: usize) -> Recorded {
//!         Recorded { number: 0, volts: f64::NAN }
//!     }
//!     fn copy_from(&mut self, other: &Recorded) {
//!         *self = *other;
//!     }
//!     fn number(&self) -> u64 {
//!         self.number
//!     }
//!     fn period(&self) -> u64 {
//!         self.number
//!     }
//!     fn sample(&self, _channel: usize) -> Sample {
//!         Sample { v3_v: self.volts, ..Sample::NONE }
//!     }
//!     fn duty(&self, _channel: usize) -> f64 {
//!         0.0
//!     }
//!     fn error(&self, _channel: usize) -> Option<BackendError> {
//!         None
//!     }
//! }
//!
//! struct Three;
//!
//! impl Source for Three {
//!     type Cycle = Recorded;
//!     type Cycles = Three;
//!     type Error = std::convert::Infallible;
//!
//!     fn channels(&self) -> usize {
//!         1
//!     }
//!     fn cycles(&self) -> Result<Three, Self::Error> {
//!         Ok(Three)
//!     }
//! }
//!
//! impl Cycles for Three {
//!     type Cycle = Recorded;
//!     type Error = std::convert::Infallible;
//!
//!     fn each(self, see: &mut dyn FnMut(&Recorded) -> bool) -> Result<(), Self::Error> {
//!         (1..=3u32).map(|n| Recorded { number: n.into(), volts: f64::from(n) }).all(|cycle| see(&cycle));
//!         Ok(())
//!     }
//! }
//!
//! let mut backend = ReplayBackend::new(Three);
//! let mut samples = [Sample::NONE];
//! backend.start()?;
//! for _ in 0..3 {
//!     assert!(backend.advance().is_ok_and(|cycle| cycle.is_some()));
//!     backend.exchange(&[0.0], &mut samples)?;
//! }
//! assert_eq!(samples[0].v3_v, 3.0);
//! # Ok::<(), sinew_backend::BackendError>(())
//! ```
#![forbid(unsafe_code)]

mod backend;
mod source;

pub use backend::ReplayBackend;
pub use source::{Cycle, Cycles, Source};
