//! Times: whether there are enough, whether any are missing, come in bursts or twice, and whether the clock ran true.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use sinew_physics::DriveKind;
use sinew_recording::{Column, TIME, drive_column};

use super::{Exclude, Gate, Warning, line, simulate, stroke};
use crate::error::{Broken, Error, Trouble, number};

/// The wire's own time constants a recording must last, and the bounds of that, s.
const LEAST_TIME_CONSTANTS: f64 = 3.0;
const LEAST_LENGTH_S: (f64, f64) = (1.0, 5.0);
/// An interval so many times the typical one is a gap, if it is longer than a share of the wire's time constant.
const GAP_INTERVALS: f64 = 5.0;
const GAP_TIME_CONSTANTS: f64 = 0.2;
/// More than this share of the time in gaps, and there is no recording.
const MOST_GAPS: f64 = 0.3;
/// After a gap with another drive the wire needs so many time constants to forget it.
const FORGETS: f64 = 3.0;
/// Times come in bursts where this share of the intervals is less than a tenth of the mean one.
const BURSTS: f64 = 0.2;
/// Samples that must be the same, noise and all, to be a copy.
const COPY: usize = 20;
/// Noise, in steps of the column's grid, from which equal samples are no chance.
const NOISE_STEPS: f64 = 2.0;

/// Enough of them, over long enough.
pub(super) fn samples(gate: &Gate) -> Result<(), Error> {
    let found_s = gate.recording.duration_s();
    let least_s = (LEAST_TIME_CONSTANTS * gate.time_constant_s()).clamp(LEAST_LENGTH_S.0, LEAST_LENGTH_S.1);
    match found_s < least_s {
        true => Err(gate.broken(None, Trouble::TooShort { found_s, least_s })),
        false => Ok(()),
    }
}

/// Gaps. Where the drive was another after one, nobody knows when it changed: what follows is left out.
pub(super) fn gaps(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let times = gate.recording.time_s();
    let longest = (GAP_INTERVALS * gate.recording.median_interval_s()).max(GAP_TIME_CONSTANTS * gate.time_constant_s());
    let gaps: Vec<usize> = (1..times.len()).filter(|i| times[*i] - times[i - 1] > longest).collect();
    let Some(&first) = gaps.first() else { return Ok(()) };
    let gaps_s: f64 = gaps.iter().map(|i| times[*i] - times[i - 1]).sum();
    let duration_s = gate.recording.duration_s();
    if gaps_s > MOST_GAPS * duration_s {
        return Err(gate.broken(None, Trouble::MostlyGaps { gaps_s, duration_s }));
    }
    let drive = gate.recording.get(drive_column(gate.model.drive.kind)).unwrap_or(&[]);
    let range = stroke(drive);
    let unknown: Vec<(f64, f64)> = gaps
        .iter()
        .filter(|i| (drive[**i] - drive[**i - 1]).abs() > 0.05 * range)
        .map(|i| (times[i - 1], times[*i] + FORGETS * gate.time_constant_s()))
        .collect();
    let mut text = format!(
        "{} of {} s in all, the first from {} s to {} s",
        if gaps.len() == 1 { "a gap".into() } else { format!("{} gaps", gaps.len()) },
        number(gaps_s),
        number(times[first - 1]),
        number(times[first])
    );
    text += if unknown.is_empty() {
        "; the drive was the same on both sides and is taken to have stayed so"
    } else {
        "; the drive changed meanwhile, so what follows is left out until the wire has forgotten it"
    };
    let exclude = if unknown.is_empty() { Exclude::Nothing } else { Exclude::Windows(unknown) };
    warnings.push(gate.warning(None, exclude, text));
    Ok(())
}

/// Times of arrival instead of times of measurement.
pub(super) fn bursts(gate: &Gate, warnings: &mut Vec<Warning>) {
    let times = gate.recording.time_s();
    let mean = gate.recording.duration_s() / (times.len() - 1) as f64;
    let short = times.windows(2).filter(|w| w[1] - w[0] < 0.1 * mean).count() as f64 / (times.len() - 1) as f64;
    if short > BURSTS {
        let text = format!(
            "column \"{TIME}\": samples come in bursts ({} % of the intervals are below a tenth of the mean): these look \
             like times of arrival; record the times of measurement",
            number(100.0 * short)
        );
        warnings.push(gate.warning(None, Exclude::Nothing, text));
    }
}

/// A stretch of noise that is there twice was copied, and the times after it are wrong.
pub(super) fn repeats(gate: &Gate) -> Result<(), Error> {
    for column in &gate.sensors {
        let (Some(values), Some(noise)) = (gate.recording.get(*column), gate.noise.get(column)) else { continue };
        // smooth or coarse columns repeat by themselves
        let noisy =
            noise.white.is_finite() && noise.white > NOISE_STEPS * noise.step && noise.white > 1e-4 * stroke(values);
        if noisy && let Some((first, second)) = copied(values) {
            let same = (0..values.len() - second).take_while(|i| values[first + i] == values[second + i]).count();
            let times = gate.recording.time_s();
            let what = Trouble::RepeatedBlock { samples: same, first_s: times[first] };
            let span_s = Some((times[second], times[second + same - 1]));
            return Err(Broken { recording: gate.recording.name().into(), column: Some(*column), span_s, what }.into());
        }
    }
    Ok(())
}

