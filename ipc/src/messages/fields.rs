//! The published fields of a channel: one table, from which everything that knows them is made.
//!
//! A row becomes a member of [`ChannelState`] and an entry of [`ChannelState::FIELDS`]. From these follow the bytes on the
//! blackboard, in the stream and in recordings, the columns of a recording's schema and of an export, the quantities of the scope,
//! what a replay starts from and compares, the keys of `status --json`, the monitor's details, and the table in `docs/client.md`.
//!
//! To publish another field, add its row here, raise [`PROTOCOL`], and fill it where the driver describes a channel
//! (`driver/src/engine.rs`).

use iceoryx2::prelude::ZeroCopySend;
use std::fmt::Write as _;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Version of the messages. Every change of a layout or of a meaning raises it; a client of another version is told so when it
/// connects.
pub const PROTOCOL: u32 = 7;

/// What a field is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldKind {
    /// An `f64`; NaN = not known.
    Float,
    /// A `u32`: a code, a count or flags.
    Code,
}

/// What a field is to the replay of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Replay {
    /// A replay starts from it.
    Input,
    /// A replay computes it anew, and compares.
    Output,
    /// Both: a client's request, which a replay repeats and the loop reports.
    Both,
    /// Nothing: it is said beside the loop, and no cycle follows from it.
    Nothing,
}

/// A line of the monitor's details.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detail {
    /// What it is called there, in a word or two.
    pub label: &'static str,
    /// Decimals, in the unit it is shown in: mm and mm/s for lengths and speeds, else the field's own.
    pub decimals: usize,
    /// Whether it is an estimate, which the line then says.
    pub is_estimate: bool,
}

impl Detail {
    const fn measured(label: &'static str, decimals: usize) -> Option<Detail> {
        Some(Detail { label, decimals, is_estimate: false })
    }

    const fn estimated(label: &'static str, decimals: usize) -> Option<Detail> {
        Some(Detail { label, decimals, is_estimate: true })
    }
}

/// One published field of a channel: a row of the table.
#[derive(Debug, Clone, Copy)]
pub struct ChannelField {
    /// Its name, with its unit: `length_m`.
    pub name: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it means, in Markdown.
    pub meaning: &'static str,
    /// What it is made of.
    pub kind: FieldKind,
    /// What it is to a replay.
    pub replay: Replay,
    /// Whether it is a key of a channel in `status --json`; mode and fault are there by name.
    pub in_status: bool,
    /// Its line among the monitor's details, if it has one.
    pub detail: Option<Detail>,
    get: fn(&ChannelState) -> f64,
}

impl ChannelField {
    /// Its value in a channel's state; codes as numbers.
    #[inline]
    pub fn of(&self, state: &ChannelState) -> f64 {
        (self.get)(state)
    }

    /// Whether a replay needs it.
    pub const fn is_replay_input(&self) -> bool {
        matches!(self.replay, Replay::Input | Replay::Both)
    }

    /// Whether a replay computes it anew.
    pub const fn is_replay_output(&self) -> bool {
        matches!(self.replay, Replay::Output | Replay::Both)
    }
}

