//! `[channel.sensors]` and `[channel.sensors.noise]`: what the recordings' sensors are like.

use std::collections::BTreeMap;

use crate::declare::rows::*;

words! {
    /// Whether the zero of `position_m` is known.
    pub enum PositionZero, default Known {
        /// 0 is L_0.
        Known = "known",
        /// The encoder's zero is arbitrary and may differ from recording to recording.
        Free = "free",
    }
}

/// Keys of `[channel.sensors]`.
pub(crate) fn sensors() -> Section<PositionZero> {
    Section {
        table: "channel.sensors",
        about: "What the recordings' sensors are like.",
        optional: false,
        keys: keys! {
            PositionZero;
            /// `free`: the encoder's zero is arbitrary and may differ from recording to recording.
            "position_zero" = itself(), PositionZero::KIND, PositionZero::DEFAULT;
        },
        check: None,
    }
}

/// RMS noise by the name of a recording's column, in the column's unit.
type Noise = BTreeMap<String, f64>;

/// The table of the noise.
pub(crate) const NOISE: &str = "channel.sensors.noise";

/// The noise of a recording's column, by the column's name.
macro_rules! of {
    ($column:literal) => {
        Accessor::new(
            |noise: &Noise| noise.get($column).copied().map(Value::Number),
            |noise, value| {
                if let Value::Number(rms) = value {
                    noise.insert($column.into(), rms);
                }
            },
        )
    };
}

const fn rms(unit: &'static str) -> Kind {
    number(si(unit), 1e-12, 1e6)
}

const ESTIMATED: crate::key::Default = Computed("estimated from the recording");

/// Keys of `[channel.sensors.noise]`.
pub(crate) fn noise() -> Section<Noise> {
    Section {
        table: NOISE,
        about: "RMS noise of the recordings' measured columns, where it is known. A fit weighs each sensor by it.",
        optional: false,
        keys: keys! {
            Noise;
            /// Of the current.
            "current_a" = of("current_a"), rms("A"), ESTIMATED;
            /// Of the first tap.
            "v1_v" = of("v1_v"), rms("V"), ESTIMATED;
            /// Of the second tap.
            "v2_v" = of("v2_v"), rms("V"), ESTIMATED;
            /// Of the moving end.
            "v3_v" = of("v3_v"), rms("V"), ESTIMATED;
            /// Of the wire tension.
            "force_n" = of("force_n"), rms("N"), ESTIMATED;
            /// Of the elongation.
            "position_m" = of("position_m"), rms("m"), ESTIMATED;
            /// Of the wire temperature.
            "temperature_c" = of("temperature_c"), rms("K"), ESTIMATED;
            /// Of the electrical power.
            "power_w" = of("power_w"), rms("W"), ESTIMATED;
        },
        check: None,
    }
}
