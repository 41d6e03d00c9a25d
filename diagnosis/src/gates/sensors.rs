//! Sensors one by one: missing, dead, stuck or at the end of their range.

use sinew_physics::DriveKind;
use sinew_recording::{Column, required_inputs};

use super::gate::{Exclude, Gate, Warning};
use super::statistics::{span, stroke};
use crate::error::{Broken, Error, Trouble};
use crate::numbers::number;

/// A column with less than this share of its samples is left out …
const LEAST_PRESENT: f64 = 0.05;
/// … and with less than this a warning is given.
const FEW_PRESENT: f64 = 0.5;
/// Noise, in steps of the grid, from which equal samples in a row are no chance.
const NOISE_STEPS: f64 = 2.0;
/// Equal samples in a row that are no chance then, and the least time they take, s.
const FLAT_SAMPLES: usize = 12;
const FLAT_S: f64 = 0.05;
/// A column that is coarse, or has no noise, stands still by itself. It is stuck if it stands so long, s, …
const COARSE_FLAT_S: f64 = 2.0;
/// … while the model moves it by this share of its own stroke and so many steps of the grid.
const COARSE_SHARE: f64 = 0.3;
const COARSE_STEPS: f64 = 20.0;
/// At the end of its range, samples at the very extreme must be so many and this share of those near it.
const EXTREME_SAMPLES: usize = 20;
const EXTREME_SHARE: f64 = 0.25;
/// Stretches left out are joined where they are nearer than this, and widened by as much, in samples.
const PAD: usize = 3;
/// A column of which more is to be left out is left out whole.
const MOST_EXCLUDED: f64 = 0.5;

/// All sensors, and the inputs for standing still.
pub(super) fn check(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    for column in &gate.sensors {
        if let Some(warning) = sensor(gate, *column) {
            warnings.push(warning);
        }
    }
    required_inputs(gate.model).try_for_each(|column| input(gate, column))
}

fn sensor(gate: &Gate, column: Column) -> Option<Warning> {
    let values = gate.recording.get(column)?;
    let present = values.iter().filter(|v| v.is_finite()).count() as f64 / values.len() as f64;
    if present < LEAST_PRESENT {
        let text = format!("{} % of its samples are missing; it is left out", number(100.0 * (1.0 - present)));
        return Some(gate.warning(Some(column), Exclude::Column, text));
    }
    if span(values) == 0.0 {
        let at = values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
        let text = format!("stands at {} from beginning to end; it is left out", number(at));
        return Some(gate.warning(Some(column), Exclude::Column, text));
    }
    if let Some(warning) = limited(gate, column, values).or_else(|| stuck(gate, column, values)) {
        return Some(warning);
    }
    if present < FEW_PRESENT {
        let text = format!("{} % of its samples are missing", number(100.0 * (1.0 - present)));
        return Some(gate.warning(Some(column), Exclude::Nothing, text));
    }
    None
}

/// At the end of its range: noise is cut off there, so that many samples share one extreme value.
fn limited(gate: &Gate, column: Column, values: &[f64]) -> Option<Warning> {
    let noise = gate.noise[&column];
    if noise.white < NOISE_STEPS * noise.step || noise.white < 1e-6 * stroke(values) {
        return None;
    }
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (lowest, highest) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    for (extreme, word) in [(highest, "largest"), (lowest, "smallest")] {
        let at: Vec<usize> = (0..values.len()).filter(|i| values[*i] == extreme && flows(gate, column, *i)).collect();
        let near = finite().filter(|v| *v != extreme && (v - extreme).abs() < 3.0 * noise.white).count();
        let many = at.len() >= EXTREME_SAMPLES && at.len() as f64 > EXTREME_SHARE * near as f64;
        if let Some(first) = at.first().filter(|_| many) {
            let text = format!(
                "is at the end of its range: {} samples have the {word} value {}, the first at {} s; they are left out",
                at.len(),
                number(extreme),
                number(gate.recording.time_s()[*first])
            );
            return Some(left_out(gate, column, at.iter().map(|i| (*i, *i)), text));
        }
    }
    None
}

/// Standing still where it cannot.
fn stuck(gate: &Gate, column: Column, values: &[f64]) -> Option<Warning> {
    let still = stretches(gate, column, values);
    let &(from, to) = still.first()?;
    let times = gate.recording.time_s();
    let text = format!(
        "is stuck at {} from {} s to {} s{}; that is left out",
        number(values[from]),
        number(times[from]),
        number(times[to]),
        if still.len() > 1 { format!(" and {} times more", still.len() - 1) } else { String::new() }
    );
    Some(left_out(gate, column, still.into_iter(), text))
}

