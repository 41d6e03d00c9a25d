//! From the voltages on a wire to its length, its motion, and the trust to put in them.
//!
//! A [`Sample`] is what the converter saw in the on-phase of one period. [`LengthSensor::read`] makes a [`Reading`] of it:
//! length by the dual measurement (eq. 42–43) or, as the baseline to beat, by resistance alone; resistance and
//! resistivity (eq. 44); the standard deviation of the length; and the [`Health`] of the sample. A length is NaN
//! unless it was measured. [`MotionObserver`] turns the noisy lengths into a [`Motion`]: length, velocity and
//! acceleration fit for the second-order sliding surface of chapter 11. [`SlideWatch`] says when a length that looks
//! well cannot be the wire's, because a tap sticks to it.
//!
//! No I/O, clock, thread or allocation; no panic on any sample, NaN and infinities included.
#![forbid(unsafe_code)]

mod error;
mod health;
mod length;
mod line;
mod observer;
mod slide;

pub use error::Error;
pub use health::Health;
pub use length::{Circuit, Converter, LengthSensor, LengthSensorConfig, Method, Reading, Sample, StuckAfter};
pub use line::{LineFit, ResistanceLine};
pub use observer::{Drive, Motion, MotionObserver, ObserverConfig};
pub use slide::{SlideConfig, SlideWatch};
