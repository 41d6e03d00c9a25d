//! One wire of a rig on the way to its answer.

use crate::diagnose::Found;

/// One wire of a rig, and what is known of it so far.
pub(crate) struct Wire {
    /// Index of its channel, and its name.
    pub(crate) channel: usize,
    pub(crate) name: String,
    /// With what is known to be shared in its model.
    pub(crate) found: Found,
    /// Of its recordings.
    pub(crate) warnings: Vec<String>,
}
