//! Times: whether there are enough, whether any are missing, come in bursts or twice, and whether the clock ran true.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use sinew_physics::{DriveKind, Load, WireModel};
use sinew_recording::{Column, Recording, TIME, drive_column};

use super::gate::{Exclude, Gate, LEAST_CONVECTION, Warning, simulate};
use super::statistics::{Line, line, quantile, stroke};
use crate::error::{Broken, Error, Trouble};
use crate::numbers::number;

/// The wire's own time constants a recording must last, and the bounds of that, s.
const LEAST_TIME_CONSTANTS: f64 = 3.0;
const LEAST_LENGTH_FROM_S: f64 = 1.0;
const LEAST_LENGTH_TO_S: f64 = 5.0;
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
    let least_s = (LEAST_TIME_CONSTANTS * gate.time_constant_s()).clamp(LEAST_LENGTH_FROM_S, LEAST_LENGTH_TO_S);
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

/// A step from one sample to the next is a jump if it is so many times the noise …
const JUMP_NOISE: f64 = 20.0;
/// … and so many times the largest but one in two hundred of all steps, and the steps on either side of it.
const JUMP_STEPS: f64 = 5.0;
/// The wire must be sampled so finely against its time constant that it cannot do that by itself.
const JUMP_SAMPLES: f64 = 20.0;

/// Where resistance and load jump together, samples are missing and the clock does not know: neither can jump by itself,
/// and nothing else moves both at once.
pub(super) fn jumps(gate: &Gate) -> Result<(), Error> {
    let interval_s = gate.recording.median_interval_s();
    let moves_by_itself = !matches!(gate.model.load, Load::SpringMassDamper { .. });
    if moves_by_itself || gate.time_constant_s() < JUMP_SAMPLES * interval_s {
        return Ok(());
    }
    let of = |columns: &[Column]| -> Vec<usize> {
        let there = columns.iter().filter(|c| gate.sensors.contains(c));
        let mut rows: Vec<usize> = there.flat_map(|c| jumps_of(gate, *c)).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    };
    let electrical = of(&[Column::CurrentA, Column::V2V, Column::V3V]);
    let mechanical = of(&[Column::PositionM, Column::ForceN]);
    let times = gate.recording.time_s();
    // a gap that the clock knows of is no secret
    let hidden = |row: &&usize| times[**row] - times[**row - 1] < 3.0 * interval_s;
    let both: Vec<usize> = electrical.iter().filter(hidden).filter(|r| mechanical.contains(r)).copied().collect();
    match both.first() {
        Some(&row) => {
            let what = Trouble::SamplesLost { times: both.len() };
            let span_s = Some((times[row - 1], times[row]));
            Err(Broken { recording: gate.recording.name().into(), column: None, span_s, what }.into())
        }
        None => Ok(()),
    }
}

/// Rows into which a column jumps.
fn jumps_of(gate: &Gate, column: Column) -> Vec<usize> {
    let values = gate.recording.get(column).unwrap_or(&[]);
    let steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let usual = quantile(steps.iter().copied(), 0.995);
    let least = (JUMP_NOISE * gate.noise[&column].white).max(JUMP_STEPS * usual);
    (2..steps.len().saturating_sub(2))
        .filter(|i| steps[*i] > least)
        .filter(|i| [*i - 2, *i - 1, *i + 1, *i + 2].iter().all(|n| JUMP_STEPS * steps[*n] < steps[*i]))
        .map(|i| i + 1)
        .collect()
}

/// A sensor is used to find the pace if it moves so many times its noise.
const MOVES: f64 = 20.0;
/// So much from the beginning is simulated for it, in rows and in time constants of the wire, whichever is more: a
/// clock is wrong from its first tick.
const RATE_ROWS: usize = 5_000;
const RATE_TIME_CONSTANTS: f64 = 30.0;
/// A recording so fine that this is still more than so many rows is not used.
const RATE_MOST_ROWS: usize = 50_000;
/// Rows that are compared for it.
const RATE_COMPARED: usize = 2_000;
/// Paces that are tried, in half octaves from a sixteenth to sixteenfold.
const PACES: std::ops::RangeInclusive<i32> = -8..=8;
/// Factors of the loss to the air, and shifts of ambient against transformation, K, that are tried with each: what the
/// rig file gives for them is least certain and moves everything.
const LOSSES: [f64; 5] = [0.6, 0.77, 1.0, 1.3, 1.67];
const SHIFTS_K: [f64; 3] = [-8.0, 0.0, 8.0];
/// Where this little of the movement is left at the recorded pace, no other is better.
const LEFT_LEAST: f64 = 0.02;
/// The clock is wrong if the best pace leaves less than this share of what any credible pace leaves …
const LEFT_BY_RIGHT_PACE: f64 = 0.35;
/// … and of the movement.
const LEFT_AT_MOST: f64 = 0.25;
/// Credible is a pace within so many standard deviations of the priors: convection and heat capacity set it too.
const PACE_SIGMAS: f64 = 2.5;
/// Latent heat that the rig file leaves out slows the wire by about this.
const LATENT: f64 = 1.35;
/// A wire this much too slow may be in a sleeve, which the catalogue knows: slower than that is the clock.
const SLEEVE: f64 = 4.0;

