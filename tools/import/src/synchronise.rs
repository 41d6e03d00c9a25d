//! A recording by a device's own clock, put on the driver's time by pairs of times of the same moments.

use std::path::Path;

use sinew_clocks::{ClockMap, ClockRules, Update};
use sinew_recording::Recording;
use sinew_rig::FileFormat;

use crate::error::Error;
use crate::read::read;
use crate::table::Table;

/// What a pair is off by where it does not say, s: read off by hand.
const BY_HAND_S: f64 = 1e-3;
/// The rates of a device's clock and the driver's are apart by no more than this: rows that are merely counted may be off by so much.
const MAX_RATE_PPM: f64 = 10_000.0;
/// Where the driver's time begins for the map, which knows no negative times, ns.
const BEGIN_NS: i64 = 1 << 60;
/// Times that fit beside that, s.
const MOST_S: f64 = 1e9;
const HINT: &str = "a file of pairs has the columns driver_s, other_s and, where it is known, error_s (what a pair is off by): \
                    the same moments on both clocks, one a line";

/// A recording on the driver's time.
#[derive(Debug)]
pub struct Synchronised {
    /// The same samples at the driver's times.
    pub recording: Recording,
    /// What its times are off by at the most, s.
    pub error_s: f64,
    /// What the device's clock ran fast by, and what that is off by, ppm.
    pub rate_ppm: (f64, f64),
    /// Rows before the first pair or behind the last.
    pub outside: usize,
}

/// Puts a recording on the driver's time: `pairs` is a file with the columns `driver_s`, `other_s` and, at will, `error_s`, both clocks'
/// times of the same moments, in the order of time. Between the pairs and beyond them times are as sure as the pairs leave them.
///
/// # Errors
/// A file that cannot be read, lacks a column or has none but one pair, and pairs that contradict each other, by their lines.
pub fn synchronised(recording: &Recording, pairs: &Path) -> Result<Synchronised, Error> {
    let name = pairs.display().to_string();
    let table = read(pairs, &FileFormat::default())?;
    let (map, first, last) = learnt(&table).map_err(|error| error.of(&name))?;
    let outside = recording.time_s().iter().filter(|&&time_s| time_s < first || time_s > last).count();
    let (mut times, mut worst) = (Vec::with_capacity(recording.len()), 0.0f64);
    for &time_s in recording.time_s() {
        let at = (time_s.abs() <= MOST_S).then(|| map.driver_at(nanoseconds(time_s))).flatten().ok_or_else(|| {
            Error::new(format!("says nothing of {time_s} s, a time of the recording"), HINT).of(&name)
        })?;
        let found_s = (at.ns as i64 - BEGIN_NS) as f64 * 1e-9;
        // What is between two pairs may go either way within its error, but never back.
        let later_s = times.last().map_or(found_s, |&before: &f64| found_s.max(before + 1e-9));
        worst = worst.max(at.error_ns as f64 * 1e-9 + (later_s - found_s));
        times.push(later_s);
    }
    let failed = |error: sinew_recording::Error| Error::new(error.what.to_string(), error.hint()).of(recording.name());
    let mut moved = Recording::new(recording.name(), times).map_err(failed)?;
    for (column, values) in recording.columns() {
        moved.set(column, values.to_vec()).map_err(failed)?;
    }
    let rate_ppm = map.rate_ppm().unwrap_or((f64::NAN, f64::NAN));
    Ok(Synchronised { recording: moved, error_s: worst, rate_ppm, outside })
}

fn nanoseconds(time_s: f64) -> i64 {
    (time_s * 1e9).round() as i64
}

