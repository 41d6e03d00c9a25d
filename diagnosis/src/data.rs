//! Recordings as a fit needs them: inputs row by row, sensors side by side, and which samples are fitted, kept back or
//! left out.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use sinew_physics::{DriveKind, Inputs, Surroundings, Wire, WireModel};
use sinew_recording::{Column, Recording, imposed_column};

use crate::error::Error;
use crate::gates::{self, Exclude, Warning};
use crate::noise::Noise;
use crate::whitening::{Residuals, Whitening};

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
    /// The part of it that is new in every sample.
    pub(crate) white: f64,
    /// RMS of what its converter or a printout rounds off; 0 = not seen.
    pub(crate) rounding: f64,
    /// Of how many samples a row is the mean that has this noise.
    pub(crate) samples: usize,
}

impl Sensor {
    /// Variance of a row that is the mean of so many samples, in units of `noise`²: what is new in every sample averages
    /// out, the rest does not.
    pub(crate) fn variance(&self, samples: usize) -> f64 {
        let white = (self.white / self.noise).powi(2);
        1.0 - white + white * self.samples as f64 / samples.max(1) as f64
    }
}

/// A row of thinned data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    /// Of how many samples it is the mean.
    pub(crate) samples: usize,
    /// How long the pieces are that it may be simulated in, s: 0 for those the wire takes by itself.
    pub(crate) piece_s: f64,
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
    /// By row: the simulation may take pieces as long as this, s. 0, or empty, for those the wire takes by itself.
    pub(crate) longest_pieces_s: Vec<f64>,
    /// By row, where rows are means of several: how long before its end they are on the whole, as a share of its
    /// length. Empty where every row is one sample.
    pub(crate) early: Vec<f64>,
    /// By row: of how many samples it is the mean. Empty where every row is one sample.
    pub(crate) samples: Vec<usize>,
    /// By sensor and row: what a simulation in long rows and pieces lacks to one in short ones, near where a search is.
    /// Empty where it lacks nothing.
    pub(crate) lacking: Vec<Vec<f64>>,
    /// By row: what other wires do to this one. Empty where it is alone.
    pub(crate) around: Vec<Surroundings>,
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
    /// What makes residuals white, where the model is known to be wrong.
    pub(crate) whitening: Option<Arc<Whitening>>,
    /// What has been simulated of them so far, in rows of a wire all alike; one account for all that is made of the same data.
    pub(crate) simulated: Arc<AtomicU64>,
}

/// A recording as the gates leave it.
pub(crate) struct Source {
    /// Sensors have no samples where they were left out.
    pub(crate) recording: Recording,
    /// Where nothing of it counts, s.
    left_out_s: Vec<(f64, f64)>,
    /// All of it is kept back.
    pub(crate) held_out: bool,
}

impl Source {
    /// The recording without what the warnings leave out.
    pub(crate) fn new(
        recording: &Recording,
        model: &WireModel,
        warnings: &[Warning],
        held_out: bool,
    ) -> Result<Source, Error> {
        let mut source = Source { recording: recording.clone(), left_out_s: Vec::new(), held_out };
        for Warning { column, exclude, .. } in warnings {
            match (exclude, column) {
                (Exclude::Nothing, _) | (Exclude::Column, None) => {}
                (Exclude::Column, Some(column)) => drop(source.recording.remove(*column)),
                (Exclude::Windows(windows), Some(column)) => source.blank(*column, windows)?,
                (Exclude::Windows(windows), None) => {
                    for column in gates::sensors(recording, model) {
                        source.blank(column, windows)?;
                    }
                    source.left_out_s.extend(windows);
                }
            }
        }
        Ok(source)
    }

    /// Takes the samples of a column in some intervals out.
    fn blank(&mut self, column: Column, windows: &[(f64, f64)]) -> Result<(), Error> {
        let Some(mut values) = self.recording.remove(column) else { return Ok(()) };
        for (value, time) in values.iter_mut().zip(self.recording.time_s()) {
            if is_in(windows, *time) {
                *value = f64::NAN;
            }
        }
        Ok(self.recording.set(column, values)?)
    }
}

fn is_in(windows: &[(f64, f64)], time_s: f64) -> bool {
    windows.iter().any(|(from, to)| (*from..=*to).contains(&time_s))
}

/// Fewest and most blocks a recording is divided into, and the length they are meant to have, s.
const FEWEST_BLOCKS: f64 = 12.0;
const MOST_BLOCKS: f64 = 36.0;
const BLOCK_S: f64 = 3.0;
/// Every third block is kept back: with the usual seed, 1, of the first recording the second, of the next the third and so
/// on. Runs of one programme would otherwise keep back the same part of it, and nothing would know what happens there.
const KEEP_EVERY: usize = 3;
/// Fewest samples to fit that make a column a sensor.
const LEAST_SEEN: usize = 20;