/// What is tried of a sleeve: its heat capacity against what would slow a wire without latent heat as much, its contact
/// with the wire and its loss to the air, both against the wire's own loss.
const SLEEVE_ID: &str = "thermal.sheath";
const SLEEVE_CAPACITIES: [f64; 2] = [1.0, 1.6];
const SLEEVE_CONTACTS: [f64; 2] = [5.0, 40.0];
const SLEEVE_LOSSES: [f64; 3] = [0.77, 1.0, 1.3];

/// A clock that is off by a factor makes a wire that seems to be another: all it does is right but for its pace.
pub(super) fn rate(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let times = gate.recording.time_s();
    let enough = times.partition_point(|t| *t < times[0] + RATE_TIME_CONSTANTS * gate.time_constant_s());
    let rows = enough.max(RATE_ROWS).min(times.len());
    // in a furnace nothing depends on the pace
    if gate.model.drive.kind == DriveKind::Temperature || rows > RATE_MOST_ROWS {
        return Ok(());
    }
    let beginning = first(gate.recording, rows)?;
    let moves = |c: &Column| beginning.get(*c).map_or(0.0, stroke) > MOVES * gate.noise[c].total;
    let moving: Vec<Column> = gate.sensors.iter().copied().filter(moves).collect();
    let pacer = Pacer { gate, beginning: &beginning, moving };
    if pacer.moving.is_empty() || pacer.left_at(1.0, 1.0, 0.0)? < LEFT_LEAST {
        return Ok(());
    }
    let sigma = |key: &str| {
        let value = gate.channel.parameter(key).unwrap_or(1.0);
        gate.channel.priors_in_force().get(key).map_or(0.0, |prior| prior.sigma(value) / value.abs().max(1e-9))
    };
    let faster = (PACE_SIGMAS * sigma("convection_w_per_m2_k").hypot(sigma("specific_heat_j_per_kg_k"))).exp();
    let latent = if gate.model.material.latent_heat_j_per_kg == 0.0 { LATENT } else { 1.0 };
    let credible = (1.0 / (faster * latent))..=faster;
    let pace = |i: i32| 2f64.powf(f64::from(i) / 2.0);

    // first with all else as given: nearly always that settles it
    let left = |i: i32, loss: f64, shift_k: f64| pacer.left_at(pace(i), loss, shift_k);
    let as_given: Vec<f64> = PACES.map(|i| left(i, 1.0, 0.0)).collect::<Result<_, Error>>()?;
    let Some(factor) = lowest(&as_given).filter(|factor| !credible.contains(factor)) else { return Ok(()) };
    // then the best that either kind of pace can do with other parameters
    let best = |paces: Vec<i32>| -> Result<f64, Error> {
        let mut least = f64::INFINITY;
        for i in paces {
            for loss in LOSSES {
                for shift_k in SHIFTS_K {
                    least = least.min(left(i, loss, shift_k)?);
                }
            }
        }
        Ok(least)
    };
    let nearest = (2.0 * factor.log2()).round() as i32;
    let clock = best(vec![nearest])?;
    if clock > LEFT_AT_MOST
        || clock > LEFT_BY_RIGHT_PACE * best(PACES.filter(|i| credible.contains(&pace(*i))).collect())?
    {
        return Ok(());
    }
    if factor > 1.0 || factor < 1.0 / (SLEEVE * faster) {
        return Err(gate.broken(None, Trouble::ClockRate { factor }));
    }
    if pacer.in_sleeve(factor)? < clock {
        return Ok(());
    }
    let text = format!(
        "the wire answers as if a recorded second were {} s: check the sampling rate the times were made from; if it is \
         right, something stores heat beside the wire",
        number(factor)
    );
    warnings.push(gate.warning(None, Exclude::Nothing, text));
    Ok(())
}

