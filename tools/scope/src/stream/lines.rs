//! Bytes to lines, and a line to numbers, in the ways in which boards and programs print them.
//!
//! Numbers are parted by tabs, semicolons, commas or blanks; a comma is a decimal one where tabs or semicolons part them. A
//! number may bear its name (`temp:21.3`, `temp = 21.3`) and its unit (`12.4mm`).

/// Longer lines are no lines: something else is on the line, or its rate is another.
const LONGEST: usize = 4096;
/// Longest name of a number, and longest unit behind one, in characters.
const LONGEST_NAME: usize = 40;
const LONGEST_UNIT: usize = 6;

/// Lines out of bytes that come in pieces.
#[derive(Debug, Default)]
pub struct Lines {
    held: Vec<u8>,
    /// What comes up to the end of this line belongs to one whose begin is not known, or that is too long.
    is_passing: bool,
}

impl Lines {
    /// Of a line that others may have been writing on already: what comes first may be the end of a number.
    pub fn from_the_middle() -> Lines {
        Lines { held: Vec::new(), is_passing: true }
    }

    /// Takes bytes in, and gives each line that is whole, without its end; none for one that is too long.
    pub fn take(&mut self, bytes: &[u8], mut each: impl FnMut(Option<&str>)) {
        for piece in bytes.split_inclusive(|byte| matches!(byte, b'\n' | b'\r')) {
            let (text, ends) = match piece.split_last() {
                Some((b'\n' | b'\r', text)) => (text, true),
                _ => (piece, false),
            };
            if !self.is_passing && self.held.len() + text.len() <= LONGEST {
                self.held.extend_from_slice(text);
            } else if !self.is_passing {
                self.is_passing = true;
                self.held.clear();
                each(None);
            }
            if ends {
                if !self.is_passing {
                    each(Some(&String::from_utf8_lossy(&self.held)));
                }
                self.held.clear();
                self.is_passing = false;
            }
        }
    }

    /// What stands without an end when nothing follows any more: a last line.
    pub fn rest(&mut self) -> Option<String> {
        let held = std::mem::take(&mut self.held);
        (!held.is_empty()).then(|| String::from_utf8_lossy(&held).into_owned())
    }
}

/// A number of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value<'a> {
    /// The name it bears itself.
    pub name: Option<&'a str>,
    /// NaN for one that is left out, and for one that is none: `nan`, `inf`.
    pub number: f64,
    /// The unit behind it; "" where there is none.
    pub unit: &'a str,
}

/// What a line says.
#[derive(Debug, PartialEq)]
pub enum Said<'a> {
    Nothing,
    Numbers(Vec<Value<'a>>),
    /// No numbers: these words, which may be the names of the numbers that follow.
    Words(Vec<&'a str>),
}

/// What parts the numbers of a line.
#[derive(Clone, Copy)]
enum Parting {
    Sign(char),
    Blanks,
}

impl Parting {
    const ALL: [Parting; 4] = [Parting::Sign('\t'), Parting::Sign(';'), Parting::Sign(','), Parting::Blanks];

    fn parts(self, line: &str) -> bool {
        match self {
            Parting::Sign(sign) => line.contains(sign),
            Parting::Blanks => true,
        }
    }

    fn pieces(self, line: &str) -> Vec<&str> {
        match self {
            Parting::Sign(sign) => {
                // a sketch that prints a comma behind every number prints one behind the last
                let line = line.strip_suffix(sign).unwrap_or(line);
                line.split(sign).map(str::trim).collect()
            }
            Parting::Blanks => blanks(line),
        }
    }

    /// Whether a comma can be a decimal one.
    fn leaves_commas(self) -> bool {
        matches!(self, Parting::Sign('\t' | ';'))
    }
}

/// Reads a line.
pub fn read(line: &str) -> Said<'_> {
    let line = line.trim();
    if line.is_empty() {
        return Said::Nothing;
    }
    let ways = || Parting::ALL.into_iter().filter(|parting| parting.parts(line));
    let numbers = ways().find_map(|parting| {
        let pieces = parting.pieces(line);
        pieces.into_iter().map(|piece| value(piece, parting.leaves_commas())).collect::<Option<Vec<_>>>()
    });
    match numbers {
        Some(values) if values.iter().any(|value| !value.number.is_nan() || value.name.is_some()) => {
            Said::Numbers(values)
        }
        // nothing but signs between nothing
        Some(_) => Said::Nothing,
        None => {
            let line = line.trim_start_matches(['#', '%']).trim_start();
            let parting = ways().next().unwrap_or(Parting::Blanks);
            Said::Words(parting.pieces(line))
        }
    }
}

/// The pieces between blanks and commas. A name and its number are one piece, whatever blanks stand between them.
fn blanks(line: &str) -> Vec<&str> {
    let mut pieces: Vec<&str> = Vec::new();
    let mut from = None;
    let bytes = line.as_bytes();
    for (at, byte) in bytes.iter().enumerate() {
        let is_blank = byte.is_ascii_whitespace() || *byte == b',';
        match (from, is_blank) {
            (None, false) => from = Some(at),
            (Some(start), true) => {
                let belongs = |sign: &u8| matches!(sign, b':' | b'=');
                let next = bytes[at..].iter().find(|byte| !byte.is_ascii_whitespace());
                if !(belongs(&bytes[at - 1]) || next.is_some_and(belongs)) {
                    pieces.push(&line[start..at]);
                    from = None;
                }
            }
            _ => {}
        }
    }
    pieces.extend(from.map(|start| &line[start..]));
    pieces
}

