//! From recordings to the data of a fit: through the gates, with the noise of every sensor, and as coarse as a search
//! may simulate them.

use std::collections::BTreeMap;

use sinew_physics::{DriveKind, Surroundings};
use sinew_recording::{Column, Recording};
use sinew_rig::{PositionZero, Rig};

use crate::data::{Data, Part, Row, Run, Source};
use crate::error::{Broken, Error, Trouble};
use crate::gates;
use crate::noise::{self, Noise};
use crate::residuals::Residuals;
use crate::simulate;
use crate::space::Space;

/// Fewest samples a fit is made from, or judged by.
const LEAST_COUNT: usize = 50;

/// A recording of which more than this has to be left out is none.
const MOST_LEFT_OUT: f64 = 0.5;

/// Of a column that is no sensor.
const NO_NOISE: Noise = Noise { white: 1.0, total: 1.0, step: 0.0 };

/// Recordings that passed the gates.
pub(crate) struct Prepared {
    pub(crate) data: Data,
    pub(crate) warnings: Vec<String>,
}

impl Prepared {
    pub(crate) fn new(
        rig: &Rig,
        channel: usize,
        recordings: &[Recording],
        held_out: &[Recording],
        seed: u64,
    ) -> Result<Prepared, Error> {
        Prepared::quieter(rig, channel, recordings, held_out, seed, &BTreeMap::new())
    }

    /// The same, where some sensors are known to be `quieter` than their recordings look.
    pub(crate) fn quieter(
        rig: &Rig,
        channel: usize,
        recordings: &[Recording],
        held_out: &[Recording],
        seed: u64,
        quieter: &BTreeMap<Column, Noise>,
    ) -> Result<Prepared, Error> {
        let channels = rig.channels.len();
        let c = rig.channels.get(channel).ok_or(Error::NoChannel { found: channel, channels })?;
        let Some(first) = recordings.first() else { return Err(Error::NoRecording) };
        let mut warnings = Vec::new();
        let mut sources = Vec::new();
        for (index, recording) in recordings.iter().chain(held_out).enumerate() {
            let found = gates::check(recording, c)?;
            sources.push(Source::new(recording, &c.model, &found, index >= recordings.len())?);
            warnings.extend(found.into_iter().map(|w| w.text));
        }
        let given = |column: Column| c.noise.get(column.name()).copied();
        let mut noise_of: BTreeMap<Column, Noise> = BTreeMap::new();
        for source in sources.iter().filter(|source| !source.held_out) {
            for column in gates::sensors(&source.recording, &c.model) {
                let noise = noise::estimate(&source.recording, column, given(column));
                // the quietest recording: there the sensor's own noise shows best
                let least = noise_of.entry(column).or_insert(noise);
                if noise.total < least.total {
                    *least = noise;
                }
            }
        }
        noise_of.extend(quieter);
        let free_zero = c.position_zero == PositionZero::Free;
        let noise = |column: Column| noise_of.get(&column).copied().unwrap_or(NO_NOISE);
        let data = Data::new(&c.model, free_zero, &sources, &noise, seed)?;
        let (fitted, kept_back) = (data.count(Part::Fitted), data.count(Part::KeptBack));
        let little = |name: &str| {
            let what = Trouble::LittleLeft { fitted, kept_back, least: LEAST_COUNT, reasons: warnings.clone() };
            Err(Broken { recording: name.into(), column: None, span_s: None, what }.into())
        };
        if fitted < LEAST_COUNT || kept_back < LEAST_COUNT {
            return little(held_out.first().filter(|_| fitted >= LEAST_COUNT).unwrap_or(first).name());
        }
        if let Some(run) = data.runs.iter().find(|run| run.left_out() > MOST_LEFT_OUT) {
            return little(&run.name);
        }
        Ok(Prepared { data, warnings })
    }
}

/// Noise by what a model leaves counts where it is less than this share of what the recording itself shows.
const QUIETER: f64 = 0.6;

/// Sensors that are quieter than their recordings look, by what a model leaves of them: `left`, over the noise as it is. A wire that is
/// faster than its sensors looks as if these were noisy. What the rig file states stays.
pub(crate) fn quieter(rig: &Rig, channel: usize, data: &Data, left: &Residuals) -> BTreeMap<Column, Noise> {
    let stated = &rig.channels[channel].noise;
    let mut quieter = BTreeMap::new();
    for (s, sensor) in data.sensors.iter().enumerate().filter(|(_, sensor)| !stated.contains_key(sensor.column.name()))
    {
        let runs = data.runs.iter().zip(left).filter(|(run, _)| !run.held_out);
        let of_run = |(run, left): (&Run, &Vec<Vec<f32>>)| {
            let rows = run.time_s.iter().zip(&left[s]).filter(|(_, r)| r.is_finite());
            let (times, values): (Vec<f64>, Vec<f64>) = rows.map(|(t, r)| (*t, f64::from(*r) * sensor.noise)).unzip();
            noise::of_residuals(&times, &values, sensor.rounding * 12f64.sqrt())
        };
        let least = runs.map(of_run).min_by(|a, b| a.total.total_cmp(&b.total));
        if let Some(least) = least.filter(|least| least.total < QUIETER * sensor.noise) {
            quieter.insert(sensor.column, least);
        }
    }
    quieter
}

