//! Current and voltages: whether they fit each other, the supply, the pulses and the wire.

use sinew_physics::DriveKind;
use sinew_recording::Column;

use super::gate::{Exclude, Gate, Warning};
use super::statistics::{Line, line, median, quantile, stroke};
use crate::error::{Error, Trouble};
use crate::numbers::number;

/// A current below this share of the expected is none.
const NO_CURRENT: f64 = 0.02;
/// A wire's resistance may be off by this factor and by so many Ω: leads, crimps and other wire together do less.
const RESISTANCE_FACTOR: f64 = 2.0;
const RESISTANCE_OHM: f64 = 2.0;
/// Factors within this of 1000 are a milli.
const NEAR_THOUSAND: f64 = 3.0;
/// V_3 may exceed the supply by this factor.
const SUPPLY_FACTOR: f64 = 1.3;
/// What is between supply and wire besides the rig file's: Ω, and as a multiple of the wire's resistance.
const EXTRA_OHM: f64 = 3.0;
const EXTRA_SHARE: f64 = 1.0;
/// A tap may lie above the next by this share of the whole voltage, and by so many times its noise.
const TAP_ORDER: f64 = 0.02;
/// The taps' share of the whole voltage may be off by this factor.
const TAP_FACTOR: f64 = 2.0;

/// Everything about the circuit.
pub(super) fn check(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    supply(gate, warnings)?;
    if !matches!(gate.model.drive.kind, DriveKind::Pwm | DriveKind::Current) {
        return Ok(());
    }
    let samples = Samples::of(gate);
    flows(gate, &samples)?;
    voltage(gate, &samples)?;
    on_phase(gate, &samples)?;
    resistance(gate, &samples)?;
    taps(gate, &samples, warnings)
}

/// The measured supply against the rig file's. It wins, but not over its unit.
fn supply(gate: &Gate, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let Some(values) = gate.recording.get(Column::SupplyV).filter(|_| gate.model.drive.kind == DriveKind::Pwm) else {
        return Ok(());
    };
    let found = median(values.iter().copied());
    let expected = gate.model.drive.supply_v;
    if found.is_nan() || expected <= 0.0 {
        return Ok(());
    }
    if found <= 0.0 {
        return Err(gate.broken(
            Some(Column::SupplyV),
            Trouble::OtherRig { of: "the supply, V,", found, expected, keys: "[channel.drive] supply_v" },
        ));
    }
    if let Some(scale) = milli(found / expected) {
        return Err(gate.broken(Some(Column::SupplyV), Trouble::WrongUnit { found, expected, scale }));
    }
    if !(0.5..=2.0).contains(&(found / expected)) {
        let text =
            format!("is about {} V, the rig file says {} V; what was measured is taken", number(found), expected);
        warnings.push(gate.warning(Some(Column::SupplyV), Exclude::Nothing, text));
    }
    Ok(())
}

/// 0.001 or 1000 where a ratio is near 1000 or 0.001.
fn milli(ratio: f64) -> Option<f64> {
    let near = |target: f64| (target / NEAR_THOUSAND..=target * NEAR_THOUSAND).contains(&ratio);
    if near(1e3) { Some(1e-3) } else { near(1e-3).then_some(1e3) }
}

/// The compared rows in which the switch is on at all.
struct Samples {
    duty: Vec<f64>,
    current: Option<Vec<f64>>,
    v3: Option<Vec<f64>>,
    supply: Vec<f64>,
    /// By the rig file.
    resistance: Vec<f64>,
    /// By the rig file.
    expected_current: Vec<f64>,
}

impl Samples {
    fn of(gate: &Gate) -> Samples {
        let s = &gate.simulated;
        let duty = match gate.model.drive.kind {
            DriveKind::Pwm => gate.measured(Column::Duty).unwrap_or_default(),
            _ => vec![1.0; s.rows.len()],
        };
        let on: Vec<usize> = (0..s.rows.len()).filter(|i| duty[*i] > 0.0).collect();
        let pick = |values: &[f64]| -> Vec<f64> { on.iter().map(|i| values[*i]).collect() };
        // a current that drives the wire is no sensor, and just as good here
        let input = gate.model.drive.kind == DriveKind::Current;
        let of = |column| if input && column == Column::CurrentA { gate.measured(column) } else { gate.sensor(column) };
        let measured = |column| of(column).map(|v| pick(&v)).filter(|v| v.iter().any(|x| x.is_finite()));
        Samples {
            duty: pick(&duty),
            current: measured(Column::CurrentA),
            v3: measured(Column::V3V),
            supply: pick(&s.supply_v),
            resistance: pick(&s.resistance_ohm),
            expected_current: pick(&s.columns[&Column::CurrentA]),
        }
    }
}

