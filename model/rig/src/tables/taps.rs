//! `[channel.taps]`: where the dual measurement touches the wire.

use sinew_physics::{Taps, WireModel};

use crate::declare::rows::*;

/// The position of a tap; that there are taps at all is what one of them being set says.
macro_rules! tap {
    ($field:ident) => {
        Accessor::new(
            |model: &WireModel| model.taps.map(|taps| Value::Number(taps.$field)),
            |model, value| model.taps.get_or_insert(Taps { l0_m: 0.0, ls_m: f64::NAN }).$field.assign(value),
        )
    };
}

/// Keys of `[channel.taps]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.taps",
        about: "The dual measurement (eq. 42–44). Leave the table out where there is none.",
        optional: true,
        keys: keys! {
            WireModel;
            /// Position of the first tap from the fixed end; on the wire.
            "l0_mm" = tap(l0_m), number(milli("mm"), 0.0, 100_000.0), Number(0.0), prior Relative(0.007);
            /// Distance from the first to the second tap; `l0_mm` + `ls_mm` must lie on the wire.
            "ls_mm" = tap(ls_m), number(milli("mm"), 0.001, 100_000.0),
                Required("the distance between the taps in mm, such as 150.0"), prior Relative(0.007);
        },
        check: None,
    }
}
