//! `sinew diagnose`: where a recording and its simulation differ, the missing physical effect, and the rig file with it.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sinew_diagnosis::{Diagnosis, NEXT_PROGRAMME, SCHEMA, Settings};
use sinew_recording::{Recording, Utc};
use sinew_report::About;

use super::bundle::{Bundle, Given};
use super::fitting::{Input, command, has_colour, sha256, sources, spare_inputs, width, work};
use crate::args;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;

/// The answer for programs.
pub const JSON: &str = "diagnosis.json";
/// The rig file with what was found in it.
pub const IMPROVED: &str = "improved.toml";
/// The answer for people.
pub const REPORT: &str = "report.html";
/// The recordings as measured and simulated, where that is asked for.
pub const PICTURE: &str = "picture.svg";

/// Files that some answers have and others have not.
const SOMETIMES: [&str; 2] = [PICTURE, NEXT_PROGRAMME];
/// A file larger than this is none of an answer, bytes: an hour of recording makes a picture of less than a hundredth of it.
const MOST_BYTES: u64 = 1 << 28;

/// `diagnosis.json`: the answer, and which files that not every answer has belong to it.
#[derive(Serialize)]
struct Written<'a> {
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    /// SHA-256 by name.
    files: BTreeMap<&'a str, String>,
}

/// What an earlier `diagnosis.json` says of files.
#[derive(Deserialize)]
struct Earlier {
    schema: String,
    files: BTreeMap<String, String>,
}

