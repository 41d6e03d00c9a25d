//! MATLAB's files of version 5 (what `save` writes by default, `-v6` and `-v7`) and 4: numeric arrays, also within structs.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::arrays::{Array, Contents, table};
use crate::bytes::{Bytes, Kind};
use crate::error::Error;
use crate::table::Table;

/// Most bytes a compressed variable is unpacked to.
const MOST_UNPACKED: u64 = 1 << 30;
/// How deep structs may stand within structs.
const DEEPEST: usize = 8;

/// Whether a file begins as one of version 5 does.
pub(crate) fn is_version_5(bytes: &[u8]) -> bool {
    bytes.len() >= 128 && matches!(&bytes[126..128], b"IM" | b"MI") && bytes.starts_with(b"MATLAB")
}

/// Whether a file begins as one of version 4 does: type, rows, columns, imaginary, length of the name.
pub(crate) fn is_version_4(bytes: &[u8]) -> bool {
    let word = |i: usize, big: bool| Bytes { rest: bytes.get(i * 4..).unwrap_or_default(), big }.u32();
    [false, true].into_iter().any(|big| {
        let (Some(kind), Some(rows), Some(columns), Some(imaginary), Some(length)) =
            (word(0, big), word(1, big), word(2, big), word(3, big), word(4, big))
        else {
            return false;
        };
        let right = kind / 1000 == u32::from(big) && kind % 1000 / 100 == 0 && kind % 100 / 10 <= 5 && kind % 10 <= 2;
        let name = bytes.get(20..20usize.saturating_add(length as usize)).unwrap_or_default();
        right
            && rows > 0
            && columns > 0
            && imaginary <= 1
            && (2..=64).contains(&length)
            && name.len() == length as usize
            && name.ends_with(&[0])
            && name[..name.len() - 1].iter().all(|b| b.is_ascii_alphanumeric() || *b == b'_')
    })
}

/// Reads a file of version 5.
pub(crate) fn version_5(bytes: &[u8]) -> Result<Table, Error> {
    let big = bytes.get(126..128) == Some(b"MI");
    let mut contents = Contents::default();
    let mut rest = Bytes { rest: bytes.get(128..).unwrap_or_default(), big };
    while !rest.rest.is_empty() {
        let Some((kind, data)) = element(&mut rest) else {
            contents.notes.push("the file stops in the middle of a variable".into());
            break;
        };
        match kind {
            15 => {
                let mut unpacked = Vec::new();
                let read = ZlibDecoder::new(data.rest).take(MOST_UNPACKED).read_to_end(&mut unpacked);
                let mut inner = Bytes { rest: &unpacked, big };
                match (read, element(&mut inner)) {
                    (Ok(_), Some((14, data))) => matrix(data, "", &mut contents, 0),
                    _ => contents.notes.push("a compressed variable is damaged: passed over".into()),
                }
            }
            14 => matrix(data, "", &mut contents, 0),
            _ => {}
        }
    }
    table(contents, "MATLAB 5")
}

/// A data element: its type, and its bytes.
fn element<'b>(from: &mut Bytes<'b>) -> Option<(u32, Bytes<'b>)> {
    let tag = from.u32()?;
    // a small one has its length in the same word
    if tag >> 16 != 0 {
        let data = from.take(4)?.get(..(tag >> 16) as usize)?;
        return Some((tag & 0xffff, Bytes { rest: data, big: from.big }));
    }
    let length = from.u32()? as usize;
    let data = from.take(length)?;
    // elements stand on multiples of eight, compressed ones do not
    if tag != 15 {
        let padding = (8 - length % 8) % 8;
        from.take(padding.min(from.rest.len()))?;
    }
    Some((tag, Bytes { rest: data, big: from.big }))
}

fn stored(kind: u32) -> Option<Kind> {
    Some(match kind {
        1 => Kind::I8,
        2 => Kind::U8,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::I32,
        6 => Kind::U32,
        7 => Kind::F32,
        9 => Kind::F64,
        12 => Kind::I64,
        13 => Kind::U64,
        _ => return None,
    })
}

fn numbers(kind: u32, mut data: Bytes<'_>) -> Option<Vec<f64>> {
    let kind = stored(kind)?;
    let count = data.rest.len() / kind.size();
    (0..count).map(|_| data.number(kind)).collect()
}

fn matrix(mut data: Bytes<'_>, path: &str, contents: &mut Contents, depth: usize) {
    if matrix_or_nothing(&mut data, path, contents, depth).is_none() {
        let name = if path.is_empty() { "a variable" } else { path };
        contents.notes.push(format!("{name} is damaged: passed over"));
    }
}

