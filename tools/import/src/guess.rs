//! Which column is what: names, units, and what the numbers and the rig file say.

use sinew_physics::DriveKind;
use sinew_recording::{Column as Quantity, TIME, drive_column, drive_word};
use sinew_rig::{Column as Mapped, Mapping};

use crate::bench::Bench;
use crate::clock;
use crate::direction::{Heat, force, position};
use crate::reading::{Reading, figure, measured};
use crate::statistics::{quantiles, range};
use crate::table::{ROW_NUMBER, Table};
use crate::units::{Dimension, Named, Unit, named, unit};
use crate::words::{Role, Said, said};

/// What was understood of a file, to be confirmed.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// Every column of the file, in its order; the row's number last, where it is used.
    pub columns: Vec<Understood>,
    /// The mapping that comes of it.
    pub mapping: Mapping,
    /// What is in doubt about the whole.
    pub doubts: Vec<String>,
}

/// What was understood of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Understood {
    /// Its name in the file.
    pub column: String,
    /// The quantity of a recording it is taken for.
    pub quantity: Option<&'static str>,
    /// What else it is, where it is none.
    pub words: String,
    /// The unit it is taken to have.
    pub unit: String,
    /// Factor to the contract's unit.
    pub scale: f64,
    /// Added after scaling.
    pub offset: f64,
    /// Least and largest value in the contract's unit (as written, where it is no quantity of a recording).
    pub range: (f64, f64),
    /// What speaks for it.
    pub evidence: Vec<String>,
    /// What is in doubt.
    pub doubts: Vec<String>,
}

/// A column with what its name says.
struct Candidate {
    said: Option<Said>,
    unit: Option<Unit>,
    unknown_unit: Option<String>,
}

impl Candidate {
    fn of(column: &crate::table::Column) -> Candidate {
        let Named { name, stated, unknown, loose } = named(&column.name);
        let apart = column.unit.as_deref().and_then(unit);
        if let Some(stated) = apart.or(stated) {
            return Candidate { said: said(&name, Some(stated.dimension)), unit: Some(stated), unknown_unit: None };
        }
        let unknown_unit = column.unit.clone().filter(|text| unit(text).is_none()).or(unknown);
        // "Force_N" is a force in newtons; "phase_a" is no current
        if let Some(loose) = loose {
            let fitting = said(&name, Some(loose.dimension))
                .filter(|s| s.role.dimension() == Some(loose.dimension) || s.role == Role::Wanted)
                .filter(|s| s.word != "its unit" || loose.symbol.chars().count() > 1);
            if let Some(said) = fitting {
                return Candidate { said: Some(said), unit: Some(loose), unknown_unit };
            }
        }
        let whole = column.name.to_lowercase();
        let own = Quantity::from_name(&whole).is_some() || whole == TIME;
        let said = if whole == TIME { said("time", None) } else { said(if own { &whole } else { &column.name }, None) };
        // the contract's own name has the contract's unit
        let unit = said.as_ref().filter(|_| own).and_then(|s| {
            let symbol = if whole == TIME { "s" } else { Quantity::from_name(&whole)?.unit() };
            unit(symbol).or(Some(Unit { dimension: s.role.dimension()?, factor: 1.0, offset: 0.0, symbol: "1" }))
        });
        Candidate { said, unit, unknown_unit }
    }

    fn role(&self) -> Option<Role> {
        self.said.as_ref().map(|said| said.role)
    }

    fn is(&self, role: Role) -> bool {
        self.role() == Some(role)
    }
}

/// A column taken for a quantity.
struct Choice {
    /// Its place in the table; `None` = the number of the row.
    column: Option<usize>,
    reading: Reading,
}

struct Guesser<'a> {
    table: &'a Table,
    bench: Option<&'a Bench>,
    candidates: Vec<Candidate>,
    choices: Vec<Choice>,
    /// What is said of columns that were not chosen.
    remarks: Vec<(usize, String)>,
    doubts: Vec<String>,
}

