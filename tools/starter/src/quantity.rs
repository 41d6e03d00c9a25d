//! Quantities as people and data sheets write them: `160mm`, `6in`, `100g`, `0.8N`, `5V`, `150N/m`, `0.1 N/mm`.

use std::fmt;

/// What a text is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// m, cm, mm, in (inches); in m.
    Length,
    /// N, mN, g, kg, gf, kgf, oz, lb: a force, or what hangs; in N.
    Force,
    /// N/m, N/mm, g/mm; in N/m.
    Stiffness,
    /// V, mV; in V.
    Voltage,
}

/// Newtons of a kilogram that hangs.
const KG_N: f64 = sinew_physics::formulas::STANDARD_GRAVITY_M_S2;

impl Quantity {
    /// Its units with what one of them is in SI's; the first is the one meant where none is given, if one is.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Quantity::Length => &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 25.4e-3)],
            Quantity::Force => &[
                ("N", 1.0),
                ("mN", 1e-3),
                ("g", 1e-3 * KG_N),
                ("gf", 1e-3 * KG_N),
                ("kg", KG_N),
                ("kgf", KG_N),
                ("oz", 28.349_523_125e-3 * KG_N),
                ("lb", 0.453_592_37 * KG_N),
            ],
            Quantity::Stiffness => &[("N/m", 1.0), ("N/mm", 1e3), ("g/mm", KG_N), ("gf/mm", KG_N)],
            Quantity::Voltage => &[("V", 1.0), ("mV", 1e-3)],
        }
    }

    /// An example of how it is written.
    pub fn example(self) -> &'static str {
        match self {
            Quantity::Length => "160mm or 6in",
            Quantity::Force => "100g or 0.98N",
            Quantity::Stiffness => "150N/m",
            Quantity::Voltage => "5V",
        }
    }

    /// Reads it, in SI's unit; above zero.
    ///
    /// # Errors
    /// What is no number, has no unit or another, or is not above zero.
    pub fn read(self, text: &str) -> Result<f64, Malformed> {
        let malformed = |what: &str| Malformed { text: text.into(), what: what.into(), quantity: self };
        let trimmed = text.trim();
        let digits = trimmed.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.').len();
        let (number, unit) = (trimmed[..digits].trim(), trimmed[digits..].trim());
        let Ok(value) = number.replace(',', ".").parse::<f64>() else {
            return Err(malformed("is no number with a unit"));
        };
        let units = self.units();
        let known = || units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        if unit.is_empty() {
            return Err(malformed(&format!("has no unit: {}", known())));
        }
        let Some((_, factor)) = units.iter().find(|(name, _)| *name == unit) else {
            return Err(malformed(&format!("is in {unit:?}, which is none of {}", known())));
        };
        let value = value * factor;
        if value > 0.0 && value.is_finite() { Ok(value) } else { Err(malformed("is not above zero")) }
    }
}

/// A text that is no such quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Malformed {
    text: String,
    what: String,
    quantity: Quantity,
}

impl Malformed {
    /// What to do about it.
    pub fn remedy(&self) -> String {
        format!("write it like {}", self.quantity.example())
    }
}

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} {}", self.text, self.what)
    }
}

impl std::error::Error for Malformed {}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quantities_of_sheets_and_benches_are_si() {
        for (quantity, text, si) in [
            (Quantity::Length, "160mm", 0.16),
            (Quantity::Length, " 6 in ", 0.1524),
            (Quantity::Length, "16,5cm", 0.165),
            (Quantity::Force, "100g", 0.980_665),
            (Quantity::Force, "0.8N", 0.8),
            (Quantity::Force, "1lb", 4.448_221_615_260_5),
            (Quantity::Stiffness, "0.15N/mm", 150.0),
            (Quantity::Stiffness, "2g/mm", 19.6133),
            (Quantity::Voltage, "5V", 5.0),
        ] {
            let read = quantity.read(text).unwrap_or_else(|e| panic!("{e}"));
            assert!((read - si).abs() < 1e-12 * si, "{text}: {read}");
        }
    }

    #[test]
    fn what_is_none_is_told_how_to_be_written() {
        for (quantity, text, words) in [
            (Quantity::Length, "160", "has no unit: mm, cm, m, in"),
            (Quantity::Length, "160g", "is in \"g\", which is none of mm"),
            (Quantity::Force, "heavy", "is no number with a unit"),
            (Quantity::Force, "-1N", "is not above zero"),
            (Quantity::Voltage, "", "is no number"),
            (Quantity::Voltage, "1e999V", "is not above zero"),
        ] {
            let error = quantity.read(text).expect_err(text).to_string();
            assert!(error.contains(words), "{error}");
            let example = quantity.example().split(" or ").next().expect("one");
            assert!(quantity.read(example).is_ok(), "{example}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,12}") {
            for quantity in [Quantity::Length, Quantity::Force, Quantity::Stiffness, Quantity::Voltage] {
                let _ = quantity.read(&text);
            }
        }
    }
}
