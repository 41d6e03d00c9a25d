//! A grid of cells, be it of a text or of a spreadsheet, taken apart: what stands above the table, its names and units, its
//! rows, and what stands below.

use sinew_rig::FileFormat;

use crate::error::{Error, shorten};
use crate::numbers::{Cell, Dates, Moment, Style, cell, is_grouped, moment};
use crate::table::{Column, Table, name_all};
use crate::units::{self, named, unit};

/// Rows of cells.
pub(crate) trait Grid {
    /// How many there are.
    fn count(&self) -> usize;
    /// The cells of one.
    fn row(&self, index: usize, style: Style) -> Vec<Cell>;
    /// The cells of one as they are written.
    fn words(&self, index: usize) -> Vec<String>;
    /// The line (row) of the file it begins in, from 1.
    fn line(&self, index: usize) -> usize;
    /// Whether rows may end before their last cells.
    fn ragged(&self) -> bool;
    /// Whether it says that it is a remark.
    fn is_remark(&self, index: usize) -> bool;
}

/// Rows that are looked through for the beginning of the table.
const LOOKED_THROUGH: usize = 4000;

/// A row's cells by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Tally {
    pub cells: usize,
    pub numbers: usize,
    pub words: usize,
}

impl Tally {
    pub(crate) fn of(cells: &[Cell]) -> Tally {
        let mut tally = Tally { cells: cells.len(), ..Tally::default() };
        for cell in cells {
            match cell {
                Cell::Number(_) | Cell::Moment(_) => tally.numbers += 1,
                Cell::Text(_) => tally.words += 1,
                Cell::Missing => {}
            }
        }
        tally
    }

    /// Whether it may be a row of a table: numbers, and not more words than numbers.
    pub(crate) fn is_data(&self) -> bool {
        self.numbers > 0 && self.words <= self.numbers
    }
}

/// The longest run of rows that may be a table of one width: from, to (exclusive).
pub(crate) fn longest_run(tallies: &[Option<Tally>], ragged: bool) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize, usize)> = None;
    let mut run: Option<(usize, usize, usize)> = None; // from, rows, width
    let mut end = 0;
    for (i, tally) in tallies.iter().enumerate().chain([(tallies.len(), &Some(Tally::default()))]) {
        let Some(tally) = tally else { continue }; // blank lines and remarks interrupt nothing
        let goes_on =
            run.is_some_and(|(.., width)| tally.cells == width || (ragged && tally.cells <= width.max(1) + 1));
        match (&mut run, tally.is_data()) {
            (Some((_, rows, _)), true) if goes_on => (*rows, end) = (*rows + 1, i + 1),
            _ => {
                if let Some((from, rows, _)) = run
                    && best.is_none_or(|(_, _, most)| rows > most)
                {
                    best = Some((from, end, rows));
                }
                run = tally.is_data().then_some((i, 1, tally.cells));
                end = i + 1;
            }
        }
    }
    best.map(|(from, to, _)| (from, to))
}

