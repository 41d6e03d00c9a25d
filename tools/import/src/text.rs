//! Tables in text: what stands between the cells, and which sign is the decimal one.

use std::borrow::Cow;

use sinew_rig::FileFormat;

use crate::decode::decode;
use crate::error::Error;
use crate::grid::{Grid, Tally, longest_run, understand};
use crate::numbers::{Cell, Dates, Style, cell, is_grouped, number};
use crate::table::Table;

/// Rows that are looked at to find separator and decimal sign.
const LOOKED_AT: usize = 1000;

/// What stands between cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    One(char),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Separator {
    const ALL: [Separator; 5] =
        [Separator::One('\t'), Separator::One(';'), Separator::One(','), Separator::One('|'), Separator::Blanks];

    fn word(self) -> String {
        match self {
            Separator::One(c) => c.to_string(),
            Separator::Blanks => "blanks".into(),
        }
    }

    fn said(self) -> String {
        match self {
            Separator::One('\t') => "tabs".into(),
            Separator::One(c) => format!("\"{c}\""),
            Separator::Blanks => "blanks".into(),
        }
    }
}

/// The lines of a text, each as it is split.
struct Lines<'t> {
    lines: Vec<(usize, Cow<'t, str>)>,
    separator: Separator,
}

/// Reads a table in text.
pub(crate) fn text(bytes: &[u8], given: &FileFormat) -> Result<Table, Error> {
    let (text, encoding) = decode(bytes, given.encoding.as_deref())?;
    refused(&text)?;
    let lines = split_lines(&text);
    if lines.iter().all(|(_, line)| line.trim().is_empty()) {
        return Err(Error::new("is empty", "record again, or check that the export has finished"));
    }
    let (separator, style) = layout(&lines, given)?;
    let grid = Lines { lines, separator };
    let kind = format!(
        "text, {encoding}, columns separated by {}, decimal {}",
        separator.said(),
        if style.decimal == ',' { "comma" } else { "point" }
    );
    let mut table = understand(&grid, kind, style, given)?;
    table.format.encoding = Some(encoding.to_ascii_lowercase());
    table.format.separator = Some(separator.word());
    table.format.decimal = Some(style.decimal.to_string());
    Ok(table)
}

/// Texts that are no tables and have a better way out.
fn refused(text: &str) -> Result<(), Error> {
    let start: String = text.chars().take(200).collect();
    let begins = |words: &[&str]| words.iter().any(|w| start.trim_start().to_ascii_lowercase().starts_with(w));
    if start.contains("# Created by Octave") {
        return Err(Error::new(
            "is Octave's own text format",
            "in Octave: save('-v7', 'FILE.mat', …), which is read here",
        ));
    }
    if begins(&["<?xml", "<html", "<!doctype"]) {
        return Err(Error::new(
            "is XML or a web page, not a table",
            "export the table as CSV or as .xlsx from the program that wrote it",
        ));
    }
    if begins(&["{", "[{"]) && text.contains("\":") {
        return Err(Error::new(
            "is JSON, not a table",
            "write it as CSV: pandas.read_json(FILE).to_csv(OUT, index=False)",
        ));
    }
    Ok(())
}

