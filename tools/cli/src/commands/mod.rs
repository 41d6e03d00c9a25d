//! The commands, one file each.

mod admission;
mod attached;
pub mod bench;
pub mod bench_control;
pub mod characterise;
mod check;
pub mod design;
pub mod diagnose;
pub mod doctor;
pub mod export;
mod fitting;
pub mod identify;
pub mod import;
pub mod live;
pub mod monitor;
mod mounted;
pub mod plot;
pub mod record;
pub mod recording;
pub mod replay;
pub mod run;
pub mod scope;
pub mod set;
pub mod simulate;
pub mod status;
pub mod test;
pub mod tune;

use std::path::Path;

use sinew_rig::{Channel, Rig, nearest};

use crate::failure::Failure;

/// Reads a rig file, or takes the built-in hexapod.
fn load_rig(path: Option<&Path>) -> Result<Rig, Failure> {
    let Some(path) = path else { return Ok(Rig::hexapod()) };
    Rig::load(path).map_err(|error| rig_failure(&error))
}

/// A rig file's mistakes, every one on its line.
pub fn rig_failure(error: &sinew_rig::Error) -> Failure {
    let hint = match error {
        sinew_rig::Error::Unreadable { .. } => "check the path; a rig file is TOML, docs/rig.md describes it".into(),
        sinew_rig::Error::Invalid { problems } if problems.len() > 1 => {
            format!("{} places to mend; docs/rig.md has every key with its range and default", problems.len())
        }
        sinew_rig::Error::Invalid { .. } => "docs/rig.md has every key with its range and default".to_string(),
    };
    Failure::input(error).hint(hint)
}

/// The channel that is meant: the named one, or the only one.
fn choose_channel<'a>(rig: &'a Rig, name: Option<&str>) -> Result<&'a Channel, Failure> {
    let names = || rig.channels.iter().map(|channel| channel.name.as_str());
    match (name, rig.channels.as_slice()) {
        (None, [only]) => Ok(only),
        (None, _) => Err(Failure::input(format!("{}: has {} channels", rig.file(), rig.channels.len()))
            .hint(format!("choose one with --channel: {}", list(names())))),
        (Some(name), _) => match rig.channel(name) {
            Some((_, channel)) => Ok(channel),
            None => Err(unknown_channel(rig.file(), name, names())),
        },
    }
}

/// A channel that does not exist, with the ones that do.
fn unknown_channel<'a>(place: &str, name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Failure {
    let failure = Failure::input(format!("{place}: has no channel \"{name}\""));
    match nearest(name, known.clone()) {
        Some(near) => failure.hint(format!("did you mean \"{near}\"?")),
        None => failure.hint(format!("its channels are {}", list(known))),
    }
}

/// Names in a row.
fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
