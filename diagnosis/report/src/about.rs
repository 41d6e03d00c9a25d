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
}
