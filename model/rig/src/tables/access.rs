//! `[access]`: which users besides the driver's own may look and command.

use crate::declare::rows::*;

/// Longest name of a Unix group, in bytes.
const MAX_GROUP_NAME: usize = 32;

table! {
    "access":
    "Which users besides the driver's own may look and command: see [access.md](access.md).";

    /// Which users besides the driver's own may do what; `None` as the default says.
    #[derive(Debug, Clone, Default, PartialEq, Eq)]
    pub struct Access {
        /// Unix group whose members may command and look: its name or number.
        command_group: Option<String> = "command_group", name(MAX_GROUP_NAME), Computed("nobody's");
        /// Unix group whose members may look and stop the driver, but command nothing else.
        stop_group: Option<String> = "stop_group", name(MAX_GROUP_NAME), Computed("nobody's");
        /// Unix group whose members may look, or `everyone`.
        read_group: Option<String> = "read_group", name(MAX_GROUP_NAME), Computed("those of `command_group`");
    }
}

impl Access {
    /// The word that lets every user look.
    pub const EVERYONE: &str = "everyone";

    /// Whether any other user may do anything.
    pub fn is_open(&self) -> bool {
        self.command_group.is_some() || self.stop_group.is_some() || self.read_group.is_some()
    }
}
