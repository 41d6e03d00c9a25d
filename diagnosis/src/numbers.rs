//! Numbers as one would say them.

/// Three significant digits and no needless zeros.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let size = value.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    trimmed(value, (2 - size.log10().floor() as i32).max(0) as usize)
}

/// A value and its 90 % interval, in as many digits as the interval is worth and no fewer than three.
pub(crate) fn interval(value: f64, low: f64, high: f64) -> (String, String, String) {
    let size = value.abs().max(low.abs()).max(high.abs());
    let width = high - low;
    if !(width > 0.0 && (1e-4..1e6).contains(&size)) {
        return (number(value), number(low), number(high));
    }
    let least = 2 - size.log10().floor() as i32;
    let digits = (1 - width.log10().floor() as i32).clamp(least, least + 6).max(0) as usize;
    (trimmed(value, digits), trimmed(low, digits), trimmed(high, digits))
}

/// A number in digits that no interval is narrower than.
pub(crate) fn digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

fn trimmed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_said_with_three_digits() {
        let said: Vec<String> = [0.0, 12345.678, 1.23456, 0.00123456, -0.05, 2.0, 1e-7, 3e9].map(number).to_vec();
        assert_eq!(said, ["0", "12346", "1.23", "0.00123", "-0.05", "2", "1.00e-7", "3.00e9"]);
    }

    #[test]
    fn an_interval_is_never_empty() {
        let said = |value, low, high| {
            let (value, low, high) = interval(value, low, high);
            format!("{value} [{low}, {high}]")
        };
        assert_eq!(said(0.39998, 0.39968, 0.40028), "0.39998 [0.39968, 0.40028]");
        assert_eq!(said(28.4, 20.1, 36.7), "28.4 [20.1, 36.7]");
        assert_eq!(said(152.0, 120.0, 190.0), "152 [120, 190]");
        assert_eq!(said(5e-6, 4e-6, 6e-6), "5.00e-6 [4.00e-6, 6.00e-6]");
        assert_eq!(said(0.0, -0.2, 0.2), "0 [-0.2, 0.2]");
    }
}