impl Data {
    /// The recordings of one channel. Blocks of the fitted ones are kept back where none is held out as a whole.
    /// `noise` gives the noise of a column, `seed` where the counting of the blocks starts.
    pub(crate) fn new(
        model: &WireModel,
        free_zero: bool,
        sources: &[Source],
        noise: &dyn Fn(Column) -> Noise,
        seed: u64,
    ) -> Result<Data, Error> {
        let fitted = || sources.iter().filter(|source| !source.held_out);
        let mut columns: Vec<Column> = fitted().flat_map(|s| gates::sensors(&s.recording, model)).collect();
        columns.sort();
        columns.dedup();
        let keep_blocks = fitted().count() == sources.len();
        let phase = (seed % KEEP_EVERY as u64) as usize;
        let keep = |number: usize| keep_blocks.then_some((number + phase) % KEEP_EVERY);
        let runs = sources.iter().enumerate().map(|(number, source)| Run::new(model, source, keep(number), &columns));
        let mut runs = runs.collect::<Result<Vec<Run>, Error>>()?;
        // a column with next to nothing to fit is no sensor
        let seen = |sensor: usize| runs.iter().map(|run| run.count(Part::Fitted, sensor)).sum::<usize>();
        let kept: Vec<bool> = (0..columns.len()).map(|sensor| seen(sensor) >= LEAST_SEEN).collect();
        for run in &mut runs {
            let mut kept = kept.iter();
            run.measured.retain(|_| kept.next().is_some_and(|kept| *kept));
        }
        let columns = columns.into_iter().zip(&kept).filter(|(_, kept)| **kept).map(|(column, _)| column);
        let sensors = columns
            .map(|column| {
                let Noise { white, total, step } = noise(column);
                Sensor { column, noise: total, white, rounding: step / 12f64.sqrt(), samples: 1 }
            })
            .collect();
        let position_imposed = imposed_column(&model.load) == Some(Column::PositionM);
        Ok(Data { sensors, runs, free_zero, position_imposed, whitening: None, simulated: Arc::default() })
    }

    /// How many samples of all sensors a part has.
    pub(crate) fn count(&self, part: Part) -> usize {
        let sensors = 0..self.sensors.len();
        self.runs.iter().map(|run| sensors.clone().map(|s| run.count(part, s)).sum::<usize>()).sum()
    }

    /// The index of the position's sensor.
    pub(crate) fn position(&self) -> Option<usize> {
        self.sensors.iter().position(|s| s.column == Column::PositionM)
    }

    /// The longest recording, s.
    pub(crate) fn longest_s(&self) -> f64 {
        self.runs.iter().map(Run::duration_s).fold(0.0, f64::max)
    }

    /// Residuals, or their derivatives, in units in which they are white, where the model is known to be wrong; else as
    /// they are.
    pub(crate) fn white(&self, left: &Residuals) -> Residuals {
        match &self.whitening {
            Some(whitening) => whitening.whiten(left),
            None => left.clone(),
        }
    }

    /// The same with rows made one, by recording as many as `groups` says in turn, `most` of them at most: as much is known of
    /// what moves slowly, for a fraction of the work.
    pub(crate) fn thinned(&self, rows: &[Vec<Row>], most: usize, drive: DriveKind) -> Data {
        let runs = self.runs.iter().zip(rows).map(|(run, rows)| run.thinned(rows, drive)).collect();
        let sensors = self
            .sensors
            .iter()
            .map(|sensor| {
                let wandering = (sensor.noise.powi(2) - sensor.white.powi(2)).max(0.0);
                let white = sensor.white / (most as f64).sqrt();
                Sensor { noise: (wandering + white * white).sqrt(), white, samples: most, ..*sensor }
            })
            .collect();
        Data { runs, sensors, ..self.clone() }
    }

