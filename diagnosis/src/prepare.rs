//! From recordings to the data of a fit: through the gates, with the noise of every sensor, and as coarse as a search may
//! simulate them.

use std::collections::BTreeMap;

use sinew_physics::DriveKind;
use sinew_recording::{Column, Recording};
use sinew_rig::{PositionZero, Rig};

use crate::data::{Data, Part, Source};
use crate::error::{Broken, Error, Trouble};
use crate::gates;
use crate::noise::{self, Noise};
use crate::residuals::{self, Residuals};
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
        let free_zero = c.position_zero == PositionZero::Free;
        let noise = |column: Column| noise_of.get(&column).copied().unwrap_or(NO_NOISE);
        let data = Data::new(&c.model, free_zero, &sources, &noise)?;
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

/// How long a row of thinned data may be, and the pieces that a search may simulate in, longest first, s.
const LONG_ROWS_S: [f64; 2] = [0.02, 0.01];
const LONG_PIECES_S: [f64; 2] = [0.01, 0.005];

/// As long as no sensor shows it by more than this share of its noise, RMS.
const UNNOTICED: f64 = 0.15;

/// The data as a search simulates them: rows and pieces as long as nobody would notice. What is reported is fitted in the
/// end with those that there are.
pub(crate) fn for_search(data: &Data, space: &Space, drive: DriveKind) -> Data {
    let rest = vec![0.0; space.len()];
    let Some(exact) = residuals::plain_at(data, space, &rest) else { return data.clone() };
    let is_unnoticed = |hasty: &Data, exact: &Residuals| {
        residuals::plain_at(hasty, space, &rest).is_some_and(|there| {
            let errors = residuals::zip(&there, exact, |there, exact| there - exact);
            (0..data.sensors.len()).all(|s| rms(errors.iter().map(|by_sensor| by_sensor[s].as_slice())) < UNNOTICED)
        })
    };
    let row_s = data.runs.iter().map(|run| run.duration_s() / run.time_s.len() as f64).fold(f64::INFINITY, f64::min);
    for long_s in LONG_ROWS_S {
        let rows = (long_s / row_s + 0.01).floor() as usize;
        if rows > 1 {
            let thin = data.thinned(rows, drive);
            // what the rows that were made one are on the mean
            let Some(exact) = residuals::plain_at(&thin.in_pieces(0.0), space, &rest) else { continue };
            let pieces = LONG_PIECES_S.iter().map(|piece| thin.in_pieces(*piece));
            if let Some(found) = pieces.into_iter().find(|hasty| is_unnoticed(hasty, &exact)) {
                return found;
            }
        }
    }
    LONG_PIECES_S
        .iter()
        .map(|piece| data.in_pieces(*piece))
        .find(|hasty| is_unnoticed(hasty, &exact))
        .unwrap_or_else(|| data.clone())
}

/// RMS of what was measured.
fn rms<'a>(values: impl Iterator<Item = &'a [f32]>) -> f64 {
    let measured = values.flatten().filter(|r| !r.is_nan());
    let (sum, count) = measured.fold((0.0, 0.0), |(sum, count), r| (sum + f64::from(*r).powi(2), count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
