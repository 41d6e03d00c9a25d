//! A name in a message: text of fixed size.

use std::fmt;

use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Bytes of a [`Name`].
const NAME_BYTES: usize = 64;

/// A name of at most 64 bytes, UTF-8, padded with zeros.
#[derive(Clone, Copy, PartialEq, Eq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Name")]
#[repr(C)]
pub struct Name {
    bytes: [u8; NAME_BYTES],
}

impl Name {
    /// No name.
    pub const EMPTY: Name = Name { bytes: [0; NAME_BYTES] };

    /// From text of 1 to 64 bytes without a zero byte; `None` otherwise.
    pub(crate) fn of(text: &str) -> Option<Name> {
        if text.is_empty() || text.len() > NAME_BYTES || text.bytes().any(|b| b == 0) {
            return None;
        }
        let mut name = Name::EMPTY;
        name.bytes[..text.len()].copy_from_slice(text.as_bytes());
        Some(name)
    }

    /// The text; what is not UTF-8 (a foreign writer's) is cut off.
    pub fn as_str(&self) -> &str {
        let end = self.bytes.iter().position(|&b| b == 0).unwrap_or(NAME_BYTES);
        match std::str::from_utf8(&self.bytes[..end]) {
            Ok(text) => text,
            Err(e) => std::str::from_utf8(&self.bytes[..e.valid_up_to()]).unwrap_or(""),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}