/// Takes a grid apart.
pub(crate) fn understand(grid: &dyn Grid, kind: String, style: Style, given: &FileFormat) -> Result<Table, Error> {
    let index_of = |line: usize| (0..grid.count()).find(|i| grid.line(*i) >= line);
    let (first, names_from) = match given.first_line {
        Some(line) => {
            let first = index_of(line).ok_or_else(|| beyond("first_line", line, grid.count()))?;
            (first, given.header_line)
        }
        None => {
            let looked = grid.count().min(LOOKED_THROUGH);
            let tallies: Vec<Option<Tally>> = (0..looked)
                .map(|i| Some(Tally::of(&grid.row(i, style))).filter(|t| t.numbers + t.words > 0 && !grid.is_remark(i)))
                .collect();
            let (first, _) = longest_run(&tallies, grid.ragged()).ok_or_else(|| nothing(grid))?;
            (first, given.header_line)
        }
    };
    let width = (first..grid.count().min(first + 200))
        .filter(|i| !grid.is_remark(*i))
        .map(|i| grid.row(i, style))
        .filter(|row| Tally::of(row).is_data())
        .map(|row| row.len())
        .fold(0, |most, cells| if most == 0 || grid.ragged() { most.max(cells) } else { most });
    if width == 0 {
        return Err(nothing(grid).at(grid.line(first)));
    }
    let header = match names_from {
        Some(0) => Header::default(),
        Some(line) => {
            let from = index_of(line).ok_or_else(|| beyond("header_line", line, grid.count()))?;
            Header::of((from..first).collect(), grid, width, style)
        }
        None => Header::above(first, grid, width, style),
    };
    let mut notes = Vec::new();
    let above = header.from.unwrap_or(first);
    let remarks: Vec<usize> = (0..above).filter(|i| grid.words(*i).iter().any(|w| !w.trim().is_empty())).collect();
    if let (Some(from), Some(to)) = (remarks.first(), remarks.last()) {
        notes.push(format!("{} above the table passed over", lines(grid.line(*from), grid.line(*to))));
    }
    let dates = Dates::from_word(given.dates.as_deref().unwrap_or_default());
    let mut rows = Rows { cells: Vec::new(), lines: Vec::new(), indices: Vec::new(), width };
    rows.take(grid, first, style, &header, &mut notes)?;
    let format = FileFormat {
        header_line: Some(header.from.map_or(0, |from| grid.line(from))),
        first_line: Some(grid.line(first)),
        ..FileFormat::default()
    };
    let mut table = Table { kind, columns: Vec::new(), format, rate_hz: None, notes, lines: rows.lines.clone() };
    rows.columns(grid, header, style, dates, &mut table)?;
    let facts = Facts::of((0..above).map(|i| grid.words(i)), style);
    facts.into(&mut table);
    name_all(&mut table.columns);
    Ok(table)
}

fn lines(from: usize, to: usize) -> String {
    if from == to { format!("line {from}") } else { format!("lines {from} to {to}") }
}

fn beyond(key: &str, line: usize, count: usize) -> Error {
    Error::new(
        format!("{key} = {line} is beyond its end: it has {count} lines"),
        "leave the key out of [recording.format], and the line is found",
    )
}

fn nothing(grid: &dyn Grid) -> Error {
    let found = (0..grid.count()).flat_map(|i| grid.words(i)).find(|w| !w.trim().is_empty()).unwrap_or_default();
    Error::new(
        format!("has no rows of numbers in it; it begins with \"{}\"", shorten(found.trim())),
        "give a table with a row a sample and a column a quantity, the names above; other programs write that as CSV",
    )
}

/// Names and units above a table.
#[derive(Debug, Default)]
struct Header {
    /// Its first row.
    from: Option<usize>,
    names: Vec<String>,
    units: Vec<String>,
    /// The row the names are in, cell by cell, by which it is known when it comes again.
    row: Vec<String>,
}

/// A cell of a header without the sign of a remark before it.
fn bare(word: &str) -> &str {
    let word = word.trim();
    // a sign alone is a unit: per cent
    if word == "%" {
        return word;
    }
    word.trim_start_matches(['#', '%', '!']).trim_start_matches("//").trim()
}

fn is_units(words: &[String]) -> bool {
    let filled: Vec<&str> = words.iter().map(|w| bare(w)).filter(|w| !w.is_empty() && *w != "-").collect();
    let plain = |w: &str| {
        let known = unit(w).is_some();
        known
            && !(w.len() > 3
                && units::plain(w) == w.to_lowercase()
                && w.chars().all(char::is_alphabetic)
                && w.chars().count() > 7)
    };
    !filled.is_empty() && filled.iter().all(|w| plain(w))
}

