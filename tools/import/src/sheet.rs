//! Spreadsheets: .xlsx, .xlsm, .xlsb, .xls and .ods.

use std::io::Cursor;

use calamine::{Data, ExcelDateTime, Ods, Range, Reader, Sheets, Xls, Xlsb, Xlsx};
use sinew_rig::FileFormat;

use crate::contain::contained;
use crate::error::{Error, shorten};
use crate::grid::{Grid, Tally, understand};
use crate::numbers::{Cell, Dates, Moment, Style, cell};
use crate::table::Table;

type Book<'b> = Sheets<Cursor<&'b [u8]>>;

/// Days from Excel's day 0 to 1970.
const EPOCH: f64 = 25_569.0;

struct Sheet {
    range: Range<Data>,
    first_row: usize,
}

/// Reads the sheet of this name, or the one with most rows of numbers.
pub(crate) fn sheet(bytes: &[u8], given: &FileFormat) -> Result<Table, Error> {
    // calamine reads what programs write; over damaged files it can panic (0.38, in its .xls reader)
    contained(|| unguarded(bytes, given)).unwrap_or_else(|| {
        Err(Error::new(
            "is damaged: no spreadsheet can be read from it",
            "copy it again from where it came, or open it in the program that wrote it and save it again",
        ))
    })
}

fn unguarded(bytes: &[u8], given: &FileFormat) -> Result<Table, Error> {
    let (kind, opened) = open(bytes);
    let mut book = opened.map_err(damaged)?;
    let names = book.sheet_names();
    let wanted: Vec<String> = match &given.sheet {
        Some(name) if names.contains(name) => vec![name.clone()],
        Some(name) => {
            return Err(Error::new(format!("has no sheet \"{name}\""), format!("its sheets are {}", names.join(", "))));
        }
        None => names,
    };
    let style = Style { decimal: '.', dates: given.dates.as_deref().and_then(Dates::from_word).unwrap_or(Dates::Dmy) };
    let mut best: Option<(usize, String, Sheet)> = None;
    let mut others = Vec::new();
    for name in wanted {
        let range = book.worksheet_range(&name).map_err(damaged)?;
        let first_row = range.start().map_or(0, |(row, _)| row as usize);
        let sheet = Sheet { range, first_row };
        let rows = (0..sheet.count()).filter(|i| Tally::of(&sheet.row(*i, style)).is_data()).count();
        if rows > 0 {
            others.push(format!("\"{name}\" ({rows} rows)"));
        }
        if best.as_ref().is_none_or(|(most, ..)| rows > *most) {
            best = Some((rows, name, sheet));
        }
    }
    let Some((_, name, sheet)) = best else {
        return Err(Error::new("has no sheet with cells", "save the table in it and try again"));
    };
    // numbers that are text: "1,5" of a German program
    let style = if commas(&sheet) { Style { decimal: ',', ..style } } else { style };
    let mut table = understand(&sheet, format!("{kind}, sheet \"{name}\""), style, given)?;
    if others.len() > 1 {
        table.notes.push(format!(
            "several sheets have numbers, the largest is read: {}; --sheet names another",
            others.join(", ")
        ));
    }
    table.format.sheet = Some(name);
    table.format.decimal = (style.decimal == ',').then(|| ",".to_string());
    Ok(table)
}

fn damaged(error: calamine::Error) -> Error {
    let text = error.to_string().replace('\n', " ");
    let locked = text.to_lowercase().contains("password") || text.to_lowercase().contains("encrypt");
    let hint = match locked {
        true => "save it without a password",
        false => "open it in the program that wrote it and save it again, as .xlsx or as CSV",
    };
    Error::new(format!("cannot be read as a spreadsheet: {}", shorten(&text)), hint)
}

