//! Energy: whether what went in can have heated this wire, and whether anything could be measured at all.

use sinew_physics::DriveKind;
use sinew_physics::formulas::relaxed;
use sinew_recording::{Column, drive_column};

use super::gate::{Gate, LEAST_CONVECTION};
use super::statistics::{span, stroke};
use crate::error::{Error, Trouble};

/// Loss and heat capacity may be off by these factors, either way, before the energy cannot be right.
const LOSS_FACTOR: f64 = 3.0;
const CAPACITY_FACTOR: f64 = 1.5;
/// A wire that would be hotter than this all the same has been destroyed, °C.
const DESTROYED_C: f64 = 600.0;
/// A wire that stays below this share of the way to its transformation cannot have moved …
const TOO_COLD: f64 = 0.4;
/// … by this share of its whole stroke.
const HAS_MOVED: f64 = 0.4;
/// What is warmed by less has not been heated, K.
const WARMED_K: f64 = 3.0;
/// A sensor moves if it goes beyond so many times its noise.
const MOVES: f64 = 8.0;
/// A sensor should move if the model moves it so far beyond its noise.
const SHOULD_MOVE: f64 = 50.0;

/// Energy first, then whether anything happened.
pub(super) fn check(gate: &Gate) -> Result<(), Error> {
    energy(gate)?;
    excitation(gate)
}

/// The electrical energy against the most the wire can lose or store.
fn energy(gate: &Gate) -> Result<(), Error> {
    let drive = gate.model.drive.kind;
    if drive == DriveKind::Temperature {
        return Ok(());
    }
    let column = Some(drive_column(drive));
    let (coolest_c, hottest_c) = peaks(gate);
    if coolest_c > DESTROYED_C {
        let of = "the wire's temperature, °C, even with three times the rig file's loss,";
        let remedy = "check the unit of the drive (duty 0..1, W, A), supply_v, diameter_mm and length_mm";
        return Err(gate.broken(column, Trouble::Impossible { found: coolest_c, limit: DESTROYED_C, of, remedy }));
    }
    let m = &gate.model.material;
    // where the heating curve begins to fall, at no stress: stress only moves it up
    let begins_c = m.austenite_temperature_c - 4.6 / m.heating_steepness_per_k;
    let ambient_c = gate.model.ambient_c;
    let enough_c = ambient_c + TOO_COLD * (begins_c - ambient_c);
    let whole = m.transformation_strain * gate.model.geometry.length_m;
    let moved = gate.pair(Column::PositionM).map_or(0.0, |(measured, _)| stroke(&measured));
    if hottest_c < enough_c && begins_c - ambient_c > 20.0 && moved > HAS_MOVED * whole && whole > 0.0 {
        return Err(gate.broken(
            column,
            Trouble::OtherRig {
                of: "the hottest the wire can have been by the energy it was given, °C, although it transformed,",
                found: hottest_c,
                expected: begins_c,
                keys: "the drive's unit, supply_v, diameter_mm and length_mm",
            },
        ));
    }
    Ok(())
}

/// The highest temperature the wire reached, °C: if it loses much, and if it loses little.
fn peaks(gate: &Gate) -> (f64, f64) {
    let (m, geometry) = (&gate.model.material, &gate.model.geometry);
    let (capacity, latent) = (gate.model.heat_capacity_j_per_k(), gate.model.latent_heat_j());
    let loss = geometry.loss_w_per_k(m.convection_w_per_m2_k.max(LEAST_CONVECTION));
    let ambient_c = gate.model.ambient_c;
    let power = powers(gate);
    let times = gate.recording.time_s();
    let rows = &gate.simulated.rows;
    // latent heat holds the wire back once, on its way up
    let mut cool = (ambient_c - latent / capacity, ambient_c);
    let mut hot = (ambient_c, ambient_c);
    let more_loss = LOSS_FACTOR * loss.max(geometry.loss_w_per_k(100.0));
    for (i, row) in rows.iter().enumerate() {
        let until = rows.get(i + 1).map_or(times[*row], |next| times[*next]);
        let interval = until - times[*row];
        cool.0 = relaxed(cool.0, ambient_c + power[i] / more_loss, interval * more_loss / (CAPACITY_FACTOR * capacity));
        let less_loss = loss / LOSS_FACTOR;
        hot.0 = relaxed(hot.0, ambient_c + power[i] / less_loss, interval * less_loss * CAPACITY_FACTOR / capacity);
        cool.1 = cool.1.max(cool.0);
        hot.1 = hot.1.max(hot.0);
    }
    (cool.1, hot.1)
}

/// Heating power at the compared rows, W: as measured where it was, else as the rig file has it.
fn powers(gate: &Gate) -> Vec<f64> {
    let by_model = &gate.simulated.columns[&Column::PowerW];
    let duty = gate.measured(Column::Duty).filter(|_| gate.model.drive.kind == DriveKind::Pwm);
    let (current, v3) = (gate.measured(Column::CurrentA), gate.measured(Column::V3V));
    match (duty, current, v3) {
        (Some(duty), Some(current), Some(v3)) => (0..by_model.len())
            .map(|i| duty[i] * current[i] * v3[i])
            .zip(by_model)
            .map(|(measured, model)| if measured.is_finite() { measured.max(0.0) } else { *model })
            .collect(),
        _ => by_model.clone(),
    }
}

/// Whether anything happened that says something of the wire.
fn excitation(gate: &Gate) -> Result<(), Error> {
    let moves = |column: &Column| gate.recording.get(*column).map_or(0.0, stroke) > MOVES * gate.noise[column].total;
    if gate.sensors.iter().any(moves) {
        return Ok(());
    }
    let warmed_k = gate.warmed_k();
    let pulled = gate.simulated.columns.iter().any(|(column, values)| {
        let noise = gate.noise.get(column).map_or(f64::INFINITY, |n| n.total);
        span(values) > SHOULD_MOVE * noise
    });
    let drive = drive_column(gate.model.drive.kind);
    let driven = gate.recording.get(drive).is_some_and(|d| span(d) > 0.0);
    if warmed_k > WARMED_K && pulled && driven {
        return Err(gate.broken(None, Trouble::NothingAnswers { warmed_k }));
    }
    if warmed_k <= WARMED_K || !driven {
        return Err(gate.broken(None, Trouble::Unexcited { drive, warmed_k }));
    }
    Ok(())
}
