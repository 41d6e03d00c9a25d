//! TOML text as a plain tree in which every key and value knows its line.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and the line on which its key (or, in an array, the value itself) stands.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub line: usize,
    pub value: Tree,
}

/// A TOML value.
#[derive(Debug, Clone)]
pub(crate) enum Tree {
    Text(String),
    /// Kept as `i128` so that a number too large for a key is out of range, not a mistake of syntax.
    Integer(i128),
    /// With the text as written, for the error message.
    Float(f64, String),
    Boolean(bool),
    Datetime,
    Array(Vec<Node>),
    Table(Table),
}

pub(crate) type Table = BTreeMap<String, Node>;

impl Tree {
    /// What it is, in words for an error message.
    pub(crate) fn describe(&self) -> String {
        match self {
            Tree::Text(t) => {
                let mut short: String = t.chars().take(40).collect();
                if short.len() < t.len() {
                    short.push('…');
                }
                format!("the text \"{}\"", short.escape_debug())
            }
            Tree::Integer(i) => format!("{i}"),
            Tree::Float(_, text) => text.clone(),
            Tree::Boolean(b) => format!("{b}"),
            Tree::Datetime => "a date".into(),
            Tree::Array(_) => "an array".into(),
            Tree::Table(_) => "a table".into(),
        }
    }
}

/// A mistake of syntax: its line and the parser's words.
pub(crate) type SyntaxError = (usize, String);

/// Reads TOML; all mistakes of syntax at once.
pub(crate) fn parse(text: &str) -> Result<Table, Vec<SyntaxError>> {
    let lines = Lines::new(text);
    let (root, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        let mut told: Vec<SyntaxError> = Vec::new();
        for error in &errors {
            let line = error.span().map_or(1, |span| lines.at(span.start));
            // What is behind the first mistake of a line is most often no other.
            if told.iter().any(|(other, _)| *other == line) {
                continue;
            }
            let message = match decimal_comma(text.lines().nth(line - 1).unwrap_or_default()) {
                Some(number) => {
                    format!("{number} has a comma for its decimal sign, expected {}", number.replace(',', "."))
                }
                None => error.message().trim().replace('\n', "; "),
            };
            told.push((line, message));
        }
        return Err(told);
    }
    Ok(table(root.get_ref(), &lines))
}

/// A number of this line that is written with a comma, as in `diameter_mm = 0,125`; a list has its commas in brackets.
fn decimal_comma(line: &str) -> Option<&str> {
    line.match_indices(',').find_map(|(at, _)| {
        let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).count();
        let before = line[..at].chars().rev().take_while(char::is_ascii_digit).count();
        let after = digits(&line[at + 1..]);
        let assigned = line[..at - before].trim_end_matches('-').trim_end().ends_with('=');
        (before > 0 && after > 0 && assigned).then(|| &line[at - before..at + 1 + after])
    })
}

fn table(from: &DeTable<'_>, lines: &Lines) -> Table {
    from.iter().map(|(key, value)| (key.get_ref().to_string(), node(key.span(), value, lines))).collect()
}

fn node(place: Range<usize>, from: &Spanned<DeValue<'_>>, lines: &Lines) -> Node {
    let value = match from.get_ref() {
        DeValue::String(s) => Tree::Text(s.to_string()),
        DeValue::Integer(i) => match i128::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => Tree::Integer(i),
            Err(_) => Tree::Float(f64::INFINITY, format!("{i}")),
        },
        DeValue::Float(f) => Tree::Float(f.as_str().parse().unwrap_or(f64::NAN), f.as_str().to_string()),
        DeValue::Boolean(b) => Tree::Boolean(*b),
        DeValue::Datetime(_) => Tree::Datetime,
        DeValue::Array(a) => Tree::Array(a.iter().map(|v| node(v.span(), v, lines)).collect()),
        DeValue::Table(t) => Tree::Table(table(t, lines)),
    };
    Node { line: lines.at(place.start), value }
}

/// Where the lines of a text begin.
struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    fn new(text: &str) -> Lines {
        let after_newline = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        Lines { starts: std::iter::once(0).chain(after_newline).collect() }
    }

    /// The line, from 1, of a byte offset.
    fn at(&self, offset: usize) -> usize {
        self.starts.partition_point(|start| *start <= offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at<'a>(table: &'a Table, path: &[&str]) -> &'a Node {
        let node = &table[path[0]];
        match (&node.value, &path[1..]) {
            (_, []) => node,
            (Tree::Table(t), rest) => at(t, rest),
            (Tree::Array(a), rest) => match &a[rest[0].parse::<usize>().unwrap()] {
                n if rest.len() == 1 => n,
                Node { value: Tree::Table(t), .. } => at(t, &rest[1..]),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_line_has_one_mistake_and_a_decimal_comma_is_told_as_one() {
        let wrong =
            parse("a = 1\nwire = { diameter_mm = 0,125, length_mm = -160,5 }\nb = [1,2]\nc = = 3,4\n").unwrap_err();
        let [(2, comma), (4, _)] = &wrong[..] else { panic!("{wrong:?}") };
        assert_eq!(comma, "0,125 has a comma for its decimal sign, expected 0.125");
        assert_eq!(decimal_comma("a = [1,2]"), None);
        assert_eq!(decimal_comma("preload_n = -2,6"), Some("2,6"));
        assert_eq!(decimal_comma("ü = { x = 1, y = 2 }"), None);
    }

    #[test]
    fn lines_of_keys_headers_and_elements() {
        let text = "# note\n[rig]\nname = \"a\"\n\n[[channel]]\nname = \"x\"\n[channel.wire]\n\n  length_mm = 1\n[[channel]]\n\
                    wire.length_mm = 2\neffects.\"thermal.draught\" = { gain = 0 }\n";
        let tree = parse(text).unwrap();
        assert_eq!(at(&tree, &["rig"]).line, 2);
        assert_eq!(at(&tree, &["rig", "name"]).line, 3);
        assert_eq!(at(&tree, &["channel", "0"]).line, 5);
        assert_eq!(at(&tree, &["channel", "0", "wire", "length_mm"]).line, 9);
        assert_eq!(at(&tree, &["channel", "1"]).line, 10);
        assert_eq!(at(&tree, &["channel", "1", "wire", "length_mm"]).line, 11);
        assert_eq!(at(&tree, &["channel", "1", "effects", "thermal.draught", "gain"]).line, 12);
    }

    #[test]
    fn syntax_errors_carry_their_line() {
        let errors = parse("a = 1\nb = = 2\n").unwrap_err();
        assert_eq!(errors[0].0, 2, "{errors:?}");
        let errors = parse("a = 1\n\na = 2\n").unwrap_err();
        assert_eq!(errors[0].0, 3, "{errors:?}");
        assert!(errors[0].1.contains("duplicate key"), "{errors:?}");
    }

    #[test]
    fn huge_numbers_are_no_panic() {
        let tree = parse("a = 99999999999999999999999999999999999999999999999\nb = 1e999\nc = 0xff").unwrap();
        assert!(matches!(at(&tree, &["a"]).value, Tree::Float(f, _) if f.is_infinite()));
        assert!(matches!(at(&tree, &["b"]).value, Tree::Float(f, _) if f.is_infinite()));
        assert!(matches!(at(&tree, &["c"]).value, Tree::Integer(255)));
    }
}
