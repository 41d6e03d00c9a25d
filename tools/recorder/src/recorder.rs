//! A running recording: start, status, stop, and its report.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::JoinHandle;

use sinew_ipc::{ChannelState, Client, Clocks};
use sinew_recording::session::{About, Ended, Gap, Layout};
use sinew_recording::{Error as RecordingError, What};
use sinew_threads::Thread;

use crate::blocks::{Outlet, buffer};
use crate::drain::drain;
use crate::error::Error;
use crate::floor::free_bytes;
use crate::options::Options;
use crate::shared::{Removed, Shared, Written};
use crate::state::layout;
use crate::warning::Warning;
use crate::writer::Writer;

/// The buffer holds so much time, s, and at least so many bytes.
const BUFFER_S: f64 = 5.0;
const BUFFER_BYTES: u64 = 64 << 20;

/// A recording so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Live {
    /// Cycles written.
    pub cycles: u64,
    /// Cycles lost.
    pub lost: u64,
    /// From its first cycle to its last one, s.
    pub seconds: f64,
    /// Bytes of all files.
    pub bytes: u64,
    /// Bytes of all messages, before compression.
    pub payload: u64,
    /// Bytes that wait to be written.
    pub waiting: u64,
    /// The file being written.
    pub file: PathBuf,
    /// Its number, from 0.
    pub part: u32,
}

/// What came of a recording.
#[derive(Debug)]
pub struct Report {
    /// The files, in order, without those that were removed.
    pub files: Vec<PathBuf>,
    /// The older ones that were removed.
    pub removed: Removed,
    /// Why it ended.
    pub ended: Ended,
    /// Cycles written, those in removed files among them; so with all that follows.
    pub cycles: u64,
    /// Cycles lost between the first and the last one written.
    pub lost: u64,
    /// Which ones.
    pub gaps: Vec<Gap>,
    /// Periods the driver skipped meanwhile; they have no cycle.
    pub missed: u64,
    /// From the first cycle to the last one, s.
    pub seconds: f64,
    /// Bytes of all files.
    pub bytes: u64,
    /// Bytes of all messages, before compression.
    pub payload: u64,
    /// Cycles that came but are in no file because that could not be written.
    pub not_written: u64,
    /// What was warned of and nobody has asked for yet ([`Recorder::warnings`]).
    pub warnings: Vec<Warning>,
    /// What went wrong.
    pub failure: Option<Error>,
}

/// Starts recordings.
#[derive(Debug)]
pub struct Recorder {
    shared: Arc<Shared>,
    drain: Option<JoinHandle<Option<()>>>,
    writer: Option<JoinHandle<Option<Written>>>,
}

