//! The input of an emergency stop: `[backend.estop]`.

use super::linux::Polarity;
use crate::declare::rows::*;
use crate::value::MAX_PATH;

table! {
    "backend.estop":
    "An emergency stop's contact, normally closed: open, everything is off and stays so until it is closed and was reset, by its own input or \
     at the driver's terminal. A rig that has one starts with it latched. See [wiring](wiring.md).";

    /// The input of an emergency stop.
    #[derive(Debug, Clone, PartialEq)]
    pub struct EmergencyStop {
        /// Whether there is one.
        fitted: bool = "fitted", BOOLEAN, Boolean(false);
        /// Where it is with kind `linux`: chip and line, such as `gpiochip0/27`, or the path of a file of sysfs. A front-end has a pin of its own for it.
        line: Option<String> = "line", text("a chip and its line", MAX_PATH),
            Computed("none: **required** with kind `linux` where one is fitted");
        /// Which level it has while the contact is closed: high, or low. A broken lead has to look like an open contact.
        polarity: Polarity = "polarity", Polarity::KIND, Polarity::DEFAULT;
        /// The line of its reset button with kind `linux`, with the same polarity while it is pressed.
        reset_line: Option<String> = "reset_line", text("a chip and its line", MAX_PATH),
            Computed("none: it is reset at the driver's terminal");
    }
}
