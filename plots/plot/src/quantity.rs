//! Formatting of numbers: few digits, a unit with an SI prefix, a true minus sign.

/// What stands where there is no number.
pub const NONE: &str = "–";

/// Beyond this nothing is a measurement any more, nor can it be drawn.
const LARGEST: f64 = 1e15;

/// A number that can be shown and drawn.
pub fn is_sane(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// Three significant digits.
pub fn number(value: f64) -> String {
    if !is_sane(value) {
        return NONE.into();
    }
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&magnitude) {
        trimmed(value, (2 - magnitude.log10().floor() as i32).max(0) as usize)
    } else {
        scientific(value)
    }
}

/// A chi: 1.02, 12.4, 124.
pub fn chi(value: f64) -> String {
    match value {
        _ if !is_sane(value) => NONE.into(),
        _ if value.abs() >= 1e5 => scientific(value),
        _ if value.abs() >= 99.95 => fixed(value, 0),
        _ if value.abs() >= 9.995 => fixed(value, 1),
        _ => fixed(value, 2),
    }
}

/// A probability; never 0.
pub fn probability(value: f64) -> String {
    match value {
        _ if !(0.0..=1.0).contains(&value) => NONE.into(),
        _ if value < 1e-4 => "below 0.0001".into(),
        _ if value < 0.1 => number(value),
        _ => fixed(value, 2),
    }
}

/// A share as per cent.
pub fn percent(share: f64) -> String {
    with_unit(fixed(100.0 * share, 0), "%")
}

/// A difference, with its sign.
pub fn signed(value: f64) -> String {
    if is_sane(value) && value > 0.0 { format!("+{}", number(value)) } else { number(value) }
}

/// A value with its unit, in the prefix that suits it: 0.000015 m is 15 µm.
pub fn quantity(value: f64, unit: &str) -> String {
    let prefix = Prefix::of(value.abs(), unit);
    with_unit(number(value / prefix.factor), &prefix.unit(unit))
}

/// A value and its interval in one prefix, in as many digits as the interval is worth.
pub fn estimate(value: f64, low: f64, high: f64, unit: &str) -> (String, String) {
    let width = high - low;
    if !is_sane(width) || width <= 0.0 || !is_sane(value) {
        return (quantity(value, unit), NONE.into());
    }
    let prefix = Prefix::of(value.abs().max(low.abs()).max(high.abs()), unit);
    let [value, low, high, width] = [value, low, high, width].map(|v| v / prefix.factor);
    let largest = value.abs().max(low.abs()).max(high.abs());
    let decimals = 1 - width.log10().floor() as i32;
    let write = |v: f64| {
        if decimals > 8 || largest >= 1e7 { number(v) } else { fixed(v, decimals.max(0) as usize) }
    };
    (with_unit(write(value), &prefix.unit(unit)), format!("{} to {}", write(low), write(high)))
}

/// The unit as it is shown: nothing for a pure number.
pub fn shown_unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// A power of a thousand, and the letter it is written with where the unit takes one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prefix {
    /// What one of it is worth in the unit itself.
    pub(crate) factor: f64,
    pub(crate) letter: Option<&'static str>,
}

impl Prefix {
    /// None at all.
    pub(crate) const NONE: Prefix = Prefix { factor: 1.0, letter: Some("") };

    /// The one in which `magnitude` has one to three digits before the point.
    pub(crate) fn of(magnitude: f64, unit: &str) -> Prefix {
        const LETTERS: [&str; 6] = ["n", "µ", "m", "", "k", "M"];
        let exponent =
            if is_sane(magnitude) && magnitude > 0.0 { (magnitude.log10() / 3.0 + 1e-4).floor() } else { 0.0 };
        match unit {
            "m" | "s" | "m/s" | "m/s²" => Prefix::letter(LETTERS, exponent.clamp(-3.0, 0.0)),
            "V" | "A" | "N" | "W" | "Ω" | "ohm" | "J" | "Pa" => Prefix::letter(LETTERS, exponent.clamp(-3.0, 2.0)),
            _ => Prefix::NONE,
        }
    }

    /// The same for an axis, where a unit without prefixes gets a power of ten once its numbers become unwieldy.
    pub(crate) fn of_axis(magnitude: f64, unit: &str) -> Prefix {
        let plain = Prefix::of(magnitude, unit);
        let scaled = magnitude / plain.factor;
        if scaled == 0.0 || !is_sane(scaled) || (1e-2..1e5).contains(&scaled) {
            return plain;
        }
        Prefix { factor: 1000f64.powf((magnitude.log10() / 3.0).floor().clamp(-100.0, 5.0)), letter: None }
    }

