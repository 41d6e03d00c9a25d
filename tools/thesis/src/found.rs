//! What comes out of a row: numbers beside what is wanted of them, and pictures.

use std::error::Error;
use std::fmt;

use sinew_plot::quantity::{number, shown_unit};
use sinew_plot::{Drawing, Ink};

/// What computing gives, or why it does not.
pub type Tried<T> = Result<T, Box<dyn Error>>;

/// What is wanted of a number: it stands in the row's source, and nothing moves it as the row is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// This value, or as near to it as this.
    Near {
        /// The value.
        value: f64,
        /// The most it may differ by, in its unit.
        within: f64,
    },
    /// Between these two, both included.
    Between(f64, f64),
    /// Less than this.
    Below(f64),
    /// More than this.
    Above(f64),
}

impl Wanted {
    /// Whether a number is as wanted; one that is none is not.
    pub fn holds(&self, found: f64) -> bool {
        match *self {
            Wanted::Near { value, within } => (found - value).abs() <= within,
            Wanted::Between(low, high) => (low..=high).contains(&found),
            Wanted::Below(limit) => found < limit,
            Wanted::Above(limit) => found > limit,
        }
    }
}

impl fmt::Display for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Wanted::Near { value, within } if within <= 1e-5 * value.abs() => write!(f, "{}", number(value)),
            Wanted::Near { value, within } => write!(f, "{} ± {}", number(value), number(within)),
            Wanted::Between(low, high) => write!(f, "{} to {}", number(low), number(high)),
            Wanted::Below(limit) => write!(f, "below {}", number(limit)),
            Wanted::Above(limit) => write!(f, "above {}", number(limit)),
        }
    }
}

/// One number beside what is wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What it is.
    pub what: String,
    /// Its unit; `1` for none.
    pub unit: &'static str,
    /// What is wanted.
    pub wanted: Wanted,
    /// What came out.
    pub found: f64,
    /// It proves why a row differs; the others say what the thesis states.
    pub proof: bool,
}

impl Check {
    /// Whether it came out as wanted.
    pub fn holds(&self) -> bool {
        self.wanted.holds(self.found)
    }

    /// What came out, with its unit.
    pub fn value(&self) -> String {
        with_unit(number(self.found), self.unit)
    }

    /// What is wanted, with its unit.
    pub fn demand(&self) -> String {
        with_unit(self.wanted.to_string(), self.unit)
    }
}

fn with_unit(number: String, unit: &str) -> String {
    match shown_unit(unit) {
        "" => number,
        unit => format!("{number} {unit}"),
    }
}

/// A figure made again: drawings under one legend.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Picture {
    /// What the inks stand for.
    pub legend: Vec<(Ink, String)>,
    /// The drawings.
    pub drawings: Vec<Drawing>,
}

/// What came out of a row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// The numbers.
    pub checks: Vec<Check>,
    /// The figure, where the row is one.
    pub picture: Picture,
    proving: bool,
}

impl Found {
    fn check(&mut self, what: &str, unit: &'static str, wanted: Wanted, found: f64) {
        self.checks.push(Check { what: what.into(), unit, wanted, found, proof: self.proving });
    }

    /// The value is stated, and holds to within `within`, in its unit.
    pub fn near(&mut self, what: &str, unit: &'static str, value: f64, within: f64, found: f64) {
        self.check(what, unit, Wanted::Near { value, within }, found);
    }

    /// Equal but for rounding: to one part in a thousand million.
    pub fn equal(&mut self, what: &str, unit: &'static str, value: f64, found: f64) {
        self.near(what, unit, value, 1e-9 * value.abs(), found);
    }

    /// Next to nothing: no more than `most` in its unit, either way.
    pub fn nothing(&mut self, what: &str, unit: &'static str, most: f64, found: f64) {
        self.near(what, unit, 0.0, most, found);
    }

    /// Between two bounds.
    pub fn between(&mut self, what: &str, unit: &'static str, low: f64, high: f64, found: f64) {
        self.check(what, unit, Wanted::Between(low, high), found);
    }

    /// Less than a bound.
    pub fn below(&mut self, what: &str, unit: &'static str, limit: f64, found: f64) {
        self.check(what, unit, Wanted::Below(limit), found);
    }

    /// More than a bound.
    pub fn above(&mut self, what: &str, unit: &'static str, limit: f64, found: f64) {
        self.check(what, unit, Wanted::Above(limit), found);
    }

    /// What is checked from here on proves why the row differs from the thesis.
    pub fn proof(&mut self) {
        self.proving = true;
    }

    /// Draws one line of the figure; lines of one name are drawn over each other, `across` and `up` are name and unit.
    pub fn line(
        &mut self,
        across: (&'static str, &'static str),
        up: (&'static str, &'static str),
        ink: Ink,
        (x, y): (Vec<f64>, Vec<f64>),
    ) {
        let trace = sinew_plot::Trace { ink, x, y };
        let same = |drawing: &&mut Drawing| (drawing.name, drawing.x) == (up.0, across);
        match self.picture.drawings.iter_mut().find(same) {
            Some(drawing) => drawing.traces.push(trace),
            None => self.picture.drawings.push(Drawing {
                name: up.0,
                unit: up.1,
                x: across,
                decades: (false, false),
                traces: vec![trace],
            }),
        }
    }

    /// Says what an ink stands for.
    pub fn legend(&mut self, ink: Ink, name: &str) {
        self.picture.legend.push((ink, name.into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_none_holds_nowhere() {
        for wanted in [
            Wanted::Near { value: 1.0, within: 10.0 },
            Wanted::Between(0.0, 2.0),
            Wanted::Below(1.0),
            Wanted::Above(1.0),
        ] {
            assert!(!wanted.holds(f64::NAN), "{wanted}");
        }
        assert!(Wanted::Near { value: 2.0, within: 0.5 }.holds(2.5) && !Wanted::Below(1.0).holds(1.0));
    }
}
