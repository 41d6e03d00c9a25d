//! Recordings in and out: what was measured on a wire, one column a quantity, in files any lab can read.
//!
//! [`read`] takes a CSV file (plain or gzipped) apart and refuses what cannot be trusted, naming the line, the column and
//! the remedy; [`Recording`] holds the columns; [`Recording::inputs_for`] turns them into what a simulated wire is
//! driven by; [`write()`] and [`Writer`] put columns back, digit for digit, never leaving half a file behind.
//!
//! [`session`] is the driver's own kind of recording: MCAP, every cycle of all channels in one file. [`rows`] makes
//! columns of one channel of it, and [`read`] takes either.
//!
//! # What a row means
//! A row's inputs hold from its time to the time of the next row, and its measured columns are what the sensors measured at
//! the *end* of that interval, in the on-phase. What is imposed (position, force, temperature) moves in a straight line
//! and reaches the row's value at the end of the row's interval. The last row's interval is as long as the one before.
//!
//! # Example
//! ```
//! use sinew_recording::{Column, Options, read_from};
//!
//! let csv = "time_s,duty,position_m\n0.00,0.0,0.0081\n0.01,0.4,0.0081\n0.02,0.4,0.0079\n";
//! let recording = read_from(csv.as_bytes(), "monday.csv", &Options::default())?;
//! assert_eq!(recording.get(Column::Duty), Some(&[0.0, 0.4, 0.4][..]));
//!
//! // what cannot be trusted is refused, with its place and the remedy
//! let error = read_from("time_s,duty\n0,0\n1,50\n".as_bytes(), "tuesday.csv", &Options::default()).unwrap_err();
//! assert_eq!((error.line, error.column.as_deref()), (Some(3), Some("duty")));
//! assert!(error.hint().contains("scale = 0.01"));
//! # Ok::<(), sinew_recording::Error>(())
//! ```
#![forbid(unsafe_code)]

mod column;
mod columns;
mod error;
mod options;
mod read;
mod recording;
pub mod rows;
pub mod session;
mod simulated;
mod simulated_columns;
mod smooth;
mod suggest;
mod table;
mod together;
mod utc;
mod write;

pub use column::{Column, TIME, drive_column, drive_word, imposed_column, required_inputs};
pub use error::{Error, Miscount, Needed, What};
pub use options::{MAX_ROWS, Options};
pub use read::{read, read_from, read_table};
pub use recording::{MAX_DURATION_S, MIN_SAMPLES, Recording};
pub use simulated_columns::SimulatedColumns;
pub use table::MAX_LINE_BYTES;
pub use together::simulated_together;
pub use utc::Utc;
pub use write::{Part, Writer, write, write_to};

#[cfg(test)]
pub(crate) mod testing {
    use sinew_physics::{Drive, DriveKind, Geometry, Initial, Load, Material, WireModel};

    /// A 0.125 mm wire of 160 mm that lifts 0.2 kg.
    pub(crate) fn model() -> WireModel {
        WireModel {
            geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
            material: Material::default(),
            taps: None,
            drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
            load: Load::SpringMassDamper {
                mass_kg: 0.2,
                damping_n_s_per_m: 40.0,
                spring_n_per_m: 0.0,
                preload_n: 1.96133,
            },
            initial: Initial::default(),
            ambient_c: 25.0,
            effects: sinew_physics::Effects::default(),
        }
    }
}
