//! What the tables say to people: the reference of `docs/rig.md`, and the words a key takes.

mod effects;
mod schema;

use std::fmt::Write as _;

use crate::key::{Default, Kind, Section, Value};
use crate::tables::{Channel, JOINT, RIG, key_of_channel, of_channel, of_rig};

pub use effects::catalogue;
pub use schema::schema;

/// The words that a key of a channel takes, such as those of `algorithm` in `channel.control`; empty where it takes none.
pub fn words(table: &str, key: &str) -> &'static [&'static str] {
    match key_of_channel(table, key).map(|key| &key.takes) {
        Some(Kind::Choice(words)) => words,
        _ => &[],
    }
}

/// The word that is in force for such a key.
pub fn word(channel: &Channel, table: &str, key: &str) -> Option<String> {
    match key_of_channel(table, key)?.get(channel) {
        Some(Value::Text(word)) => Some(word),
        _ => None,
    }
}

/// The reference of every key as Markdown: one table for each table of the rig file.
/// `docs/rig.md` carries it word for word.
pub fn reference() -> String {
    let mut out = String::new();
    describe(&mut out, &RIG, "[rig]");
    for section in of_channel() {
        let header = if section.local().is_empty() { "[[channel]]".into() } else { format!("[{}]", section.table) };
        describe(&mut out, section, &header);
    }
    describe(&mut out, &JOINT, "[[joint]]");
    for section in of_rig() {
        describe(&mut out, section, &format!("[{}]", section.table));
    }
    out
}

fn describe<T: 'static>(out: &mut String, section: &Section<T>, header: &str) {
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "### `{header}`\n\n{}\n\n| key | unit | default | range | |\n|---|---|---|---|---|\n",
        section.about
    );
    for key in section.keys() {
        let (unit, range) = match &key.takes {
            Kind::Number { unit, low, high } => (unit.name, format!("{low} to {high}")),
            Kind::Integer { low, high: i64::MAX, .. } => ("", format!("whole, from {low}")),
            Kind::Integer { low, high, .. } => ("", format!("whole, {low} to {high}")),
            Kind::Boolean => ("", "`true`, `false`".into()),
            Kind::Choice(words) => ("", words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")),
            Kind::Name { .. } => ("", "a name".into()),
            Kind::Text { what, .. } => ("", (*what).into()),
        };
        let default = match &key.default {
            Default::Required(_) => "**required**".into(),
            Default::Number(n) => format!("{n}"),
            Default::Integer(i) => format!("{i}"),
            Default::Boolean(on) => format!("`{on}`"),
            Default::Text(t) => format!("`{t}`"),
            Default::Computed(words) => (*words).into(),
        };
        let _ = writeln!(out, "| `{}` | {unit} | {default} | {range} | {} |", key.name, key.about());
    }
    out.push('\n');
}

#[cfg(test)]
mod tests {
    #[test]
    fn words_are_those_the_reader_takes() {
        let words = super::words("channel.control", "algorithm");
        assert!(words.contains(&"sliding_mode") && words.contains(&"pi"));
        for word in words {
            let text = format!(
                "[rig]\nname = \"a\"\n[[channel]]\nname = \"w\"\nwire = {{ diameter_mm = 0.1, length_mm = 100.0 }}\n\
                 drive = {{ supply_v = 5.0 }}\nload = {{ mass_kg = 0.1, damping_n_s_per_m = 10.0 }}\n\
                 control = {{ algorithm = \"{word}\" }}\n"
            );
            let rig = crate::Rig::parse(&text, "a.toml").unwrap_or_else(|e| panic!("{word}: {e}"));
            assert_eq!(super::word(&rig.channels[0], "channel.control", "algorithm").as_deref(), Some(*word));
        }
        let no_words: &[&str] = &[];
        assert_eq!(super::words("channel.control", "lambda_per_s"), no_words);
        assert_eq!(super::words("channel.nothing", "algorithm"), no_words);
        assert_eq!(super::word(&crate::Rig::hexapod().channels[0], "channel.wire", "length_mm"), None);
    }
}
