//! What one cycle holds: the channels by name, the fields each of them has, and the schema text that tells any reader so.
//!
//! A cycle is one message: `uint64 cycle`, `uint64 monotonic_ns`, `uint64 missed`, then one field a channel, all of the same type:
//! `float64` and `uint32` fields in the order of [`Layout::fields`]. Encoded as CDR (XCDR1, little endian) a channel then is
//! byte for byte a `repr(C)` structure with these fields, provided its size is a multiple of 8, which [`Layout::new`] sees to.

use std::collections::HashSet;
use std::fmt::Write as _;

use super::error::Trouble;

/// Type of the message on [`super::CYCLES`].
pub(super) const CYCLE_TYPE: &str = "sinew_msgs/msg/Cycle";
/// Type of one channel in it.
const CHANNEL_TYPE: &str = "sinew_msgs/Channel";
/// The fields before the channels.
const HEAD: [&str; 3] = ["cycle", "monotonic_ns", "missed"];
/// Bytes of those.
pub(super) const HEAD_BYTES: usize = 24;
/// Most channels of a recording.
pub const MAX_CHANNELS: usize = 1024;
/// Most fields of a channel.
pub const MAX_FIELDS: usize = 1024;
/// Longest schema that is read, bytes.
const MAX_TEXT: usize = 1 << 20;

/// What a field is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A 64-bit float; NaN = not known.
    F64,
    /// A 32-bit code, count or set of flags.
    U32,
}

impl Kind {
    const fn bytes(self) -> usize {
        match self {
            Kind::F64 => 8,
            Kind::U32 => 4,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Kind::F64 => "float64",
            Kind::U32 => "uint32",
        }
    }
}

/// One quantity of a channel.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Field {
    /// Its name, with its unit: `length_m`.
    pub name: String,
    /// What it is made of.
    pub kind: Kind,
    /// Its unit; empty where it has none.
    pub unit: String,
}

impl Field {
    /// A float.
    pub fn f64(name: &str, unit: &str) -> Field {
        Field { name: name.into(), kind: Kind::F64, unit: unit.into() }
    }

    /// A code, a count or flags.
    pub fn u32(name: &str) -> Field {
        Field { name: name.into(), kind: Kind::U32, unit: String::new() }
    }
}

/// What a driver up to protocol 5 called the length without a sample's noise. It called the sample itself `length_m`.
const OBSERVED: &str = "observed_length_m";

/// Today's name of a field.
fn today(name: &str) -> &str {
    if name == OBSERVED { "length_m" } else { name }
}

/// Gives the lengths of a recording of such a driver today's names.
fn rename_lengths(fields: &mut [Field]) {
    if fields.iter().any(|field| field.name == OBSERVED) {
        for field in fields {
            match field.name.as_str() {
                OBSERVED => field.name = today(OBSERVED).into(),
                "length_m" => field.name = "measured_length_m".into(),
                _ => {}
            }
        }
    }
}

/// The channels of a recording and the fields of each; the order is that of the bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Names of the channels, as in the rig file.
    pub channels: Vec<String>,
    /// Fields of every channel.
    pub fields: Vec<Field>,
}

impl Layout {
    /// A layout, checked.
    ///
    /// # Errors
    /// [`Trouble::Layout`] for no or too many channels or fields, for names twice or names no schema can have, and for fields that do
    /// not fill whole 8 bytes or would leave holes.
    pub fn new(channels: Vec<String>, fields: Vec<Field>) -> Result<Layout, Trouble> {
        let layout = Layout { channels, fields };
        let wrong = |reason: String| Err(Trouble::Layout { reason });
        for (what, count, most) in
            [("channels", layout.channels.len(), MAX_CHANNELS), ("fields", layout.fields.len(), MAX_FIELDS)]
        {
            if count == 0 || count > most {
                return wrong(format!("it has {count} {what}, expected 1 to {most}"));
            }
        }
        if let Some(twice) = first_twice(&layout.channels) {
            return wrong(format!("two of its channels are called {twice:?}"));
        }
        let names: Vec<&str> = layout.fields.iter().map(|field| field.name.as_str()).collect();
        if let Some(twice) = first_twice(&names) {
            return wrong(format!("two of its fields are called {twice:?}"));
        }
        if let Some(bad) = names.iter().find(|name| !is_identifier(name)) {
            return wrong(format!("{bad:?} cannot be the name of a field: expected a-z, then a-z, 0-9 and single _"));
        }
        if let Some(bad) = layout.fields.iter().find(|field| field.unit.contains(['\n', '\r'])) {
            return wrong(format!("the unit of {:?} has more than one line", bad.name));
        }
        let packed: usize = layout.fields.iter().map(|field| field.kind.bytes()).sum();
        if layout.stride() != packed || !packed.is_multiple_of(8) {
            return wrong(
                "its fields do not fill whole 8 bytes: put floats first, then an even number of codes".into(),
            );
        }
        Ok(layout)
    }

