//! What a page says of the run it reports.

/// What a page says about where it comes from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct About {
    /// Name of the rig.
    pub rig: String,
    /// Name of the channel that was looked at.
    pub channel: String,
    /// The command that makes this page again, as typed.
    pub command: String,
    /// Version of the program that made it.
    pub version: String,
    /// When, as people write it.
    pub date: String,
    /// The rig file and the recordings it was made from.
    pub files: Vec<Source>,
}

/// A file as it was when it was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Source {
    /// Its path, as typed.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}
