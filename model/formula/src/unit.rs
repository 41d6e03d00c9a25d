//! Units as people write them, and what they measure.

use std::fmt;
use std::ops::{Div, Mul};
use std::str::FromStr;

use crate::error::{Error, Place};

/// Exponents are kept in twelfths, so that roots of roots have one.
const PARTS: i16 = 12;
/// The longest text that is a unit.
const MOST_CHARACTERS: usize = 60;
/// The largest exponent of a unit.
const MOST_EXPONENT: i16 = 12;

/// What a quantity measures: exponents of m, kg, s, A and K. The default has none, as a ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dimension([i16; 5]);

impl Dimension {
    /// Of pure numbers.
    pub const NONE: Dimension = Dimension([0; 5]);

    const fn of(m: i16, kg: i16, s: i16, a: i16, k: i16) -> Dimension {
        Dimension([m * PARTS, kg * PARTS, s * PARTS, a * PARTS, k * PARTS])
    }

    /// Of a power; `None` where that has no exponents in twelfths, or huge ones.
    pub fn power(self, exponent: f64) -> Option<Dimension> {
        let mut of = self.0;
        for part in &mut of {
            let raised = f64::from(*part) * exponent;
            if (raised - raised.round()).abs() > 1e-9 || raised.abs() > f64::from(MOST_EXPONENT * PARTS) {
                return None;
            }
            *part = raised.round() as i16;
        }
        Some(Dimension(of))
    }
}

impl Mul for Dimension {
    type Output = Dimension;

    fn mul(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i].saturating_add(other.0[i])))
    }
}

impl Div for Dimension {
    type Output = Dimension;

    fn div(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i].saturating_sub(other.0[i])))
    }
}

/// As the shortest common unit that has it: `W`, `W/K`, `m kg/s²`.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const KNOWN: [(&str, Dimension); 7] = [
            ("W", WATT),
            ("N", NEWTON),
            ("Pa", PASCAL),
            ("J", JOULE),
            ("V", VOLT),
            ("Ω", OHM),
            ("Hz", Dimension::of(0, 0, -1, 0, 0)),
        ];
        if *self == Dimension::NONE {
            return f.write_str("a number without unit");
        }
        if let Some((name, _)) = KNOWN.iter().find(|(_, of)| of == self) {
            return f.write_str(name);
        }
        // a known unit by a base unit
        for (name, of) in KNOWN.iter().take(6) {
            for (base, by) in BASES {
                if *of / by == *self {
                    return write!(f, "{name}/{base}");
                }
                if *of * by == *self {
                    return write!(f, "{name} {base}");
                }
            }
        }
        let mut separator = "";
        for ((name, _), &exponent) in BASES.iter().zip(&self.0) {
            if exponent != 0 {
                write!(f, "{separator}{name}")?;
                separator = " ";
                if exponent % PARTS != 0 {
                    write!(f, "^{}", f64::from(exponent) / f64::from(PARTS))?;
                } else if exponent != PARTS {
                    write!(f, "^{}", exponent / PARTS)?;
                }
            }
        }
        Ok(())
    }
}

const BASES: [(&str, Dimension); 5] = [
    ("m", Dimension::of(1, 0, 0, 0, 0)),
    ("kg", Dimension::of(0, 1, 0, 0, 0)),
    ("s", Dimension::of(0, 0, 1, 0, 0)),
    ("A", Dimension::of(0, 0, 0, 1, 0)),
    ("K", Dimension::of(0, 0, 0, 0, 1)),
];
const NEWTON: Dimension = Dimension::of(1, 1, -2, 0, 0);
const PASCAL: Dimension = Dimension::of(-1, 1, -2, 0, 0);
const JOULE: Dimension = Dimension::of(2, 1, -2, 0, 0);
const WATT: Dimension = Dimension::of(2, 1, -3, 0, 0);
const VOLT: Dimension = Dimension::of(2, 1, -3, -1, 0);
const OHM: Dimension = Dimension::of(2, 1, -3, -2, 0);

/// Units by their symbol: SI per unit, what it measures, and whether it takes prefixes.
const SYMBOLS: [(&str, f64, Dimension, bool); 20] = [
    ("m", 1.0, BASES[0].1, true),
    ("g", 1e-3, BASES[1].1, true),
    ("s", 1.0, BASES[2].1, true),
    ("A", 1.0, BASES[3].1, true),
    ("K", 1.0, BASES[4].1, true),
    // counted from the ice point, as every temperature here
    ("°C", 1.0, BASES[4].1, false),
    ("degC", 1.0, BASES[4].1, false),
    ("N", 1.0, NEWTON, true),
    ("Pa", 1.0, PASCAL, true),
    ("J", 1.0, JOULE, true),
    ("W", 1.0, WATT, true),
    ("V", 1.0, VOLT, true),
    ("Ω", 1.0, OHM, true),
    ("ohm", 1.0, OHM, true),
    ("Hz", 1.0, Dimension::of(0, 0, -1, 0, 0), true),
    ("min", 60.0, BASES[2].1, false),
    ("h", 3600.0, BASES[2].1, false),
    ("rad", 1.0, Dimension::NONE, false),
    ("%", 0.01, Dimension::NONE, false),
    ("1", 1.0, Dimension::NONE, false),
];

