//! The layout of an IIO buffer: the format in `scan_elements/in_*_type`, and the offset of an element in a scan.
//!
//! Source: the kernel's `Documentation/ABI/testing/sysfs-bus-iio` (`scan_elements`) and `iio_compute_scan_bytes` of
//! `drivers/iio/industrialio-buffer.c`: elements stand in the order of their index, each aligned to its own size, and the
//! whole is padded to its largest element (since kernel 5.4; before, only buffers with a timestamp were).

/// How one element is stored: `[be|le]:[s|u]bits/storagebits[Xrepeat]>>shift`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Most significant byte first.
    pub big_endian: bool,
    /// Two's complement.
    pub signed: bool,
    /// Bits that carry the value, 1 to 64.
    pub bits: u32,
    /// Bits it takes: 8, 16, 32 or 64.
    pub storage_bits: u32,
    /// How many values stand side by side; 1 for a voltage or a current.
    pub repeat: u32,
    /// By how much it is shifted up.
    pub shift: u32,
}

impl Format {
    /// Reads a `_type` file; `None` where it is not of that form, or says something no buffer can hold.
    pub fn parse(text: &str) -> Option<Format> {
        let (endian, rest) = text.trim().split_once(':')?;
        let big_endian = match endian {
            "be" => true,
            "le" => false,
            _ => return None,
        };
        let signed = match rest.chars().next()? {
            's' => true,
            'u' => false,
            _ => return None,
        };
        let (bits, rest) = rest[1..].split_once('/')?;
        let (storage, shift) = rest.split_once(">>")?;
        let (storage, repeat) = storage.split_once('X').unwrap_or((storage, "1"));
        let number = |text: &str| text.parse::<u32>().ok();
        let format = Format {
            big_endian,
            signed,
            bits: number(bits)?,
            storage_bits: number(storage)?,
            repeat: number(repeat)?.max(1),
            shift: number(shift)?,
        };
        let fits = format.bits.checked_add(format.shift).is_some_and(|bits| bits <= format.storage_bits);
        let whole = matches!(format.storage_bits, 8 | 16 | 32 | 64) && format.bits > 0 && format.repeat <= 16;
        (fits && whole).then_some(format)
    }

    /// Bytes it takes in a scan.
    pub fn bytes(&self) -> usize {
        (self.storage_bits / 8 * self.repeat) as usize
    }

    /// The value stored at the start of `bytes` (the first where several stand side by side); `None` where they are too few.
    pub fn value(&self, bytes: &[u8]) -> Option<i64> {
        let stored = bytes.get(..(self.storage_bits / 8) as usize)?;
        let join = |word: u64, byte: &u8| word << 8 | u64::from(*byte);
        let word = if self.big_endian { stored.iter().fold(0, join) } else { stored.iter().rev().fold(0, join) };
        let unused = 64 - self.bits;
        let up = word >> self.shift << unused;
        Some(if self.signed { up.cast_signed() >> unused } else { (up >> unused).cast_signed() })
    }
}

/// Where the enabled elements of a buffer lie.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Layout {
    /// Offset of each element, in the order they were given, in bytes.
    pub offsets: Vec<usize>,
    /// Bytes from one scan to the next.
    pub bytes: usize,
}

