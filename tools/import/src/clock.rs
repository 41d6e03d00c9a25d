//! The time of the rows.

use crate::reading::{Reading, figure};
use crate::statistics::quantiles;
use crate::table::{Column, ROW_NUMBER, Table};
use crate::units::Unit;

/// Whether the numbers go up, row by row; with `standing`, they may stand still.
pub(crate) fn increases(values: &[f64], standing: bool) -> bool {
    values.len() > 1
        && values.windows(2).all(|pair| if standing { pair[1] >= pair[0] } else { pair[1] > pair[0] })
        && values[values.len() - 1] > values[0]
}

/// How a column is taken as the time, in s.
pub(crate) fn of_column(column: &Column, unit: Option<Unit>) -> Reading {
    let mut reading = Reading::new(None);
    let values = &column.values;
    if column.clock {
        reading.unit = "clock".into();
        reading.because("times of day, counted in seconds from the first row");
        return reading;
    }
    let first = values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let [step] = quantiles(&steps, [0.5]);
    if let Some(unit) = unit {
        (reading.scale, reading.unit) = (unit.factor, unit.symbol.to_string());
    } else {
        // by what clocks count from, and by the size of the steps
        let epochs = [
            (1.0, "s", "seconds"),
            (1e-3, "ms", "milliseconds"),
            (1e-6, "µs", "microseconds"),
            (1e-9, "ns", "nanoseconds"),
        ];
        let since_1970 = epochs.into_iter().find(|(scale, ..)| (9e8..2.2e9).contains(&(first * scale)));
        let whole = values.iter().all(|v| v.fract() == 0.0);
        let (scale, symbol, why, doubted) = match since_1970 {
            Some((scale, symbol, word)) => {
                (scale, symbol, format!("{first:.0} is a moment in {word} since 1970"), false)
            }
            None if (3e4..8e5).contains(&first) && step < 0.01 => {
                (86_400.0, "days", format!("{first} with steps of {} is a day of a calendar", figure(step)), true)
            }
            None if whole && step >= 1000.0 => {
                (1e-6, "µs", format!("whole numbers in steps of {}", figure(step)), true)
            }
            None if whole && step >= 2.0 => (1e-3, "ms", format!("whole numbers in steps of {}", figure(step)), true),
            None => (1.0, "s", format!("steps of {}", figure(step)), true),
        };
        (reading.scale, reading.unit) = (scale, symbol.into());
        reading.because(why);
        if doubted {
            reading.doubt(format!("has no unit: taken for {symbol}"));
        }
    }
    let lasts_s = (values.last().copied().unwrap_or(0.0) - first) * reading.scale;
    if lasts_s > 1e6 {
        reading.doubt(format!("the recording would last {} s: is its unit {}?", figure(lasts_s), reading.unit));
    }
    reading
}

/// Rates that rows can have, Hz: one in eleven days to one a nanosecond.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1e-6..=1e9;

/// The time made of the row's number, by a rate.
pub(crate) fn of_rows(table: &Table, rate_hz: Option<f64>) -> Option<Reading> {
    let mut reading = Reading::new(None);
    let (rate_hz, why) = match (rate_hz, &table.rate_hz) {
        (Some(rate_hz), _) => (rate_hz, format!("--rate {rate_hz}")),
        (None, Some((rate_hz, said))) => (*rate_hz, format!("the file says: {said}")),
        (None, None) => return None,
    };
    if !RATES_HZ.contains(&rate_hz) {
        return None;
    }
    reading.scale = 1.0 / rate_hz;
    reading.unit = "rows".into();
    reading.because(format!("{why}, so a row each {} s", figure(1.0 / rate_hz)));
    Some(reading)
}

/// A clock that stands still for several rows: the rate of the rows, where it is a steady one.
pub(crate) fn between_ticks(column: &Column) -> Option<Reading> {
    let (first, last) = (*column.values.first()?, *column.values.last()?);
    let rows = column.values.len() as f64 - 1.0;
    if !increases(&column.values, true) || rows < 3.0 {
        return None;
    }
    let rate_hz = Some(rows / (last - first)).filter(|rate_hz| RATES_HZ.contains(rate_hz))?;
    let mut reading = Reading::new(None);
    // a rate is a round one where that is as good
    let round = (rate_hz * 10.0).round() / 10.0;
    let rate_hz = if (round / rate_hz - 1.0).abs() < 0.05 && round >= 1.0 { round.round() } else { rate_hz };
    reading.scale = 1.0 / rate_hz;
    reading.unit = "rows".into();
    reading.because(format!(
        "\"{}\" stands still for several rows: about {} rows a second",
        column.name,
        figure(rate_hz)
    ));
    reading.doubt(format!(
        "the times within its ticks are not known: the row's number {ROW_NUMBER} is taken; give the rate with --rate"
    ));
    Some(reading)
}