/// Makes of the table [`ChannelState`], its constants and its conversions. A row is
/// `/// meaning`, `name: "unit" = value when nothing is known, { what differs from the default }`.
macro_rules! channel_state {
    (
        floats { $( $(#[doc = $float_doc:literal])+ $float:ident: $float_unit:literal = $float_unknown:expr, { $($float_set:tt)* } )+ }
        codes { $( $(#[doc = $code_doc:literal])+ $code:ident = $code_unknown:expr, { $($code_set:tt)* } )+ }
    ) => {
        /// One channel in one cycle, in SI units. What is not known is NaN.
        #[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
        #[type_name("sinew_ipc::messages::ChannelState")]
        #[repr(C)]
        pub struct ChannelState {
            $( $(#[doc = $float_doc])+ pub $float: f64, )+
            $( $(#[doc = $code_doc])+ pub $code: u32, )+
        }

        impl ChannelState {
            /// How many of its fields are floats; they come first.
            pub const FLOATS: usize = [$(stringify!($float)),+].len();
            /// How many are codes.
            pub const CODES: usize = [$(stringify!($code)),+].len();

            /// Of a channel nothing is known about.
            pub const UNKNOWN: ChannelState =
                ChannelState { $($float: $float_unknown,)+ $($code: $code_unknown,)+ };

            /// The table: every field in the order of its bytes, floats first.
            pub const FIELDS: &'static [ChannelField] = &[
                $( ChannelField {
                    $($float_set)*
                    ..row(
                        stringify!($float),
                        $float_unit,
                        concat!($($float_doc),+),
                        FieldKind::Float,
                        |state| state.$float,
                    )
                }, )+
                $( ChannelField {
                    $($code_set)*
                    ..row(
                        stringify!($code),
                        "",
                        concat!($($code_doc),+),
                        FieldKind::Code,
                        |state| f64::from(state.$code),
                    )
                }, )+
            ];

            /// Its floats and its codes, in the order of [`ChannelState::FIELDS`].
            #[inline]
            pub const fn parts(&self) -> ([f64; Self::FLOATS], [u32; Self::CODES]) {
                ([$(self.$float),+], [$(self.$code),+])
            }

            /// The state with these parts: the inverse of [`ChannelState::parts`].
            #[inline]
            pub const fn from_parts(floats: &[f64; Self::FLOATS], codes: &[u32; Self::CODES]) -> ChannelState {
                let [$($float),+] = *floats;
                let [$($code),+] = *codes;
                ChannelState { $($float,)+ $($code,)+ }
            }
        }
    };
}

/// A row as most are: computed by the loop, and shown in neither status nor details.
const fn row(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    kind: FieldKind,
    get: fn(&ChannelState) -> f64,
) -> ChannelField {
    ChannelField { name, unit, meaning, kind, replay: Replay::Output, in_status: false, detail: None, get }
}

channel_state! {
    floats {
        /// Wire length as well as it is known: measured, without the noise of a sample, a few ms late; NaN while it is not measured.
        length_m: "m" = f64::NAN, { in_status: true, detail: Detail::measured("length", 3), }
        /// The same as the last sample measured it, with its noise: what replays and models go by; NaN while it is not measured.
        measured_length_m: "m" = f64::NAN, { in_status: true, }
        /// Observed speed, positive when the wire gets longer.
        velocity_m_s: "m/s" = f64::NAN, { detail: Detail::measured("speed", 2), }
        /// Observed acceleration.
        acceleration_m_s2: "m/s²" = f64::NAN, {}
        /// Commanded length; NaN when there is none.
        target_m: "m" = f64::NAN, { in_status: true, detail: Detail::measured("target", 3), }
        /// Duty given for the next period, 0..1.
        duty: "" = 0.0, { in_status: true, replay: Replay::Both, }
        /// Measured resistance.
        resistance_ohm: "Ω" = f64::NAN, { in_status: true, detail: Detail::measured("resistance", 3), }
        /// Estimated wire temperature.
        temperature_c: "°C" = f64::NAN, { in_status: true, detail: Detail::estimated("temperature", 1), }
        /// Estimated martensite fraction, 0..1.
        martensite: "" = f64::NAN, { in_status: true, detail: Detail::estimated("martensite", 3), }
        /// Mean electrical power over the period just past.
        power_w: "W" = 0.0, { in_status: true, detail: Detail::measured("power", 3), }
        /// The controller's surface σ (sliding mode) or error; 0 without a controller.
        surface: "m/s²" = 0.0, {}
        /// What is left of the setpoint's lease; infinite when the driver moves the channel by itself, NaN without a setpoint.
        lease_s: "s" = f64::NAN, { in_status: true, replay: Replay::Both, }
        /// Value of the client's setpoint as the loop took it: m for a length and for a force against a spring, N for the tension of
        /// a joint, a duty 0..1; NaN without one.
        asked: "" = f64::NAN, { replay: Replay::Both, }
        /// Supply as sampled in the period just past; NaN = not sampled. This and the four below are the bits the backend
        /// delivered.
        supply_v: "V" = f64::NAN, { replay: Replay::Input, }
        /// First tap as sampled; NaN = not sampled.
        v1_v: "V" = f64::NAN, { replay: Replay::Input, }
        /// Second tap as sampled; NaN = not sampled.
        v2_v: "V" = f64::NAN, { replay: Replay::Input, }
        /// Moving end as sampled; NaN = not sampled.
        v3_v: "V" = f64::NAN, { replay: Replay::Input, }
        /// Current as sampled; NaN = not sampled.
        current_a: "A" = f64::NAN, { replay: Replay::Input, }
    }
    codes {
        /// What the channel is doing: 0 waiting, 1 off, 2 length, 3 duty, 4 force, 5 program, 6 fault, 7 lapsed.
        mode = 0, { in_status: true, }
        /// Code of the latched fault, 0 = none.
        fault = 0, { in_status: true, }
        /// Verdict on the present sample, 0 = good: the codes of `sinew_sensing::Health`.
        health = 0, {}
        /// Bits of `ChannelState::FLAG_…`: 1 controller at its limit, 2 settled, 4 held back by the supervisor or the limits of the
        /// tension, 8 and that is the heat budget, 16 and that is the temperature budget, 32 the first of the latched faults, 64 the
        /// next period is dark, 128 the output has not confirmed its duty,
        /// 256 an emergency stop holds everything off.
        flags = 0, {}
        /// The request the loop took right before this cycle: its kind as in `CommandKind`, plus 256 times its place among those of
        /// this cycle; 0 = none. A channel takes one a cycle.
        order = 0, { replay: Replay::Both, }
        /// How the backend failed in this cycle, 0 = it did not: the codes of `sinew_driver::BackendError`.
        backend = 0, { replay: Replay::Input, }
        /// Process id of the client that has claimed the channel, 0 = nobody.
        owner = 0, { in_status: true, replay: Replay::Nothing, }
        /// Priority of that claim, 0 to 9; 0 without one.
        priority = 0, { in_status: true, replay: Replay::Nothing, }
    }
}

impl ChannelState {
    /// The field of this name, or of a name it once had.
    pub fn field(name: &str) -> Option<&'static ChannelField> {
        let name = if name == "observed_length_m" { "length_m" } else { name };
        ChannelState::FIELDS.iter().find(|field| field.name == name)
    }

    /// The bytes of these, one after the other, as they lie in memory: what a recording holds.
    pub fn bytes_of(channels: &[ChannelState]) -> &[u8] {
        channels.as_bytes()
    }
}

impl Default for ChannelState {
    fn default() -> Self {
        ChannelState::UNKNOWN
    }
}

/// The table as Markdown, as it stands in `docs/client.md`.
pub fn field_table_markdown() -> String {
    let mut text = String::from("| field | type | unit | `status --json` | meaning |\n|---|---|---|---|---|\n");
    for ChannelField { name, unit, meaning, kind, in_status, .. } in ChannelState::FIELDS {
        let kind = match kind {
            FieldKind::Float => "f64",
            FieldKind::Code => "u32",
        };
        let in_status = if *in_status { "yes" } else { "" };
        let _ = writeln!(text, "| `{name}` | {kind} | {unit} | {in_status} | {} |", meaning.trim());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_laid_out_as_in_protocol_6() {
        // A change here is a change of the protocol: raise PROTOCOL with it.
        assert_eq!((PROTOCOL, size_of::<ChannelState>()), (7, 176));
    }

    #[test]
    fn parts_stand_in_the_order_of_the_bytes_and_under_their_names() {
        let state =
            ChannelState::from_parts(&std::array::from_fn(|i| i as f64 + 0.5), &std::array::from_fn(|i| i as u32));
        let (floats, codes) = state.parts();
        assert_eq!(ChannelState::from_parts(&floats, &codes), state);
        let text = format!("{state:?}");
        let names = ChannelState::FIELDS.iter().map(|field| field.name);
        let values = floats.iter().map(|v| format!("{v:?}")).chain(codes.iter().map(|v| v.to_string()));
        let reported: Vec<String> = names.zip(values).map(|(name, value)| format!("{name}: {value}")).collect();
        assert_eq!(
            text,
            format!("ChannelState {{ {} }}", reported.join(", ")),
            "Debug prints the fields in their order"
        );
        assert_eq!(size_of::<ChannelState>(), 8 * floats.len() + 4 * codes.len(), "without holes");
    }

    #[test]
    fn a_field_finds_its_own_value_and_is_what_its_row_says() {
        let state =
            ChannelState::from_parts(&std::array::from_fn(|i| i as f64 + 0.5), &std::array::from_fn(|i| i as u32 + 7));
        let (floats, codes) = state.parts();
        let values = floats.into_iter().chain(codes.map(f64::from));
        for ((place, field), value) in ChannelState::FIELDS.iter().enumerate().zip(values) {
            assert_eq!(field.of(&state), value, "{}", field.name);
            assert_eq!(field.kind == FieldKind::Float, place < ChannelState::FLOATS, "{}", field.name);
            assert_eq!(ChannelState::field(field.name).map(|found| found.name), Some(field.name), "no name twice");
            let meaning = field.meaning.trim();
            assert!(meaning.ends_with('.') && !meaning.contains('|'), "{}: {meaning}", field.name);
        }
        assert!(ChannelState::field("no_such_field").is_none());
    }
}
