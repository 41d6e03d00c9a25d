//! What can be wrong with a recording, with its place and the remedy.

use std::fmt;

use sinew_physics::DriveKind;

use crate::column::{Column, TIME, drive_column, drive_word};
use crate::session::Trouble;
use crate::suggest;

/// A recording that cannot be used, or not be written. Shown as `FILE:LINE: column "NAME": what; remedy`.
#[derive(Debug, Clone, PartialEq)]
pub struct Error {
    /// The file, as it was given.
    pub file: String,
    /// Line in it, counted from 1, where one is to blame.
    pub line: Option<u64>,
    /// Column as it is called in the file, where one is to blame.
    pub column: Option<String>,
    /// What is wrong.
    pub what: What,
}

/// The kinds of trouble, each with what was found and what would be right.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// The operating system does not let us read it.
    Unreadable {
        /// The system's reason.
        reason: String,
    },
    /// The operating system does not let us write it.
    Unwritable {
        /// The system's reason.
        reason: String,
    },
    /// No byte in it.
    Empty,
    /// A header and nothing below.
    HeaderOnly,
    /// Fewer samples than anything can be computed from.
    TooFewSamples {
        /// Samples found.
        found: usize,
        /// Least number that will do.
        least: usize,
    },
    /// More rows than are read into memory.
    TooManyRows {
        /// Most rows that are read.
        limit: usize,
    },
    /// A line longer than any row can be.
    LineTooLong {
        /// Most bytes of a line.
        limit: usize,
    },
    /// Called `.gz`, but not compressed.
    NotGzip,
    /// Compressed, but not called `.gz`.
    UnexpectedGzip,
    /// The compressed data stop in the middle.
    TruncatedGzip,
    /// The compressed data are damaged.
    CorruptGzip {
        /// The decoder's words.
        reason: String,
    },
    /// Not comma-separated text at all.
    NotText {
        /// What it looks like.
        found: &'static str,
    },
    /// The first line has numbers where names should be.
    NoHeader {
        /// Its first cell.
        found: String,
    },
    /// Columns are separated by something else than a comma.
    WrongSeparator {
        /// By what.
        found: &'static str,
    },
    /// A column the contract does not know.
    UnknownColumn {
        /// The known name nearest to it.
        nearest: Option<&'static str>,
        /// Further unknown columns of the same file.
        others: Vec<String>,
    },
    /// A name that stands twice in the header, or two columns that mean the same.
    DuplicateColumn {
        /// The quantity they both give.
        quantity: &'static str,
        /// The other column.
        other: String,
    },
    /// No column `time_s`.
    MissingTimeColumn {
        /// The columns there are.
        present: Vec<String>,
    },
    /// A column that the map names is not there.
    MissingMapped {
        /// The quantity it was to be.
        quantity: &'static str,
        /// The columns there are.
        present: Vec<String>,
    },
    /// A column the rig's simulation is driven by is not there.
    MissingInput {
        /// Which.
        input: Column,
        /// What asks for it.
        because: Needed,
        /// The columns there are.
        present: Vec<String>,
    },
    /// A row with more or fewer cells than the header.
    FieldCount {
        /// Cells of the header.
        expected: usize,
        /// Cells of the row.
        found: usize,
        /// What may have happened.
        cause: Miscount,
    },
    /// A cell that is no number.
    NotANumber {
        /// As written.
        found: String,
    },
    /// A cell that is infinite.
    Infinite {
        /// As written.
        found: String,
    },
    /// A row without its time.
    MissingTime,
    /// Time that stands still or runs backwards.
    TimeNotIncreasing {
        /// Time of the row before, s.
        previous: f64,
        /// Time of this row, s.
        found: f64,
    },
    /// A recording longer than any experiment.
    TooLong {
        /// From the first sample to this one, s.
        found_s: f64,
        /// The longest that is taken, s.
        limit_s: f64,
    },
    /// A model whose parameters no wire can have, so that nothing can be driven by the recording.
    Impossible {
        /// Which parameter, and what would be right.
        error: sinew_physics::Error,
    },
    /// A recording of a channel that the rig does not have.
    NoSuchChannel {
        /// Its index.
        found: usize,
        /// How many there are.
        channels: usize,
    },
    /// Recordings of one run whose rows are at different times.
    OtherTimes {
        /// The recording it is compared with.
        than: String,
    },
    /// The formula of a law of one's own was no number where the recording drives the wire.
    Undefined {
        /// Its id.
        law: &'static str,
        /// When, s since the first row.
        time_s: f64,
    },
    /// An input with a hole in it.
    MissingSample {
        /// When, s.
        time_s: f64,
    },
    /// Duty outside 0..1.
    DutyOutOfRange {
        /// As read, after any mapping.
        found: f64,
    },
    /// Power below zero.
    NegativePower {
        /// As read, W.
        found: f64,
    },
    /// An elongation longer than the wire.
    PositionTooLarge {
        /// As read, m.
        found: f64,
        /// Length of the wire, m.
        wire_m: f64,
    },
    /// A temperature no such wire survives, or below absolute zero.
    TemperatureOutOfRange {
        /// As read, °C.
        found: f64,
    },
    /// Temperatures that look like kelvin.
    Kelvin {
        /// The lowest of the column.
        lowest: f64,
    },
    /// A column of another length than the time, handed over by a program.
    WrongLength {
        /// Samples of the time.
        expected: usize,
        /// Samples of the column.
        found: usize,
    },
    /// Trouble with a recording in MCAP.
    Session(Trouble),
    /// A session with several channels, and no word or a wrong one about which is meant.
    WhichChannel {
        /// The word, if there was one.
        asked: Option<String>,
        /// The channels there are.
        channels: Vec<String>,
    },
    /// A driver's session without a rig file that says how its samples are to be read.
    NoRig {
        /// What is wrong with the one there is.
        reason: Option<String>,
    },
    /// A driver's session whose cycles lack what rows are made of.
    LacksField {
        /// Which field.
        field: &'static str,
    },
    /// A session without any of the contract's columns.
    NoColumns {
        /// The fields it has.
        fields: Vec<String>,
    },
}

