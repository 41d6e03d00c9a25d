//! The record button: one recording at a time, in a file named after what is shown and the time of day.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use sinew_recorder::{Options as RecorderOptions, Recorder, Report};

/// The recordings of this scope.
pub struct Button {
    folder: PathBuf,
    name: String,
    what: What,
    running: Option<Running>,
}

/// What is recorded.
enum What {
    /// Every cycle of a driver.
    Cycles,
    /// Every row of a stream, under these heads of columns.
    Rows(Vec<String>),
}

enum Running {
    Cycles(Box<Recorder>),
    Rows(Box<Rows>),
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
    /// Of the driver of this rig; none runs yet.
    pub fn of_driver(folder: &Path, rig: &str) -> Button {
        Button { folder: folder.to_path_buf(), name: rig.to_string(), what: What::Cycles, running: None }
    }

    /// Of a stream of this name; none runs yet.
    pub fn of_stream(folder: &Path, name: &str) -> Button {
        Button { folder: folder.to_path_buf(), name: name.to_string(), what: What::Rows(Vec::new()), running: None }
    }

    /// Starts one. A driver's has a connection of its own: the recorder is a client like any other.
    pub fn start(&mut self) -> Result<String, String> {
        self.forget_ended();
        if let Some(running) = &self.running {
            return Err(format!("{} is being recorded already", running.file().display()));
        }
        let stamp = sinew_recording::Utc::now().stamp();
        let running = match &self.what {
            What::Cycles => {
                let client = sinew_ipc::Client::connect(&self.name).map_err(|error| error.message())?;
                let path = self.folder.join(format!("{}-{stamp}.mcap", self.name));
                let recorder = Recorder::start(client, RecorderOptions::new(&path)).map_err(|error| {
                    let remedy = error.remedy();
                    if remedy.is_empty() { error.to_string() } else { format!("{error}; {remedy}") }
                })?;
                Running::Cycles(Box::new(recorder))
            }
            What::Rows(heads) if heads.is_empty() => return Err("no numbers have come yet".into()),
            What::Rows(heads) => {
                let path = self.folder.join(format!("{}-{stamp}.csv", self.name));
                Running::Rows(Box::new(Rows::create(path, heads)?))
            }
        };
        let path = running.file().display().to_string();
        self.running = Some(running);
        Ok(format!("recording {path}"))
    }

    /// Ends the one that runs, and says what came of it.
    pub fn stop(&mut self) -> Result<String, String> {
        match self.running.take().ok_or("nothing is being recorded")? {
            Running::Cycles(recorder) => {
                recorder.stop();
                said(&recorder.join())
            }
            Running::Rows(rows) => rows.finish(),
        }
    }

    /// How it does; none where none runs.
    pub fn state(&mut self) -> Option<State> {
        self.forget_ended();
        Some(match self.running.as_mut()? {
            Running::Cycles(recorder) => {
                let live = recorder.live();
                let file = live.file.display().to_string();
                State { file, seconds: live.seconds, bytes: live.bytes, lost: live.lost }
            }
            Running::Rows(rows) => State {
                file: rows.path.display().to_string(),
                seconds: rows.began.elapsed().as_secs_f64(),
                bytes: rows.bytes(),
                lost: 0,
            },
        })
    }

    /// The columns of a stream are these from here on: a recording that runs goes on in a file of its own.
    ///
    /// # Errors
    /// Why it does not.
    pub fn name_columns(&mut self, heads: Vec<String>) -> Result<(), String> {
        self.what = What::Rows(heads);
        if let Some(Running::Rows(_)) = self.running {
            self.stop()?;
            self.start()?;
        }
        Ok(())
    }

    /// A row of a stream, into the recording that runs. Time in s.
    ///
    /// # Errors
    /// Why it is not in the file, which ends there.
    pub fn row(&mut self, time_s: f64, row: &[f64]) -> Result<(), String> {
        let Some(Running::Rows(rows)) = self.running.as_mut() else { return Ok(()) };
        let Err(error) = rows.write(time_s, row) else { return Ok(()) };
        let why = format!("{} has ended: {error}", rows.path.display());
        self.running = None;
        Err(why)
    }

