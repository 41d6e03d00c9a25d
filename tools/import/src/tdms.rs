//! LabVIEW's TDMS: segments of metadata and raw data, after NI's published description of the format.

use sinew_rig::FileFormat;

use crate::bytes::{Bytes, Kind};
use crate::error::Error;
use crate::table::{Column, Table, name_all};

const META: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;
/// Seconds from NI's epoch (1904) to 1970.
const EPOCH_S: f64 = 2_082_844_800.0;
/// Most channels, and most values, of a file.
const MOST: usize = 100_000;

/// What is stored for a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stored {
    Number(Kind),
    Moment,
    /// Texts and whatever else no column is made of, with its bytes a value.
    Other(Option<usize>),
}

impl Stored {
    fn of(code: u32) -> Stored {
        Stored::Number(match code {
            1 => Kind::I8,
            2 => Kind::I16,
            3 => Kind::I32,
            4 => Kind::I64,
            5 => Kind::U8,
            6 => Kind::U16,
            7 => Kind::U32,
            8 => Kind::U64,
            9 | 0x19 => Kind::F32,
            10 | 0x1a => Kind::F64,
            0x21 => Kind::U8,
            0x44 => return Stored::Moment,
            0x0008_000c => return Stored::Other(Some(8)),
            0x0010_000d => return Stored::Other(Some(16)),
            _ => return Stored::Other(None),
        })
    }

    fn size(self) -> Option<usize> {
        match self {
            Stored::Number(kind) => Some(kind.size()),
            Stored::Moment => Some(16),
            Stored::Other(size) => size,
        }
    }
}

/// Raw data of a channel in a segment.
#[derive(Debug, Clone, Copy)]
struct Index {
    stored: Stored,
    count: usize,
    /// Of texts: bytes altogether.
    bytes: Option<usize>,
}

impl Index {
    fn size(&self) -> Option<usize> {
        self.bytes.or_else(|| self.stored.size()?.checked_mul(self.count))
    }
}

#[derive(Debug, Default)]
struct Channel {
    path: String,
    index: Option<Index>,
    values: Vec<f64>,
    unit: Option<String>,
    increment_s: Option<f64>,
    offset_s: f64,
    is_moment: bool,
    is_other: bool,
}

/// Reads a file.
pub(crate) fn tdms(bytes: &[u8], given: &FileFormat) -> Result<Table, Error> {
    let mut channels: Vec<Channel> = Vec::new();
    let mut active: Vec<usize> = Vec::new();
    let mut notes = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        match segment(rest, &mut channels, &mut active) {
            Ok(Some(length)) => rest = &rest[length.min(rest.len())..],
            Ok(None) => {
                notes.push("the file stops in the middle of a segment: what comes before it is read".to_string());
                break;
            }
            Err(error) => return Err(error),
        }
    }
    table(channels, notes, given)
}

/// Reads a segment; its length, or nothing where the file ends before it does.
fn segment(all: &[u8], channels: &mut Vec<Channel>, active: &mut Vec<usize>) -> Result<Option<usize>, Error> {
    let mut head = Bytes { rest: all, big: false };
    if head.take(4) != Some(b"TDSm") {
        return Ok(None);
    }
    let Some(toc) = head.u32() else { return Ok(None) };
    head.big = toc & BIG != 0;
    if toc & DAQMX != 0 {
        return Err(Error::new(
            "has DAQmx raw data, whose scaling is the device's",
            "in LabVIEW write it with `TDMS Write`, or export it as CSV: npTDMS's `tdmsinfo` and TdmsFile.as_dataframe().to_csv(OUT) do that in Python",
        ));
    }
    let (Some(_), Some(next), Some(raw)) = (head.u32(), head.u64(), head.u64()) else { return Ok(None) };
    let body = head.rest;
    // a segment that was not ended has no length: it takes what there is
    let length = usize::try_from(next).unwrap_or(usize::MAX).min(body.len());
    let raw_at = usize::try_from(raw).unwrap_or(usize::MAX);
    if raw_at > length {
        return Ok(None);
    }
    if toc & META != 0 {
        let mut meta = Bytes { rest: &body[..raw_at], big: head.big };
        if metadata(&mut meta, toc & NEW_LIST != 0, channels, active).is_none() {
            return Ok(None);
        }
    }
    if toc & RAW != 0 {
        let data = Bytes { rest: &body[raw_at..length], big: head.big };
        raw_data(data, toc & INTERLEAVED != 0, channels, active);
    }
    Ok(Some(28 + length))
}