    /// Bytes of one channel.
    pub fn stride(&self) -> usize {
        let end = offsets(&self.fields).last().map_or(0, |&(kind, offset)| offset + kind.bytes());
        end.next_multiple_of(8)
    }

    /// Bytes of all channels of a cycle.
    pub fn bytes(&self) -> usize {
        self.stride() * self.channels.len()
    }

    /// The number of the channel with this name.
    pub fn channel(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|channel| channel == name)
    }

    /// The number of the field with this name, or with one it once had.
    pub fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|field| field.name == today(name))
    }

    /// What the channels are called in the schema, where not every name is allowed: `front_left_coxa` stays, `Bench 1` becomes
    /// `bench_1`. No two alike.
    pub fn identifiers(&self) -> Vec<String> {
        let mut taken: HashSet<String> = HEAD.iter().map(|name| name.to_string()).collect();
        self.channels
            .iter()
            .map(|name| {
                let plain = identifier(name);
                let free = (1..).map(|n| if n == 1 { plain.clone() } else { format!("{plain}_{n}") });
                let free = free.into_iter().find(|name| !taken.contains(name)).unwrap_or(plain.clone());
                taken.insert(free.clone());
                free
            })
            .collect()
    }

    /// The schema, in the form of ROS 2 message definitions.
    pub(super) fn text(&self) -> String {
        let mut text = String::from(
            "# One cycle of all channels.\n\
             uint64 cycle  # number of the cycle; consecutive, a gap is what the recorder lost\n\
             uint64 monotonic_ns  # when its samples were taken, CLOCK_MONOTONIC\n\
             uint64 missed  # periods skipped since the start because the loop was late\n",
        );
        for (identifier, name) in self.identifiers().iter().zip(&self.channels) {
            let _ = writeln!(text, "{CHANNEL_TYPE} {identifier}  # {}", name.escape_debug());
        }
        let _ = writeln!(text, "{}\nMSG: {CHANNEL_TYPE}", "=".repeat(80));
        for field in &self.fields {
            let _ = write!(text, "{} {}", field.kind.name(), field.name);
            let _ = if field.unit.is_empty() { writeln!(text) } else { writeln!(text, "  # {}", field.unit) };
        }
        text
    }

    /// From a schema's text; the channels are called as in the schema.
    pub(super) fn parse(text: &[u8]) -> Result<Layout, Trouble> {
        let wrong = |reason: &str| Trouble::Schema { reason: reason.into() };
        if text.len() > MAX_TEXT {
            return Err(wrong("it is longer than a megabyte"));
        }
        let text = std::str::from_utf8(text).map_err(|_| wrong("it is not UTF-8 text"))?;
        let mut main: Vec<Line> = Vec::new();
        let mut others: Vec<(&str, Vec<Line>)> = Vec::new();
        let mut after_rule = false;
        for line in text.lines() {
            let line = line.trim();
            if line.len() >= 3 && line.bytes().all(|b| b == b'=') {
                after_rule = true;
            } else if let Some(name) = line.strip_prefix("MSG:").filter(|_| after_rule) {
                others.push((name.trim(), Vec::new()));
                after_rule = false;
            } else if let Some(field) = Line::parse(line)? {
                match others.last_mut() {
                    _ if after_rule => return Err(wrong("a definition has no name")),
                    Some((_, fields)) => fields.push(field),
                    None => main.push(field),
                }
            }
        }
        let is_head = main.len() > HEAD.len()
            && main.iter().zip(HEAD).all(|(line, name)| line.name == name && line.kind == "uint64");
        if !is_head {
            return Err(wrong("a cycle does not begin with cycle, monotonic_ns and missed"));
        }
        let rest = &main[HEAD.len()..];
        let of = rest[0].kind;
        if let Some(other) = rest.iter().find(|line| line.kind != of) {
            return Err(Trouble::Schema { reason: format!("{:?} is no channel like the first", other.name) });
        }
        let short = |name: &'_ str| name.rsplit('/').next().unwrap_or_default().to_string();
        let (_, fields) = others
            .iter()
            .find(|(name, _)| short(name) == short(of))
            .ok_or_else(|| Trouble::Schema { reason: format!("the type {of:?} is not defined") })?;
        let fields = fields.iter().map(|line| {
            let kind = match line.kind {
                "float64" => Kind::F64,
                "uint32" => Kind::U32,
                other => return Err(Trouble::Schema { reason: format!("fields of type {other:?} are not read") }),
            };
            Ok(Field { name: line.name.into(), kind, unit: line.comment.into() })
        });
        let mut fields = fields.collect::<Result<Vec<Field>, _>>()?;
        rename_lengths(&mut fields);
        let channels = rest.iter().map(|line| line.name.to_string()).collect();
        Layout::new(channels, fields).map_err(|trouble| Trouble::Schema { reason: trouble.to_string() })
    }
}

