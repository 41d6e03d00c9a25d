//! The thread that writes: cycles out of the buffer into files, one after the other.

use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::{Clocks, Reading};
use sinew_recording::session::{Abandoned, About, Ended, Ending, Head, Layout, SessionWriter, WriteOptions, close_off};

use crate::blocks::{Item, Outlet};
use crate::error::Error;
use crate::events::FaultEvents;
use crate::files;
use crate::floor::{Floor, Free};
use crate::options::Options;
use crate::retention::Kept;
use crate::shared::{Shared, Written};
use crate::warning::Warning;

/// How long at most an idle writer keeps what it has.
const IDLE: Duration = Duration::from_millis(200);
/// How often what is written is brought to the disk: what a power failure may cost.
const SYNC: Duration = Duration::from_secs(5);
/// How often the clocks are written beside each other; when the system's is set, at once.
const CLOCKS_NS: u64 = 10_000_000_000;
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
    clocks: Clocks,
    /// When the clocks were written last, CLOCK_MONOTONIC, ns.
    clocks_written_ns: u64,
    faults: FaultEvents,
    kept: Kept,
    floor: Floor<'a>,
}

/// The file that is being written.
struct Part {
    number: u32,
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
    /// With its first file open, so that what is wrong with its place is known at once. `free` says how much is free there.
    pub(crate) fn new(
        options: &'a Options,
        about: About,
        layout: Layout,
        clocks: Clocks,
        shared: &'a Shared,
        free: &'a Free<'a>,
    ) -> Result<Writer<'a>, Error> {
        let mut writer = Writer {
            options,
            faults: FaultEvents::new(layout.channels.len()),
            about,
            layout,
            shared,
            part: None,
            written: Written::default(),
            clocks,
            clocks_written_ns: 0,
            kept: Kept::new(options),
            floor: Floor::new(options.keep_free_bytes, free),
        };
        // Before anything is created or replaced.
        writer.floor.look(&options.path, Instant::now())?.into_iter().for_each(|warning| shared.warn(warning));
        // The first file of an earlier recording may have been removed: its later ones would be in the way only when they are reached.
        if let Some(path) = files::later_part(&options.path).filter(|_| options.removes() && !options.overwrite) {
            return Err(Error::Exists { path });
        }
        writer.part = Some(writer.open(0, writer.about.started_monotonic_ns, None)?);
        Ok(writer)
    }

    fn open(&mut self, number: u32, from_ns: u64, after_cycle: Option<u64>) -> Result<Part, Error> {
        let path = files::part_path(&self.options.path, number);
        let file = files::create(&path, self.options.overwrite)?;
        let second = file.try_clone().map_err(|error| files::unwritable(&path, &error))?;
        let most_bytes = self.options.most_bytes();
        self.about.extra.insert("part".into(), number.to_string());
        let defaults = WriteOptions::new(path.to_string_lossy());
        let options = WriteOptions {
            compression: self.options.compression,
            after_cycle,
            chunk_bytes: most_bytes.map_or(defaults.chunk_bytes, |most| defaults.chunk_bytes.min(most / 8)),
            ..defaults
        };
        let mut session = SessionWriter::create(file, &self.about, &self.layout, options)?;
        // The comparison that the time of day of all its messages is made by, or, in a later file, the latest.
        session.clocks(self.clocks.reading())?;
        self.clocks_written_ns = self.clocks.reading().monotonic_ns;
        self.written.files.push(path.clone());
        self.shared.set_file(&path);
        let bytes = session.bytes();
        Ok(Part {
            number,
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
            if sinew_threads::is_struck() {
                return self.written;
            }
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
                    // Below the floor the file is open yet.
                    let failed = self.part.is_none() || self.written.failure.is_some();
                    let ended = if failed { Ended::Unwritable } else { ended };
                    self.written.ended = Some(ended);
                    let done = self.close(ended);
                    self.settle(done);
                    return self.written;
                }
            };
            let compared = done.and_then(|()| self.compare_clocks());
            let synced = compared.and_then(|()| self.sync());
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
        let begins = part.is_full(self.options, head);
        if begins {
            let number = part.number + 1;
            self.close(Ended::Rotated)?;
            self.part = Some(self.open(number, head.monotonic_ns, self.written.last.map(|last| last.cycle))?);
        }
        let Some(part) = &mut self.part else { return Ok(()) };
        for event in self.faults.of(head, bytes, &self.layout.channels) {
            part.session.event(&event)?;
        }
        part.session.cycle(head, bytes)?;
        let grown = part.grown();
        self.written.first.get_or_insert(*head);
        self.written.last = Some(*head);
        self.shared.progress(&self.written, &part.session);
        // A file that was ended has had its last chunk.
        if grown || begins {
            self.remove_oldest();
            self.look_at_the_disk();
        }
        Ok(())
    }

    /// Looks at the clocks. They are written now and then, and on either side of what became of the system's.
    fn compare_clocks(&mut self) -> Result<(), Error> {
        let before = *self.clocks.reading();
        let change = self.clocks.refresh();
        let now = *self.clocks.reading();
        let is_another = change.step().is_some() || change.suspended_ns != 0 || change.tai_offset_changed;
        let is_due = now.monotonic_ns.saturating_sub(self.clocks_written_ns) >= CLOCKS_NS;
        match (is_another, is_due) {
            (true, _) => self.write_clocks(&[before, now]),
            (false, true) => self.write_clocks(&[now]),
            (false, false) => Ok(()),
        }
    }

    fn write_clocks(&mut self, readings: &[Reading]) -> Result<(), Error> {
        for reading in readings.iter().filter(|reading| reading.monotonic_ns > self.clocks_written_ns) {
            if let Some(part) = &mut self.part {
                part.session.clocks(reading)?;
            }
        }
        self.clocks_written_ns = readings.last().map_or(self.clocks_written_ns, |last| last.monotonic_ns);
        Ok(())
    }

    /// Removes the oldest files while there is too much. After the next one is open: should that fail, more is left.
    fn remove_oldest(&mut self) {
        let Some(being_written) = self.part.as_ref().map(Part::next_bytes) else { return };
        while let Some(oldest) = self.kept.surplus(being_written) {
            let removed = oldest.remove();
            if !matches!(removed, Err(Warning::NotRemoved { .. })) {
                self.written.files.retain(|path| *path != oldest.path);
            }
            match removed {
                Ok(true) => self.written.removed.add(&oldest),
                // somebody has moved it away
                Ok(false) => {}
                Err(warning) => self.shared.warn(warning),
            }
        }
    }

    /// Looks how much is free. Below the floor nothing more is taken from the driver, and what was taken is still written.
    fn look_at_the_disk(&mut self) {
        let Some(part) = self.part.as_ref().filter(|_| self.written.failure.is_none()) else { return };
        match self.floor.look(&part.path, Instant::now()) {
            Ok(None) => {}
            Ok(Some(warning)) => self.shared.warn(warning),
            Err(error) => {
                self.written.failure = Some(error);
                self.shared.stop.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Completes the present file.
    fn close(&mut self, ended: Ended) -> Result<(), Error> {
        if self.part.is_none() {
            return Ok(());
        }
        self.clocks.refresh();
        let last = *self.clocks.reading();
        self.write_clocks(&[last])?;
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
                let there = file.metadata().map_err(unwritable)?;
                self.written.bytes += there.len();
                self.kept.add(&path, &there, ending.cycles);
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
        self.session.cycles() > 0
            && (options.max_file_s.is_some_and(|most| age_s >= most)
                || options.most_bytes().is_some_and(|most| self.chunks > 0 && self.next_bytes() > most))
    }

    /// Bytes it will have at the most with one more chunk and its summary.
    fn next_bytes(&self) -> u64 {
        self.bytes + self.largest_chunk + SUMMARY + SUMMARY_PER_CHUNK * (self.chunks + 1)
    }

    /// Takes note of a chunk that was completed; whether one was.
    fn grown(&mut self) -> bool {
        let bytes = self.session.bytes();
        let grown = bytes > self.bytes;
        if grown {
            self.chunks += 1;
            self.largest_chunk = self.largest_chunk.max(bytes - self.bytes);
            self.bytes = bytes;
        }
        grown
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs;
    use std::io;
    use std::path::Path;
    use std::sync::Arc;

    use sinew_ipc::{ChannelState, CycleHeader};
    use sinew_recording::session::{Compression, Session, check};

    use super::*;
    use crate::blocks::{Block, buffer};

    const MS: u64 = 1_000_000;
    const MB: u64 = 1_000_000;

    fn plenty(_: &Path) -> io::Result<u64> {
        Ok(u64::MAX)
    }

    /// Writes so many cycles of eight channels, a millisecond apart; a chunk is a second of them.
    fn write(options: &Options, cycles: u64, free: &Free) -> Result<(Written, Shared), Error> {
        let (shared, held) = (Shared::default(), Arc::default());
        let layout = crate::layout((0..8).map(|channel| format!("wire{channel}")).collect()).unwrap();
        let about = About {
            rig: "bench".into(),
            rate_hz: 1000.0,
            software: "test".into(),
            kind: "driver".into(),
            simulated: true,
            started_unix_ns: 0,
            started_monotonic_ns: 0,
            rig_toml: None,
            extra: Default::default(),
        };
        let writer = Writer::new(options, about, layout, Clocks::now(), &shared, free)?;
        let (inlet, outlet) = buffer(u64::MAX, held);
        let (mut block, mut last) = (Block::default(), Head::default());
        for cycle in 1..=cycles {
            let header = CycleHeader { cycle, monotonic_ns: cycle * MS, missed: 0 };
            last = block.push(&header, &[ChannelState::UNKNOWN; 8]);
            if cycle % 100 == 0 || cycle == cycles {
                assert!(inlet.put(&mut block));
            }
        }
        inlet.send(Item::End(Ended::Stopped, last));
        let written = writer.run(&outlet);
        Ok((written, shared))
    }

    /// The files there, with the bytes of each.
    fn listing(folder: &Path) -> Vec<(String, u64)> {
        let there = fs::read_dir(folder).unwrap().map(Result::unwrap);
        let mut listing: Vec<_> =
            there.map(|entry| (entry.file_name().into_string().unwrap(), entry.metadata().unwrap().len())).collect();
        listing.sort();
        listing
    }

    /// Expects a whole file; its cycles.
    fn whole(path: &Path) -> u64 {
        let checkup = check(path, |_, _| {}).unwrap();
        assert!(checkup.is_whole(), "{}: {checkup:?}", path.display());
        checkup.cycles
    }

    #[test]
    fn below_the_floor_it_ends_with_a_whole_file_and_all_it_had_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.mcap");
        let free = Cell::new(550 * MB);
        let falls = |_: &Path| {
            free.set(free.get() - 50 * MB);
            Ok(free.get())
        };
        let (written, shared) = write(&Options::new(&path), 10_000, &falls).unwrap();
        let Some(Error::Floor { path: named, free: 250_000_000, floor: 256_000_000 }) = &written.failure else {
            panic!("{:?}", written.failure)
        };
        assert!(*named == path && shared.stop.load(Ordering::Relaxed));
        assert_eq!((written.ended, written.total.cycles), (Some(Ended::Unwritable), 10_000));
        assert_eq!(whole(&path), 10_000);
        assert_eq!(Session::open(&path).unwrap().ending().unwrap().ended, Some(Ended::Unwritable));
        // nobody looks again once it is known
        assert_eq!(free.get(), 250 * MB);
        let warnings = shared.take_warnings();
        assert!(matches!(&warnings[..], [Warning::LowSpace { floor: 256_000_000, .. }]), "{warnings:?}");
    }

    #[test]
    fn the_floor_is_seen_however_short_the_files_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.mcap");
        let options = Options { max_file_s: Some(1.0), ..Options::new(&path) };
        let free = Cell::new(1000 * MB);
        let falls = |_: &Path| {
            free.set(free.get() - 200 * MB);
            Ok(free.get())
        };
        let (written, _) = write(&options, 10_000, &falls).unwrap();
        assert!(matches!(written.failure, Some(Error::Floor { .. })), "{:?}", written.failure);
        assert_eq!(written.files.iter().map(|path| whole(path)).sum::<u64>(), 10_000);
    }

    #[test]
    fn without_room_nothing_is_created_or_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.mcap");
        let little = |_: &Path| Ok(255 * MB);
        let error = write(&Options::new(&path), 1, &little).unwrap_err();
        assert!(matches!(error, Error::Floor { .. }) && !error.is_bad_input() && !path.exists(), "{error}");
        fs::write(&path, "precious").unwrap();
        write(&Options { overwrite: true, ..Options::new(&path) }, 1, &little).unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"precious");
        write(&Options { overwrite: true, keep_free_bytes: 0, ..Options::new(&path) }, 1, &little).unwrap();
        assert_eq!(whole(&path), 1);
    }

    #[test]
    fn the_last_files_are_kept_and_nothing_else_is_touched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.mcap");
        let options = Options { max_file_s: Some(1.0), keep_files: Some(3), ..Options::new(&path) };
        for other in ["night-0001.csv", "night-notes.mcap", "night-1.mcap", "other-0002.mcap"] {
            fs::write(folder.path().join(other), "precious").unwrap();
        }
        let before = listing(folder.path());
        let (written, shared) = write(&options, 9_500, &plenty).unwrap();
        assert!(written.failure.is_none() && shared.take_warnings().is_empty());
        let kept: Vec<PathBuf> = (7..10).map(|number| files::part_path(&path, number)).collect();
        assert_eq!(written.files, kept);
        let mut all = before.clone();
        all.extend(kept.iter().map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::metadata(path).unwrap().len())
        }));
        all.sort();
        assert_eq!(listing(folder.path()), all);
        let left: u64 = kept.iter().map(|path| whole(path)).sum();
        assert_eq!((written.removed.files, written.removed.cycles + left), (7, written.total.cycles));
        assert_eq!(Session::open(&kept[2]).unwrap().about().extra["part"], "9");
    }

    #[test]
    fn all_files_together_stay_within_what_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.mcap");
        let keep = 8 * MB;
        let options = Options { compression: Compression::None, keep_bytes: Some(keep), ..Options::new(&path) };
        let most = Cell::new(0);
        // asked for after each chunk
        let look = |_: &Path| {
            most.set(most.get().max(listing(folder.path()).iter().map(|(_, bytes)| bytes).sum()));
            Ok(u64::MAX)
        };
        let (written, _) = write(&options, 15_000, &look).unwrap();
        assert!(written.failure.is_none() && written.removed.files > 5, "{written:?}");
        let left: u64 = listing(folder.path()).iter().map(|(_, bytes)| bytes).sum();
        assert!(most.get() <= keep && left <= keep && left > keep / 2, "{} {left}", most.get());
        assert_eq!(written.bytes, written.removed.bytes + left);
        assert_eq!(written.files.iter().map(|path| whole(path)).sum::<u64>() + written.removed.cycles, 15_000);
    }

    #[test]
    fn a_file_put_in_the_place_of_an_older_one_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.mcap");
        let options = Options { max_file_s: Some(1.0), keep_files: Some(2), ..Options::new(&path) };
        // by somebody else, while the second file is written
        let replaces = |_: &Path| {
            if files::part_path(&path, 1).exists() && fs::metadata(&path).is_ok_and(|there| there.len() != 8) {
                fs::remove_file(&path).unwrap();
                fs::write(&path, "precious").unwrap();
            }
            Ok(u64::MAX)
        };
        let (written, shared) = write(&options, 4_500, &replaces).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"precious");
        let warnings = shared.take_warnings();
        assert!(matches!(&warnings[..], [Warning::NotOurs { path: named }] if *named == path), "{warnings:?}");
        assert_eq!((written.files.len(), written.removed.files), (2, 2));
    }

    #[test]
    fn a_series_of_which_the_first_file_was_removed_is_not_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.mcap");
        let options = Options { max_file_s: Some(1.0), keep_files: Some(2), ..Options::new(&path) };
        write(&options, 3_500, &plenty).unwrap();
        let before = listing(folder.path());
        let error = write(&options, 1, &plenty).unwrap_err();
        assert!(matches!(&error, Error::Exists { path: there } if there.ends_with("night-0002.mcap")), "{error}");
        assert_eq!(listing(folder.path()), before);
        // as asked for
        write(&Options { overwrite: true, ..options }, 1, &plenty).unwrap();
    }
}
