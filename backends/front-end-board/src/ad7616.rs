//! The converter's words: an AD7616 with a serial interface on one data line, configured by registers, sequencer and burst on. One edge
//! of CONVST converts eight pairs of inputs one after the other; sixteen words are read afterwards, A and B of each pair.
//!
//! Registers as in the data sheet (Rev. 0) and in Analog Devices' own driver (no-OS, `ad7616.h`).

use crate::CHANNELS;

/// Words of a sweep: A and B of every pair.
pub const WORDS: usize = 4 * CHANNELS;
/// What is sent while results are read: no register.
pub const NOTHING: u16 = 0;

const CONFIGURATION: u8 = 0x02;
const RANGE_A1: u8 = 0x04;
const RANGE_A2: u8 = 0x05;
const RANGE_B1: u8 = 0x06;
const RANGE_B2: u8 = 0x07;
const SEQUENCER: u8 = 0x20;

const BURST: u16 = 1 << 6;
const SEQUENCE: u16 = 1 << 5;
const LAST: u16 = 1 << 8;
/// Ranges of four inputs, two bits each: ±10 V, and ±2.5 V where a shunt is.
const ALL_10_V: u16 = 0b11_11_11_11;
const ODD_2_5_V: u16 = 0b01_11_01_11;

/// Registers as they have to be: address, value. The configuration comes last: it starts the sequencer.
const REGISTERS: [(u8, u16); 13] = [
    (RANGE_A1, ALL_10_V),
    (RANGE_A2, ALL_10_V),
    (RANGE_B1, ODD_2_5_V),
    (RANGE_B2, ODD_2_5_V),
    (SEQUENCER, pair(0)),
    (SEQUENCER + 1, pair(1)),
    (SEQUENCER + 2, pair(2)),
    (SEQUENCER + 3, pair(3)),
    (SEQUENCER + 4, pair(4)),
    (SEQUENCER + 5, pair(5)),
    (SEQUENCER + 6, pair(6)),
    (SEQUENCER + 7, pair(7) | LAST),
    (CONFIGURATION, BURST | SEQUENCE),
];

/// Inputs A and B of the same number.
const fn pair(input: u16) -> u16 {
    input << 4 | input
}

/// The word that writes a register.
const fn write(address: u8, value: u16) -> u16 {
    1 << 15 | read(address) | value & 0x1ff
}

/// The word that asks for a register: the next word that is read has its nine bits.
const fn read(address: u8) -> u16 {
    ((address & 0x3f) as u16) << 9
}

/// A register's value in the word after [`read`].
const fn value(word: u16) -> u16 {
    word & 0x1ff
}

/// Writes the registers and reads them back: whether a converter has them all. `transfer` sends a word, and gives what came meanwhile.
pub fn configure(mut transfer: impl FnMut(u16) -> u16) -> bool {
    for (address, register) in REGISTERS {
        transfer(write(address, register));
    }
    REGISTERS.iter().all(|(address, register)| {
        transfer(read(*address));
        value(transfer(NOTHING)) == *register
    })
}

/// What a sweep saw of one wire, as codes: the voltages of ±10 V, the shunt's of ±2.5 V.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WireCodes {
    /// First tap.
    pub v1: i16,
    /// Second tap.
    pub v2: i16,
    /// Moving end.
    pub v3: i16,
    /// Fixed end: the shunt's voltage.
    pub shunt: i16,
}

/// Sorts the words of a sweep. Of each wire the pair (V2, V3) comes first, for the length is mostly their ratio and so sampled in the same
/// instant; (V1, shunt) follows a microsecond later.
pub fn wires(words: &[u16; WORDS]) -> [WireCodes; CHANNELS] {
    let mut wires = [WireCodes::default(); CHANNELS];
    for (wire, words) in wires.iter_mut().zip(words.chunks_exact(4)) {
        if let [v2, v3, v1, shunt] = *words {
            *wire = WireCodes { v1: v1 as i16, v2: v2 as i16, v3: v3 as i16, shunt: shunt as i16 };
        }
    }
    wires
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_of_the_data_sheet() {
        assert_eq!(write(CONFIGURATION, BURST | SEQUENCE), 0x8460);
        assert_eq!(write(SEQUENCER + 7, pair(7) | LAST), 0xcf77);
        assert_eq!(read(RANGE_B2), 0x0e00);
        assert_eq!(value(0xff60), 0x160);
    }

    #[test]
    fn the_registers_read_back_are_those_written_and_only_shunts_are_2_5_v() {
        for (address, register) in REGISTERS {
            assert_eq!(value(write(address, register)), register, "{address:#x}");
        }
        let range = |register: u8, input: u8| {
            REGISTERS.iter().find(|(address, _)| *address == register).unwrap().1 >> (2 * input) & 0b11
        };
        for input in 0..8 {
            let (a, b) = if input < 4 { (RANGE_A1, RANGE_B1) } else { (RANGE_A2, RANGE_B2) };
            assert_eq!(range(a, input % 4), 0b11);
            assert_eq!(range(b, input % 4), if input % 2 == 1 { 0b01 } else { 0b11 }, "B{input}");
        }
    }

    #[test]
    fn a_converter_answers_that_has_every_register() {
        let answers = |loses: Option<u8>| {
            let (mut registers, mut asked) = ([0x1ff; 64], 0);
            configure(|word| {
                let (address, answer) = ((word >> 9 & 0x3f) as u8, asked);
                if word >> 15 == 1 && Some(address) != loses {
                    registers[usize::from(address)] = value(word);
                }
                asked = registers[usize::from(address)];
                answer
            })
        };
        assert!(answers(None));
        assert!(REGISTERS.iter().all(|(address, _)| !answers(Some(*address))));
        assert!(!configure(|_| 0) && !configure(|_| u16::MAX), "none is there");
    }

    #[test]
    fn every_wire_has_its_own_words() {
        let words = core::array::from_fn(|index| index as u16 | 0x8000);
        let wires = wires(&words);
        let code = |index: u16| (index | 0x8000) as i16;
        assert_eq!(wires[2], WireCodes { v2: code(8), v3: code(9), v1: code(10), shunt: code(11) });
        assert_eq!(wires[3].shunt, code(15));
    }
}