impl Header {
    /// What stands directly above the table.
    fn above(first: usize, grid: &dyn Grid, width: usize, style: Style) -> Header {
        // up to four rows that are as wide as the table, nearest first
        let mut rows = Vec::new();
        for i in (0..first).rev() {
            let words = fitted(grid.words(i), width);
            let filled = words.iter().filter(|w| !w.trim().is_empty()).count();
            if filled == 0 {
                if rows.is_empty() {
                    continue;
                }
                break;
            }
            let tally = Tally::of(&grid.row(i, style));
            let wide =
                words.len() == width || (words.len() > width && width > 1) || (grid.ragged() && 2 * filled > width);
            if !wide || (tally.is_data() && tally.words == 0) || rows.len() == 4 {
                break;
            }
            rows.push(i);
        }
        rows.reverse();
        // "Operator; Meier" above a table of two columns is no name of a column
        let mut from = rows.len().saturating_sub(1);
        if rows.len() > 1 && is_units(&fitted(grid.words(rows[from]), width)) {
            from -= 1;
        }
        let own = rows.get(from).copied();
        let joins = |i: usize| {
            let (above, below) =
                (fitted(grid.words(i), width), own.map(|o| fitted(grid.words(o), width)).unwrap_or_default());
            let filled = above.iter().filter(|w| !w.trim().is_empty()).count();
            let twice = below.iter().enumerate().any(|(k, w)| !w.trim().is_empty() && below[..k].contains(w));
            width > 2 && filled > 0 && (twice || is_units(&above))
        };
        while from > 0 && joins(rows[from - 1]) {
            from -= 1;
        }
        // a description between the names and the numbers: names are what has words for quantities
        if from > 0 && from + 1 == rows.len() && rows.len() > 1 && width > 2 {
            let units_above = rows[..from].iter().position(|i| is_units(&fitted(grid.words(*i), width)));
            if let Some(at) = units_above.filter(|at| *at > 0) {
                return Header::of(vec![rows[at - 1], rows[at]], grid, width, style);
            }
        }
        Header::of(rows.split_off(from.min(rows.len())), grid, width, style)
    }

    /// Of these rows.
    fn of(rows: Vec<usize>, grid: &dyn Grid, width: usize, style: Style) -> Header {
        let mut header = Header { from: rows.first().copied(), ..Header::default() };
        let filled: Vec<Vec<String>> = rows
            .iter()
            .map(|i| fitted(grid.words(*i), width))
            .filter(|words| words.iter().any(|w| !w.trim().is_empty()))
            .collect();
        let several = filled.len() > 1;
        let mut group = vec![String::new(); width];
        for words in filled {
            if several && header.units.is_empty() && is_units(&words) {
                header.units = words.iter().map(|w| bare(w).to_string()).collect();
                continue;
            }
            let all_texts = words.iter().all(|w| crate::numbers::number(w, style.decimal).is_none());
            if !header.row.is_empty() && all_texts {
                // a name above several columns holds up to the next one
                let mut above = String::new();
                for (k, name) in group.iter_mut().enumerate() {
                    let own = header.row.get(k).map(|w| bare(w)).unwrap_or_default();
                    if !own.is_empty() {
                        above = own.to_string();
                    }
                    *name = above.clone();
                }
            }
            header.row = words;
        }
        header.names = (0..width)
            .map(|k| {
                let own = header.row.get(k).map(|w| bare(w)).unwrap_or_default();
                format!("{} {own}", group[k]).split_whitespace().collect::<Vec<_>>().join(" ")
            })
            .collect();
        header
    }
}

/// A header's words brought to the table's width: a name of a remark may have a cell of its own before the first.
fn fitted(mut words: Vec<String>, width: usize) -> Vec<String> {
    if words.len() == width + 1 && matches!(words[0].trim(), "#" | "%" | "//" | "!") {
        words.remove(0);
    }
    while words.len() > width && words.last().is_some_and(|w| w.trim().is_empty()) {
        words.pop();
    }
    words
}

/// The rows of a table.
struct Rows {
    cells: Vec<Vec<Cell>>,
    lines: Vec<usize>,
    /// Their places in the grid.
    indices: Vec<usize>,
    width: usize,
}

