//! A programme that was played: how well it was kept to. What it says of the wire is for `identify` and `diagnose`.

use super::finding::{Estimate, Finding};
use super::run::Run;
use crate::programme::{End, Programme};
use crate::run::Row;
use crate::stage::Part;
use crate::wave::Quantity;

/// A duty below this is hardly more than the sensing pulse.
const LEAST_DUTY: f64 = 0.05;

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    let Some(programme) = &run.options.programme else { return Vec::new() };
    let rows: Vec<&Row> =
        run.stretches().filter(|(stage, _)| stage.part == Part::Programme).flat_map(|(_, rows)| rows).collect();
    [heat(programme, &rows)].into_iter().chain(end(programme, &rows)).collect()
}

/// What the amplifier gave, beside what was asked.
fn heat(programme: &Programme, rows: &[&Row]) -> Finding {
    let (of, unit): (fn(&Row) -> f64, _) = match programme.quantity() {
        Quantity::Current => (|row| row.reading.current_a, "mA"),
        Quantity::Voltage => (|row| row.reading.voltage_v, "mV"),
        Quantity::Power => (|row| row.reading.power_w(), "mW"),
        Quantity::Duty => {
            let how =
                "power over the duty, and how far that power scatters over the run: the wire's resistance changes";
            let full: Vec<f64> = rows.iter().filter(|row| row.directive.heat > LEAST_DUTY).map(full_power_w).collect();
            let count = full.len().max(1) as f64;
            let mean = full.iter().sum::<f64>() / count;
            let scatter = (full.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / count).sqrt();
            let found = match full.is_empty() {
                true => Err("no row of it heats".to_string()),
                false => Ok(Estimate { value: mean, sigma: scatter }),
            };
            return Finding::from("full_power_w", "Power at duty 1", "W", "", &found, how);
        }
    };
    let error = rms_in_thousandths(rows.iter().map(|row| of(row) - row.directive.heat));
    let how = "RMS of what was measured less what was asked, sensor's noise included";
    Finding::new("heat_error", "Heat beside the programme's", unit, "", error, how)
}

/// Power at duty 1 by a row's own, W.
fn full_power_w(row: &&Row) -> f64 {
    row.reading.power_w() / row.directive.heat
}

/// Where the wire's end was, beside where it was to be; `None` where nothing said where.
fn end(programme: &Programme, rows: &[&Row]) -> Option<Finding> {
    let how = "RMS of what was measured less what was asked";
    Some(match programme.end_at(0.0) {
        End::Left => return None,
        End::At(_) => {
            let error = rms_in_thousandths(rows.iter().map(|row| row.reading.position_m - row.directive.target));
            Finding::new("elongation_error", "Elongation beside the programme's", "mm", "", error, how)
        }
        End::Pulled(_) => {
            let new = rows.iter().filter(|row| row.reading.force_is_new);
            let error = rms_in_thousandths(new.map(|row| row.reading.force_n - row.directive.target));
            Finding::new("force_error", "Force beside the programme's", "mN", "", error, how)
        }
    })
}

/// In thousandths of the errors' unit. Counted over all rows, not estimated from some: it is what it is.
fn rms_in_thousandths(errors: impl Iterator<Item = f64>) -> Estimate {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| (sum + error * error, count + 1.0));
    Estimate { value: 1e3 * (sum / count).sqrt(), sigma: f64::NAN }
}