/// Guesses which column is what. `rate_hz` is the rate of the rows, where the user has said it.
pub fn guess(table: &Table, bench: Option<&Bench>, rate_hz: Option<f64>) -> Guess {
    let candidates = table.columns.iter().map(Candidate::of).collect();
    let mut guesser =
        Guesser { table, bench, candidates, choices: Vec::new(), remarks: Vec::new(), doubts: Vec::new() };
    guesser.time(rate_hz);
    guesser.temperatures();
    guesser.voltages();
    for quantity in Quantity::ALL {
        guesser.quantity(quantity);
    }
    guesser.instead();
    guesser.voltages_by_ohms_law();
    guesser.directions();
    guesser.power();
    guesser.what_is_missing();
    guesser.guess()
}

impl Guesser<'_> {
    fn values(&self, column: usize) -> &[f64] {
        &self.table.columns[column].values
    }

    fn name(&self, column: usize) -> &str {
        &self.table.columns[column].name
    }

    fn is_taken(&self, column: usize) -> bool {
        self.choices.iter().any(|choice| choice.column == Some(column))
    }

    fn with(&self, is: impl Fn(&Candidate) -> bool) -> Vec<usize> {
        (0..self.candidates.len()).filter(|i| is(&self.candidates[*i]) && !self.is_taken(*i)).collect()
    }

    fn chosen(&self, quantity: Quantity) -> Option<&Choice> {
        self.choices.iter().find(|choice| choice.reading.quantity == Some(quantity))
    }

    fn chosen_values(&self, quantity: Quantity) -> Option<Vec<f64>> {
        let choice = self.chosen(quantity)?;
        Some(choice.reading.values(self.values(choice.column?)))
    }

    fn time(&mut self, rate_hz: Option<f64>) {
        // "T" beside "t" is a temperature: it goes up and down
        for i in
            self.with(|c| c.unit.is_none() && c.said.as_ref().is_some_and(|s| s.role == Role::Time && s.word == "t"))
        {
            let goes_on = self.table.columns[i].clock || clock::increases(self.values(i), true);
            if let Some(said) = self.candidates[i].said.as_mut().filter(|_| !goes_on) {
                said.role = Role::Temperature;
            }
        }
        let columns = &self.table.columns;
        let is_time = |i: &usize| self.candidates[*i].is(Role::Time) || columns[*i].clock;
        let named: Vec<usize> = (0..columns.len()).filter(is_time).collect();
        // the unit stated, a clock, then a bare name; of times of day and dates the ones that go on
        let rank = |i: &usize| match (columns[*i].clock, self.candidates[*i].unit) {
            (false, Some(_)) => 0,
            (true, _) => 1,
            (false, None) => 2,
        };
        let mut increasing: Vec<usize> =
            named.iter().copied().filter(|i| clock::increases(self.values(*i), false)).collect();
        increasing.sort_by_key(rank);
        if let (Some(&time), None) = (increasing.first(), rate_hz) {
            let mut reading = clock::of_column(&columns[time], self.candidates[time].unit);
            if let Some(unknown) =
                self.candidates[time].unknown_unit.as_ref().filter(|_| self.candidates[time].unit.is_none())
            {
                reading.doubt(format!("its unit \"{unknown}\" is unknown"));
            }
            for &other in increasing.iter().skip(1) {
                self.remarks.push((other, "another time".into()));
            }
            return self.choices.push(Choice { column: Some(time), reading });
        }
        let sample = self.with(|c| c.is(Role::Sample)).into_iter().find(|i| {
            let values = self.values(*i);
            clock::increases(values, false) && values.windows(2).all(|w| w[1] - w[0] == 1.0)
        });
        if let Some(reading) = clock::of_rows(self.table, rate_hz) {
            named.iter().for_each(|i| self.remarks.push((*i, "a time that is not used".into())));
            return self.choices.push(Choice { column: sample, reading });
        }
        if let Some((_, reading)) = named.iter().find_map(|i| Some((i, clock::between_ticks(&columns[*i])?))) {
            named.iter().for_each(|i| self.remarks.push((*i, "a time that stands still".into())));
            return self.choices.push(Choice { column: None, reading });
        }
        // the only column that goes up steadily, and has no other meaning
        let steady = self.with(|c| c.role().is_none()).into_iter().find(|i| clock::increases(self.values(*i), false));
        if let (Some(time), true) = (steady, named.is_empty()) {
            let mut reading = clock::of_column(&columns[time], self.candidates[time].unit);
            reading.because("its numbers go up from row to row");
            reading.doubt("its name does not say that it is a time");
            return self.choices.push(Choice { column: Some(time), reading });
        }
        match named.first() {
            Some(&time) => {
                let values = self.values(time);
                let at = values.windows(2).position(|pair| pair[1] <= pair[0] || pair[1].is_nan());
                let line = at
                    .and_then(|row| self.table.lines.get(row + 1))
                    .map_or(String::new(), |line| format!(" at line {line}"));
                self.doubts.push(format!(
                    "the time \"{}\" does not go on{line}: cut the file there, or give the rate of its rows with --rate",
                    self.name(time)
                ));
            }
            None => self.doubts.push(
                "no column is a time: give the rate of its rows with --rate HZ, and their number is taken".to_string(),
            ),
        }
    }

    /// Temperatures of which the name does not say whether they are the wire's or the air's.
    fn temperatures(&mut self) {
        let open = self.with(|c| c.is(Role::Temperature));
        let rise = |of: &Self, i: usize| {
            let factor = of.candidates[i].unit.map_or(1.0, |u| u.factor);
            let [low, high] = quantiles(of.values(i), [0.02, 0.98]);
            (high - low) * factor
        };
        let mut by_rise: Vec<(f64, usize)> = open.iter().map(|i| (rise(self, *i), *i)).collect();
        by_rise.sort_by(|a, b| b.0.total_cmp(&a.0));
        let has = |of: &Self, quantity| of.candidates.iter().any(|c| c.is(Role::Is(quantity)));
        for (rank, (rise_k, i)) in by_rise.into_iter().enumerate() {
            let quantity = match rank {
                0 if rise_k > 15.0 && !has(self, Quantity::TemperatureC) => Quantity::TemperatureC,
                _ if rise_k < 6.0 && !has(self, Quantity::AmbientC) => Quantity::AmbientC,
                _ => {
                    let words = format!("a temperature that rises by {} K: the wire's or the air's?", figure(rise_k));
                    self.remarks.push((i, words));
                    continue;
                }
            };
            let said = self.candidates[i].said.as_mut();
            if let Some(said) = said {
                said.role = Role::Is(quantity);
            }
            let of = if quantity == Quantity::AmbientC { "air" } else { "wire" };
            self.remarks.push((i, format!("rises by {} K: that of the {of}", figure(rise_k))));
        }
    }

    /// Voltages of which the name does not say where they are.
    fn voltages(&mut self) {
        for i in self.with(|c| c.is(Role::Voltage)) {
            let [low, middle, high] = quantiles(self.values(i), [0.05, 0.5, 0.95]);
            let steady = middle != 0.0 && (high - low).abs() < 0.15 * middle.abs();
            let has = |quantity| self.candidates.iter().any(|c| c.is(Role::Is(quantity)));
            let (quantity, why) = match steady {
                true if !has(Quantity::SupplyV) => (Quantity::SupplyV, "hardly changes: that of the supply"),
                false if !has(Quantity::V3V) => (Quantity::V3V, "comes and goes: that over the wire, as v3_v"),
                _ => {
                    self.remarks.push((i, "a voltage of which it is not clear where it was measured".into()));
                    continue;
                }
            };
            if let Some(said) = self.candidates[i].said.as_mut() {
                said.role = Role::Is(quantity);
            }
            self.remarks.push((i, why.into()));
        }
    }

    /// Chooses the column for a quantity.
    fn quantity(&mut self, quantity: Quantity) {
        let mut open = self.with(|c| c.is(Role::Is(quantity)));
        let derived = |of: &Self, i: &usize| of.candidates[*i].said.as_ref().is_some_and(|s| s.derived);
        let by_unit = |of: &Self, i: &usize| of.candidates[*i].said.as_ref().is_some_and(|s| s.word == "its unit");
        let empty = |of: &Self, i: &usize| range(of.values(*i)).0.is_nan();
        // a word before a bare unit, what was measured before what was computed of it, something before nothing
        for worse in [&empty as &dyn Fn(&Self, &usize) -> bool, &by_unit, &derived] {
            let better: Vec<usize> = open.iter().copied().filter(|i| !worse(self, i)).collect();
            if !better.is_empty() {
                for i in open.iter().filter(|i| !better.contains(i)) {
                    self.remarks
                        .push((*i, format!("{}, but \"{}\" is taken for that", quantity.name(), self.name(better[0]))));
                }
                open = better;
            }
        }
        match open[..] {
            [] => {}
            [only] => {
                let candidate = &self.candidates[only];
                let mut reading = measured(quantity, candidate.unit, self.values(only), self.bench);
                if let Some(unknown) = candidate.unknown_unit.as_ref().filter(|_| candidate.unit.is_none()) {
                    reading.doubt(format!("its unit \"{unknown}\" is unknown"));
                }
                self.choices.push(Choice { column: Some(only), reading });
            }
            _ => {
                let names: Vec<String> = open.iter().map(|i| format!("\"{}\"", self.name(*i))).collect();
                self.doubts.push(format!(
                    "{} may be any of {}: none is taken, choose one in the mapping",
                    quantity.name(),
                    names.join(", ")
                ));
                open.iter().for_each(|i| self.remarks.push((*i, format!("{}, as others may be", quantity.name()))));
            }
        }
    }

    /// Lengths, strains and stresses are elongations and forces of a wire whose size is known.
    fn instead(&mut self) {
        for (role, quantity) in
            [(Role::Length, Quantity::PositionM), (Role::Strain, Quantity::PositionM), (Role::Stress, Quantity::ForceN)]
        {
            for i in self.with(|c| c.is(role)) {
                let word = match role {
                    Role::Length => "the wire's length",
                    Role::Strain => "a strain",
                    _ => "a stress",
                };
                let taken = self.chosen(quantity).is_some();
                let Some(bench) = self.bench.filter(|_| !taken) else {
                    let why = if taken { "not needed" } else { "with --rig it can be taken" };
                    self.remarks.push((i, format!("{word}: {why}")));
                    continue;
                };
                let unit = self.candidates[i].unit;
                let mut reading = match role {
                    Role::Length => measured(quantity, unit, self.values(i), self.bench),
                    _ => {
                        let per = if role == Role::Strain { bench.length_m } else { bench.area_m2 };
                        let mut reading = Reading::new(Some(quantity));
                        let usual = if role == Role::Strain { (0.01, "%") } else { (1e6, "MPa") };
                        let (factor, symbol) = unit.map_or(usual, |unit| (unit.factor, unit.symbol));
                        (reading.scale, reading.unit) = (factor * per, symbol.into());
                        reading.because(match role {
                            Role::Strain => format!("a strain, times the wire's length {} m", bench.length_m),
                            _ => format!("a stress, times the wire's cross-section {:.3e} m²", bench.area_m2),
                        });
                        if unit.is_none() {
                            reading.doubt(format!("has no unit: taken for {symbol}"));
                        }
                        reading
                    }
                };
                if let (Role::Length, None) = (role, unit) {
                    // a whole length says its unit by being that of the wire
                    let [middle] = quantiles(self.values(i), [0.5]);
                    let units = [(1e-3, "mm"), (1.0, "m"), (1e-2, "cm")];
                    if let Some((factor, symbol)) =
                        units.into_iter().find(|(f, _)| (middle * f / bench.length_m - 1.0).abs() < 0.3)
                    {
                        (reading.scale, reading.unit) = (factor, symbol.into());
                        reading.doubts =
                            vec![format!("has no unit: taken for {symbol}, which makes it this wire's length")];
                    }
                }
                self.choices.push(Choice { column: Some(i), reading });
            }
        }
    }

    /// What voltage and current say together.
    fn voltages_by_ohms_law(&mut self) {
        let Some(bench) = self.bench else { return };
        let (Some(volts), Some(amps)) = (self.chosen_values(Quantity::V3V), self.chosen_values(Quantity::CurrentA))
        else {
            return;
        };
        let [most] = quantiles(&amps, [0.98]);
        let ratios: Vec<f64> = volts.iter().zip(&amps).filter(|(_, i)| **i > 0.3 * most).map(|(u, i)| u / i).collect();
        let [ohm] = quantiles(&ratios, [0.5]);
        let expected = bench.resistance_ohm;
        let Some(choice) = self.choices.iter_mut().find(|c| c.reading.quantity == Some(Quantity::V3V)) else { return };
        let said =
            format!("over the current it is {} Ω, the rig file's wire has about {} Ω", figure(ohm), figure(expected));
        match ohm / expected {
            near if (0.4..2.5).contains(&near) => choice.reading.because(said),
            near if near.is_finite() => choice.reading.doubt(format!("{said}: units, or which wire it is?")),
            _ => {}
        }
    }

    /// Directions and zeros, by what heat does.
    fn directions(&mut self) {
        let time_s = self.choices.iter().find(|c| c.reading.quantity.is_none()).map(|time| match time.column {
            Some(column) => time.reading.values(self.values(column)),
            None => (0..self.table.len()).map(|row| row as f64 * time.reading.scale).collect(),
        });
        let order = [
            self.bench.map(|bench| bench.drive),
            Some(Quantity::TemperatureC),
            Some(Quantity::PowerW),
            Some(Quantity::Duty),
            Some(Quantity::CurrentA),
        ];
        let heating = order.into_iter().flatten().find_map(|quantity| {
            let values = self.chosen_values(quantity)?;
            let [low, high] = quantiles(&values, [0.02, 0.98]);
            (high > low).then_some((quantity, values))
        });
        let heat = match (&time_s, heating) {
            (Some(time_s), Some((quantity, values))) => Some(Heat {
                by: quantity.name(),
                time_s,
                values: if quantity == Quantity::CurrentA { values.iter().map(|i| i * i).collect() } else { values },
                at_once: quantity == Quantity::TemperatureC,
            }),
            _ => None,
        };
        for choice in &mut self.choices {
            let Some(column) = choice.column else { continue };
            let raw = &self.table.columns[column].values;
            let shortening = self.candidates[column].said.as_ref().is_some_and(|s| s.shortening);
            match choice.reading.quantity {
                Some(Quantity::PositionM) => position(&mut choice.reading, raw, heat.as_ref(), self.bench, shortening),
                Some(Quantity::ForceN) => force(&mut choice.reading, raw),
                _ => {}
            }
        }
    }

    /// Power against voltage times current.
    fn power(&mut self) {
        let of = |quantity| self.chosen_values(quantity);
        let (Some(watts), Some(volts), Some(amps)) = (of(Quantity::PowerW), of(Quantity::V3V), of(Quantity::CurrentA))
        else {
            return;
        };
        let [most] = quantiles(&watts, [0.98]);
        let ratios: Vec<f64> = watts
            .iter()
            .zip(volts.iter().zip(&amps))
            .filter(|(p, _)| **p > 0.3 * most)
            .map(|(p, (u, i))| p / (u * i))
            .collect();
        let [ratio] = quantiles(&ratios, [0.5]);
        let Some(choice) = self.choices.iter_mut().find(|c| c.reading.quantity == Some(Quantity::PowerW)) else {
            return;
        };
        if (0.8..1.25).contains(&ratio) {
            choice.reading.because("is voltage times current");
        } else if ratio.is_finite() && !(0.02..1.25).contains(&ratio) {
            choice
                .reading
                .doubt(format!("is {} times voltage times current: are all three units right?", figure(ratio)));
        }
    }

    fn what_is_missing(&mut self) {
        let Some(bench) = self.bench else { return };
        for needed in [Some(bench.drive), bench.imposed].into_iter().flatten() {
            if self.chosen(needed).is_none() {
                let mut doubt =
                    format!("no column is taken for {}, which the rig file's wire is driven by", needed.name());
                let drives = [DriveKind::Pwm, DriveKind::Power, DriveKind::Current, DriveKind::Temperature];
                let other = drives.into_iter().find(|kind| self.chosen(drive_column(*kind)).is_some());
                if let (true, Some(kind)) = (needed == bench.drive, other) {
                    let (column, word) = (drive_column(kind).name(), drive_word(kind));
                    doubt += &format!("; if {column} is what drove it, set kind = \"{word}\" in the channel's drive");
                }
                self.doubts.push(doubt);
            }
        }
    }

    fn guess(self) -> Guess {
        let mut mapping = Mapping { format: self.table.format.clone(), ..Mapping::default() };
        let mut columns: Vec<Understood> = Vec::new();
        for choice in &self.choices {
            let column = choice.column.map_or(ROW_NUMBER, |i| self.name(i)).to_string();
            let (scale, offset) = (choice.reading.scale, choice.reading.offset);
            mapping.columns.insert(choice.reading.name().into(), Mapped { column, scale, offset });
        }
        for (i, column) in self.table.columns.iter().enumerate() {
            let remarks = || self.remarks.iter().filter(|(of, _)| *of == i).map(|(_, words)| words.clone());
            let choice = self.choices.iter().find(|choice| choice.column == Some(i));
            columns.push(match choice {
                Some(Choice { reading, .. }) => Understood {
                    column: column.name.clone(),
                    quantity: Some(reading.name()),
                    words: reading.name().into(),
                    unit: reading.unit.clone(),
                    scale: reading.scale,
                    offset: reading.offset,
                    range: range(&reading.values(&column.values)),
                    evidence: remarks().chain(reading.evidence.iter().cloned()).collect(),
                    doubts: reading.doubts.clone(),
                },
                None => {
                    let candidate = &self.candidates[i];
                    let words = remarks().next().unwrap_or_else(|| match candidate.role() {
                        Some(Role::Resistance) => "a resistance: a recording has none".into(),
                        Some(Role::Wanted) => "what was asked for, not what was measured".into(),
                        Some(Role::Sample) => "the sample's number".into(),
                        Some(Role::Time) => "a time that does not go on".into(),
                        Some(Role::Other) => "nothing a recording has".into(),
                        _ => "not understood".into(),
                    });
                    let shown = candidate.unit.filter(|u| u.dimension != Dimension::Other).map_or("", |u| u.symbol);
                    Understood {
                        column: column.name.clone(),
                        quantity: None,
                        words,
                        unit: column.unit.clone().unwrap_or_else(|| shown.into()),
                        scale: 1.0,
                        offset: 0.0,
                        range: range(&column.values),
                        evidence: remarks().skip(1).collect(),
                        doubts: Vec::new(),
                    }
                }
            });
        }
        if let Some(Choice { reading, .. }) = self.choices.iter().find(|choice| choice.column.is_none()) {
            let last = self.table.len().saturating_sub(1) as f64;
            columns.push(Understood {
                column: ROW_NUMBER.into(),
                quantity: Some(reading.name()),
                words: format!("{} from the row's number", reading.name()),
                unit: reading.unit.clone(),
                scale: reading.scale,
                offset: reading.offset,
                range: (reading.offset, last * reading.scale + reading.offset),
                evidence: reading.evidence.clone(),
                doubts: reading.doubts.clone(),
            });
        }
        Guess { columns, mapping, doubts: self.doubts }
    }
}