    fn letter(letters: [&'static str; 6], exponent: f64) -> Prefix {
        Prefix { factor: 1000f64.powf(exponent), letter: Some(letters[(exponent + 3.0) as usize]) }
    }

    /// `mm`, or `10⁻⁶ K`.
    pub(crate) fn unit(&self, unit: &str) -> String {
        match self.letter {
            Some(letter) => format!("{letter}{}", shown_unit(unit)),
            None => format!("10{} {}", superscript(self.factor.log10().round() as i32), shown_unit(unit)),
        }
    }
}

/// With exactly so many decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !is_sane(value) {
        return NONE.into();
    }
    let written = format!("{value:.decimals$}");
    match written.strip_prefix('-') {
        Some(digits) if digits.bytes().any(|b| (b'1'..=b'9').contains(&b)) => format!("−{digits}"),
        Some(zero) => zero.into(),
        None => written,
    }
}

fn trimmed(value: f64, decimals: usize) -> String {
    let written = fixed(value, decimals);
    if written.contains('.') { written.trim_end_matches('0').trim_end_matches('.').into() } else { written }
}

fn scientific(value: f64) -> String {
    let written = format!("{value:.2e}");
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let mantissa = mantissa.parse().map(|m: f64| trimmed(m, 2)).unwrap_or_default();
    format!("{mantissa}·10{}", superscript(exponent.parse().unwrap_or(0)))
}

fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent.to_string().bytes().map(|b| if b == b'-' { '⁻' } else { DIGITS[usize::from(b - b'0')] }).collect()
}

fn with_unit(number: String, unit: &str) -> String {
    if unit.is_empty() || number == NONE { number } else { format!("{number} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, shown) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.35, "0.35"),
            (1.0 / 3.0, "0.333"),
            (121.24, "121"),
            (-5210.4, "−5210"),
            (0.00312, "0.00312"),
            (1.5e-5, "1.5·10⁻⁵"),
            (-2.346e7, "−2.35·10⁷"),
            (9.999, "10"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
            (1e300, "–"),
        ] {
            assert_eq!(number(value), shown);
        }
    }

    #[test]
    fn a_quantity_takes_the_prefix_that_suits_it() {
        for (value, unit, shown) in [
            (1.5e-5, "m", "15 µm"),
            (0.00999, "m", "9.99 mm"),
            (1.0, "m", "1 m"),
            (2000.0, "m", "2000 m"),
            (-0.0015, "V", "−1.5 mV"),
            (2.2e3, "Ω", "2.2 kΩ"),
            (0.0, "A", "0 A"),
            (0.35, "1", "0.35"),
            (0.012, "K", "0.012 K"),
            (f64::NAN, "m", "–"),
            (1e-12, "s", "0.001 ns"),
        ] {
            assert_eq!(quantity(value, unit), shown);
        }
    }

    #[test]
    fn an_estimate_has_the_digits_its_interval_is_worth() {
        let show = |v, l, h, u| {
            let (value, interval) = estimate(v, l, h, u);
            format!("{value} [{interval}]")
        };
        assert_eq!(show(0.35123, 0.33111, 0.37009, "1"), "0.351 [0.331 to 0.370]");
        assert_eq!(show(113.04, 111.0, 115.2, "W/(m² K)"), "113.0 W/(m² K) [111.0 to 115.2]");
        assert_eq!(show(1.23e-3, 1.11e-3, 1.4e-3, "m"), "1.23 mm [1.11 to 1.40]");
        assert_eq!(show(24200.0, 22000.0, 26000.0, "J/kg"), "24200 J/kg [22000 to 26000]");
        assert_eq!(show(5.0, 5.0, 5.0, "K"), "5 K [–]");
        assert_eq!(show(5.0, f64::NEG_INFINITY, f64::INFINITY, "K"), "5 K [–]");
    }

    #[test]
    fn chi_and_probability() {
        assert_eq!([chi(1.0), chi(12.44), chi(124.4), chi(f64::NAN)], ["1.00", "12.4", "124", "–"]);
        assert_eq!(
            [probability(0.001), probability(0.5), probability(0.0), probability(1.5)],
            ["0.001", "0.50", "below 0.0001", "–"]
        );
        assert_eq!([percent(0.834), signed(2.0), signed(-2.0), signed(0.0)], ["83 %", "+2", "−2", "0"]);
    }

    #[test]
    fn an_axis_without_prefixes_gets_a_power_of_ten() {
        assert_eq!(Prefix::of_axis(4e-6, "K").unit("K"), "10⁻⁶ K");
        assert_eq!(Prefix::of_axis(4e-6, "K").factor, 1e-6);
        assert_eq!(Prefix::of_axis(80.0, "°C").unit("°C"), "°C");
        assert_eq!(Prefix::of_axis(f64::NAN, "°C").factor, 1.0);
        assert_eq!(Prefix::of_axis(0.0, "1").unit("1"), "");
    }
}
