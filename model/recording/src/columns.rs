//! From named cells to the columns of a recording: which is which, in which unit, and what cannot be meant. Every way in
//! goes through here, whatever the file was.

use crate::column::{Column, TIME, required_inputs};
use crate::error::{Error, What};
use crate::options::Options;
use crate::recording::{MAX_DURATION_S, MIN_SAMPLES, Recording, check_input, check_range, missing_input};
use crate::suggest;

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
    low: (f64, Option<u64>),
    high: (f64, Option<u64>),
}

/// Takes a table in, row by row.
pub(crate) struct Columns<'a> {
    name: &'a str,
    options: &'a Options<'a>,
    targets: Vec<Target>,
    times: Vec<f64>,
    values: Vec<Values>,
}

impl<'a> Columns<'a> {
    /// Of a table whose columns are called `header`, in this line.
    pub(crate) fn new(
        name: &'a str,
        options: &'a Options<'a>,
        header: &[String],
        line: Option<u64>,
    ) -> Result<Columns<'a>, Error> {
        let mut columns = Columns { name, options, targets: Vec::new(), times: Vec::new(), values: Vec::new() };
        columns.targets = columns.targets(header, line)?;
        let empty = Values { all: Vec::new(), low: (f64::INFINITY, None), high: (f64::NEG_INFINITY, None) };
        columns.values = vec![empty; columns.targets.len()];
        Ok(columns)
    }

    fn error(&self, what: What) -> Error {
        Error::new(self.name, what)
    }

    fn here(&self, line: Option<u64>, what: What) -> Error {
        self.error(what).maybe_at(line)
    }

    /// What becomes of each column of the file; the time comes first.
    fn targets(&self, header: &[String], line: Option<u64>) -> Result<Vec<Target>, Error> {
        for (i, name) in header.iter().enumerate() {
            if header[..i].contains(name) && self.is_wanted(name) {
                let quantity = Column::from_name(name).map_or(TIME, Column::name);
                let error = self.here(line, What::DuplicateColumn { quantity, other: name.clone() });
                return Err(error.in_column(name));
            }
        }
        let inputs: Vec<Column> = self.options.model.map(|m| required_inputs(m).collect()).unwrap_or_default();
        let place = |name: &str| header.iter().position(|h| h == name);
        // a file of ours goes with the same rig: nothing in it is foreign
        let ours = header.iter().all(|name| name == TIME || Column::from_name(name).is_some());
        let mut targets: Vec<Target> = Vec::new();
        for column in std::iter::once(None).chain(Column::ALL.into_iter().map(Some)) {
            let quantity = column.map_or(TIME, Column::name);
            let map = self.options.columns.and_then(|m| m.get(quantity));
            let own = place(quantity).filter(|_| !self.is_foreign_source(quantity));
            let foreign = map.and_then(|m| Some((place(&m.column)?, m)));
            let (cell, scale, offset) = match (foreign, own) {
                (Some((cell, _)), Some(other)) if cell != other => {
                    let what = What::DuplicateColumn { quantity, other: header[other].clone() };
                    return Err(self.here(line, what).in_column(&header[cell]));
                }
                (Some((cell, map)), _) => (cell, map.scale, map.offset),
                (None, Some(cell)) => (cell, 1.0, 0.0),
                (None, None) if column.is_none() && (map.is_none() || ours) => {
                    return Err(self.here(line, What::MissingTimeColumn { present: header.to_vec() }));
                }
                (None, None) => {
                    if let Some(map) = map.filter(|_| !ours) {
                        let what = What::MissingMapped { quantity, present: header.to_vec() };
                        return Err(self.here(line, what).in_column(&map.column));
                    }
                    continue;
                }
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
            return Err(self.here(line, what).in_column(first));
        }
        if let Some(model) = self.options.model {
            let missing = inputs.iter().find(|input| targets.iter().all(|t| t.column != Some(**input)));
            if let Some(&input) = missing {
                return Err(missing_input(self.name, input, model, header.to_vec()).maybe_at(line));
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

    /// Takes a row in. `cell` says the number in a place of it, NaN where it is missing; it is asked for what is used only.
    pub(crate) fn row(
        &mut self,
        line: Option<u64>,
        mut cell: impl FnMut(usize) -> Result<f64, What>,
    ) -> Result<(), Error> {
        if self.times.len() == self.options.max_rows {
            return Err(self.here(line, What::TooManyRows { limit: self.options.max_rows }));
        }
        for i in 0..self.targets.len() {
            let target = &self.targets[i];
            let checked = cell(target.cell).and_then(|raw| {
                let value = if target.mapped { raw * target.scale + target.offset } else { raw };
                match target.column {
                    _ if value.is_infinite() => return Err(What::Infinite { found: raw.to_string() }),
                    None => check_time(&self.times, value),
                    Some(column) if target.input => check_input(column, value, self.times[self.times.len() - 1]),
                    Some(_) if value.is_nan() => Ok(()),
                    Some(column) => check_range(column, value, false),
                }
                .map(|()| value)
            });
            let value = checked.map_err(|what| self.here(line, what).in_column(&target.foreign))?;
            if target.column.is_none() {
                self.times.push(value);
                continue;
            }
            let values = &mut self.values[i];
            values.all.push(value);
            if value < values.low.0 {
                values.low = (value, line);
            }
            if value > values.high.0 {
                values.high = (value, line);
            }
        }
        Ok(())
    }

    /// What has been taken in.
    pub(crate) fn recording(self) -> Result<Recording, Error> {
        match self.times.len() {
            0 => return Err(self.error(What::HeaderOnly)),
            found if found < MIN_SAMPLES => {
                return Err(self.error(What::TooFewSamples { found, least: MIN_SAMPLES }));
            }
            _ => {}
        }
        for (target, values) in self.targets.iter().zip(&self.values) {
            if let Some(column) = target.column {
                self.check_unit(target, column, values)?;
            }
        }
        let mut columns: [Option<Vec<f64>>; Column::COUNT] = Default::default();
        for (target, values) in self.targets.iter().zip(self.values) {
            if let Some(column) = target.column {
                columns[column.index()] = Some(values.all);
            }
        }
        Ok(Recording::checked(self.name.to_string(), self.times, columns))
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
        Err(self.here(line, what).in_column(&target.foreign))
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