/// The first samples of two equal stretches, if there are such.
fn copied(values: &[f64]) -> Option<(usize, usize)> {
    let mut seen: HashMap<u64, usize> = HashMap::with_capacity(values.len());
    for (start, stretch) in values.windows(COPY).enumerate() {
        let different = stretch.windows(2).filter(|w| w[0] != w[1]).count();
        if different < COPY / 2 || stretch.iter().any(|v| v.is_nan()) {
            continue;
        }
        let mut hasher = DefaultHasher::new();
        stretch.iter().for_each(|v| v.to_bits().hash(&mut hasher));
        let first = *seen.entry(hasher.finish()).or_insert(start);
        if start >= first + COPY && values[first..first + COPY] == *stretch {
            return Some((first, start));
        }
    }
    None
}

/// A sensor is asked for the pace if it moves so many times its noise.
const MOVES: f64 = 20.0;
/// Paces that are tried, in half octaves from a sixteenth to sixteenfold.
const PACES: std::ops::RangeInclusive<i32> = -8..=8;
/// Longest recording that is simulated for it, in rows.
const RATE_ROWS: usize = 100_000;
/// Rows that are compared for it.
const RATE_COMPARED: usize = 2_000;
/// Where this little of the movement is left at the recorded pace, no other is better.
const LEFT_LEAST: f64 = 0.02;
/// The clock is wrong if the best pace leaves less than this share of what the recorded pace leaves, and of the movement …
const LEFT_BY_RIGHT_PACE: (f64, f64) = (0.5, 0.25);
/// … and lies so many standard deviations of the priors away, as convection and heat capacity set the pace too.
const PACE_SIGMAS: f64 = 2.5;
/// Latent heat that the rig file leaves out slows the wire by about this.
const LATENT: f64 = 1.35;
/// A wire this much too slow may be in a sleeve, which the catalogue knows: slower than that is the clock.
const SLEEVE: f64 = 4.0;

/// A clock that is off by a factor makes a wire that seems to be another: all it does is right but for its pace.
pub(super) fn rate(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    // in a furnace nothing depends on the pace
    if gate.model.drive.kind == DriveKind::Temperature || gate.recording.len() > RATE_ROWS {
        return Ok(());
    }
    let moves = |c: &Column| gate.recording.get(*c).map_or(0.0, stroke) > MOVES * gate.noise[c].total;
    let moving: Vec<Column> = gate.sensors.iter().copied().filter(moves).collect();
    if moving.is_empty() || left_at(gate, &moving, 1.0)? < LEFT_LEAST {
        return Ok(());
    }
    let octaves = |i: i32| f64::from(i) / 2.0;
    let left: Vec<f64> = PACES.map(|i| left_at(gate, &moving, 2f64.powf(octaves(i)))).collect::<Result<_, Error>>()?;
    let Some(best) = (0..left.len()).min_by(|a, b| left[*a].total_cmp(&left[*b])) else { return Ok(()) };
    // a best one at the end of the range is no optimum
    if best == 0 || best + 1 == left.len() {
        return Ok(());
    }
    // the parabola through the best and its neighbours
    let (below, above) = (left[best - 1] - left[best], left[best + 1] - left[best]);
    let vertex = if below + above > 0.0 { 0.5 * (below - above) / (below + above) } else { 0.0 };
    let factor = 2f64.powf(octaves(PACES.start() + best as i32) + 0.5 * vertex);
    let recorded = left[(-PACES.start()) as usize];
    let better = left[best] < LEFT_BY_RIGHT_PACE.0 * recorded && left[best] < LEFT_BY_RIGHT_PACE.1;
    let sigma = |key: &str| {
        let value = gate.channel.parameter(key).unwrap_or(1.0);
        gate.channel.priors_in_force().get(key).map_or(0.0, |prior| prior.sigma(value) / value.abs().max(1e-9))
    };
    let faster = (PACE_SIGMAS * sigma("convection_w_per_m2_k").hypot(sigma("specific_heat_j_per_kg_k"))).exp();
    let latent = if gate.model.material.latent_heat_j_per_kg == 0.0 { LATENT } else { 1.0 };
    if better && (factor > faster || factor < 1.0 / (SLEEVE * faster)) {
        return Err(gate.broken(None, Trouble::ClockRate { factor }));
    }
    if better && factor < 1.0 / (faster * latent) {
        let text = format!(
            "the wire answers as if a recorded second were {} s: check the sampling rate the times were made from; if it \
             is right, something stores heat beside the wire",
            number(factor)
        );
        warnings.push(gate.warning(None, Exclude::Nothing, text));
    }
    Ok(())
}

/// The share of the movement that a straight line in what is simulated at a pace leaves, over all that moves.
fn left_at(gate: &Gate, moving: &[Column], pace: f64) -> Result<f64, Error> {
    let simulated = simulate(gate.recording, gate.model, pace, RATE_COMPARED)?;
    let each = moving.iter().filter_map(|column| {
        let values = gate.recording.get(*column)?;
        let measured: Vec<f64> = simulated.rows.iter().map(|row| values[*row]).collect();
        let explained = line(&simulated.columns[column], &measured).1;
        Some(if explained.is_finite() { 1.0 - explained } else { 1.0 })
    });
    Ok(each.sum::<f64>() / moving.len() as f64)
}
