//! Setpoints in a CSV file, row by row at their times: what `sinew play` plays and a rig's program may be.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::driving::setpoint::Setpoint;
use crate::failure::Failure;

/// First column of the file.
const TIME: &str = "time_s";

/// A file as it is to be played.
#[derive(Debug)]
pub struct Score {
    /// Names of its channels, in the order of its columns.
    pub channels: Vec<String>,
    /// At least one; their times increase.
    pub rows: Vec<Row>,
}

/// What is wanted from a time on.
#[derive(Debug, PartialEq)]
pub struct Row {
    /// Its line in the file.
    pub line: u64,
    /// From the start, s.
    pub time_s: f64,
    /// Of each channel what is wanted from then on; `None` as before.
    pub setpoints: Vec<Option<Setpoint>>,
}

impl Score {
    /// Reads a file: `time_s` and a column for each channel, with a setpoint in each cell, its unit with it, or nothing.
    pub fn read(path: &Path) -> Result<Score, Failure> {
        let place = path.display();
        let broken = |error: csv::Error| {
            let failure = Failure::input(format!("{place}: {error}"));
            if error.is_io_error() { failure.hint("check the path") } else { failure.hint(form()) }
        };
        let mut csv = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_path(path).map_err(broken)?;
        let header = csv.headers().map_err(broken)?.clone();
        let channels: Vec<String> = header.iter().skip(1).map(str::to_string).collect();
        if header.get(0) != Some(TIME) || channels.is_empty() {
            return Err(
                Failure::input(format!("{place}:1: no `{TIME}` and a channel for every further column")).hint(form())
            );
        }
        if let Some(twice) =
            channels.iter().enumerate().find_map(|(at, name)| channels[..at].contains(name).then_some(name))
        {
            return Err(
                Failure::input(format!("{place}:1: `{twice}` stands there twice")).hint("a column for each channel")
            );
        }
        let mut rows: Vec<Row> = Vec::new();
        for record in csv.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, |position| position.line());
            let row = row(&record, &channels)
                .map_err(|(message, hint)| Failure::input(format!("{place}:{line}: {message}")).hint(hint))?;
            if rows.last().is_some_and(|before| before.time_s >= row.time_s) {
                return Err(Failure::input(format!(
                    "{place}:{line}: {TIME} {} is not after the row before",
                    row.time_s
                ))
                .hint("rows stand in the order of their times"));
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(Failure::input(format!("{place}: has no rows")).hint(form()));
        }
        Ok(Score { channels, rows })
    }
}

fn row(record: &StringRecord, channels: &[String]) -> Result<Row, (String, String)> {
    let time = record.get(0).unwrap_or_default();
    let time_s = time.parse().ok().filter(|time_s: &f64| time_s.is_finite() && *time_s >= 0.0);
    let time_s =
        time_s.ok_or_else(|| (format!("`{time}` is no time"), "seconds from the start, 0 or more".to_string()))?;
    let setpoint = |(cell, name): (&str, &String)| match cell {
        "" => Ok(None),
        cell => Setpoint::parse_cell(cell).map(Some).map_err(|e| (format!("{name}: {}", e.message), e.hint)),
    };
    let setpoints = record.iter().skip(1).zip(channels).map(setpoint).collect::<Result<_, _>>()?;
    let line = record.position().map_or(0, |position| position.line());
    Ok(Row { line, time_s, setpoints })
}

fn form() -> String {
    format!("a first line such as `{TIME},left,right`, then rows such as `0.5,40%,` or `1.5,164mm,off`")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Score, Failure> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Score::read(file.path())
    }

    #[test]
    fn cells_are_setpoints_and_empty_ones_change_nothing() {
        let score = read_text("time_s, left, right\n# a comment\n0, 10%, off\n0.5, 164mm,\n2,,duty=0.1\n").unwrap();
        assert_eq!(score.channels, ["left", "right"]);
        let rows: Vec<_> = score.rows.iter().map(|row| (row.time_s, row.setpoints.clone())).collect();
        let expected = [
            (0.0, vec![Some(Setpoint::Stroke(0.1)), Some(Setpoint::Off)]),
            (0.5, vec![Some(Setpoint::Length(0.164)), None]),
            (2.0, vec![None, Some(Setpoint::Duty(0.1))]),
        ];
        assert_eq!(rows, expected);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_a_remedy() {
        for (text, message) in [
            ("", "no `time_s`"),
            ("time_s\n0\n", "no `time_s`"),
            ("left,right\n0,1\n", "no `time_s`"),
            ("time_s,left,left\n0,1,1\n", "`left` stands there twice"),
            ("time_s,left\n", "no rows"),
            ("time_s,left\n0,10%\n0,20%\n", ":3: time_s 0 is not after"),
            ("time_s,left\n0,10%\nlater,20%\n", ":3: `later` is no time"),
            ("time_s,left\n0,10%\n1,140%\n", ":3: left: `stroke=140%` is outside"),
            ("time_s,left\n0,10%\n1,20%,30%\n", "3"),
        ] {
            let said = read_text(text).map(|_| ()).expect_err(text).to_string();
            assert!(said.contains(message) && said.contains("hint: "), "{text:?}: {said}");
        }
    }
}
