//! `sinew import`: foreign recordings in our formats, and guesses at what is in them.

use std::path::Path;

use sinew_exchange::{Imported, session};
use sinew_import::{Bench, Synchronised, confirm, guess, mapping, recording, synchronised};
use sinew_recording::{Options, Recording, write};
use sinew_rig::{Channel, FileFormat, Mapping, Rig};

use super::export::{foreign, spare};
use super::parquet::parquet;
use super::simulate::recording_failure;
use super::{choose_channel, load_rig, rig_failure};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::format::Format;
use crate::output;

/// Runs the command.
pub fn import(args: &args::Import) -> Outcome {
    if !args.guess && Format::of(&args.foreign) == Some(Format::Session) {
        return Err(Failure::input(format!("{}: is a session already", args.foreign.display()))
            .hint("every command takes it as it is; `sinew export` brings it into other formats"));
    }
    let rig = args.rig.as_deref().map(|path| load_rig(Some(path))).transpose()?;
    let rig = rig.as_ref().map(|rig| Ok((rig, choose_channel(rig, args.channel.as_deref())?))).transpose()?;
    match (rig, &args.output) {
        _ if args.guess => tell(args, rig.map(|(_, channel)| channel)),
        (Some((rig, channel)), Some(output)) => bring_in(args, rig, channel, output),
        // the command line asks for both
        _ => Err(Failure::input("--rig and -o are needed").hint("or --guess, to see what is in the file")),
    }
}

/// Says what is in a file, and writes the mapping.
fn tell(args: &args::Import, channel: Option<&Channel>) -> Outcome {
    if let Some(path) = &args.output {
        if path.extension().is_none_or(|end| end != "toml") {
            return Err(Failure::input(format!("{}: is no name for a mapping", path.display()))
                .hint("--guess writes a mapping: end its name in .toml; `sinew import FILE --map MAP.toml` brings the file in"));
        }
        output::has_place(path)?;
        spare(path, &args.foreign)?;
    }
    let given = FileFormat { sheet: args.sheet.clone(), ..FileFormat::default() };
    let table = sinew_import::read(&args.foreign, &given).map_err(import_failure)?;
    let guess = guess(&table, channel.map(Bench::of).as_ref(), args.rate);
    let name = args.foreign.display().to_string();
    output::print(confirm(&name, &table, &guess))?;
    if let Some(path) = &args.output {
        let own = args.foreign.file_name().map_or(name, |own| own.to_string_lossy().into_owned());
        output::write_file(path, mapping(&own, &table, &guess))?;
        output::note(format_args!("{}: the mapping; look at its lines with ? first", path.display()));
    }
    Ok(())
}

fn bring_in(args: &args::Import, rig: &Rig, channel: &Channel, output: &Path) -> Outcome {
    let Some(format) = Format::of(output) else {
        return Err(Failure::input(format!("{}: is no format to import into", output.display()))
            .hint("end its name in .mcap, .csv, .csv.gz or .parquet"));
    };
    output::has_place(output)?;
    spare(output, &args.foreign)?;
    let own = args.map.as_deref().map(Mapping::load).transpose().map_err(mapping_failure)?;
    let recording = match &own {
        Some(mapping) => understood(args, mapping, channel)?,
        None if rig.recording.format != FileFormat::default() || Format::of(&args.foreign).is_none() => {
            understood(args, &rig.recording, channel)?
        }
        None => {
            let options = Options {
                ignore_columns: args.ignore_columns,
                columns: Some(&rig.recording.columns),
                model: Some(&channel.model),
                ..Options::default()
            };
            sinew_recording::read(&args.foreign, &options).map_err(recording_failure)?
        }
    };
    let (recording, clock) = match &args.clock {
        Some(pairs) => on_the_drivers_time(&recording, pairs)?,
        None => (recording, None),
    };
    let rows = recording.len();
    if format == Format::Csv {
        write(output, &recording).map_err(recording_failure)?;
    } else {
        let mut about = foreign(&args.foreign, &rig.name, Some(rig.text()));
        about.extra.extend(clock.map(|said| ("clock".to_string(), said)));
        let imported = Imported::new(recording, &channel.name, about).map_err(recording_failure)?;
        match format {
            Format::Parquet => parquet(&imported, &[], output)?,
            _ => session(&imported, output).map_err(recording_failure)?,
        };
    }
    output::note(format_args!("{}: {rows} rows of {}", output.display(), channel.name));
    Ok(())
}

/// A recording by a device's own clock, on the driver's, and what that is off by.
fn on_the_drivers_time(recording: &Recording, pairs: &Path) -> Result<(Recording, Option<String>), Failure> {
    let Synchronised { recording, error_s, rate_ppm: (ppm, error_ppm), outside } =
        synchronised(recording, pairs).map_err(import_failure)?;
    let way = if ppm < 0.0 { "slow" } else { "fast" };
    let rate = format!("its clock runs {:.1} ± {error_ppm:.1} ppm {way}", ppm.abs());
    let mut said = format!("times are the driver's within ± {:.3} ms; {rate}", 1e3 * error_s);
    if outside > 0 {
        said += &format!("; {outside} rows are before the first pair or behind the last");
    }
    output::note(format_args!("{}: {said}", pairs.display()));
    Ok((recording, Some(said)))
}

/// What is wrong with a mapping.
fn mapping_failure(error: sinew_rig::Error) -> Failure {
    match &error {
        sinew_rig::Error::Unreadable { .. } => {
            Failure::input(&error).hint("check the path; `sinew import --guess FILE -o MAP.toml` writes a mapping")
        }
        sinew_rig::Error::Invalid { .. } => rig_failure(&error),
    }
}

/// A file of any kind by a mapping.
fn understood(args: &args::Import, mapping: &Mapping, channel: &Channel) -> Result<Recording, Failure> {
    let table = sinew_import::read(&args.foreign, &mapping.format).map_err(import_failure)?;
    recording(&args.foreign, &table, mapping, Some(&channel.model)).map_err(recording_failure)
}

pub(super) fn import_failure(error: sinew_import::Error) -> Failure {
    Failure::input(error.place_and_message()).hint(error.hint)
}
