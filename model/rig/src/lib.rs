//! The rig file: one TOML description of wires, drives, loads, limits and control for everything in the project.
//!
//! [`Rig::load`] reads, checks and completes a file, or says every mistake in it with file, line, key and remedy.
//! [`Rig::to_toml`] writes a changed rig back into its own text, comments and order kept.
//! The format is described in `docs/rig.md`; the tables of that page, the reader and the writer are made from the same
//! tables of keys.
//!
//! ```
//! use sinew_rig::Rig;
//!
//! let text = r#"
//! [rig]
//! name = "bench"
//!
//! [[channel]]
//! name = "wire"
//! wire = { diameter_mm = 0.125, length_mm = 160.0 } # measured
//! drive = { supply_v = 6.0 }
//! load = { mass_kg = 0.2 }
//! "#;
//! let mut rig = Rig::parse(text, "bench.toml")?;
//! assert_eq!(rig.channels[0].model.geometry.length_m, 0.16);
//! assert_eq!(rig.channels[0].model.material.latent_heat_j_per_kg, 24_200.0, "the default");
//!
//! rig.set_parameter(0, "length_mm", 150.0)?;
//! assert_eq!(rig.to_toml(), text.replace("160.0", "150.0"));
//!
//! let error = Rig::parse(&text.replace("mass_kg", "mas_kg"), "bench.toml").unwrap_err().to_string();
//! assert!(error.contains("bench.toml:9: channel \"wire\": load.mas_kg is unknown, did you mean mass_kg?"), "{error}");
//! # Ok::<(), sinew_rig::Error>(())
//! ```
#![forbid(unsafe_code)]

mod choose;
mod complete;
mod declare;
mod derive;
mod doubts;
mod drivable;
mod edit;
mod effects;
mod error;
mod key;
mod notes;
mod own;
mod parameters;
mod read;
mod reference;
mod suggest;
mod tables;
mod tree;
mod value;
mod wires;
mod write;

pub use choose::NotChosen;
pub use doubts::{Doubt, LASTING_PULL_PA};
pub use drivable::LEAST_SILENCE_PERIODS;
pub use error::{Error, Problem, What};
pub use key::Prior;
pub use own::Catalogue;
pub use parameters::{Parameter, default_priors, is_tolerance, parameters};
pub use read::HEXAPOD_TOML;
pub use reference::{catalogue, reference, schema, word, words};
pub use suggest::nearest;
pub use tables::*;
pub use value::MAX_PATH;
pub use value::rounded;
pub use wires::{WIRE_KINDS, WireKind};
