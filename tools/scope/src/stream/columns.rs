//! What the numbers of a stream are: their columns, as they turn out while they come.

use super::lines::{Said, Value, read};

/// More columns are none: something else is on the line.
const MOST: usize = 64;
/// What looks like another column must come so often before it is one: a byte that was lost looks like one, once.
const SIGHTINGS: u32 = 3;

/// One column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// As it is written, without its unit.
    pub name: String,
    /// As it is written; "" where none is.
    pub unit: String,
}

impl Column {
    /// Of a name that may have its unit with it: `Force [N]`, `temp_C`.
    pub fn of(heading: &str) -> Column {
        let (name, unit) = sinew_import::heading(heading);
        Column { name, unit }
    }

    /// As the head of a column in a file.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} [{}]", self.name, self.unit) }
    }
}

/// What became of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Came {
    /// Nothing to count: an empty line, or a part of a row that is not whole yet.
    Nothing,
    /// Words that name columns.
    Names,
    /// No numbers, or other ones than those before.
    Odd,
    /// A row.
    Row,
    /// A row, and from it on the columns are others.
    Others,
}

/// The columns, and the last row.
#[derive(Debug, Default)]
pub struct Columns {
    columns: Vec<Column>,
    /// Names that were given beforehand: they stand, whatever the stream says.
    given: Vec<Column>,
    /// The words of the line before the first row.
    words: Vec<Column>,
    row: Vec<f64>,
    /// Numbers that bear names are gathered until one comes again.
    gathered: Vec<f64>,
    /// How many rows on end had so many numbers, or how often a name was seen that is no column.
    wider: (usize, u32),
    strangers: Vec<(String, u32)>,
}

impl Columns {
    /// With names that are known beforehand.
    pub fn named(given: &[String]) -> Columns {
        Columns { given: given.iter().map(|name| Column::of(name)).collect(), ..Columns::default() }
    }

    /// What the numbers are.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The row that came last: a number a column, NaN where there was none.
    pub fn row(&self) -> &[f64] {
        &self.row
    }

    /// Takes a line in.
    pub fn take(&mut self, line: &str) -> Came {
        match read(line) {
            Said::Nothing => Came::Nothing,
            Said::Words(words) => {
                let is_first = self.columns.is_empty();
                if is_first {
                    self.words = words.into_iter().map(Column::of).collect();
                }
                if is_first { Came::Names } else { Came::Odd }
            }
            Said::Numbers(values) if values.len() > MOST => Came::Odd,
            Said::Numbers(values) if values.iter().all(|value| value.name.is_some()) => self.gather(&values),
            Said::Numbers(values) if values.iter().any(|value| value.name.is_some()) => Came::Odd,
            Said::Numbers(values) => self.file(&values),
        }
    }

