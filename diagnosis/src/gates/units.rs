//! Lengths, forces, powers and temperatures against the wire's own size: another unit, another sign, another zero.

use sinew_physics::{DriveKind, Load};
use sinew_recording::{Column, drive_column, imposed_column};
use sinew_rig::PositionZero;

use super::gate::{Exclude, Gate, Warning};
use super::statistics::{Line, line, median, quantile, span, stroke};
use crate::error::{Error, Trouble};
use crate::numbers::number;

/// No NiTi wire carries more, Pa.
const MOST_STRESS_PA: f64 = 3e9;
/// Strain no wire survives: shape, elastic and thermal together.
const MOST_STRAIN: f64 = 0.3;
/// Strain a whole stroke cannot exceed.
const MOST_STROKE: f64 = 0.2;
/// A load that pulls with less is hardly one, and its force no measure, Pa.
const LEAST_STRESS_PA: f64 = 5e6;
/// A force may be off by this factor: preload, mass and friction together do less.
const FORCE_FACTOR: f64 = 5.0;
/// Share of the movement that the model must explain before the direction or the size of it is judged.
const EXPLAINED: f64 = 0.7;
/// A movement so many times the model's, or so small a part of it, is in another unit.
const MOVEMENT_FACTOR: f64 = 30.0;
/// The model must transform this much of the wire before a stroke can be held against its own.
const TRANSFORMS: f64 = 0.3;
/// A known zero may be off by so much of the wire's length, and by so many of the model's strokes.
const ZERO_SHARE: f64 = 0.1;
const ZERO_STROKES: f64 = 3.0;
/// Above this share of the length it is worth a warning.
const ZERO_DOUBT: f64 = 0.02;
/// Factors within this of a power of ten that units differ by are that power.
const NEAR: f64 = 3.0;

/// All of them.
pub(super) fn check(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    position(gate, warnings)?;
    force(gate)?;
    power(gate)?;
    temperature(gate, warnings)
}

/// `scale` for values that are `ratio` times too large, if that is what units differ by: thousand, hundred or million.
fn unit(ratio: f64) -> Option<f64> {
    [1e-3, 1e3, 1e-2, 1e2, 1e-6, 1e6].into_iter().find(|scale| {
        let off = ratio * scale;
        (1.0 / NEAR..=NEAR).contains(&off)
    })
}

fn position(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let Some(values) = gate.recording.get(Column::PositionM) else { return Ok(()) };
    let column = Some(Column::PositionM);
    let length = gate.model.geometry.length_m;
    let moved = stroke(values);
    if moved > MOST_STROKE * length {
        let of = "the stroke, m,";
        let remedy = "check the unit of the column (m) and length_mm of the rig file";
        return Err(gate.broken(column, Trouble::Impossible { found: moved, limit: MOST_STROKE * length, of, remedy }));
    }
    let known = gate.channel.position_zero == PositionZero::Known;
    let farthest = quantile(values.iter().map(|v| v.abs()), 0.99);
    if known && farthest > MOST_STRAIN * length {
        let of = "the elongation, m,";
        let remedy = "position_m counts from L_0; where its zero is arbitrary set [channel.sensors] position_zero = \
                      \"free\" in the rig file";
        return Err(
            gate.broken(column, Trouble::Impossible { found: farthest, limit: MOST_STRAIN * length, of, remedy })
        );
    }
    let Some((measured, simulated)) = gate.pair(Column::PositionM) else { return Ok(()) };
    let noise = gate.noise[&Column::PositionM].total;
    let own = stroke(simulated);
    let transforms = span(&gate.simulated.martensite) > TRANSFORMS && own > 20.0 * noise.min(1e-3 * length);
    if transforms && moved > 20.0 * noise {
        let Line { slope, explained } = line(simulated, &measured);
        if explained > EXPLAINED && slope < 0.0 {
            return Err(gate.broken(column, Trouble::WrongSign));
        }
        let outside = moved > MOVEMENT_FACTOR * own || moved < own / MOVEMENT_FACTOR;
        if outside
            && explained > EXPLAINED
            && let Some(scale) = unit(moved / own)
        {
            return Err(gate.broken(column, Trouble::WrongUnit { found: moved, expected: own, scale }));
        }
    }
    // at the long and at the short end: a wire that does not transform as far as its model is off at one of them only
    let end = |share: f64| quantile(measured.iter().copied(), share) - quantile(simulated.iter().copied(), share);
    let (short, long) = (end(0.02), end(0.98));
    let off = if short.abs() < long.abs() { short } else { long };
    if known && off.abs() > (ZERO_SHARE * length).max(ZERO_STROKES * own) {
        let of = "the distance from where the rig file's wire would be, m,";
        let remedy = "where the zero of position_m is arbitrary set [channel.sensors] position_zero = \"free\" in the rig \
                      file; else check length_mm and the load";
        let limit = (ZERO_SHARE * length).max(ZERO_STROKES * own);
        return Err(gate.broken(column, Trouble::Impossible { found: off.abs(), limit, of, remedy }));
    }
    if known && off.abs() > (ZERO_DOUBT * length).max(own) {
        let text = format!(
            "lies {} m from where the rig file's wire would be; if its zero is arbitrary, set [channel.sensors] \
             position_zero = \"free\"",
            number(off)
        );
        warnings.push(gate.warning(column, Exclude::Nothing, text));
    }
    Ok(())
}