/// Whether any current flows.
fn flows(gate: &Gate, samples: &Samples) -> Result<(), Error> {
    let Some(current) = &samples.current else { return Ok(()) };
    let expected_a = median(samples.expected_current.iter().copied());
    let largest = quantile(current.iter().map(|i| i.abs()), 0.95);
    // a thousandth of what is expected may be another unit: reported as such further on
    let none = largest < NO_CURRENT * expected_a && milli(largest / expected_a).is_none();
    match none && expected_a > 0.0 {
        true => Err(gate.broken(Some(Column::CurrentA), Trouble::NoCurrent { expected_a })),
        false => Ok(()),
    }
}

/// No voltage over the wire is above the supply.
fn voltage(gate: &Gate, samples: &Samples) -> Result<(), Error> {
    let (Some(v3), DriveKind::Pwm) = (&samples.v3, gate.model.drive.kind) else { return Ok(()) };
    let (found, supply) = (median(v3.iter().copied()), median(samples.supply.iter().copied()));
    if found.is_nan() || supply <= 0.0 {
        return Ok(());
    }
    let column = Some(Column::V3V);
    if let Some(scale) = milli(found / supply) {
        return Err(gate.broken(column, Trouble::WrongUnit { found, expected: supply, scale }));
    }
    if found > SUPPLY_FACTOR * supply {
        let (of, remedy) = (
            "the voltage over the wire, V,",
            "no more than the supply can stand over the wire: check the column's unit and [channel.drive] supply_v",
        );
        return Err(gate.broken(column, Trouble::Impossible { found, limit: supply, of, remedy }));
    }
    if found < -TAP_ORDER * supply {
        return Err(gate.broken(column, Trouble::WrongSign));
    }
    Ok(())
}

/// The wire's resistance from what is measured, against the rig file's wire.
fn resistance(gate: &Gate, samples: &Samples) -> Result<(), Error> {
    let drive = &gate.model.drive;
    let series = drive.series_ohm();
    let Some(current) = &samples.current else { return Ok(()) };
    let flowing = 0.2 * quantile(current.iter().map(|i| i.abs()), 0.95);
    let each = |over_wire: &dyn Fn(usize, f64) -> f64| {
        median((0..current.len()).filter(|i| current[*i] > flowing).map(|i| over_wire(i, current[i])))
    };
    let by_supply = each(&|i, a| samples.supply[i] / a - series);
    let by_wire = samples.v3.as_ref().map(|v3| each(&|i, a| v3[i] / a));
    let found = by_wire.filter(|r| r.is_finite()).unwrap_or(by_supply);
    let expected = median(samples.resistance.iter().copied());
    if !(found.is_finite() && expected > 0.0) || drive.kind != DriveKind::Pwm && by_wire.is_none() {
        return Ok(());
    }
    let column = Some(Column::CurrentA);
    let off = found / expected;
    if let Some(scale) = milli(off) {
        // V_3 was held against the supply before: it is the current
        let (found, expected) = (median(current.iter().copied()), median(samples.expected_current.iter().copied()));
        return Err(gate.broken(column, Trouble::WrongUnit { found, expected, scale: 1.0 / scale }));
    }
    let larger = off > RESISTANCE_FACTOR && found - expected > RESISTANCE_OHM;
    if larger || off < 1.0 / RESISTANCE_FACTOR {
        let keys = "diameter_mm, length_mm, the resistivities and [channel.drive]";
        let of = "the wire's resistance, Ω,";
        return Err(gate.broken(column, Trouble::OtherRig { of, found, expected, keys }));
    }
    let Some(v3) = samples.v3.as_ref().filter(|_| drive.kind == DriveKind::Pwm) else { return Ok(()) };
    let extra = each(&|i, a| (samples.supply[i] - v3[i]) / a - series);
    let limit = EXTRA_OHM + EXTRA_SHARE * expected;
    if extra > limit || extra < -0.5 * (limit - EXTRA_OHM) - 0.5 {
        let of = "the resistance between supply and wire, Ω,";
        let keys = "supply_v, shunt_ohm, switch_ohm and lead_ohm";
        let (found, expected) = (extra + series, series);
        return Err(gate.broken(Some(Column::V3V), Trouble::OtherRig { of, found, expected, keys }));
    }
    Ok(())
}