impl Layout {
    /// The layout of elements given as (index, format); the timestamp is one of them where it is enabled.
    pub fn of(elements: &[(u32, Format)]) -> Layout {
        let mut order: Vec<usize> = (0..elements.len()).collect();
        order.sort_by_key(|&element| elements[element].0);
        let mut offsets = vec![0; elements.len()];
        let (mut end, mut largest) = (0usize, 1);
        for element in order {
            let bytes = elements[element].1.bytes();
            // Since repeated elements need not be a power of two wide, the kernel rounds their alignment up to one.
            let alignment = bytes.next_power_of_two();
            offsets[element] = end.next_multiple_of(alignment);
            end = offsets[element] + bytes;
            largest = largest.max(alignment);
        }
        Layout { offsets, bytes: end.next_multiple_of(largest) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn format(text: &str) -> Format {
        Format::parse(text).expect("a format of the kernel")
    }

    #[test]
    fn formats_of_real_drivers_are_read() {
        // ina2xx-adc (power, current), max1363, ad7124, the timestamp, a quaternion of bno055, a rotation vector
        let ina = format("le:s16/16>>0\n");
        assert_eq!((ina.signed, ina.bits, ina.storage_bits, ina.shift), (true, 16, 16, 0));
        let max = format("be:u12/16>>0");
        assert_eq!(max.value(&[0x0a, 0xbc]), Some(0xabc));
        let shifted = format("be:s12/16>>4");
        assert_eq!(shifted.value(&[0xff, 0xf0]), Some(-1));
        assert_eq!(shifted.value(&[0x7f, 0xff]), Some(2047));
        let wide = format("be:u24/32>>8");
        assert_eq!(wide.value(&[0x80, 0, 0x01, 0xee]), Some(0x0080_0001));
        let time = format("le:s64/64>>0");
        assert_eq!(time.value(&[0xff; 8]), Some(-1));
        assert_eq!(format("le:s16/16X4>>0").bytes(), 8);
    }

    #[test]
    fn what_is_no_format_is_refused() {
        for text in [
            "",
            "le",
            "le:",
            "le:x12/16>>0",
            "me:s12/16>>0",
            "le:s12/12>>0",
            "le:s0/16>>0",
            "le:s12/16>>8",
            "le:s12/16",
            "le:s4294967295/16>>1",
        ] {
            assert_eq!(Format::parse(text), None, "{text}");
        }
    }

    #[test]
    fn elements_are_aligned_to_their_own_size_and_the_whole_to_the_largest() {
        let (narrow, wide, time) = (format("le:u12/16>>0"), format("le:s24/32>>8"), format("le:s64/64>>0"));
        // given out of order: 16 bits at 0, 32 at 4, 64 at 8
        let all = Layout::of(&[(7, time), (2, wide), (0, narrow)]);
        assert_eq!((all.offsets.as_slice(), all.bytes), ([8, 4, 0].as_slice(), 16));
        // three narrow ones and a timestamp: 6 bytes, padding, 8
        let three = Layout::of(&[(0, narrow), (1, narrow), (2, narrow), (3, time)]);
        assert_eq!((three.offsets.as_slice(), three.bytes), ([0, 2, 4, 8].as_slice(), 16));
        // without it the scan is as wide as the three
        assert_eq!(Layout::of(&[(0, narrow), (1, narrow), (2, narrow)]).bytes, 6);
        assert_eq!(Layout::of(&[(0, wide), (1, narrow)]).bytes, 8);
        assert_eq!(Layout::of(&[]).bytes, 0);
    }

    proptest! {
        #[test]
        fn a_stored_value_is_read_back(
            big_endian: bool, signed: bool, some_bits: u32, room in 0usize..4, some_shift: u32, raw: i64,
        ) {
            let storage_bits = [8, 16, 32, 64][room];
            // an unsigned 64-bit value would not fit into the result
            let bits = 1 + some_bits % if signed { storage_bits } else { storage_bits.min(63) };
            let shift = some_shift % (storage_bits - bits + 1);
            let text = format!(
                "{}:{}{bits}/{storage_bits}>>{shift}",
                if big_endian { "be" } else { "le" },
                if signed { 's' } else { 'u' }
            );
            let format = format(&text);
            let unused = 64 - bits;
            let expected = if signed { raw << unused >> unused } else { ((raw as u64) << unused >> unused).cast_signed() };
            let word = ((expected as u64) << unused >> unused) << shift;
            let bytes = match big_endian {
                true => word.to_be_bytes()[8 - format.bytes()..].to_vec(),
                false => word.to_le_bytes()[..format.bytes()].to_vec(),
            };
            prop_assert_eq!(format.value(&bytes), Some(expected));
        }

        #[test]
        fn any_text_is_read_or_refused(text in ".{0,24}") {
            if let Some(format) = Format::parse(&text) {
                prop_assert!(format.value(&[0xa5; 8]).is_some());
                prop_assert!(format.value(&[]).is_none());
            }
        }
    }
}
