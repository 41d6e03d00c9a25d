//! `sinew simulate`: a recording's inputs drive the model, and the simulated sensors are written row by row.

use std::io::{self, BufWriter};
use std::path::Path;

use sinew_physics::WireModel;
use sinew_recording::{Options, Recording, SimulatedColumns, Writer};

use super::{choose_channel, load_rig_with};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Runs the command.
pub fn simulate(args: &args::Simulate) -> Outcome {
    let rig = load_rig_with(Some(&args.rig), &args.laws)?;
    let channel = choose_channel(&rig, args.channel.as_deref())?;
    let options = Options {
        ignore_columns: args.ignore_columns,
        columns: Some(&rig.recording.columns),
        model: Some(&channel.model),
        channel: Some(&channel.name),
        ..Options::default()
    };
    let recording = sinew_recording::read(&args.inputs, &options).map_err(recording_failure)?;
    output::has_place(&args.output)?;
    if let (Ok(from), Ok(to)) = (args.inputs.canonicalize(), args.output.canonicalize())
        && from == to
    {
        return Err(Failure::input(format!("{}: is the recording itself", args.output.display()))
            .hint("name another file for -o: what was measured is not to be overwritten"));
    }
    let columns = SimulatedColumns::of(&recording, &channel.model);
    let names = columns.names();
    let writer = if args.output == Path::new("-") {
        Writer::to_stream(Box::new(BufWriter::new(io::stdout())), "stdout", &names)
    } else {
        Writer::create_named(&args.output, &names)
    };
    let written = writer.and_then(|writer| rows(&recording, &channel.model, &columns, writer));
    match written {
        Err(error) if args.output == Path::new("-") && error.to_string().contains("Broken pipe") => Ok(()),
        written => written.map_err(recording_failure),
    }
}

/// Steps the wire through the recording, one row at a time.
fn rows(
    recording: &Recording,
    model: &WireModel,
    columns: &SimulatedColumns,
    mut writer: Writer,
) -> Result<(), sinew_recording::Error> {
    let mut cells = Vec::new();
    for (simulated, &time_s) in recording.simulated(model)?.zip(recording.time_s()) {
        let (inputs, outputs) = simulated?;
        cells.clear();
        cells.extend(columns.values(&inputs, &outputs));
        writer.row(time_s, &cells)?;
    }
    writer.finish()
}

/// A recording's mistake with its place and remedy.
pub fn recording_failure(error: sinew_recording::Error) -> Failure {
    let failure = if error.is_bad_input() { Failure::input(error.message()) } else { Failure::own(error.message()) };
    failure.hint(error.hint())
}