    /// One that ended by itself, as when the driver left, is complete: its file was closed.
    fn forget_ended(&mut self) {
        if let Some(Running::Cycles(recorder)) = &self.running
            && !recorder.is_running()
        {
            self.running = None;
        }
    }
}

impl Running {
    fn file(&self) -> PathBuf {
        match self {
            Running::Cycles(recorder) => recorder.live().file,
            Running::Rows(rows) => rows.path.clone(),
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

/// A CSV of rows: `time_s` from its first row on, then the columns. A number that did not come is an empty cell.
struct Rows {
    path: PathBuf,
    out: csv::Writer<Counted>,
    began: Instant,
    /// Time of its first row, s.
    origin_s: Option<f64>,
    rows: u64,
}

/// A file that knows how much went into it.
struct Counted {
    file: BufWriter<File>,
    bytes: u64,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Rows {
    /// A file that must not be there yet; a second one within a second has a number.
    fn create(path: PathBuf, heads: &[String]) -> Result<Rows, String> {
        let numbered = |n: u32| path.with_extension(format!("{n}.csv"));
        let mut chosen = path.clone();
        let mut tried = 1;
        let file = loop {
            match File::create_new(&chosen) {
                Ok(file) => break file,
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && tried < 100 => {
                    tried += 1;
                    chosen = numbered(tried);
                }
                Err(error) => return Err(format!("{}: {error}", chosen.display())),
            }
        };
        let mut out = csv::Writer::from_writer(Counted { file: BufWriter::new(file), bytes: 0 });
        let heads = std::iter::once("time_s").chain(heads.iter().map(String::as_str));
        out.write_record(heads).map_err(|error| format!("{}: {error}", chosen.display()))?;
        Ok(Rows { path: chosen, out, began: Instant::now(), origin_s: None, rows: 0 })
    }

    fn write(&mut self, time_s: f64, row: &[f64]) -> io::Result<()> {
        let since = time_s - *self.origin_s.get_or_insert(time_s);
        let cell = |value: &f64| if value.is_finite() { value.to_string() } else { String::new() };
        self.out.write_record(std::iter::once(format!("{since:.6}")).chain(row.iter().map(cell)))?;
        self.rows += 1;
        Ok(())
    }

    fn bytes(&mut self) -> u64 {
        self.out.get_ref().bytes
    }

    fn finish(mut self) -> Result<String, String> {
        let path = self.path.display().to_string();
        match self.out.flush() {
            Ok(()) => Ok(format!("{} rows in {path}", self.rows)),
            Err(error) => Err(format!("{path}: {error}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_a_stream_are_a_file_that_can_be_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut button = Button::of_stream(folder.path(), "board");
        assert_eq!(button.start(), Err("no numbers have come yet".into()));
        button.name_columns(vec!["force [N]".into(), "a, b".into()]).unwrap();
        button.row(1.0, &[9.0, 9.0]).unwrap();
        button.start().unwrap();
        button.row(5.0, &[1.5, f64::NAN]).unwrap();
        button.row(5.01, &[1.25, -2.0]).unwrap();
        // other columns, another file
        button.name_columns(vec!["force [N]".into()]).unwrap();
        button.row(5.02, &[1.0]).unwrap();
        assert!(button.state().is_some());
        button.stop().unwrap();
        let mut files: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort_by_key(|path| path.as_os_str().len());
        let texts: Vec<_> = files.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
        let whole = "time_s,force [N],\"a, b\"\n0.000000,1.5,\n0.010000,1.25,-2\n";
        let rest = "time_s,force [N]\n0.000000,1\n";
        assert_eq!(texts.len(), 2);
        assert!(texts.contains(&whole.to_string()) && texts.contains(&rest.to_string()), "{texts:?}");
    }
}
