//! Numbers as they are typed, with their units; what is no such number is an error that shows one.

/// A duration, in seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('s').parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e7 => Ok(value),
        Ok(_) => Err("seconds are more than 0 and at most 10000000".into()),
        Err(_) => Err("give seconds as a number, as in 2.5".into()),
    }
}

/// A number that is more than 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e6 => Ok(value),
        _ => Err("a number more than 0 and at most 1000000".into()),
    }
}

/// A length, in metres.
pub fn length(text: &str) -> Result<f64, String> {
    quantity(text, "length", &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)], 1e-4..=10.0, "6mm")
}

/// A wire's diameter, in metres.
pub fn diameter(text: &str) -> Result<f64, String> {
    quantity(text, "diameter", &[("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)], 1e-5..=2e-3, "0.15mm")
}

/// A number with one of these units, in SI and within what can be meant.
pub fn quantity(
    text: &str,
    name: &str,
    units: &[(&str, f64)],
    range: std::ops::RangeInclusive<f64>,
    example: &str,
) -> Result<f64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic()).trim_end();
    let unit = text[digits.len()..].trim_start();
    let known = || units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ");
    let Ok(number) = digits.parse::<f64>() else {
        return Err(format!("not a number with a unit; give the {name} as in {example}"));
    };
    let Some((_, factor)) = units.iter().find(|(known, _)| *known == unit) else {
        return Err(format!("a {name} is given in {}, as in {example}", known()));
    };
    let value = number * factor;
    match range.contains(&value) {
        true => Ok(value),
        false => Err(format!(
            "no wire is made for a {name} of {text}: {} to {} {}",
            range.start() / factor,
            range.end() / factor,
            unit
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_positive_numbers() {
        assert_eq!(seconds("2.5"), Ok(2.5));
        assert_eq!(seconds("3s"), Ok(3.0));
        for bad in ["0", "-1", "nan", "inf", "abc", ""] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
    }
}
