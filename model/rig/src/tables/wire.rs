//! `[channel.wire]`: the wire's size.

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::Channel;
use crate::wires;

/// Keys of `[channel.wire]`.
pub(crate) fn section() -> Section<Channel> {
    Section {
        table: "channel.wire",
        about: "The wire's size, or its name where the project knows it: see [wires by name](#wires-by-name). Required.",
        optional: false,
        keys: keys! {
            Channel;
            /// A wire as it is sold, which gives its diameter and what its data sheet says of the material; keys that are given
            /// besides go before it.
            "kind" = at(wire_kind), wires::KIND, Computed("none");
            /// Diameter d.
            "diameter_mm" = at(model.geometry.diameter_m), number(milli("mm"), 0.005, 10.0),
                Computed("the `kind`'s; **required** without one"), prior Relative(0.01);
            /// Hot and unloaded length L_0.
            "length_mm" = at(model.geometry.length_m), number(milli("mm"), 1.0, 100_000.0),
                Required("the wire's hot, unloaded length in mm, such as 160.0"), prior Relative(0.005);
        },
        check: Some(Box::new(is_some_size)),
    }
}

fn is_some_size(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    if channel.wire_kind.is_none() && !stated.gives("wire", "diameter_mm") && !stated.gives("wire", "kind") {
        let expected =
            "the wire's diameter in mm, such as 0.125, or what it is sold as, such as kind = \"flexinol-150-lt\""
                .into();
        reader.problem(stated.line_at(&["wire"]), stated.label(), "wire.diameter_mm", What::Missing { expected });
    }
}
