//! A table in CSV: one pass, row by row, in bounded memory, refusing whatever would make a simulation silently wrong.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use csv::{ByteRecord, ReaderBuilder, StringRecord, Terminator};

use crate::column::TIME;
use crate::columns::Columns;
use crate::error::{Error, Miscount, What};
use crate::options::Options;
use crate::recording::Recording;
use crate::suggest;

/// Longest line that is read.
pub const MAX_LINE_BYTES: usize = 1 << 16;

/// Bytes requested of the system at a time.
pub(crate) const BUFFER_BYTES: usize = 1 << 16;

/// Passes text on up to the first line longer than [`MAX_LINE_BYTES`], and ends the last line if it is not ended.
struct Lines<R> {
    input: BufReader<R>,
    /// Bytes of the line being read.
    length: usize,
}

impl<R> Lines<R> {
    fn too_long(&self) -> bool {
        self.length > MAX_LINE_BYTES
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.too_long() {
            return Err(ErrorKind::FileTooLarge.into());
        }
        // so little at a time that no line becomes too long before its end is looked for
        let room = buffer.len().min(MAX_LINE_BYTES + 1 - self.length);
        let read = self.input.read(&mut buffer[..room])?;
        match buffer[..read].iter().rposition(|byte| *byte == b'\n') {
            Some(end) => self.length = read - end - 1,
            None if read == 0 && self.length > 0 && room > 0 => {
                buffer[0] = b'\n';
                self.length = 0;
                return Ok(1);
            }
            None => self.length += read,
        }
        Ok(read)
    }
}

/// Reads one table.
pub(crate) struct Reader<'a, R> {
    csv: csv::Reader<Lines<R>>,
    name: &'a str,
    options: &'a Options<'a>,
    gzip: bool,
}

impl<'a, R: Read> Reader<'a, R> {
    pub(crate) fn new(from: R, name: &'a str, options: &'a Options<'a>, gzip: bool) -> Self {
        let input = BufReader::with_capacity(BUFFER_BYTES, from);
        // a row is a line: nothing in a table of numbers needs quotes, and one left open would swallow the rest
        let csv = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .quoting(false)
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(BUFFER_BYTES)
            .from_reader(Lines { input, length: 0 });
        Reader { csv, name, options, gzip }
    }

    fn error(&self, what: What) -> Error {
        Error::new(self.name, what)
    }

    /// The number of the row's line: rows know where they were looked for, ahead of any blank lines.
    fn line(&self) -> u64 {
        self.csv.position().line() - 1
    }

    fn here(&self, what: What) -> Error {
        self.error(what).at(self.line())
    }

