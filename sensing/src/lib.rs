//! From the voltages on a wire to its length, its motion, and the health of the measurement.
//!
//! A [`Sample`] contains the converter's readings in the on-phase of one period. [`LengthSensor::read`] computes a [`Reading`]:
//! length by the dual measurement (eq. 42–43) or, as a baseline, by resistance alone; resistance and
//! resistivity (eq. 44); the standard deviation of the length; and the [`Health`] of the sample. A length is NaN
//! unless it was measured. [`MotionObserver`] turns the noisy lengths into a [`Motion`]: length, velocity and
//! acceleration suitable for the second-order sliding surface of chapter 11. [`SlideWatch`] detects when a plausible length
//! cannot be the wire's, because a tap sticks to it.
//!
//! The formulas themselves are in [`sinew_physics::formulas`]; this crate handles noise, broken wires and lost probes.
//! No I/O, clock, thread or allocation; no panic on any sample, NaN and infinities included.
//!
//! ```
//! use sinew_sensing::{Converter, Health, LengthSensor, LengthSensorConfig, Method, MotionObserver, ObserverConfig};
//! use sinew_sensing::{Sample, WireEnd};
//!
//! // A wire of 0.125 mm at 6 V with one tap at 150 mm, contracted hot and stretched cold.
//! let hot = WireEnd { resistance_ohm: 11.9, length_m: 0.1603 };
//! let cold = WireEnd { resistance_ohm: 10.4, length_m: 0.1667 };
//! let method = Method::DualMeasurement { l0_m: 0.0, ls_m: 0.150 };
//! let config = LengthSensorConfig::for_wire(method, 1.2272e-8, 6.0, hot, cold, Converter::default());
//! let mut sensor = LengthSensor::new(config)?;
//! let mut observer = MotionObserver::new(1000.0, ObserverConfig::default())?;
//!
//! let sample = Sample { v1_v: 0.0, v2_v: 5.4, v3_v: 5.9, current_a: 0.52, supply_v: 6.0 };
//! let reading = sensor.read(&sample);
//! assert_eq!(reading.health, Health::Ok);
//! assert!((reading.length_m - 0.150 * 5.9 / 5.4).abs() < 1e-12);
//! let motion = observer.update_weighted(reading.length(), reading.length_sigma_m, 1e-3);
//! assert_eq!(motion.length_m, reading.length_m);
//!
//! // A wire that has come off its crimp: voltage, but no current.
//! let broken = Sample { current_a: 0.0, v3_v: 6.0, v2_v: 0.0, ..sample };
//! assert_eq!(sensor.read(&broken).health, Health::OpenWire);
//! # Ok::<(), sinew_sensing::Error>(())
//! ```
#![forbid(unsafe_code)]

mod config;
mod converter;
mod error;
mod health;
mod length;
mod line;
mod observer;
mod reading;
mod repeats;
mod sample;
mod slide;

pub use config::{LengthSensorConfig, Method};
pub use converter::{Circuit, Converter};
pub use error::Error;
pub use health::Health;
pub use length::LengthSensor;
pub use line::{LineFit, ResistanceLine, WireEnd};
pub use observer::{Drive, Motion, MotionObserver, ObserverConfig};
pub use reading::Reading;
pub use repeats::StuckAfter;
pub use sample::Sample;
pub use slide::{Bounds, SlideConfig, SlideWatch};
