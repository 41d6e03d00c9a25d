//! Numbers, missing samples and moments as people and their programs write them.

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    /// Nothing, or a word for it.
    Missing,
    /// A number.
    Number(f64),
    /// A moment.
    Moment(Moment),
    /// Any other text.
    Text(String),
}

/// A time of day, with its day where that is known (days since 1970).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub day: Option<i64>,
    pub seconds: f64,
    /// The number in a spreadsheet that is shown as a moment.
    pub serial: Option<f64>,
}

/// How numbers and dates are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Style {
    pub decimal: char,
    pub dates: Dates,
}

/// Order of day, month and year where both readings are possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dates {
    /// Day, month, year.
    Dmy,
    /// Month, day, year.
    Mdy,
    /// Year, month, day.
    Ymd,
}

impl Dates {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Dates::Dmy => "dmy",
            Dates::Mdy => "mdy",
            Dates::Ymd => "ymd",
        }
    }

    pub(crate) fn from_word(word: &str) -> Option<Dates> {
        [Dates::Dmy, Dates::Mdy, Dates::Ymd].into_iter().find(|order| order.word() == word)
    }
}

/// Words for a missing sample.
const MISSING: [&str; 22] = [
    "nan", "na", "n/a", "#n/a", "#nv", "null", "none", "-", "--", "---", "----", "missing", "fehlt", "#wert!",
    "#value!", "#div/0!", "1.#qnan", "-1.#ind", "1.#ind", "nan(ind)", "-nan", "*",
];

/// What a text in a cell is.
pub(crate) fn cell(text: &str, style: Style) -> Cell {
    let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
    let text = text.strip_prefix('=').and_then(|t| t.strip_prefix('"')?.strip_suffix('"')).unwrap_or(text);
    if text.is_empty() || (text.len() < 10 && MISSING.contains(&text.to_ascii_lowercase().as_str())) {
        return Cell::Missing;
    }
    if let Some(number) = number(text, style.decimal) {
        return Cell::Number(number);
    }
    match moment(text, style.dates) {
        Some(moment) => Cell::Moment(moment),
        None => Cell::Text(text.to_string()),
    }
}

/// A mark between groups of three digits.
fn groups_with(c: char, decimal: char) -> bool {
    matches!(c, '\u{a0}' | '\u{202f}' | '\u{2009}' | ' ' | '\'' | '’')
        || (c == '.' && decimal == ',')
        || (c == ',' && decimal == '.')
}

/// A number, finite, with this decimal sign; marks between groups of three digits are passed over.
pub(crate) fn number(text: &str, decimal: char) -> Option<f64> {
    let text = text.trim();
    let first = text.chars().next()?;
    if !(first.is_ascii_digit() || matches!(first, '-' | '+' | '.' | ',' | '−')) || text.len() > 60 {
        return None;
    }
    let mut plain = String::with_capacity(text.len());
    let (mut digits, mut grouped, mut fraction, mut exponent) = (0usize, None::<char>, false, false);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '0'..='9' => {
                digits += 1;
                plain.push(c);
            }
            '−' => plain.push('-'),
            '-' | '+' => plain.push(c),
            'e' | 'E' | 'd' | 'D' if digits > 0 && !exponent => {
                if grouped.is_some() && !fraction && digits != 3 {
                    return None;
                }
                (exponent, digits) = (true, 0);
                plain.push('e');
            }
            _ if c == decimal && !fraction && !exponent => {
                if grouped.is_some() && digits != 3 {
                    return None;
                }
                (fraction, digits) = (true, digits.max(usize::from(plain.is_empty())));
                plain.push('.');
            }
            _ if groups_with(c, decimal) && !fraction && !exponent => {
                let leading = plain.trim_start_matches(['-', '+']);
                let first = grouped.is_none();
                let right = if first { (1..=3).contains(&digits) && !leading.starts_with('0') } else { digits == 3 };
                if !right || grouped.is_some_and(|g| g != c) || !chars.peek().is_some_and(char::is_ascii_digit) {
                    return None;
                }
                (grouped, digits) = (Some(c), 0);
            }
            _ => return None,
        }
    }
    if grouped.is_some() && !fraction && !exponent && digits != 3 {
        return None;
    }
    plain.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Whether a number was written with marks between its groups of digits.
