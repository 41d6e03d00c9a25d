//! A table in CSV: one pass, row by row, in bounded memory, refusing whatever would make a simulation silently wrong.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use csv::{ByteRecord, ReaderBuilder, StringRecord, Terminator};

use crate::column::{Column, TIME, required_inputs};
use crate::error::{Error, Miscount, What};
use crate::options::Options;
use crate::recording::{MAX_DURATION_S, MIN_SAMPLES, Recording, check_input, check_range, missing_input};
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

/// Where the cells of one column of the file go.
struct Target {
    /// Place in the row.
    cell: usize,
    /// `None` = time.
    column: Option<Column>,
    /// As called in the file.
    foreign: String,
    scale: f64,
    offset: f64,
    /// Whether the rig file says what it is: then its unit is not doubted.
    mapped: bool,
    /// Whether the wire is driven by it.
    input: bool,
}

/// The values of a column, and their extremes with their lines.
#[derive(Clone)]
struct Values {
    all: Vec<f64>,
    low: (f64, u64),
    high: (f64, u64),
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
        let targets = self.targets(&header)?;
        self.rows(header.len(), &targets)
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

    /// What becomes of each column of the file; the time comes first.
    fn targets(&self, header: &[String]) -> Result<Vec<Target>, Error> {
        for (i, name) in header.iter().enumerate() {
            if header[..i].contains(name) && self.is_wanted(name) {
                let quantity = Column::from_name(name).map_or(TIME, Column::name);
                let error = self.here(What::DuplicateColumn { quantity, other: name.clone() });
                return Err(error.in_column(name));
            }
        }
        let inputs: Vec<Column> = self.options.model.map(|m| required_inputs(m).collect()).unwrap_or_default();
        let place = |name: &str| header.iter().position(|h| h == name);
        let mut targets: Vec<Target> = Vec::new();
        for column in std::iter::once(None).chain(Column::ALL.into_iter().map(Some)) {
            let quantity = column.map_or(TIME, Column::name);
            let map = self.options.columns.and_then(|m| m.get(quantity));
            let own = place(quantity).filter(|_| !self.is_foreign_source(quantity));
            let foreign = map.and_then(|m| Some((place(&m.column)?, m)));
            let (cell, scale, offset) = match (foreign, own) {
                (Some((cell, _)), Some(other)) if cell != other => {
                    let what = What::DuplicateColumn { quantity, other: header[other].clone() };
                    return Err(self.here(what).in_column(&header[cell]));
                }
                (Some((cell, map)), _) => (cell, map.scale, map.offset),
                (None, Some(cell)) => (cell, 1.0, 0.0),
                (None, None) if column.is_none() => {
                    return Err(self.here(What::MissingTimeColumn { present: header.to_vec() }));
                }
                (None, None) => continue,
            };
            let (mapped, input) = (foreign.is_some(), column.is_some_and(|c| inputs.contains(&c)));
            targets.push(Target { cell, column, foreign: header[cell].clone(), scale, offset, mapped, input });
        }
        let used = |cell: usize| targets.iter().any(|t| t.cell == cell);
        let mut unknown = header.iter().enumerate().filter(|(cell, _)| !used(*cell)).map(|(_, name)| name.clone());
        if !self.options.ignore_columns
            && let Some(first) = unknown.next()
        {
            let taken = |name: &str| targets.iter().any(|t| t.column.map_or(TIME, Column::name) == name);
            let nearest = suggest::nearest(&first).filter(|name| !taken(name));
            let what = What::UnknownColumn { nearest, others: unknown.collect() };
            return Err(self.here(what).in_column(first));
        }
        if let Some(model) = self.options.model {
            let missing = inputs.iter().find(|input| targets.iter().all(|t| t.column != Some(**input)));
            if let Some(&input) = missing {
                return Err(missing_input(self.name, input, model, header.to_vec()).at(self.line()));
            }
        }
        Ok(targets)
    }

    /// Whether a column of this name in the file means something to us.
    fn is_wanted(&self, name: &str) -> bool {
        !self.options.ignore_columns
            || name == TIME
            || Column::from_name(name).is_some()
            || self.is_foreign_source(name)
    }

    /// Whether the rig file maps a column of the file with this name to another quantity.
    fn is_foreign_source(&self, name: &str) -> bool {
        self.options.columns.is_some_and(|m| m.iter().any(|(quantity, c)| c.column == name && quantity != name))
    }

