//! Writing: every number in the fewest digits that read back as the same number, and a file that appears whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::iter;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use csv::WriterBuilder;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::column::{Column, TIME};
use crate::error::{Error, What};
use crate::read::is_gz;
use crate::recording::Recording;

/// Writes a recording, gzipped if `path` ends in `.gz`. A file of that name is replaced once the new one is complete.
///
/// # Errors
/// [`What::Unwritable`] with the system's reason; what was there before is untouched.
pub fn write(path: impl AsRef<Path>, recording: &Recording) -> Result<(), Error> {
    let columns: Vec<(Column, &[f64])> = recording.columns().collect();
    let names: Vec<Column> = columns.iter().map(|(c, _)| *c).collect();
    let mut writer = Writer::create(path, &names)?;
    let mut row = vec![0.0; columns.len()];
    for (i, &time_s) in recording.time_s().iter().enumerate() {
        for (cell, (_, values)) in row.iter_mut().zip(&columns) {
            *cell = values[i];
        }
        writer.row(time_s, &row)?;
    }
    writer.finish()
}

/// Writes a recording as CSV to anything, such as standard output; not compressed.
///
/// # Errors
/// Those of `to`.
pub fn write_to(to: impl Write, recording: &Recording) -> io::Result<()> {
    let columns: Vec<(Column, &[f64])> = recording.columns().collect();
    let names: Vec<&str> = columns.iter().map(|(c, _)| c.name()).collect();
    let mut csv = plain(to);
    header(&mut csv, &names)?;
    let mut cells = Vec::new();
    for (i, &time_s) in recording.time_s().iter().enumerate() {
        put(&mut csv, &mut cells, time_s, columns.iter().map(|(_, values)| values[i]))?;
    }
    csv.flush()
}

fn plain<W: Write>(to: W) -> csv::Writer<W> {
    WriterBuilder::new().has_headers(false).buffer_capacity(1 << 16).from_writer(to)
}

fn header<W: Write>(csv: &mut csv::Writer<W>, names: &[&str]) -> csv::Result<()> {
    csv.write_record(iter::once(&TIME).chain(names))
}

/// One row; `cells` is scratch space. The numbers are in the shortest form that reads back as the same bits.
fn put<W: Write>(
    csv: &mut csv::Writer<W>,
    cells: &mut Vec<Option<f64>>,
    time_s: f64,
    values: impl Iterator<Item = f64>,
) -> csv::Result<()> {
    cells.clear();
    cells.push(Some(time_s));
    cells.extend(values.map(|value| Some(value).filter(|v| !v.is_nan())));
    csv.serialize(cells)
}

/// Writes row by row, for recordings that do not fit into memory or are just being made.
///
/// Nothing of that name changes before [`Writer::finish`]; a writer that is dropped leaves nothing behind.
#[derive(Debug)]
pub struct Writer {
    /// `None` once finished.
    csv: Option<csv::Writer<Sink>>,
    /// What messages call it.
    path: PathBuf,
    /// The file it becomes; `None` for a stream.
    part: Option<Part>,
    columns: usize,
    cells: Vec<Option<f64>>,
}

enum Sink {
    Plain(File),
    Gzip(Box<GzEncoder<File>>),
    Stream(Box<dyn Write + Send>),
}

impl std::fmt::Debug for Sink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Sink::Plain(_) => "Plain",
            Sink::Gzip(_) => "Gzip",
            Sink::Stream(_) => "Stream",
        })
    }
}

impl Sink {
    fn writer(&mut self) -> &mut dyn Write {
        match self {
            Sink::Plain(file) => file,
            Sink::Gzip(file) => file.as_mut(),
            Sink::Stream(stream) => stream,
        }
    }

    /// The file, where it is one, with all that goes into it.
    fn finish(self) -> io::Result<Option<File>> {
        match self {
            Sink::Plain(file) => Ok(Some(file)),
            Sink::Gzip(file) => file.finish().map(Some),
            Sink::Stream(_) => Ok(None),
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer().flush()
    }
}

impl Writer {
    /// A file with `time_s` and these columns, gzipped if `path` ends in `.gz`.
    ///
    /// # Errors
    /// [`What::Unwritable`] with the system's reason.
    pub fn create(path: impl AsRef<Path>, columns: &[Column]) -> Result<Writer, Error> {
        let names: Vec<&str> = columns.iter().map(|c| c.name()).collect();
        Writer::create_named(path, &names)
    }