/// What in the rig file asks for an input column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Needed {
    /// The kind of its drive.
    Drive(DriveKind),
    /// Its load, "imposed_position".
    ImposedPosition,
    /// Its load, "imposed_force".
    ImposedForce,
}

/// Why a row may have another number of cells than the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Miscount {
    /// Nothing in particular.
    Unknown,
    /// A comma used as the decimal point makes two cells of one.
    DecimalComma,
    /// A comma at the end of the row.
    TrailingComma,
    /// The last line stops in the middle.
    CutOff,
}

impl Miscount {
    const fn hint(self) -> &'static str {
        match self {
            Miscount::Unknown => "give every row as many cells as the header has; leave a missing sample empty",
            Miscount::DecimalComma => "write numbers with a decimal point, not a comma",
            Miscount::TrailingComma => "take the comma off the end of the rows",
            Miscount::CutOff => "the file stops in the middle of its last row: take that row out, or copy it again",
        }
    }
}

impl Error {
    pub(crate) fn new(file: &str, what: What) -> Error {
        Error { file: file.to_string(), line: None, column: None, what }
    }

    pub(crate) fn at(mut self, line: u64) -> Error {
        self.line = Some(line);
        self
    }

    pub(crate) fn maybe_at(mut self, line: Option<u64>) -> Error {
        self.line = line;
        self
    }

    pub(crate) fn in_column(mut self, column: impl Into<String>) -> Error {
        self.column = Some(column.into());
        self
    }

    /// Whether the recording or its use is to blame (a program should then exit with 2), and not the machine.
    pub fn is_bad_input(&self) -> bool {
        !matches!(
            self.what,
            What::Unwritable { .. }
                | What::WrongLength { .. }
                | What::Session(Trouble::Layout { .. } | Trouble::CycleBytes { .. } | Trouble::NotAfter { .. })
        )
    }

    /// Place and trouble, without the remedy.
    pub fn message(&self) -> String {
        let mut text = self.file.clone();
        if let Some(line) = self.line {
            text += &format!(":{line}");
        }
        text += ": ";
        if let Some(column) = &self.column {
            text += &format!("column \"{}\": ", shorten(column));
        }
        text + &self.what.to_string()
    }

