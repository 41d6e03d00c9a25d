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

/// How wrong something may be, as a share.
pub fn uncertainty(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number.trim_end(), 100.0));
    match number.parse::<f64>() {
        Ok(value) if (0.0..=0.9).contains(&(value / unit)) => Ok(value / unit),
        Ok(_) => Err("the uncertainty is 0 to 90 %".into()),
        Err(_) => Err("give the uncertainty as in 30% or 0.3".into()),
    }
}

/// A range of strokes, as shares.
pub fn strokes(text: &str) -> Result<(f64, f64), String> {
    let wanted = "give the strokes as in 10-90%";
    let number = |text: &str| text.trim().trim_end_matches('%').parse::<f64>().map_err(|_| wanted.to_string());
    let (low, high) = text.split_once('-').ok_or(wanted)?;
    let (low, high) = (number(low)? / 100.0, number(high)? / 100.0);
    match 0.0 <= low && low < high && high <= 1.0 {
        true => Ok((low, high)),
        false => Err("the strokes rise, from 0 to 100 %".into()),
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
    fn shares_are_typed_in_percent_or_as_numbers() {
        assert_eq!((uncertainty("30%"), uncertainty("0.3")), (Ok(0.3), Ok(0.3)));
        assert!(uncertainty("95%").is_err() && uncertainty("-1").is_err() && uncertainty("x").is_err());
        assert_eq!(strokes("10-90%"), Ok((0.1, 0.9)));
        assert!(strokes("90-10%").is_err() && strokes("0-120%").is_err() && strokes("10").is_err());
    }

    #[test]
    fn durations_are_positive_numbers() {
        assert_eq!(seconds("2.5"), Ok(2.5));
        assert_eq!(seconds("3s"), Ok(3.0));
        for bad in ["0", "-1", "nan", "inf", "abc", ""] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
    }
}