/// How long a row of thinned data may be, and the pieces that it is simulated in, s; halved to less than the last, the wire
/// takes its own.
const LONG_ROW_S: f64 = 0.04;
const LONG_PIECE_S: f64 = 0.02;
const SHORT_PIECE_S: f64 = 0.005;

/// As long as what they lack, which is known at one place and taken into account, is less than this share of any
/// sensor's noise, RMS: then it hardly changes from place to place.
const UNNOTICED: f64 = 0.5;
/// How often rows that lack much are halved; where that makes hardly more pieces, by this share, those that lack half as
/// much are next.
const HALVINGS: usize = 16;
const HARDLY: f64 = 0.03;

/// A piece halved, s: 0 where the wire takes its own.
fn half_as_long(piece_s: f64) -> f64 {
    if piece_s > SHORT_PIECE_S { 0.5 * piece_s } else { 0.0 }
}

/// The data as a search simulates them, and those they are made from.
#[derive(Debug, Clone)]
pub(crate) struct Searched {
    pub(crate) data: Data,
    exact: Data,
}

/// What a simulation in long rows and pieces lacks, by recording, sensor and row.
type Lacking = Vec<Vec<Vec<f64>>>;

impl Searched {
    /// In rows and pieces as long as nobody would notice: long where things move slowly, short where they do not, as after an
    /// edge of the drive. What is reported is judged in the end by those that there are.
    pub(crate) fn new(exact: &Data, space: &Space, drive: DriveKind) -> Searched {
        let whole = Searched { data: exact.clone(), exact: exact.clone() };
        let rest = vec![0.0; space.len()];
        let row_s =
            exact.runs.iter().map(|run| run.duration_s() / run.time_s.len() as f64).fold(f64::INFINITY, f64::min);
        let most = (LONG_ROW_S / row_s + 0.01).floor().max(1.0) as usize;
        let Some(there) = Searched::outputs(exact, space, &rest) else { return whole };
        let long = |samples: usize| Row { samples, piece_s: LONG_PIECE_S };
        let mut rows: Vec<Vec<Row>> =
            exact.runs.iter().map(|run| run.groups(most).into_iter().map(long).collect()).collect();
        let mut much = UNNOTICED;
        for _ in 0..=HALVINGS {
            let searched = Searched { data: exact.thinned(&rows, most, drive), exact: exact.clone() };
            let Some(lacking) = searched.lacking_to(&there, space, &rest) else { break };
            if searched.is_unnoticed(&lacking) {
                return searched.with(lacking);
            }
            let halved = searched.halved(&rows, &lacking, much);
            if searched.pieces(&halved) < (1.0 + HARDLY) * searched.pieces(&rows) {
                much *= 0.5;
            }
            rows = halved;
        }
        whole
    }

    /// Rows halved, and their pieces, before and where they begin to lack more than `much`, in units of noise.
    fn halved(&self, rows: &[Vec<Row>], lacking: &Lacking, much: f64) -> Vec<Vec<Row>> {
        let halved = |(rows, lacking): (&Vec<Row>, &Vec<Vec<f64>>)| {
            let begins = |row: usize| {
                row < rows.len()
                    && self.data.sensors.iter().zip(lacking).any(|(sensor, lacking)| {
                        let before = if row == 0 { 0.0 } else { lacking[row - 1] };
                        (lacking[row] - before).abs() > much * sensor.noise
                    })
            };
            let parts = |(row, whole): (usize, &Row)| {
                let is_halved = begins(row) || begins(row + 1);
                let piece_s = if is_halved { half_as_long(whole.piece_s) } else { whole.piece_s };
                let half = if is_halved { whole.samples / 2 } else { 0 };
                let parts = [half, whole.samples - half].into_iter().filter(|samples| *samples > 0);
                parts.map(move |samples| Row { samples, piece_s })
            };
            rows.iter().enumerate().flat_map(parts).collect()
        };
        rows.iter().zip(lacking).map(halved).collect()
    }

    /// How many pieces a simulation in such rows takes, about.
    fn pieces(&self, rows: &[Vec<Row>]) -> f64 {
        let of_run = |(run, rows): (&Run, &Vec<Row>)| {
            let row_s = run.duration_s() / run.time_s.len() as f64;
            let pieces = |row: &Row| (row.samples as f64 * row_s / row.piece_s.max(0.5 * SHORT_PIECE_S)).ceil();
            rows.iter().map(pieces).sum::<f64>()
        };
        self.exact.runs.iter().zip(rows).map(of_run).sum()
    }