/// One field's line of a definition.
struct Line<'a> {
    kind: &'a str,
    name: &'a str,
    comment: &'a str,
}

impl Line<'_> {
    /// `None` for a line without a field.
    fn parse(line: &str) -> Result<Option<Line<'_>>, Trouble> {
        let (code, comment) = line.split_once('#').unwrap_or((line, ""));
        let code = code.trim();
        // constants take no room in a message
        if code.is_empty() || code.contains('=') {
            return Ok(None);
        }
        let (kind, name) = code
            .split_once(char::is_whitespace)
            .ok_or_else(|| Trouble::Schema { reason: format!("{:?} is no field", shorten(code)) })?;
        Ok(Some(Line { kind, name: name.trim(), comment: comment.trim() }))
    }
}

fn shorten(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Each field's kind and its offset in a channel, aligned as CDR aligns.
pub(super) fn offsets(fields: &[Field]) -> Vec<(Kind, usize)> {
    let mut end = 0usize;
    fields
        .iter()
        .map(|field| {
            let offset = end.next_multiple_of(field.kind.bytes());
            end = offset + field.kind.bytes();
            (field.kind, offset)
        })
        .collect()
}

fn first_twice<T: AsRef<str>>(names: &[T]) -> Option<&str> {
    let mut seen = HashSet::new();
    names.iter().map(AsRef::as_ref).find(|name| !seen.insert(*name))
}

/// Whether ROS takes it as the name of a field.
fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
        && !name.contains("__")
        && !name.ends_with('_')
}

