//! A front-end: the microcontroller that makes the PWM and samples in the on-phase, on the other end of a serial line.
//!
//! This crate is what both ends share, and all of a front-end that is not its peripherals: [`wire`] puts frames on a line and
//! takes them off it, [`frame`] says what is in them, [`Firmware`] is what the microcontroller does with them, over the four
//! calls of [`Hardware`]. No allocation, no operating system, no unsafe code; `docs/front-end.md` describes every byte.
#![no_std]
#![forbid(unsafe_code)]

mod error;
mod firmware;
pub mod frame;
mod guard;
mod version;
pub mod wire;

pub use error::Error;
pub use firmware::{Event, Firmware, Hardware};
pub use frame::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Duty, FULL_DUTY, Frame, Identification, MAX_CHANNELS,
    NOT_SAMPLED, RawSample, Refusal, Samples, State, decode, encode,
};
pub use version::VERSION;
pub use wire::{Decoder, MAX_BODY, MAX_FRAME};