    /// The same with columns of any name besides `time_s`: for what a model knows and no sensor measures. Such a file
    /// reads back with [`crate::Options::ignore_columns`] only.
    ///
    /// # Errors
    /// As [`Writer::create`].
    pub fn create_named(path: impl AsRef<Path>, names: &[&str]) -> Result<Writer, Error> {
        let asked = path.as_ref();
        let (part, file) = Part::create(asked).map_err(|e| unwritable(asked, &e))?;
        let sink = match is_gz(asked) {
            true => Sink::Gzip(Box::new(GzEncoder::new(file, Compression::default()))),
            false => Sink::Plain(file),
        };
        Writer::headed(sink, asked.to_path_buf(), Some(part), names)
    }

    /// The same into a stream, such as standard output, uncompressed; `name` is what messages call it.
    ///
    /// # Errors
    /// [`What::Unwritable`] with the system's reason.
    pub fn to_stream(stream: Box<dyn Write + Send>, name: &str, names: &[&str]) -> Result<Writer, Error> {
        Writer::headed(Sink::Stream(stream), PathBuf::from(name), None, names)
    }

    fn headed(sink: Sink, path: PathBuf, part: Option<Part>, names: &[&str]) -> Result<Writer, Error> {
        let mut csv = plain(sink);
        let written = header(&mut csv, names);
        // a writer from here on, so that nothing is left behind if the header cannot be written
        let writer = Writer { csv: Some(csv), path, part, columns: names.len(), cells: Vec::new() };
        written.map_err(|e| unwritable(&writer.path, &e))?;
        Ok(writer)
    }

    /// One row: its time, and a value (NaN = missing) for each column in the order given to [`Writer::create`].
    ///
    /// # Errors
    /// [`What::Unwritable`], or [`What::WrongLength`] for another number of values.
    pub fn row(&mut self, time_s: f64, values: &[f64]) -> Result<(), Error> {
        if values.len() != self.columns {
            let what = What::WrongLength { expected: self.columns, found: values.len() };
            return Err(Error::new(&self.path.to_string_lossy(), what));
        }
        let Some(csv) = &mut self.csv else { return Ok(()) };
        put(csv, &mut self.cells, time_s, values.iter().copied()).map_err(|e| unwritable(&self.path, &e))
    }

    /// Completes the file, brings it safely to the disk and gives it its name.
    ///
    /// # Errors
    /// [`What::Unwritable`]; what was there before is untouched.
    pub fn finish(mut self) -> Result<(), Error> {
        let Some(csv) = self.csv.take() else { return Ok(()) };
        self.publish(csv).map_err(|e| unwritable(&self.path, &e))
    }

    fn publish(&mut self, csv: csv::Writer<Sink>) -> io::Result<()> {
        let sink = csv.into_inner().map_err(|e| e.into_error())?;
        if let (Some(part), Some(file)) = (self.part.take(), sink.finish()?) {
            part.publish(&file)?;
        }
        Ok(())
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        // first the handle, then the name: what is left here was never finished
        drop(self.csv.take());
    }
}

/// A file on its way: it is written beside its place, and takes it once it is whole. Dropped before, it leaves nothing
/// behind, and what was there before is untouched.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    /// Where it is collected; `None` when `path` is no ordinary file (a pipe, a terminal) and is written directly, and once
    /// it is published.
    part: Option<PathBuf>,
}

impl Part {
    /// Of a file that is to be called `path`, and what to write it to. A link stays a link, what it points to is replaced.
    ///
    /// # Errors
    /// The system's.
    pub fn create(path: &Path) -> io::Result<(Part, File)> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        match fs::metadata(&path) {
            Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) if !there.is_file() => {
                let file = File::options().write(true).open(&path)?;
                Ok((Part { path, part: None }, file))
            }
            _ => {
                let part = part_path(&path);
                let file = File::options().read(true).write(true).create_new(true).open(&part)?;
                Ok((Part { path, part: Some(part) }, file))
            }
        }
    }

    /// Brings what was written safely to the disk and gives it its name.
    ///
    /// # Errors
    /// The system's; what was there before is untouched.
    pub fn publish(mut self, file: &File) -> io::Result<()> {
        if let Some(part) = &self.part {
            file.sync_all()?;
            fs::rename(part, &self.path)?;
            self.part = None;
        }
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            let _ = fs::remove_file(part);
        }
    }
}

