//! Units as headers have them.

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dimension {
    Time,
    Voltage,
    Current,
    Length,
    Force,
    Temperature,
    Power,
    Resistance,
    Stress,
    /// Shares: duty and strain.
    Ratio,
    /// A unit of something a recording does not have.
    Other,
}

/// A unit: value in SI (temperatures: °C) = `factor` · number + `offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    pub dimension: Dimension,
    pub factor: f64,
    pub offset: f64,
    /// As it is usually written.
    pub symbol: &'static str,
}

const G: f64 = 9.80665;

/// Spellings, lower case and without blanks, and what each is. Where case matters the first column has it.
const UNITS: &[(&str, Dimension, f64, &str)] = {
    use Dimension::*;
    &[
        ("s", Time, 1.0, "s"),
        ("sec", Time, 1.0, "s"),
        ("sek", Time, 1.0, "s"),
        ("secs", Time, 1.0, "s"),
        ("second", Time, 1.0, "s"),
        ("seconds", Time, 1.0, "s"),
        ("sekunde", Time, 1.0, "s"),
        ("sekunden", Time, 1.0, "s"),
        ("secondes", Time, 1.0, "s"),
        ("seconde", Time, 1.0, "s"),
        ("秒", Time, 1.0, "s"),
        ("ms", Time, 1e-3, "ms"),
        ("msec", Time, 1e-3, "ms"),
        ("msek", Time, 1e-3, "ms"),
        ("millis", Time, 1e-3, "ms"),
        ("milliseconds", Time, 1e-3, "ms"),
        ("millisekunden", Time, 1e-3, "ms"),
        ("ミリ秒", Time, 1e-3, "ms"),
        ("us", Time, 1e-6, "µs"),
        ("usec", Time, 1e-6, "µs"),
        ("micros", Time, 1e-6, "µs"),
        ("ns", Time, 1e-9, "ns"),
        ("min", Time, 60.0, "min"),
        ("minute", Time, 60.0, "min"),
        ("minutes", Time, 60.0, "min"),
        ("minuten", Time, 60.0, "min"),
        ("分", Time, 60.0, "min"),
        ("h", Time, 3600.0, "h"),
        ("hr", Time, 3600.0, "h"),
        ("hours", Time, 3600.0, "h"),
        ("std", Time, 3600.0, "h"),
        ("v", Voltage, 1.0, "V"),
        ("volt", Voltage, 1.0, "V"),
        ("volts", Voltage, 1.0, "V"),
        ("mv", Voltage, 1e-3, "mV"),
        ("uv", Voltage, 1e-6, "µV"),
        ("kv", Voltage, 1e3, "kV"),
        ("a", Current, 1.0, "A"),
        ("amp", Current, 1.0, "A"),
        ("amps", Current, 1.0, "A"),
        ("ampere", Current, 1.0, "A"),
        ("ma", Current, 1e-3, "mA"),
        ("ua", Current, 1e-6, "µA"),
        ("m", Length, 1.0, "m"),
        ("meter", Length, 1.0, "m"),
        ("cm", Length, 1e-2, "cm"),
        ("mm", Length, 1e-3, "mm"),
        ("millimeter", Length, 1e-3, "mm"),
        ("ミリ", Length, 1e-3, "mm"),
        ("um", Length, 1e-6, "µm"),
        ("micron", Length, 1e-6, "µm"),
        ("nm", Length, 1e-9, "nm"),
        ("in", Length, 0.0254, "in"),
        ("inch", Length, 0.0254, "in"),
        ("inches", Length, 0.0254, "in"),
        ("\"", Length, 0.0254, "in"),
        ("mil", Length, 25.4e-6, "mil"),
        ("ft", Length, 0.3048, "ft"),
        ("n", Force, 1.0, "N"),
        ("newton", Force, 1.0, "N"),
        ("mn", Force, 1e-3, "mN"),
        ("cn", Force, 1e-2, "cN"),
        ("kn", Force, 1e3, "kN"),
        ("g", Force, G * 1e-3, "g"),
        ("gf", Force, G * 1e-3, "gf"),
        ("gram", Force, G * 1e-3, "g"),
        ("grams", Force, G * 1e-3, "g"),
        ("gramm", Force, G * 1e-3, "g"),
        ("kg", Force, G, "kg"),
        ("kgf", Force, G, "kgf"),
        ("kp", Force, G, "kp"),
        ("lb", Force, 4.448_221_615_260_5, "lbf"),
        ("lbf", Force, 4.448_221_615_260_5, "lbf"),
        ("lbs", Force, 4.448_221_615_260_5, "lbf"),
        ("oz", Force, 0.278_013_850_953_781_2, "ozf"),
        ("ozf", Force, 0.278_013_850_953_781_2, "ozf"),
        ("°c", Temperature, 1.0, "°C"),
        ("degc", Temperature, 1.0, "°C"),
        ("c", Temperature, 1.0, "°C"),
        ("celsius", Temperature, 1.0, "°C"),
        ("k", Temperature, 1.0, "K"),
        ("kelvin", Temperature, 1.0, "K"),
        ("°f", Temperature, 5.0 / 9.0, "°F"),
        ("degf", Temperature, 5.0 / 9.0, "°F"),
        ("f", Temperature, 5.0 / 9.0, "°F"),
        ("fahrenheit", Temperature, 5.0 / 9.0, "°F"),
        ("w", Power, 1.0, "W"),
        ("watt", Power, 1.0, "W"),
        ("watts", Power, 1.0, "W"),
        ("mw", Power, 1e-3, "mW"),
        ("ohm", Resistance, 1.0, "Ω"),
        ("ohms", Resistance, 1.0, "Ω"),
        ("mohm", Resistance, 1e-3, "mΩ"),
        ("kohm", Resistance, 1e3, "kΩ"),
        ("pa", Stress, 1.0, "Pa"),
        ("kpa", Stress, 1e3, "kPa"),
        ("mpa", Stress, 1e6, "MPa"),
        ("gpa", Stress, 1e9, "GPa"),
        ("n/mm2", Stress, 1e6, "MPa"),
        ("n/mm^2", Stress, 1e6, "MPa"),
        ("%", Ratio, 1e-2, "%"),
        ("percent", Ratio, 1e-2, "%"),
    ]
};

