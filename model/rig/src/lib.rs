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

mod declare;
mod derive;
mod edit;
mod effects;
mod error;
mod key;
mod notes;
mod parameters;
mod read;
mod reference;
mod suggest;
mod tables;
mod tree;
mod write;

use std::path::Path;

use read::value::wrong_number;

pub use effects::catalogue;
pub use error::{Error, Problem, What};
pub use key::Prior;
pub use parameters::{Parameter, default_priors, parameters, range_of};
pub use reference::{reference, word, words};
pub use suggest::nearest;
pub use tables::MAX_PATH;
pub use tables::*;

/// The rig file of the built-in hexapod.
pub const HEXAPOD_TOML: &str = include_str!("../../../examples/hexapod.toml");

impl Rig {
    /// Reads a rig file.
    ///
    /// # Errors
    /// [`Error::Unreadable`] where the file cannot be read as text, else as [`Rig::parse`].
    pub fn load(path: &Path) -> Result<Rig, Error> {
        let file = path.display().to_string();
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) => return Err(Error::Unreadable { file, reason: error.to_string() }),
        };
        match String::from_utf8(bytes) {
            Ok(text) => Rig::parse(&text, &file),
            Err(error) => {
                let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
                let line = 1 + good.iter().filter(|b| **b == b'\n').count();
                Err(Error::Unreadable { file, reason: format!("line {line} is not UTF-8 text; is this a rig file?") })
            }
        }
    }

    /// Reads the text of a rig file; `file` is what messages call it.
    ///
    /// # Errors
    /// [`Error::Invalid`] with every mistake found, each with its line, its key and what would be right.
    pub fn parse(text: &str, file: &str) -> Result<Rig, Error> {
        read::rig(text, file)
    }

    /// The built-in rig: a hexapod of eighteen wires, three joints to each of six legs.
    ///
    /// # Panics
    /// Never: its text is part of the program and a test reads it.
    pub fn hexapod() -> Rig {
        match Rig::parse(HEXAPOD_TOML, "examples/hexapod.toml") {
            Ok(rig) => rig,
            Err(error) => unreachable!("the built-in rig: {error}"),
        }
    }

    /// The channel of this name and its index.
    pub fn channel(&self, name: &str) -> Option<(usize, &Channel)> {
        self.channels.iter().enumerate().find(|(_, c)| c.name == name)
    }

    /// The joint a channel's wire turns and its side there, 0 = agonist; `None` where it has a load of its own.
    pub fn joint_of(&self, channel: usize) -> Option<(&Joint, usize)> {
        let name = &self.channels.get(channel)?.name;
        self.joints.iter().find_map(|joint| Some((joint, joint.side(name)?)))
    }

    /// The indices of a joint's channels, agonist first; `None` where one was renamed since the rig was read.
    pub fn channels_of(&self, joint: &Joint) -> Option<[usize; 2]> {
        Some([self.channel(&joint.agonist)?.0, self.channel(&joint.antagonist)?.0])
    }

    /// The wire of a channel in the load its stroke and limits are reckoned with, see [`Channel::nominal_model`].
    pub fn nominal_model(&self, channel: usize) -> sinew_physics::WireModel {
        self.channels[channel].nominal_model(self.joint_of(channel).map(|(joint, _)| joint))
    }

    /// Checks what the driver needs beyond what `simulate` does: a rate it can keep, wires it can heat by PWM and move, and
    /// numbers that a rig file could have said, for a program may have made this rig or changed it.
    ///
    /// # Errors
    /// [`Error::Invalid`] with every reason against it.
    pub fn check_drivable(&self) -> Result<(), Error> {
        use sinew_physics::{DriveKind, Load};
        let mut problems = Vec::new();
        let mut problem = |channel: Option<usize>, key: &str, what: What| {
            problems.push(Problem {
                file: self.source.file.clone(),
                line: read::line_of(&self.source, channel, key),
                channel: channel.map(|c| self.channels[c].name.clone()),
                key: key.to_string(),
                what,
            });
        };
        if !(MIN_DRIVEN_RATE_HZ..=MAX_DRIVEN_RATE_HZ).contains(&self.rate_hz) {
            let (found, low, high) = (self.rate_hz, MIN_DRIVEN_RATE_HZ, MAX_DRIVEN_RATE_HZ);
            problem(None, "rig.rate_hz", What::OutOfRange { found, low, high, defaulted: false });
        }
        for (index, channel) in self.channels.iter().enumerate() {
            for section in tables::of_channel() {
                for (key, what) in section.keys().filter_map(|key| Some((key.name, wrong_number(key, channel)?))) {
                    problem(Some(index), format!("{}.{key}", section.local()).trim_start_matches('.'), what);
                }
            }
            if channel.model.drive.kind != DriveKind::Pwm {
                let message = "cannot be driven: the driver heats by PWM only, expected \"pwm\"".into();
                problem(Some(index), "drive.kind", What::Contradiction { message });
            } else if channel.model.drive.supply_v <= 0.0 {
                let message = "is 0, expected the voltage the wire is driven from".into();
                problem(Some(index), "drive.supply_v", What::Contradiction { message });
            }
            let in_joint = self.joint_of(index).is_some();
            if !in_joint && !matches!(channel.model.load, Load::SpringMassDamper { .. }) {
                let message =
                    "cannot be driven: nothing moves, expected \"spring_mass_damper\" or a place in a [[joint]]".into();
                problem(Some(index), "load.kind", What::Contradiction { message });
            }
            if channel.control.minimum_duty <= 0.0 {
                let message = "is 0: without a current there is nothing to measure, expected more, such as 0.02".into();
                problem(Some(index), "control.sensing_duty", What::Contradiction { message });
            }
        }
        if problems.is_empty() { Ok(()) } else { Err(Error::Invalid { problems }) }
    }

    /// The rig as its file would be read again: computed limits and ranges follow parameters that were changed.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a field was set to something no rig file may say.
    pub fn refreshed(&self) -> Result<Rig, Error> {
        Rig::parse(&self.to_toml(), &self.source.file)
    }

    /// The file this rig came from, as it was asked for.
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// The text it was read from, as it was; later changes of fields are not in it, see [`Rig::to_toml`].
    pub fn text(&self) -> &str {
        &self.source.text
    }
}
