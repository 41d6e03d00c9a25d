//! CSV with the contract's columns: one channel a file, all files in one go through the session.

use std::path::PathBuf;

use sinew_recording::rows::Rows;
use sinew_recording::session::Session;
use sinew_recording::{Error, Writer};

/// One channel's file.
#[derive(Debug, Clone)]
pub struct CsvFile {
    /// The channel, by its index.
    pub channel: usize,
    /// Where it goes: `.csv` or `.csv.gz`.
    pub path: PathBuf,
}

/// Writes channels of a session, from one time to another (s), each into its file, which takes its name once it is whole. Gives the
/// rows written and the cycles that the session lacks in between.
///
/// # Errors
/// Where the session cannot be read or has no rows, or a file cannot be written.
pub fn csv(session: &Session, files: &[CsvFile], from_s: f64, to_s: f64) -> Result<(u64, u64), Error> {
    let mut rows = Vec::new();
    let mut writers = Vec::new();
    for file in files {
        let channel = Rows::new(session, file.channel, None)?;
        writers.push(Writer::create(&file.path, channel.columns())?);
        rows.push(channel);
    }
    // A row has its duty from the cycle before and its samples from the one after: some more cycles on either side.
    let margin_s = if session.about().rate_hz > 0.0 { 10.0 / session.about().rate_hz } else { 1.0 };
    let mut cycles = session.cycles_between(from_s - margin_s, f64::INFINITY);
    let mut written = 0;
    'cycles: while let Some(cycle) = cycles.next()? {
        for (rows, writer) in rows.iter_mut().zip(&mut writers) {
            if let Some((time_s, cells)) = rows.feed(&cycle)? {
                if time_s >= to_s {
                    break 'cycles;
                }
                if time_s >= from_s {
                    writer.row(time_s, cells)?;
                    written += 1;
                }
            }
        }
    }
    writers.into_iter().try_for_each(Writer::finish)?;
    Ok((written, rows.first().map_or(0, Rows::lost)))
}