pub(crate) fn is_grouped(text: &str, decimal: char) -> bool {
    text.trim().chars().any(|c| groups_with(c, decimal))
}

/// Days from 1970 to a day of the calendar.
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let lengths = [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let length = *lengths.get(usize::try_from(month - 1).ok()?)?;
    if !(1..=length).contains(&day) || !(1900..=2200).contains(&year) {
        return None;
    }
    // the count of Howard Hinnant's days_from_civil
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year - era * 400;
    let of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

/// A moment: a time of day, a date, or both.
pub(crate) fn moment(text: &str, dates: Dates) -> Option<Moment> {
    if text.len() > 60 || !text.chars().any(|c| c.is_ascii_digit()) {
        return None;
    }
    let text: String = text
        .chars()
        .map(|c| match c {
            '年' | '月' => '-',
            '日' | '秒' => ' ',
            '時' | '分' | '：' => ':',
            '／' => '/',
            'T' | 't' | '_' => ' ',
            c => c,
        })
        .collect();
    let (mut day, mut seconds, mut half, mut zone_s) = (None, None, None, 0.0);
    for part in text.split_whitespace() {
        let lower = part.to_ascii_lowercase();
        match lower.as_str() {
            "am" | "a.m." if seconds.is_some() => half = Some(false),
            "pm" | "p.m." if seconds.is_some() => half = Some(true),
            "z" | "utc" | "uhr" if seconds.is_some() => {}
            _ if part.contains(':') && seconds.is_none() => {
                let (time, zone) = zoned(part);
                seconds = Some(time_of_day(time)?);
                zone_s = zone?;
            }
            _ if day.is_none() && seconds.is_none() => day = Some(date(part, dates)?),
            _ => return None,
        }
    }
    if day.is_none() && seconds.is_none() {
        return None;
    }
    let mut seconds = seconds.unwrap_or(0.0);
    match half {
        Some(true) if seconds < 43_200.0 => seconds += 43_200.0,
        Some(false) if (43_200.0..46_800.0).contains(&seconds) => seconds -= 43_200.0,
        _ => {}
    }
    Some(Moment { day, seconds: seconds - zone_s, serial: None })
}

/// A time of day without the zone behind it, and that in seconds east of Greenwich.
fn zoned(part: &str) -> (&str, Option<f64>) {
    if let Some(time) = part.strip_suffix(['Z', 'z']) {
        return (time, Some(0.0));
    }
    match part.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')) {
        Some((at, sign)) => {
            let zone = part[at + 1..].replace(':', "");
            let hours = match zone.len() {
                2 => zone.parse::<f64>().ok(),
                4 => zone.parse::<u32>().ok().map(|z| f64::from(z / 100) + f64::from(z % 100) / 60.0),
                _ => None,
            };
            (&part[..at], hours.map(|h| h * if sign == '-' { -3600.0 } else { 3600.0 }))
        }
        None => (part, Some(0.0)),
    }
}

/// `h:m`, `h:m:s`, `m:s.fff`, `h:m:s:ms`: seconds.
fn time_of_day(text: &str) -> Option<f64> {
    let parts: Vec<&str> = text.trim_end_matches(':').split(':').collect();
    let whole = |part: &str| part.parse::<u32>().ok().map(f64::from);
    let second = |part: &str| {
        let plain = part.replace(',', ".");
        let fine = !plain.is_empty() && plain.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        plain.parse::<f64>().ok().filter(|s| fine && *s < 61.0)
    };
    let fraction = text.contains(['.', ',']);
    match parts[..] {
        [m, s] if fraction => Some(whole(m)? * 60.0 + second(s)?),
        [h, m] => Some(whole(h)? * 3600.0 + whole(m).filter(|m| *m < 60.0)? * 60.0),
        [h, m, s] => Some(whole(h)? * 3600.0 + whole(m).filter(|m| *m < 60.0)? * 60.0 + second(s)?),
        [h, m, s, ms] if ms.len() == 3 => {
            Some(whole(h)? * 3600.0 + whole(m).filter(|m| *m < 60.0)? * 60.0 + second(s)? + whole(ms)? / 1000.0)
        }
        _ => None,
    }
}

