//! The boards of `docs/board.md` as far as no microcontroller is needed to know them: when a period's pulses and conversions are, what
//! goes over the converter's SPI, what its codes are worth, and of each microcontroller its pins and what its timers count
//! ([`pico`], [`nucleo`]). `firmware/rp2040` and `firmware/stm32g4` put it on one; all of it is tested where there is none.
//!
//! A period: [`Plan`] is when the converter sweeps its sixteen inputs so that each wire is seen at the end of its on-phase, and
//! [`Collector`] takes the sweeps that came in time and makes samples of them.
#![no_std]
#![forbid(unsafe_code)]

pub mod ad7616;
mod collector;
mod identity;
pub mod nucleo;
mod period;
pub mod pico;
mod scale;

pub use collector::Collector;
pub use identity::{MAX_SILENCE_NS, WATCHDOG_NS, identification, version};
pub use period::{LEAD_NS, MIN_ON_NS, Plan, READ_NS, SPACING_NS, SWEEP_NS, Sweep};
pub use scale::{FULL_CODE, SHUNT_OHM, SUPPLY_DIVIDER, current_code, supply_code, voltage_code};

/// Wires of a board: the converter has four inputs for each.
pub const CHANNELS: usize = 4;
