//! `sinew record`: every cycle of a running driver into a file.

use std::io::{self, IsTerminal};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use serde::Serialize;
use signal_hook::consts::SIGXFSZ;
use sinew_recorder::{Error, Live, Options, Recorder, Removed, Report, Warning};
use sinew_recording::session::{Ended, size};

use super::live;
use crate::args;
use crate::commands::recording::gaps;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output::{self, counted};

/// Version of the summary's JSON.
const SCHEMA: &str = "sinew.record/1";
/// Exit code when cycles were lost.
const LOST: u8 = 3;

/// Takes away the line that changes.
const CLEAR: &[u8] = b"\r\x1b[2K";

/// Runs the command.
pub fn record(args: &args::Record) -> Outcome {
    output::has_place(&args.file)?;
    let client = live::connect(&args.target)?;
    let (rig, channels, rate_hz) = (client.info().rig.to_string(), client.channels().len(), client.info().rate_hz);
    let asked = ending::asked()?;
    log::never_wait()?;
    // A file that may not grow any further (`ulimit -f`) is an error, reported like a full disk, not a sudden end.
    signal_hook::flag::register(SIGXFSZ, Arc::default())
        .map_err(|error| Failure::own(format!("signal {SIGXFSZ} cannot be handled: {error}")))?;
    let options = Options {
        overwrite: args.force,
        compression: args.compression.into(),
        duration_s: args.duration_s,
        max_bytes: args.max_size,
        max_file_s: args.max_time,
        keep_files: args.keep_files,
        keep_bytes: args.keep_size,
        keep_free_bytes: args.keep_free,
        ..Options::new(&args.file)
    };
    let recorder = Recorder::start(client, options).map_err(failure)?;
    output::note(format_args!(
        "recording {rig} ({} at {rate_hz} Hz) to {}; Ctrl-C ends it",
        counted(channels, "channel"),
        args.file.display()
    ));
    watch(&recorder, &|| asked.load(Ordering::Relaxed));
    recorder.stop();
    let report = recorder.join();
    report.warnings.iter().for_each(warn);
    if args.json {
        output::print_json(&Summary::of(&report))?;
    } else {
        output::print(text(&report))?;
    }
    verdict(report)
}

fn warn(warning: &Warning) {
    output::note(format_args!("warning: {warning}"));
}

/// Shows how it does, until it ends or `over` says so: on a terminal a line that changes.
fn watch(recorder: &Recorder, over: &dyn Fn() -> bool) {
    let shows = io::stderr().is_terminal();
    let mut next = Instant::now();
    while recorder.is_running() && !over() {
        let warnings = recorder.warnings();
        if shows && !warnings.is_empty() {
            log::say(CLEAR);
        }
        warnings.iter().for_each(warn);
        if shows && Instant::now() >= next {
            next += Duration::from_millis(500);
            log::say(&[CLEAR, line(&recorder.live()).as_bytes()].concat());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    if shows {
        log::say(CLEAR);
    }
}

fn line(live: &Live) -> String {
    let Live { cycles, lost, seconds, bytes, waiting, .. } = live;
    let mut line = format!("{seconds:.1} s  {cycles} cycles  {lost} lost  {}", size(*bytes));
    if *waiting > 8 << 20 {
        line += &format!("  {} waiting for the disk", size(*waiting));
    }
    if live.part > 0 {
        line += &format!("  file {}", live.part + 1);
    }
    line
}

/// The summary as JSON.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    schema: &'static str,
    files: Vec<&'a Path>,
    removed_files: u64,
    removed_cycles: u64,
    removed_bytes: u64,
    ended: &'static str,
    seconds: f64,
    cycles: u64,
    lost: u64,
    gaps: Vec<[u64; 2]>,
    missed: u64,
    not_written: u64,
    bytes: u64,
    payload_bytes: u64,
    error: Option<String>,
}

impl Summary<'_> {
    fn of(report: &Report) -> Summary<'_> {
        Summary {
            schema: SCHEMA,
            files: report.files.iter().map(|path| path.as_path()).collect(),
            removed_files: report.removed.files,
            removed_cycles: report.removed.cycles,
            removed_bytes: report.removed.bytes,
            ended: report.ended.word(),
            seconds: report.seconds,
            cycles: report.cycles,
            lost: report.lost,
            gaps: report.gaps.iter().map(|gap| [gap.from, gap.to]).collect(),
            missed: report.missed,
            not_written: report.not_written,
            bytes: report.bytes,
            payload_bytes: report.payload,
            error: report.failure.as_ref().map(Error::to_string),
        }
    }
}

fn text(report: &Report) -> String {
    let Report { cycles, lost, missed, seconds, bytes, payload, files, .. } = report;
    let ratio = if *payload > 0 { *bytes as f64 / *payload as f64 } else { f64::NAN };
    let mut text = format!("{seconds:.1} s, {cycles} cycles, {lost} lost, {missed} periods the driver missed\n");
    if report.removed != Removed::default() {
        let Removed { files, cycles, bytes } = report.removed;
        text += &format!("  {files} older files with {cycles} of these cycles were removed ({})\n", size(bytes));
    }
    for file in files {
        text += &format!("  {}\n", file.display());
    }
    text += &format!("  {} ({:.0} % of the {} recorded)\n", size(*bytes), 100.0 * ratio, size(*payload));
    match report.ended {
        Ended::DriverStopped => text += "  the driver stopped\n",
        Ended::DriverDied => text += "  the driver died\n",
        _ => {}
    }
    text
}

/// What a recording's end means for the exit code.
fn verdict(report: Report) -> Outcome {
    if let Some(error) = report.failure {
        let file = report.files.last().map(|path| path.display().to_string()).unwrap_or_default();
        let at_the_floor = matches!(error, Error::Floor { .. });
        let error = failure(error);
        return Err(match report.not_written {
            0 if at_the_floor => {
                error.also(format_args!("the recording ended there; nothing is lost, and {file} is whole"))
            }
            0 => error,
            n => error.also(format_args!(
                "{n} cycles are not written; the {} before them are whole in {file}",
                report.cycles
            )),
        });
    }
    if report.lost > 0 {
        return Err(Failure::of_code(LOST, format!("{} cycles were lost: {}", report.lost, gaps(&report.gaps, 0)))
            .hint("the file lists them too; a machine that is too busy loses cycles: see `sinew doctor`, or write to a faster disk"));
    }
    Ok(())
}

/// Why there is no recording, with what to do about it.
pub fn failure(error: Error) -> Failure {
    match error {
        Error::Driver(error) => live::failure(error),
        error => {
            let failure = if error.is_bad_input() { Failure::input(&error) } else { Failure::own(&error) };
            failure.hint(error.remedy())
        }
    }
}
