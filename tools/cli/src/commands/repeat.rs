//! `sinew repeat`: a diagnosis made again from its bundle, and the two answers beside each other.

use std::path::{Path, PathBuf};

use clap::Parser;
use serde_json::Value;

use super::bundle::Bundle;
use super::diagnose::JSON;
use super::{diagnose, whole_rig};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Runs the command.
pub fn repeat(args: &args::Repeat) -> Outcome {
    let bundle = Bundle::read(&args.bundle)?;
    let out = args.out.clone().unwrap_or_else(|| beside(&args.bundle));
    if out.exists() {
        return Err(Failure::input(format!("{}: is there already", out.display()))
            .hint("choose another --out: nothing is overwritten"));
    }
    output::can_become_folder(&out)?;
    let out = std::path::absolute(&out)
        .map_err(|error| Failure::own(format!("{}: has no absolute path: {error}", out.display())))?;
    let mut again = command(&bundle, &args.bundle, &out)?;
    again.fitting.jobs = args.jobs;
    let folder = tempfile::Builder::new().prefix("sinew-repeat-").tempdir();
    let folder = folder.map_err(|error| Failure::own(format!("no folder to unpack to: {error}")).hint("set TMPDIR"))?;
    bundle.unpack_inputs(folder.path()).and_then(|()| std::env::set_current_dir(folder.path())).map_err(|error| {
        Failure::own(format!("{}: cannot be unpacked: {error}", args.bundle.display()))
            .hint("check the free space of the folder for temporary files, or set TMPDIR to another")
    })?;
    match again.whole_rig {
        true => whole_rig::diagnose(&again)?,
        false => diagnose::diagnose(&again)?,
    }
    compare(&bundle, &out)
}

/// Where the new answer goes unless something else is asked for.
fn beside(bundle: &Path) -> PathBuf {
    let mut name = bundle.file_stem().unwrap_or_default().to_os_string();
    name.push("-again");
    PathBuf::from(name)
}

/// The bundle's command, which may name nothing but what is in the bundle.
fn command(bundle: &Bundle, path: &Path, out: &Path) -> Result<args::Diagnose, Failure> {
    let version = &bundle.manifest.version;
    let refused = |what: String| {
        Failure::input(format!("{}: {what}", path.display())).hint(format!("it was made by sinew {version}: use that"))
    };
    let words = std::iter::once("sinew").chain(bundle.manifest.words.iter().map(String::as_str));
    let words = words.map(Into::into).chain(["--out".into(), out.as_os_str().to_os_string()]);
    let cli = args::Cli::try_parse_from(words).map_err(|error| {
        let said = error.to_string();
        let first = said.lines().next().unwrap_or_default().trim_start_matches("error: ").to_string();
        refused(format!("its command is not understood here: {first}"))
    })?;
    let args::Command::Diagnose(again) = cli.command else {
        return Err(refused("its command is no diagnosis".into()));
    };
    let args::Fitting { rig, recordings, laws, .. } = &again.fitting;
    let recordings = recordings.iter().chain(&again.holdout).map(|given| {
        let place = given.to_str().unwrap_or_default();
        // CHANNEL=FILE
        let file = place.split_once('=').filter(|_| again.whole_rig).map_or(place, |(_, file)| file);
        PathBuf::from(file)
    });
    let named = std::iter::once(rig.clone()).chain(laws.catalogue.clone()).chain(recordings);
    if let Some(stranger) = named.into_iter().find(|place| bundle.renamed().all(|(there, _)| Path::new(there) != place))
    {
        return Err(refused(format!("its command names {}, which is not in it", stranger.display())));
    }
    Ok(again)
}

/// Says how the answer of the bundle and the new one differ; one of another verdict or with other effects is a failure.
fn compare(bundle: &Bundle, out: &Path) -> Outcome {
    let unreadable = |what: &str| Failure::own(format!("{what} cannot be read as JSON"));
    let parse = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).ok();
    let there = bundle.answer(JSON).and_then(parse).ok_or_else(|| unreadable("the bundle's answer"))?;
    let here = std::fs::read(out.join(JSON)).ok().and_then(|bytes| parse(&bytes));
    let mut here = here.ok_or_else(|| unreadable("the new answer"))?;
    as_typed(bundle, &mut here);
    let mut differences = Vec::new();
    differ("", &there, &here, &mut differences);
    let (made, ours) = (&bundle.manifest.version, args::VERSION);
    let by = if made == ours { format!("both by sinew {ours}") } else { format!("there sinew {made}, here {ours}") };
    if differences.is_empty() {
        return output::print(format!("The same answer as in the bundle, to the last digit ({by}).\n"));
    }
    let said = (said(&there), said(&here));
    if said.0 == said.1 {
        let numbers = if differences.len() == 1 { "One value differs" } else { "Values differ" };
        return output::print(format!(
            "The same verdict and effects as in the bundle ({by}).\n{numbers}: {} in all, most of all {}.\n",
            differences.len(),
            most(&differences)
        ));
    }
    Err(Failure::own(format!("another answer than in the bundle ({by})\n  there  {}\n  here   {}", said.0, said.1))
        .hint("use the version that made it to see whether it is the program or the machine"))
}