/// Units of what a recording does not have, so that a row of units is known for one: spelling, and as it is usually written.
const OTHERS: [(&str, &str); 22] = [
    ("hz", "Hz"),
    ("khz", "kHz"),
    ("1/s", "1/s"),
    ("rpm", "rpm"),
    ("u/min", "U/min"),
    ("j", "J"),
    ("mj", "mJ"),
    ("ws", "Ws"),
    ("wh", "Wh"),
    ("°", "°"),
    ("deg", "°"),
    ("rad", "rad"),
    ("bar", "bar"),
    ("mbar", "mbar"),
    ("mm/s", "mm/s"),
    ("m/s", "m/s"),
    ("m/s2", "m/s²"),
    ("n/m", "N/m"),
    ("n/mm", "N/mm"),
    ("°c/s", "°C/s"),
    ("k/s", "K/s"),
    ("mm/min", "mm/min"),
];

/// Written in one way, whatever the letters were: `µ` and `μ`, `℃`, full width, blanks.
pub(crate) fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.trim().chars() {
        match c {
            'µ' | 'μ' => out.push('u'),
            '℃' => out.push_str("°c"),
            '℉' => out.push_str("°f"),
            'º' | '˚' => out.push('°'),
            'Ω' | '\u{2126}' => out.push_str("ohm"),
            '²' => out.push('2'),
            '％' => out.push('%'),
            '−' => out.push('-'),
            '！'..='～' => out.extend(char::from_u32(c as u32 - 0xfee0).into_iter().flat_map(char::to_lowercase)),
            c if c.is_whitespace() => {}
            c => out.extend(c.to_lowercase()),
        }
    }
    out
}

/// The unit of this spelling.
pub(crate) fn unit(text: &str) -> Option<Unit> {
    use Dimension::*;
    let word = plain(text);
    let word = word.trim_matches(['[', ']', '(', ')', '{', '}']);
    let exact = |dimension, factor, symbol| Some(Unit { dimension, factor, offset: 0.0, symbol });
    // by their letters' case
    match text.trim().trim_matches(['[', ']', '(', ')', ' ']) {
        "S" | "Min" | "H" | "" => return None,
        "MPa" => return exact(Stress, 1e6, "MPa"),
        "mPa" => return exact(Stress, 1e-3, "mPa"),
        "mm/mm" | "m/m" | "in/in" | "1" => return exact(Ratio, 1.0, "1"),
        "µε" | "με" | "ue" | "µm/m" | "μm/m" | "um/m" => return exact(Ratio, 1e-6, "µm/m"),
        "‰" => return exact(Ratio, 1e-3, "‰"),
        "MN" => return exact(Other, 1.0, "MN"),
        "MW" => return exact(Other, 1.0, "MW"),
        "MV" => return exact(Other, 1.0, "MV"),
        "MA" => return exact(Other, 1.0, "MA"),
        _ => {}
    }
    if let Some((_, symbol)) = OTHERS.iter().find(|(spelling, _)| *spelling == word) {
        return exact(Other, 1.0, symbol);
    }
    let &(_, dimension, factor, symbol) = UNITS.iter().find(|(spelling, ..)| *spelling == word)?;
    let offset = match symbol {
        "K" => -273.15,
        "°F" => -160.0 / 9.0,
        _ => 0.0,
    };
    Some(Unit { dimension, factor, offset, symbol })
}

/// A name taken apart: what it is of, and its unit in brackets, behind a slash, a comma or a word for "in".
/// Units of one letter behind `_` or a blank are weaker: they are given as `loose`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Named {
    pub name: String,
    /// In brackets, or behind a slash.
    pub stated: Option<Unit>,
    /// What stands in brackets and is no unit that is known.
    pub unknown: Option<String>,
    /// What could be a unit at its end.
    pub loose: Option<Unit>,
}

