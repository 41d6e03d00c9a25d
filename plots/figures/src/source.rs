//! A recording to be drawn, whichever kind it is: channels, fields, and its samples one after the other.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use sinew_recording::session::{CycleView, LoopFigures, Session};
use sinew_recording::{Column, Options, Recording, TIME};
use sinew_rig::Rig;

use crate::Error;

/// How an MCAP file begins.
const MCAP: &[u8] = b"\x89MCAP";

/// An open recording.
pub struct Source {
    /// What it is called in legends: its file's name.
    pub name: String,
    /// Its channels; one of CSV has none of its own and is called as the file.
    pub channels: Vec<String>,
    /// The fields of every channel, unit included.
    pub fields: Vec<String>,
    /// The rig it was taken on, where it says so.
    pub rig: Option<Rig>,
    of: Of,
}

enum Of {
    Csv { recording: Box<Recording>, columns: Vec<Column> },
    Session(Box<Session>),
}

/// One sample of all channels.
pub enum Sample<'a> {
    /// A row of CSV.
    Row(&'a Recording, &'a [Column], usize),
    /// A cycle of a session.
    Cycle(CycleView<'a>),
}

impl Sample<'_> {
    /// A channel's field, both by number; NaN where it is missing.
    #[inline]
    pub fn get(&self, channel: usize, field: usize) -> f64 {
        match self {
            Sample::Row(recording, columns, row) => {
                columns.get(field).and_then(|column| recording.get(*column)?.get(*row)).copied().unwrap_or(f64::NAN)
            }
            Sample::Cycle(cycle) => cycle.get(channel, field),
        }
    }
}

impl Source {
    /// Opens a session (MCAP) or a CSV file, by what is in it.
    ///
    /// # Errors
    /// [`Error::Recording`] with the reader's own words.
    pub fn open(path: &Path, ignore_columns: bool) -> Result<Source, Error> {
        let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
        let name = name.strip_suffix(".csv").unwrap_or(&name).to_owned();
        let mut start = [0; 5];
        let is_mcap = File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok() && start == *MCAP;
        if is_mcap {
            let session = Session::open(path).map_err(Error::Recording)?;
            let rig = session.about().rig_toml.as_deref().and_then(|text| Rig::parse(text, "rig.toml").ok());
            return Ok(Source {
                name,
                channels: session.layout().channels.clone(),
                fields: session.layout().fields.iter().map(|field| field.name.clone()).collect(),
                rig,
                of: Of::Session(Box::new(session)),
            });
        }
        let options = Options { ignore_columns, ..Options::default() };
        let recording = sinew_recording::read(path, &options).map_err(Error::Recording)?;
        let columns: Vec<Column> = recording.columns().map(|(column, _)| column).collect();
        Ok(Source {
            channels: vec![name.clone()],
            name,
            fields: columns.iter().map(|column| column.name().to_owned()).collect(),
            rig: None,
            of: Of::Csv { recording: Box::new(recording), columns },
        })
    }

    /// Whether its channels have names of their own.
    pub fn has_channels(&self) -> bool {
        matches!(self.of, Of::Session(_))
    }

    /// The number of a field.
    pub fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field == name)
    }

    /// Gives every sample from one time to another, s, in order: its time, whether something is missing before it, itself.
    ///
    /// # Errors
    /// [`Error::Recording`] where the file is damaged.
    pub fn each(
        &self,
        (from_s, to_s): (f64, f64),
        progress: &mut dyn FnMut(u64, u64),
        mut take: impl FnMut(f64, bool, &Sample<'_>),
    ) -> Result<(), Error> {
        match &self.of {
            Of::Csv { recording, columns } => {
                let times = recording.time_s();
                for (row, &time_s) in times.iter().enumerate() {
                    if (from_s..=to_s).contains(&time_s) {
                        take(time_s, false, &Sample::Row(recording, columns, row));
                    }
                }
            }
            Of::Session(session) => {
                let total = session.cycle_count();
                let mut cycles = session.cycles_between(from_s, to_s);
                let (mut done, mut expected) = (0u64, None);
                while let Some(cycle) = cycles.next().map_err(Error::Recording)? {
                    let missing = expected.is_some_and(|expected| cycle.head.cycle != expected);
                    expected = Some(cycle.head.cycle + 1);
                    take(session.time_s(&cycle.head), missing, &Sample::Cycle(cycle));
                    done += 1;
                    if done.is_multiple_of(4096) {
                        progress(done, total);
                    }
                }
            }
        }
        Ok(())
    }

    /// How the driver's loop did, where that was recorded.
    ///
    /// # Errors
    /// [`Error::Recording`] where the file is damaged.
    pub fn loop_figures(&self) -> Result<Vec<LoopFigures>, Error> {
        match &self.of {
            Of::Csv { .. } => Ok(Vec::new()),
            Of::Session(session) => session.loop_figures().map_err(Error::Recording),
        }
    }

    /// All names a quantity can be requested by.
    pub fn known(&self) -> impl Iterator<Item = &str> + Clone {
        self.fields.iter().map(String::as_str).filter(|name| *name != TIME)
    }
}