/// A date: days since 1970.
fn date(text: &str, order: Dates) -> Option<i64> {
    let separator = text.chars().find(|c| matches!(c, '.' | '/' | '-'))?;
    let mut parts = text.split(separator);
    let part = |text: &str| text.parse::<i64>().ok().filter(|_| (1..=4).contains(&text.len()));
    let (a, b, c) = (part(parts.next()?)?, part(parts.next()?)?, part(parts.next()?)?);
    if parts.next().is_some_and(|rest| !rest.is_empty()) {
        return None;
    }
    let full = |year: i64| if year < 100 { 2000 + year } else { year };
    match order {
        _ if a > 31 => days(a, b, c),
        // with points the day always stands first
        Dates::Ymd if separator != '.' && c <= 31 => days(full(a), b, c),
        Dates::Mdy if separator != '.' => days(full(c), a, b),
        _ => days(full(c), b, a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_all_countries() {
        for (text, decimal, value) in [
            ("1,5", ',', 1.5),
            ("-0,25", ',', -0.25),
            ("1.234,5", ',', 1234.5),
            ("1.234.567", ',', 1_234_567.0),
            ("1,234.5", '.', 1234.5),
            ("1 234,5", ',', 1234.5),
            ("1\u{202f}234,5", ',', 1234.5),
            ("1'234.5", '.', 1234.5),
            ("1,2E-3", ',', 1.2e-3),
            ("1.5D+02", '.', 150.0),
            ("−3", '.', -3.0),
            (",5", ',', 0.5),
            ("7.", '.', 7.0),
        ] {
            assert_eq!(number(text, decimal), Some(value), "{text}");
        }
        for (text, decimal) in [
            ("0,010", '.'),
            ("1,23", '.'),
            ("1.2.3", '.'),
            ("12:30", '.'),
            ("1e999", '.'),
            ("1,2,3", ','),
            ("e5", '.'),
            ("-", '.'),
        ] {
            assert_eq!(number(text, decimal), None, "{text}");
        }
    }

    #[test]
    fn moments_of_all_countries() {
        let at = |text: &str| moment(text, Dates::Dmy).unwrap_or_else(|| panic!("{text}"));
        let noon = Moment { day: Some(19_794), seconds: 43_200.5, serial: None };
        for text in [
            "2024-03-12T12:00:00.5Z",
            "2024-03-12 12:00:00,5",
            "12.03.2024 12:00:00,5",
            "12/03/2024 12:00:00.5",
            "2024年3月12日 12時0分0.5秒",
            "2024-03-12T14:00:00.5+02:00",
            "2024/03/12 12:00:00.5 PM",
        ] {
            assert_eq!(at(text), noon, "{text}");
        }
        assert_eq!(moment("03/12/2024 12:00:00.5", Dates::Mdy), Some(noon));
        assert_eq!(at("00:01:02,25"), Moment { day: None, seconds: 62.25, serial: None });
        assert_eq!(at("1:02.25"), Moment { day: None, seconds: 62.25, serial: None });
        assert_eq!(at("10:00:01:250"), Moment { day: None, seconds: 36_001.25, serial: None });
        for text in ["32.03.2024", "1.2", "1.2.3.4", "12", "a:b", "10:61:00", "é:ü", "-:+:é"] {
            assert_eq!(moment(text, Dates::Dmy), None, "{text}");
        }
    }
}
