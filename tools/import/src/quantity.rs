//! Quantities of material tests, in a table that is no recording: which column, and its values in SI units.

use crate::error::{Error, shorten};
use crate::table::{Column, Table};
use crate::units::{Dimension, Unit, named, plain, unit};
use crate::words::{Role, said};

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Of the material, °C.
    Temperature,
    /// As a share.
    Strain,
    /// Pa.
    Stress,
    /// Elongation or deflection, m.
    Elongation,
    /// Pull, N.
    Force,
    /// Into the sample, W/kg; of a heat flow of the whole sample, W.
    HeatFlow,
    /// s.
    Time,
}

/// A column that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Its name in the file.
    pub column: String,
    /// Its values in SI units, temperatures in °C; NaN where a sample is missing.
    pub values: Vec<f64>,
    /// Its unit as the file has it; none where it says none, and SI is taken.
    pub unit: Option<&'static str>,
    /// Of a heat flow: it is that of the whole sample, W.
    pub is_of_sample: bool,
}

/// Words of a heat flow.
const HEAT_FLOW: [&str; 8] =
    ["heat flow", "heatflow", "heat_flow", "dsc", "wärmestrom", "waermestrom", "flux de chaleur", "熱流"];
/// Units of a heat flow by mass, W/kg.
const BY_MASS: [(&str, f64, &str); 4] =
    [("mw/mg", 1e3, "mW/mg"), ("w/g", 1e3, "W/g"), ("mw/g", 1.0, "mW/g"), ("w/kg", 1.0, "W/kg")];

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 7] = [
        Quantity::Temperature,
        Quantity::Strain,
        Quantity::Stress,
        Quantity::Elongation,
        Quantity::Force,
        Quantity::HeatFlow,
        Quantity::Time,
    ];

    /// Its word on a command line.
    pub const fn word(self) -> &'static str {
        match self {
            Quantity::Temperature => "temperature",
            Quantity::Strain => "strain",
            Quantity::Stress => "stress",
            Quantity::Elongation => "elongation",
            Quantity::Force => "force",
            Quantity::HeatFlow => "heat-flow",
            Quantity::Time => "time",
        }
    }

    fn name(self) -> String {
        self.word().replace('-', " ")
    }

    fn is(self, role: Role) -> bool {
        use sinew_recording::Column as Is;
        match self {
            Quantity::Temperature => matches!(role, Role::Temperature | Role::Is(Is::TemperatureC)),
            Quantity::Strain => role == Role::Strain,
            Quantity::Stress => role == Role::Stress,
            Quantity::Elongation => matches!(role, Role::Length | Role::Is(Is::PositionM)),
            Quantity::Force => role == Role::Is(Is::ForceN),
            Quantity::HeatFlow => false,
            Quantity::Time => role == Role::Time,
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            Quantity::Temperature => Dimension::Temperature,
            Quantity::Strain => Dimension::Ratio,
            Quantity::Stress => Dimension::Stress,
            Quantity::Elongation => Dimension::Length,
            Quantity::Force => Dimension::Force,
            Quantity::HeatFlow => Dimension::Power,
            Quantity::Time => Dimension::Time,
        }
    }
}

/// The column that holds `of`; `wanted` names it where its own name does not say so.
///
/// # Errors
/// There is none, or several; a named column that is not there; a unit that is another quantity's. The columns there are come with the hint.
pub fn quantity(table: &Table, of: Quantity, wanted: Option<&str>) -> Result<Found, Error> {
    let name = of.name();
    let columns = || table.columns.iter().map(|c| format!("\"{}\"", shorten(&c.name))).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = wanted {
        let column = table.column(wanted).ok_or_else(|| {
            Error::new(format!("has no column \"{}\"", shorten(wanted)), format!("its columns: {}", columns()))
        })?;
        return of_column(column, of);
    }
    let candidates: Vec<&Column> = table.columns.iter().filter(|column| is_called(column, of)).collect();
    match candidates.as_slice() {
        [one] => of_column(one, of),
        [] => Err(Error::new(
            format!("has no column that is called a {name}"),
            format!("name it: --column {}=NAME; its columns: {}", of.word(), columns()),
        )),
        several => Err(Error::new(
            format!(
                "has {} columns that may be the {name}: {}",
                several.len(),
                several.iter().map(|c| format!("\"{}\"", shorten(&c.name))).collect::<Vec<_>>().join(", ")
            ),
            format!("say which: --column {}=NAME", of.word()),
        )),
    }
}

