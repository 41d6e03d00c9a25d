//! The thread that writes: cycles out of the buffer into files, one after the other.

use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_recording::session::{Abandoned, About, Ended, Ending, Head, Layout, SessionWriter, WriteOptions, close_off};

use crate::blocks::{Item, Outlet};
use crate::error::Error;
use crate::events::FaultEvents;
use crate::files;
use crate::options::Options;
use crate::shared::{Shared, Written};

/// How long at most an idle writer keeps what it has.
const IDLE: Duration = Duration::from_millis(200);
/// How often what is written is brought to the disk: what a power failure may cost.
const SYNC: Duration = Duration::from_secs(5);
/// What a summary takes for each chunk, and at all, bytes: to end a file before it is too large.
const SUMMARY_PER_CHUNK: u64 = 160;
const SUMMARY: u64 = 64 << 10;

/// Writes until the end, or until nothing more can be written; then the rest is only taken out of the buffer.
pub(crate) struct Writer<'a> {
    options: &'a Options,
    about: About,
    layout: Layout,
    shared: &'a Shared,
    /// `None` once nothing more can be written.
    part: Option<Part>,
    written: Written,
    faults: FaultEvents,
}

/// The file that is being written.
struct Part {
    path: PathBuf,
    session: SessionWriter<File>,
    /// A second hold on it, to bring it to the disk.
    file: File,
    from_ns: u64,
    next_sync: Instant,
    chunks: u64,
    largest_chunk: u64,
    bytes: u64,
}

