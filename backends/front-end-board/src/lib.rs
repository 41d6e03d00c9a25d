//! The board of `docs/board.md` as far as no microcontroller is needed to know it: its pins, when a period's pulses and conversions
//! are, what goes over the converter's SPI and what its codes are worth. `firmware/rp2040` puts it on an RP2040; all of it is
//! tested where there is none.
//!
//! A period: [`pulse`] is the length of an output's one pulse, [`Plan`] when the converter sweeps its sixteen inputs so that each
//! wire is seen at the end of its on-phase, and [`Collector`] takes the sweeps that came in time and makes samples of them.
#![no_std]
#![forbid(unsafe_code)]

pub mod ad7616;
mod collector;
mod identity;
mod period;
pub mod pins;
mod scale;

pub use collector::Collector;
pub use identity::{MAX_SILENCE_NS, WATCHDOG_NS, identification, reset_cause};
pub use period::{CLOCK_MHZ, LEAD_NS, MIN_ON_NS, Plan, READ_NS, SPACING_NS, SWEEP_NS, Sweep, pulse};
pub use pins::CHANNELS;
pub use scale::{FULL_CODE, SHUNT_OHM, SUPPLY_DIVIDER, current_code, supply_code, voltage_code};