/// In the on-phase the current does not depend on the duty.
fn on_phase(gate: &Gate, samples: &Samples) -> Result<(), Error> {
    let (Some(current), DriveKind::Pwm) = (&samples.current, gate.model.drive.kind) else { return Ok(()) };
    let least = quantile(samples.duty.iter().copied(), 0.05);
    let most = quantile(samples.duty.iter().copied(), 0.95);
    if most.is_nan() || most < 3.0 * least {
        return Ok(());
    }
    let x: Vec<f64> = samples.duty.iter().map(|d| d.ln()).collect();
    let share = current.iter().zip(&samples.expected_current);
    let y: Vec<f64> =
        share.map(|(found, expected)| if *found > 0.0 { (found / expected).ln() } else { f64::NAN }).collect();
    let Line { slope, explained } = line(&x, &y);
    match (0.8..=1.2).contains(&slope) && explained > 0.9 {
        true => Err(gate.broken(Some(Column::CurrentA), Trouble::AveragedCurrent)),
        false => Ok(()),
    }
}

/// V_1 ≤ V_2 ≤ V_3, and in proportion to where the taps are.
fn taps(gate: &Gate, samples: &Samples, warnings: &mut Vec<Warning>) -> Result<(), Error> {
    let Some(taps) = gate.model.taps else { return Ok(()) };
    let on: Vec<bool> = match gate.model.drive.kind {
        DriveKind::Pwm => gate.measured(Column::Duty).unwrap_or_default().iter().map(|d| *d > 0.0).collect(),
        _ => vec![true; gate.simulated.rows.len()],
    };
    let volts = |column: Column| -> Option<Vec<f64>> {
        let values = gate.sensor(column)?;
        Some(values.into_iter().zip(&on).filter(|(_, on)| **on).map(|(v, _)| v).collect())
    };
    let whole = samples.v3.as_ref().map(|v3| median(v3.iter().copied())).filter(|v| *v > 0.0);
    let length = gate.model.geometry.length_m;
    let mut lost = Vec::new();
    for (column, at) in [(Column::V1V, taps.l0_m), (Column::V2V, taps.second_m())] {
        let share = whole.and_then(|whole| volts(column).map(|v| median(v) / whole)).filter(|r| r.is_finite());
        let (Some(found), expected) = (share, at / length) else { continue };
        if found.abs() < TAP_ORDER && expected > 5.0 * TAP_ORDER {
            let text = "shows next to no voltage: the tap touches nothing; it is left out".into();
            warnings.push(gate.warning(Some(column), Exclude::Column, text));
            lost.push(column);
        }
    }
    let pairs = [(Column::V1V, Column::V2V), (Column::V2V, Column::V3V), (Column::V1V, Column::V3V)];
    for (low, high) in pairs.into_iter().filter(|(low, high)| !lost.contains(low) && !lost.contains(high)) {
        let (Some(lower), Some(upper)) = (volts(low), volts(high)) else { continue };
        let above = median(lower.iter().zip(&upper).map(|(l, u)| l - u));
        let scatter = gate.noise[&low].total.max(gate.noise[&high].total);
        let largest = median(upper.iter().chain(&lower).map(|v| v.abs()));
        if above > TAP_ORDER * whole.unwrap_or(largest) && above > 5.0 * scatter {
            return Err(gate.broken(Some(low), Trouble::Exchanged { with: high }));
        }
    }
    for (column, at) in [(Column::V1V, taps.l0_m), (Column::V2V, taps.second_m())] {
        let share = whole.and_then(|whole| volts(column).map(|v| median(v) / whole)).filter(|r| r.is_finite());
        let (Some(found), expected) = (share, at / length) else { continue };
        let far = found > TAP_FACTOR * expected + TAP_ORDER || found < expected / TAP_FACTOR - TAP_ORDER;
        if far && !lost.contains(&column) {
            let of = "the tap's share of the wire's voltage";
            let keys = "[channel.taps] l0_mm and ls_mm and length_mm";
            return Err(gate.broken(Some(column), Trouble::OtherRig { of, found, expected, keys }));
        }
    }
    let v1_moves = volts(Column::V1V).is_some_and(|v| stroke(&v) > 20.0 * gate.noise[&Column::V1V].total);
    if v1_moves && taps.l0_m == 0.0 {
        let text = "moves although the rig file puts the first tap at the fixed end, where there is no voltage: check \
                    l0_mm and the ground of the measurement"
            .into();
        warnings.push(gate.warning(Some(Column::V1V), Exclude::Nothing, text));
    }
    Ok(())
}