fn force(gate: &Gate) -> Result<(), Error> {
    let Some(values) = gate.recording.get(Column::ForceN) else { return Ok(()) };
    let column = Some(Column::ForceN);
    let limit = MOST_STRESS_PA * gate.model.geometry.area_m2();
    let lowest = quantile(values.iter().copied(), 0.01);
    let highest = quantile(values.iter().copied(), 0.99);
    // tension is positive, and a wire cannot push: all of it well below zero is the other way round
    if highest < 0.0 && highest < 0.2 * lowest {
        return Err(gate.broken(column, Trouble::WrongSign));
    }
    level(gate)?;
    let largest = quantile(values.iter().map(|v| v.abs()), 0.99);
    if largest > limit {
        let of = "the tension, N,";
        let remedy = "no wire of this diameter carries that: check the unit of the column (N) and diameter_mm";
        return Err(gate.broken(column, Trouble::Impossible { found: largest, limit, of, remedy }));
    }
    Ok(())
}

/// A force against what the load pulls with. Where the position is imposed, the tension hangs on its zero.
fn level(gate: &Gate) -> Result<(), Error> {
    let Some((measured, simulated)) = gate.pair(Column::ForceN) else { return Ok(()) };
    let (found, expected) = (median(measured), median(simulated.iter().copied()));
    let loaded = matches!(gate.model.load, Load::SpringMassDamper { .. });
    if !loaded || found.is_nan() || expected < LEAST_STRESS_PA * gate.model.geometry.area_m2() {
        return Ok(());
    }
    let ratio = found / expected;
    if (1.0 / FORCE_FACTOR..=FORCE_FACTOR).contains(&ratio) {
        return Ok(());
    }
    // grams of force and kilograms are as usual as milli
    let scale = [9.80665e-3, 9.80665].into_iter().find(|s| (0.5..=2.0).contains(&(ratio * s))).or_else(|| unit(ratio));
    let what = match scale {
        Some(scale) => Trouble::WrongUnit { found, expected, scale },
        None => Trouble::OtherRig { of: "the tension, N,", found, expected, keys: "[channel.load]" },
    };
    Err(gate.broken(Some(Column::ForceN), what))
}

fn power(gate: &Gate) -> Result<(), Error> {
    let Some((measured, simulated)) = gate.pair(Column::PowerW) else { return Ok(()) };
    let heating = 0.2 * quantile(simulated.iter().copied(), 0.99);
    let both = measured.iter().zip(simulated).filter(|(m, s)| **s > heating && m.is_finite());
    let (found, expected): (Vec<f64>, Vec<f64>) = both.map(|(m, s)| (*m, *s)).unzip();
    let (found, expected) = (median(found), median(expected));
    if let Some(scale) = unit(found / expected) {
        return Err(gate.broken(Some(Column::PowerW), Trouble::WrongUnit { found, expected, scale }));
    }
    Ok(())
}

fn temperature(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let ambient = gate.recording.get(Column::AmbientC).map(|a| median(a.iter().copied()));
    if let Some(found) = ambient.filter(|a| (a - gate.model.ambient_c).abs() > 15.0) {
        let text = format!(
            "is about {} °C, the rig file says {} °C; what was measured is taken",
            number(found),
            number(gate.model.ambient_c)
        );
        warnings.push(gate.warning(Some(Column::AmbientC), Exclude::Nothing, text));
    }
    let (drive, imposed) = (drive_column(gate.model.drive.kind), imposed_column(&gate.model.load));
    let Some(values) = gate.recording.get(Column::TemperatureC) else { return Ok(()) };
    if gate.model.drive.kind == DriveKind::Temperature || imposed == Some(drive) {
        return Ok(());
    }
    // a sensor that is warmer than anything the wire can be at rest, from its first to its last sample
    let coldest = quantile(values.iter().copied(), 0.01);
    if coldest > gate.model.ambient_c + 200.0 {
        let of = "the coldest temperature, °C,";
        let remedy = "check the unit of the column (°C, not kelvin) and ambient_c of the rig file";
        let limit = gate.model.ambient_c + 200.0;
        return Err(gate.broken(Some(Column::TemperatureC), Trouble::Impossible { found: coldest, limit, of, remedy }));
    }
    Ok(())
}
