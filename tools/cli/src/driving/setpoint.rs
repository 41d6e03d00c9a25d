//! The syntax of a setpoint on the command line: `length=164mm`, `stroke=40%`, `stroke=6mm`, `duty=0.1`, `force=2N`, `off`.

use std::fmt;

/// A command as typed, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setpoint {
    /// Wire length, m.
    Length(f64),
    /// Share of the stroke, 0 = cold, 1 = hot.
    Stroke(f64),
    /// Way from the cold end of the stroke, m.
    Way(f64),
    /// Duty, 0..1.
    Duty(f64),
    /// Wire tension, N.
    Force(f64),
    /// Control off.
    Off,
}

/// What is wrong with what was typed.
#[derive(Debug, Clone, PartialEq)]
pub struct SetpointError {
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub hint: String,
}

/// One kind of quantity: its name, the units it may carry with their factor to SI, and an example. One that has two kinds of units stands twice.
struct Quantity {
    name: &'static str,
    units: &'static [(&'static str, f64)],
    example: &'static str,
}

const QUANTITIES: [Quantity; 5] = [
    Quantity { name: "length", units: &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)], example: "length=164mm" },
    Quantity { name: "stroke", units: &[("%", 1e-2)], example: "stroke=40%" },
    Quantity { name: "stroke", units: &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)], example: "stroke=6mm" },
    Quantity { name: "duty", units: &[("", 1.0), ("%", 1e-2)], example: "duty=0.1" },
    Quantity { name: "force", units: &[("N", 1.0), ("mN", 1e-3)], example: "force=2N" },
];

const FORMS: &str = "write length=164mm, stroke=40%, duty=0.1, force=2N or off";

impl Setpoint {
    /// Reads what was typed on the command line.
    ///
    /// # Errors
    /// The quantity, number or unit that does not fit, and what would.
    pub fn parse(text: &str) -> Result<Setpoint, SetpointError> {
        let fail = |message: String, hint: String| Err(SetpointError { message, hint });
        let text = text.trim();
        if text == "off" {
            return Ok(Setpoint::Off);
        }
        if text == "program" {
            let back = "a wire goes back to its program by itself when a setpoint's lease ends: `stroke=0% --hold 1`";
            return fail("`program` is not a setpoint".into(), back.into());
        }
        let Some((name, value)) = text.split_once('=') else {
            return fail(format!("`{text}` is not a setpoint"), FORMS.into());
        };
        let (name, value) = (name.trim(), value.trim());
        let named = || QUANTITIES.iter().filter(|quantity| quantity.name == name);
        let Some(quantity) = named().next() else {
            return fail(format!("unknown quantity `{name}` in `{text}`"), FORMS.into());
        };
        let split = value
            .char_indices()
            .find(|&(at, c)| !is_number_character(&value[..at], c))
            .map_or(value.len(), |(at, _)| at);
        let (number, unit) = (value[..split].trim(), value[split..].trim());
        let Ok(number) = number.parse::<f64>() else {
            let hint = match value.contains(',') {
                true => format!("the decimal point is `.`, as in {}", quantity.example),
                false => format!("as in {}", quantity.example),
            };
            return fail(format!("`{value}` is not a number with a unit, in `{text}`"), hint);
        };
        if !number.is_finite() {
            return fail(format!("`{value}` is not a finite number"), format!("as in {}", quantity.example));
        }
        let Some((_, factor)) = named().flat_map(|quantity| quantity.units).find(|(known, _)| *known == unit) else {
            let units = named().flat_map(|quantity| quantity.units);
            let known: Vec<&str> = units.map(|(u, _)| if u.is_empty() { "no unit" } else { *u }).collect();
            let known = match known.split_last() {
                Some((last, [])) => (*last).to_string(),
                Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
                None => String::new(),
            };
            let message = match unit {
                "" => format!("`{text}` lacks its unit"),
                _ => format!("`{unit}` is not a unit of {name}, in `{text}`"),
            };
            return fail(message, format!("{name} is given in {known}, as in {}", quantity.example));
        };
        let value = number * factor;
        let within = |low: f64, high: f64| value >= low && value <= high;
        match name {
            "length" if within(1e-3, 100.0) => Ok(Setpoint::Length(value)),
            "stroke" if unit != "%" && within(0.0, 100.0) => Ok(Setpoint::Way(value)),
            "stroke" if unit == "%" && within(0.0, 1.0) => Ok(Setpoint::Stroke(value)),
            "duty" if within(0.0, 1.0) => Ok(Setpoint::Duty(value)),
            "force" if within(0.0, 1e5) => Ok(Setpoint::Force(value)),
            "length" => fail(format!("`{text}`: no wire has that length"), "length is 1 mm to 100 m".into()),
            "stroke" => {
                let nearest = format!("stroke={}{unit}", if value < 0.0 { "0" } else { "100" });
                let nearest =
                    if unit == "%" || value < 0.0 { format!("; the nearest is {nearest}") } else { String::new() };
                let hint = format!("0 % is cold and long, 100 % is hot and short{nearest}");
                fail(format!("`{text}` is outside the stroke"), hint)
            }
            "duty" => fail(format!("`{text}` is no duty"), "duty is 0 to 1 (or 0% to 100%)".into()),
            _ => fail(format!("`{text}`: a wire can only pull"), "force is 0 N or more".into()),
        }
    }