/// A hidden neighbour of `path`, on the same file system so that it can be renamed, no two alike.
pub(crate) fn part_path(path: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()))
}

fn unwritable(path: &Path, error: &dyn std::error::Error) -> Error {
    Error::new(&path.to_string_lossy(), What::Unwritable { reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, read};
    use proptest::prelude::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn an_unfinished_file_replaces_nothing_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("good.csv");
        fs::write(&path, "precious").unwrap();
        let mut writer = Writer::create(&path, &[Column::Duty]).unwrap();
        writer.row(0.0, &[0.5]).unwrap();
        assert!(matches!(writer.row(0.1, &[]).unwrap_err().what, What::WrongLength { expected: 1, found: 0 }));
        drop(writer);
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        assert_eq!(names_in(folder.path()), ["good.csv"]);
        let mut writer = Writer::create(&path, &[Column::Duty]).unwrap();
        writer.row(0.0, &[0.5]).unwrap();
        writer.row(1e-7, &[f64::NAN]).unwrap();
        writer.finish().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "time_s,duty\n0.0,0.5\n1e-7,\n");
        assert_eq!(names_in(folder.path()), ["good.csv"]);
    }

    #[test]
    fn a_refusal_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = Writer::create(folder.path(), &[]).unwrap_err();
        assert!(matches!(error.what, What::Unwritable { .. }) && !error.is_bad_input(), "{error}");
        let nowhere = folder.path().join("no/such/folder.csv");
        let error = Writer::create(&nowhere, &[]).unwrap_err();
        assert!(error.to_string().contains("no/such/folder.csv: cannot be written"), "{error}");
    }

    #[test]
    fn a_stream_takes_columns_of_any_name() {
        #[derive(Clone, Default)]
        struct Shared(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);
        impl Write for Shared {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0.lock().unwrap().extend_from_slice(bytes);
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let stream = Shared::default();
        let mut writer = Writer::to_stream(Box::new(stream.clone()), "stdout", &["duty", "martensite"]).unwrap();
        writer.row(0.5, &[0.1, 0.9]).unwrap();
        writer.finish().unwrap();
        assert_eq!(*stream.0.lock().unwrap(), b"time_s,duty,martensite\n0.5,0.1,0.9\n");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real.csv"), folder.path().join("link.csv"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        Writer::create(&link, &[]).unwrap().finish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "time_s\n");
    }

    prop_compose! {
        fn any_recording()(
            steps in prop::collection::vec(1e-6f64..10.0, 3..40),
            columns in prop::collection::vec(any::<bool>(), Column::COUNT),
            seed in any::<u64>(),
        ) -> Recording {
            let times = steps.iter().scan(-3.0, |t, dt| { *t += dt; Some(*t) }).collect();
            let mut recording = Recording::new("any", times).unwrap();
            let mut bits = seed;
            for (column, _) in Column::ALL.into_iter().zip(columns).filter(|(_, there)| *there) {
                let values = (0..recording.len()).map(|_| {
                    bits = bits.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    let share = (bits >> 11) as f64 / (1u64 << 53) as f64;
                    match column {
                        Column::Duty => share,
                        Column::PositionM => share * 0.1,
                        Column::TemperatureC | Column::AmbientC => share * 200.0,
                        // any number there is, holes included
                        _ => Some(f64::from_bits(bits)).filter(|v| v.is_finite()).unwrap_or(f64::NAN),
                    }
                }).collect();
                recording.set(column, values).unwrap();
            }
            recording
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_bit_survives_a_round_trip(recording in any_recording(), gz in any::<bool>()) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(if gz { "a.csv.gz" } else { "a.csv" });
            write(&path, &recording).unwrap();
            let back = read(&path, &Options::default()).unwrap();
            let bits = |values: &[f64]| -> Vec<u64> {
                values.iter().map(|v| if v.is_nan() { u64::MAX } else { v.to_bits() }).collect()
            };
            prop_assert_eq!(bits(back.time_s()), bits(recording.time_s()));
            for column in Column::ALL {
                prop_assert_eq!(back.get(column).map(bits), recording.get(column).map(bits));
            }
            let mut text = Vec::new();
            write_to(&mut text, &recording).unwrap();
            if !gz {
                prop_assert_eq!(text, fs::read(&path).unwrap());
            }
        }
    }
}
