//! The true temperatures of the wires in a file, for whoever watches from outside. A thread of its own writes them: the
//! host must answer in time, and a disk may take tens of milliseconds.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use sinew_rig::Rig;

use crate::error::Error;
use crate::wires::Wires;

/// From one row to the next, ns.
const TRUTH_NS: u64 = 10_000_000;
/// Rows that may wait for the disk, a minute's; then the host waits as well, since no row may be missing.
const WAITING: usize = 6_000;

/// Time since it was made, s, and the temperature of every wire in °C, in the order of the rig.
type Row = (f64, Vec<f64>);

/// Writes the rows `time_s,WIRE,…`.
#[derive(Debug)]
pub(crate) struct Truth {
    path: PathBuf,
    rows: Option<SyncSender<Row>>,
    writer: Option<JoinHandle<io::Result<()>>>,
    start_ns: Option<u64>,
    due_ns: u64,
}

impl Truth {
    pub fn create(path: &Path, rig: &Rig) -> Result<Truth, Error> {
        let names: Vec<&str> = rig.channels.iter().map(|channel| channel.name.as_str()).collect();
        let (rows, waiting) = sync_channel(WAITING);
        let started = File::create(path).and_then(|file| {
            let mut file = BufWriter::new(file);
            writeln!(file, "time_s,{}", names.join(","))?;
            file.flush()?;
            thread::Builder::new().name("truth".into()).spawn(move || written(file, &waiting))
        });
        let writer = started.map_err(|error| Error::Truth { path: path.into(), error })?;
        Ok(Truth { path: path.into(), rows: Some(rows), writer: Some(writer), start_ns: None, due_ns: 0 })
    }

    /// A row, if it is time for one.
    pub fn write(&mut self, now_ns: u64, wires: &mut Wires) -> Result<(), Error> {
        if now_ns < self.due_ns {
            return Ok(());
        }
        self.due_ns = now_ns + TRUTH_NS;
        wires.rest();
        let time_s = (now_ns - *self.start_ns.get_or_insert(now_ns)) as f64 * 1e-9;
        let row = (time_s, wires.temperatures_c().collect());
        match self.rows.as_ref().map(|rows| rows.send(row)) {
            Some(Ok(())) => Ok(()),
            // the writer ended before it was asked to
            _ => self.finish(),
        }
    }

    /// Waits until every row is in the file.
    ///
    /// # Errors
    /// What kept the writer from writing.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.rows = None;
        let ended = self.writer.take().map(JoinHandle::join);
        let written = match ended {
            Some(Ok(written)) => written,
            Some(Err(_)) => Err(io::Error::other("the writer ended by itself")),
            None => Ok(()),
        };
        written.map_err(|error| Error::Truth { path: self.path.clone(), error })
    }
}

impl Drop for Truth {
    fn drop(&mut self) {
        // who ends in order has finished already and knows of errors
        let _ = self.finish();
    }
}

fn written(mut file: BufWriter<File>, rows: &Receiver<Row>) -> io::Result<()> {
    for (time_s, temperatures_c) in rows {
        write!(file, "{time_s:.4}")?;
        for temperature_c in temperatures_c {
            write!(file, ",{temperature_c:.3}")?;
        }
        writeln!(file)?;
        file.flush()?;
    }
    Ok(())
}