/// Prefixes; `u` for those without a µ, which has two characters of its own.
const PREFIXES: [(char, f64); 9] =
    [('n', 1e-9), ('µ', 1e-6), ('μ', 1e-6), ('u', 1e-6), ('m', 1e-3), ('c', 1e-2), ('k', 1e3), ('M', 1e6), ('G', 1e9)];

/// A unit: what it measures, and how much of it in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// SI units in one of it.
    pub si: f64,
    /// What it measures.
    pub dimension: Dimension,
}

impl Unit {
    /// Reads a unit: `W/(m² K)`, `mΩ`, `1/K`, `N s/m`, `m^2`, `%`, `1`. A slash holds for the factor behind it.
    ///
    /// # Errors
    /// What cannot be read, with its place.
    pub fn parse(text: &str) -> Result<Unit, Error> {
        if text.chars().count() > MOST_CHARACTERS {
            return Err(Error::new(0..text.len(), format!("a unit has at most {MOST_CHARACTERS} characters")));
        }
        let mut reader = Reader { text, at: 0 };
        let unit = reader.product()?;
        match reader.rest() {
            "" => Ok(unit),
            rest => Err(Error::new(reader.at..text.len(), format!("`{rest}` does not belong to a unit"))),
        }
    }
}

impl FromStr for Unit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Unit, Error> {
        Unit::parse(text)
    }
}

/// Reads a unit from left to right.
struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_spaces(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn take(&mut self, any: &[char]) -> Option<char> {
        let next = self.rest().chars().next().filter(|next| any.contains(next))?;
        self.at += next.len_utf8();
        Some(next)
    }

    /// Factors, multiplied and divided.
    fn product(&mut self) -> Result<Unit, Error> {
        self.skip_spaces();
        let mut product = self.factor()?;
        loop {
            self.skip_spaces();
            let over = match self.take(&['/', '*', '·']) {
                Some('/') => true,
                Some(_) => false,
                None if self.rest().is_empty() || self.rest().starts_with(')') => return Ok(product),
                None => false,
            };
            self.skip_spaces();
            let Unit { si, dimension } = self.factor()?;
            product = match over {
                true => Unit { si: product.si / si, dimension: product.dimension / dimension },
                false => Unit { si: product.si * si, dimension: product.dimension * dimension },
            };
        }
    }

    /// A symbol or something in parentheses, with its exponent.
    fn factor(&mut self) -> Result<Unit, Error> {
        let from = self.at;
        let unit = match self.take(&['(']) {
            Some(_) => {
                let inner = self.product()?;
                self.take(&[')']).ok_or_else(|| Error::new(from..self.at, "this parenthesis is not closed"))?;
                inner
            }
            None => self.symbol()?,
        };
        let exponent = self.exponent()?;
        let dimension = unit.dimension.power(exponent).filter(|_| exponent.abs() <= f64::from(MOST_EXPONENT));
        let dimension = dimension.ok_or_else(|| Error::new(from..self.at, "no unit has this exponent"))?;
        Ok(Unit { si: unit.si.powf(exponent), dimension })
    }

    fn symbol(&mut self) -> Result<Unit, Error> {
        let rest = self.rest();
        let end = if rest.starts_with('1') {
            1
        } else {
            rest.find(|c: char| !(c.is_alphabetic() || matches!(c, '°' | '%'))).unwrap_or(rest.len())
        };
        let (from, symbol) = (self.at, &rest[..end]);
        self.at += end;
        let at: Place = from..self.at.max(from + rest.chars().next().map_or(0, char::len_utf8));
        known(symbol).ok_or_else(|| match symbol {
            "" if rest.is_empty() => Error::new(at, "a unit is missing here"),
            "" => Error::new(at, "a unit begins with its symbol, such as W, mm or °C"),
            _ => {
                Error::new(at, format!("there is no unit `{symbol}` here: SI units with prefixes, °C, min, h, % and 1"))
            }
        })
    }

    /// `²`, `^-2`, `-2`, `^0.5`; 1 where there is none.
    fn exponent(&mut self) -> Result<f64, Error> {
        let from = self.at;
        let marked = self.take(&['^']).is_some();
        let negative = self.take(&['-', '−', '⁻']).is_some();
        let raised = [('¹', 1.0), ('²', 2.0), ('³', 3.0)];
        let raised = self
            .take(&raised.map(|(sign, _)| sign))
            .and_then(|found| raised.iter().find(|(sign, _)| *sign == found).map(|(_, exponent)| *exponent));
        let size = match raised {
            Some(raised) => raised,
            None => {
                let rest = self.rest();
                let end = rest.find(|c: char| !(c.is_ascii_digit() || marked && c == '.')).unwrap_or(rest.len());
                self.at += end;
                match &rest[..end] {
                    "" if !marked && !negative => 1.0,
                    digits => digits.parse().map_err(|_| Error::new(from..self.at, "an exponent is missing here"))?,
                }
            }
        };
        Ok(if negative { -size } else { size })
    }
}

