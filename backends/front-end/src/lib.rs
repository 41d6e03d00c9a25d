//! A front-end: the microcontroller that makes the PWM and samples in the on-phase, on the other end of a serial line.
//!
//! This crate is shared by both ends, and contains all of a front-end but its peripherals: [`wire`] encodes and decodes frames
//! on a line, [`frame`] defines their fields, [`Firmware`] is the microcontroller's logic, over the
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
