//! Guesses at what was meant, for the remedies in error messages.

use crate::column::{Column, TIME};

/// The known column nearest to `word`, if one is near enough to be a slip, or the same quantity written otherwise.
pub(crate) fn nearest(word: &str) -> Option<&'static str> {
    let names = || std::iter::once(TIME).chain(Column::ALL.iter().map(|c| c.name()));
    let near = sinew_rig::nearest(word, names());
    let word = word.to_lowercase();
    // "position", "position_mm" and "Position [mm]" all begin like position_m
    let letters: String = word.chars().take_while(char::is_ascii_alphanumeric).collect();
    near.or_else(|| names().find(|name| letters.len() > 2 && name.split('_').next() == Some(letters.as_str())))
}

/// The column that is probably the time under another name.
pub(crate) fn time_like(present: &[String]) -> Option<&str> {
    present.iter().map(String::as_str).find(|name| {
        let name = name.to_lowercase();
        name == "t" || name.starts_with("t_") || name.contains("time") || name.contains("zeit")
    })
}

/// Factor to seconds that such a name asks for.
pub(crate) fn time_scale(name: &str) -> Option<f64> {
    let name = name.to_lowercase();
    let ends = |unit: &str| name.trim_end_matches([')', ']']).ends_with(unit);
    if ends("ms") {
        Some(1e-3)
    } else if ends("us") || ends("µs") {
        Some(1e-6)
    } else {
        None
    }
}

/// The known column that such a name is in another unit of, and the factor to the column's own: `position_mm` or `Position [mm]`.
pub(crate) fn in_another_unit(name: &str) -> Option<(&'static str, f64)> {
    let name = name.to_lowercase();
    let parts: Vec<&str> = name.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect();
    let (unit, quantity) = parts.split_last()?;
    let unit = unit.replace('µ', "u");
    let known = |name: &&str| name.rsplit_once('_').is_some_and(|(known, _)| known == quantity.join("_"));
    let column = std::iter::once(TIME).chain(Column::ALL.iter().map(|c| c.name())).find(known)?;
    let (_, own) = column.rsplit_once('_')?;
    let factor = match unit.strip_suffix(own)? {
        "k" => 1e3,
        "c" if own == "m" => 1e-2,
        "m" => 1e-3,
        "u" => 1e-6,
        _ => return None,
    };
    Some((column, factor))
}

/// An entry of the rig file's `[recording.columns]`.
pub(crate) fn map_entry(quantity: &str, column: &str, scale: Option<f64>) -> String {
    let scale = scale.map(|s| format!(", scale = {s:?}")).unwrap_or_default();
    format!("{quantity} = {{ column = \"{}\"{scale} }}", column.escape_debug())
}

/// Whether a cell is a number but for a comma as its decimal sign.
pub(crate) fn decimal_comma(cell: &str) -> bool {
    cell.matches(',').count() == 1 && cell.replace(',', ".").trim().parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_and_other_units_are_recognised() {
        assert_eq!(nearest("positon_m"), Some("position_m"));
        assert_eq!(nearest("position_mm"), Some("position_m"));
        assert_eq!(nearest("Position [mm]"), Some("position_m"));
        assert_eq!(nearest("Time"), Some("time_s"));
        assert_eq!(nearest("Duty"), Some("duty"));
        assert_eq!(nearest("force"), Some("force_n"));
        assert_eq!(nearest("martensite"), None);
        assert_eq!(nearest("Pos"), None);
        assert_eq!(nearest(&"x".repeat(100_000)), None);
    }

    #[test]
    fn another_unit_has_its_factor() {
        assert_eq!(in_another_unit("position_mm"), Some(("position_m", 1e-3)));
        assert_eq!(in_another_unit("Position [cm]"), Some(("position_m", 1e-2)));
        assert_eq!(in_another_unit("current (mA)"), Some(("current_a", 1e-3)));
        assert_eq!(in_another_unit("force_kn"), Some(("force_n", 1e3)));
        assert_eq!(in_another_unit("v1_µv"), Some(("v1_v", 1e-6)));
        for name in ["position_m", "position_inch", "position", "mm", "", "duty_%", "temperature_c", "foo_mm"] {
            assert_eq!(in_another_unit(name), None, "{name}");
        }
    }

    #[test]
    fn the_time_is_found_and_scaled() {
        let columns = ["Pos".to_string(), "t_ms".to_string()];
        assert_eq!(time_like(&columns), Some("t_ms"));
        assert_eq!(time_scale("t_ms"), Some(1e-3));
        assert_eq!(time_scale("Time [us]"), Some(1e-6));
        assert_eq!(time_scale("t"), None);
        assert_eq!(map_entry("time_s", "t_ms", Some(1e-3)), "time_s = { column = \"t_ms\", scale = 0.001 }");
    }
}