    /// The same among other wires, which do this by recording and row.
    pub(crate) fn among(&self, around: &[Vec<Surroundings>]) -> Searched {
        Searched { data: self.data.among(&self.exact, around), exact: self.exact.among(&self.exact, around) }
    }

    /// The same, what it lacks taken into account as it is at `z`.
    pub(crate) fn near(&self, space: &Space, z: &[f64]) -> Searched {
        let lacking = self.lacking(space, z);
        lacking.map_or_else(|| self.clone(), |lacking| self.clone().with(lacking))
    }

    fn with(mut self, lacking: Lacking) -> Searched {
        for (run, lacking) in self.data.runs.iter_mut().zip(lacking) {
            run.lacking = lacking;
        }
        self
    }

    /// What an exact simulation at `z` shows beside a hasty one.
    fn lacking(&self, space: &Space, z: &[f64]) -> Option<Lacking> {
        self.lacking_to(&Searched::outputs(&self.exact, space, z)?, space, z)
    }

    /// The same, where an exact simulation shows `there`.
    fn lacking_to(&self, there: &[Vec<Vec<f64>>], space: &Space, z: &[f64]) -> Option<Lacking> {
        let mut hasty = self.data.clone();
        hasty.runs.iter_mut().for_each(|run| run.lacking.clear());
        let here = Searched::outputs(&hasty, space, z)?;
        let by_run = hasty.runs.iter().zip(&self.exact.runs).zip(there.iter().zip(&here));
        let lacking = by_run.map(|((run, exact), (there, here))| {
            let differences = there.iter().zip(here).map(|(there, here)| {
                run.means_of(&exact.time_s, there).iter().zip(here).map(|(there, here)| there - here).collect()
            });
            differences.collect()
        });
        Some(lacking.collect())
    }

    /// What `data` would have shown at `z`, by recording, sensor and row.
    fn outputs(data: &Data, space: &Space, z: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let model = space.model(z)?;
        let outputs = |r| simulate::outputs(&model, &space.run(data, r, z), &data.sensors);
        (0..data.runs.len()).map(outputs).collect()
    }

    fn is_unnoticed(&self, lacking: &Lacking) -> bool {
        self.data.sensors.iter().enumerate().all(|(s, sensor)| {
            let (sum, count) = lacking
                .iter()
                .flat_map(|by_sensor| &by_sensor[s])
                .fold((0.0, 0.0), |(sum, count), lacking| (sum + lacking * lacking, count + 1.0));
            (sum / f64::max(count, 1.0)).sqrt() < UNNOTICED * sensor.noise
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::Stage;
    use crate::testing::{NOISE, RIG, recording};

    /// A thin wire that never rests: within a second it does more than a polynomial can follow.
    #[test]
    fn a_wire_that_never_rests_is_not_taken_for_noise() {
        let thin = RIG
            .replace("diameter_mm = 0.125\nlength_mm = 160.0", "diameter_mm = 0.05\nlength_mm = 900.0")
            .replace("ls_mm = 140.0", "ls_mm = 850.0")
            .replace("supply_v = 6.0", "supply_v = 30.0")
            .replace(
                "mass_kg = 0.13\ndamping_n_s_per_m = 30.0\nspring_n_per_m = 150.0",
                "mass_kg = 0.01\ndamping_n_s_per_m = 1.3\nspring_n_per_m = 1.0",
            )
            .replace("preload_n = 2.6", "preload_n = 0.1");
        let mut rig = Rig::parse(&thin, "thin.toml").unwrap();
        let duty = |time_s: f64| 0.2 + 0.15 * (8.0 * time_s).sin();
        let recording = recording(&rig.channels[0].model, duty, 3);
        let data = Prepared::new(&rig, 0, &[recording], &[], 1).unwrap().data;
        let space = Space::reference(&rig, 0, &data);
        let left = Stage::as_given(&data, &space).unwrap().residuals;
        let quieter = quieter(&rig, 0, &data, &left);
        let mut mended = 0;
        for sensor in &data.sensors {
            let (_, truth) = NOISE.into_iter().find(|(column, _)| *column == sensor.column).unwrap();
            match quieter.get(&sensor.column) {
                Some(noise) => {
                    mended += 1;
                    assert!((noise.total / truth - 1.0).abs() < 0.1, "{:?}: {noise:?}", sensor.column);
                }
                None => assert!(sensor.noise < truth / QUIETER, "{:?}: {} of {truth}", sensor.column, sensor.noise),
            }
        }
        assert!(mended > 0, "{:?}", data.sensors.iter().map(|s| (s.column, s.noise)).collect::<Vec<_>>());
        // what a user states stays
        rig.channels[0].noise = quieter.keys().map(|column| (column.name().to_string(), 1.0)).collect();
        assert!(super::quieter(&rig, 0, &data, &left).is_empty());
    }
}