impl Rows {
    fn take(
        &mut self,
        grid: &dyn Grid,
        first: usize,
        style: Style,
        header: &Header,
        notes: &mut Vec<String>,
    ) -> Result<(), Error> {
        let (mut remarks, mut passed, mut repeated) = (0usize, Vec::new(), 0usize);
        // empty rows, and those of them that a row of the table follows
        let (mut empty, mut between) = (0usize, 0usize);
        self.cells = vec![Vec::new(); self.width];
        for i in first..grid.count() {
            if grid.is_remark(i) {
                remarks += 1;
                continue;
            }
            let row = grid.row(i, style);
            let tally = Tally::of(&row);
            if tally.numbers + tally.words == 0 {
                empty += usize::from(!row.is_empty());
                continue;
            }
            if !header.row.is_empty() && fitted(grid.words(i), self.width) == header.row {
                repeated += 1;
                continue;
            }
            if !tally.is_data() && tally.words > 0 {
                passed.push(i);
                continue;
            }
            if row.len() != self.width && !(grid.ragged() && row.len() < self.width) {
                let more = (i + 1..grid.count()).any(|k| Tally::of(&grid.row(k, style)).is_data());
                if let Some(last) = passed.last().copied().filter(|last| *last + 3 >= i && more) {
                    notes.push(format!("another table below line {}: not read", grid.line(last)));
                    passed.retain(|at| *at != last);
                    break;
                }
                if !more && row.len() < self.width {
                    notes.push(format!("line {}, the last, stops in the middle: passed over", grid.line(i)));
                    break;
                }
                let (found, width) = (row.len(), self.width);
                return Err(Error::new(
                    format!("has {found} cells in this row, and the table has {width} columns"),
                    "give every row as many cells as the first; leave a missing sample empty",
                )
                .at(grid.line(i)));
            }
            let mut cells = row.into_iter();
            for column in &mut self.cells {
                column.push(cells.next().unwrap_or(Cell::Missing));
            }
            between = empty;
            self.lines.push(grid.line(i));
            self.indices.push(i);
        }
        if remarks > 0 {
            notes.push(format!("{remarks} remarks between the rows passed over"));
        }
        if between > 0 {
            notes.push(format!("{between} rows of empty cells passed over"));
        }
        if repeated > 0 {
            notes.push(format!("the header comes again {repeated} times: was the logger started anew?"));
        }
        match passed[..] {
            [] => {}
            [one] => notes.push(format!("line {} is text: passed over", grid.line(one))),
            [one, .., last] => notes.push(format!(
                "{} lines of text between {} and {} passed over",
                passed.len(),
                grid.line(one),
                grid.line(last)
            )),
        }
        Ok(())
    }

