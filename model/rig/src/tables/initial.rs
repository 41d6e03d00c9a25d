//! `[channel.initial]`: the state at the first sample.

use sinew_physics::WireModel;

use crate::declare::rows::*;

/// Keys of `[channel.initial]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.initial",
        about: "The state at the first sample.",
        optional: false,
        keys: keys! {
            WireModel;
            /// Wire temperature.
            "temperature_c" = at(initial.temperature_c), number(si("°C"), -273.15, 800.0),
                Computed("ambient, or the first imposed temperature");
            /// Martensite fraction, clipped into the outer curves.
            "martensite" = at(initial.martensite), number(si("1"), 0.0, 1.0), Number(1.0);
        },
        check: None,
    }
}
