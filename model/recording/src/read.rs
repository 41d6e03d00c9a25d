//! Reading CSV: one pass, row by row, in bounded memory, refusing whatever would make a simulation silently wrong.

use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, StringRecord, Terminator};
use flate2::bufread::MultiGzDecoder;
use sinew_physics::WireModel;
use sinew_rig::ColumnMap;

use crate::column::{Column, TIME, required_inputs};
use crate::error::{Error, Miscount, What};
use crate::recording::{MAX_DURATION_S, MIN_SAMPLES, Recording, check_input, check_range, missing_input};
use crate::session::Session;
use crate::{rows, suggest};

/// Most rows a recording is read to by default: 83 minutes at 1 kHz, and at most 0.5 GB with every column there is.
pub const MAX_ROWS: usize = 5_000_000;
/// Longest line that is read.
pub const MAX_LINE_BYTES: usize = 1 << 16;
/// Bytes asked of the system at a time.
const BUFFER_BYTES: usize = 1 << 16;

/// How to read a recording.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Pass over columns the contract does not know instead of refusing them.
    pub ignore_columns: bool,
    /// Foreign names and units, from the rig file. A name that is in the file under the contract's own name only is
    /// taken as it is.
    pub columns: Option<&'a ColumnMap>,
    /// The wire it was recorded on: its inputs must then be there and complete, and its elongation possible.
    pub model: Option<&'a WireModel>,
    /// Most rows, [`MAX_ROWS`] by default; a file with more is refused.
    pub max_rows: usize,
    /// Which channel of a session with several.
    pub channel: Option<&'a str>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options { ignore_columns: false, columns: None, model: None, max_rows: MAX_ROWS, channel: None }
    }
}

/// Whether a file of this name is to be gzipped.
pub(crate) fn is_gz(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

/// Whether a file of this name is to be a session.
pub(crate) fn is_mcap(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
}

/// Reads a `.csv`, a `.csv.gz`, or one channel of a session (`.mcap`), see [`crate::rows`].
///
/// # Errors
/// Whatever is wrong first, with file, line, column and remedy.
pub fn read(path: impl AsRef<Path>, options: &Options<'_>) -> Result<Recording, Error> {
    let path = path.as_ref();
    let name = path.to_string_lossy();
    let unreadable = |e: io::Error| Error::new(&name, What::Unreadable { reason: e.to_string() });
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(unreadable(ErrorKind::IsADirectory.into()));
    }
    let mut file = BufReader::with_capacity(BUFFER_BYTES, file);
    // the first bytes of a file arrive together, only a pipe may split them
    let start = file.fill_buf().map_err(unreadable)?;
    let compressed = start.starts_with(&[0x1f, 0x8b]);
    if is_mcap(path) || start.starts_with(&[0x89, b'M', b'C', b'A', b'P']) {
        return rows::recording(&Session::open(path)?, options);
    }
    match (start.is_empty(), is_gz(path), compressed) {
        (true, ..) => Err(Error::new(&name, What::Empty)),
        (_, true, false) => Err(Error::new(&name, What::NotGzip)),
        (_, false, true) => Err(Error::new(&name, What::UnexpectedGzip)),
        (_, true, true) => Reader::new(MultiGzDecoder::new(file), &name, options, true).recording(),
        (_, false, false) => Reader::new(file, &name, options, false).recording(),
    }
}

/// Reads CSV text from anything; `name` is what messages call it.
///
/// # Errors
/// As [`read`].
pub fn read_from(from: impl Read, name: &str, options: &Options<'_>) -> Result<Recording, Error> {
    Reader::new(from, name, options, false).recording()
}

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

struct Reader<'a, R> {
    csv: csv::Reader<Lines<R>>,
    name: &'a str,
    options: &'a Options<'a>,
    gzip: bool,
}