/// Whether a column's name says that it is this.
fn is_called(column: &Column, of: Quantity) -> bool {
    if column.clock {
        return of == Quantity::Time;
    }
    if of == Quantity::HeatFlow {
        let name = column.name.to_lowercase();
        return HEAT_FLOW.iter().any(|word| name.contains(word)) || by_mass(column).is_some();
    }
    let parts = named(&column.name);
    let stated = stated(column);
    let is = said(&parts.name, stated.map(|unit| unit.dimension)).is_some_and(|said| of.is(said.role) && !said.derived);
    is && by_mass(column).is_none()
}

/// The unit that a column has, in its name or apart from it.
fn stated(column: &Column) -> Option<Unit> {
    let parts = named(&column.name);
    column.unit.as_deref().and_then(unit).or(parts.stated).or(parts.loose)
}

/// A heat flow by mass, W/kg.
fn by_mass(column: &Column) -> Option<(f64, &'static str)> {
    let text = plain(&format!("{} {}", column.name, column.unit.as_deref().unwrap_or_default()));
    BY_MASS.iter().find(|(spelling, ..)| text.contains(spelling)).map(|(_, factor, symbol)| (*factor, *symbol))
}

fn of_column(column: &Column, of: Quantity) -> Result<Found, Error> {
    let of_unit = |factor: f64, offset: f64, symbol, is_of_sample| Found {
        column: column.name.clone(),
        values: column.values.iter().map(|value| factor * value + offset).collect(),
        unit: symbol,
        is_of_sample,
    };
    if of == Quantity::HeatFlow
        && let Some((factor, symbol)) = by_mass(column)
    {
        return Ok(of_unit(factor, 0.0, Some(symbol), false));
    }
    match stated(column) {
        // the numbers of a clock are seconds already
        _ if column.clock => Ok(of_unit(1.0, 0.0, None, false)),
        Some(unit) if unit.dimension == of.dimension() => {
            Ok(of_unit(unit.factor, unit.offset, Some(unit.symbol), of == Quantity::HeatFlow))
        }
        Some(unit) if of != Quantity::HeatFlow => Err(Error::new(
            format!("column \"{}\" is in {}, which is no unit of a {}", shorten(&column.name), unit.symbol, of.name()),
            "name another column, or put its unit right in the file",
        )),
        _ => Ok(of_unit(1.0, 0.0, None, true)),
    }
}

#[cfg(test)]
mod tests {
    use sinew_rig::FileFormat;

    use super::*;

    fn table(text: &str) -> Table {
        crate::read_bytes(text.as_bytes(), &FileFormat::default()).expect("a table")
    }

    #[test]
    fn columns_are_found_by_their_names_and_brought_to_si() {
        let table =
            table("Temp./°C;DSC/(mW/mg);Dehnung [%];Spannung [MPa];Weg/mm\n20,0;0,5;1,0;100;2\n21,0;0,6;2,0;200;3\n");
        let of = |of| quantity(&table, of, None).expect("there is one");
        assert_eq!(of(Quantity::Temperature).values, [20.0, 21.0]);
        assert_eq!(of(Quantity::HeatFlow).values, [500.0, 600.0]);
        assert!(!of(Quantity::HeatFlow).is_of_sample);
        assert_eq!(of(Quantity::Strain).values, [0.01, 0.02]);
        assert_eq!(of(Quantity::Stress).values, [100e6, 200e6]);
        assert_eq!(of(Quantity::Elongation).values, [0.002, 0.003]);
    }

    #[test]
    fn what_is_missing_or_double_is_said_with_what_there_is() {
        let table = table("Temp1 (C),Temp2 (C),Heat Flow (mW),x\n1,2,3,4\n2,3,4,5\n");
        let error = quantity(&table, Quantity::Temperature, None).expect_err("two");
        assert!(error.to_string().contains("--column temperature=NAME"), "{error}");
        let named = quantity(&table, Quantity::Temperature, Some("Temp2 (C)")).expect("named");
        assert_eq!(named.values, [2.0, 3.0]);
        let flow = quantity(&table, Quantity::HeatFlow, None).expect("one");
        assert!(flow.is_of_sample && (flow.values[0] - 3e-3).abs() < 1e-12);
        let error = quantity(&table, Quantity::Strain, None).expect_err("none");
        assert!(error.hint.contains("\"Heat Flow (mW)\""), "{error}");
        assert!(quantity(&table, Quantity::Strain, Some("Temp1 (C)")).is_err());
        assert!(quantity(&table, Quantity::Strain, Some("nowhere")).is_err());
        assert_eq!(quantity(&table, Quantity::Strain, Some("x")).expect("no unit: a share").unit, None);
    }
}