/// Takes a column's name apart.
pub(crate) fn named(text: &str) -> Named {
    let text: String = text
        .chars()
        .map(|c| match c {
            '（' | '［' | '【' => '(',
            '）' | '］' | '】' => ')',
            '／' => '/',
            c => c,
        })
        .collect();
    let text = text.trim();
    let mut named = Named { name: text.to_string(), stated: None, unknown: None, loose: None };
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')] {
        let Some(from) = text.rfind(open) else { continue };
        let Some(to) = text[from..].find(close).map(|to| from + to) else { continue };
        let inside = &text[from + open.len_utf8()..to];
        if let Some(unit) = unit(inside.trim_start_matches("in ")) {
            named.stated = Some(unit);
            named.name = format!("{} {}", text[..from].trim(), text[to + close.len_utf8()..].trim()).trim().to_string();
            return named;
        }
        if named.unknown.is_none() && !inside.trim().is_empty() && inside.chars().count() <= 8 {
            named.unknown = Some(inside.trim().to_string());
        }
    }
    for mark in [" / ", "/", ", ", " in "] {
        if let Some((name, end)) = text.rsplit_once(mark)
            && !name.trim().is_empty()
            && let Some(unit) = unit(end)
        {
            return Named { name: name.trim().to_string(), stated: Some(unit), unknown: None, loose: None };
        }
    }
    // position_mm, Temp °C, forceN
    let end = text
        .char_indices()
        .rev()
        .find(|(_, c)| matches!(c, '_' | ' ' | '.' | '-' | ':'))
        .map(|(at, c)| (at, at + c.len_utf8()));
    if let Some((at, behind)) = end
        && at > 0
        && !text[behind..].starts_with(|c: char| c.is_ascii_digit())
        && let Some(unit) = unit(&text[behind..])
    {
        return Named { name: text[..at].trim().to_string(), stated: None, unknown: named.unknown, loose: Some(unit) };
    }
    let camel = text
        .char_indices()
        .zip(text.char_indices().skip(1))
        .filter(|((_, a), (_, b))| (a.is_lowercase() || a.is_ascii_digit()) && b.is_uppercase())
        .last();
    if let Some((_, (at, _))) = camel
        && let Some(unit) = unit(&text[at..])
    {
        named = Named { name: text[..at].to_string(), stated: None, unknown: named.unknown, loose: Some(unit) };
    }
    named
}

/// A column's heading taken apart: its name, and its unit as it is usually written or, where it is none that is known, as it stands in
/// brackets; "" where none is stated.
pub fn heading(text: &str) -> (String, String) {
    let Named { name, stated, unknown, loose } = named(text);
    match (stated.or(loose), unknown) {
        (Some(unit), _) => (name, unit.symbol.to_string()),
        (None, Some(written)) => {
            let bare = text.find(['[', '(', '{', '<']).map_or(text, |from| &text[..from]).trim();
            (if bare.is_empty() { name } else { bare.to_string() }, written)
        }
        (None, None) => (name, String::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_is_a_name_and_a_unit() {
        let of = |text: &str| heading(text);
        let is = |name: &str, unit: &str| (name.to_string(), unit.to_string());
        assert_eq!(of("Force [N]"), is("Force", "N"));
        assert_eq!(of("t_ms"), is("t", "ms"));
        assert_eq!(of("speed [rpm]"), is("speed", "rpm"));
        assert_eq!(of("fruit (bananas)"), is("fruit", "bananas"));
        assert_eq!(of("counts"), is("counts", ""));
        assert_eq!(of("speed_rpm"), is("speed", "rpm"));
        assert_eq!(of("f [Hz]"), is("f", "Hz"));
        assert_eq!(of(""), is("", ""));
    }

    #[test]
    fn units_are_found_where_people_write_them() {
        for (text, name, symbol) in [
            ("Strom [mA]", "Strom", "mA"),
            ("Temperature (°C)", "Temperature", "°C"),
            ("Weg/mm", "Weg", "mm"),
            ("Kraft / N", "Kraft", "N"),
            ("変位（mm）", "変位", "mm"),
            ("温度(℃)", "温度", "°C"),
            ("Zeit in s", "Zeit", "s"),
            ("temps, s", "temps", "s"),
            ("Weg [µm] gefiltert", "Weg gefiltert", "µm"),
            ("R (Ω)", "R", "Ω"),
        ] {
            let found = named(text);
            assert_eq!((found.name.as_str(), found.stated.map(|u| u.symbol)), (name, Some(symbol)), "{text}");
        }
        for (text, name, symbol) in [
            ("Force_N", "Force", "N"),
            ("position_mm", "position", "mm"),
            ("Temp °C", "Temp", "°C"),
            ("forceN", "force", "N"),
            ("t_ms", "t", "ms"),
        ] {
            let found = named(text);
            assert_eq!((found.name.as_str(), found.loose.map(|u| u.symbol)), (name, Some(symbol)), "{text}");
        }
        assert_eq!(named("Kanal 1").loose, None);
        assert_eq!(named("Force [bananas]").unknown.as_deref(), Some("bananas"));
        let fahrenheit = unit("°F").unwrap();
        assert!((fahrenheit.factor * 212.0 + fahrenheit.offset - 100.0).abs() < 1e-12);
    }
}
