//! Labels of recorded quantities: a column's or field's name in words, and its unit.

/// What a column or field is called, and its unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// In words, as in "Wire temperature".
    pub title: String,
    /// SI, without a prefix; "1" for a pure number.
    pub unit: &'static str,
}

/// Every name whose words are not those of the name itself. The rest of a name is its unit.
const TITLES: [(&str, &str); 31] = [
    ("time_s", "Time"),
    ("duty", "Duty"),
    ("power_w", "Heating power"),
    ("temperature_c", "Wire temperature"),
    ("supply_v", "Supply voltage"),
    ("current_a", "Current"),
    ("v1_v", "Voltage at the first tap"),
    ("v2_v", "Voltage at the second tap"),
    ("v3_v", "Voltage at the moving end"),
    ("force_n", "Tension"),
    ("position_m", "Elongation"),
    ("ambient_c", "Ambient temperature"),
    ("disturbance_n", "Disturbance"),
    ("length_m", "Wire length"),
    ("measured_length_m", "Wire length, sample by sample"),
    ("velocity_m_s", "Speed, observed"),
    ("acceleration_m_s2", "Acceleration, observed"),
    ("target_m", "Length asked for"),
    ("resistance_ohm", "Resistance"),
    ("martensite", "Martensite fraction"),
    ("surface", "Sliding surface"),
    ("lease_s", "Lease"),
    ("mode", "Mode"),
    ("fault", "Fault"),
    ("health", "Health of the sample"),
    ("flags", "Flags"),
    ("strain", "Strain"),
    ("stress_pa", "Stress"),
    ("chamber_c", "Chamber temperature"),
    ("crosshead_m", "Cross-head"),
    ("missed", "Periods missed"),
];

/// Endings of names, and the units they stand for. Longer ones first.
const ENDINGS: [(&str, &str); 15] = [
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_ohm", "Ω"),
    ("_hz", "Hz"),
    ("_pa", "Pa"),
    ("_ns", "ns"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
    ("_w", "W"),
    ("_v", "V"),
    ("_a", "A"),
    ("_c", "°C"),
    ("_k", "K"),
    ("_j", "J"),
];

impl Field {
    /// The field of this name: known ones in words of their own, others by what their name says.
    pub fn of(name: &str) -> Field {
        let (bare, unit) = ENDINGS
            .iter()
            .find_map(|(ending, unit)| Some((name.strip_suffix(ending)?, *unit)))
            .filter(|(bare, _)| !bare.is_empty())
            .unwrap_or((name, if name == "surface" { "m/s²" } else { "1" }));
        let title = TITLES.iter().find(|(known, _)| *known == name).map_or_else(
            || {
                let words = bare.replace('_', " ");
                let mut letters = words.chars();
                letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
            },
            |(_, title)| (*title).to_owned(),
        );
        Field { title, unit }
    }

    /// Whether `word` means the field `name`: the whole name, or the name without its unit.
    pub fn is_meant(word: &str, name: &str) -> bool {
        word == name || ENDINGS.iter().any(|(ending, _)| name.strip_suffix(ending).is_some_and(|bare| bare == word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_its_words_and_unit() {
        for (name, title, unit) in [
            ("length_m", "Wire length", "m"),
            ("velocity_m_s", "Speed, observed", "m/s"),
            ("acceleration_m_s2", "Acceleration, observed", "m/s²"),
            ("resistance_ohm", "Resistance", "Ω"),
            ("duty", "Duty", "1"),
            ("surface", "Sliding surface", "m/s²"),
            ("cell_temperature_c", "Cell temperature", "°C"),
            ("_m", " m", "1"),
            ("", "", "1"),
        ] {
            assert_eq!(Field::of(name), Field { title: title.into(), unit }, "{name}");
        }
        assert!(Field::is_meant("length", "length_m") && Field::is_meant("duty", "duty"));
        assert!(!Field::is_meant("length", "measured_length_m"));
    }

    #[test]
    fn no_name_is_listed_twice() {
        for (i, (name, _)) in TITLES.iter().enumerate() {
            assert!(TITLES[..i].iter().all(|(other, _)| other != name), "{name}");
        }
    }
}