/// The lines with their numbers, whatever ends them; a line break within quotes ends none.
fn split_lines(text: &str) -> Vec<(usize, Cow<'_, str>)> {
    let only_returns = text.contains('\r') && !text.contains('\n');
    let raw: Vec<&str> = if only_returns { text.split('\r').collect() } else { text.lines().collect() };
    let odd = |line: &str| line.matches('"').count() % 2 == 1;
    let mut lines: Vec<(usize, Cow<'_, str>)> = Vec::with_capacity(raw.len());
    let mut i = 0;
    while i < raw.len() {
        // a name in quotes may take up to four lines; a quote that stays open is a sign for inches
        let closed = (i + 1..raw.len().min(i + 4)).find(|k| odd(raw[*k])).filter(|_| odd(raw[i]));
        match closed {
            Some(to) => {
                lines.push((i + 1, Cow::Owned(raw[i..=to].join(" "))));
                i = to + 1;
            }
            None => {
                lines.push((i + 1, Cow::Borrowed(raw[i].trim_end_matches('\r'))));
                i += 1;
            }
        }
    }
    lines
}

/// Takes a line apart; the flag says that a cell was in quotes.
fn split(line: &str, separator: Separator) -> Vec<(Cow<'_, str>, bool)> {
    let Separator::One(separator) = separator else {
        // "Time (s)" is one name: what is in brackets belongs to the word before
        let mut words: Vec<(Cow<'_, str>, bool)> = Vec::new();
        for (word, quoted) in blank_separated(line) {
            match words.last_mut() {
                Some((before, _)) if word.starts_with(['(', '[']) && before.parse::<f64>().is_err() => {
                    before.to_mut().push(' ');
                    before.to_mut().push_str(word);
                }
                _ => words.push((Cow::Borrowed(word), quoted)),
            }
        }
        return words;
    };
    let line = if separator == '|' { line.trim().trim_start_matches('|').trim_end_matches('|') } else { line };
    let mut cells = Vec::new();
    let mut rest = line;
    loop {
        let lead = rest.trim_start_matches([' ', '\u{feff}']);
        if let Some(inside) = lead.strip_prefix('"')
            && let Some((cell, after)) = quoted(inside)
            && let Some(after) =
                after.trim_start_matches(' ').strip_prefix(separator).or(after.trim().is_empty().then_some(""))
        {
            let ended = lead.len() - 1 - cell.0 == 0 || !lead[1 + cell.0..].contains(separator);
            cells.push((cell.1, true));
            if after.is_empty() && ended {
                return cells;
            }
            rest = after;
            continue;
        }
        match rest.split_once(separator) {
            Some((cell, after)) => {
                cells.push((Cow::Borrowed(cell), false));
                rest = after;
            }
            None => {
                cells.push((Cow::Borrowed(rest), false));
                return cells;
            }
        }
    }
}

/// The text up to the quote that closes it: its length with that quote, itself with doubled quotes as one; and what follows.
fn quoted(text: &str) -> Option<((usize, Cow<'_, str>), &str)> {
    let mut from = 0;
    loop {
        let at = from + text[from..].find('"')?;
        if text[at + 1..].starts_with('"') {
            from = at + 2;
            continue;
        }
        let inside = &text[..at];
        let inside =
            if inside.contains("\"\"") { Cow::Owned(inside.replace("\"\"", "\"")) } else { Cow::Borrowed(inside) };
        return Some(((at + 1, inside), &text[at + 1..]));
    }
}

fn blank_separated(line: &str) -> Vec<(&str, bool)> {
    let mut words = Vec::new();
    let mut rest = line.trim();
    while !rest.is_empty() {
        let (word, after, quoted) = match rest.strip_prefix('"').and_then(|inside| inside.split_once('"')) {
            Some((word, after)) => (word, after, true),
            None => match rest.split_once(char::is_whitespace) {
                Some((word, after)) => (word, after, false),
                None => (rest, "", false),
            },
        };
        words.push((word, quoted));
        rest = after.trim_start();
    }
    words
}

fn is_remark(line: &str) -> bool {
    let line = line.trim_start();
    line.starts_with(['#', '%', '!']) || line.starts_with("//") || line.starts_with("***")
}

/// Separator and decimal sign: those with which most of the text is numbers.
fn layout(lines: &[(usize, Cow<'_, str>)], given: &FileFormat) -> Result<(Separator, Style), Error> {
    let separators: Vec<Separator> = match given.separator.as_deref() {
        Some("blanks") => vec![Separator::Blanks],
        Some(text) => text.chars().next().map(Separator::One).into_iter().collect(),
        None => Separator::ALL.to_vec(),
    };
    let decimals: Vec<char> = match given.decimal.as_deref().and_then(|text| text.chars().next()) {
        Some(decimal) => vec![decimal],
        None => vec!['.', ','],
    };
    let looked_at = &lines[..lines.len().min(LOOKED_AT)];
    let mut best: Option<(f64, Separator, char)> = None;
    for separator in separators {
        let rows: Vec<Option<Vec<_>>> = looked_at
            .iter()
            .map(|(_, line)| (!line.trim().is_empty() && !is_remark(line)).then(|| split(line, separator)))
            .collect();
        for &decimal in &decimals {
            let style = Style { decimal, dates: Dates::Dmy };
            let cells = |(text, quoted): &(Cow<'_, str>, bool)| match cell(text, style) {
                // "1,2,3" between commas is three cells unless it is in quotes
                Cell::Number(_) if separator == Separator::One(decimal) && !quoted && text.contains(decimal) => {
                    Cell::Text(text.to_string())
                }
                cell => cell,
            };
            let tallies: Vec<Option<Tally>> = rows
                .iter()
                .map(|row| row.as_ref().map(|row| Tally::of(&row.iter().map(cells).collect::<Vec<_>>())))
                .collect();
            let Some((from, to)) = longest_run(&tallies, false) else { continue };
            let mut score = 0.0;
            for (row, tally) in rows[from..to].iter().zip(&tallies[from..to]) {
                let (Some(row), Some(tally)) = (row, tally) else { continue };
                let share = 1.0 - tally.words as f64 / tally.cells as f64;
                // 1,234 is a number with a fraction before it is one with a mark between its thousands
                let grouped =
                    row.iter().filter(|(text, _)| number(text, decimal).is_some() && is_grouped(text, decimal));
                score += (tally.numbers as f64 - 0.3 * grouped.count() as f64) * share * share;
            }
            // names as many as columns: a date and a time with a blank between them are one cell
            let width = tallies[from].map_or(0, |tally| tally.cells);
            let above = (0..from).rev().find(|i| rows[*i].as_ref().is_some_and(|row| !row.is_empty()));
            if above.and_then(|i| rows[i].as_ref()).is_some_and(|row| row.len() == width && width > 1) {
                score *= 1.5;
            }
            if best.is_none_or(|(most, ..)| score > 1.001 * most) {
                best = Some((score, separator, decimal));
            }
        }
    }
    let Some((_, separator, decimal)) = best else {
        return Err(Error::new(
            "has no rows of numbers in it",
            "give a table with a row a sample and a column a quantity, the names above",
        ));
    };
    no_commas_for_both(looked_at, separator, decimal)?;
    let dates = match given.dates.as_deref().and_then(Dates::from_word) {
        Some(dates) => dates,
        None => dates(looked_at, separator, decimal),
    };
    Ok((separator, Style { decimal, dates }))
}

/// A comma that separates columns and is the decimal sign too leaves two cells of each number: what is what cannot be known.
fn no_commas_for_both(lines: &[(usize, Cow<'_, str>)], separator: Separator, decimal: char) -> Result<(), Error> {
    if separator != Separator::One(',') || decimal != '.' {
        return Ok(());
    }
    let widths: Vec<(usize, usize, bool)> = lines
        .iter()
        .filter(|(_, line)| !line.trim().is_empty() && !is_remark(line))
        .map(|(number, line)| {
            let cells = split(line, separator);
            let whole = |text: &str| text.trim().trim_start_matches('-').bytes().all(|b| b.is_ascii_digit());
            (*number, cells.len(), cells.iter().all(|(text, _)| whole(text)))
        })
        .collect();
    let numbers: Vec<_> = widths.iter().filter(|(_, _, whole)| *whole).collect();
    let header = widths.iter().rev().skip_while(|(_, _, whole)| *whole).find(|(_, cells, whole)| !whole && *cells > 1);
    match (header, numbers.first()) {
        (Some((_, names, _)), Some((line, cells, _)))
            if *cells > *names && *cells <= 2 * names && numbers.len() > 2 && numbers.len() + 5 > widths.len() =>
        {
            Err(Error::new(
                format!("has commas between its columns and in its numbers: {names} names, {cells} cells in a row of numbers"),
                "export it with \";\" or tabs between the columns, or with a decimal point",
            )
            .at(*line))
        }
        _ => Ok(()),
    }
}

/// The order of day and month in dates with slashes: the one all of them can have.
fn dates(lines: &[(usize, Cow<'_, str>)], separator: Separator, decimal: char) -> Dates {
    let fits = |dates: Dates| {
        let style = Style { decimal, dates };
        let cells = lines.iter().flat_map(|(_, line)| split(line, separator));
        cells.filter(|(text, _)| matches!(cell(text, style), Cell::Moment(_))).count()
    };
    let (day, month) = (fits(Dates::Dmy), fits(Dates::Mdy));
    // where both fit, the decimal sign says whose dates they are
    match day.cmp(&month) {
        std::cmp::Ordering::Greater => Dates::Dmy,
        std::cmp::Ordering::Less => Dates::Mdy,
        std::cmp::Ordering::Equal if decimal == '.' && day > 0 => Dates::Mdy,
        std::cmp::Ordering::Equal => Dates::Dmy,
    }
}

impl Grid for Lines<'_> {
    fn count(&self) -> usize {
        self.lines.len()
    }

    fn row(&self, index: usize, style: Style) -> Vec<Cell> {
        if self.lines[index].1.trim().is_empty() {
            return Vec::new();
        }
        split(&self.lines[index].1, self.separator).iter().map(|(text, _)| cell(text, style)).collect()
    }

    fn words(&self, index: usize) -> Vec<String> {
        split(&self.lines[index].1, self.separator).into_iter().map(|(text, _)| text.trim().to_string()).collect()
    }

    fn line(&self, index: usize) -> usize {
        self.lines.get(index).map_or(self.lines.len() + 1, |(line, _)| *line)
    }

    fn ragged(&self) -> bool {
        false
    }

    fn is_remark(&self, index: usize) -> bool {
        is_remark(&self.lines[index].1)
    }
}