/// Rows from and to which a column stands still although it should not.
fn stretches(gate: &Gate, column: Column, values: &[f64]) -> Vec<(usize, usize)> {
    let noise = gate.noise[&column];
    let noisy = noise.white > NOISE_STEPS * noise.step && noise.white > 1e-6 * stroke(values);
    let times = gate.recording.time_s();
    let own = gate.simulated.columns.get(&column).map_or(0.0, |v| stroke(v));
    runs(values)
        .into_iter()
        .filter(|(from, to)| flows(gate, column, *from) && flows(gate, column, *to))
        .filter(|(from, to)| {
            let lasted = times[*to] - times[*from];
            let chance = to - from < FLAT_SAMPLES || lasted < FLAT_S;
            let moved = lasted >= COARSE_FLAT_S && {
                let should = model_moves(gate, column, *from, *to);
                should > COARSE_SHARE * own && should > COARSE_STEPS * noise.step.max(noise.white)
            };
            !chance && (noisy || moved)
        })
        .collect()
}

/// Rows from and to which a column has the very same value; missing samples neither end nor make such a run.
fn runs(values: &[f64]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (row, value) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        match runs.last_mut() {
            Some((from, to)) if values[*from] == *value => *to = row,
            _ => runs.push((row, row)),
        }
    }
    runs
}

/// How far the model moves a column between two rows.
fn model_moves(gate: &Gate, column: Column, from: usize, to: usize) -> f64 {
    let rows = &gate.simulated.rows;
    let (first, last) = (rows.partition_point(|r| *r < from), rows.partition_point(|r| *r <= to));
    gate.simulated.columns.get(&column).map_or(0.0, |values| span(&values[first..last.max(first)]))
}

/// Whether a column can say anything in a row: voltages and currents are nothing while the switch is off.
fn flows(gate: &Gate, column: Column, row: usize) -> bool {
    let electrical = matches!(column, Column::CurrentA | Column::V1V | Column::V2V | Column::V3V | Column::PowerW);
    let off = gate.model.drive.kind == DriveKind::Pwm
        && gate.recording.get(Column::Duty).is_some_and(|duty| duty[row] <= 0.0);
    !(electrical && off)
}

/// A warning that leaves these rows of a column out, or all of it where little would be left.
fn left_out(gate: &Gate, column: Column, rows: impl Iterator<Item = (usize, usize)>, text: String) -> Warning {
    let last = gate.recording.len() - 1;
    let mut windows: Vec<(usize, usize)> = Vec::new();
    for (from, to) in rows.map(|(from, to)| (from.saturating_sub(PAD), (to + PAD).min(last))) {
        match windows.last_mut() {
            Some((_, end)) if from <= *end + PAD => *end = to.max(*end),
            _ => windows.push((from, to)),
        }
    }
    let excluded: usize = windows.iter().map(|(from, to)| to - from + 1).sum();
    if excluded as f64 > MOST_EXCLUDED * gate.recording.len() as f64 {
        return gate.warning(
            Some(column),
            Exclude::Column,
            format!("{text}; little remains, so all of it is left out"),
        );
    }
    let times = gate.recording.time_s();
    let windows = windows.into_iter().map(|(from, to)| (times[from], times[to])).collect();
    gate.warning(Some(column), Exclude::Windows(windows), text)
}

/// An imposed force or a temperature with noise on it that stands still for seconds is no input.
fn input(gate: &Gate, column: Column) -> Result<(), Error> {
    // a duty or a power is set, not measured: it stands still by right
    if matches!(column, Column::Duty | Column::PowerW) {
        return Ok(());
    }
    let Some(values) = gate.recording.get(column) else { return Ok(()) };
    let noise = crate::noise::estimate(gate.recording, column, None);
    if span(values) == 0.0 || noise.white < NOISE_STEPS * noise.step || noise.white < 1e-4 * stroke(values) {
        return Ok(());
    }
    let times = gate.recording.time_s();
    let stuck =
        runs(values).into_iter().find(|(from, to)| to - from >= 2 * FLAT_SAMPLES && times[*to] - times[*from] > 1.0);
    match stuck {
        Some((from, to)) => Err(Broken {
            recording: gate.recording.name().into(),
            column: Some(column),
            span_s: Some((times[from], times[to])),
            what: Trouble::InputStuck { at: values[from] },
        }
        .into()),
        None => Ok(()),
    }
}
