//! The protocol's version.

/// Version of the protocol: the first byte of every frame.
pub const VERSION: u8 = 2;
