//! The true temperatures of the wires in a file, for whoever watches from outside.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use sinew_rig::Rig;

use crate::error::Error;
use crate::wires::Wires;

/// From one row to the next, ns.
const TRUTH_NS: u64 = 10_000_000;

/// Writes `time_s` (since it was made) and the temperature of every wire in °C, in the order of the rig.
#[derive(Debug)]
pub(crate) struct Truth {
    path: PathBuf,
    file: BufWriter<File>,
    start_ns: Option<u64>,
    due_ns: u64,
}

impl Truth {
    pub fn create(path: &Path, rig: &Rig) -> Result<Truth, Error> {
        let made = File::create(path).and_then(|file| {
            let mut file = BufWriter::new(file);
            let names: Vec<&str> = rig.channels.iter().map(|channel| channel.name.as_str()).collect();
            writeln!(file, "time_s,{}", names.join(","))?;
            file.flush()?;
            Ok(file)
        });
        let file = made.map_err(|error| Error::Truth { path: path.into(), error })?;
        Ok(Truth { path: path.into(), file, start_ns: None, due_ns: 0 })
    }

    /// A row, if it is time for one.
    pub fn write(&mut self, now_ns: u64, wires: &mut Wires) -> Result<(), Error> {
        if now_ns < self.due_ns {
            return Ok(());
        }
        self.due_ns = now_ns + TRUTH_NS;
        wires.rest();
        let time_s = (now_ns - *self.start_ns.get_or_insert(now_ns)) as f64 * 1e-9;
        self.row(time_s, wires).map_err(|error| Error::Truth { path: self.path.clone(), error })
    }

    fn row(&mut self, time_s: f64, wires: &Wires) -> io::Result<()> {
        write!(self.file, "{time_s:.4}")?;
        for temperature_c in wires.temperatures_c() {
            write!(self.file, ",{temperature_c:.3}")?;
        }
        writeln!(self.file)?;
        self.file.flush()
    }
}
