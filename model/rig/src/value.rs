//! From what stands in the file to a key's value, or what is wrong with it and what was probably meant.

use crate::error::What;
use crate::key::{Key, Kind, Value, choices};
use crate::suggest::nearest;
use crate::tree::{Node, Tree};

/// Longest name of a device or file in a rig file, in bytes.
pub const MAX_PATH: usize = 255;

/// Names of a rig or channel: the rule in words.
const NAME_RULE: &str = "letters, digits, '-', '_' and '.', a letter or digit first";

/// A key's value in SI, or what is wrong with it.
pub(crate) fn value<T>(key: &Key<T>, node: &Node) -> Result<Value, What> {
    match &key.takes {
        Kind::Number { unit, low, high } => in_range(node, *low, *high).map(|found| Value::Number(unit.to_si(found))),
        Kind::Integer { low, high, times } => {
            whole_in_range(node, *low, *high).map(|found| Value::Integer(found * times))
        }
        Kind::Boolean => match &node.value {
            Tree::Boolean(on) => Ok(Value::Boolean(*on)),
            other => Err(What::WrongType { found: other.describe(), expected: "true or false".into() }),
        },
        Kind::Choice(words) => match &node.value {
            Tree::Text(word) if words.contains(&word.as_str()) => Ok(Value::Text(word.clone())),
            Tree::Text(word) => Err(not_a_choice(word, words)),
            other => Err(What::WrongType { found: other.describe(), expected: choices(words) }),
        },
        Kind::Name { longest } => match &node.value {
            Tree::Text(name) if is_name(name, *longest) => Ok(Value::Text(name.clone())),
            Tree::Text(name) => {
                Err(What::BadName { found: shown(name), expected: format!("{NAME_RULE}, at most {longest}") })
            }
            other => Err(What::WrongType { found: other.describe(), expected: "a name in quotes".into() }),
        },
        Kind::Text { what, longest } => match &node.value {
            Tree::Text(text) if is_text(text, *longest) => Ok(Value::Text(text.clone())),
            Tree::Text(text) => {
                let expected = format!("{what}: text without control characters, 1 to {longest} bytes");
                Err(What::BadName { found: shown(text), expected })
            }
            other => Err(What::WrongType { found: other.describe(), expected: format!("{what} in quotes") }),
        },
    }
}

/// What was written, as far as a message can hold it.
fn shown(text: &str) -> String {
    text.chars().take(60).flat_map(char::escape_debug).collect()
}

/// Whether a text can name something of the operating system's.
fn is_text(text: &str, longest: usize) -> bool {
    (1..=longest).contains(&text.len()) && !text.chars().any(char::is_control)
}

/// Whether a text can be a name: it becomes part of service names, columns and commands.
pub(crate) fn is_name(name: &str, longest: usize) -> bool {
    name.len() <= longest
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'))
}

/// Any number TOML can hold: its integers have 64 bits.
pub(crate) fn number(node: &Node, expected: &str) -> Result<f64, What> {
    match &node.value {
        Tree::Integer(i) if i64::try_from(*i).is_err() => {
            let expected = format!("{expected}; TOML's integers have 64 bits, write a larger one with a decimal point");
            Err(What::WrongType { found: format!("{i}"), expected })
        }
        _ => any_number(node, expected),
    }
}

fn any_number(node: &Node, expected: &str) -> Result<f64, What> {
    match &node.value {
        Tree::Integer(i) => Ok(*i as f64),
        Tree::Float(f, _) if f.is_finite() => Ok(*f),
        Tree::Float(_, text) => Err(What::NotFinite { found: text.clone(), expected: expected.into() }),
        other => Err(What::WrongType { found: other.describe(), expected: expected.into() }),
    }
}

/// A number within a range that includes its ends.
pub(crate) fn in_range(node: &Node, low: f64, high: f64) -> Result<f64, What> {
    let found = any_number(node, &format!("a number, {low} to {high}"))?;
    if (low..=high).contains(&found) { Ok(found) } else { Err(What::OutOfRange { found, low, high, defaulted: false }) }
}

/// What is wrong with the number a key has in a rig that a program made or changed: the same as if it were read.
pub(crate) fn wrong_number<T: 'static>(key: &Key<T>, of: &T) -> Option<What> {
    let (Kind::Number { unit, low, high }, Some(Value::Number(found))) = (&key.takes, key.get(of)) else { return None };
    if !found.is_finite() {
        let expected = format!("a number, {low} to {high}");
        return Some(What::NotFinite { found: found.to_string().to_lowercase(), expected });
    }
    let inside = (unit.to_si(*low)..=unit.to_si(*high)).contains(&found);
    (!inside).then(|| What::OutOfRange { found: unit.to_file(found), low: *low, high: *high, defaulted: false })
}

fn whole_in_range(node: &Node, low: i64, high: i64) -> Result<i64, What> {
    let Tree::Integer(found) = node.value else {
        let expected = format!("a whole number, {low} to {high}");
        return Err(What::WrongType { found: node.value.describe(), expected });
    };
    let inside = i64::try_from(found).ok().filter(|i| (low..=high).contains(i));
    inside.ok_or(What::OutOfRange { found: found as f64, low: low as f64, high: high as f64, defaulted: false })
}

/// What is said of a word that is none of those to choose from.
pub(crate) fn not_a_choice(word: &str, words: &[&str]) -> What {
    let expected = match nearest(word, words.iter().copied()) {
        Some(near) => format!("{}; did you mean \"{near}\"?", choices(words)),
        None => choices(words),
    };
    What::NotAChoice { found: shown(word), expected }
}

/// The channels that a name could have meant.
pub(crate) fn channel_choices<'c>(name: &str, channels: impl IntoIterator<Item = &'c str>) -> String {
    let names: Vec<&str> = channels.into_iter().filter(|name| !name.is_empty()).collect();
    match nearest(name, names.iter().copied()) {
        Some(near) => format!("the name of a channel; did you mean \"{near}\"?"),
        None => format!("the name of a channel: {}", choices(&names)),
    }
}

/// What an unknown key of a table was probably meant to be: one of its keys, or the list.
pub(crate) fn unknown_hint<'k>(name: &str, table: &str, keys: impl IntoIterator<Item = &'k str>) -> String {
    let keys: Vec<&str> = keys.into_iter().collect();
    match nearest(name, keys.iter().copied()) {
        Some(near) => format!(", did you mean {near}?"),
        None if keys.len() <= 12 => format!("; expected {}", keys.join(", ")),
        None => format!("; the keys of [{table}] are listed in docs/rig.md"),
    }
}

/// A number of four digits that matter, as a rig file has it: `0.125`, `158.0`, `1234.6`.
pub fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0.0".into();
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(1, 9) as usize;
    let text = format!("{value:.digits$}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_toml() {
        for (value, text) in [
            (6.0, "6.0"),
            (0.125, "0.125"),
            (158.04999, "158.0"),
            (0.00012347, "0.0001235"),
            (1234.56, "1234.6"),
            (0.0, "0.0"),
        ] {
            assert_eq!(rounded(value), text);
        }
    }
}