/// The pace that leaves least, by the parabola through it and its neighbours; none where that is at the end of the
/// range, which is no optimum.
fn lowest(left: &[f64]) -> Option<f64> {
    let best = (0..left.len()).min_by(|a, b| left[*a].total_cmp(&left[*b]))?;
    let (before, after) = (*left.get(best.checked_sub(1)?)?, *left.get(best + 1)?);
    let (below, above) = (before - left[best], after - left[best]);
    let vertex = if below + above > 0.0 { 0.5 * (below - above) / (below + above) } else { 0.0 };
    let half_octaves = f64::from(*PACES.start()) + best as f64 + vertex;
    Some(2f64.powf(half_octaves / 2.0))
}

/// The first rows of a recording.
fn first(recording: &Recording, rows: usize) -> Result<Recording, Error> {
    let mut beginning = Recording::new(recording.name(), recording.time_s()[..rows].to_vec())?;
    for (column, values) in recording.columns() {
        beginning.set(column, values[..rows].to_vec())?;
    }
    Ok(beginning)
}

/// Moves both transformations.
fn shift(model: &mut WireModel, shift_k: f64) {
    model.material.austenite_temperature_c += shift_k;
    model.material.martensite_temperature_c += shift_k;
}

/// Sets a parameter of an effect.
fn set(model: &mut WireModel, id: &str, key: &str, value: f64) {
    let effect = sinew_physics::effects::effect(id);
    if let Some(parameter) = effect.and_then(|effect| effect.parameters.iter().find(|p| p.key == key)) {
        parameter.set(model, value.clamp(parameter.low, parameter.high));
    }
}

/// What the pace is found from.
struct Pacer<'a> {
    gate: &'a Gate<'a>,
    beginning: &'a Recording,
    moving: Vec<Column>,
}

impl Pacer<'_> {
    /// What is left at a pace, with the loss to the air by a factor and transformation at other temperatures.
    fn left_at(&self, pace: f64, loss: f64, shift_k: f64) -> Result<f64, Error> {
        let mut model = self.gate.model.clone();
        model.material.convection_w_per_m2_k *= loss;
        shift(&mut model, shift_k);
        self.left_by(&model, pace)
    }

    /// The least that a sleeve leaves which makes the wire slower by this factor: the one thing of the catalogue that can.
    fn in_sleeve(&self, factor: f64) -> Result<f64, Error> {
        let given = self.gate.model;
        let capacity = given.heat_capacity_j_per_k();
        let loss = given.geometry.loss_w_per_k(given.material.convection_w_per_m2_k.max(LEAST_CONVECTION));
        let mut least = f64::INFINITY;
        for more in SLEEVE_CAPACITIES {
            for (inner, outer) in SLEEVE_CONTACTS.into_iter().flat_map(|i| SLEEVE_LOSSES.map(|o| (i, o))) {
                for shift_k in SHIFTS_K {
                    let mut model = given.clone();
                    shift(&mut model, shift_k);
                    set(&mut model, SLEEVE_ID, "heat_capacity_j_per_k", more * (1.0 / factor - 1.0) * capacity);
                    set(&mut model, SLEEVE_ID, "inner_w_per_k", inner * loss);
                    set(&mut model, SLEEVE_ID, "outer_w_per_k", outer * loss);
                    least = least.min(self.left_by(&model, 1.0)?);
                }
            }
        }
        Ok(least)
    }

    /// The share of the movement that a rising line in what a model gives at a pace leaves, over all that moves.
    fn left_by(&self, model: &WireModel, pace: f64) -> Result<f64, Error> {
        let simulated = simulate(self.beginning, model, pace, RATE_COMPARED)?;
        let each = self.moving.iter().filter_map(|column| {
            let values = self.beginning.get(*column)?;
            let measured: Vec<f64> = simulated.rows.iter().map(|row| values[*row]).collect();
            let Line { slope, explained } = line(&simulated.columns[column], &measured);
            Some(if slope > 0.0 && explained.is_finite() { 1.0 - explained } else { 1.0 })
        });
        Ok(each.sum::<f64>() / self.moving.len() as f64)
    }
}
