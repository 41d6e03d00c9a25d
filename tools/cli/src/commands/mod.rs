//! The commands that need no driver, one file each, and what all commands share.

pub mod astm;
pub mod bundle;
pub mod conceal;
mod curves;
pub mod diagnose;
mod dsc;
pub mod export;
pub mod fitting;
pub mod identify;
pub mod import;
pub mod new;
mod parquet;
pub mod plot;
pub mod recording;
pub mod repeat;
pub mod rig_file;
pub mod shell;
pub mod simulate;
pub mod tune;
pub mod whole_rig;

use std::path::Path;

use sinew_rig::{Catalogue, Channel, HEXAPOD_TOML, Rig, nearest};

use crate::args;
use crate::failure::{Failure, Outcome};
use crate::format::Format;

/// Reads a rig file, or takes the built-in hexapod.
pub fn load_rig(path: Option<&Path>) -> Result<Rig, Failure> {
    load_rig_with(path, &args::Laws::default())
}

/// The same, with laws of one's own.
pub fn load_rig_with(path: Option<&Path>, laws: &args::Laws) -> Result<Rig, Failure> {
    let failure = |error: sinew_rig::Error| rig_failure(&error);
    let catalogue = laws.catalogue.as_deref().map(Catalogue::load).transpose().map_err(failure)?.unwrap_or_default();
    match path {
        Some(path) => {
            is_no_recording(path)?;
            Rig::load_with(path, &catalogue).map_err(failure)
        }
        None => Rig::parse_with(HEXAPOD_TOML, "the built-in hexapod", &catalogue).map_err(failure),
    }
}

/// Refuses a recording in the place of a rig file, by its name, before every line of it is told as a mistake.
fn is_no_recording(path: &Path) -> Outcome {
    match Format::of(path).is_some() {
        true => Err(Failure::input(format!("{}: is a recording by its name, not a rig file", path.display()))
            .hint("the rig file comes first, a .toml; the recording after it")),
        false => Ok(()),
    }
}

/// A rig file's mistakes, every one on its line.
pub fn rig_failure(error: &sinew_rig::Error) -> Failure {
    let hint = match error {
        sinew_rig::Error::Unreadable { .. } => "check the path; a rig file is TOML, docs/rig.md describes it".into(),
        sinew_rig::Error::Invalid { problems } => {
            let page = match problems.iter().all(|problem| problem.key.contains("effects.\"own.")) {
                true => "docs/own-physics.md has what a law of one's own may say",
                false => "docs/rig.md has every key with its range and default",
            };
            match problems.len() {
                1 => page.to_string(),
                count => format!("{count} places to mend; {page}"),
            }
        }
    };
    Failure::input(error).hint(hint)
}

/// The channel that is meant: the named one, or the only one.
pub fn choose_channel<'a>(rig: &'a Rig, name: Option<&str>) -> Result<&'a Channel, Failure> {
    match rig.chosen(name) {
        Ok(index) => Ok(&rig.channels[index]),
        Err(error) => Err(Failure::input(&error).hint(error.remedy("--channel"))),
    }
}

/// A channel that does not exist, with the ones that do.
pub fn unknown_channel<'a>(place: &str, name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Failure {
    let failure = Failure::input(format!("{place}: has no channel \"{name}\""));
    match nearest(name, known.clone()) {
        Some(near) => failure.hint(format!("did you mean \"{near}\"?")),
        None => failure.hint(format!("its channels are {}", list(known))),
    }
}

/// Names in a row.
pub fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
