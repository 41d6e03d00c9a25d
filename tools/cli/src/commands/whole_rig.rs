//! `sinew diagnose --whole-rig`: several wires at once, an answer for each and one for what they share.

use std::path::{Path, PathBuf};

use sinew_diagnosis::{MOST_SAMPLES, NEXT_PROGRAMME, Settings, WireRecordings};
use sinew_recording::{Options, Utc};
use sinew_report::About;
use sinew_rig::Rig;

use super::bundle::{self, Bundle};
use super::diagnose::{IMPROVED, JSON, PICTURE, REPORT, as_csv, is_no_folder, list, write_all};
use super::fitting::{command, has_colour, read_all, sources, spare_inputs, width, work};
use super::load_rig_with;
use crate::args;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;

/// A file that is given, and what it is of.
struct Given {
    /// Name of the channel; every channel of the session where there is none.
    channel: Option<String>,
    path: PathBuf,
}

impl Given {
    /// `CHANNEL=FILE`, or a session of all channels.
    fn parse(rig: &Rig, text: &Path) -> Result<Given, Failure> {
        let named = text.to_str().and_then(|text| text.split_once('='));
        if let Some((name, path)) = named.filter(|(name, _)| rig.channel(name).is_some()) {
            return Ok(Given { channel: Some(name.to_string()), path: path.into() });
        }
        let is_session = text.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap"));
        if is_session || rig.channels.len() == 1 {
            return Ok(Given { channel: None, path: text.to_path_buf() });
        }
        let names: Vec<&str> = rig.channels.iter().map(|channel| channel.name.as_str()).collect();
        Err(Failure::input(format!("{}: does not say which channel it is of", text.display()))
            .hint(format!("write CHANNEL=FILE; the channels are {}", names.join(", "))))
    }

    /// As it goes into a bundle.
    fn in_bundle(&self) -> bundle::Given<'_> {
        bundle::Given { channel: self.channel.as_deref(), path: &self.path }
    }

    /// The files of one channel.
    fn of(all: &[Given], channel: &str) -> Vec<PathBuf> {
        let of_it = all.iter().filter(|given| given.channel.as_deref().is_none_or(|name| name == channel));
        of_it.map(|given| given.path.clone()).collect()
    }
}

/// Runs the command.
pub fn diagnose(args: &args::Diagnose) -> Outcome {
    let fitting = &args.fitting;
    let rig = load_rig_with(Some(&fitting.rig), &fitting.laws)?;
    let parse = |paths: &[PathBuf]| paths.iter().map(|path| Given::parse(&rig, path)).collect::<Result<Vec<_>, _>>();
    let (fitted, held_out) = (parse(&fitting.recordings)?, parse(&args.holdout)?);
    let recordings = || fitted.iter().chain(&held_out).map(|given| &given.path);
    let wires = read(&rig, &fitted, &held_out, fitting.ignore_columns)?;
    let files = sources(fitting, recordings())?;
    output::can_become_folder(&args.out)?;
    let folders = || std::iter::once(args.out.clone()).chain(wires.iter().map(|wire| folder(args, &rig, wire)));
    for folder in folders() {
        output::can_become_folder(&folder)?;
        for name in [REPORT, JSON, IMPROVED, PICTURE, NEXT_PROGRAMME] {
            spare_inputs(&folder.join(name), fitting, recordings())?;
            is_no_folder(&folder.join(name))?;
        }
    }
    Bundle::can_be_written(args)?;
    let outcome = work(fitting, |settings| {
        let settings = Settings { thorough: args.thorough, ..*settings };
        sinew_diagnosis::diagnose_rig(&rig, &wires, &settings)
    })?;
    let about = |channel: &str| About {
        rig: rig.name.clone(),
        channel: channel.to_string(),
        command: command(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        date: Utc::now().to_string(),
        files: files.clone(),
    };
    let json = output::json(&outcome.diagnosis)? + "\n";
    let page = sinew_report::rig_html(&outcome.diagnosis, &about(""));
    let improved = outcome.improved.to_toml();
    let mut answers: Vec<(PathBuf, Vec<(&str, String)>)> = Vec::new();
    for (name, wire) in &outcome.wires {
        let mut of_wire = vec![
            (REPORT, sinew_report::html(&wire.diagnosis, &wire.figures, &about(name))),
            (JSON, output::json(&wire.diagnosis)? + "\n"),
        ];
        if args.picture {
            of_wire.push((PICTURE, sinew_report::picture(&wire.diagnosis, &wire.figures)));
        }
        if let Some(next) = &wire.next_programme {
            of_wire.push((NEXT_PROGRAMME, as_csv(next)?));
        }
        answers.push((args.out.join(name), of_wire));
    }
    answers.push((args.out.clone(), vec![(REPORT, page), (JSON, json.clone()), (IMPROVED, improved)]));
    // from here to the end Ctrl-C is ignored, so that no partial result is left: it takes a moment
    let _asked = ending::asked()?;
    for (folder, answer) in &answers {
        let answer: Vec<(&str, &str)> = answer.iter().map(|(name, text)| (*name, text.as_str())).collect();
        write_all(folder, &answer)?;
    }
    let kept: Vec<(PathBuf, &str)> = answers
        .iter()
        .flat_map(|(folder, files)| {
            let folder = folder.strip_prefix(&args.out).unwrap_or(folder);
            files.iter().map(move |(name, text)| (folder.join(name), text.as_str()))
        })
        .collect();
    let recordings = [&fitted, &held_out].map(|all| all.iter().map(Given::in_bundle).collect());
    Bundle::keep(args, recordings, &files, &kept)?;
    if fitting.json {
        return output::print(json);
    }
    output::print(sinew_report::rig_text(&outcome.diagnosis, width(), has_colour()))?;
    output::note(format_args!(
        "written: {}, and each wire's in a folder there",
        list(&args.out, [REPORT, JSON, IMPROVED].into_iter(), args.bundle.as_deref())
    ));
    Ok(())
}

/// Where a wire's own answer is written.
fn folder(args: &args::Diagnose, rig: &Rig, wire: &WireRecordings) -> PathBuf {
    args.out.join(&rig.channels[wire.channel].name)
}

/// The recordings of every channel there are any of.
fn read(rig: &Rig, fitted: &[Given], held_out: &[Given], ignore_columns: bool) -> Result<Vec<WireRecordings>, Failure> {
    let mut wires = Vec::new();
    for (channel, of_rig) in rig.channels.iter().enumerate() {
        let (fitted, held_out) = (Given::of(fitted, &of_rig.name), Given::of(held_out, &of_rig.name));
        if fitted.is_empty() && held_out.is_empty() {
            continue;
        }
        let options = Options {
            ignore_columns,
            columns: Some(&rig.recording.columns),
            model: Some(&of_rig.model),
            max_rows: MOST_SAMPLES,
            channel: Some(&of_rig.name),
        };
        let (recordings, held_out) = read_all(&fitted, &held_out, &options)?;
        wires.push(WireRecordings { channel, recordings, held_out });
    }
    Ok(wires)
}
