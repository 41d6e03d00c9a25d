//! Laboratories' own files, read and understood.
//!
//! [`read`](read()) turns any file that is known into named columns of numbers, a [`Table`]; [`guess`](guess()) says which column is what, in
//! which unit and which way round, with what speaks for it and what is in doubt; [`confirm`] and [`mapping`](mapping()) write that down for people and
//! as the mapping of a rig file; [`recording`](recording()) brings a table in by a mapping; [`quantity`](quantity()) finds one quantity of a material
//! test. Nothing is changed that is not said.
//!
//! # Example
//! ```
//! use sinew_import::{guess, read_bytes};
//! use sinew_recording::Column;
//! use sinew_rig::FileFormat;
//!
//! let text = "Zeit [ms];Weg [mm];Kraft [N]\n0,0;7,5;-1,9\n20,0;7,4;-2,0\n40,0;7,0;-1,9\n";
//! let table = read_bytes(text.as_bytes(), &FileFormat::default())?;
//! let understood = guess(&table, None, None);
//! assert_eq!(understood.mapping.columns["time_s"].scale, 1e-3);
//! // a wire pulls: the load cell counts the other way, which is proposed and said
//! assert_eq!(understood.mapping.columns["force_n"].scale, -1.0);
//! assert!(understood.columns[2].doubts[0].starts_with("TURNED ROUND"));
//!
//! let recording = sinew_import::recording("lab.csv".as_ref(), &table, &understood.mapping, None)?;
//! assert_eq!(recording.get(Column::PositionM), Some(&[0.0075, 0.0074, 0.007][..]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod arrays;
mod bench;
mod bytes;
mod clock;
#[cfg(feature = "formats")]
mod contain;
mod decode;
mod direction;
mod error;
mod grid;
mod guess;
#[cfg(feature = "formats")]
mod hdf5;
mod import;
mod mat;
mod numbers;
mod quantity;
mod read;
mod reading;
mod report;
#[cfg(feature = "formats")]
mod sheet;
mod statistics;
mod synchronise;
mod table;
mod tdms;
mod text;
mod units;
mod words;

pub use bench::Bench;
pub use error::Error;
pub use guess::{Guess, Understood, guess};
pub use import::recording;
pub use quantity::{Found, Quantity, quantity};
pub use read::{MAX_BYTES, read, read_bytes};
pub use report::{confirm, mapping};
pub use synchronise::{Synchronised, synchronised};
pub use table::{Column, ROW_NUMBER, Table};
pub use units::heading;
