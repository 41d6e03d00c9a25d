//! Text and bytes for the reader of Linux's converters: what `in_*_type` files say, and scans out of a buffer.

use sinew_linux_backend::scan::{Format, Layout};

use crate::script::Script;

/// Elements of a scan at most.
const MOST_ELEMENTS: usize = 8;

/// Formats of a device's elements, a line each behind the element's index, then the bytes of a scan.
///
/// Whatever it is: a format is refused or means what it says, and is the same written and read again; elements lie beside one another, each
/// aligned, and within the scan; a value is what its bits say one by one, and no value comes of too few bytes.
///
/// # Panics
/// Where the reader breaks a promise.
pub fn scan(bytes: &[u8]) {
    let mut script = Script::new(bytes);
    let mut elements = Vec::new();
    for _ in 0..usize::from(script.byte()) % (MOST_ELEMENTS + 1) {
        let index = u32::from(script.byte());
        let line = script.until(b'\n');
        let Ok(text) = std::str::from_utf8(line) else { continue };
        let Some(format) = Format::parse(text) else { continue };
        assert_eq!(Format::parse(&written(&format)), Some(format), "{text:?} came back otherwise");
        assert!(format.bits >= 1 && format.bits + format.shift <= format.storage_bits, "{text:?}: {format:?}");
        elements.push((index, format));
    }
    let layout = Layout::of(&elements);
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (offset, (_, format)) in layout.offsets.iter().zip(&elements) {
        let end = offset + format.bytes();
        assert!(end <= layout.bytes && offset % (format.storage_bits / 8) as usize == 0, "{elements:?}: {layout:?}");
        assert!(taken.iter().all(|(from, to)| end <= *from || *to <= *offset), "{elements:?} overlap: {layout:?}");
        taken.push((*offset, end));
    }
    let mut scan = script.bytes(usize::MAX).to_vec();
    let short = scan.len() < layout.bytes;
    for ((_, format), offset) in elements.iter().zip(&layout.offsets) {
        let room = scan.get(*offset..).unwrap_or_default();
        assert_eq!(format.value(room).is_some(), room.len() >= (format.storage_bits / 8) as usize);
    }
    if short {
        scan.resize(layout.bytes, 0xa5);
    }
    for ((_, format), offset) in elements.iter().zip(&layout.offsets) {
        let found = format.value(&scan[*offset..]);
        assert_eq!(found, Some(bit_by_bit(format, &scan[*offset..])), "{format:?} of {:x?}", &scan[*offset..]);
    }
}

/// A format as the kernel writes it.
fn written(format: &Format) -> String {
    let Format { big_endian, signed, bits, storage_bits, repeat, shift } = format;
    let (endian, sign) = (if *big_endian { "be" } else { "le" }, if *signed { 's' } else { 'u' });
    let repeat = if *repeat > 1 { format!("X{repeat}") } else { String::new() };
    format!("{endian}:{sign}{bits}/{storage_bits}{repeat}>>{shift}\n")
}

/// The value by the definition: the bits in the order of their weight, the highest negative where it is signed.
fn bit_by_bit(format: &Format, bytes: &[u8]) -> i64 {
    let stored = (format.storage_bits / 8) as usize;
    let bit = |weight: u32| {
        let place = (weight + format.shift) as usize;
        let byte = if format.big_endian { stored - 1 - place / 8 } else { place / 8 };
        bytes[byte] >> (place % 8) & 1 == 1
    };
    let magnitude = (0..format.bits).filter(|weight| bit(*weight)).map(|weight| 1i128 << weight).sum::<i128>();
    let negative = format.signed && bit(format.bits - 1);
    (magnitude - if negative { 1i128 << format.bits } else { 0 }) as i64
}