    /// The next row that is not blank; `false` at the end of the file.
    fn next(&mut self, row: &mut ByteRecord) -> Result<bool, Error> {
        while self.csv.read_byte_record(row).map_err(|e| self.broken(&e))? {
            if row.len() > 1 || !row[0].trim_ascii().is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What an error of the reader underneath means.
    fn broken(&self, error: &csv::Error) -> Error {
        let reason = error.to_string();
        let what = match error.kind() {
            _ if self.csv.get_ref().too_long() => What::LineTooLong { limit: MAX_LINE_BYTES },
            csv::ErrorKind::Io(e) if self.gzip => match e.kind() {
                ErrorKind::UnexpectedEof => What::TruncatedGzip,
                ErrorKind::InvalidData | ErrorKind::InvalidInput => What::CorruptGzip { reason },
                _ => What::Unreadable { reason },
            },
            _ => What::Unreadable { reason },
        };
        self.error(what).at(self.csv.position().line())
    }

    /// The whole of it.
    pub(crate) fn recording(mut self) -> Result<Recording, Error> {
        let header = self.header()?;
        let columns = Columns::new(self.name, self.options, &header, Some(self.line()))?;
        self.rows(header.len(), columns)
    }

    /// The names in the first line.
    fn header(&mut self) -> Result<Vec<String>, Error> {
        let foreign = self.csv.get_mut().input.fill_buf().map(foreign_kind);
        if let Some(found) = foreign.map_err(|e| self.broken(&e.into()))? {
            return Err(self.error(What::NotText { found }).at(1));
        }
        let mut row = ByteRecord::new();
        if !self.next(&mut row)? {
            return Err(self.error(What::Empty));
        }
        // Latin-1 has µ and ° as bytes no UTF-8 has
        let row =
            StringRecord::from_byte_record(row).map_err(|_| self.here(What::NotText { found: "not UTF-8 text" }))?;
        let names: Vec<String> = row.iter().map(|cell| unquoted(cell).to_string()).collect();
        if names.len() == 1 || !names.iter().any(|n| n == TIME) {
            let separators = [(';', "semicolons"), ('\t', "tabs"), ('|', "bars")];
            let text = row.as_slice().trim_end();
            if let Some((_, found)) = separators.into_iter().find(|(c, _)| text.contains(*c)) {
                return Err(self.here(What::WrongSeparator { found }));
            }
            if names.len() == 1 && names[0] != TIME && names[0].split_whitespace().any(|word| word == TIME) {
                return Err(self.here(What::WrongSeparator { found: "spaces" }));
            }
        }
        if names.iter().all(|n| n.parse::<f64>().is_ok()) {
            return Err(self.here(What::NoHeader { found: names[0].clone() }));
        }
        Ok(names)
    }

    /// The rows below a header of so many cells.
    fn rows(&mut self, cells: usize, mut columns: Columns<'_>) -> Result<Recording, Error> {
        let mut row = ByteRecord::new();
        while self.next(&mut row)? {
            if row.len() != cells {
                return Err(self.miscounted(&row, cells));
            }
            columns.row(Some(self.line()), |cell| number(&row[cell]))?;
        }
        columns.recording()
    }

    /// A row of the wrong length, and why it may be.
    fn miscounted(&mut self, row: &ByteRecord, expected: usize) -> Error {
        let (place, found) = (self.line(), row.len());
        let cells: Vec<_> = row.iter().map(String::from_utf8_lossy).collect();
        let text = cells.join(",");
        let text = text.trim_end();
        let separators = [(';', "semicolons"), ('\t', "tabs")];
        let enough = |c: char| expected > 1 && text.matches(c).count() + 1 >= expected;
        if let Some((_, separator)) = separators.into_iter().find(|(c, _)| enough(*c)) {
            return self.here(What::WrongSeparator { found: separator });
        }
        let quoted_comma = text.split('"').skip(1).step_by(2).any(suggest::decimal_comma);
        let whole = |cell: &str| cell.trim().trim_start_matches('-').bytes().all(|b| b.is_ascii_digit());
        let cause = if found == expected + 1 && text.ends_with(',') {
            Miscount::TrailingComma
        } else if quoted_comma || (found > expected && found <= 2 * expected && text.split(',').all(whole)) {
            Miscount::DecimalComma
        } else if found < expected && matches!(self.next(&mut ByteRecord::new()), Ok(false)) {
            // only the last row of a file that was cut off is short
            Miscount::CutOff
        } else {
            Miscount::Unknown
        };
        self.error(What::FieldCount { expected, found, cause }).at(place)
    }
}

/// A cell without the blanks and the quotes around it.
fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|c| c.strip_suffix('"')).unwrap_or(cell).trim()
}

/// A cell as the number it has; NaN when it is empty or says so.
fn number(cell: &[u8]) -> Result<f64, What> {
    let text = std::str::from_utf8(cell).map(unquoted);
    if text.is_ok_and(|t| t.is_empty() || t.eq_ignore_ascii_case("nan")) {
        return Ok(f64::NAN);
    }
    let raw = text.ok().and_then(|t| t.parse::<f64>().ok()).filter(|raw| !raw.is_nan());
    let found = || String::from_utf8_lossy(cell).trim().to_string();
    match raw {
        None => Err(What::NotANumber { found: found() }),
        Some(raw) if raw.is_infinite() => Err(What::Infinite { found: found() }),
        Some(raw) => Ok(raw),
    }
}

/// Which other kind of file begins like this, if it is not text.
fn foreign_kind(start: &[u8]) -> Option<&'static str> {
    match start {
        [0x89, b'M', b'C', b'A', b'P', ..] => Some("an MCAP file"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16 text"),
        [b'P', b'K', 3, 4, ..] => Some("a zip archive (a spreadsheet?)"),
        [b'M', b'A', b'T', b'L', b'A', b'B', b' ', ..] => Some("a MATLAB file"),
        [0x89, b'H', b'D', b'F', ..] => Some("an HDF5 file"),
        _ if start.iter().take(512).take_while(|b| **b != b'\n').any(|b| *b == 0) => Some("binary"),
        _ => None,
    }
}
