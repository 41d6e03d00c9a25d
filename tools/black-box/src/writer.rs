//! The writing thread: one file after the other, each complete or not at all.

use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sinew_ipc::Clocks;
use sinew_ipc::Fault;
use sinew_recorder::FaultEvents;
use sinew_recording::session::{About, Ended, Event, Layout, SessionWriter, WriteOptions};
use sinew_recording::{Part, Utc, What};
use sinew_rig::Rig;

use crate::error::Error;
use crate::place::Place;
use crate::tap::Job;
use crate::written::Written;

/// How often it looks whether it is to go on.
const LOOK: Duration = Duration::from_millis(100);

pub(crate) struct Writer {
    about: About,
    layout: Layout,
    place: Place,
    before_s: f64,
    written: Arc<Mutex<Written>>,
    /// Whether the last file could not be written: then that is known.
    failing: bool,
}

impl Writer {
    pub(crate) fn new(
        rig: &Rig,
        layout: Layout,
        place: Place,
        simulated: bool,
        written: Arc<Mutex<Written>>,
    ) -> Writer {
        let about = About {
            rig: rig.name.clone(),
            rate_hz: rig.rate_hz,
            software: concat!("sinew ", env!("CARGO_PKG_VERSION")).into(),
            kind: "driver".into(),
            simulated,
            started_unix_ns: 0,
            started_monotonic_ns: 0,
            rig_toml: Some(rig.to_toml()),
            extra: [("driver_pid".to_string(), std::process::id().to_string())].into(),
        };
        Writer { about, layout, place, before_s: rig.black_box.before_s, written, failing: false }
    }

    /// Writes what is due until there will be no more.
    pub(crate) fn run(mut self, work: &Receiver<Job>) {
        while !sinew_threads::is_struck() {
            let job = match work.recv_timeout(LOOK) {
                Ok(job) => job,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            let cause = self.cause(&job);
            match self.write(&job) {
                Ok(path) => {
                    self.failing = false;
                    tracing::warn!("black box of {cause}: {}", path.display());
                    self.written.lock().unwrap_or_else(PoisonError::into_inner).files.push(path);
                }
                Err(error) => {
                    if !std::mem::replace(&mut self.failing, true) {
                        tracing::warn!("no black box of {cause}: {error}; {}", error.remedy());
                    }
                    let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
                    written.failed += 1;
                    written.failure = Some(error.to_string());
                }
            }
        }
    }

    /// The first cause, in words.
    fn cause(&self, job: &Job) -> String {
        let channel = self.layout.channels.get(job.due.channel).map_or("?", String::as_str);
        match Fault::from_code(job.due.fault) {
            Some(fault) => format!("{channel}: {fault}"),
            None => format!("{channel}: fault {}", job.due.fault),
        }
    }

    fn write(&self, job: &Job) -> Result<PathBuf, Error> {
        let due = &job.due;
        let cycles = || job.blocks.iter().flat_map(|kept| kept.block.iter());
        let within = |ns: u64| ns >= due.from_ns && ns <= due.until_ns;
        let first_ns = cycles().map(|(head, _)| head.monotonic_ns).find(|ns| within(*ns)).unwrap_or(due.at_ns);
        let before_s = due.at_ns.saturating_sub(first_ns) as f64 * 1e-9;

        let flag = Fault::from_code(due.fault).map_or("fault", Fault::flag);
        let channel = self.layout.channels.get(due.channel).map_or("", String::as_str);
        self.place.prepare()?;
        let clocks = Clocks::now();
        let unix_ns = |monotonic_ns| clocks.system(monotonic_ns).ns.max(0) as u64;
        let path = self.place.path(Utc::of_unix_ns(unix_ns(due.at_ns)), channel, flag);
        let failed = |reason: std::io::Error| {
            let (file, what) = (path.display().to_string(), What::Unwritable { reason: reason.to_string() });
            Error::File(sinew_recording::Error { file, line: None, column: None, what })
        };
        let mut about = self.about.clone();
        (about.started_monotonic_ns, about.started_unix_ns) = (first_ns, unix_ns(first_ns));
        let extra = [
            ("black_box", self.cause(job)),
            ("fault_cycle", due.cycle.to_string()),
            ("fault_s", format!("{before_s:?}")),
            ("faults", due.faults.to_string()),
        ];
        about.extra.extend(extra.map(|(key, value)| (key.to_string(), value)));

        let (part, file) = Part::create(&path).map_err(failed)?;
        let options = WriteOptions::new(path.to_string_lossy());
        let mut session = SessionWriter::create(BufWriter::new(file), &about, &self.layout, options)?;
        session.clocks(clocks.reading())?;
        let mut faults = FaultEvents::new(self.layout.channels.len());
        let mut said = false;
        for (head, bytes) in cycles().filter(|(head, _)| within(head.monotonic_ns)) {
            for event in faults.of(head, bytes, &self.layout.channels) {
                session.event(&event)?;
            }
            if !said && head.cycle >= due.cycle {
                said = true;
                session.event(&Event::note(head.cycle, head.monotonic_ns, self.note(job, before_s)))?;
            }
            session.cycle(head, bytes)?;
        }
        let ended = if job.cut_short { Ended::DriverStopped } else { Ended::Complete };
        let file = session.finish(ended)?.into_inner().map_err(|error| failed(error.into_error()))?;
        part.publish(&file).map_err(failed)?;
        // a folder that cannot be tidied has its file all the same
        let _ = self.place.tidy(&path);
        Ok(path)
    }

    /// What the file is of, for people.
    fn note(&self, job: &Job, before_s: f64) -> String {
        let mut note = format!("black box: first cause {}", self.cause(job));
        if before_s < 0.99 * self.before_s {
            note += &format!("; {before_s:.2} s before it were at hand, not {} s", self.before_s);
        }
        note
    }
}
