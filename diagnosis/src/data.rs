//! Recordings as a fit needs them: inputs row by row, sensors side by side, and which samples are fitted, kept back or
//! left out.

use sinew_physics::{DriveKind, Inputs, WireModel};
use sinew_recording::{Column, Recording, drive_column, imposed_column};

use crate::error::Error;

/// What a sample is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// The fit sees it.
    Fitted,
    /// Only ever judged.
    KeptBack,
    /// Neither: a gate left it out.
    LeftOut,
}

/// A sensor that is judged, the same in every recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sensor {
    pub(crate) column: Column,
    /// RMS, in the column's unit.
    pub(crate) noise: f64,
}

/// One recording.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) name: String,
    pub(crate) time_s: Vec<f64>,
    /// What drives the wire, and for how long each row holds, s.
    pub(crate) inputs: Vec<(Inputs, f64)>,
    /// Ambient temperature and supply are the model's, not measured.
    pub(crate) ambient_of_model: bool,
    pub(crate) supply_of_model: bool,
    /// By sensor; NaN where there is no sample, or none that means anything.
    pub(crate) measured: Vec<Vec<f64>>,
    /// By sample.
    pub(crate) part: Vec<Part>,
    /// By sample: the number of its block.
    pub(crate) block: Vec<usize>,
    /// All of it is kept back.
    pub(crate) held_out: bool,
    /// The simulation may take pieces as long as this, s: 0 for those the wire takes by itself.
    pub(crate) longest_piece_s: f64,
}

/// Everything that is compared.
#[derive(Debug, Clone)]
pub(crate) struct Data {
    pub(crate) sensors: Vec<Sensor>,
    pub(crate) runs: Vec<Run>,
    /// The position's zero is arbitrary in every recording.
    pub(crate) free_zero: bool,
    /// The position is not measured but imposed.
    pub(crate) position_imposed: bool,
}

/// What is left out of one recording: a column of it or all columns (`None`), from and to, s.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Excluded {
    pub(crate) column: Option<Column>,
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
}

/// Fewest and most blocks a recording is divided into, and the length they are meant to have, s.
const FEWEST_BLOCKS: f64 = 12.0;
const MOST_BLOCKS: f64 = 36.0;
const BLOCK_S: f64 = 3.0;
/// Every third block is kept back.
const KEEP_EVERY: usize = 3;

/// The columns that sensors measure here: what the model predicts and is not itself an input.
pub(crate) fn judged_columns(model: &WireModel, recording: &Recording) -> Vec<Column> {
    let electrical = matches!(model.drive.kind, DriveKind::Pwm | DriveKind::Current);
    let inputs = [Some(drive_column(model.drive.kind)), imposed_column(&model.load)];
    recording
        .columns()
        .map(|(column, _)| column)
        .filter(|column| !inputs.contains(&Some(*column)))
        .filter(|column| match column {
            Column::CurrentA | Column::V3V => electrical || model.drive.kind == DriveKind::Power,
            Column::V1V | Column::V2V => electrical && model.taps.is_some(),
            Column::PowerW => model.drive.kind != DriveKind::Temperature,
            Column::ForceN | Column::PositionM | Column::TemperatureC => true,
            Column::Duty | Column::SupplyV | Column::AmbientC | Column::DisturbanceN => false,
        })
        .collect()
}

impl Data {
    /// The recordings of one channel. Blocks of the fitted ones are kept back where none is held out as a whole.
    /// `noise` gives the RMS noise of a column, `excluded` what the gates left out of each recording.
    pub(crate) fn new(
        model: &WireModel,
        free_zero: bool,
        recordings: &[&Recording],
        held_out: &[&Recording],
        noise: &dyn Fn(Column) -> f64,
        excluded: &[Vec<Excluded>],
    ) -> Result<Data, Error> {
        let mut columns: Vec<Column> = Vec::new();
        for recording in recordings {
            for column in judged_columns(model, recording) {
                if !columns.contains(&column) {
                    columns.push(column);
                }
            }
        }
        columns.sort();
        let sensors: Vec<Sensor> = columns.into_iter().map(|column| Sensor { column, noise: noise(column) }).collect();
        let mut runs = Vec::new();
        for (index, recording) in recordings.iter().chain(held_out).enumerate() {
            let held = index >= recordings.len();
            let nothing = Vec::new();
            let excluded = excluded.get(index).unwrap_or(&nothing);
            runs.push(Run::new(model, recording, held, held_out.is_empty(), &sensors, excluded)?);
        }
        let position_imposed = imposed_column(&model.load) == Some(Column::PositionM);
        Ok(Data { sensors, runs, free_zero, position_imposed })
    }

    /// The same with only what `of_runs` says, for parts that look at single recordings.
    pub(crate) fn samples(&self) -> usize {
        self.runs.iter().map(|run| run.time_s.len()).sum()
    }

    /// The index of the position's sensor.
    pub(crate) fn position(&self) -> Option<usize> {
        self.sensors.iter().position(|s| s.column == Column::PositionM)
    }

    /// The longest recording, s.
    pub(crate) fn longest_s(&self) -> f64 {
        self.runs.iter().map(Run::duration_s).fold(0.0, f64::max)
    }