fn text<'b>(from: &mut Bytes<'b>) -> Option<std::borrow::Cow<'b, str>> {
    let length = from.u32()? as usize;
    Some(String::from_utf8_lossy(from.take(length)?))
}

fn metadata(meta: &mut Bytes<'_>, new_list: bool, channels: &mut Vec<Channel>, active: &mut Vec<usize>) -> Option<()> {
    if new_list {
        active.clear();
    }
    for _ in 0..meta.u32()? {
        let path = text(meta)?.into_owned();
        let at = match channels.iter().position(|channel| channel.path == path) {
            Some(at) => at,
            None if channels.len() < MOST => {
                channels.push(Channel { path, ..Channel::default() });
                channels.len() - 1
            }
            None => return None,
        };
        match meta.u32()? {
            u32::MAX => {}
            // as in the segment before
            0 => active.extend((!active.contains(&at)).then_some(at)),
            _ => {
                let stored = Stored::of(meta.u32()?);
                let _dimension = meta.u32()?;
                let count = usize::try_from(meta.u64()?).ok()?;
                let bytes = match stored {
                    Stored::Other(None) => Some(usize::try_from(meta.u64()?).ok()?),
                    _ => None,
                };
                channels[at].index = Some(Index { stored, count, bytes });
                active.extend((!active.contains(&at)).then_some(at));
            }
        }
        for _ in 0..meta.u32()? {
            let name = text(meta)?.into_owned();
            property(&name, meta, &mut channels[at])?;
        }
    }
    Some(())
}

fn property(name: &str, meta: &mut Bytes<'_>, channel: &mut Channel) -> Option<()> {
    let code = meta.u32()?;
    if code == 0x20 {
        let value = text(meta)?.trim().to_string();
        if matches!(name, "unit_string" | "NI_UnitDescription" | "unit" | "Unit") && !value.is_empty() {
            channel.unit = Some(value);
        }
        return Some(());
    }
    match Stored::of(code) {
        Stored::Number(kind) => {
            let value = meta.number(kind)?;
            match name {
                "wf_increment" if value > 0.0 => channel.increment_s = Some(value),
                "wf_start_offset" if value.is_finite() => channel.offset_s = value,
                _ => {}
            }
        }
        stored => {
            meta.take(stored.size()?)?;
        }
    }
    Some(())
}

fn raw_data(mut data: Bytes<'_>, interleaved: bool, channels: &mut [Channel], active: &[usize]) {
    let listed: Vec<(usize, Index)> = active.iter().filter_map(|at| Some((*at, channels[*at].index?))).collect();
    let chunk: Option<usize> = listed.iter().try_fold(0usize, |sum, (_, index)| sum.checked_add(index.size()?));
    if chunk.is_none_or(|chunk| chunk == 0) {
        return;
    }
    // the same layout again and again until the segment ends
    loop {
        let before = data.rest.len();
        if interleaved {
            let rows = listed.iter().map(|(_, index)| index.count).max().unwrap_or(0);
            for _ in 0..rows {
                for (at, index) in &listed {
                    if !value(&mut data, index.stored, &mut channels[*at]) {
                        return;
                    }
                }
            }
        } else {
            for (at, index) in &listed {
                if let (Stored::Other(_), Some(size)) = (index.stored, index.size()) {
                    channels[*at].is_other = true;
                    if data.take(size).is_none() {
                        return;
                    }
                    continue;
                }
                for _ in 0..index.count {
                    if !value(&mut data, index.stored, &mut channels[*at]) {
                        return;
                    }
                }
            }
        }
        if data.rest.is_empty() || data.rest.len() == before {
            return;
        }
    }
}