impl<'a, R: Read> Reader<'a, R> {
    fn new(from: R, name: &'a str, options: &'a Options<'a>, gzip: bool) -> Self {
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

    fn recording(mut self) -> Result<Recording, Error> {
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

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::PathBuf;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use proptest::prelude::*;
    use sinew_physics::{DriveKind, Load};

    use super::*;
    use crate::error::Needed;
    use crate::testing::model;

    fn text(text: &str) -> Result<Recording, Error> {
        let model = model();
        read_from(text.as_bytes(), "lab.csv", &Options { model: Some(&model), ..Options::default() })
    }

    /// The error of `text`, checked to name the file and the given place, and to have a remedy.
    fn wrong(content: &str, line: Option<u64>, column: Option<&str>) -> What {
        let error = text(content).expect_err(content);
        assert_eq!((error.line, error.column.as_deref()), (line, column), "{error}");
        assert!(error.file == "lab.csv" && !error.hint().is_empty() && error.is_bad_input(), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
        error.what
    }

    const GOOD: &str = "time_s,duty,position_m\n0,0,0.001\n0.1,0.5,\n0.3,1,nan\n";

    #[test]
    fn a_good_file_is_read() {
        let r = text(GOOD).unwrap();
        assert_eq!(r.time_s(), [0.0, 0.1, 0.3]);
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.5, 1.0]);
        let position = r.get(Column::PositionM).unwrap();
        assert!(position[0] == 0.001 && position[1].is_nan() && position[2].is_nan());
        assert_eq!(r.get(Column::ForceN), None);
        assert_eq!(r.columns().count(), 2);
    }

    #[test]
    fn marks_blanks_quotes_and_line_ends_do_no_harm() {
        let spoilt =
            format!("\u{feff}{}", GOOD.replace('\n', "\r\n").replace("time_s", "\"time_s\"").replace("0.5", " 0.5 "));
        assert_eq!(text(&spoilt).unwrap().time_s(), text(GOOD).unwrap().time_s());
        assert_eq!(text(&format!("\n{GOOD}\n\n  \n")).unwrap().len(), 3);
        assert_eq!(text(GOOD.trim_end()).unwrap().len(), 3);
    }

    #[test]
    fn too_little_is_refused() {
        assert_eq!(wrong("", None, None), What::Empty);
        assert_eq!(wrong("\n\r\n", None, None), What::Empty);
        assert_eq!(wrong("time_s,duty\n", None, None), What::HeaderOnly);
        assert_eq!(wrong("time_s,duty\n0,0\n1,0\n", None, None), What::TooFewSamples { found: 2, least: 3 });
    }

    #[test]
    fn the_columns_must_be_right() {
        let error = text("t_ms,duty\n0,0\n").unwrap_err();
        assert!(matches!(error.what, What::MissingTimeColumn { .. }));
        assert!(error.hint().contains("time_s = { column = \"t_ms\", scale = 0.001 }"), "{error}");
        assert!(matches!(wrong("duty,force_n\n0,0\n", Some(1), None), What::MissingTimeColumn { .. }));

        let what = wrong("time_s,power_w\n0,0\n", Some(1), None);
        let because = Needed::Drive(DriveKind::Pwm);
        let present = vec!["time_s".to_string(), "power_w".to_string()];
        assert_eq!(what, What::MissingInput { input: Column::Duty, because, present });
        let error = text("time_s,power_w\n0,0\n").unwrap_err();
        assert!(error.hint().contains("kind = \"power\""), "{error}");

        let what = wrong("time_s,duty,positon_m,foo\n0,0,0,0\n", Some(1), Some("positon_m"));
        let nearest = Some("position_m");
        assert_eq!(what, What::UnknownColumn { nearest, others: vec!["foo".to_string()] });
        assert!(text("time_s,duty,foo\n0,0\n").unwrap_err().hint().contains("--ignore-columns"));

        let what = wrong("time_s,duty,duty\n0,0,0\n", Some(1), Some("duty"));
        assert!(matches!(what, What::DuplicateColumn { quantity: "duty", .. }));
        let what = wrong("0,0.5\n1,0.5\n", Some(1), None);
        assert!(matches!(what, What::NoHeader { .. }));
    }

    #[test]
    fn ignored_columns_are_not_even_parsed() {
        let options = Options { ignore_columns: true, ..Options::default() };
        let content = "time_s,note,note,duty\n0,a,b,0\n1,,\u{e4},0\n2,x,inf,0.5\n";
        let r = read_from(content.as_bytes(), "x", &options).unwrap();
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.0, 0.5]);
    }

    #[test]
    fn cells_must_be_numbers() {
        let what = wrong("time_s,duty\n0,0\n1,0.5x\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::NotANumber { found: "0.5x".into() });
        for bad in ["inf", "-Infinity", "1e999"] {
            let what = wrong(&format!("time_s,duty,force_n\n0,0,0\n1,0,{bad}\n2,0,0\n"), Some(3), Some("force_n"));
            assert_eq!(what, What::Infinite { found: bad.into() });
        }
        let what = wrong("time_s,duty\n0,0\n,0\n2,0\n", Some(3), Some("time_s"));
        assert_eq!(what, What::MissingTime);
        let what = wrong("time_s,duty\n0,0\n1,\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::MissingSample { time_s: 1.0 });
    }

    #[test]
    fn rows_must_be_whole() {
        let what = wrong("time_s,duty,force_n\n0,0,0\n\n1,0\n2,0,0\n", Some(4), None);
        assert_eq!(what, What::FieldCount { expected: 3, found: 2, cause: Miscount::Unknown });
        let what = wrong("time_s,duty,force_n\n0,0,0\n1,0\n", Some(3), None);
        assert_eq!(what, What::FieldCount { expected: 3, found: 2, cause: Miscount::CutOff });
        let what = wrong("time_s,duty\n0,0,\n1,0,\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 3, cause: Miscount::TrailingComma });
    }

    #[test]
    fn other_countries_files_are_recognised() {
        assert_eq!(wrong("time_s;duty\n0;0\n", Some(1), None), What::WrongSeparator { found: "semicolons" });
        assert_eq!(wrong("time_s\tduty\n0\t0\n", Some(1), None), What::WrongSeparator { found: "tabs" });
        assert_eq!(wrong("time_s duty\n0 0\n", Some(1), None), What::WrongSeparator { found: "spaces" });
        assert_eq!(wrong("time_s,duty\n0,0;0,5\n", Some(2), None), What::WrongSeparator { found: "semicolons" });
        let what = wrong("time_s,duty\n0,0,0,5\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 4, cause: Miscount::DecimalComma });
        let what = wrong("time_s,duty\n0,\"0,5\"\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 3, cause: Miscount::DecimalComma });
        let bytes = [b"\xff\xfet\0i\0m\0e\0".as_slice(), b"PK\x03\x04....", b"\x89MCAP0\r\n", b"a\0b"];
        for kind in bytes {
            let error = read_from(kind, "x", &Options::default()).unwrap_err();
            assert!(matches!(error.what, What::NotText { .. }), "{error}");
        }
        let latin = b"time_s,duty,\xb5m\n";
        assert!(matches!(read_from(&latin[..], "x", &Options::default()).unwrap_err().what, What::NotText { .. }));
    }

    #[test]
    fn time_must_increase_and_end() {
        let what = wrong("time_s,duty\n0,0\n1,0\n1,0\n", Some(4), Some("time_s"));
        assert_eq!(what, What::TimeNotIncreasing { previous: 1.0, found: 1.0 });
        let what = wrong("time_s,duty\n0,0\n1,0\n0.5,0\n", Some(4), Some("time_s"));
        assert_eq!(what, What::TimeNotIncreasing { previous: 1.0, found: 0.5 });
        let what = wrong("time_s,duty\n0,0\n1,0\n5e6,0\n", Some(4), Some("time_s"));
        assert!(matches!(what, What::TooLong { .. }));
    }

    #[test]
    fn units_that_cannot_be_meant_are_refused() {
        let what = wrong("time_s,duty\n0,0\n1,50\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::DutyOutOfRange { found: 50.0 });
        assert!(text("time_s,duty\n0,0\n1,50\n").unwrap_err().hint().contains("scale = 0.01"));
        wrong("time_s,duty\n0,-0.1\n", Some(2), Some("duty"));

        let what = wrong("time_s,duty,position_m\n0,0,7\n1,0,3.5\n2,0,7.1\n", Some(4), Some("position_m"));
        assert_eq!(what, What::PositionTooLarge { found: 7.1, wire_m: 0.16 });
        // an encoder's arbitrary zero is not a unit
        assert!(text("time_s,duty,position_m\n0,0,7\n1,0,7.003\n2,0,7.005\n").is_ok());

        let what = wrong("time_s,duty,ambient_c\n0,0,298\n1,0,297.5\n2,0,299\n", Some(3), Some("ambient_c"));
        assert_eq!(what, What::Kelvin { lowest: 297.5 });
        let what = wrong("time_s,duty,temperature_c\n0,0,298\n1,0,350\n2,0,370\n", Some(2), Some("temperature_c"));
        assert_eq!(what, What::Kelvin { lowest: 298.0 });
        assert!(text("time_s,duty,temperature_c\n0,0,20\n1,0,250\n2,0,370\n").is_ok());
        wrong("time_s,duty,temperature_c\n0,0,-300\n", Some(2), Some("temperature_c"));
    }

    #[test]
    fn negative_power_is_refused_only_as_an_input() {
        let content = "time_s,duty,power_w\n0,0,-0.001\n1,0,0\n2,0,1\n";
        assert!(text(content).is_ok());
        let mut model = model();
        model.drive.kind = DriveKind::Power;
        let options = Options { model: Some(&model), ..Options::default() };
        let error = read_from(content.as_bytes(), "x", &options).unwrap_err();
        assert_eq!(error.what, What::NegativePower { found: -0.001 });
    }

    #[test]
    fn foreign_names_are_mapped_and_scaled() {
        let map: ColumnMap = [
            ("time_s", "t", 1e-3, 0.0),
            ("position_m", "Pos", -1e-3, 0.01),
            ("duty", "PWM", 0.01, 0.0),
            ("temperature_c", "temperature_c", 1.0, -273.15),
        ]
        .into_iter()
        .map(|(to, column, scale, offset)| {
            (to.to_string(), sinew_rig::Column { column: column.to_string(), scale, offset })
        })
        .collect();
        let model = model();
        let options = Options { columns: Some(&map), model: Some(&model), ..Options::default() };
        let content = "t,Pos,PWM,temperature_c\n0,1,0,298.15\n100,2,50,300\n200,3,100,301\n";
        let r = read_from(content.as_bytes(), "x", &options).unwrap();
        assert!((r.time_s()[1] - 0.1).abs() < 1e-15);
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.5, 1.0]);
        assert!((r.get(Column::PositionM).unwrap()[0] - 0.009).abs() < 1e-15);
        assert!((r.get(Column::TemperatureC).unwrap()[0] - 25.0).abs() < 1e-9);
        // our own files go with the same rig
        assert_eq!(read_from(GOOD.as_bytes(), "x", &options).unwrap().len(), 3);
        let both = "time_s,duty,PWM\n0,0,0\n";
        let error = read_from(both.as_bytes(), "x", &options).unwrap_err();
        assert!(matches!(error.what, What::DuplicateColumn { quantity: "duty", .. }), "{error}");
        let error = read_from("t,PWM\n0,0\n1,500\n".as_bytes(), "x", &options).unwrap_err();
        assert_eq!((error.line, error.column.as_deref()), (Some(3), Some("PWM")), "{error}");
    }

    #[test]
    fn exchanged_names_are_exchanged() {
        let entry = |column: &str| sinew_rig::Column { column: column.to_string(), scale: 1.0, offset: 0.0 };
        let map: ColumnMap =
            [("v1_v".to_string(), entry("v2_v")), ("v2_v".to_string(), entry("v1_v"))].into_iter().collect();
        let options = Options { columns: Some(&map), ..Options::default() };
        let r = read_from("time_s,v1_v,v2_v\n0,1,2\n1,1,2\n2,1,2\n".as_bytes(), "x", &options).unwrap();
        assert_eq!((r.get(Column::V1V).unwrap()[0], r.get(Column::V2V).unwrap()[0]), (2.0, 1.0));
    }

    #[test]
    fn lines_are_counted_whatever_ends_them() {
        for end in ["\n", "\r\n"] {
            for last in ["", end] {
                let content = ["", "time_s,duty", "", "", "0,0", "  ", "1,x"].join(end) + last;
                assert_eq!(wrong(&content, Some(7), Some("duty")), What::NotANumber { found: "x".into() });
            }
        }
        // good lines that arrive together with one that is too long are still counted
        let body = |long: usize| format!("time_s,duty\n0,0\n1,0\n2,0{}\n3,0\n", " ".repeat(long - 3));
        assert!(text(&body(MAX_LINE_BYTES)).is_ok());
        assert_eq!(wrong(&body(MAX_LINE_BYTES + 1), Some(4), None), What::LineTooLong { limit: MAX_LINE_BYTES });
    }

    #[test]
    fn rows_and_lines_have_a_limit() {
        let rows: String = (0..11).map(|i| format!("{i},0\n")).collect();
        let content = format!("time_s,duty\n{rows}");
        let options = Options { max_rows: 10, ..Options::default() };
        let error = read_from(content.as_bytes(), "x", &options).unwrap_err();
        assert_eq!((error.line, error.what), (Some(12), What::TooManyRows { limit: 10 }));
        // memory stays bounded however long the line is: this one never ends
        let endless = "time_s,duty\n".as_bytes().chain(io::repeat(b'7'));
        let error = read_from(endless, "x", &Options::default()).unwrap_err();
        assert_eq!((error.line, error.what), (Some(2), What::LineTooLong { limit: MAX_LINE_BYTES }));
        let error = read_from(io::repeat(0), "x", &Options::default()).unwrap_err();
        assert!(matches!(error.what, What::NotText { .. }), "{error}");
    }

    fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        (folder, path)
    }

    fn gzip(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn compression_must_be_what_the_name_says() {
        let what = |name: &str, content: &[u8]| {
            let (_folder, path) = file(name, content);
            let error = read(&path, &Options::default()).unwrap_err();
            assert!(error.file.ends_with(name), "{error}");
            error.what
        };
        let packed = gzip(GOOD.as_bytes());
        assert_eq!(what("a.csv.gz", GOOD.as_bytes()), What::NotGzip);
        assert_eq!(what("a.csv", &packed), What::UnexpectedGzip);
        assert_eq!(what("a.csv.gz", b""), What::Empty);
        assert_eq!(what("a.csv.gz", &gzip(b"")), What::Empty);
        for cut in 2..packed.len() {
            assert_eq!(what("a.csv.gz", &packed[..cut]), What::TruncatedGzip, "cut at {cut}");
        }
        let mut damaged = packed.clone();
        let crc = damaged.len() - 6;
        damaged[crc] ^= 0xff;
        assert!(matches!(what("a.csv.gz", &damaged), What::CorruptGzip { .. }));
        let (_folder, path) = file("two.csv.gz", &[packed, gzip(b"0.4,0,\n")].concat());
        assert_eq!(read(&path, &Options::default()).unwrap().len(), 4, "gzip files may be put end to end");
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let error = read(folder.path(), &Options::default()).unwrap_err();
        assert!(matches!(error.what, What::Unreadable { .. }), "{error}");
        let error = read(folder.path().join("none.csv"), &Options::default()).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("none.csv: cannot be read"), "{error}");
    }

    /// A number as labs write them, or rubbish.
    fn cell() -> impl Strategy<Value = String> {
        prop_oneof![
            4 => (-2.0f64..2.0).prop_map(|v| format!("{v}")),
            1 => any::<f64>().prop_map(|v| format!("{v}")),
            1 => Just(String::new()),
            1 => "[0-9.,;\"eE+-]{0,6}",
            1 => "\\PC{0,4}",
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]
        #[test]
        fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), ignore in any::<bool>()) {
            let model = model();
            let options = Options { ignore_columns: ignore, model: Some(&model), ..Options::default() };
            if let Err(error) = read_from(&bytes[..], "x", &options) {
                prop_assert!(!error.to_string().contains('\n') && !error.hint().is_empty());
            }
        }

        #[test]
        fn arbitrary_rows_below_a_good_header_never_panic(
            rows in prop::collection::vec(prop::collection::vec(cell(), 1..6), 0..12),
            imposed in any::<bool>(),
        ) {
            let mut model = model();
            if imposed {
                model.load = Load::ImposedForce;
            }
            let options = Options { model: Some(&model), ..Options::default() };
            let body: String = rows.iter().map(|r| r.join(",") + "\n").collect();
            let content = format!("time_s,duty,force_n,position_m\n{body}");
            match read_from(content.as_bytes(), "x", &options) {
                Ok(r) => {
                    prop_assert!(r.time_s().windows(2).all(|w| w[0] < w[1]));
                    prop_assert!(r.columns().all(|(_, v)| v.iter().all(|x| !x.is_infinite())));
                    prop_assert!(r.inputs_for(&model).unwrap().all(|(i, dt)| dt > 0.0 && i.drive.is_finite()));
                }
                Err(error) => prop_assert!(!error.to_string().contains('\n') && !error.hint().is_empty()),
            }
        }

        #[test]
        fn damaged_gzip_never_panics(place in any::<prop::sample::Index>(), flip in 1u8..) {
            let mut packed = gzip(GOOD.as_bytes());
            let place = place.index(packed.len());
            packed[place] ^= flip;
            let (_folder, path) = file("a.csv.gz", &packed);
            let _ = read(&path, &Options::default());
        }
    }
}