    /// What to do about it.
    pub fn hint(&self) -> String {
        let column = self.column.as_deref().unwrap_or("COLUMN");
        match &self.what {
            What::Unreadable { .. } => "check the path and that you may read it".into(),
            What::Unwritable { .. } => "check the folder, its free space and that you may write there".into(),
            What::Empty | What::HeaderOnly => {
                "record again, or check that the export has finished: a header and at least three rows are needed"
                    .into()
            }
            What::TooFewSamples { least, .. } => format!("give a recording of at least {least} samples"),
            What::TooManyRows { limit } => {
                format!("cut it into files of at most {limit} rows, or keep every n-th row")
            }
            What::LineTooLong { .. } => {
                "end every row with a newline (a file with bare carriage returns has to be converted)".into()
            }
            What::NotGzip => "take the .gz off its name, or compress it with gzip".into(),
            What::UnexpectedGzip => "add .gz to its name, or unpack it with gunzip".into(),
            What::TruncatedGzip => "copy it again from where it came; `gzip -t` tells whether a copy is whole".into(),
            What::CorruptGzip { .. } => "copy it again from where it came, as binary".into(),
            What::NotText { found } => match *found {
                "an MCAP file" => "give it its own name, ending in .mcap".into(),
                "binary" => "save it as CSV text".into(),
                _ => "`sinew import --guess` reads it and writes the map that `sinew import` brings it in by".into(),
            },
            What::NoHeader { .. } => {
                format!("put a line with the columns' names on top, such as {TIME},duty,position_m")
            }
            What::WrongSeparator { .. } => {
                "`sinew import --guess` reads it and writes the map that `sinew import` brings it in by; or write it with commas \
                 between the columns and a point as the decimal sign"
                    .into()
            }
            What::UnknownColumn { nearest, .. } => map_or_ignore(column, *nearest),
            What::DuplicateColumn { .. } => "take one of them out".into(),
            What::MissingTimeColumn { present } => name_the_time(present),
            What::MissingMapped { quantity, present } => {
                let near = sinew_rig::nearest(column, present.iter().map(String::as_str));
                let meant = near.map(|near| format!("did you mean \"{}\"? ", shorten(near))).unwrap_or_default();
                format!("{meant}name it in [recording.columns] as the file does, or take the entry {quantity} out")
            }
            What::MissingInput { input, because, present } => give_the_input(*input, *because, present),
            What::FieldCount { cause, .. } => cause.hint().into(),
            What::NotANumber { found } => {
                if suggest::decimal_comma(found) {
                    "write numbers with a decimal point, not a comma".into()
                } else {
                    "write a number with a decimal point, or leave the cell empty (or nan) for a missing sample".into()
                }
            }
            What::Infinite { .. } => "leave the cell empty (or nan) if the sample is missing".into(),
            What::MissingTime => "give every row its time, or take the row out".into(),
            What::TimeNotIncreasing { previous, found } => if found == previous {
                "take the doubled row out, or write the time with more digits"
            } else {
                "sort the rows by time; if two recordings were put together, cut them apart again"
            }
            .into(),
            What::TooLong { .. } => {
                let entry = suggest::map_entry(TIME, column, Some(0.001));
                format!(
                    "if the times are milliseconds: [recording.columns] {entry}; otherwise cut it into shorter files"
                )
            }
            What::Impossible { .. } => "give the wire a parameter in its range".into(),
            What::NoSuchChannel { .. } => "count channels in the order of the rig file, from 0".into(),
            What::OtherTimes { .. } => "give recordings of one run, with a row each at the same times".into(),
            What::Undefined { .. } => {
                "use abs, max or clamp where a root, a logarithm or a division of its formula needs it".into()
            }
            What::MissingSample { .. } => {
                "an input has to be known at every row: take the row out, or fill it in".into()
            }
            What::DutyOutOfRange { found } => scale_the_duty(*found, column),
            What::NegativePower { .. } => "heating power is not negative: check the sensor's sign and offset".into(),
            What::PositionTooLarge { .. } => {
                let entry = suggest::map_entry("position_m", column, Some(0.001));
                format!(
                    "position_m is the elongation L − L_0 in metres; if it is in millimetres: [recording.columns] {entry}"
                )
            }
            What::TemperatureOutOfRange { .. } => {
                "temperatures are in °C; map other units in [recording.columns]".into()
            }
            What::Kelvin { .. } => {
                // only a column under the contract's own name is doubted
                let entry = format!("{column} = {{ column = \"{column}\", offset = -273.15 }}");
                format!(
                    "if it is in kelvin: [recording.columns] {entry}; if it is right, say so with offset = 0.0 there"
                )
            }
            What::WrongLength { .. } => "give as many samples as the time has".into(),
            What::Session(trouble) => trouble.hint().into(),
            What::WhichChannel { channels, .. } => format!("choose one with --channel: {}", channels.join(", ")),
            What::NoRig { .. } => "give the rig file it was recorded with, or record again with this version".into(),
            What::LacksField { .. } => "it was not written by `sinew record`; record again with this version".into(),
            What::NoColumns { fields } => {
                format!("it has {}; bring it into CSV with columns such as {TIME},duty,position_m", fields.join(", "))
            }
        }
    }
}