    /// The same among other wires, which do this by recording and row of `exact`, the data these were thinned from.
    pub(crate) fn among(&self, exact: &Data, around: &[Vec<Surroundings>]) -> Data {
        let runs = self.runs.iter().zip(&exact.runs).zip(around);
        Data { runs: runs.map(|((run, exact), around)| run.among(&exact.time_s, around)).collect(), ..self.clone() }
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
    /// Of every [`KEEP_EVERY`] blocks the one numbered `keep` is kept back.
    fn new(model: &WireModel, source: &Source, keep: Option<usize>, columns: &[Column]) -> Result<Run, Error> {
        let Source { recording, left_out_s, held_out } = source;
        let inputs: Vec<(Inputs, f64)> = recording.inputs_for(model)?.collect();
        let time_s = recording.time_s().to_vec();
        let n = time_s.len();
        let measured = columns
            .iter()
            .map(|column| {
                let Some(values) = recording.get(*column) else { return vec![f64::NAN; n] };
                // voltages exist only while current flows (eq. 42): in a period without an on-phase nothing is measured
                let needs_current = matches!(column, Column::CurrentA | Column::V1V | Column::V2V | Column::V3V);
                let seen = |(inputs, value): (&(Inputs, f64), &f64)| {
                    if needs_current && inputs.0.drive <= 0.0 { f64::NAN } else { *value }
                };
                inputs.iter().zip(values).map(seen).collect()
            })
            .collect();
        let duration = time_s[n - 1] - time_s[0];
        let blocks = (duration / BLOCK_S).clamp(FEWEST_BLOCKS, MOST_BLOCKS).floor();
        let mut block = Vec::with_capacity(n);
        let mut part = Vec::with_capacity(n);
        for time in &time_s {
            let number = (((time - time_s[0]) / duration * blocks) as usize).min(blocks as usize - 1);
            block.push(number);
            part.push(if is_in(left_out_s, *time) {
                Part::LeftOut
            } else if *held_out || keep == Some(number % KEEP_EVERY) {
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
            held_out: *held_out,
            longest_pieces_s: Vec::new(),
            early: Vec::new(),
            samples: Vec::new(),
            lacking: Vec::new(),
            around: Vec::new(),
        })
    }

    /// How many rows may be made one, in turn: up to `most`, of one block.
    pub(crate) fn groups(&self, most: usize) -> Vec<usize> {
        let mut groups = Vec::with_capacity(self.time_s.len() / most.max(1) + 1);
        let mut first = 0;
        while first < self.time_s.len() {
            let alike = |row: &usize| self.block[*row] == self.block[first] && self.part[*row] == self.part[first];
            let count = (first..self.time_s.len()).take(most.max(1)).take_while(alike).count();
            groups.push(count);
            first += count;
        }
        groups
    }

    /// The same with so many rows made one in turn, each simulated in pieces of its own length.
    fn thinned(&self, rows: &[Row], drive: DriveKind) -> Run {
        let mut thin = Run {
            time_s: Vec::new(),
            inputs: Vec::new(),
            measured: vec![Vec::new(); self.measured.len()],
            part: Vec::new(),
            block: Vec::new(),
            early: Vec::new(),
            samples: rows.iter().map(|row| row.samples).collect(),
            longest_pieces_s: rows.iter().map(|row| row.piece_s).collect(),
            around: Vec::new(),
            ..self.clone()
        };
        let mut first = 0;
        for &Row { samples: count, .. } in rows {
            let group = first..first + count;
            let last = group.end - 1;
            let span_s: f64 = self.inputs[group.clone()].iter().map(|(_, dt_s)| dt_s).sum();
            let mean = |of: &dyn Fn(&Inputs) -> f64| {
                self.inputs[group.clone()].iter().map(|(inputs, dt_s)| of(inputs) * dt_s).sum::<f64>() / span_s
            };
            let (end, _) = self.inputs[last];
            let inputs = Inputs {
                drive: match drive {
                    DriveKind::Pwm | DriveKind::Power => mean(&|i| i.drive),
                    // heats by its square
                    DriveKind::Current | DriveKind::Amplifier(_) => mean(&|i| i.drive * i.drive).sqrt(),
                    // is there at the end
                    DriveKind::Temperature => end.drive,
                },
                supply_v: mean(&|i| i.supply_v),
                ambient_c: mean(&|i| i.ambient_c),
                external_n: mean(&|i| i.external_n),
                ..end
            };
            let ago = group.clone().map(|row| self.time_s[last] - self.time_s[row]).sum::<f64>() / count as f64;
            thin.time_s.push(self.time_s[last]);
            thin.inputs.push((inputs, span_s));
            thin.part.push(self.part[first]);
            thin.block.push(self.block[first]);
            thin.early.push(ago / span_s);
            for (thin, all) in thin.measured.iter_mut().zip(&self.measured) {
                thin.push(all[group.clone()].iter().sum::<f64>() / count as f64);
            }
            first = group.end;
        }
        thin.among(&self.time_s, &self.around)
    }

    /// How many samples of one sensor a part has.
    fn count(&self, part: Part, sensor: usize) -> usize {
        let samples = self.part.iter().zip(&self.measured[sensor]);
        samples.filter(|(of, value)| **of == part && !value.is_nan()).count()
    }

    /// From the least to the largest of what a sensor measured.
    pub(crate) fn range(&self, sensor: usize) -> f64 {
        let (least, most) = self.measured[sensor]
            .iter()
            .filter(|v| !v.is_nan())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(*v), most.max(*v)));
        (most - least).max(0.0)
    }