/// A symbol, with a prefix or without.
fn known(symbol: &str) -> Option<Unit> {
    let plain = |symbol: &str, prefixed: bool| {
        SYMBOLS
            .iter()
            .find(|(name, _, _, takes)| *name == symbol && (!prefixed || *takes))
            .map(|&(_, si, dimension, _)| Unit { si, dimension })
    };
    plain(symbol, false).or_else(|| {
        let mut characters = symbol.chars();
        let first = characters.next()?;
        let (_, factor) = PREFIXES.iter().find(|(prefix, _)| *prefix == first)?;
        let unit = plain(characters.as_str(), true)?;
        Some(Unit { si: factor * unit.si, ..unit })
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn si(text: &str) -> f64 {
        Unit::parse(text).unwrap().si
    }

    #[test]
    fn units_are_read_as_people_write_them() {
        for (text, expected) in [
            ("1", 1.0),
            ("%", 0.01),
            ("mm", 1e-3),
            ("min", 60.0),
            ("ms", 1e-3),
            ("mΩ", 1e-3),
            ("kohm", 1e3),
            ("µm", 1e-6),
            ("um", 1e-6),
            ("g", 1e-3),
            ("kg", 1.0),
            ("MPa", 1e6),
            ("1/MPa", 1e-6),
            ("mW/(cm² K)", 10.0),
            ("mW/cm^2/K", 10.0),
            ("mW cm-2 K⁻¹", 10.0),
            ("N·s/mm", 1e3),
            ("K/h", 1.0 / 3600.0),
        ] {
            assert!((si(text) / expected - 1.0).abs() < 1e-12, "{text}: {}", si(text));
        }
    }

    #[test]
    fn what_they_measure_is_known() {
        let of = |text: &str| Unit::parse(text).unwrap().dimension;
        assert_eq!(of("V A"), of("W"));
        assert_eq!(of("N/m²"), of("Pa"));
        assert_eq!(of("V/A"), of("Ω"));
        assert_eq!(of("°C"), of("K"));
        assert_eq!(of("1/Hz"), of("s"));
        assert_eq!(of("mm/m"), Dimension::NONE);
        assert_ne!(of("N"), of("J"));
        assert_eq!(of("W/(m² K)").to_string(), "kg s^-3 K^-1");
        assert_eq!(of("mW/K").to_string(), "W/K");
        assert_eq!(of("K s").to_string(), "s K");
        assert_eq!(of("m²").power(0.5), Some(of("m")));
        assert_eq!(of("m").power(0.1), None);
        assert_eq!(of("m^0.5").power(2.0), Some(of("m")));
    }

    #[test]
    fn what_is_none_is_said_with_its_place() {
        for (text, at, what) in [
            ("W/", 2..2, "missing"),
            ("", 0..0, "missing"),
            ("W/(m K", 2..6, "not closed"),
            ("parsec", 0..6, "no unit `parsec`"),
            ("kmin", 0..4, "no unit"),
            ("W m^", 3..4, "exponent is missing"),
            ("W)", 1..2, "does not belong"),
            ("m^99", 0..4, "no unit has this exponent"),
            ("(m^9)^9", 0..7, "no unit has this exponent"),
            ("m^0.1", 0..5, "no unit has this exponent"),
            ("m^.", 1..3, "exponent is missing"),
            ("W $", 2..3, "begins with its symbol"),
        ] {
            let error = Unit::parse(text).unwrap_err();
            assert!(error.what.contains(what), "{text}: {error}");
            assert!(text.get(error.at.clone()).is_some(), "{text}: {:?}", error.at);
            assert!(error.at.start >= at.start && error.at.end <= at.end.max(at.start), "{text}: {:?}", error.at);
        }
    }

    proptest! {
        #[test]
        fn no_text_is_too_much(text in "\\PC{0,40}") {
            if let Err(error) = Unit::parse(&text) {
                prop_assert!(text.get(error.at.clone()).is_some(), "{:?}", error.at);
            }
        }
    }
}
