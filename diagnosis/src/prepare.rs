//! From recordings to the data of a fit: through the gates, with the noise of every sensor, and as coarse as a search may
//! simulate them.

use std::collections::BTreeMap;

use sinew_recording::{Column, Recording};
use sinew_rig::{PositionZero, Rig};

use crate::data::{Data, Part, Source};
use crate::error::{Broken, Error, Trouble};
use crate::gates;
use crate::noise;
use crate::residuals;
use crate::space::Space;

/// Fewest samples a fit is made from, or judged by.
const LEAST_COUNT: usize = 50;

/// A recording of which more than this has to be left out is none.
const MOST_LEFT_OUT: f64 = 0.5;

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
        let mut noise_of: BTreeMap<Column, f64> = BTreeMap::new();
        for source in sources.iter().filter(|source| !source.held_out) {
            for column in gates::sensors(&source.recording, &c.model) {
                let noise = noise::estimate(&source.recording, column, given(column)).total;
                // the quietest recording: there the sensor's own noise shows best
                let least = noise_of.entry(column).or_insert(noise);
                *least = least.min(noise);
            }
        }
        let free_zero = c.position_zero == PositionZero::Free;
        let noise = |column: Column| noise_of.get(&column).copied().unwrap_or(1.0);
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

/// Pieces that a search may simulate in, longest first, s.
const LONG_PIECES_S: [f64; 2] = [0.01, 0.005];

/// As long as no sensor shows it by more than this share of its noise, RMS.
const UNNOTICED: f64 = 0.05;

/// The data as a search simulates them: in pieces as long as nobody would notice. What is reported is fitted in the end
/// with those that the wire takes by itself.
pub(crate) fn for_search(data: &Data, space: &Space) -> Data {
    let rest = vec![0.0; space.len()];
    let Some(exact) = residuals::at(data, space, &rest) else { return data.clone() };
    let is_unnoticed = |hasty: &Data| {
        residuals::at(hasty, space, &rest).is_some_and(|there| {
            let errors = residuals::zip(&there, &exact, |there, exact| there - exact);
            (0..data.sensors.len()).all(|s| rms(errors.iter().map(|by_sensor| by_sensor[s].as_slice())) < UNNOTICED)
        })
    };
    LONG_PIECES_S.iter().map(|piece| data.in_pieces(*piece)).find(is_unnoticed).unwrap_or_else(|| data.clone())
}

/// RMS of what was measured.
fn rms<'a>(values: impl Iterator<Item = &'a [f32]>) -> f64 {
    let measured = values.flatten().filter(|r| !r.is_nan());
    let (sum, count) = measured.fold((0.0, 0.0), |(sum, count), r| (sum + f64::from(*r).powi(2), count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