    /// The share of its rows that count for nothing.
    pub(crate) fn left_out(&self) -> f64 {
        let out = self.part.iter().filter(|part| **part == Part::LeftOut).count();
        out as f64 / self.part.len().max(1) as f64
    }

    /// The inputs as this model has them: what was not measured is the model's own.
    pub(crate) fn inputs_of<'a>(&'a self, model: &'a WireModel) -> impl ExactSizeIterator<Item = (Inputs, f64)> + 'a {
        self.inputs.iter().enumerate().map(|(row, (inputs, dt_s))| {
            let mut inputs = *inputs;
            if self.ambient_of_model {
                inputs.ambient_c = model.ambient_c;
            }
            if self.supply_of_model {
                inputs.supply_v = model.drive.supply_v;
            }
            let inputs = self.around.get(row).map_or(inputs, |around| around.acting_on(model, inputs));
            (inputs, *dt_s)
        })
    }

    /// Lets a wire know of a row how long its pieces may be and what is beside it.
    pub(crate) fn prepare(&self, row: usize, wire: &mut Wire) {
        wire.take_long_pieces(self.longest_pieces_s.get(row).copied().unwrap_or(0.0));
        if let Some(around) = self.around.get(row) {
            around.warm(wire);
        }
    }

    /// The same among other wires, which do this to it by row of the recording that this one was thinned from.
    pub(crate) fn among(&self, time_s: &[f64], around: &[Surroundings]) -> Run {
        if around.is_empty() {
            return Run { around: Vec::new(), ..self.clone() };
        }
        let others_a: Vec<f64> = around.iter().map(|around| around.others_a).collect();
        let neighbour_c: Vec<f64> = around.iter().map(|around| around.neighbour_c.unwrap_or(f64::NAN)).collect();
        let rows = self.means_of(time_s, &others_a).into_iter().zip(self.means_of(time_s, &neighbour_c));
        let mean = |(others_a, neighbour_c): (f64, f64)| Surroundings {
            others_a,
            neighbour_c: (!neighbour_c.is_nan()).then_some(neighbour_c),
        };
        Run { around: rows.map(mean).collect(), ..self.clone() }
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

    /// Values by row of the recording that this one was thinned from, as means over its own rows.
    pub(crate) fn means_of(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let mut first = 0;
        self.time_s
            .iter()
            .map(|end_s| {
                let count = time_s[first..].partition_point(|time| time <= end_s);
                let mean = values[first..first + count].iter().sum::<f64>() / count.max(1) as f64;
                first += count;
                mean
            })
            .collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{recording, rig, stairs};

    fn data(held_out: [bool; 3], seed: u64) -> Data {
        let model = &rig().channels[0].model;
        let sources = held_out.map(|held_out| {
            Source::new(&recording(model, stairs, 1), model, &[], held_out).expect("a recording that can be used")
        });
        Data::new(model, false, &sources, &|_| Noise { white: 1.0, total: 1.0, step: 0.0 }, seed).expect("sensors")
    }

    #[test]
    fn runs_of_one_programme_keep_back_different_parts_of_it() {
        let data = data([false; 3], 1);
        for row in 0..data.runs[0].time_s.len() {
            let kept = data.runs.iter().filter(|run| run.part[row] == Part::KeptBack).count();
            assert_eq!(kept, 1, "sample {row}");
        }
    }

    #[test]
    fn another_seed_keeps_back_other_blocks() {
        let of = |seed| data([false; 3], seed);
        let seeds = [of(1), of(2), of(3)];
        for row in 0..seeds[0].runs[0].time_s.len() {
            let kept = seeds.iter().filter(|data| data.runs[0].part[row] == Part::KeptBack).count();
            assert_eq!(kept, 1, "sample {row}");
        }
        assert_eq!(of(4).runs[0].part, seeds[0].runs[0].part, "there are three ways");
    }

    #[test]
    fn beside_a_recording_that_is_held_out_all_of_the_others_is_fitted() {
        let data = data([false, true, false], 1);
        for (run, part) in data.runs.iter().zip([Part::Fitted, Part::KeptBack, Part::Fitted]) {
            assert!(run.part.iter().all(|p| *p == part));
        }
    }
}