    /// The rows below a header of so many cells.
    fn rows(&mut self, cells: usize, targets: &[Target]) -> Result<Recording, Error> {
        let mut times: Vec<f64> = Vec::new();
        let empty = Values { all: Vec::new(), low: (f64::INFINITY, 0), high: (f64::NEG_INFINITY, 0) };
        let mut values = vec![empty; targets.len()];
        let mut row = ByteRecord::new();
        while self.next(&mut row)? {
            if row.len() != cells {
                return Err(self.miscounted(&row, cells));
            }
            if times.len() == self.options.max_rows {
                return Err(self.here(What::TooManyRows { limit: self.options.max_rows }));
            }
            for (target, values) in targets.iter().zip(&mut values) {
                let value = self.number(&row[target.cell], target)?;
                let checked = match target.column {
                    None => check_time(&times, value),
                    Some(column) if target.input => check_input(column, value, times[times.len() - 1]),
                    Some(_) if value.is_nan() => Ok(()),
                    Some(column) => check_range(column, value, false),
                };
                checked.map_err(|what| self.here(what).in_column(&target.foreign))?;
                if target.column.is_none() {
                    times.push(value);
                    continue;
                }
                values.all.push(value);
                if value < values.low.0 {
                    values.low = (value, self.line());
                }
                if value > values.high.0 {
                    values.high = (value, self.line());
                }
            }
        }
        match times.len() {
            0 => return Err(self.error(What::HeaderOnly)),
            found if found < MIN_SAMPLES => {
                return Err(self.error(What::TooFewSamples { found, least: MIN_SAMPLES }));
            }
            _ => {}
        }
        let mut columns: [Option<Vec<f64>>; Column::COUNT] = Default::default();
        for (target, values) in targets.iter().zip(values) {
            let Some(column) = target.column else { continue };
            self.check_unit(target, column, &values)?;
            columns[column.index()] = Some(values.all);
        }
        Ok(Recording::checked(self.name.to_string(), times, columns))
    }

    /// Is the column in the contract's unit? Asked once all of it is known.
    fn check_unit(&self, target: &Target, column: Column, values: &Values) -> Result<(), Error> {
        let Some(model) = self.options.model else { return Ok(()) };
        let (low, high) = (values.low.0, values.high.0);
        let (what, line) = match column {
            // an encoder's zero may be anywhere, its travel may not
            Column::PositionM if high - low > model.geometry.length_m => {
                let (found, line) = if high.abs() > low.abs() { values.high } else { values.low };
                (What::PositionTooLarge { found, wire_m: model.geometry.length_m }, line)
            }
            Column::TemperatureC | Column::AmbientC if !target.mapped => {
                // air is not that hot, and a wire that never comes near its transformation is not worth recording
                let plausible = match column {
                    Column::AmbientC => model.ambient_c.max(100.0) + 100.0,
                    _ => model.material.austenite_temperature_c.max(model.material.martensite_temperature_c) + 100.0,
                };
                if low <= plausible.max(200.0) || high > 900.0 || low > high {
                    return Ok(());
                }
                (What::Kelvin { lowest: low }, values.low.1)
            }
            _ => return Ok(()),
        };
        Err(self.error(what).at(line).in_column(&target.foreign))
    }

    /// A cell as a number in the contract's unit; NaN when it is empty or says so.
    fn number(&self, cell: &[u8], target: &Target) -> Result<f64, Error> {
        let found = || String::from_utf8_lossy(cell).trim().to_string();
        let wrong = |what: What| Err(self.here(what).in_column(&target.foreign));
        let text = std::str::from_utf8(cell).map(unquoted);
        if text.is_ok_and(|t| t.is_empty() || t.eq_ignore_ascii_case("nan")) {
            return Ok(f64::NAN);
        }
        let raw = text.ok().and_then(|t| t.parse::<f64>().ok()).filter(|raw| !raw.is_nan());
        let Some(raw) = raw else { return wrong(What::NotANumber { found: found() }) };
        let value = if target.mapped { raw * target.scale + target.offset } else { raw };
        if value.is_finite() { Ok(value) } else { wrong(What::Infinite { found: found() }) }
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

fn check_time(times: &[f64], found: f64) -> Result<(), What> {
    match (times.first(), times.last()) {
        _ if found.is_nan() => Err(What::MissingTime),
        (_, Some(&previous)) if found <= previous => Err(What::TimeNotIncreasing { previous, found }),
        (Some(&first), _) if found - first > MAX_DURATION_S => {
            Err(What::TooLong { found_s: found - first, limit_s: MAX_DURATION_S })
        }
        _ => Ok(()),
    }
}

/// A cell without the blanks and the quotes around it.
fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|c| c.strip_suffix('"')).unwrap_or(cell).trim()
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
