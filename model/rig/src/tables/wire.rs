//! `[channel.wire]`: the wire's size.

use sinew_physics::WireModel;

use crate::declare::rows::*;

/// Keys of `[channel.wire]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.wire",
        about: "The wire's size. Required.",
        optional: false,
        keys: keys! {
            WireModel;
            /// Diameter d.
            "diameter_mm" = at(geometry.diameter_m), number(milli("mm"), 0.005, 10.0),
                Required("the wire's diameter in mm, such as 0.125"), prior Relative(0.01);
            /// Hot and unloaded length L_0.
            "length_mm" = at(geometry.length_m), number(milli("mm"), 1.0, 100_000.0),
                Required("the wire's hot, unloaded length in mm, such as 160.0"), prior Relative(0.005);
        },
        check: None,
    }
}