fn matrix_or_nothing(data: &mut Bytes<'_>, path: &str, contents: &mut Contents, depth: usize) -> Option<()> {
    if data.rest.is_empty() {
        return Some(()); // an empty field
    }
    let (_, mut flags) = element(data)?;
    let flags = flags.u32()?;
    let (class, complex) = (flags & 0xff, flags & 0x800 != 0);
    if class == 17 {
        // an object (a table, a timeseries, a datetime): its name, then what is documented nowhere
        let (_, name) = element(data)?;
        let name = String::from_utf8_lossy(name.rest).trim_end_matches('\0').to_string();
        contents.objects.push(if name.is_empty() { path.to_string() } else { name });
        return Some(());
    }
    let (kind, dims) = element(data)?;
    let dims: Vec<usize> = numbers(kind, dims)?.iter().map(|n| *n as usize).collect();
    let (_, own) = element(data)?;
    let own = String::from_utf8_lossy(own.rest).trim_end_matches('\0').to_string();
    let name = match (path.is_empty(), own.is_empty()) {
        (true, _) => own,
        (false, true) => path.to_string(),
        (false, false) => format!("{path}.{own}"),
    };
    match class {
        6..=15 => {
            let (kind, real) = element(data)?;
            let values = numbers(kind, real)?;
            let (rows, columns) =
                (dims.first().copied()?, dims.get(1..)?.iter().try_fold(1usize, |a, b| a.checked_mul(*b))?);
            if complex {
                contents.notes.push(format!("{name} is complex: passed over"));
            } else if rows.checked_mul(columns)? == values.len() {
                contents.arrays.push(Array { name, rows, columns, values });
            } else {
                return None;
            }
        }
        2 | 3 if depth < DEEPEST => {
            if class == 3 {
                element(data)?; // the class's name
            }
            let (_, mut length) = element(data)?;
            let length = length.u32()? as usize;
            let (_, names) = element(data)?;
            if length == 0 || dims.iter().product::<usize>() > 1 {
                contents.notes.push(format!("{name} is an array of structs: passed over"));
                return Some(());
            }
            for field in names.rest.chunks_exact(length) {
                let field: Vec<u8> = field.iter().copied().take_while(|b| *b != 0).collect();
                let (14, inner) = element(data)? else { return None };
                let path = format!("{name}.{}", String::from_utf8_lossy(&field));
                matrix(inner, &path, contents, depth + 1);
            }
        }
        // texts say units and names to people, not to us
        4 => {}
        1 => contents.notes.push(format!("{name} is a cell array: passed over")),
        5 => contents.notes.push(format!("{name} is sparse: passed over")),
        _ => contents.objects.push(name),
    }
    Some(())
}

/// Reads a file of version 4.
pub(crate) fn version_4(bytes: &[u8]) -> Result<Table, Error> {
    let big = bytes.first() == Some(&0);
    let mut contents = Contents::default();
    let mut rest = Bytes { rest: bytes, big: big && bytes.get(3).is_some_and(|b| *b != 0) };
    while !rest.rest.is_empty() {
        if variable_4(&mut rest, &mut contents).is_none() {
            contents.notes.push("the file stops in the middle of a variable".into());
            break;
        }
    }
    table(contents, "MATLAB 4")
}

fn variable_4(rest: &mut Bytes<'_>, contents: &mut Contents) -> Option<()> {
    let (kind, rows, columns) = (rest.u32()?, rest.u32()? as usize, rest.u32()? as usize);
    let (imaginary, length) = (rest.u32()?, rest.u32()? as usize);
    let name = String::from_utf8_lossy(rest.take(length)?).trim_end_matches('\0').to_string();
    let stored = match kind % 100 / 10 {
        0 => Kind::F64,
        1 => Kind::F32,
        2 => Kind::I32,
        3 => Kind::I16,
        4 => Kind::U16,
        5 => Kind::U8,
        _ => return None,
    };
    let count = rows.checked_mul(columns)?;
    let mut data = Bytes { rest: rest.take(count.checked_mul(stored.size())?)?, big: rest.big };
    if imaginary == 1 {
        rest.take(count.checked_mul(stored.size())?)?;
        contents.notes.push(format!("{name} is complex: passed over"));
    } else if kind % 10 == 0 {
        let values = (0..count).map(|_| data.number(stored)).collect::<Option<Vec<f64>>>()?;
        contents.arrays.push(Array { name, rows, columns, values });
    }
    Some(())
}
