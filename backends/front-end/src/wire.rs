//! Frames on a line: consistent overhead byte stuffing (COBS) with a CRC-32 inside.
//!
//! A zero byte begins and ends every frame and occurs nowhere else. So a reader that starts late, or has lost synchronisation
//! by damage, resynchronises at the next zero, whatever the frames contain; with a magic number and a length it would have to trust
//! bytes before their checksum is known. Two adjacent frames may share their zero. The checksum is CRC-32/ISO-HDLC (the one of
//! Ethernet and zip, which many microcontrollers compute in hardware) over all bytes before it: sixteen bits would let one
//! damaged frame in 65536 through, on a noisy line at 1 kHz one a minute.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

use crate::error::Error;

/// The checksum of a frame.
static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Bytes of a checksum.
pub(crate) const CRC_BYTES: usize = 4;
/// Longest frame before stuffing, checksum included: an identification of 64 channels.
pub const MAX_BODY: usize = 1600;
/// Longest one that goes down to a front-end: a configuration of 64 channels.
pub const MAX_BODY_TO_DEVICE: usize = 800;
/// Longest frame on the line: a byte for every 254, its own first, and a zero at either end.
pub const MAX_FRAME: usize = MAX_BODY + MAX_BODY.div_ceil(254) + 3;

/// The checksum of some bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Stuffs a body, its checksum behind it, into `line`, zeros at both ends; gives how many bytes that is.
///
/// # Errors
/// [`Error::NoRoom`] where `line` is too short.
pub(crate) fn put(body: &[u8], line: &mut [u8]) -> Result<usize, Error> {
    let sum = checksum(body).to_le_bytes();
    let mut stuffer = Stuffer { line, at: 2, count_at: 1 };
    *stuffer.line.get_mut(0).ok_or(Error::NoRoom)? = 0;
    for byte in body.iter().chain(&sum) {
        stuffer.put(*byte)?;
    }
    stuffer.finish()
}

struct Stuffer<'a> {
    line: &'a mut [u8],
    at: usize,
    /// Where the count of the present run goes.
    count_at: usize,
}

impl Stuffer<'_> {
    fn put(&mut self, byte: u8) -> Result<(), Error> {
        if byte != 0 {
            *self.line.get_mut(self.at).ok_or(Error::NoRoom)? = byte;
            self.at += 1;
        }
        // A run ends with a zero, or full.
        if byte == 0 || self.at - self.count_at == 0xff { self.close() } else { Ok(()) }
    }

    fn close(&mut self) -> Result<(), Error> {
        let count = (self.at - self.count_at) as u8;
        *self.line.get_mut(self.count_at).ok_or(Error::NoRoom)? = count;
        self.count_at = self.at;
        self.at += 1;
        Ok(())
    }

    fn finish(mut self) -> Result<usize, Error> {
        self.close()?;
        let end = self.count_at;
        *self.line.get_mut(end).ok_or(Error::NoRoom)? = 0;
        Ok(end + 1)
    }
}

/// Takes frames off a line, byte by byte, into a buffer of its own of `N` bytes: the longest body that can come.
#[derive(Debug, Clone)]
pub struct Decoder<const N: usize> {
    body: [u8; N],
    length: usize,
    /// Bytes until the run ends; 0 = a count comes next.
    left: u8,
    /// Whether the run that ends stands for a zero.
    zero: bool,
    /// Whether more came than fits: nothing counts until the next end.
    spilt: bool,
    /// Whether anything came since the last end.
    begun: bool,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Decoder<N> {
        Decoder::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// At the beginning of a frame.
    pub const fn new() -> Decoder<N> {
        Decoder { body: [0; N], length: 0, left: 0, zero: false, spilt: false, begun: false }
    }

    /// The next byte from the line: `None` while a frame is not over, then its body without the checksum, or what was wrong
    /// with it. Empty frames (zeros in a row) are passed over.
    #[inline]
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], Error>> {
        if byte == 0 {
            return self.end();
        }
        self.begun = true;
        if self.left > 0 {
            self.left -= 1;
            self.keep(byte);
        } else {
            if self.zero {
                self.keep(0);
            }
            self.left = byte - 1;
            self.zero = byte != 0xff;
        }
        None
    }