/// The hint for a column that the contract does not know.
fn map_or_ignore(column: &str, nearest: Option<&str>) -> String {
    // Under its new name alone it would be wrong by that factor.
    if let Some((known, factor)) = suggest::in_another_unit(column) {
        let entry = suggest::map_entry(known, column, Some(factor));
        return format!("map it in the rig file: [recording.columns] {entry}; or pass --ignore-columns");
    }
    let meant = nearest.map(|n| format!("did you mean \"{n}\"? otherwise ")).unwrap_or_default();
    let foreign = suggest::map_entry("NAME", column, None);
    format!("{meant}map it in the rig file ([recording.columns] {foreign}) or pass --ignore-columns")
}

/// The hint where no column is the time.
fn name_the_time(present: &[String]) -> String {
    let guess = suggest::time_like(present).unwrap_or("NAME");
    let entry = suggest::map_entry(TIME, guess, suggest::time_scale(guess));
    format!("name the time column {TIME}, in seconds, or map it in the rig file: [recording.columns] {entry}")
}

/// The hint for an input that is not there.
fn give_the_input(input: Column, because: Needed, present: &[String]) -> String {
    let entry = suggest::map_entry(input.name(), "NAME", None);
    let mut text = format!("add the column, or map another to it in the rig file: [recording.columns] {entry}");
    let drives = [DriveKind::Pwm, DriveKind::Power, DriveKind::Current, DriveKind::Temperature];
    let drive = drives.into_iter().find(|kind| present.iter().any(|p| p == drive_column(*kind).name()));
    if let (Needed::Drive(_), Some(kind)) = (because, drive) {
        text += &format!(
            "; or, if {} is what drove the wire, set kind = \"{}\" in the channel's drive",
            drive_column(kind).name(),
            drive_word(kind)
        );
    }
    text
}

/// The hint for a duty that is none, in `column` of the file.
fn scale_the_duty(found: f64, column: &str) -> String {
    let scale = |scale, unit| {
        let entry = suggest::map_entry("duty", column, Some(scale));
        format!("if it is {unit}: [recording.columns] {entry}")
    };
    match found {
        f if f < 0.0 => "duty is the share of the period the current flows: 0 to 1".into(),
        f if f <= 100.0 => scale(0.01, "in percent"),
        f if f <= 255.0 => scale(0.00392156862745098, "an 8-bit register"),
        _ => "duty is the share of the period the current flows: 0 to 1; scale it in [recording.columns]".into(),
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message(), self.hint())
    }
}

