//! Errors of decoding a frame.

use core::fmt;

/// What is wrong with a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    /// More bytes than any frame has; they were dropped up to the next end of a frame.
    TooLong,
    /// Not stuffed as frames are, or too few bytes to be one.
    Broken,
    /// The checksum is another.
    Checksum,
    /// Another version of the protocol.
    Version {
        /// The one it names.
        found: u8,
    },
    /// A kind of frame there is not.
    Kind {
        /// Its number.
        found: u8,
    },
    /// Its length is not that of its kind and number of channels.
    Length,
    /// A value no frame may carry.
    Value,
    /// The buffer it is to be written to is too small.
    NoRoom,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::TooLong => f.write_str("more bytes than any frame has"),
            Error::Broken => f.write_str("not a frame"),
            Error::Checksum => f.write_str("the checksum does not fit"),
            Error::Version { found } => {
                write!(f, "the frame is of protocol version {found}, expected {}", crate::version::VERSION)
            }
            Error::Kind { found } => write!(f, "there is no frame of kind {found:#04x}"),
            Error::Length => f.write_str("the frame's length is not that of its kind"),
            Error::Value => f.write_str("the frame carries a value it may not"),
            Error::NoRoom => f.write_str("the buffer is too small for the frame"),
        }
    }
}

impl core::error::Error for Error {}
