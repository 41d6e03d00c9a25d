//! Laboratories' own files, read and understood.
//!
//! [`read`] turns any file that is known into named columns of numbers, a [`Table`].
#![forbid(unsafe_code)]

mod bench;
mod bytes;
mod clock;
mod contain;
mod decode;
mod direction;
mod error;
mod grid;
mod guess;
mod import;
mod mat;
mod numbers;
mod read;
mod reading;
mod report;
mod sheet;
mod statistics;
mod table;
mod tdms;
mod text;
mod units;
mod words;

pub use bench::Bench;
pub use error::Error;
pub use guess::{Guess, Understood, guess};
pub use import::recording;
pub use read::{MAX_BYTES, read, read_bytes};
pub use report::{confirm, mapping};
pub use table::{Column, ROW_NUMBER, Table};