    /// The same with other noise.
    pub(crate) fn with_noise(&self, noise: &[f64]) -> Data {
        let mut data = self.clone();
        for (sensor, noise) in data.sensors.iter_mut().zip(noise) {
            sensor.noise = *noise;
        }
        data
    }

    /// The same, simulated in pieces as long as `longest_s`.
    pub(crate) fn in_pieces(&self, longest_s: f64) -> Data {
        let mut data = self.clone();
        data.runs.iter_mut().for_each(|run| run.longest_piece_s = longest_s);
        data
    }

    /// The same with nothing kept back: for a last fit of everything that may be fitted.
    pub(crate) fn all_fitted(&self) -> Data {
        let mut data = self.clone();
        for run in data.runs.iter_mut().filter(|run| !run.held_out) {
            for part in run.part.iter_mut().filter(|part| **part == Part::KeptBack) {
                *part = Part::Fitted;
            }
        }
        data
    }
}

impl Run {
    fn new(
        model: &WireModel,
        recording: &Recording,
        held_out: bool,
        keep_blocks: bool,
        sensors: &[Sensor],
        excluded: &[Excluded],
    ) -> Result<Run, Error> {
        let inputs: Vec<(Inputs, f64)> = recording.inputs_for(model)?.collect();
        let time_s = recording.time_s().to_vec();
        let n = time_s.len();
        let is_out = |time_s: f64, column: Option<Column>| {
            excluded
                .iter()
                .any(|e| (e.column.is_none() || e.column == column) && e.from_s <= time_s && time_s <= e.to_s)
        };
        let measured = sensors
            .iter()
            .map(|sensor| {
                let Some(values) = recording.get(sensor.column) else { return vec![f64::NAN; n] };
                // voltages exist only while current flows (eq. 42): in a period without an on-phase nothing is measured
                let needs_current = matches!(sensor.column, Column::CurrentA | Column::V1V | Column::V2V | Column::V3V);
                let mut values = values.to_vec();
                for (value, ((inputs, _), time)) in values.iter_mut().zip(inputs.iter().zip(&time_s)) {
                    if (needs_current && inputs.drive <= 0.0) || is_out(*time, Some(sensor.column)) {
                        *value = f64::NAN;
                    }
                }
                values
            })
            .collect();
        let duration = time_s[n - 1] - time_s[0];
        let blocks = (duration / BLOCK_S).clamp(FEWEST_BLOCKS, MOST_BLOCKS).floor();
        let mut block = Vec::with_capacity(n);
        let mut part = Vec::with_capacity(n);
        for time in &time_s {
            let number = (((time - time_s[0]) / duration * blocks) as usize).min(blocks as usize - 1);
            block.push(number);
            part.push(if is_out(*time, None) {
                Part::LeftOut
            } else if held_out || (keep_blocks && number % KEEP_EVERY == 1) {
                Part::KeptBack
            } else {
                Part::Fitted
            });
        }
        let unknown = |column| recording.get(column).is_none_or(|values| values.iter().all(|v| v.is_nan()));
        Ok(Run {
            name: recording.name().to_string(),
            time_s,
            inputs,
            ambient_of_model: unknown(Column::AmbientC),
            supply_of_model: unknown(Column::SupplyV),
            measured,
            part,
            block,
            held_out,
            longest_piece_s: 0.0,
        })
    }

    /// The inputs as this model has them: what was not measured is the model's own.
    pub(crate) fn inputs_of<'a>(&'a self, model: &'a WireModel) -> impl ExactSizeIterator<Item = (Inputs, f64)> + 'a {
        self.inputs.iter().map(|(inputs, dt_s)| {
            let mut inputs = *inputs;
            if self.ambient_of_model {
                inputs.ambient_c = model.ambient_c;
            }
            if self.supply_of_model {
                inputs.supply_v = model.drive.supply_v;
            }
            (inputs, *dt_s)
        })
    }

    /// The same, its imposed position counted from another zero, m.
    pub(crate) fn counted_from(&self, zero_m: f64) -> Run {
        let mut run = self.clone();
        run.inputs.iter_mut().for_each(|(inputs, _)| inputs.imposed -= zero_m);
        run
    }

    /// The same with every sample fitted.
    pub(crate) fn everything_fitted(&self) -> Run {
        Run { part: vec![Part::Fitted; self.time_s.len()], ..self.clone() }
    }

    /// From the first sample to the last, s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.time_s[self.time_s.len() - 1] - self.time_s[0]
    }

    /// The intervals kept back, s.
    pub(crate) fn kept_back(&self) -> Vec<(f64, f64)> {
        let mut intervals: Vec<(f64, f64)> = Vec::new();
        let mut inside = false;
        for (time, part) in self.time_s.iter().zip(&self.part) {
            match (*part == Part::KeptBack, inside) {
                (true, false) => intervals.push((*time, *time)),
                (true, true) => {
                    if let Some(last) = intervals.last_mut() {
                        last.1 = *time;
                    }
                }
                _ => {}
            }
            inside = *part == Part::KeptBack;
        }
        intervals
    }
}
