//! The rig file: one TOML description of wires, drives, loads, limits and control for everything in the project.
//!
//! [`Rig::load`] reads, checks and completes a file, or says every mistake in it with file, line, key and remedy.
//! [`Rig::to_toml`] writes a changed rig back into its own text, comments and order kept.
//! The format is described in `docs/rig.md`; the tables of that page and this crate come from one schema.
#![forbid(unsafe_code)]

mod derive;
mod effects;
mod error;
mod generated;
mod parameters;
mod read;
mod schema;
mod suggest;
mod tree;
mod types;
mod write;

use std::path::Path;

pub use effects::catalogue;
pub use error::{Error, Problem, What};
pub use parameters::{Parameter, Prior, default_priors, parameters, range_of};
pub use schema::{reference, word, words};
pub use suggest::nearest;
pub use types::{
    Access, Adc, Algorithm, Backend, BackendKind, BlackBox, Channel, Column, ColumnMap, Control, Estimator, FaultKind,
    Joint, Limits, LinuxChannel, LinuxInput, LinuxInterfaces, LinuxPhase, LinuxSampling, MAX_CHANNEL_NAME,
    MAX_CHANNELS, MAX_DRIVEN_RATE_HZ, MAX_PATH, MAX_RIG_NAME, MIN_DRIVEN_RATE_HZ, Machine, Pace, Polarity,
    PositionZero, RapidHeating, Realtime, RealtimeMode, Rig, SamplingCircuit, Sensing, SerialLine, SimulatedFault,
    Simulation,
};

/// The columns a recording can have: the keys of [`ColumnMap`].
pub const RECORDING_COLUMNS: [&str; 13] = read::COLUMNS;

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

    /// Which channel of a serial front-end a channel of the rig is.
    pub fn front_end_index(&self, channel: usize) -> Option<u32> {
        let own = self.channels.get(channel)?.front_end_index;
        own.or(u32::try_from(channel).ok())
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

    /// Checks what the driver needs beyond what `simulate` does: a rate it can keep, and wires it can heat by PWM
    /// and move.
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