impl std::error::Error for Error {}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            What::Unreadable { reason } => write!(f, "cannot be read: {reason}"),
            What::Unwritable { reason } => write!(f, "cannot be written: {reason}"),
            What::Empty => f.write_str("is empty"),
            What::HeaderOnly => f.write_str("has a header but no rows"),
            What::TooFewSamples { found, least } => write!(f, "has {found} samples, expected at least {least}"),
            What::TooManyRows { limit } => write!(f, "has more than {limit} rows"),
            What::LineTooLong { limit } => write!(f, "has a line longer than {limit} bytes"),
            What::NotGzip => f.write_str("is called .gz but is not compressed by gzip"),
            What::UnexpectedGzip => f.write_str("is compressed by gzip but not called .gz"),
            What::TruncatedGzip => f.write_str("stops in the middle of the compressed data"),
            What::CorruptGzip { reason } => write!(f, "has damaged compressed data: {reason}"),
            What::NotText { found } => write!(f, "is {found}, expected comma-separated text"),
            What::NoHeader { found } => {
                write!(f, "has no header: expected the columns' names, found \"{}\"", shorten(found))
            }
            What::WrongSeparator { found } => write!(f, "has columns separated by {found}, expected commas"),
            What::UnknownColumn { others, .. } => {
                f.write_str("is unknown")?;
                match others.len() {
                    0 => Ok(()),
                    n if n <= 6 => write!(f, " (so are {})", list(others)),
                    n => write!(f, " (so are {n} others)"),
                }
            }
            What::DuplicateColumn { quantity, other } => {
                write!(f, "gives {quantity} a second time, after column \"{}\"", shorten(other))
            }
            What::MissingTimeColumn { present } => write!(f, "has no column {TIME}, only {}", list(present)),
            What::MissingMapped { quantity, present } => {
                write!(f, "is mapped to {quantity} and is not in the file; there are {}", list(present))
            }
            What::MissingInput { input, because, present } => {
                write!(f, "has no column {}, which ", input.name())?;
                match because {
                    Needed::Drive(kind) => write!(f, "the rig's drive \"{}\" takes as its input", drive_word(*kind))?,
                    Needed::ImposedPosition => f.write_str("the rig's load \"imposed_position\" takes as its input")?,
                    Needed::ImposedForce => f.write_str("the rig's load \"imposed_force\" takes as its input")?,
                }
                write!(f, "; there are {}", list(present))
            }
            What::FieldCount { expected, found, .. } => {
                let cells = if *found == 1 { "cell" } else { "cells" };
                write!(f, "has {found} {cells} in this row, expected {expected} as in the header")
            }
            What::NotANumber { found } => write!(f, "\"{}\" is not a number", shorten(found)),
            What::Infinite { found } => write!(f, "{} is infinite", shorten(found)),
            What::MissingTime => f.write_str("the time is missing"),
            What::TimeNotIncreasing { previous, found } => {
                write!(f, "time has to increase, but {found:?} s comes after {previous:?} s")
            }
            What::TooLong { found_s, limit_s } => {
                write!(f, "is {found_s:?} s long at this row, expected at most {limit_s:?} s")
            }
            What::Impossible { error } => write!(f, "cannot drive this wire: {error}"),
            What::NoSuchChannel { found, channels } => {
                write!(f, "is of channel number {found}, and the rig has {channels}")
            }
            What::OtherTimes { than } => write!(f, "has rows at other times than {than}"),
            What::Undefined { law, time_s } => {
                write!(f, "the formula of {law} is no number {time_s:.3} s after the first row")
            }
            What::MissingSample { time_s } => write!(f, "has no value at {time_s:?} s, but it is an input"),
            What::DutyOutOfRange { found } => write!(f, "a duty of {found:?} is not in 0 to 1"),
            What::NegativePower { found } => write!(f, "a power of {found:?} W is negative"),
            What::PositionTooLarge { found, wire_m } => {
                write!(f, "an elongation of {found:?} m is more than the wire's own length of {wire_m:?} m")
            }
            What::TemperatureOutOfRange { found } => {
                write!(f, "a temperature of {found:?} °C is not in -273.15 to 1500")
            }
            What::Kelvin { lowest } => write!(f, "is never below {lowest:?} °C: that looks like kelvin"),
            What::WrongLength { expected, found } => write!(f, "has {found} samples, expected {expected}"),
            What::Session(trouble) => trouble.fmt(f),
            What::WhichChannel { asked: Some(asked), .. } => write!(f, "has no channel {asked:?}"),
            What::WhichChannel { channels, .. } => write!(f, "has {} channels", channels.len()),
            What::NoRig { reason: None } => {
                f.write_str("has no rig file in it, which says how its samples are to be read")
            }
            What::NoRig { reason: Some(reason) } => write!(f, "has a rig file in it that cannot be used: {reason}"),
            What::LacksField { field } => write!(f, "has no field \"{field}\""),
            What::NoColumns { .. } => f.write_str("has no column that a recording can have"),
        }
    }
}

/// A word of a file, fit for a message: printable, and not too long.
fn shorten(word: &str) -> String {
    let mut short: String = word.chars().take(40).flat_map(char::escape_debug).collect();
    if word.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}

/// Names in a row, the first few of them.
fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "no column".into();
    }
    let mut text = names.iter().take(12).map(|n| shorten(n)).collect::<Vec<_>>().join(", ");
    if names.len() > 12 {
        text += ", …";
    }
    text
}
