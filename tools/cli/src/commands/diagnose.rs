//! `sinew diagnose`: where a recording and its simulation differ, the missing physical effect, and the rig file with it.

use std::fs;
use std::path::{Path, PathBuf};

use sinew_diagnosis::NEXT_PROGRAMME;
use sinew_recording::{Recording, Utc};
use sinew_report::About;

use super::fitting::{Input, command, has_colour, sources, spare_inputs, width, work};
use super::monitor::signals;
use crate::args;
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

/// Runs the command.
pub fn diagnose(args: &args::Diagnose) -> Outcome {
    let fitting = &args.fitting;
    let input = Input::read(fitting, &args.holdout)?;
    let recordings = || fitting.recordings.iter().chain(&args.holdout);
    let files = sources(fitting, recordings())?;
    can_become_folder(&args.out)?;
    for name in [REPORT, JSON, IMPROVED, PICTURE, NEXT_PROGRAMME] {
        let path = args.out.join(name);
        spare_inputs(&path, fitting, recordings())?;
        is_no_folder(&path)?;
    }
    let outcome = work(fitting, |settings| {
        sinew_diagnosis::diagnose(&input.rig, input.channel, &input.recordings, &input.held_out, settings)
    })?;
    let about = About {
        rig: input.rig.name.clone(),
        channel: input.channel_name().to_string(),
        command: command(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        date: Utc::now().to_string(),
        files,
    };
    let json = output::json(&outcome.diagnosis)? + "\n";
    let page = sinew_report::html(&outcome.diagnosis, &outcome.figures, &about);
    let picture = args.picture.then(|| sinew_report::picture(&outcome.diagnosis, &outcome.figures));
    let next = outcome.next_programme.as_ref().map(as_csv).transpose()?;
    // from here to the end Ctrl-C is ignored, so that no partial result is left: it takes a moment
    let _asked = signals()?;
    let improved = outcome.improved.to_toml();
    let more = [(PICTURE, picture.as_deref()), (NEXT_PROGRAMME, next.as_deref())];
    let more = more.into_iter().filter_map(|(name, text)| Some((name, text?)));
    let files: Vec<_> =
        [(REPORT, page.as_str()), (JSON, &json), (IMPROVED, &improved)].into_iter().chain(more).collect();
    write_all(&args.out, &files)?;
    if fitting.json {
        output::print(json)?;
    } else {
        output::print(sinew_report::text(&outcome.diagnosis, width(), has_colour()))?;
        output::note(format_args!(
            "written: {}",
            list(&args.out, &files.iter().map(|(name, _)| *name).collect::<Vec<_>>())
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

/// Finds out before the work, not after it, that the answer has no place.
pub fn can_become_folder(out: &Path) -> Outcome {
    let there = out.ancestors().map(|path| if path.as_os_str().is_empty() { Path::new(".") } else { path });
    let Some(nearest) = there.into_iter().find(|path| path.exists()) else { return Ok(()) };
    if !nearest.is_dir() {
        return Err(Failure::input(format!("{}: is a file, not a folder", nearest.display()))
            .hint("choose another --out, or move that file away"));
    }
    tempfile_in(nearest).map_err(|error| {
        Failure::input(format!("{}: cannot be written to: {error}", nearest.display()))
            .hint("choose an --out where you may write")
    })
}

/// Makes a file and takes it away again: permissions say less than trying.
fn tempfile_in(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!(".sinew.{}.part", std::process::id()));
    fs::write(&path, "").and_then(|()| fs::remove_file(&path))
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

/// A recording as the text of its file.
pub fn as_csv(recording: &Recording) -> Result<String, Failure> {
    let mut csv = Vec::new();
    sinew_recording::write_to(&mut csv, recording)
        .map_err(|error| Failure::own(format!("{}: cannot be written: {error}", recording.name())))?;
    Ok(String::from_utf8_lossy(&csv).into_owned())
}

pub fn list(out: &Path, names: &[&str]) -> String {
    names.iter().map(|name| out.join(name).display().to_string()).collect::<Vec<_>>().join(", ")
}