/// Runs the command.
pub fn diagnose(args: &args::Diagnose) -> Outcome {
    let fitting = &args.fitting;
    let input = Input::read(fitting, &args.holdout)?;
    let recordings = || fitting.recordings.iter().chain(&args.holdout);
    let files = sources(fitting, recordings())?;
    output::can_become_folder(&args.out)?;
    for name in [REPORT, JSON, IMPROVED, PICTURE, NEXT_PROGRAMME] {
        let path = args.out.join(name);
        spare_inputs(&path, fitting, recordings())?;
        is_no_folder(&path)?;
    }
    Bundle::can_be_written(args)?;
    let outcome = work(fitting, |settings| {
        let settings = Settings { thorough: args.thorough, ..*settings };
        sinew_diagnosis::diagnose(&input.rig, input.channel, &input.recordings, &input.held_out, &settings)
    })?;
    let about = About {
        rig: input.rig.name.clone(),
        channel: input.channel_name().to_string(),
        command: command(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        date: Utc::now().to_string(),
        files: files.clone(),
    };
    let page = sinew_report::html(&outcome.diagnosis, &outcome.figures, &about);
    let picture = args.picture.then(|| sinew_report::picture(&outcome.diagnosis, &outcome.figures));
    let next = outcome.next_programme.as_ref().map(as_csv).transpose()?;
    // from here to the end Ctrl-C is ignored, so that no partial result is left: it takes a moment
    let _asked = ending::asked()?;
    let improved = outcome.improved.to_toml();
    let more = [(PICTURE, picture.as_deref()), (NEXT_PROGRAMME, next.as_deref())];
    let more: Vec<(&str, &str)> = more.into_iter().filter_map(|(name, text)| Some((name, text?))).collect();
    let listed = more.iter().map(|(name, text)| (*name, sha256(text.as_bytes()))).collect();
    let json = output::json(&Written { diagnosis: &outcome.diagnosis, files: listed })? + "\n";
    let answer: Vec<_> =
        [(REPORT, page.as_str()), (JSON, &json), (IMPROVED, &improved)].into_iter().chain(more).collect();
    let former = Former::beside(&args.out, &answer);
    write_all(&args.out, &answer)?;
    former.clear()?;
    let [fitted, held_out] = [&fitting.recordings, &args.holdout].map(|paths| paths.iter().map(Given::of).collect());
    let answer: Vec<_> = answer.into_iter().map(|(name, text)| (PathBuf::from(name), text)).collect();
    Bundle::keep(args, [fitted, held_out], &files, &answer)?;
    if fitting.json {
        output::print(json)?;
    } else {
        output::print(sinew_report::text(&outcome.diagnosis, width(), has_colour()))?;
        output::note(format_args!(
            "written: {}",
            list(&args.out, answer.iter().map(|(name, _)| name), args.bundle.as_deref())
        ));
    }
    Ok(())
}

/// Refuses a folder in the place of a file.
pub fn is_no_folder(path: &Path) -> Outcome {
    if path.is_dir() {
        return Err(Failure::input(format!("{}: is a folder", path.display())).hint("choose another --out"));
    }
    Ok(())
}

/// Writes all files or none: each beside its place first, then all of them moved there.
pub fn write_all(out: &Path, files: &[(&str, &str)]) -> Outcome {
    let failed = |error: std::io::Error| {
        Failure::own(format!("{}: cannot be written: {error}", out.display()))
            .hint("check the folder, its free space and that you may write there")
    };
    fs::create_dir_all(out).map_err(failed)?;
    let part = |name: &str| out.join(format!(".{name}.{}.part", std::process::id()));
    let parts: Vec<(PathBuf, PathBuf)> = files.iter().map(|(name, _)| (part(name), out.join(name))).collect();
    let written = files
        .iter()
        .zip(&parts)
        .try_for_each(|((_, text), (part, _))| fs::write(part, text))
        .and_then(|()| parts.iter().try_for_each(|(part, path)| fs::rename(part, path)));
    written.map_err(|error| {
        parts.iter().for_each(|(part, _)| drop(fs::remove_file(part)));
        failed(error)
    })
}

/// Files in the answer's folder that would be taken for part of it and are not.
struct Former {
    /// As an earlier answer wrote them.
    ours: Vec<PathBuf>,
    /// Of whoever wrote them.
    others: Vec<PathBuf>,
}

impl Former {
    /// Those beside an answer that is to be written. A file is an earlier answer's if that answer lists it and nobody has changed
    /// it since.
    fn beside(out: &Path, files: &[(&str, &str)]) -> Former {
        let earlier: Option<Earlier> = bytes(&out.join(JSON)).and_then(|json| serde_json::from_slice(&json).ok());
        let listed = earlier.filter(|earlier| earlier.schema == SCHEMA).map_or_else(BTreeMap::new, |e| e.files);
        let absent = SOMETIMES.into_iter().filter(|name| files.iter().all(|(written, _)| written != name));
        let (ours, others) = absent
            .map(|name| (name, out.join(name)))
            .filter(|(_, path)| path.exists())
            .partition::<Vec<_>, _>(|(name, path)| {
                listed.get(*name).is_some_and(|digest| bytes(path).is_some_and(|there| sha256(&there) == *digest))
            });
        let paths = |named: Vec<(&str, PathBuf)>| named.into_iter().map(|(_, path)| path).collect();
        Former { ours: paths(ours), others: paths(others) }
    }

    /// Takes away what an earlier answer wrote, and says of the rest that it is no part of this one.
    fn clear(self) -> Outcome {
        for path in &self.others {
            output::note(format_args!("left as it is: {}, which is no part of this answer", path.display()));
        }
        for path in &self.ours {
            fs::remove_file(path).map_err(|error| {
                Failure::own(format!("{}: is of an earlier answer and cannot be removed: {error}", path.display()))
                    .hint("remove it: it is no part of this answer, which is written")
            })?;
        }
        Ok(())
    }
}

/// What is in a file of an answer; nothing where it cannot be read or is too large to be one.
fn bytes(path: &Path) -> Option<Vec<u8>> {
    let file = fs::File::open(path).ok().filter(|file| file.metadata().is_ok_and(|about| about.is_file()))?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 <= MOST_BYTES).then_some(bytes)
}

/// A recording as the text of its file.
pub fn as_csv(recording: &Recording) -> Result<String, Failure> {
    let mut csv = Vec::new();
    sinew_recording::write_to(&mut csv, recording)
        .map_err(|error| Failure::own(format!("{}: cannot be written: {error}", recording.name())))?;
    Ok(String::from_utf8_lossy(&csv).into_owned())
}

/// What was written, in words.
pub fn list(out: &Path, names: impl Iterator<Item = impl AsRef<Path>>, bundle: Option<&Path>) -> String {
    let files = names.map(|name| out.join(name)).chain(bundle.map(Path::to_path_buf));
    files.map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}
