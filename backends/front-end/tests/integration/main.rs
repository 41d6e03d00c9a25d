//! The protocol and its firmware: what every input of bytes comes to.

mod firmware;
mod frames;