    /// What is to be said of a setpoint outside of a range, and the nearest one inside, both in the unit it was given in. The range is the driver's: in SI,
    /// of a stroke in shares of one that is so long.
    pub fn outside(self, low: f64, high: f64, stroke_m: f64) -> (String, String) {
        let (name, value, unit, factor, decimals) = match self {
            Setpoint::Length(m) => ("length", 1e3 * m, "mm", 1e3, 2),
            Setpoint::Stroke(share) => ("stroke", 1e2 * share, "%", 1e2, 1),
            Setpoint::Way(m) => ("stroke", 1e3 * m, "mm", 1e3 * stroke_m, 2),
            Setpoint::Duty(duty) => ("duty", duty, "", 1.0, 3),
            Setpoint::Force(n) => ("force", n, "N", 1.0, 3),
            Setpoint::Off => ("off", f64::NAN, "", 1.0, 0),
        };
        // rounded inwards, so that what is offered would be taken
        let scale = f64::powi(10.0, decimals);
        let low = (low * factor * scale - 1e-6).ceil() / scale + 0.0;
        let high = (high * factor * scale + 1e-6).floor() / scale;
        let nearest = if value < low { low } else { high };
        let (d, gap) = (decimals as usize, if unit.is_empty() { "" } else { " " });
        (
            format!("{name} {value:.d$}{gap}{unit} is outside {low:.d$} to {high:.d$}{gap}{unit}"),
            format!("{name}={nearest:.d$}{unit}"),
        )
    }

    /// Reads what was typed in the monitor: as on the command line, a percentage without a name is a stroke, and so is a bare
    /// number, which stands there as it is typed.
    ///
    /// # Errors
    /// As [`Setpoint::parse`].
    pub fn parse_typed(text: &str) -> Result<Setpoint, SetpointError> {
        match text.trim() {
            t if is_bare(t) => Setpoint::parse(&format!("stroke={t}%")),
            t => Setpoint::parse_cell(t),
        }
    }

    /// Reads a cell of a file: as on the command line, and the unit alone says which quantity. A bare number is an error: nobody
    /// sees whether 0.4 is a share or per cent.
    ///
    /// # Errors
    /// As [`Setpoint::parse`].
    pub fn parse_cell(text: &str) -> Result<Setpoint, SetpointError> {
        match text.trim() {
            t if t.contains('=') => Setpoint::parse(t),
            t if is_bare(t) => {
                let message = format!("`{t}` does not say of what");
                Err(SetpointError { message, hint: "write the unit: 40%, 164mm, 2N, or duty=0.1".into() })
            }
            t if t.ends_with('%') => Setpoint::parse(&format!("stroke={t}")),
            t if t.ends_with('N') => Setpoint::parse(&format!("force={t}")),
            t if t.ends_with('m') => Setpoint::parse(&format!("length={t}")),
            t => Setpoint::parse(t),
        }
    }
}

/// Whether this is a number without a unit or a name.
fn is_bare(text: &str) -> bool {
    !text.contains('=') && text.ends_with(|c: char| c.is_ascii_digit() || c == '.')
}

/// Whether `c`, after `before`, still belongs to a number.
fn is_number_character(before: &str, c: char) -> bool {
    let exponent = before.ends_with(['e', 'E']);
    match c {
        '0'..='9' | '.' | ',' => true,
        '+' | '-' => before.is_empty() || exponent,
        'e' | 'E' => before.ends_with(|c: char| c.is_ascii_digit() || c == '.'),
        _ => false,
    }
}

