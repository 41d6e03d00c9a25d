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
    fn the_time_is_found_and_scaled() {
        let columns = ["Pos".to_string(), "t_ms".to_string()];
        assert_eq!(time_like(&columns), Some("t_ms"));
        assert_eq!(time_scale("t_ms"), Some(1e-3));
        assert_eq!(time_scale("Time [us]"), Some(1e-6));
        assert_eq!(time_scale("t"), None);
        assert_eq!(map_entry("time_s", "t_ms", Some(1e-3)), "time_s = { column = \"t_ms\", scale = 0.001 }");
    }
}