/// A piece as a number; none where it is no number.
fn value(piece: &str, leaves_commas: bool) -> Option<Value<'_>> {
    if piece.is_empty() {
        return Some(Value { name: None, number: f64::NAN, unit: "" });
    }
    if let Some((number, unit)) = number(piece, leaves_commas) {
        return Some(Value { name: None, number, unit });
    }
    let (name, rest) = piece.rsplit_once([':', '='])?;
    let name = name.trim();
    // 12:30:05 is a time of day, not a number called 12:30
    if !name.starts_with(char::is_alphabetic) || name.chars().count() > LONGEST_NAME {
        return None;
    }
    let (number, unit) = number(rest.trim(), leaves_commas)?;
    Some(Value { name: Some(name), number, unit })
}

/// A number, and the unit behind it.
fn number(text: &str, leaves_commas: bool) -> Option<(f64, &str)> {
    let parse = |text: &str| {
        let parsed = if leaves_commas && text.contains(',') && !text.contains('.') {
            text.replace(',', ".").parse::<f64>()
        } else {
            text.parse::<f64>()
        };
        parsed.ok().map(|number| if number.is_finite() { number } else { f64::NAN })
    };
    if let Some(number) = parse(text) {
        return Some((number, ""));
    }
    let bare = text.trim_end_matches(|c: char| c.is_alphabetic() || matches!(c, '%' | '°' | '/' | '²'));
    let unit = &text[bare.len()..];
    if unit.is_empty() || unit.chars().count() > LONGEST_UNIT {
        return None;
    }
    parse(bare.trim_end()).map(|number| (number, unit))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn lines_of(pieces: &[&str]) -> Vec<Option<String>> {
        let (mut lines, mut out) = (Lines::default(), Vec::new());
        for piece in pieces {
            lines.take(piece.as_bytes(), |line| out.push(line.map(str::to_string)));
        }
        out
    }

    #[test]
    fn lines_come_whole_however_the_bytes_come() {
        let some = |text: &str| Some(text.to_string());
        assert_eq!(lines_of(&["1 2\r\n3", " 4\n", "5"]), [some("1 2"), some(""), some("3 4")]);
        let long = "1".repeat(LONGEST + 1);
        assert_eq!(lines_of(&[&long, "2\n3\n"]), [None, some("3")]);
        let mut middle = Lines::from_the_middle();
        let mut out = Vec::new();
        middle.take(b"45.2\n1 2\n", |line| out.push(line.map(str::to_string)));
        assert_eq!(out, [some("1 2")]);
        let mut last = Lines::default();
        last.take(b"1\n2", |_| {});
        assert_eq!((last.rest().as_deref(), last.rest()), (Some("2"), None));
    }

    /// Names, numbers and units of a line.
    fn numbers(line: &str) -> Vec<(Option<&str>, f64, &str)> {
        match read(line) {
            Said::Numbers(values) => values.iter().map(|v| (v.name, v.number, v.unit)).collect(),
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn numbers_are_read_as_people_print_them() {
        let plain = |line: &str| numbers(line).into_iter().map(|(_, number, _)| number).collect::<Vec<_>>();
        for line in ["1 -2.5 3e-2", "1,-2.5,0.03", "1, -2.5, 0.03,", "1;-2,5;0,03", "1\t-2,5\t0,03", " 1   -2.5,0.03 "]
        {
            assert_eq!(plain(line), [1.0, -2.5, 0.03], "{line}");
        }
        for line in ["temp:21.5 hum:40", "temp: 21.5, hum: 40", "temp = 21.5; hum = 40", "temp=21.5\thum=40"] {
            assert_eq!(numbers(line), [(Some("temp"), 21.5, ""), (Some("hum"), 40.0, "")], "{line}");
        }
        assert_eq!(numbers("wire temp: 21.5°C, pull: 3.2 N")[0], (Some("wire temp"), 21.5, "°C"));
        assert_eq!(numbers("12.4mm 3N"), [(None, 12.4, "mm"), (None, 3.0, "N")]);
        let gap = plain("1,,3");
        assert!(gap[0] == 1.0 && gap[1].is_nan() && gap[2] == 3.0);
        assert!(plain("nan 1")[0].is_nan());
    }

    #[test]
    fn words_are_no_numbers() {
        assert_eq!(read("# time, force [N]"), Said::Words(vec!["time", "force [N]"]));
        assert_eq!(read("time\tforce"), Said::Words(vec!["time", "force"]));
        assert_eq!(read("sensor ready"), Said::Words(vec!["sensor", "ready"]));
        assert!(matches!(read("12:30:05 4"), Said::Words(_)));
        assert!(matches!(read("error: none"), Said::Words(_)));
        assert_eq!(read("  "), Said::Nothing);
        assert_eq!(read(",,"), Said::Nothing);
    }

    proptest! {
        #[test]
        fn any_line_is_read_without_a_panic(line in "\\PC*") {
            read(&line);
        }

        #[test]
        fn what_is_printed_comes_back(row in prop::collection::vec(-1e9f64..1e9, 1..20), by in 0usize..4) {
            let by = ["\t", ";", ", ", " "][by];
            let line = row.iter().map(f64::to_string).collect::<Vec<_>>().join(by);
            let back: Vec<f64> = numbers(&line).into_iter().map(|(_, number, _)| number).collect();
            prop_assert_eq!(back, row);
        }
    }
}
