//! A front-end: the microcontroller that makes the PWM and samples in the on-phase, on the other end of a serial line.
//!
//! This crate is shared by both ends, and contains all of a front-end but its peripherals: [`wire`] encodes and decodes frames
//! on a line, [`frame`] defines their fields, [`Firmware`] is the microcontroller's logic, over the
//! calls of [`Hardware`]. No allocation, no operating system, no unsafe code; `docs/front-end.md` describes every byte.
//!
//! ```
//! use sinew_front_end::{Decoder, Frame, MAX_BODY, MAX_FRAME, decode, encode};
//!
//! let mut line = [0; MAX_FRAME];
//! let sent = encode(&Frame::Hello { nonce: 7 }, &mut line)?;
//!
//! let mut decoder = Decoder::<MAX_BODY>::new();
//! let mut received = None;
//! for byte in &line[..sent] {
//!     if let Some(body) = decoder.push(*byte) {
//!         received = Some(decode(body?)?);
//!     }
//! }
//! assert_eq!(received, Some(Frame::Hello { nonce: 7 }));
//! # Ok::<(), sinew_front_end::Error>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod error;
mod firmware;
pub mod frame;
mod guard;
mod version;
pub mod wire;

pub use error::Error;
pub use firmware::{Event, Firmware, Hardware, StopPins};
pub use frame::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Duty, EnableMode, FULL_DUTY, Features, Frame, Identification,
    MAX_CHANNELS, NOT_SAMPLED, RawSample, Refusal, ResetCause, Samples, State, decode, encode, encode_hello,
};
pub use version::VERSION;
pub use wire::{Decoder, MAX_BODY, MAX_FRAME};
