//! `sinew export`: recordings in the formats other tools read.

use std::path::{Path, PathBuf};

use sinew_exchange::{CsvFile, Imported, SessionPart, Table, csv};
use sinew_recording::session::{About, Session};
use sinew_recording::{Options, Recording, write};

use super::parquet::parquet;
use super::simulate::recording_failure;
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::format::Format;
use crate::output::{self, counted};
use crate::progress::Progress;

/// Runs the command.
pub fn export(args: &args::Export) -> Outcome {
    let format = Format::of(&args.output);
    if !matches!(format, Some(Format::Csv | Format::Parquet)) {
        return Err(Failure::input(format!("{}: is no format to export to", args.output.display()))
            .hint("end its name in .csv, .csv.gz or .parquet; `sinew import` writes .mcap"));
    }
    output::has_place(&args.output)?;
    spare(&args.output, &args.recording)?;
    let (from_s, to_s) = (args.from_s.unwrap_or(f64::NEG_INFINITY), args.to_s.unwrap_or(f64::INFINITY));
    if from_s >= to_s {
        return Err(Failure::input(format!("--from {from_s} --to {to_s}: there is nothing in between"))
            .hint("give the earlier time to --from"));
    }
    if Format::of(&args.recording) == Some(Format::Csv) {
        return export_rows(args, format, from_s, to_s);
    }

    let session = Session::open(&args.recording).map_err(recording_failure)?;
    let channels = channels(&session, &args.channels)?;
    let progress = Progress::new();
    progress.tell("exporting", 0.0);
    if format == Some(Format::Parquet) {
        let part = Watched { table: SessionPart { session: &session, from_s, to_s }, progress: &progress };
        let rows = parquet(&part, &channels, &args.output);
        progress.clear();
        let rows = rows?;
        output::note(format_args!(
            "{}: {rows} cycles of {}",
            args.output.display(),
            counted(channels.len(), "channel")
        ));
        return Ok(());
    }
    let files: Vec<CsvFile> = match channels.as_slice() {
        [channel] => vec![CsvFile { channel: *channel, path: args.output.clone() }],
        several => several
            .iter()
            .map(|channel| CsvFile {
                channel: *channel,
                path: named_after(&args.output, &session.layout().channels[*channel]),
            })
            .collect(),
    };
    let written = csv(&session, &files, from_s, to_s);
    progress.clear();
    let (rows, lost) = written.map_err(recording_failure)?;
    for file in &files {
        output::note(format_args!("{}: {}", file.path.display(), session.layout().channels[file.channel]));
    }
    output::note(format_args!("{} rows a channel", rows / files.len().max(1) as u64));
    if lost > 0 {
        output::note(format_args!(
            "warning: the recorder lost {lost} cycles; across them the last duty that is known is held"
        ));
    }
    Ok(())
}

/// A table that shows how far it has been read.
struct Watched<'a, T> {
    table: T,
    progress: &'a Progress,
}

impl<T: Table> Table for Watched<'_, T> {
    fn about(&self) -> &About {
        self.table.about()
    }

    fn layout(&self) -> &sinew_recording::session::Layout {
        self.table.layout()
    }

    fn count(&self) -> u64 {
        self.table.count()
    }

    fn each(
        &self,
        see: &mut dyn FnMut(&sinew_exchange::Cycle<'_>) -> Result<(), sinew_recording::Error>,
    ) -> Result<(), sinew_recording::Error> {
        let (all, mut seen) = (self.count().max(1) as f64, 0u64);
        self.table.each(&mut |cycle| {
            seen += 1;
            if seen.is_multiple_of(4096) {
                self.progress.tell("exporting", seen as f64 / all);
            }
            see(cycle)
        })
    }
}

/// The channels meant, by index; all of them where none is named.
fn channels(session: &Session, names: &[String]) -> Result<Vec<usize>, Failure> {
    if names.is_empty() {
        return Ok((0..session.layout().channels.len()).collect());
    }
    let mut channels = Vec::new();
    for name in names {
        let known = || session.layout().channels.iter().map(String::as_str);
        let channel = known()
            .position(|channel| channel == name)
            .ok_or_else(|| super::unknown_channel(session.name(), name, known()))?;
        if !channels.contains(&channel) {
            channels.push(channel);
        }
    }
    Ok(channels)
}