    fn keep(&mut self, byte: u8) {
        match self.body.get_mut(self.length) {
            Some(place) => {
                *place = byte;
                self.length += 1;
            }
            None => self.spilt = true,
        }
    }

    fn end(&mut self) -> Option<Result<&[u8], Error>> {
        let (length, left, spilt, begun) = (self.length, self.left, self.spilt, self.begun);
        (self.length, self.left, self.zero, self.spilt, self.begun) = (0, 0, false, false, false);
        if !begun {
            return None;
        }
        if spilt {
            return Some(Err(Error::TooLong));
        }
        if left > 0 {
            return Some(Err(Error::Broken));
        }
        let Some((body, sum)) = self.body.get(..length).and_then(|whole| whole.split_last_chunk::<CRC_BYTES>()) else {
            return Some(Err(Error::Broken));
        };
        Some(if checksum(body) == u32::from_le_bytes(*sum) { Ok(body) } else { Err(Error::Checksum) })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    fn line(body: &[u8]) -> Vec<u8> {
        let mut line = std::vec![0xaa; body.len() + body.len() / 254 + 16];
        let length = put(body, &mut line).unwrap();
        line.truncate(length);
        line
    }

    fn bodies(line: &[u8]) -> Vec<Result<Vec<u8>, Error>> {
        let mut decoder = Decoder::<MAX_BODY>::new();
        line.iter().filter_map(|byte| decoder.push(*byte).map(|body| body.map(<[u8]>::to_vec))).collect()
    }

    #[test]
    fn the_checksum_is_the_one_of_zip() {
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn runs_are_closed_where_they_are_full() {
        for length in [0, 1, 249, 250, 251, 253, 254, 255, 508, 1500] {
            for byte in [0u8, 7] {
                let body = std::vec![byte; length];
                assert_eq!(bodies(&line(&body)), [Ok(body)], "{length} times {byte}");
            }
        }
    }

    #[test]
    fn too_long_is_said_once_and_the_next_is_good() {
        let mut all = std::vec![1u8; 5000];
        all.extend(line(&[1, 2, 3]));
        assert_eq!(bodies(&all), [Err(Error::TooLong), Ok(std::vec![1, 2, 3])]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn what_goes_in_comes_out(all in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..600), 1..5)) {
            let mut stream = Vec::new();
            for body in &all {
                let line = line(body);
                prop_assert!(line[1..line.len() - 1].iter().all(|byte| *byte != 0));
                prop_assert!(line.len() <= body.len() + CRC_BYTES + (body.len() + CRC_BYTES).div_ceil(254) + 3);
                stream.extend(line);
            }
            let found: Vec<_> = bodies(&stream).into_iter().map(Result::unwrap).collect();
            prop_assert_eq!(found, all);
        }

        #[test]
        fn a_damaged_frame_costs_itself_and_at_most_its_neighbour(
            all in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..60), 4..6),
            place in any::<prop::sample::Index>(),
            with in 1u8..,
        ) {
            let lines: Vec<_> = all.iter().map(|body| line(body)).collect();
            let mut stream: Vec<u8> = lines.concat();
            let place = place.index(stream.len());
            stream[place] ^= with;
            let found: Vec<_> = bodies(&stream).into_iter().filter_map(Result::ok).collect();
            prop_assert!(found.len() + 2 >= all.len());
            prop_assert!(found.iter().all(|body| all.contains(body)), "never another one than was sent");
        }

        #[test]
        fn any_bytes_are_taken(bytes in prop::collection::vec(any::<u8>(), 0..5000)) {
            let mut decoder = Decoder::<64>::new();
            for byte in bytes {
                let _ = decoder.push(byte);
            }
        }
    }
}