impl Recorder {
    /// Begins to record the driver behind this connection, from its next cycle on. Dropped without [`Recorder::join`] it stops and
    /// completes its file.
    ///
    /// # Errors
    /// [`Error::Exists`], [`Error::TooSmall`], [`Error::TooFewKept`], [`Error::TooLittleKept`], [`Error::OneFile`], [`Error::Floor`],
    /// [`Error::Driver`], [`Error::File`], [`Error::Thread`]; then nothing runs.
    pub fn start(client: Client, options: Options) -> Result<Recorder, Error> {
        options.check()?;
        let info = *client.info();
        let misnamed = |trouble| {
            Error::File(RecordingError {
                file: options.path.to_string_lossy().into_owned(),
                line: None,
                column: None,
                what: What::Session(trouble),
            })
        };
        let layout =
            layout(client.channels().iter().map(|channel| channel.name.to_string()).collect()).map_err(misnamed)?;
        let from_ns = client.with_latest(|state| state.monotonic_ns);
        let stream = client.stream()?;
        let clocks = client.clocks();
        let about = About {
            rig: info.rig.to_string(),
            rate_hz: info.rate_hz,
            software: concat!("sinew ", env!("CARGO_PKG_VERSION")).into(),
            kind: "driver".into(),
            simulated: info.simulated != 0,
            started_unix_ns: clocks.system(from_ns).ns.max(0) as u64,
            started_monotonic_ns: from_ns,
            rig_toml: client.rig_text()?,
            extra: [("protocol", info.protocol.to_string()), ("driver_pid", info.pid.to_string())]
                .map(|(key, value)| (key.to_string(), value))
                .into(),
        };
        let bytes_per_s = layout.bytes() as f64 * info.rate_hz;
        let limit = options.buffer_bytes.unwrap_or(BUFFER_BYTES.max((BUFFER_S * bytes_per_s) as u64));
        let shared = Arc::new(Shared::default());
        let (inlet, outlet) = buffer(limit, shared.held.clone());
        let (ready, opened) = std::sync::mpsc::channel();
        let length_ns = options.duration_s.map(|seconds| (seconds * 1e9) as u64);
        let writer = {
            let over = shared.clone();
            let shared = shared.clone();
            let start = Thread::Writer.start().ends_when(move || over.is_written.load(Ordering::Acquire));
            start
                .spawn(move || write(&options, about, layout, clocks, &shared, &outlet, &ready))
                .map_err(Error::Thread)?
        };
        // The first file is open, or it is known why not.
        match opened.recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => {
                let _ = writer.join();
                return Err(error);
            }
            Err(_) => return Err(Error::Thread(std::io::Error::other("the writer died while it started"))),
        }
        let drain = {
            let over = shared.clone();
            let shared = shared.clone();
            let start = Thread::Recorder.start().ends_when(move || over.drained.load(Ordering::Acquire));
            let body = move || drain(&client, stream, &inlet, &shared, from_ns, length_ns);
            start.spawn(body).map_err(Error::Thread)?
        };
        Ok(Recorder { shared, drain: Some(drain), writer: Some(writer) })
    }

    /// Asks it to end; [`Recorder::join`] waits for it.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it still records. It may have ended by itself: its time is over, the driver is gone, the disk is full or nearly so.
    pub fn is_running(&self) -> bool {
        !self.shared.ended.load(Ordering::Acquire)
    }

    /// How it does.
    pub fn live(&self) -> Live {
        let shared = &self.shared;
        let get = |number: &AtomicU64| number.load(Ordering::Relaxed);
        Live {
            cycles: get(&shared.cycles),
            lost: get(&shared.lost_in_stream) + get(&shared.dropped),
            seconds: get(&shared.last_ns).saturating_sub(get(&shared.first_ns)) as f64 * 1e-9,
            bytes: get(&shared.bytes),
            payload: get(&shared.payload),
            waiting: get(&shared.held),
            file: shared.file.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            part: get(&shared.part) as u32,
        }
    }

    /// What there is to warn of since this was asked last.
    pub fn warnings(&self) -> Vec<Warning> {
        self.shared.take_warnings()
    }

    /// Waits until it has ended (it does not ask for that), and tells what came of it.
    pub fn join(mut self) -> Report {
        let (is_drained, written) = self.wait();
        let failure = self.shared.failure.lock().unwrap_or_else(PoisonError::into_inner).take();
        let failure = failure.or((!is_drained).then_some(Error::Died(Thread::Recorder)));
        let written = written.unwrap_or_else(|| Written {
            files: vec![self.shared.file.lock().unwrap_or_else(PoisonError::into_inner).clone()],
            failure: Some(Error::Died(Thread::Writer)),
            ..Written::default()
        });
        let (first, last) = (written.first.unwrap_or_default(), written.last.unwrap_or_default());
        let total = written.total;
        let dropped = self.shared.dropped.load(Ordering::Relaxed);
        let received = self.shared.received.load(Ordering::Relaxed);
        let failure = written.failure.or(failure);
        Report {
            files: written.files,
            removed: written.removed,
            ended: written.ended.unwrap_or(Ended::Unwritable),
            cycles: total.cycles,
            // where nothing at all was written there is no gap to be seen
            lost: total.lost.max(dropped),
            gaps: total.gaps,
            missed: last.missed.saturating_sub(first.missed),
            seconds: last.monotonic_ns.saturating_sub(first.monotonic_ns) as f64 * 1e-9,
            bytes: written.bytes,
            payload: written.payload,
            not_written: received.saturating_sub(total.cycles + dropped),
            warnings: self.shared.take_warnings(),
            failure,
        }
    }

    /// Waits for both threads: whether the one that reads has done so to its end, and what the other has written.
    fn wait(&mut self) -> (bool, Option<Written>) {
        // its death is found by the writer, which then ends
        let is_drained = self.drain.take().is_some_and(|drain| drain.join().is_ok_and(|done| done.is_some()));
        (is_drained, self.writer.take().and_then(|writer| writer.join().ok().flatten()))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.stop();
        self.wait();
    }
}

/// The writer's thread.
fn write(
    options: &Options,
    about: About,
    layout: Layout,
    clocks: Clocks,
    shared: &Shared,
    outlet: &Outlet,
    ready: &std::sync::mpsc::Sender<Result<(), Error>>,
) -> Written {
    let _said = SaysItEnded(shared);
    match Writer::new(options, about, layout, clocks, shared, &free_bytes) {
        Ok(writer) => {
            let _ = ready.send(Ok(()));
            let written = writer.run(outlet);
            shared.is_written.store(written.ended.is_some(), Ordering::Release);
            written
        }
        Err(error) => {
            shared.is_written.store(true, Ordering::Release);
            let _ = ready.send(Err(error));
            Written::default()
        }
    }
}

/// Says that nothing more is written, also where the writer panics: who waits for its end must not wait for ever.
struct SaysItEnded<'a>(&'a Shared);

impl Drop for SaysItEnded<'_> {
    fn drop(&mut self) {
        self.0.stop.store(true, Ordering::Relaxed);
        self.0.ended.store(true, Ordering::Release);
    }
}

// A recording is made of these bytes as they are.
const _: () = assert!(cfg!(target_endian = "little") && align_of::<ChannelState>() == 8);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_writer_that_panics_has_ended() {
        let shared = Shared::default();
        let writer = std::panic::AssertUnwindSafe(|| {
            let _said = SaysItEnded(&shared);
            panic!("asked to panic");
        });
        assert!(std::panic::catch_unwind(writer).is_err());
        assert!(shared.ended.load(Ordering::Acquire) && shared.stop.load(Ordering::Relaxed));
    }
}
