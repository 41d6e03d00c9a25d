//! Linux's own PWM outputs and converters: `[backend.linux]` and `[channel.linux]`.

use crate::declare::rows::*;
use crate::value::MAX_PATH;

words! {
    /// How converters are read.
    pub enum LinuxSampling, default Buffer {
        /// From `/dev/iio:deviceN`: the converter runs by itself and the newest scan is taken.
        Buffer = "buffer",
        /// From `in_…_raw` or `in_…_input` in sysfs: each input is converted when it is read, within the cycle.
        Sysfs = "sysfs",
    }
}

words! {
    /// What moment of a period a conversion is of.
    pub enum LinuxPhase, default Synchronised {
        /// The hardware sees to it that it is of an on-phase: a trigger from the PWM, or a sample-and-hold gated by it.
        Synchronised = "synchronised",
        /// Any: the newest whose voltage or current shows the on-phase is taken.
        Free = "free",
    }
}

words! {
    /// The level of an output that heats.
    pub enum Polarity, default Normal {
        /// High.
        Normal = "normal",
        /// Low.
        Inversed = "inversed",
    }
}

table! {
    "backend.linux":
    "Linux's own PWM outputs and converters, with kind `linux`: [Linux](linux-backend.md).";

    /// Linux's own interfaces.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct LinuxInterfaces {
        /// From `/dev/iio:deviceN`, which the converter fills by itself, or input by input from sysfs within the cycle.
        sampling: LinuxSampling = "sampling", LinuxSampling::KIND, LinuxSampling::DEFAULT;
        /// What moment a conversion is of: hardware sees to it that it is of an on-phase (a trigger from the PWM, a
        /// sample-and-hold gated by it), or any, and the newest that shows the on-phase is taken.
        phase: LinuxPhase = "phase", LinuxPhase::KIND, LinuxPhase::DEFAULT;
        /// Name of the IIO trigger that the converters are set to.
        trigger: Option<String> = "trigger", text("a trigger's name", MAX_PATH),
            Computed("the one the converter has, or none");
        /// The driver's silence, in ms, after which the guard puts all outputs to zero; at least 4 periods. A driver
        /// that is gone is noticed at once.
        guard_ms: u32 = "guard_ms", integer(20, 1000), Integer(100);
        /// The folder `sys` and `dev` are in: another one for tests.
        root: String = "root", text("a folder", MAX_PATH), Text("/");
    }
}

/// Where a channel is among Linux's own outputs and inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxChannel {
    /// Its output, `chip/number`; `Some` where the kind is [`BackendKind::Linux`](crate::BackendKind::Linux).
    pub pwm: Option<String>,
    /// Which level heats.
    pub polarity: Polarity,
    /// First tap.
    pub v1: LinuxInput,
    /// Second tap.
    pub v2: LinuxInput,
    /// Moving end.
    pub v3: LinuxInput,
    /// Current.
    pub current: LinuxInput,
    /// Supply.
    pub supply: LinuxInput,
    /// When gains and offsets were measured, and against what.
    pub measured: Option<String>,
}

/// An input of a converter: value = `gain` · what the kernel makes of it, in V or A, + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxInput {
    /// `device:input`; `None` = not measured.
    pub name: Option<String>,
    /// Of the divider or shunt before it, V/V or A/V; never 0.
    pub gain: f64,
    /// Added after it, in V or A.
    pub offset: f64,
}

impl Unread for LinuxChannel {
    const UNREAD: LinuxChannel = {
        const INPUT: LinuxInput = LinuxInput { name: Field::UNREAD, gain: Field::UNREAD, offset: Field::UNREAD };
        LinuxChannel {
            pwm: Field::UNREAD,
            polarity: Field::UNREAD,
            v1: INPUT,
            v2: INPUT,
            v3: INPUT,
            current: INPUT,
            supply: INPUT,
            measured: Field::UNREAD,
        }
    };
}

/// The keys of an input: which it is, the gain before it, the offset after that.
macro_rules! input {
    (
        $(#[doc = $doc:literal])+
        $name:literal = $field:ident, $default:literal;
        $gain:literal in $per:literal; $offset:literal in $unit:literal
    ) => {
        keys! {
            LinuxChannel;
            $(#[doc = $doc])+
            $name = at($field.name), text("a converter and its input", MAX_PATH), Computed($default);
            /// What a volt or ampere at the converter stands for: the divider, amplifier or shunt before it.
            $gain = at($field.gain), number(si($per), -1e6, 1e6), Number(1.0);
            /// Added to that.
            $offset = at($field.offset), number(si($unit), -1e3, 1e3), Number(0.0);
        }
    };
}

/// Keys of `[channel.linux]`.
pub(crate) fn channel() -> Section<LinuxChannel> {
    Section {
        table: "channel.linux",
        about: "Where the channel is among Linux's outputs and inputs, with kind `linux` of the backend. A converter goes by its \
                number (`iio:device0`), its name or label where no other has it, or its place on the bus (`1-0041`), a chip by \
                its number (`pwmchip0`) or its place; `sinew doctor` lists them.",
        optional: false,
        keys: [
            keys! {
                LinuxChannel;
                /// Its output: the chip, a slash, and the output's number, such as `pwmchip0/1` or `1-0040/1`.
                "pwm" = at(pwm), text("a chip and its output", MAX_PATH),
                    Computed("none: **required** with kind `linux`");
                /// Which level heats: high, or low.
                "polarity" = at(polarity), Polarity::KIND, Polarity::DEFAULT;
            },
            input! {
                /// The first tap's input, such as `1-0048:in_voltage0`.
                "v1" = v1, "none: **required** with kind `linux` and taps";
                "v1_gain" in "V/V"; "v1_offset_v" in "V"
            },
            input! {
                /// The second tap's.
                "v2" = v2, "none: **required** with kind `linux` and taps";
                "v2_gain" in "V/V"; "v2_offset_v" in "V"
            },
            input! {
                /// The moving end's.
                "v3" = v3, "none: **required** with kind `linux`";
                "v3_gain" in "V/V"; "v3_offset_v" in "V"
            },
            input! {
                /// The current's: a current, or the voltage across a shunt with 1/Ω as its gain.
                "current" = current, "none: **required** with kind `linux`";
                "current_gain" in "A/V or A/A"; "current_offset_a" in "A"
            },
            input! {
                /// The supply's.
                "supply" = supply, "not measured";
                "supply_gain" in "V/V"; "supply_offset_v" in "V"
            },
            keys! {
                LinuxChannel;
                /// When gains and offsets were measured, and against what: `sinew bringup` writes it with them.
                "measured" = at(measured), text("a date and what it was measured against", MAX_PATH), Computed("not measured");
            },
        ]
        .into_iter()
        .flatten()
        .collect(),
        check: None,
    }
}