    /// Numbers by their places.
    fn file(&mut self, values: &[Value<'_>]) -> Came {
        let count = values.len();
        let others = if self.columns.is_empty() {
            true
        } else if count > self.columns.len() {
            self.wider = if self.wider.0 == count { (count, self.wider.1 + 1) } else { (count, 1) };
            if self.wider.1 < SIGHTINGS {
                return Came::Odd;
            }
            true
        } else {
            self.wider = (0, 0);
            false
        };
        if others {
            let named = self.words.len() == count;
            for (at, value) in values.iter().enumerate().skip(self.columns.len()) {
                let mut column = match (self.given.get(at), self.words.get(at)) {
                    (Some(given), _) => given.clone(),
                    (None, Some(word)) if named => word.clone(),
                    _ => Column { name: format!("column {}", at + 1), unit: String::new() },
                };
                if column.unit.is_empty() {
                    column.unit = value.unit.to_string();
                }
                self.columns.push(column);
            }
        }
        self.row.clear();
        self.row.extend(values.iter().map(|value| value.number));
        self.row.resize(self.columns.len(), f64::NAN);
        if others { Came::Others } else { Came::Row }
    }

    /// Numbers by their names. A board may print all of them on a line or one a line: a row is whole once each has come, or
    /// one comes again.
    fn gather(&mut self, values: &[Value<'_>]) -> Came {
        let mut others = false;
        let mut is_row = false;
        let is_first = self.columns.is_empty();
        for value in values {
            let name = value.name.unwrap_or_default();
            let found = Column::of(name);
            let at = match self.columns.iter().position(|column| column.name == found.name) {
                Some(at) => at,
                None if is_first || self.is_met(&found.name) => {
                    let unit = if found.unit.is_empty() { value.unit.to_string() } else { found.unit };
                    self.columns.push(Column { name: found.name, unit });
                    self.gathered.push(f64::NAN);
                    others = true;
                    self.columns.len() - 1
                }
                None => continue,
            };
            self.gathered.resize(self.columns.len(), f64::NAN);
            if !self.gathered[at].is_nan() {
                self.emit();
                is_row = true;
            }
            self.gathered[at] = value.number;
        }
        if others && !is_first {
            // one a line: a row begins with the first column, not with the one that was found last
            self.gathered.fill(f64::NAN);
        } else if self.gathered.iter().all(|number| !number.is_nan()) {
            self.emit();
            is_row = true;
        }
        match (others, is_row) {
            (true, _) => {
                // what was found so far is shown from here on, whole or not
                if !is_row {
                    self.row.clear();
                }
                self.row.resize(self.columns.len(), f64::NAN);
                Came::Others
            }
            (false, true) => Came::Row,
            (false, false) => Came::Nothing,
        }
    }

    fn emit(&mut self) {
        self.row.clear();
        self.row.extend_from_slice(&self.gathered);
        self.gathered.fill(f64::NAN);
    }

    /// Whether a name that is no column has come often enough to be one.
    fn is_met(&mut self, name: &str) -> bool {
        if self.columns.len() >= MOST {
            return false;
        }
        if let Some(at) = self.strangers.iter().position(|(stranger, _)| stranger == name) {
            self.strangers[at].1 += 1;
            let is_met = self.strangers[at].1 >= SIGHTINGS;
            if is_met {
                self.strangers.remove(at);
            }
            return is_met;
        }
        if self.strangers.len() >= MOST {
            self.strangers.remove(0);
        }
        self.strangers.push((name.to_string(), 1));
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headings(columns: &Columns) -> Vec<String> {
        columns.columns().iter().map(Column::heading).collect()
    }

    /// What becomes of these lines, and the columns after them.
    fn told(columns: &mut Columns, lines: &[&str]) -> Vec<Came> {
        lines.iter().map(|line| columns.take(line)).collect()
    }

    #[test]
    fn a_head_names_the_columns_and_their_units() {
        let mut columns = Columns::default();
        let came = told(&mut columns, &["booting", "t_ms, force [N], note", "0, 1.5, 3", "10, 1.6, 3"]);
        assert_eq!(came, [Came::Names, Came::Names, Came::Others, Came::Row]);
        assert_eq!(headings(&columns), ["t [ms]", "force [N]", "note"]);
        assert_eq!(columns.row(), [10.0, 1.6, 3.0]);
        // a name given beforehand stands
        let mut given = Columns::named(&["x (mm)".to_string()]);
        told(&mut given, &["a b", "1 2"]);
        assert_eq!(headings(&given), ["x [mm]", "b"]);
    }

    #[test]
    fn a_damaged_line_is_no_column_and_a_short_one_leaves_gaps() {
        let mut columns = Columns::default();
        assert_eq!(told(&mut columns, &["1 2", "1 2 3", "1 2"]), [Came::Others, Came::Odd, Came::Row]);
        assert_eq!(headings(&columns), ["column 1", "column 2"]);
        assert_eq!(columns.take("7"), Came::Row);
        assert!(columns.row()[0] == 7.0 && columns.row()[1].is_nan());
        let came = told(&mut columns, &["1 2 3", "1 2 3", "1 2 3", "1 2 3", "hello world", "a:1"]);
        assert_eq!(came[..4], [Came::Odd, Came::Odd, Came::Others, Came::Row]);
        assert_eq!(columns.columns().len(), 3);
        assert_eq!(came[4], Came::Odd);
    }

    #[test]
    fn numbers_with_names_are_a_row_however_they_are_printed() {
        let mut lines = Columns::default();
        assert_eq!(told(&mut lines, &["temp:1°C hum:2", "temp:3 hum:4"]), [Came::Others, Came::Row]);
        assert_eq!((headings(&lines), lines.row()), (vec!["temp [°C]".into(), "hum".into()], &[3.0, 4.0][..]));
        // one a line: the second name is met three times before it is a column
        let mut apart = Columns::default();
        let printed = ["a:1", "b:2", "a:3", "b:4", "a:5", "b:6", "a:7", "b:8"];
        let came = told(&mut apart, &printed);
        assert_eq!(came.last(), Some(&Came::Row));
        assert_eq!((apart.columns().len(), apart.row()), (2, &[7.0, 8.0][..]));
    }
}
