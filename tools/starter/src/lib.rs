//! The first files of somebody's bench, made from what lies on it: a rig file with a comment to every line, which runs at once in simulation; a
//! first robot program; and what an editor needs to complete and check the rig file.
//!
//! ```
//! use sinew_starter::{Against, Bench, Quantity};
//!
//! let wire = sinew_rig::WireKind::of("flexinol-150-ht").expect("a wire that is sold");
//! let bench = Bench { length_m: Quantity::Length.read("6in")?, against: Against::Weight { force_n: 1.5 }, ..Bench::of("gripper", wire) };
//! let rig = sinew_rig::Rig::parse(&bench.rig_file(), "gripper.toml")?;
//! assert_eq!(rig.channels[0].model.geometry.diameter_m, wire.diameter_m);
//! rig.check_drivable()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod bench;
mod files;
mod quantity;

pub use bench::{Against, Bench, Doubt};
pub use files::{File, Language, files};
pub use quantity::{Malformed, Quantity};