/// Takes a value in; `false` where there is none left.
fn value(data: &mut Bytes<'_>, stored: Stored, channel: &mut Channel) -> bool {
    let value = match stored {
        Stored::Number(kind) => data.number(kind),
        Stored::Moment => {
            channel.is_moment = true;
            // little-endian: fractions first
            let parts =
                if data.big { data.u64().zip(data.u64()) } else { data.u64().zip(data.u64()).map(|(f, s)| (s, f)) };
            parts.map(|(seconds, fraction)| seconds as i64 as f64 - EPOCH_S + fraction as f64 / 2f64.powi(64))
        }
        Stored::Other(size) => {
            channel.is_other = true;
            size.and_then(|size| data.take(size)).map(|_| f64::NAN)
        }
    };
    value.is_some_and(|value| {
        channel.values.push(if value.is_finite() { value } else { f64::NAN });
        true
    })
}

/// `/'Group'/'Channel'` as its two names.
fn names(path: &str) -> Option<(String, String)> {
    let inside = path.strip_prefix("/'")?.strip_suffix('\'')?;
    let (group, channel) = inside.split_once("'/'")?;
    Some((group.replace("''", "'"), channel.replace("''", "'")))
}

fn table(channels: Vec<Channel>, mut notes: Vec<String>, given: &FileFormat) -> Result<Table, Error> {
    let mut named: Vec<(String, String, Channel)> = Vec::new();
    for channel in channels {
        let Some((group, name)) = names(&channel.path) else { continue };
        if channel.is_other {
            notes.push(format!("channel \"{name}\" is no numbers: passed over"));
        } else if !channel.values.is_empty() {
            named.push((group, name, channel));
        }
    }
    let mut groups: Vec<(usize, usize, &str)> = Vec::new();
    for (group, _, channel) in &named {
        let length = channel.values.len();
        match groups.iter_mut().find(|(_, l, g)| *l == length && g == group) {
            Some((count, ..)) => *count += 1,
            None => groups.push((1, length, group)),
        }
    }
    if let Some(wanted) = &given.sheet {
        groups.retain(|(.., group)| group == wanted);
        if groups.is_empty() {
            let mut there: Vec<&str> = named.iter().map(|(group, ..)| group.as_str()).collect();
            there.dedup();
            return Err(Error::new(
                format!("has no group \"{wanted}\""),
                format!("its groups are {}", there.join(", ")),
            ));
        }
    }
    let best = groups.iter().max_by_key(|(count, length, _)| (*count.min(&64), *length));
    let Some((_, length, group)) = best.map(|(c, l, g)| (*c, *l, g.to_string())) else {
        return Err(Error::new("has no channel with numbers in it", "check that the recording was written to its end"));
    };
    let mut columns = Vec::new();
    let mut increment: Option<(f64, f64)> = None;
    for (of, name, channel) in named {
        if of != group || channel.values.len() != length {
            notes
                .push(format!("channel \"{name}\" of group \"{of}\" has {} values: passed over", channel.values.len()));
            continue;
        }
        increment = increment.or(channel.increment_s.map(|step| (step, channel.offset_s)));
        let first = channel.values.iter().copied().find(|v| !v.is_nan()).unwrap_or(0.0);
        let values = match channel.is_moment {
            true => channel.values.iter().map(|v| ((v - first) * 1e6).round() / 1e6).collect(),
            false => channel.values,
        };
        columns.push(Column { name, unit: channel.unit, values, clock: channel.is_moment });
    }
    let rate_hz = increment.map(|(step, _)| (1.0 / step, format!("wf_increment = {step} s")));
    name_all(&mut columns);
    let format = FileFormat { sheet: Some(group.clone()), ..FileFormat::default() };
    Ok(Table { kind: format!("TDMS, group \"{group}\""), columns, format, rate_hz, notes, lines: Vec::new() })
}