/// The file of one channel among several: its name stands before the ending.
fn named_after(path: &Path, channel: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let end = [".csv.gz", ".csv"].into_iter().find(|end| name.to_ascii_lowercase().ends_with(end)).unwrap_or_default();
    let (stem, end) = name.split_at(name.len() - end.len());
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    path.with_file_name(format!("{stem}-{}{end}", channel.chars().map(plain).collect::<String>()))
}

/// A recording that is CSV already: into another place, compressed or not, or into Parquet.
fn export_rows(args: &args::Export, format: Option<Format>, from_s: f64, to_s: f64) -> Outcome {
    let recording = sinew_recording::read(&args.recording, &Options::default()).map_err(recording_failure)?;
    let recording = between(&recording, from_s, to_s)?;
    if format == Some(Format::Csv) {
        return write(&args.output, &recording).map_err(recording_failure);
    }
    let name = match args.channels.as_slice() {
        [] => "wire",
        [name] => name,
        _ => {
            return Err(Failure::input(format!("{}: has one channel", args.recording.display()))
                .hint("--channel gives it its name, once"));
        }
    };
    let about = foreign(&args.recording, "", None);
    let imported = Imported::new(recording, name, about).map_err(recording_failure)?;
    parquet(&imported, &[], &args.output).map(|_| ())
}

/// The rows from one time to another.
fn between(recording: &Recording, from_s: f64, to_s: f64) -> Result<Recording, Failure> {
    let kept: Vec<usize> = recording
        .time_s()
        .iter()
        .enumerate()
        .filter(|(_, t)| (from_s..to_s).contains(*t))
        .map(|(row, _)| row)
        .collect();
    let pick = |values: &[f64]| kept.iter().map(|row| values[*row]).collect::<Vec<f64>>();
    let mut part = Recording::new(recording.name(), pick(recording.time_s())).map_err(recording_failure)?;
    for (column, values) in recording.columns() {
        part.set(column, pick(values)).map_err(recording_failure)?;
    }
    Ok(part)
}

/// What is known of a foreign recording: the rig, and when its file was last written.
pub fn foreign(path: &Path, rig: &str, rig_toml: Option<&str>) -> About {
    let written = path.metadata().and_then(|there| there.modified()).ok();
    let since = written.and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok()).unwrap_or_default();
    About {
        rig: rig.into(),
        rate_hz: f64::NAN,
        software: concat!("sinew ", env!("CARGO_PKG_VERSION")).into(),
        kind: sinew_exchange::IMPORT.into(),
        simulated: false,
        started_unix_ns: u64::try_from(since.as_nanos()).unwrap_or(0),
        started_monotonic_ns: 0,
        rig_toml: rig_toml.map(str::to_string),
        extra: [("source".to_string(), path.file_name().unwrap_or_default().to_string_lossy().into_owned())].into(),
    }
}

/// Refuses to write over what is read.
pub fn spare(output: &Path, input: &Path) -> Outcome {
    match (output.canonicalize(), input.canonicalize()) {
        (Ok(output_there), Ok(input_there)) if output_there == input_there => {
            Err(Failure::input(format!("{}: is the recording itself", output.display()))
                .hint("name another file for -o: what was recorded is not to be overwritten"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_known_by_the_end_of_its_name() {
        for (name, format) in [
            ("a.csv", Some(Format::Csv)),
            ("a/b.CSV.GZ", Some(Format::Csv)),
            ("a.parquet", Some(Format::Parquet)),
            ("a.mcap", Some(Format::Session)),
            ("a.gz", None),
            (".csv", None),
            ("csv", None),
        ] {
            assert_eq!(Format::of(Path::new(name)), format, "{name}");
        }
    }

    #[test]
    fn each_channel_of_several_has_a_file_of_its_own_name() {
        assert_eq!(named_after(Path::new("x/walk.csv.gz"), "front_left"), Path::new("x/walk-front_left.csv.gz"));
        assert_eq!(named_after(Path::new("walk.csv"), "a/b c"), Path::new("walk-a_b_c.csv"));
    }
}