/// Which kind of spreadsheet it is, by what is in it, and the reader for that.
fn open(bytes: &[u8]) -> (&'static str, Result<Book<'_>, calamine::Error>) {
    let has = |words: &[u8]| bytes.windows(words.len()).any(|window| window == words);
    let from = Cursor::new(bytes);
    if !bytes.starts_with(b"PK") {
        return ("Excel (.xls)", Xls::new(from).map(Sheets::Xls).map_err(Into::into));
    }
    let start = &bytes[..bytes.len().min(200)];
    if start.windows(17).any(|window| window == b"vnd.oasis.opendoc") {
        ("OpenDocument (.ods)", Ods::new(from).map(Sheets::Ods).map_err(Into::into))
    } else if has(b"xl/workbook.bin") {
        ("Excel (.xlsb)", Xlsb::new(from).map(Sheets::Xlsb).map_err(Into::into))
    } else {
        ("Excel (.xlsx)", Xlsx::new(from).map(Sheets::Xlsx).map_err(Into::into))
    }
}

/// Whether more texts are numbers with a comma than with a point.
fn commas(sheet: &Sheet) -> bool {
    let texts = || sheet.range.used_cells().filter_map(|(.., data)| data.as_string_of_text()).take(2000);
    let count = |decimal| texts().filter(|text| crate::numbers::number(text, decimal).is_some()).count();
    count(',') > count('.')
}

/// The text of a cell that is one.
trait Text {
    fn as_string_of_text(&self) -> Option<&str>;
}

impl Text for Data {
    fn as_string_of_text(&self) -> Option<&str> {
        match self {
            Data::String(text) => Some(text),
            _ => None,
        }
    }
}

fn moment_of(at: &ExcelDateTime) -> Cell {
    let days = at.as_f64();
    if !days.is_finite() || days.abs() > 3e6 {
        return Cell::Missing;
    }
    // a serial number has no more than some microseconds of a day in it
    let seconds = |days: f64| (days * 86_400.0 * 1e5).round() / 1e5;
    // times of day and durations have no day
    Cell::Moment(match at.is_duration() || days < 1.0 {
        true => Moment { day: None, seconds: seconds(days), serial: Some(days) },
        false => {
            Moment { day: Some((days.floor() - EPOCH) as i64), seconds: seconds(days.fract()), serial: Some(days) }
        }
    })
}

impl Grid for Sheet {
    fn count(&self) -> usize {
        self.range.height()
    }

    fn row(&self, index: usize, style: Style) -> Vec<Cell> {
        if index >= self.range.height() {
            return Vec::new();
        }
        let row = &self.range[index];
        let mut cells: Vec<Cell> = row
            .iter()
            .map(|data| match data {
                Data::Float(number) if number.is_finite() => Cell::Number(*number),
                Data::Int(number) => Cell::Number(*number as f64),
                Data::String(text) | Data::DateTimeIso(text) => cell(text, style),
                Data::DateTime(at) => moment_of(at),
                Data::DurationIso(text) => duration(text).unwrap_or_else(|| cell(text, style)),
                Data::Bool(on) => Cell::Number(f64::from(u8::from(*on))),
                _ => Cell::Missing,
            })
            .collect();
        while cells.last() == Some(&Cell::Missing) {
            cells.pop();
        }
        cells
    }

    fn words(&self, index: usize) -> Vec<String> {
        if index >= self.range.height() {
            return Vec::new();
        }
        let row = &self.range[index];
        let mut words: Vec<String> =
            row.iter().map(|data| data.to_string().split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        while words.last().is_some_and(String::is_empty) {
            words.pop();
        }
        words
    }

    fn line(&self, index: usize) -> usize {
        self.first_row + index + 1
    }

    fn ragged(&self) -> bool {
        true
    }

    fn is_remark(&self, _: usize) -> bool {
        false
    }
}

/// `PT00H01M02.5S`, as OpenDocument writes times.
fn duration(text: &str) -> Option<Cell> {
    let mut rest = text.strip_prefix("PT")?;
    let mut seconds = 0.0;
    for (unit, factor) in [('H', 3600.0), ('M', 60.0), ('S', 1.0)] {
        if let Some((number, after)) = rest.split_once(unit) {
            seconds += number.replace(',', ".").parse::<f64>().ok()? * factor;
            rest = after;
        }
    }
    Some(Cell::Moment(Moment { day: None, seconds, serial: None })).filter(|_| rest.is_empty())
}
