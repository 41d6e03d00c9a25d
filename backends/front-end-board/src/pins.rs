//! Which pin of the Pico is what. The table in `docs/board.md` is this one; a test compares them.

/// Wires of the board.
pub const CHANNELS: usize = 4;

/// Gates of the wires' stages, by channel.
pub const GATES: [u8; CHANNELS] = [2, 3, 4, 5];
/// The master switch of the wires' supply.
pub const ENABLE: u8 = 6;
/// Second contact of the emergency stop, to ground: low = closed.
pub const STOP: u8 = 7;
/// Reset button of the emergency stop, to ground: low = pressed.
pub const STOP_RESET: u8 = 8;
/// The converter's pins beside its SPI.
pub const CONVST: u8 = 10;
/// High while it converts.
pub const BUSY: u8 = 11;
/// Low resets it.
pub const ADC_RESET: u8 = 12;
/// SPI 0, with the chip select in hardware.
pub const SDOA: u8 = 16;
/// Chip select.
pub const CS: u8 = 17;
/// Clock.
pub const SCLK: u8 = 18;
/// To the converter.
pub const SDI: u8 = 19;
/// The Pico's own light.
pub const LED: u8 = 25;
/// The wires' supply by its divider, on the RP2040's own converter.
pub const SUPPLY: u8 = 26;

/// Every pin: number, name, and what holds it while the RP2040 is reset or not there.
pub const TABLE: [(u8, &str, &str); 16] = [
    (GATES[0], "gate 0", "10 kΩ to ground"),
    (GATES[1], "gate 1", "10 kΩ to ground"),
    (GATES[2], "gate 2", "10 kΩ to ground"),
    (GATES[3], "gate 3", "10 kΩ to ground"),
    (ENABLE, "enable", "10 kΩ to ground"),
    (STOP, "emergency stop, contact", "pull-up: open"),
    (STOP_RESET, "emergency stop, reset button", "pull-up: released"),
    (CONVST, "CONVST", "10 kΩ to ground"),
    (BUSY, "BUSY", "–"),
    (ADC_RESET, "RESET", "10 kΩ to ground: in reset"),
    (SDOA, "SDOA", "–"),
    (CS, "CS", "10 kΩ to 3.3 V"),
    (SCLK, "SCLK", "–"),
    (SDI, "SDI", "–"),
    (LED, "light", "–"),
    (SUPPLY, "supply ÷ 4", "–"),
];