/// The device's clock, with the first and the last of its times, s.
fn learnt(table: &Table) -> Result<(ClockMap, f64, f64), Error> {
    let column = |name: &str| {
        let there = table.columns.iter().find(|column| column.name.trim().eq_ignore_ascii_case(name));
        there.map(|column| column.values.as_slice())
    };
    let needed = |name: &str| column(name).ok_or_else(|| Error::new(format!("has no column {name}"), HINT));
    let (driver_s, other_s, error_s) = (needed("driver_s")?, needed("other_s")?, column("error_s"));
    let mut map = ClockMap::new(ClockRules {
        max_rate_ppm: MAX_RATE_PPM,
        window_s: 1e9,
        pairs: driver_s.len(),
        ..ClockRules::default()
    });
    let mut ends: Option<(f64, f64)> = None;
    for (row, (&driver_s, &other_s)) in driver_s.iter().zip(other_s).enumerate() {
        let error_s = error_s.map_or(BY_HAND_S, |error_s| error_s[row]);
        let nth = format!("pair {}", row + 1);
        let within = |value: f64| value.abs() <= MOST_S;
        if !within(driver_s) || !within(other_s) || !(0.0..=MOST_S).contains(&error_s) {
            let found = format!("{nth} is {driver_s}, {other_s} ± {error_s} s: no times");
            return Err(Error::new(found, HINT));
        }
        if ends.is_some_and(|(_, last)| other_s <= last) {
            let hint =
                "put the pairs in the order of their times; of a device that was reset bring in each part on its own";
            return Err(Error::new(format!("{nth} is not after the one before it"), hint));
        }
        let at = (BEGIN_NS + nanoseconds(driver_s)) as u64;
        if let Update::Anew(why) = map.pair(at, nanoseconds(other_s), nanoseconds(error_s) as u64) {
            let hint = "correct it, or give what the pairs are off by in a column error_s; of a device that was reset or set bring in each part on its own";
            return Err(Error::new(format!("{nth} contradicts those before it: {why}"), hint));
        }
        ends = Some((ends.map_or(other_s, |(first, _)| first), other_s));
    }
    match ends {
        Some((first, last)) if first < last => Ok((map, first, last)),
        _ => Err(Error::new("has fewer than two pairs", HINT)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_recording::Column;

    fn pairs(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::Builder::new().suffix(".csv").tempfile().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    /// A device that runs 300 ppm fast and was started 12.5 s before the driver.
    fn daq(driver_s: f64) -> f64 {
        12.5 + driver_s * (1.0 + 300e-6)
    }

    fn recorded() -> (Recording, Vec<f64>) {
        let truth: Vec<f64> = (0..2000).map(|row| -2.0 + 0.01 * row as f64).collect();
        let mut recording = Recording::new("daq.csv", truth.iter().map(|&at| daq(at)).collect()).unwrap();
        recording.set(Column::ForceN, truth.clone()).unwrap();
        (recording, truth)
    }

    #[test]
    fn rows_come_to_the_drivers_time_within_what_is_said() {
        let (recording, truth) = recorded();
        // 2 ms off, as it is to be found out
        let off = [0.0015, -0.0018, 0.001, 0.0, -0.0019];
        let rows = [0.0, 4.0, 8.0, 12.0, 16.0].iter().zip(off);
        let text: String = rows.map(|(&at, off)| format!("{:.6},{:.6},0.002\n", at + off, daq(at))).collect();
        let done = synchronised(&recording, pairs(&format!("driver_s,other_s,error_s\n{text}")).path()).unwrap();
        for (found, truth) in done.recording.time_s().iter().zip(&truth) {
            assert!((found - truth).abs() <= done.error_s, "{found} {truth} ± {}", done.error_s);
        }
        assert!(done.error_s < 0.01, "{}", done.error_s);
        assert!((done.rate_ppm.0 - 300.0).abs() <= done.rate_ppm.1, "{:?}", done.rate_ppm);
        assert_eq!(done.outside, 200 + 199);
        assert_eq!(done.recording.get(Column::ForceN).unwrap(), &truth[..]);
    }

    #[test]
    fn what_cannot_be_used_is_said_with_its_place() {
        let (recording, _) = recorded();
        for (text, said) in [
            ("driver_s,other\n1,2\n2,3\n", "has no column other_s"),
            ("driver_s,other_s\n1,13.5\n1.5,13.4\n", "pair 2 is not after"),
            ("driver_s,other_s\n1,13.5\n2,14.5\n3,17\n", "pair 3 contradicts"),
            ("driver_s,other_s\n1,13.5\n", ""),
        ] {
            let file = pairs(text);
            let error = synchronised(&recording, file.path()).unwrap_err();
            assert!(error.to_string().contains(said) && !error.hint.is_empty(), "{error}");
            assert!(error.file.contains(file.path().file_name().unwrap().to_str().unwrap()), "{error}");
        }
    }
}