/// The nearest name ROS takes.
fn identifier(name: &str) -> String {
    let mut plain = String::new();
    for c in name.chars().map(|c| c.to_ascii_lowercase()) {
        match c {
            'a'..='z' | '0'..='9' => plain.push(c),
            _ if plain.is_empty() || plain.ends_with('_') => {}
            _ => plain.push('_'),
        }
    }
    let plain = plain.trim_end_matches('_');
    match plain.as_bytes().first() {
        Some(first) if first.is_ascii_lowercase() => plain.into(),
        Some(_) => format!("channel_{plain}"),
        None => "channel".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn layout(channels: &[&str]) -> Layout {
        let fields = vec![Field::f64("length_m", "m"), Field::f64("duty", ""), Field::u32("mode"), Field::u32("fault")];
        Layout::new(channels.iter().map(|name| name.to_string()).collect(), fields).unwrap()
    }

    #[test]
    fn the_schema_is_what_ros_would_call_such_a_message() {
        let text = layout(&["front_left", "Größe 2"]).text();
        let (head, channel) = text.split_once(&format!("{}\n", "=".repeat(80))).unwrap();
        assert!(head.contains("\nsinew_msgs/Channel front_left  # front_left\n"), "{head}");
        assert!(head.contains("\nsinew_msgs/Channel gr_e_2  # Größe 2\n"), "{head}");
        assert_eq!(
            channel,
            "MSG: sinew_msgs/Channel\nfloat64 length_m  # m\nfloat64 duty\nuint32 mode\nuint32 fault\n"
        );
    }

    #[test]
    fn names_become_identifiers_no_two_alike() {
        let layout = layout(&["A-b", "a.b", "a_b", "a_b_2", "7", "__", "cycle", "ünder_"]);
        let names = layout.identifiers();
        assert_eq!(names, ["a_b", "a_b_2", "a_b_3", "a_b_2_2", "channel_7", "channel", "cycle_2", "nder"]);
        assert!(names.iter().all(|name| is_identifier(name)));
    }

    #[test]
    fn what_no_message_can_be_is_refused() {
        let two = |fields: Vec<Field>| Layout::new(vec!["a".into()], fields);
        let f = Field::f64("x", "m");
        for (fields, word) in [
            (vec![], "0 fields"),
            (vec![f.clone(), f.clone()], "called \"x\""),
            (vec![f.clone(), Field::u32("n")], "whole 8 bytes"),
            (vec![Field::u32("n"), f.clone(), Field::u32("m")], "whole 8 bytes"),
            (vec![Field::f64("Length", "")], "cannot be the name"),
            (vec![Field::f64("x", "m\n")], "more than one line"),
        ] {
            let trouble = two(fields).unwrap_err().to_string();
            assert!(trouble.contains(word), "{trouble}");
        }
        assert!(Layout::new(vec!["a".into(), "a".into()], vec![f.clone()]).is_err());
        assert!(Layout::new(vec![], vec![f]).is_err());
    }

    #[test]
    fn lengths_of_recordings_up_to_protocol_5_have_todays_names() {
        let text = |lengths: &str| {
            layout(&["a"]).text().replace("float64 length_m  # m\n", lengths).replace("float64 duty\n", "")
        };
        let old = text("float64 length_m  # m\nfloat64 observed_length_m  # m\n");
        let old = Layout::parse(old.as_bytes()).unwrap();
        assert_eq!((old.field("measured_length_m"), old.field("length_m")), (Some(0), Some(1)), "{old:?}");
        assert_eq!(old.field("observed_length_m"), Some(1), "the old name goes on being found");
        let new = text("float64 length_m  # m\nfloat64 measured_length_m  # m\n");
        let new = Layout::parse(new.as_bytes()).unwrap();
        assert_eq!((new.field("length_m"), new.field("measured_length_m")), (Some(0), Some(1)), "{new:?}");
        // An imported one has what its file had.
        let plain = Layout::parse(text("float64 length_m  # m\nfloat64 duty\n").as_bytes()).unwrap();
        assert_eq!((plain.field("length_m"), plain.field("measured_length_m")), (Some(0), None), "{plain:?}");
    }

    #[test]
    fn schemas_of_others_are_refused_by_name_of_what_is_wrong() {
        let good = layout(&["a"]).text();
        for (from, to, word) in [
            ("uint64 missed", "uint32 missed", "does not begin"),
            ("float64 length_m", "float32 length_m", "float32"),
            ("float64 length_m", "float64[] length_m", "float64[]"),
            ("MSG: sinew_msgs/Channel", "MSG: sinew_msgs/Other", "not defined"),
            ("float64 length_m", "float64", "no field"),
        ] {
            let bad = good.replace(from, to);
            assert_ne!(bad, good);
            let trouble = Layout::parse(bad.as_bytes()).unwrap_err().to_string();
            assert!(trouble.contains(word), "{trouble}");
        }
        assert!(Layout::parse(b"\xff").is_err());
        assert!(Layout::parse(&vec![b' '; MAX_TEXT + 1]).is_err());
    }

    proptest! {
        #[test]
        fn a_schema_reads_back_as_the_layout_it_came_from(
            names in prop::collection::hash_set("[a-z][a-z0-9]{0,8}(_[a-z0-9]{1,3})?", 1..20),
            floats in 1usize..20,
            codes in 0usize..4,
        ) {
            let fields = (0..floats).map(|i| Field::f64(&format!("x{i}_m"), "m/s²"))
                .chain((0..2 * codes).map(|i| Field::u32(&format!("n{i}")))).collect();
            let layout = Layout::new(names.into_iter().collect(), fields).unwrap();
            let back = Layout::parse(layout.text().as_bytes()).unwrap();
            prop_assert_eq!(back.channels, layout.identifiers());
            prop_assert_eq!(back.fields, layout.fields);
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in "[ -~\n=#/]{0,400}") {
            let _ = Layout::parse(text.as_bytes());
        }
    }
}