impl fmt::Display for Setpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Setpoint::Length(m) => write!(f, "length {:.2} mm", m * 1e3),
            Setpoint::Stroke(share) => write!(f, "stroke {:.1} %", share * 100.0),
            Setpoint::Way(m) => write!(f, "stroke {:.2} mm", m * 1e3),
            Setpoint::Duty(duty) => write!(f, "duty {duty:.3}"),
            Setpoint::Force(n) => write!(f, "force {n:.2} N"),
            Setpoint::Off => f.write_str("off"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Setpoint, b: Setpoint) -> bool {
        use Setpoint::*;
        match (a, b) {
            (Length(a), Length(b))
            | (Way(a), Way(b))
            | (Stroke(a), Stroke(b))
            | (Duty(a), Duty(b))
            | (Force(a), Force(b)) => (a - b).abs() < 1e-12,
            (a, b) => a == b,
        }
    }

    #[test]
    fn every_quantity_in_every_unit() {
        for (text, expected) in [
            ("length=155mm", Setpoint::Length(0.155)),
            ("length=15.5cm", Setpoint::Length(0.155)),
            ("length=0.155m", Setpoint::Length(0.155)),
            ("length=1.55e-1 m", Setpoint::Length(0.155)),
            ("length = 155 mm", Setpoint::Length(0.155)),
            ("stroke=40%", Setpoint::Stroke(0.4)),
            ("stroke=0%", Setpoint::Stroke(0.0)),
            ("stroke=6mm", Setpoint::Way(0.006)),
            ("stroke=0.6 cm", Setpoint::Way(0.006)),
            ("duty=0.1", Setpoint::Duty(0.1)),
            ("duty=10%", Setpoint::Duty(0.1)),
            ("force=1.5N", Setpoint::Force(1.5)),
            ("force=1500mN", Setpoint::Force(1.5)),
            ("off", Setpoint::Off),
        ] {
            let found = Setpoint::parse(text).unwrap_or_else(|e| panic!("{text}: {e:?}"));
            assert!(near(found, expected), "{text}: {found:?}");
        }
    }

    #[test]
    fn what_does_not_fit_is_named_with_what_would() {
        for (text, message, hint) in [
            ("length=155", "lacks its unit", "mm, cm or m"),
            ("length=155in", "`in` is not a unit of length", "mm, cm or m"),
            ("stroke=40in", "`in` is not a unit of stroke", "stroke is given in %, mm, cm or m"),
            ("stroke=-3mm", "outside the stroke", "0 % is cold"),
            ("force=2kg", "`kg` is not a unit of force", "N or mN"),
            ("duty=0.1V", "`V` is not a unit of duty", "no unit or %"),
            ("length=1,5cm", "is not a number", "decimal point is `.`"),
            ("length=mm", "is not a number", "length=164mm"),
            ("speed=3", "unknown quantity `speed`", "length=164mm"),
            ("half", "not a setpoint", "stroke=40%"),
            ("stroke=140%", "outside the stroke", "the nearest is stroke=100%"),
            ("stroke=-3%", "outside the stroke", "the nearest is stroke=0%"),
            ("stroke=-3mm", "outside the stroke", "the nearest is stroke=0mm"),
            ("duty=2", "no duty", "0 to 1"),
            ("force=-1N", "only pull", "0 N or more"),
            ("length=nanmm", "not a number", "length=164mm"),
            ("length=1e400m", "not a finite number", "length=164mm"),
            ("", "not a setpoint", "off"),
        ] {
            let error = Setpoint::parse(text).expect_err(text);
            assert!(error.message.contains(message), "{text}: {error:?}");
            assert!(error.hint.contains(hint), "{text}: {error:?}");
        }
    }

    #[test]
    fn what_is_outside_is_told_in_its_own_unit_and_what_is_offered_would_be_taken() {
        let told = |setpoint: Setpoint, low, high| setpoint.outside(low, high, 0.009_006);
        let (message, nearest) = told(Setpoint::Way(0.012), 0.0, 1.0);
        assert_eq!(
            (message.as_str(), nearest.as_str()),
            ("stroke 12.00 mm is outside 0.00 to 9.00 mm", "stroke=9.00mm")
        );
        let (message, nearest) = told(Setpoint::Length(0.155), 0.160_530_1, 0.167_046_9);
        assert_eq!(message, "length 155.00 mm is outside 160.54 to 167.04 mm");
        assert_eq!(nearest, "length=160.54mm");
        assert_eq!(told(Setpoint::Stroke(1.2), 0.0, 1.0).0, "stroke 120.0 % is outside 0.0 to 100.0 %");
        assert_eq!(
            told(Setpoint::Duty(0.9), 0.0, 0.5),
            ("duty 0.900 is outside 0.000 to 0.500".into(), "duty=0.500".into())
        );
        for (setpoint, low, high) in
            [(Setpoint::Way(0.012), 0.0, 1.0), (Setpoint::Length(0.2), 0.160_530_1, 0.167_046_9)]
        {
            let (_, nearest) = told(setpoint, low, high);
            match Setpoint::parse(&nearest).unwrap() {
                Setpoint::Way(m) => assert!((low..=high).contains(&(m / 0.009_006)), "{nearest}"),
                Setpoint::Length(m) => assert!((low..=high).contains(&m), "{nearest}"),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_bare_number_in_the_monitor_is_stroke() {
        assert!(near(Setpoint::parse_typed("45").unwrap(), Setpoint::Stroke(0.45)));
        assert!(near(Setpoint::parse_typed("45.5%").unwrap(), Setpoint::Stroke(0.455)));
        assert!(near(Setpoint::parse_typed("155mm").unwrap(), Setpoint::Length(0.155)));
        assert!(near(Setpoint::parse_typed("1.5N").unwrap(), Setpoint::Force(1.5)));
        assert!(near(Setpoint::parse_typed("duty=0.2").unwrap(), Setpoint::Duty(0.2)));
        assert_eq!(Setpoint::parse_typed("off").unwrap(), Setpoint::Off);
        assert!(Setpoint::parse_typed("120").is_err());
        assert!(near(Setpoint::parse_cell("40%").unwrap(), Setpoint::Stroke(0.4)));
        assert!(near(Setpoint::parse_cell("duty=0.4").unwrap(), Setpoint::Duty(0.4)));
        assert!(Setpoint::parse_cell("0.4").is_err_and(|error| error.hint.contains("40%")));
    }
}