/// Names of recordings as they were when the bundle's own answer was made.
fn as_typed(bundle: &Bundle, value: &mut Value) {
    match value {
        Value::String(text) => {
            for (place, typed) in bundle.renamed() {
                *text = text.replace(place, typed);
            }
        }
        Value::Array(values) => values.iter_mut().for_each(|value| as_typed(bundle, value)),
        Value::Object(fields) => {
            let named = std::mem::take(fields).into_iter().map(|(mut name, mut value)| {
                for (place, typed) in bundle.renamed() {
                    name = name.replace(place, typed);
                }
                as_typed(bundle, &mut value);
                (name, value)
            });
            *fields = named.collect();
        }
        _ => {}
    }
}

/// A value that differs: where, and by which share of the larger one (1 where it is no number).
struct Difference {
    at: String,
    share: f64,
}

fn differ(at: &str, there: &Value, here: &Value, differences: &mut Vec<Difference>) {
    match (there, here) {
        (Value::Object(a), Value::Object(b)) => {
            // Hashes of drawings, which carry the date.
            let keys = a
                .keys()
                .chain(b.keys().filter(|key| !a.contains_key(*key)))
                .filter(|key| !(at.is_empty() && *key == "files"));
            for key in keys {
                let [a, b] = [a, b].map(|fields| fields.get(key).unwrap_or(&Value::Null));
                differ(&format!("{at}/{key}"), a, b, differences);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                differ(&format!("{at}/{index}"), a, b, differences);
            }
        }
        (a, b) if a == b => {}
        (a, b) => {
            let share = match (a.as_f64(), b.as_f64()) {
                (Some(a), Some(b)) => (a - b).abs() / a.abs().max(b.abs()),
                _ => 1.0,
            };
            differences.push(Difference { at: at.to_string(), share });
        }
    }
}

/// The largest difference, in words.
fn most(differences: &[Difference]) -> String {
    let Some(most) = differences.iter().max_by(|a, b| a.share.total_cmp(&b.share)) else { return String::new() };
    format!("{} by {:.1e} of it", most.at, most.share)
}

/// Verdict and effects; of a whole rig, each wire's.
fn said(answer: &Value) -> String {
    let mut words = Vec::new();
    gather("", answer, &mut words);
    words.join(", ")
}

fn gather(name: &str, value: &Value, words: &mut Vec<String>) {
    match (name, value) {
        ("verdict", Value::String(verdict)) => words.push(verdict.clone()),
        ("effects", Value::Array(effects)) => {
            words.extend(effects.iter().filter_map(|effect| effect["id"].as_str()).map(str::to_string));
        }
        (_, Value::Object(fields)) => {
            // The verdict first, as people say it.
            let first = fields.get_key_value("verdict").into_iter();
            for (name, value) in first.chain(fields.iter().filter(|(name, _)| *name != "verdict")) {
                gather(name, value, words);
            }
        }
        (_, Value::Array(values)) => values.iter().for_each(|value| gather("", value, words)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn differences(there: &Value, here: &Value) -> Vec<(String, f64)> {
        let mut found = Vec::new();
        differ("", there, here, &mut found);
        found.into_iter().map(|d| (d.at, d.share)).collect()
    }

    #[test]
    fn what_differs_is_told_by_its_place_and_size() {
        let there =
            json!({ "verdict": "agrees", "left": { "chi": 2.0, "p": [0.1, 0.2] }, "files": { "picture.svg": "a" } });
        assert_eq!(differences(&there, &there), []);
        let here = json!({ "verdict": "agrees", "left": { "chi": 1.0, "p": [0.1, 0.2] }, "files": {} });
        assert_eq!(differences(&there, &here), [("/left/chi".to_string(), 0.5)]);
        assert_eq!(said(&there), said(&here));
        let more = json!({ "verdict": "physics_missing", "effects": [{ "id": "thermal.draught" }] });
        assert_eq!(said(&more), "physics_missing, thermal.draught");
        assert!(differences(&there, &more).iter().any(|(at, share)| at == "/left" && *share == 1.0));
    }
}
