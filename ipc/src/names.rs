//! Names that come from outside, checked: of channels and groups in messages, and of rigs, which become names of files.

use crate::error::Error;
use crate::messages::Name;

/// Longest rig name.
pub const MAX_RIG_NAME: usize = 48;

impl Name {
    /// From text of 1 to 64 bytes without a zero byte.
    ///
    /// # Errors
    /// [`Error::Name`] otherwise.
    pub fn new(text: &str) -> Result<Name, Error> {
        Name::of(text).ok_or_else(|| Error::Name { name: text.to_string() })
    }
}

/// Checks a rig name: 1 to 48 of `A-Z a-z 0-9 _ . -`.
///
/// # Errors
/// [`Error::RigName`].
pub fn check_rig_name(name: &str) -> Result<(), Error> {
    let allowed = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'.' | b'-');
    if name.is_empty() || name.len() > MAX_RIG_NAME || !name.bytes().all(allowed) {
        return Err(Error::RigName { name: name.to_string() });
    }
    Ok(())
}
