//! Where a simulation and a recording differ, what physics was left out, and what it explains on data never fitted.
//!
//! [`diagnose`] names the missing physics, [`identify`] fits the parameters alone, beside what was [`Measured`] of them elsewhere, and [`check`] runs the gates that both
//! pass first: what is wrong with a recording itself is an error with its remedy, never a verdict.
//!
//! # Example
//! ```
//! use sinew_diagnosis::{Error, Trouble, check};
//! use sinew_recording::{Column, Recording};
//! use sinew_rig::Rig;
//!
//! let rig = Rig::parse(
//!     r#"
//! [rig]
//! name = "bench"
//! rate_hz = 100.0
//! [[channel]]
//! name = "wire"
//! [channel.wire]
//! diameter_mm = 0.125
//! length_mm = 160.0
//! [channel.drive]
//! supply_v = 6.0
//! [channel.load]
//! mass_kg = 0.13
//! damping_n_s_per_m = 30.0
//! spring_n_per_m = 150.0
//! preload_n = 2.6
//! "#,
//!     "bench.toml",
//! )?;
//! let channel = &rig.channels[0];
//!
//! // twenty seconds of stairs, as the wire of the rig file itself would show them
//! let time_s: Vec<f64> = (0..2000).map(|i| f64::from(i) / 100.0).collect();
//! let duty = time_s.iter().map(|t| [0.05, 0.3, 0.02, 0.35][(t / 3.0) as usize % 4]).collect();
//! let mut monday = Recording::new("monday.csv", time_s)?;
//! monday.set(Column::Duty, duty)?;
//! let shown = |row: Result<(_, _), _>| row.map(|(_, seen)| Column::PositionM.of_outputs(&seen).unwrap_or(f64::NAN));
//! let position = monday.simulated(&channel.model)?.map(shown).collect::<Result<Vec<f64>, _>>()?;
//! monday.set(Column::PositionM, position.clone())?;
//! assert!(check(&monday, channel)?.is_empty());
//!
//! // the same in millimetres is no recording of this wire
//! monday.set(Column::PositionM, position.iter().map(|m| 1e3 * m).collect())?;
//! match check(&monday, channel) {
//!     Err(Error::Broken(broken)) => assert!(matches!(broken.what, Trouble::Impossible { .. })),
//!     other => panic!("{other:?}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod answer;
mod conditions;
mod data;
mod derivatives;
mod describe;
mod diagnose;
mod discrepancy;
mod edges;
mod error;
mod evidence;
mod experiment;
mod explanation;
mod figures;
mod fit;
mod gates;
mod grade;
mod identify;
mod intervals;
mod locate;
mod measured;
mod noise;
mod numbers;
mod prepare;
mod products;
mod progress;
mod remains;
mod residuals;
mod screen;
mod select;
mod settings;
mod shares;
mod simulate;
mod space;
mod stages;
mod starts;
mod tolerances;
mod unknown;
mod whitening;
mod whole_rig;
mod words;

pub use answer::*;
pub use diagnose::{Outcome, diagnose};
pub use error::{Broken, Error, Trouble};
pub use experiment::NEXT_PROGRAMME;
pub use gates::{Exclude, LEAST_SAMPLES, MOST_SAMPLES, Warning, check, sensors};
pub use identify::{Identified, identify};
pub use measured::{ByRecordings, Measured, MeasuredParameter};
pub use noise::{Noise, estimate};
pub use settings::Settings;
pub use whole_rig::{RIG_SCHEMA, RigDiagnosis, RigOutcome, SharedFinding, SharedTried, WireRecordings, diagnose_rig};

#[cfg(test)]
mod testing;
#[cfg(test)]
mod valley;
