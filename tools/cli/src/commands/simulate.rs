//! `sinew simulate`: a recording's inputs drive the model, and the simulated sensors are written row by row.

use std::io::{self, BufWriter};
use std::path::Path;

use sinew_physics::{DriveKind, Inputs, Outputs, WireModel};
use sinew_recording::{Column, Options, Recording, Writer, drive_column, imposed_column};

use super::{choose_channel, load_rig_with};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// The martensite fraction: no sensor measures it, but the model knows it.
const MARTENSITE: &str = "martensite";

/// Runs the command.
pub fn simulate(args: &args::Simulate) -> Outcome {
    let rig = load_rig_with(Some(&args.rig), &args.laws)?;
    let channel = choose_channel(&rig, args.channel.as_deref())?;
    let options = Options {
        ignore_columns: args.ignore_columns,
        columns: Some(&rig.columns),
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
    let columns = columns(&recording, &channel.model);
    let names: Vec<&str> = columns.iter().map(|column| column.name()).collect();
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

/// One column of the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Written {
    /// As it drove the model.
    Input(Column),
    /// As the model has it at the end of the row.
    Output(Column),
    /// ξ at the end of the row.
    Martensite,
}

impl Written {
    fn name(self) -> &'static str {
        match self {
            Written::Input(column) | Written::Output(column) => column.name(),
            Written::Martensite => MARTENSITE,
        }
    }
}

/// The inputs as they are in the recording, then everything the model can say of a sensor, in any case whatever the
/// recording measures: so the two files can be laid side by side.
fn columns(recording: &Recording, model: &WireModel) -> Vec<Written> {
    let drive = drive_column(model.drive.kind);
    let imposed = imposed_column(&model.load);
    let optional = [Column::SupplyV, Column::AmbientC, Column::DisturbanceN];
    let inputs: Vec<Column> = [Some(drive), imposed]
        .into_iter()
        .flatten()
        .chain(optional.into_iter().filter(|column| recording.get(*column).is_some()))
        .collect();
    // a furnace and a given power tell nothing of currents and voltages
    let electrical = matches!(model.drive.kind, DriveKind::Pwm | DriveKind::Current);
    let outputs = [
        (Column::CurrentA, electrical),
        (Column::V1V, electrical && model.taps.is_some()),
        (Column::V2V, electrical && model.taps.is_some()),
        (Column::V3V, electrical),
        (Column::ForceN, true),
        (Column::PositionM, true),
        (Column::PowerW, model.drive.kind != DriveKind::Temperature),
        (Column::TemperatureC, true),
    ];
    let outputs = outputs
        .into_iter()
        .filter(|(column, known)| (*known || recording.get(*column).is_some()) && !inputs.contains(column))
        .map(|(column, _)| Written::Output(column));
    inputs.iter().copied().map(Written::Input).chain(outputs).chain([Written::Martensite]).collect()
}

/// Steps the wire through the recording, one row at a time.
fn rows(
    recording: &Recording,
    model: &WireModel,
    columns: &[Written],
    mut writer: Writer,
) -> Result<(), sinew_recording::Error> {
    let mut cells = vec![0.0; columns.len()];
    for (simulated, &time_s) in recording.simulated(model)?.zip(recording.time_s()) {
        let (inputs, outputs) = simulated?;
        for (cell, column) in cells.iter_mut().zip(columns) {
            *cell = value(*column, &inputs, &outputs, model);
        }
        writer.row(time_s, &cells)?;
    }
    writer.finish()
}

fn value(column: Written, inputs: &Inputs, outputs: &Outputs, model: &WireModel) -> f64 {
    match column {
        Written::Martensite => outputs.martensite,
        Written::Output(column) => column.of_outputs(outputs).unwrap_or(f64::NAN),
        Written::Input(column) if column == drive_column(model.drive.kind) => inputs.drive,
        Written::Input(Column::SupplyV) => inputs.supply_v,
        Written::Input(Column::AmbientC) => inputs.ambient_c,
        Written::Input(Column::DisturbanceN) => inputs.external_n,
        Written::Input(_) => inputs.imposed,
    }
}

/// A recording's mistake with its place and remedy.
pub fn recording_failure(error: sinew_recording::Error) -> Failure {
    let failure = if error.is_bad_input() { Failure::input(error.message()) } else { Failure::own(error.message()) };
    failure.hint(error.hint())
}
