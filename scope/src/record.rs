//! The record button: one recording at a time, in a file named after the rig and the time of day.

use std::path::PathBuf;

use serde::Serialize;
use sinew_recorder::{Options as RecorderOptions, Recorder, Report};

use crate::Options;

/// The recordings of this scope.
pub struct Button {
    folder: PathBuf,
    rig: String,
    running: Option<Recorder>,
}

/// How a recording does, for the page.
#[derive(Serialize)]
pub struct State {
    file: String,
    seconds: f64,
    bytes: u64,
    lost: u64,
}

impl Button {
    /// None runs yet.
    pub fn new(options: &Options) -> Button {
        Button { folder: options.record_dir.clone(), rig: options.rig.clone(), running: None }
    }

    /// Starts one, by a connection of its own: the recorder is a client like any other.
    pub fn start(&mut self) -> Result<String, String> {
        self.forget_ended();
        if let Some(running) = &self.running {
            return Err(format!("{} is being recorded already", running.live().file.display()));
        }
        let client = sinew_ipc::Client::connect(&self.rig).map_err(|error| error.message())?;
        let path = self.folder.join(format!("{}-{}.mcap", self.rig, time_of_day()));
        let recorder = Recorder::start(client, RecorderOptions::new(&path)).map_err(|error| {
            let remedy = error.remedy();
            if remedy.is_empty() { error.to_string() } else { format!("{error}; {remedy}") }
        })?;
        self.running = Some(recorder);
        Ok(format!("recording {}", path.display()))
    }

    /// Ends the one that runs, and says what came of it.
    pub fn stop(&mut self) -> Result<String, String> {
        let recorder = self.running.take().ok_or("nothing is being recorded")?;
        recorder.stop();
        said(&recorder.join())
    }

    /// How it does; none where none runs.
    pub fn state(&mut self) -> Option<State> {
        self.forget_ended();
        let live = self.running.as_ref()?.live();
        let file = live.file.display().to_string();
        Some(State { file, seconds: live.seconds, bytes: live.bytes, lost: live.lost })
    }

    /// One that ended by itself, as when the driver left, is complete: its file was closed.
    fn forget_ended(&mut self) {
        if self.running.as_ref().is_some_and(|recorder| !recorder.is_running()) {
            self.running = None;
        }
    }
}

fn said(report: &Report) -> Result<String, String> {
    let files: Vec<String> = report.files.iter().map(|file| file.display().to_string()).collect();
    let what = format!("{} cycles in {}", report.cycles, files.join(", "));
    match &report.failure {
        Some(failure) => Err(format!("{what}; {failure}")),
        None if report.lost > 0 => Err(format!("{what}; {} cycles were lost", report.lost)),
        None => Ok(what),
    }
}

/// The time of day (UTC) for a file's name: 20260801-153012.
fn time_of_day() -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    let (days, seconds) = (since.as_secs() / 86_400, since.as_secs() % 86_400);
    let (year, month, day) = date(days as i64);
    format!("{year:04}{month:02}{day:02}-{:02}{:02}{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// Year, month and day of a day counted from 1970 (the civil calendar by shifting the year's start to March, so that the
/// leap day is its last).
fn date(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let era = days.div_euclid(146_097);
    let of_era = days.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn days_become_dates() {
        for (days, expected) in [
            (0, (1970, 1, 1)),
            (11_016, (2000, 2, 29)),
            (19_722, (2023, 12, 31)),
            (20_635, (2026, 7, 1)),
            (-1, (1969, 12, 31)),
        ] {
            assert_eq!(date(days), expected, "{days}");
        }
    }
}