    /// The columns of numbers.
    fn columns(
        self,
        grid: &dyn Grid,
        header: Header,
        style: Style,
        dates: Option<Dates>,
        table: &mut Table,
    ) -> Result<(), Error> {
        for (k, mut cells) in self.cells.into_iter().enumerate() {
            let name = header.names.get(k).cloned().unwrap_or_default();
            let shown = if name.is_empty() { format!("column {}", k + 1) } else { shorten(&name) };
            let unit = header.units.get(k).filter(|u| !u.is_empty() && *u != "-").cloned();
            let word = |row: usize| grid.words(self.indices[row]).into_iter().nth(k).unwrap_or_default();
            let is_text = |cell: &Cell| matches!(cell, Cell::Text(_));
            if cells.iter().any(is_text) {
                // a column may have been written with the other decimal sign than the rest
                let other = Style { decimal: if style.decimal == ',' { '.' } else { ',' }, ..style };
                let again: Vec<Cell> = (0..cells.len()).map(|row| cell(&word(row), other)).collect();
                if again.iter().all(|cell| matches!(cell, Cell::Number(_) | Cell::Missing)) {
                    table.notes.push(format!("column \"{shown}\" has \"{}\" as its decimal sign", other.decimal));
                    cells = again;
                }
            } else {
                let large = |row| match cells[row] {
                    Cell::Number(number) if number.abs() >= 1e3 => Some((word(row), number)),
                    _ => None,
                };
                let mut first = (0..cells.len().min(1000)).filter_map(large);
                if let Some((word, number)) = first.find(|(word, _)| is_grouped(word, style.decimal)) {
                    table.notes.push(format!("column \"{shown}\": \"{word}\" is read as {number}"));
                }
            }
            // a cell that was given the format of a date by accident is the number it has
            let measures = named(&name).stated.or(unit.as_deref().and_then(units::unit));
            if measures.is_some_and(|u| !matches!(u.dimension, units::Dimension::Time | units::Dimension::Other)) {
                let mut dated = false;
                for cell in &mut cells {
                    if let Cell::Moment(Moment { serial: Some(serial), .. }) = cell {
                        (*cell, dated) = (Cell::Number(*serial), true);
                    }
                }
                if dated {
                    table.notes.push(format!("column \"{shown}\" is shown as dates: its numbers are read"));
                }
            }
            let count = |is: fn(&Cell) -> bool| cells.iter().filter(|cell| is(cell)).count();
            let numbers = count(|cell| matches!(cell, Cell::Number(_)));
            let moments = count(|cell| matches!(cell, Cell::Moment(_)));
            let words = count(|cell| matches!(cell, Cell::Text(_)));
            if numbers + moments + words == 0 {
                if !name.is_empty() {
                    table.notes.push(format!("column \"{shown}\" is empty"));
                    table.columns.push(Column { name, unit, values: vec![f64::NAN; cells.len()], clock: false });
                }
                continue;
            }
            if words > numbers + moments {
                table.notes.push(format!("column \"{shown}\" is text: passed over"));
                continue;
            }
            let wrong = |row: usize, found: &str, hint: &str| {
                Error::new(format!("column \"{shown}\": \"{}\" is no number", shorten(found)), hint).at(self.lines[row])
            };
            let empty = "leave the cell empty (or nan) if the sample is missing";
            if moments > numbers {
                let moments = clock(&cells, style, dates, table);
                let mut seconds = Vec::with_capacity(moments.len());
                let mut from: Option<Moment> = None;
                let mut shift = 0.0;
                for (row, moment) in moments.into_iter().enumerate() {
                    let moment = match moment {
                        Ok(Some(moment)) => moment,
                        Ok(None) => {
                            seconds.push(f64::NAN);
                            continue;
                        }
                        Err(found) => return Err(wrong(row, &found, "write every time the same way")),
                    };
                    let from = *from.get_or_insert(moment);
                    let days = moment.day.unwrap_or(0) - from.day.unwrap_or(0);
                    let mut at = days as f64 * 86_400.0 + (moment.seconds - from.seconds) + shift;
                    let last = seconds.iter().rev().find(|s: &&f64| !s.is_nan()).copied().unwrap_or(0.0);
                    if moment.day.is_none() && at < last - 43_200.0 {
                        shift += 86_400.0;
                        at += 86_400.0;
                        table.notes.push(format!("line {}: past midnight", self.lines[row]));
                    }
                    // 0.1 s apart on the clock is 0.1 s, not 0.09999999999854481
                    seconds.push((at * 1e9).round() / 1e9);
                }
                table.columns.push(Column { name, unit, values: seconds, clock: true });
                continue;
            }
            let mut values = Vec::with_capacity(cells.len());
            for (row, cell) in cells.into_iter().enumerate() {
                values.push(match cell {
                    Cell::Number(number) => number,
                    Cell::Missing => f64::NAN,
                    Cell::Moment(_) => return Err(wrong(row, "a time", empty)),
                    Cell::Text(found) => return Err(wrong(row, &found, empty)),
                });
            }
            table.columns.push(Column { name, unit, values, clock: false });
        }
        Ok(())
    }
}

/// The moments of a column, read with the order of day and month that fits all of it.
fn clock(cells: &[Cell], style: Style, dates: Option<Dates>, table: &mut Table) -> Vec<Result<Option<Moment>, String>> {
    // the grid has read them with `style.dates`; a text that is none in that order may be one in the other
    let read = |order: Dates| -> Vec<Result<Option<Moment>, String>> {
        cells
            .iter()
            .map(|cell| match cell {
                Cell::Moment(moment) => Ok(Some(*moment)),
                Cell::Missing => Ok(None),
                Cell::Number(number) => Err(number.to_string()),
                Cell::Text(text) => moment(text, order).map(Some).ok_or_else(|| text.clone()),
            })
            .collect()
    };
    let found = read(dates.unwrap_or(style.dates));
    let days: Vec<i64> = found.iter().filter_map(|m| m.as_ref().ok()?.as_ref()?.day).collect();
    if days.iter().any(|day| *day != days[0]) {
        table.format.dates = Some(dates.unwrap_or(style.dates).word().into());
    }
    found
}

/// What files say beside their columns: how fast they were sampled, and LabVIEW's units.
#[derive(Debug, Default)]
struct Facts {
    rate_hz: Option<(f64, String)>,
    /// Unit labels by channel, the time's not among them.
    units: Vec<String>,
    is_labview: bool,
}

