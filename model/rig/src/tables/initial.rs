//! `[channel.initial]`: the state at the first sample.

use crate::declare::rows::*;
use crate::tables::Channel;

/// Keys of `[channel.initial]`.
pub(crate) static SECTION: Section<Channel> = Section {
    table: "channel.initial",
    about: "The state at the first sample.",
    optional: false,
    check: None,
    keys: &[keys! {
        Channel;
        /// Wire temperature.
        "temperature_c" = at(model.initial.temperature_c), number(si("°C"), -273.15, 800.0),
            Computed("ambient, or the first imposed temperature");
        /// Martensite fraction, clipped into the outer curves.
        "martensite" = at(model.initial.martensite), number(si("1"), 0.0, 1.0), Number(1.0);
    }],
};
