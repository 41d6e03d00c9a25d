//! A session of any table.

use std::io::BufWriter;
use std::path::Path;

use sinew_recording::session::{Ended, SessionWriter, WriteOptions};
use sinew_recording::{Error, Part};

use crate::table::Table;
use crate::unwritable;

/// Writes all cycles as a session in MCAP; a file of that name is replaced once the new one is whole. Gives how many there are.
///
/// # Errors
/// Where the table cannot be read or the file not be written.
pub fn session(table: &dyn Table, path: &Path) -> Result<u64, Error> {
    let (part, file) = Part::create(path).map_err(|e| unwritable(path, &e))?;
    let options = WriteOptions::new(path.to_string_lossy());
    let mut writer = SessionWriter::create(BufWriter::new(file), table.about(), table.layout(), options)?;
    let mut cycles = 0;
    table.each(&mut |cycle| {
        cycles += 1;
        writer.cycle(&cycle.head, cycle.bytes)
    })?;
    let file = writer.finish(Ended::Complete)?.into_inner().map_err(|e| unwritable(path, e.error()))?;
    part.publish(&file).map_err(|e| unwritable(path, &e))?;
    Ok(cycles)
}
