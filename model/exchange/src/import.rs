//! A recording of another lab as a session: its rows are the cycles, its columns the fields, and its times are kept to the
//! last bit in a field of their own.

use sinew_recording::session::{About, Field, Head, Layout};
use sinew_recording::{Error, Recording, TIME, What};

use crate::table::{Cycle, Table};

/// Kind of such a session.
pub const IMPORT: &str = "import";

/// A recording in memory, as a table of one channel.
#[derive(Debug)]
pub struct Imported {
    recording: Recording,
    about: About,
    layout: Layout,
}

impl Imported {
    /// Of a recording of this channel. `about` says where it comes from; its kind becomes [`IMPORT`], its rate that of the rows.
    ///
    /// # Errors
    /// A channel's name that no session can have.
    pub fn new(recording: Recording, channel: &str, about: About) -> Result<Imported, Error> {
        let columns = recording.columns().map(|(column, _)| Field::f64(column.name(), column.unit()));
        let fields = std::iter::once(Field::f64(TIME, "s")).chain(columns).collect();
        let layout = Layout::new(vec![channel.to_string()], fields).map_err(|trouble| Error {
            file: recording.name().into(),
            line: None,
            column: None,
            what: What::Session(trouble),
        })?;
        let about = About { kind: IMPORT.into(), rate_hz: 1.0 / recording.median_interval_s(), ..about };
        Ok(Imported { recording, about, layout })
    }

    /// The recording itself.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }
}

impl Table for Imported {
    fn about(&self) -> &About {
        &self.about
    }

    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn each(&self, see: &mut dyn FnMut(&Cycle<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let times = self.recording.time_s();
        let columns: Vec<&[f64]> = self.recording.columns().map(|(_, values)| values).collect();
        let mut bytes = Vec::with_capacity(self.layout.stride());
        for (row, &time_s) in times.iter().enumerate() {
            bytes.clear();
            bytes.extend(time_s.to_le_bytes());
            columns.iter().for_each(|values| bytes.extend(values[row].to_le_bytes()));
            // the clock of viewers; the field has the time itself
            let since_ns = ((time_s - times[0]) * 1e9).round() as u64;
            let head = Head {
                cycle: row as u64 + 1,
                monotonic_ns: self.about.started_monotonic_ns.saturating_add(since_ns),
                missed: 0,
            };
            see(&Cycle { head, time_s, bytes: &bytes })?;
        }
        Ok(())
    }

    fn count(&self) -> u64 {
        self.recording.len() as u64
    }
}