impl Facts {
    fn of(rows: impl Iterator<Item = Vec<String>>, style: Style) -> Facts {
        let mut facts = Facts::default();
        for words in rows {
            let first = words.first().map(|w| bare(w)).unwrap_or_default().to_string();
            let rest = words.get(1..).unwrap_or_default();
            match first.as_str() {
                "LabVIEW Measurement" => facts.is_labview = true,
                "Y_Unit_Label" => facts.units = rest.iter().map(|w| w.trim().to_string()).collect(),
                "Delta_X" => {
                    let step = rest.iter().find_map(|w| crate::numbers::number(w, style.decimal)).filter(|s| *s > 0.0);
                    facts.rate_hz = step.map(|step| (1.0 / step, "Delta_X".into())).or(facts.rate_hz);
                }
                _ if facts.rate_hz.is_none() && words.len() < 6 => {
                    facts.rate_hz = rate(&words.join(" "), style.decimal)
                }
                _ => {}
            }
        }
        facts
    }

    fn into(self, table: &mut Table) {
        table.rate_hz = self.rate_hz;
        if !self.is_labview {
            return;
        }
        let x = usize::from(table.columns.first().is_some_and(|c| c.name == "X_Value"));
        if let Some(time) = table.columns.first_mut().filter(|_| x == 1) {
            time.unit = Some("s".into());
        }
        for (column, unit) in table.columns.iter_mut().skip(x).zip(self.units) {
            column.unit = column.unit.take().or(Some(unit).filter(|u| !u.is_empty()));
        }
    }
}

/// Words before a rate, and before a time between samples.
const RATES: [&str; 13] = [
    "abtastrate",
    "abtastfrequenz",
    "messrate",
    "messfrequenz",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "fréquenced'échantillonnage",
    "échantillonnage",
    "fs",
    "サンプリング周波数",
    "samplerate(hz)",
];
const STEPS: [&str; 10] = [
    "abtastintervall",
    "messintervall",
    "sampleinterval",
    "samplinginterval",
    "sampletime",
    "dt",
    "ts",
    "période",
    "サンプリング周期",
    "サンプリング間隔",
];

/// A rate that a line says, such as `Abtastrate: 100 Hz` or `dt = 10 ms`, with its words.
fn rate(text: &str, decimal: char) -> Option<(f64, String)> {
    if text.len() > 200 {
        return None;
    }
    let text = text.replace(['=', '[', ']', '(', ')', '\t', ';', '"', '#', '%'], " ");
    let at = text.find(|c: char| c.is_ascii_digit())?;
    let (words, number_and_unit) = text.split_at(at);
    let words: String = words.to_lowercase().chars().filter(|c| !c.is_whitespace() && *c != ':' && *c != '_').collect();
    let words = words.trim_end_matches("hz").trim_end_matches('/').to_string();
    let end = number_and_unit
        .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | 'e' | '-')))
        .unwrap_or(number_and_unit.len());
    let (number, unit_text) = number_and_unit.split_at(end);
    let value = crate::numbers::number(number, decimal).or_else(|| number.parse().ok()).filter(|v: &f64| *v > 0.0)?;
    let unit_text = unit_text.split_whitespace().next().unwrap_or_default();
    let said = shorten(text.split_whitespace().collect::<Vec<_>>().join(" ").trim());
    let fits =
        |list: &[&str]| list.iter().any(|word| words == *word || (word.chars().count() > 3 && words.ends_with(word)));
    if fits(&RATES) {
        let factor = match unit_text.to_lowercase().as_str() {
            "khz" | "ks/s" => 1e3,
            "ms" => return Some((1e3 / value, said)),
            _ => 1.0,
        };
        return Some((value * factor, said));
    }
    if fits(&STEPS) {
        let factor = unit(unit_text).filter(|u| u.dimension == units::Dimension::Time).map_or(1.0, |u| u.factor);
        return Some((1.0 / (value * factor), said));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_found_in_words_of_several_languages() {
        for (text, hz) in [
            ("Abtastrate: 100 Hz", 100.0),
            ("Messrate [Hz] 50", 50.0),
            ("Sample rate = 2 kHz", 2000.0),
            ("dt = 10 ms", 100.0),
            ("fs: 25", 25.0),
            ("サンプリング周期 20 ms", 50.0),
        ] {
            let (found, said) = rate(text, '.').unwrap_or_else(|| panic!("{text}"));
            assert!((found - hz).abs() < 1e-9 && !said.is_empty(), "{text}: {found}");
        }
        assert_eq!(rate("Probe 100", '.'), None);
        assert_eq!(rate("Results 7", '.'), None);
    }
}
