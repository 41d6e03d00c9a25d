//! `sinew test characterise`: from an unknown wire to a fitted rig file.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::Ordering;

use sinew_diagnosis::Settings;
use sinew_machine::characterise::{
    Characterised, Place, Recorded, believed, fit, fitted_rig, foretell, judge, tasks, tasks_on_rig,
};
use sinew_machine::running::most_power_w;
use sinew_machine::{Ending, RoutineKind, analysis, record};
use sinew_recording::Recording;

use super::mounted::{Bench, Done, Task};
use crate::args;
use crate::commands::diagnose::write_all;
use crate::commands::fitting::{diagnosis_failure, warn};
use crate::commands::identify::parameters_table;
use crate::commands::simulate::recording_failure;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;
use crate::table::columns;

/// Runs the command.
pub fn characterise(args: &args::Characterise) -> Outcome {
    let bench = Bench::read(&args.wire)?;
    output::can_become_folder(&args.out)?;
    let (model, spec) = (&bench.wire().model, &bench.spec);
    let (place, tasks) = match bench.on_rig() {
        Some(on_rig) => {
            let kind = RoutineKind::ConstantForceSweep;
            let options = on_rig.options(kind, bench.wire(), spec);
            on_rig.check(kind, &options, bench.wire())?;
            (Place::Rig, tasks_on_rig(model, &options, most_power_w(bench.wire())))
        }
        None => (Place::Machine, tasks(model, spec)),
    };
    let asked = ending::asked()?;
    let mut recorded = Vec::new();
    let mut pages = Vec::new();
    for (number, task) in tasks.into_iter().enumerate() {
        let one = Task {
            kind: task.kind,
            options: &task.options,
            seed: number as u64,
            name: task.name,
            out: Some(&args.out),
            real_time: false,
        };
        let Done { ran, routine, simulated, notes, at_rest } = bench.run(&one, &asked)?;
        let run = analysis::Run {
            kind: task.kind,
            options: &task.options,
            stages: routine.stages(),
            rows: &ran.rows,
            model,
            spec,
            at_rest,
        };
        let report = sinew_machine::Report::of(&run, &ran, simulated, bench.sources(at_rest), bench.about(), notes);
        pages.push((format!("{}.html", task.name), sinew_machine::page(&run, &report)));
        match &ran.ending {
            Ending::Complete => {}
            Ending::Stopped => {
                output::note(format_args!(
                    "stopped in {}: nothing was fitted; {} has what was recorded",
                    task.name,
                    args.out.display()
                ));
                return Ok(());
            }
            Ending::Failed(error) if bench.on_rig().is_some() => {
                return Err(super::test::ended(task.name, error, Some(&args.out)));
            }
            ending => {
                return Err(Failure::own(format!("{}: {ending}", task.name))
                    .hint("the rig file's beliefs may be far off, or its limits too narrow for this wire"));
            }
        }
        let recording = match place {
            Place::Machine => record::recording(task.name, &ran.rows).map_err(recording_failure)?,
            Place::Rig => recorded_by_driver(&bench, &args.out.join(format!("{}.mcap", task.name)))?,
        };
        recorded.push(Recorded { task, recording });
    }
    let progress = Progress::new();
    let tell = |stage: &str, share: f64| progress.tell(stage, share);
    let settings =
        Settings { seed: args.seed, jobs: args.jobs.map_or(0, usize::from), thorough: false, progress: &tell };
    let identified = fit(&bench.rig, bench.channel, place, &recorded, &settings);
    progress.clear();
    let identified = identified.map_err(|error| diagnosis_failure(&error))?;
    let judged = judge(&bench.rig, bench.channel, place, &identified, &recorded).map_err(recording_failure)?;
    let json = output::json(&judged)? + "\n";
    let text = format!("{}\n{}", parameters_table(&identified), table(&judged));
    let rigs = [
        ("fitted.toml", fitted_rig(&bench.rig, bench.channel, &identified).to_toml()),
        ("rig.toml", place.recorded(&bench.rig, bench.channel).to_toml()),
        ("characterise.json", json.clone()),
    ];
    let as_believed = believed(&bench.rig, bench.channel, place, &identified);
    let unseen: Vec<_> = recorded.iter().filter(|r| !r.task.is_fitted).collect();
    let foretold = unseen
        .iter()
        .map(|r| {
            Ok((
                *r,
                foretell(&as_believed, bench.channel, &r.recording)?,
                foretell(&identified.rig, bench.channel, &r.recording)?,
            ))
        })
        .collect::<Result<Vec<_>, sinew_recording::Error>>()
        .map_err(recording_failure)?;
    pages.push(("report.html".into(), sinew_machine::characterise::page(&judged, &bench.about(), &foretold)));
    let files: Vec<(&str, &str)> = rigs
        .iter()
        .map(|(name, text)| (*name, text.as_str()))
        .chain(pages.iter().map(|(name, text)| (name.as_str(), text.as_str())))
        .collect();
    write_all(&args.out, &files)?;
    warn(&judged.warnings);
    output::note(format_args!("written: {}", args.out.display()));
    asked.store(false, Ordering::Relaxed);
    if args.json { output::print(json) } else { output::print(text) }
}

/// What the driver has recorded of the wire, in as many rows a second as the routine had.
fn recorded_by_driver(bench: &Bench, path: &Path) -> Result<Recording, Failure> {
    let wire = bench.wire();
    let options =
        sinew_recording::Options { model: Some(&wire.model), channel: Some(&wire.name), ..Default::default() };
    let recording = sinew_recording::read(path, &options).map_err(recording_failure)?;
    let rows = 1.0 / (bench.spec.rate_hz * recording.median_interval_s());
    record::in_rows_of(&recording, rows.round() as usize, &wire.model).map_err(recording_failure)
}

/// How every recording is met, before and after.
fn table(judged: &Characterised) -> String {
    let head = ["recording", "routine", "chi as believed", "chi fitted", "the fit saw it"].map(String::from);
    let rows = judged.recordings.iter().map(|met| {
        [
            met.recording.clone(),
            met.routine.to_string(),
            format!("{:.2}", met.chi_as_believed),
            format!("{:.3}", met.chi),
            if met.fitted { "yes" } else { "no" }.to_string(),
        ]
    });
    let mut text = columns(std::iter::once(head).chain(rows).collect());
    let _ = writeln!(text, "\nchi of what no fit saw: {:.3}", judged.chi_unseen);
    text
}
