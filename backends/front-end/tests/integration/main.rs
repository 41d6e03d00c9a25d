//! The protocol and its firmware, for every input of bytes.

mod firmware;
mod frames;