impl<'a> Writer<'a> {
    /// With its first file open, so that what is wrong with its place is known at once.
    pub(crate) fn new(
        options: &'a Options,
        about: About,
        layout: Layout,
        shared: &'a Shared,
    ) -> Result<Writer<'a>, Error> {
        let faults = FaultEvents::new(layout.channels.len());
        let mut writer = Writer { options, about, layout, shared, part: None, written: Written::default(), faults };
        writer.part = Some(writer.open(0, writer.about.started_monotonic_ns, None)?);
        Ok(writer)
    }

    fn open(&mut self, number: u32, from_ns: u64, after_cycle: Option<u64>) -> Result<Part, Error> {
        let path = files::part_path(&self.options.path, number);
        let file = files::create(&path, self.options.overwrite)?;
        let second = file.try_clone().map_err(|error| files::unwritable(&path, &error))?;
        self.about.extra.insert("part".into(), number.to_string());
        let defaults = WriteOptions::new(path.to_string_lossy());
        let options = WriteOptions {
            compression: self.options.compression,
            after_cycle,
            chunk_bytes: self.options.max_bytes.map_or(defaults.chunk_bytes, |most| defaults.chunk_bytes.min(most / 8)),
            ..defaults
        };
        let session = SessionWriter::create(file, &self.about, &self.layout, options)?;
        self.written.files.push(path.clone());
        self.shared.set_file(&path);
        let bytes = session.bytes();
        Ok(Part {
            path,
            session,
            file: second,
            from_ns,
            next_sync: Instant::now() + SYNC,
            chunks: 0,
            largest_chunk: 0,
            bytes,
        })
    }

    /// Writes what comes out of the buffer until it says that this is all.
    pub(crate) fn run(mut self, outlet: &Outlet) -> Written {
        loop {
            let done = match outlet.next(IDLE) {
                None => self.on(|part, _| part.session.cut().map_err(Error::from)),
                Some(Item::Figures(figures)) => self.on(|part, _| Ok(part.session.loop_stats(&figures)?)),
                Some(Item::Cycles(block)) => {
                    let mut done = Ok(());
                    for (head, bytes) in block.iter() {
                        done = done.and_then(|()| self.cycle(head, bytes));
                    }
                    outlet.done(block);
                    done
                }
                Some(Item::End(ended, last)) => {
                    let lost = self.on(|part, _| Ok(part.session.lost_to(&last)?));
                    self.settle(lost);
                    let ended = if self.part.is_some() { ended } else { Ended::Unwritable };
                    self.written.ended = Some(ended);
                    let done = self.close(ended);
                    self.settle(done);
                    return self.written;
                }
            };
            let synced = done.and_then(|()| self.sync());
            self.settle(synced);
        }
    }

    /// With the present file, if there still is one.
    fn on(&mut self, act: impl FnOnce(&mut Part, &mut Written) -> Result<(), Error>) -> Result<(), Error> {
        match &mut self.part {
            Some(part) => act(part, &mut self.written),
            None => Ok(()),
        }
    }

    fn cycle(&mut self, head: &Head, bytes: &[u8]) -> Result<(), Error> {
        let Some(part) = &self.part else { return Ok(()) };
        if part.is_full(self.options, head) {
            let number = self.written.files.len() as u32;
            self.close(Ended::Rotated)?;
            self.part = Some(self.open(number, head.monotonic_ns, self.written.last.map(|last| last.cycle))?);
        }
        let Some(part) = &mut self.part else { return Ok(()) };
        for event in self.faults.of(head, bytes, &self.layout.channels) {
            part.session.event(&event)?;
        }
        part.session.cycle(head, bytes)?;
        part.grown();
        self.written.first.get_or_insert(*head);
        self.written.last = Some(*head);
        self.shared.progress(&self.written, &part.session);
        Ok(())
    }

    /// Completes the present file.
    fn close(&mut self, ended: Ended) -> Result<(), Error> {
        let Some(mut part) = self.part.take() else { return Ok(()) };
        // a file that cannot be completed must still be reported
        if let Err(error) = part.session.cut() {
            self.part = Some(part);
            return Err(error.into());
        }
        let (ending, payload, path) = (part.session.ending(), part.session.payload(), part.path.clone());
        let unwritable = |error| files::unwritable(&path, &error);
        let length = part.session.bytes();
        match part.session.finish(ended) {
            Ok(file) => {
                files::keep(&path, &file).map_err(unwritable)?;
                self.written.bytes += file.metadata().map_err(unwritable)?.len();
                self.add(&ending, payload);
                Ok(())
            }
            Err(error) => {
                // All chunks are there; only the summary found no room.
                let ending = Ending { ended: Some(Ended::Unwritable), ..ending };
                self.end_without_summary(&mut part.file, length, &ending);
                self.add(&ending, payload);
                Err(error.into())
            }
        }
    }

    /// Takes note of a failure: what is complete is made a whole file, and nothing more is written.
    fn settle(&mut self, done: Result<(), Error>) {
        let Err(error) = done else { return };
        if let Some(part) = self.part.take() {
            let payload = part.session.payload();
            let Abandoned { mut sink, length, ending } = part.session.abandon();
            let ending = Ending { ended: Some(Ended::Unwritable), ..ending };
            self.end_without_summary(&mut sink, length, &ending);
            self.add(&ending, payload);
        }
        self.written.failure.get_or_insert(error);
        self.written.ended = Some(Ended::Unwritable);
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    fn end_without_summary(&mut self, file: &mut File, length: u64, ending: &Ending) {
        // If there is no room even for that, the file ends after its last complete chunk.
        if file.set_len(length).is_ok() && close_off(file, length, ending).is_err() {
            let _ = file.set_len(length);
        }
        let _ = file.sync_all();
        self.written.bytes += file.metadata().map_or(length, |there| there.len());
    }

    /// Adds a file's end to the whole recording's.
    fn add(&mut self, ending: &Ending, payload: u64) {
        let total = &mut self.written.total;
        total.cycles += ending.cycles;
        total.lost += ending.lost;
        total.gaps.extend(&ending.gaps);
        total.gaps_not_listed += ending.gaps_not_listed;
        self.written.payload += payload;
    }

    fn sync(&mut self) -> Result<(), Error> {
        self.on(|part, _| {
            if Instant::now() >= part.next_sync {
                part.file.sync_data().map_err(|error| files::unwritable(&part.path, &error))?;
                part.next_sync = Instant::now() + SYNC;
            }
            Ok(())
        })
    }
}

impl Part {
    /// Whether this cycle belongs into the next file.
    fn is_full(&self, options: &Options, head: &Head) -> bool {
        let age_s = head.monotonic_ns.saturating_sub(self.from_ns) as f64 * 1e-9;
        let next = self.bytes + self.largest_chunk + SUMMARY + SUMMARY_PER_CHUNK * (self.chunks + 1);
        self.session.cycles() > 0
            && (options.max_file_s.is_some_and(|most| age_s >= most)
                || options.max_bytes.is_some_and(|most| self.chunks > 0 && next > most))
    }

    /// Takes note of a chunk that was completed.
    fn grown(&mut self) {
        let bytes = self.session.bytes();
        if bytes > self.bytes {
            self.chunks += 1;
            self.largest_chunk = self.largest_chunk.max(bytes - self.bytes);
            self.bytes = bytes;
        }
    }
}
