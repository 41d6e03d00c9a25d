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
        let path = self.folder.join(format!("{}-{}.mcap", self.rig, sinew_recording::Utc::now().stamp()));
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
