//! `sinew import`: foreign recordings in our formats.

use sinew_exchange::{Imported, parquet, session};
use sinew_recording::{Options, write};

use super::export::{Format, foreign, spare};
use super::simulate::recording_failure;
use super::{choose_channel, load_rig};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Runs the command.
pub fn import(args: &args::Import) -> Outcome {
    let Some(format) = Format::of(&args.output) else {
        return Err(Failure::input(format!("{}: is no format to import into", args.output.display()))
            .hint("end its name in .mcap, .csv, .csv.gz or .parquet"));
    };
    let rig = load_rig(Some(&args.rig))?;
    let channel = choose_channel(&rig, args.channel.as_deref())?;
    if Format::of(&args.foreign) == Some(Format::Session) {
        return Err(Failure::input(format!("{}: is a session already", args.foreign.display()))
            .hint("every command takes it as it is; `sinew export` brings it into other formats"));
    }
    output::has_place(&args.output)?;
    spare(&args.output, &args.foreign)?;
    let options = Options {
        ignore_columns: args.ignore_columns,
        columns: Some(&rig.columns),
        model: Some(&channel.model),
        ..Options::default()
    };
    let recording = sinew_recording::read(&args.foreign, &options).map_err(recording_failure)?;
    let rows = recording.len();
    if format == Format::Csv {
        write(&args.output, &recording).map_err(recording_failure)?;
    } else {
        let about = foreign(&args.foreign, &rig.name, Some(rig.text()));
        let imported = Imported::new(recording, &channel.name, about).map_err(recording_failure)?;
        match format {
            Format::Parquet => parquet(&imported, &[], &args.output),
            _ => session(&imported, &args.output),
        }
        .map_err(recording_failure)?;
    }
    output::note(format_args!("{}: {rows} rows of {}", args.output.display(), channel.name));
    Ok(())
}
