//! Every key of the rig file: its name, unit, range, default, meaning, and where it lives in the rig.
//!
//! One table serves the reader, the writer, the fits' parameters and the reference in `docs/rig.md`
//! (a test compares them), so that none of the four can say something else.

use sinew_physics::{Convection, DriveKind, Kinetics, Load, Mixing, Taps};

use crate::types::*;

/// A table of the rig file whose keys live in `T` (the rig or a channel).
pub(crate) struct Section<T: 'static> {
    /// As in the header, such as `channel.wire`.
    pub table: &'static str,
    /// What it is for.
    pub about: &'static str,
    /// Where the table is left out, its defaults do not apply either.
    pub optional: bool,
    pub keys: &'static [Key<T>],
}

/// One key. `get` and `set` work in SI.
pub(crate) struct Key<T> {
    pub name: &'static str,
    pub kind: Kind,
    pub default: Default,
    pub about: &'static str,
    pub get: fn(&T) -> Option<Value>,
    pub set: fn(&mut T, Value),
}

/// What a key takes; ranges are inclusive and in the key's own unit.
pub(crate) enum Kind {
    Number {
        unit: &'static str,
        scale: Scale,
        low: f64,
        high: f64,
    },
    Integer {
        low: i64,
        high: i64,
    },
    Boolean,
    Choice(&'static [&'static str]),
    Name {
        longest: usize,
    },
    /// Any text without control characters; the words say what it names.
    Text {
        what: &'static str,
        longest: usize,
    },
}

/// What holds where a key is not given.
pub(crate) enum Default {
    /// It must be given; the words say what.
    Required(&'static str),
    /// In the key's own unit.
    Number(f64),
    Integer(i64),
    Text(&'static str),
    /// Computed from other keys as the words say.
    Computed(&'static str),
}

/// A value in SI on its way between text and rig.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Integer(i64),
    Boolean(bool),
    Text(String),
}

/// From the key's unit to SI: times `mul`, divided by `div`. One of the two is always 1,
/// and dividing by a power of ten (rather than multiplying by its inexact inverse) gives the
/// double nearest to the decimal that was written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    mul: f64,
    div: f64,
}

impl Scale {
    const fn times(mul: f64) -> Scale {
        Scale { mul, div: 1.0 }
    }

    const fn over(div: f64) -> Scale {
        Scale { mul: 1.0, div }
    }

    pub(crate) fn to_si(self, in_file: f64) -> f64 {
        in_file * self.mul / self.div
    }

    /// The shortest decimal that reads back as exactly `si`, or the nearest double where there is none.
    pub(crate) fn to_file(self, si: f64) -> f64 {
        let guess = si / self.mul * self.div;
        (0..17)
            .filter_map(|digits| format!("{guess:.digits$e}").parse::<f64>().ok())
            .find(|v| self.to_si(*v) == si)
            .unwrap_or(guess)
    }
}

const SAME: Scale = Scale::times(1.0);
const MILLI: Scale = Scale::over(1e3);
const GIGA: Scale = Scale::times(1e9);
const MEGA: Scale = Scale::times(1e6);
const PER_MEGA: Scale = Scale::over(1e6);
const UOHM_CM: Scale = Scale::over(1e8);
const PER_MILLI: Scale = Scale::times(1e3);

macro_rules! number {
    ($name:literal, $unit:literal, $scale:expr, $low:literal .. $high:literal, $default:expr, $about:literal,
     $of:ident . $($field:ident).+) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: $unit, scale: $scale, low: $low, high: $high },
            default: $default,
            about: $about,
            get: |$of| Some(Value::Number($of.$($field).+)),
            set: |$of, value| {
                if let Value::Number(n) = value {
                    $of.$($field).+ = n;
                }
            },
        }
    };
}

macro_rules! optional_number {
    ($name:literal, $unit:literal, $scale:expr, $low:literal .. $high:literal, $default:expr, $about:literal,
     $of:ident . $($field:ident).+) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: $unit, scale: $scale, low: $low, high: $high },
            default: $default,
            about: $about,
            get: |$of| $of.$($field).+.map(Value::Number),
            set: |$of, value| {
                if let Value::Number(n) = value {
                    $of.$($field).+ = Some(n);
                }
            },
        }
    };
}

macro_rules! choice {
    ($name:literal, [$(($word:literal, $variant:expr)),+ $(,)?], $default:expr, $about:literal,
     $of:ident . $($field:ident).+) => {
        Key {
            name: $name,
            kind: Kind::Choice(&[$($word),+]),
            default: $default,
            about: $about,
            get: |$of| [$(($word, $variant)),+]
                .into_iter()
                .find(|(_, v)| *v == $of.$($field).+)
                .map(|(word, _)| Value::Text(word.into())),
            set: |$of, value| {
                let Value::Text(text) = value else { return };
                if let Some((_, v)) = [$(($word, $variant)),+].into_iter().find(|(word, _)| *word == text) {
                    $of.$($field).+ = v;
                }
            },
        }
    };
}

/// A number that only some laws take, see [`Algorithm::takes`].
macro_rules! law_number {
    ($name:literal, $unit:literal, $scale:expr, $low:literal .. $high:literal, $default:expr, $about:literal,
     $field:ident) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: $unit, scale: $scale, low: $low, high: $high },
            default: $default,
            about: $about,
            get: |c| {
                let taken = c.control.algorithm.takes($name);
                if taken { Option::from(c.control.$field).map(Value::Number) } else { None }
            },
            set: |c, value| {
                if let Value::Number(n) = value {
                    c.control.$field = n.into();
                }
            },
        }
    };
}

macro_rules! load_number {
    ($name:literal, $unit:literal, $low:literal .. $high:literal, $default:expr, $about:literal, $field:ident) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: $unit, scale: SAME, low: $low, high: $high },
            default: $default,
            about: $about,
            get: |c| match c.model.load {
                Load::SpringMassDamper { $field, .. } => Some(Value::Number($field)),
                _ => None,
            },
            set: |c, value| {
                if let (Load::SpringMassDamper { $field, .. }, Value::Number(n)) = (&mut c.model.load, value) {
                    *$field = n;
                }
            },
        }
    };
}

macro_rules! skew {
    ($name:literal, $field:ident, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: "1", scale: SAME, low: 0.05, high: 20.0 },
            default: Default::Number(1.0),
            about: $about,
            get: |c| match c.model.material.kinetics {
                Kinetics::Richards { $field, .. } => Some(Value::Number($field)),
                _ => None,
            },
            set: |c, value| {
                if let (Kinetics::Richards { $field, .. }, Value::Number(n)) = (&mut c.model.material.kinetics, value) {
                    *$field = n;
                }
            },
        }
    };
}

/// Where a channel's input is: its name, the gain before it, the offset after that.
macro_rules! linux_input {
    ($name:literal, $gain:literal, $offset:literal, $per:literal, $unit:literal, $default:literal, $about:literal, $field:ident) => {
        [
            Key {
                name: $name,
                kind: Kind::Text { what: "a converter and its input", longest: MAX_PATH },
                default: Default::Computed($default),
                about: $about,
                get: |c: &Channel| c.linux.$field.name.clone().map(Value::Text),
                set: |c: &mut Channel, value| {
                    if let Value::Text(name) = value {
                        c.linux.$field.name = Some(name);
                    }
                },
            },
            number!(
                $gain,
                $per,
                SAME,
                -1e6..1e6,
                Default::Number(1.0),
                "What a volt or ampere at the converter stands for: the divider, amplifier or shunt before it",
                c.linux.$field.gain
            ),
            number!($offset, $unit, SAME, -1e3..1e3, Default::Number(0.0), "Added to that", c.linux.$field.offset),
        ]
    };
}

macro_rules! noise {
    ($name:literal, $unit:literal, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Number { unit: $unit, scale: SAME, low: 1e-12, high: 1e6 },
            default: Default::Computed("estimated from the recording"),
            about: $about,
            get: |c| c.noise.get($name).copied().map(Value::Number),
            set: |c, value| {
                if let Value::Number(n) = value {
                    c.noise.insert($name.into(), n);
                }
            },
        }
    };
}

/// A load whose numbers are still to be read.
pub(crate) const UNREAD_LOAD: Load =
    Load::SpringMassDamper { mass_kg: f64::NAN, damping_n_s_per_m: f64::NAN, spring_n_per_m: 0.0, preload_n: f64::NAN };

/// A backend whose tables are still to be read.
pub(crate) const UNREAD_BACKEND: Backend = Backend {
    kind: BackendKind::Simulated,
    serial: SerialLine { port: None, baud_hz: 0, watchdog_periods: 0 },
    linux: LinuxInterfaces {
        root: String::new(),
        sampling: LinuxSampling::Buffer,
        trigger: None,
        phase: LinuxPhase::Synchronised,
        guard_ms: 0,
    },
};

/// The place of a channel among Linux's outputs and inputs that is still to be read.
pub(crate) const UNREAD_LINUX: LinuxChannel = {
    const UNREAD: LinuxInput = LinuxInput { name: None, gain: f64::NAN, offset: f64::NAN };
    LinuxChannel {
        pwm: None,
        polarity: Polarity::Normal,
        v1: UNREAD,
        v2: UNREAD,
        v3: UNREAD,
        current: UNREAD,
        supply: UNREAD,
    }
};

/// A black box whose keys are still to be read.
pub(crate) const UNREAD_BLACK_BOX: BlackBox =
    BlackBox { enabled: true, before_s: f64::NAN, after_s: f64::NAN, keep: 0, memory_bytes: 0 };

/// A machine whose numbers are still to be read.
pub(crate) const UNREAD_MACHINE: Machine = Machine {
    rate_hz: f64::NAN,
    travel_m: f64::NAN,
    microstep_m: f64::NAN,
    max_speed_m_s: f64::NAN,
    max_acceleration_m_s2: f64::NAN,
    compliance_m_per_n: f64::NAN,
    max_force_n: f64::NAN,
    force_rate_hz: f64::NAN,
    force_noise_n: f64::NAN,
    max_strain: f64::NAN,
    heater_supply_v: f64::NAN,
    heater_cutoff_hz: f64::NAN,
    current_step_a: f64::NAN,
    current_noise_a: f64::NAN,
    voltage_step_v: f64::NAN,
    voltage_noise_v: f64::NAN,
    chamber_min_c: f64::NAN,
    chamber_max_c: f64::NAN,
    chamber_power_w: f64::NAN,
    chamber_time_s: f64::NAN,
    chamber_noise_k: f64::NAN,
};

/// The table whose keys are columns of recordings.
pub(crate) const NOISE: &str = "channel.sensors.noise";

/// Keys of `[rig]`.
pub(crate) static RIG: Section<Rig> = Section {
    table: "rig",
    about: "The rig as a whole. Required.",
    optional: false,
    keys: &[
        Key {
            name: "name",
            kind: Kind::Name { longest: MAX_RIG_NAME },
            default: Default::Required("a name such as \"tensile-bench\""),
            about: "Name of the rig: clients find the driver by it. Letters, digits, `-`, `_` and `.`, \
                    a letter or digit first, at most 48",
            get: |r| Some(Value::Text(r.name.clone())),
            set: |r, value| {
                if let Value::Text(name) = value {
                    r.name = name;
                }
            },
        },
        number!(
            "rate_hz",
            "Hz",
            SAME,
            0.001..20_000.0,
            Default::Number(1000.0),
            "PWM, sampling and control rate. The driver needs at least 10 Hz; recordings may be slower",
            r.rate_hz
        ),
        number!(
            "ambient_c",
            "°C",
            SAME,
            -200.0..800.0,
            Default::Number(25.0),
            "Temperature of the air, where a recording does not give it",
            r.ambient_c
        ),
        choice!(
            "realtime",
            [("off", RealtimeMode::Off), ("try", RealtimeMode::Try), ("strict", RealtimeMode::Strict)],
            Default::Text("try"),
            "Real-time scheduling: ask and go on without (`try`), refuse to start without (`strict`), do not ask (`off`)",
            r.realtime.mode
        ),
        Key {
            name: "realtime_priority",
            kind: Kind::Integer { low: 1, high: 98 },
            default: Default::Integer(80),
            about: "SCHED_FIFO priority of the loop (99 belongs to the kernel)",
            get: |r| Some(Value::Integer(r.realtime.priority.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.realtime.priority = i as u32;
                }
            },
        },
        Key {
            name: "realtime_cpu",
            kind: Kind::Integer { low: 0, high: 4095 },
            default: Default::Computed("the driver chooses"),
            about: "Core the loop is pinned to",
            get: |r| r.realtime.cpu.map(|cpu| Value::Integer(cpu.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.realtime.cpu = Some(i as u32);
                }
            },
        },
    ],
};

macro_rules! channel_name {
    ($name:literal, $field:ident, $default:literal, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Name { longest: MAX_CHANNEL_NAME },
            default: Default::Required($default),
            about: $about,
            get: |j| Some(Value::Text(j.$field.clone())),
            set: |j, value| {
                if let Value::Text(name) = value {
                    j.$field = name;
                }
            },
        }
    };
}

/// Keys of `[[joint]]`.
pub(crate) static JOINT: Section<Joint> = Section {
    table: "joint",
    about: "Two channels whose wires turn one joint against each other: J θ̈ + B θ̇ + K θ = r (agonist − antagonist) + torque, θ in rad, \
            positive where the agonist is shorter. Their wires have no load of their own: leave `[channel.load]` out.",
    optional: false,
    keys: &[
        channel_name!("name", name, "a name such as \"knee\"", "Name of the joint, as unique as a channel's"),
        channel_name!("agonist", agonist, "the name of a channel", "Channel whose wire turns it forward"),
        channel_name!("antagonist", antagonist, "the name of a channel", "Channel whose wire turns it back"),
        number!(
            "radius_mm",
            "mm",
            MILLI,
            0.01..10_000.0,
            Default::Required("the lever the wires pull at in mm, such as 8.0"),
            "Lever r of both wires",
            j.mechanics.radius_m
        ),
        number!(
            "inertia_kg_mm2",
            "kg mm²",
            PER_MEGA,
            1e-6..1e9,
            Default::Required("the moment of inertia in kg mm², such as 2.5"),
            "Moment of inertia J; at least so much that the joint swings on its wires with no more than 3 kHz",
            j.mechanics.inertia_kg_m2
        ),
        number!(
            "damping_n_mm_s",
            "N mm s",
            MILLI,
            0.0..1e9,
            Default::Computed("0.3 of critical damping on both wires at their stiffest"),
            "Damping B, torque per rad/s",
            j.mechanics.damping_n_m_s
        ),
        number!(
            "spring_n_mm",
            "N mm",
            MILLI,
            0.0..1e9,
            Default::Number(0.0),
            "Spring K towards θ = 0, torque per rad",
            j.mechanics.spring_n_m
        ),
        number!(
            "torque_n_mm",
            "N mm",
            MILLI,
            -1e9..1e9,
            Default::Number(0.0),
            "A torque that always acts, positive in the agonist's direction",
            j.mechanics.torque_n_m
        ),
        number!(
            "pretension_n",
            "N",
            SAME,
            0.0..1e5,
            Default::Computed("100 MPa in the thinner wire"),
            "How taut the pair is mounted: tension at the ends of its way, where one wire is wholly hot and the other wholly cold",
            j.mechanics.pretension_n
        ),
        number!(
            "minimum_tension_n",
            "N",
            SAME,
            0.0..1e5,
            Default::Computed("half of `pretension_n`"),
            "Anti-slack: a wire whose estimated tension falls below it is heated",
            j.min_tension_n
        ),
        number!(
            "tension_n",
            "N",
            SAME,
            0.0..1e5,
            Default::Computed("twice `pretension_n`, or `maximum_tension_n` where that is less"),
            "Tension that is kept where the motion leaves it free",
            j.tension_n
        ),
        number!(
            "maximum_tension_n",
            "N",
            SAME,
            0.0..1e5,
            Default::Computed("500 MPa in the thinner wire"),
            "Anti-overload: neither wire is heated further while the estimated tension is above it",
            j.max_tension_n
        ),
    ],
};

macro_rules! group {
    ($name:literal, $field:ident, $default:literal, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Name { longest: MAX_GROUP_NAME },
            default: Default::Computed($default),
            about: $about,
            get: |r| r.access.$field.clone().map(Value::Text),
            set: |r, value| {
                if let Value::Text(name) = value {
                    r.access.$field = Some(name);
                }
            },
        }
    };
}

/// Keys of `[access]`.
pub(crate) static ACCESS: Section<Rig> = Section {
    table: "access",
    about: "Which users besides the driver's own may look and command: see [access.md](access.md).",
    optional: false,
    keys: &[
        group!(
            "command_group",
            command_group,
            "nobody's",
            "Unix group whose members may command and look: its name or number"
        ),
        group!(
            "read_group",
            read_group,
            "those of `command_group`",
            "Unix group whose members may look, or `everyone`"
        ),
    ],
};

/// Keys of `[simulation]`; its faults are read apart.
pub(crate) static SIMULATION: Section<Rig> = Section {
    table: "simulation",
    about: "The simulated backend.",
    optional: false,
    keys: &[
        Key {
            name: "seed",
            kind: Kind::Integer { low: 0, high: i64::MAX },
            default: Default::Integer(1),
            about: "Seed of all noise: same seed, same run",
            get: |r| Some(Value::Integer(i64::try_from(r.simulation.seed).unwrap_or(i64::MAX))),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.simulation.seed = i as u64;
                }
            },
        },
        choice!(
            "pace",
            [("real_time", Pace::RealTime), ("as_fast_as_possible", Pace::AsFastAsPossible)],
            Default::Text("real_time"),
            "Whether simulated time keeps to the clock",
            r.simulation.pace
        ),
    ],
};

/// Keys of `[backend]`. Another backend is one more word here, a table `[backend.NAME]` below, listed in [`OF_RIG`], and,
/// where channels have to be told apart, a table `[channel.NAME]` in [`CHANNEL`].
pub(crate) static BACKEND: Section<Rig> = Section {
    table: "backend",
    about: "What powers and measures the wires.",
    optional: false,
    keys: &[choice!(
        "kind",
        [("simulated", BackendKind::Simulated), ("serial", BackendKind::Serial), ("linux", BackendKind::Linux)],
        Default::Text("simulated"),
        "Simulated wires, a front-end on a serial line: [front-end](front-end.md), or Linux's own PWM outputs and converters: \
         [Linux](linux-backend.md)",
        r.backend.kind
    )],
};

/// Keys of `[backend.serial]`.
pub(crate) static BACKEND_SERIAL: Section<Rig> = Section {
    table: "backend.serial",
    about: "The line to a front-end, with kind `serial`.",
    optional: false,
    keys: &[
        Key {
            name: "port",
            kind: Kind::Text { what: "a device", longest: MAX_PATH },
            default: Default::Computed("none: **required** with kind `serial`"),
            about: "The device it is on, such as `/dev/ttyACM0` or, better, its name in `/dev/serial/by-id`",
            get: |r| r.backend.serial.port.clone().map(Value::Text),
            set: |r, value| {
                if let Value::Text(port) = value {
                    r.backend.serial.port = Some(port);
                }
            },
        },
        Key {
            name: "baud_hz",
            kind: Kind::Integer { low: 9600, high: 12_000_000 },
            default: Default::Integer(2_000_000),
            about: "Bits a second of a UART; USB takes no notice of it",
            get: |r| Some(Value::Integer(r.backend.serial.baud_hz.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.backend.serial.baud_hz = i as u32;
                }
            },
        },
        Key {
            name: "watchdog_periods",
            kind: Kind::Integer { low: 2, high: 1000 },
            default: Default::Integer(5),
            about: "Periods without a good frame after which the front-end switches its outputs off by itself, and after \
                    which the driver calls the front-end silent",
            get: |r| Some(Value::Integer(r.backend.serial.watchdog_periods.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.backend.serial.watchdog_periods = i as u32;
                }
            },
        },
    ],
};

/// Keys of `[backend.linux]`.
pub(crate) static BACKEND_LINUX: Section<Rig> = Section {
    table: "backend.linux",
    about: "Linux's own PWM outputs and converters, with kind `linux`: [Linux](linux-backend.md).",
    optional: false,
    keys: &[
        choice!(
            "sampling",
            [("buffer", LinuxSampling::Buffer), ("sysfs", LinuxSampling::Sysfs)],
            Default::Text("buffer"),
            "From `/dev/iio:deviceN`, which the converter fills by itself, or input by input from sysfs within the cycle",
            r.backend.linux.sampling
        ),
        choice!(
            "phase",
            [("synchronised", LinuxPhase::Synchronised), ("free", LinuxPhase::Free)],
            Default::Text("synchronised"),
            "What moment a conversion is of: hardware sees to it that it is of an on-phase (a trigger from the PWM, a \
             sample-and-hold gated by it), or any, and the newest that shows the on-phase is taken",
            r.backend.linux.phase
        ),
        Key {
            name: "trigger",
            kind: Kind::Text { what: "a trigger's name", longest: MAX_PATH },
            default: Default::Computed("the one the converter has, or none"),
            about: "Name of the IIO trigger that the converters are set to",
            get: |r| r.backend.linux.trigger.clone().map(Value::Text),
            set: |r, value| {
                if let Value::Text(trigger) = value {
                    r.backend.linux.trigger = Some(trigger);
                }
            },
        },
        Key {
            name: "guard_ms",
            kind: Kind::Integer { low: 20, high: 1000 },
            default: Default::Integer(100),
            about: "The driver's silence, in ms, after which the guard puts all outputs to zero; at least 4 periods. A driver \
                    that is gone is noticed at once",
            get: |r| Some(Value::Integer(r.backend.linux.guard_ms.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.backend.linux.guard_ms = i as u32;
                }
            },
        },
        Key {
            name: "root",
            kind: Kind::Text { what: "a folder", longest: MAX_PATH },
            default: Default::Text("/"),
            about: "The folder `sys` and `dev` are in: another one for tests",
            get: |r| Some(Value::Text(r.backend.linux.root.clone())),
            set: |r, value| {
                if let Value::Text(root) = value {
                    r.backend.linux.root = root;
                }
            },
        },
    ],
};

/// Keys of `[black_box]`.
pub(crate) static BLACK_BOX: Section<Rig> = Section {
    table: "black_box",
    about: "The last seconds before a fault is latched, and what follows, in a file: [black box](recording-sessions.md#the-black-box).",
    optional: false,
    keys: &[
        Key {
            name: "enabled",
            kind: Kind::Boolean,
            default: Default::Computed("`true`"),
            about: "Whether there is one",
            get: |r| Some(Value::Boolean(r.black_box.enabled)),
            set: |r, value| {
                if let Value::Boolean(on) = value {
                    r.black_box.enabled = on;
                }
            },
        },
        number!(
            "before_s",
            "s",
            SAME,
            0.1..600.0,
            Default::Number(10.0),
            "Time before the fault; less where `memory_mb` does not hold it",
            r.black_box.before_s
        ),
        number!(
            "after_s",
            "s",
            SAME,
            0.0..60.0,
            Default::Number(1.0),
            "Time after it; faults latched meanwhile are in the same file",
            r.black_box.after_s
        ),
        Key {
            name: "keep",
            kind: Kind::Integer { low: 1, high: 10_000 },
            default: Default::Integer(20),
            about: "Files of this rig that are kept, the newest",
            get: |r| Some(Value::Integer(r.black_box.keep.into())),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.black_box.keep = i as u32;
                }
            },
        },
        Key {
            name: "memory_mb",
            kind: Kind::Integer { low: 1, high: 65_536 },
            default: Default::Integer(256),
            about: "Most memory it takes, MB: 11 s of 64 channels at 2 kHz are 237",
            get: |r| Some(Value::Integer((r.black_box.memory_bytes / 1_000_000) as i64)),
            set: |r, value| {
                if let Value::Integer(i) = value {
                    r.black_box.memory_bytes = i as u64 * 1_000_000;
                }
            },
        },
    ],
};

/// The plain tables of the rig as a whole, but for `[rig]` itself.
pub(crate) static OF_RIG: [&Section<Rig>; 7] =
    [&ACCESS, &BACKEND, &BACKEND_SERIAL, &BACKEND_LINUX, &BLACK_BOX, &SIMULATION, &MACHINE];

/// Keys of `[channel.linux]`.
static LINUX_PLACES: [Key<Channel>; 17] = {
    let [v1, v1_gain, v1_offset] = linux_input!(
        "v1",
        "v1_gain",
        "v1_offset_v",
        "V/V",
        "V",
        "none: **required** with kind `linux` and taps",
        "The first tap's input, such as `1-0048:in_voltage0`",
        v1
    );
    let [v2, v2_gain, v2_offset] = linux_input!(
        "v2",
        "v2_gain",
        "v2_offset_v",
        "V/V",
        "V",
        "none: **required** with kind `linux` and taps",
        "The second tap's",
        v2
    );
    let [v3, v3_gain, v3_offset] = linux_input!(
        "v3",
        "v3_gain",
        "v3_offset_v",
        "V/V",
        "V",
        "none: **required** with kind `linux`",
        "The moving end's",
        v3
    );
    let [current, current_gain, current_offset] = linux_input!(
        "current",
        "current_gain",
        "current_offset_a",
        "A/V or A/A",
        "A",
        "none: **required** with kind `linux`",
        "The current's: a current, or the voltage across a shunt with 1/Ω as its gain",
        current
    );
    let [supply, supply_gain, supply_offset] =
        linux_input!("supply", "supply_gain", "supply_offset_v", "V/V", "V", "not measured", "The supply's", supply);
    [
        Key {
            name: "pwm",
            kind: Kind::Text { what: "a chip and its output", longest: MAX_PATH },
            default: Default::Computed("none: **required** with kind `linux`"),
            about: "Its output: the chip, a slash, and the output's number, such as `pwmchip0/1` or `1-0040/1`",
            get: |c| c.linux.pwm.clone().map(Value::Text),
            set: |c, value| {
                if let Value::Text(pwm) = value {
                    c.linux.pwm = Some(pwm);
                }
            },
        },
        choice!(
            "polarity",
            [("normal", Polarity::Normal), ("inversed", Polarity::Inversed)],
            Default::Text("normal"),
            "Which level heats: high, or low",
            c.linux.polarity
        ),
        v1,
        v1_gain,
        v1_offset,
        v2,
        v2_gain,
        v2_offset,
        v3,
        v3_gain,
        v3_offset,
        current,
        current_gain,
        current_offset,
        supply,
        supply_gain,
        supply_offset,
    ]
};

/// Keys of `[machine]`.
pub(crate) static MACHINE: Section<Rig> = Section {
    table: "machine",
    about: "The tensile testing machine that `sinew test` mounts a wire in: cross-head, load cell, heater amplifier, thermal \
            chamber. The defaults are those of the thesis' machine (chapter 8, table 9).",
    optional: false,
    keys: &[
        number!(
            "rate_hz",
            "Hz",
            SAME,
            10.0..1000.0,
            Default::Number(160.0),
            "Rate of the machine's own loop and of its recordings. A multiple of the load cell's gives every conversion a row of its own",
            r.machine.rate_hz
        ),
        number!(
            "travel_mm",
            "mm",
            MILLI,
            1.0..2000.0,
            Default::Number(250.0),
            "How far the cross-head travels; the wire is mounted so that half of it is left",
            r.machine.travel_m
        ),
        number!(
            "microstep_um",
            "µm",
            PER_MEGA,
            0.001..1000.0,
            Default::Number(0.625),
            "Smallest motion of the cross-head",
            r.machine.microstep_m
        ),
        number!(
            "max_speed_mm_per_s",
            "mm/s",
            MILLI,
            0.01..5000.0,
            Default::Number(400.0),
            "Fastest cross-head",
            r.machine.max_speed_m_s
        ),
        number!(
            "max_acceleration_mm_per_s2",
            "mm/s²",
            MILLI,
            1.0..1000000.0,
            Default::Number(5000.0),
            "Quickest change of its speed",
            r.machine.max_acceleration_m_s2
        ),
        number!(
            "compliance_um_per_n",
            "µm/N",
            PER_MEGA,
            0.0..1000.0,
            Default::Number(0.204),
            "By how much the frame gives: 0.01 mm under 5 kg. Known, and taken out of the measured position",
            r.machine.compliance_m_per_n
        ),
        number!(
            "max_force_n",
            "N",
            SAME,
            0.01..10000.0,
            Default::Number(49.0),
            "Largest force of the load cell; a routine ends above it",
            r.machine.max_force_n
        ),
        number!(
            "force_rate_hz",
            "Hz",
            SAME,
            1.0..10000.0,
            Default::Number(80.0),
            "Conversions of the load cell a second",
            r.machine.force_rate_hz
        ),
        number!(
            "force_noise_n",
            "N",
            SAME,
            0.0..100.0,
            Default::Number(0.00736),
            "Noise of a conversion, RMS: 0.75 g for the cell of 5 kg, 0.15 g (0.00147) for that of 1 kg",
            r.machine.force_noise_n
        ),
        number!(
            "max_strain",
            "1",
            SAME,
            0.0001..1.0,
            Default::Number(0.08),
            "Largest elongation as a share of the wire's length; a routine ends above it",
            r.machine.max_strain
        ),
        number!(
            "heater_supply_v",
            "V",
            SAME,
            0.1..1000.0,
            Default::Number(12.0),
            "Largest voltage of the heater amplifier",
            r.machine.heater_supply_v
        ),
        number!(
            "heater_cutoff_hz",
            "Hz",
            SAME,
            0.1..100000.0,
            Default::Number(40.0),
            "Cut-off of the filter before the amplifier",
            r.machine.heater_cutoff_hz
        ),
        number!(
            "current_step_a",
            "A",
            SAME,
            0.0..1.0,
            Default::Number(0.0001),
            "Step of the measured current",
            r.machine.current_step_a
        ),
        number!(
            "current_noise_a",
            "A",
            SAME,
            0.0..1.0,
            Default::Number(0.00005),
            "Noise of the measured current, averaged over a row, RMS",
            r.machine.current_noise_a
        ),
        number!(
            "voltage_step_v",
            "V",
            SAME,
            0.0..1.0,
            Default::Number(0.004),
            "Step of the measured voltages",
            r.machine.voltage_step_v
        ),
        number!(
            "voltage_noise_v",
            "V",
            SAME,
            0.0..1.0,
            Default::Number(0.002),
            "Noise of the measured voltages, averaged over a row, RMS",
            r.machine.voltage_noise_v
        ),
        number!(
            "chamber_min_c",
            "°C",
            SAME,
            -200.0..800.0,
            Default::Number(0.0),
            "Coldest the thermal chamber gets",
            r.machine.chamber_min_c
        ),
        number!(
            "chamber_max_c",
            "°C",
            SAME,
            -200.0..800.0,
            Default::Number(95.0),
            "Warmest it gets",
            r.machine.chamber_max_c
        ),
        number!(
            "chamber_power_w",
            "W",
            SAME,
            0.0..100000.0,
            Default::Number(80.0),
            "Heat that its thermo-electric elements pump either way",
            r.machine.chamber_power_w
        ),
        number!(
            "chamber_time_s",
            "s",
            SAME,
            0.1..100000.0,
            Default::Number(150.0),
            "Time constant of the chamber left to itself",
            r.machine.chamber_time_s
        ),
        number!(
            "chamber_noise_k",
            "K",
            SAME,
            0.0..10.0,
            Default::Number(0.1),
            "Noise of its thermocouple, which is read 10 times a second in steps of 0.25 K, RMS",
            r.machine.chamber_noise_k
        ),
    ],
};

/// Every table of a channel that is a plain list of keys.
pub(crate) static CHANNEL: &[Section<Channel>] = &[
    Section {
        table: "channel",
        about: "One wire each: `[[channel]]`, at least one and at most 64. Its own tables follow it.",
        optional: false,
        keys: &[Key {
            name: "name",
            kind: Kind::Name { longest: MAX_CHANNEL_NAME },
            default: Default::Required("a name such as \"wire\""),
            about: "Name of the channel, unique in the rig. Letters, digits, `-`, `_` and `.`, a letter or digit first, \
                    at most 32",
            get: |c| Some(Value::Text(c.name.clone())),
            set: |c, value| {
                if let Value::Text(name) = value {
                    c.name = name;
                }
            },
        }],
    },
    Section {
        table: "channel.wire",
        about: "The wire's size. Required.",
        optional: false,
        keys: &[
            number!(
                "diameter_mm",
                "mm",
                MILLI,
                0.005..10.0,
                Default::Required("the wire's diameter in mm, such as 0.125"),
                "Diameter d",
                c.model.geometry.diameter_m
            ),
            number!(
                "length_mm",
                "mm",
                MILLI,
                1.0..100_000.0,
                Default::Required("the wire's hot, unloaded length in mm, such as 160.0"),
                "Hot and unloaded length L_0",
                c.model.geometry.length_m
            ),
        ],
    },
    Section {
        table: "channel.taps",
        about: "The dual measurement (eq. 42–44). Leave the table out where there is none.",
        optional: true,
        keys: &[
            Key {
                name: "l0_mm",
                kind: Kind::Number { unit: "mm", scale: MILLI, low: 0.0, high: 100_000.0 },
                default: Default::Number(0.0),
                about: "Position of the first tap from the fixed end; on the wire",
                get: |c| c.model.taps.map(|t| Value::Number(t.l0_m)),
                set: |c, value| {
                    if let Value::Number(n) = value {
                        c.model.taps.get_or_insert(Taps { l0_m: 0.0, ls_m: f64::NAN }).l0_m = n;
                    }
                },
            },
            Key {
                name: "ls_mm",
                kind: Kind::Number { unit: "mm", scale: MILLI, low: 0.001, high: 100_000.0 },
                default: Default::Required("the distance between the taps in mm, such as 150.0"),
                about: "Distance from the first to the second tap; `l0_mm` + `ls_mm` must lie on the wire",
                get: |c| c.model.taps.map(|t| Value::Number(t.ls_m)),
                set: |c, value| {
                    if let Value::Number(n) = value {
                        c.model.taps.get_or_insert(Taps { l0_m: 0.0, ls_m: f64::NAN }).ls_m = n;
                    }
                },
            },
        ],
    },
    Section {
        table: "channel.drive",
        about: "What heats the wire.",
        optional: false,
        keys: &[
            choice!(
                "kind",
                [
                    ("pwm", DriveKind::Pwm),
                    ("power", DriveKind::Power),
                    ("current", DriveKind::Current),
                    ("temperature", DriveKind::Temperature),
                ],
                Default::Text("pwm"),
                "What the input is: `duty` of the supply, `power_w` into the wire, a steady `current_a`, or an imposed \
                 `temperature_c`",
                c.model.drive.kind
            ),
            number!(
                "supply_v",
                "V",
                SAME,
                0.0..1000.0,
                Default::Computed("required with kind `pwm`, else 0"),
                "Supply voltage; the driver needs more than 0",
                c.model.drive.supply_v
            ),
            number!(
                "shunt_ohm",
                "Ω",
                SAME,
                0.0..1000.0,
                Default::Number(0.0),
                "Current shunt",
                c.model.drive.shunt_ohm
            ),
            number!(
                "switch_ohm",
                "Ω",
                SAME,
                0.0..1000.0,
                Default::Number(0.0),
                "Switch in its on state",
                c.model.drive.switch_ohm
            ),
            number!(
                "lead_ohm",
                "Ω",
                SAME,
                0.0..1000.0,
                Default::Number(0.0),
                "Leads outside the taps",
                c.model.drive.lead_ohm
            ),
        ],
    },
    Section {
        table: "channel.load",
        about: "What the moving end pulls against: M ẍ + B ẋ + K x = preload + external − tension (eq. 51).",
        optional: false,
        keys: &[
            Key {
                name: "kind",
                kind: Kind::Choice(&["spring_mass_damper", "imposed_position", "imposed_force"]),
                default: Default::Text("spring_mass_damper"),
                about: "A load in motion, or `position_m` or `force_n` as an input; the other keys belong to the first",
                get: |c| {
                    Some(Value::Text(
                        match c.model.load {
                            Load::SpringMassDamper { .. } => "spring_mass_damper",
                            Load::ImposedPosition => "imposed_position",
                            Load::ImposedForce => "imposed_force",
                        }
                        .into(),
                    ))
                },
                set: |c, value| {
                    let Value::Text(kind) = value else { return };
                    c.model.load = match kind.as_str() {
                        "imposed_position" => Load::ImposedPosition,
                        "imposed_force" => Load::ImposedForce,
                        _ => UNREAD_LOAD,
                    };
                },
            },
            load_number!(
                "mass_kg",
                "kg",
                1e-6..1e4,
                Default::Computed("required with kind `spring_mass_damper`"),
                "Moving mass M",
                mass_kg
            ),
            load_number!("damping_n_s_per_m", "N s/m", 0.0..1e6, Default::Number(40.0), "Damping B", damping_n_s_per_m),
            load_number!(
                "spring_n_per_m",
                "N/m",
                0.0..1e7,
                Default::Number(0.0),
                "Spring K; 0 = a hanging mass",
                spring_n_per_m
            ),
            load_number!(
                "preload_n",
                "N",
                -1e5..1e5,
                Default::Computed("`mass_kg` × 9.80665 m/s²"),
                "Pull on the wire at its hot, unloaded length",
                preload_n
            ),
        ],
    },
    Section {
        table: "channel.sensors",
        about: "What the recordings' sensors are like.",
        optional: false,
        keys: &[choice!(
            "position_zero",
            [("known", PositionZero::Known), ("free", PositionZero::Free)],
            Default::Text("known"),
            "`free`: the encoder's zero is arbitrary and may differ from recording to recording",
            c.position_zero
        )],
    },
    Section {
        table: NOISE,
        about: "RMS noise of the recordings' measured columns, where it is known. A fit weighs each sensor by it.",
        optional: false,
        keys: &[
            noise!("current_a", "A", "Of the current"),
            noise!("v1_v", "V", "Of the first tap"),
            noise!("v2_v", "V", "Of the second tap"),
            noise!("v3_v", "V", "Of the moving end"),
            noise!("force_n", "N", "Of the wire tension"),
            noise!("position_m", "m", "Of the elongation"),
            noise!("temperature_c", "K", "Of the wire temperature"),
            noise!("power_w", "W", "Of the electrical power"),
        ],
    },
    Section {
        table: "channel.initial",
        about: "The state at the first sample.",
        optional: false,
        keys: &[
            optional_number!(
                "temperature_c",
                "°C",
                SAME,
                -273.15..800.0,
                Default::Computed("ambient, or the first imposed temperature"),
                "Wire temperature",
                c.model.initial.temperature_c
            ),
            number!(
                "martensite",
                "1",
                SAME,
                0.0..1.0,
                Default::Number(1.0),
                "Martensite fraction, clipped into the outer curves",
                c.model.initial.martensite
            ),
        ],
    },
    Section {
        table: "channel.material",
        about: "The alloy: the coefficients of the reference model and its alternatives.",
        optional: false,
        keys: &[
            number!(
                "austenite_modulus_gpa",
                "GPa",
                GIGA,
                1.0..300.0,
                Default::Number(75.0),
                "Young's modulus E_A",
                c.model.material.austenite_modulus_pa
            ),
            number!(
                "martensite_modulus_gpa",
                "GPa",
                GIGA,
                1.0..300.0,
                Default::Number(28.0),
                "Young's modulus E_M",
                c.model.material.martensite_modulus_pa
            ),
            number!(
                "transformation_strain",
                "1",
                SAME,
                0.0..0.15,
                Default::Number(0.04),
                "Largest shape-memory strain ε_L",
                c.model.material.transformation_strain
            ),
            number!(
                "thermoelastic_mpa_per_k",
                "MPa/K",
                MEGA,
                -5.0..5.0,
                Default::Number(0.55),
                "Thermoelastic coefficient θ; 0 = no thermal strain",
                c.model.material.thermoelastic_pa_per_k
            ),
            number!(
                "reference_temperature_c",
                "°C",
                SAME,
                -273.15..500.0,
                Default::Number(20.0),
                "T_0, from which thermal strain and resistivity are counted",
                c.model.material.reference_temperature_c
            ),
            number!(
                "austenite_temperature_c",
                "°C",
                SAME,
                -200.0..800.0,
                Default::Number(93.0),
                "Centre A of the transformation on heating, without stress",
                c.model.material.austenite_temperature_c
            ),
            number!(
                "martensite_temperature_c",
                "°C",
                SAME,
                -200.0..800.0,
                Default::Number(67.0),
                "Centre M of the transformation on cooling, without stress; not above A",
                c.model.material.martensite_temperature_c
            ),
            number!(
                "stress_shift_k_per_mpa",
                "K/MPa",
                PER_MEGA,
                0.0..1.0,
                Default::Number(0.125),
                "1/α: how far stress moves A and M; 0 = not at all",
                c.model.material.stress_shift_k_per_pa
            ),
            number!(
                "heating_steepness_per_k",
                "1/K",
                SAME,
                0.005..20.0,
                Default::Number(0.31),
                "k_A",
                c.model.material.heating_steepness_per_k
            ),
            number!(
                "cooling_steepness_per_k",
                "1/K",
                SAME,
                0.005..20.0,
                Default::Number(0.31),
                "k_M",
                c.model.material.cooling_steepness_per_k
            ),
            number!(
                "outer_loop_weight",
                "1",
                SAME,
                0.0..1.0,
                Default::Number(0.8),
                "w: 0 = implicit inner loop only, 1 = outer loop only",
                c.model.material.outer_loop_weight
            ),
            number!(
                "specific_heat_j_per_kg_k",
                "J/(kg K)",
                SAME,
                50.0..5000.0,
                Default::Number(836.0),
                "c_p",
                c.model.material.specific_heat_j_per_kg_k
            ),
            number!(
                "latent_heat_j_per_kg",
                "J/kg",
                SAME,
                0.0..200_000.0,
                Default::Number(24_200.0),
                "ΔH; 0 = left out",
                c.model.material.latent_heat_j_per_kg
            ),
            number!(
                "density_kg_per_m3",
                "kg/m³",
                SAME,
                1000.0..20_000.0,
                Default::Number(6450.0),
                "ρ_d",
                c.model.material.density_kg_per_m3
            ),
            number!(
                "convection_w_per_m2_k",
                "W/(m² K)",
                SAME,
                0.0..20_000.0,
                Default::Number(121.2),
                "h; not used with convection `natural`",
                c.model.material.convection_w_per_m2_k
            ),
            number!(
                "austenite_resistivity_uohm_cm",
                "µΩ cm",
                UOHM_CM,
                1.0..1000.0,
                Default::Number(86.5),
                "ρ_A0 at T_0",
                c.model.material.austenite_resistivity_ohm_m
            ),
            number!(
                "martensite_resistivity_uohm_cm",
                "µΩ cm",
                UOHM_CM,
                1.0..1000.0,
                Default::Number(75.0),
                "ρ_M0 at T_0",
                c.model.material.martensite_resistivity_ohm_m
            ),
            number!(
                "austenite_resistivity_slope_uohm_cm_per_k",
                "µΩ cm/K",
                UOHM_CM,
                -1.0..1.0,
                Default::Number(0.05),
                "α_A",
                c.model.material.austenite_resistivity_slope_ohm_m_per_k
            ),
            number!(
                "martensite_resistivity_slope_uohm_cm_per_k",
                "µΩ cm/K",
                UOHM_CM,
                -1.0..1.0,
                Default::Number(0.15),
                "α_M",
                c.model.material.martensite_resistivity_slope_ohm_m_per_k
            ),
            Key {
                name: "kinetics",
                kind: Kind::Choice(&["logistic", "linear", "square_root", "tanaka", "liang_rogers", "richards"]),
                default: Default::Text("logistic"),
                about: "Law of the outer curves (eq. 15–22); `logistic` is the reference",
                get: |c| {
                    Some(Value::Text(
                        match c.model.material.kinetics {
                            Kinetics::Logistic => "logistic",
                            Kinetics::Linear => "linear",
                            Kinetics::SquareRoot => "square_root",
                            Kinetics::Tanaka => "tanaka",
                            Kinetics::LiangRogers => "liang_rogers",
                            Kinetics::Richards { .. } => "richards",
                        }
                        .into(),
                    ))
                },
                set: |c, value| {
                    let Value::Text(law) = value else { return };
                    c.model.material.kinetics = match law.as_str() {
                        "linear" => Kinetics::Linear,
                        "square_root" => Kinetics::SquareRoot,
                        "tanaka" => Kinetics::Tanaka,
                        "liang_rogers" => Kinetics::LiangRogers,
                        "richards" => Kinetics::Richards { heating_skew: 1.0, cooling_skew: 1.0 },
                        _ => Kinetics::Logistic,
                    };
                },
            },
            skew!("heating_skew", heating_skew, "v_A of Richards' curves (eq. 21); only with kinetics `richards`"),
            skew!("cooling_skew", cooling_skew, "v_M of Richards' curves (eq. 21); only with kinetics `richards`"),
            choice!(
                "mixing",
                [("series", Mixing::Series), ("parallel", Mixing::Parallel)],
                Default::Text("series"),
                "How the phases' moduli combine: Reuss (eq. 4) or Voigt (eq. 3)",
                c.model.material.mixing
            ),
            choice!(
                "convection",
                [("constant", Convection::Constant), ("natural", Convection::Natural)],
                Default::Text("constant"),
                "Loss to the air by h, or by eq. 34",
                c.model.material.convection
            ),
        ],
    },
    Section {
        table: "channel.adc",
        about: "The converter that measures the wire, as the simulated backend plays it and the driver expects it.",
        optional: false,
        keys: &[
            choice!(
                "circuit",
                [("separate_taps", SamplingCircuit::SeparateTaps), ("shared", SamplingCircuit::Shared)],
                Default::Text("separate_taps"),
                "V_3 and shunt on inputs of their own, or one input for the supply in the off-phase and shunt and switch in the on-phase: [sensing](sensing.md#the-two-circuits)",
                c.adc.circuit
            ),
            Key {
                name: "bits",
                kind: Kind::Integer { low: 4, high: 32 },
                default: Default::Integer(16),
                about: "Resolution over the range",
                get: |c| Some(Value::Integer(c.adc.bits.into())),
                set: |c, value| {
                    if let Value::Integer(i) = value {
                        c.adc.bits = i as u32;
                    }
                },
            },
            number!(
                "voltage_range_v",
                "V",
                SAME,
                0.001..1e5,
                Default::Computed("10, or 1.25 × `supply_v` where that is more"),
                "Full scale of the voltages",
                c.adc.voltage_range_v
            ),
            number!(
                "current_range_a",
                "A",
                SAME,
                1e-6..1e5,
                Default::Computed("1.1 × `maximum_current_a`"),
                "Full scale of the current; above `maximum_current_a`; not for a shared input",
                c.adc.current_range_a
            ),
            number!(
                "voltage_noise_v",
                "V",
                SAME,
                0.0..100.0,
                Default::Number(0.0015),
                "RMS noise of a voltage sample",
                c.adc.voltage_noise_v
            ),
            number!(
                "current_noise_a",
                "A",
                SAME,
                0.0..100.0,
                Default::Number(0.0004),
                "RMS noise of a current sample; not for a shared input",
                c.adc.current_noise_a
            ),
            number!(
                "voltage_offset_v",
                "V",
                SAME,
                -100.0..100.0,
                Default::Number(0.0),
                "Offset of the voltage samples",
                c.adc.voltage_offset_v
            ),
            number!(
                "current_offset_a",
                "A",
                SAME,
                -100.0..100.0,
                Default::Number(0.0),
                "Offset of the current samples; not for a shared input",
                c.adc.current_offset_a
            ),
            number!(
                "supply_noise_v",
                "V",
                SAME,
                0.0..100.0,
                Default::Number(0.003),
                "RMS noise of the measured supply; not for a shared input",
                c.adc.supply_noise_v
            ),
        ],
    },
    Section {
        table: "channel.front_end",
        about: "Where the channel is on a front-end, with kind `serial` of the backend.",
        optional: false,
        keys: &[Key {
            name: "index",
            kind: Kind::Integer { low: 0, high: 63 },
            default: Default::Computed("its place in the file, from 0"),
            about: "Which of the front-end's channels it is",
            get: |c| c.front_end_index.map(|index| Value::Integer(index.into())),
            set: |c, value| {
                if let Value::Integer(i) = value {
                    c.front_end_index = Some(i as u32);
                }
            },
        }],
    },
    Section {
        table: "channel.linux",
        about: "Where the channel is among Linux's outputs and inputs, with kind `linux` of the backend. A converter goes by its \
                number (`iio:device0`), its name or label where no other has it, or its place on the bus (`1-0041`), a chip by \
                its number (`pwmchip0`) or its place; `sinew doctor` lists them.",
        optional: false,
        keys: &LINUX_PLACES,
    },
    Section {
        table: "channel.limits",
        about: "What the driver's supervisor holds the channel within. Leaving one of them is a fault and switches it off.",
        optional: false,
        keys: &[
            number!(
                "minimum_length_mm",
                "mm",
                MILLI,
                0.0..200_000.0,
                Default::Computed("hot length − margin, margin = 10 % of the stroke + 0.5 % of `length_mm`"),
                "Shortest length a measurement may show",
                c.limits.min_length_m
            ),
            number!(
                "maximum_length_mm",
                "mm",
                MILLI,
                0.0..200_000.0,
                Default::Computed("cold length + margin"),
                "Longest length a measurement may show",
                c.limits.max_length_m
            ),
            number!(
                "maximum_duty",
                "1",
                SAME,
                0.001..1.0,
                Default::Computed(
                    "1 (1 − `sensing_duty` with a shared input), or `maximum_power_w` over the full-on power where that is less"
                ),
                "Largest duty; only with drive kind `pwm`",
                c.limits.max_duty
            ),
            number!(
                "maximum_power_w",
                "W",
                SAME,
                1e-6..1e6,
                Default::Computed("1.1 × the largest full-on power"),
                "Largest mean power into the wire",
                c.limits.max_power_w
            ),
            number!(
                "maximum_current_a",
                "A",
                SAME,
                1e-6..1e5,
                Default::Computed("1.15 × the largest full-on current"),
                "Largest current in the on-phase",
                c.limits.max_current_a
            ),
            number!(
                "maximum_temperature_c",
                "°C",
                SAME,
                -200.0..1200.0,
                Default::Computed("A + 60 K + the shift by the stress of the hot wire"),
                "Highest estimated wire temperature",
                c.limits.max_temperature_c
            ),
            number!(
                "continuous_current_a",
                "A",
                SAME,
                1e-6..1e5,
                Default::Computed(
                    "20 A/mm² + 40 mA (eq. 8), but no less than holds the contracted wire and no more than holds it at `maximum_temperature_c`"
                ),
                "Current the wire bears for good, RMS over on- and off-phases; read where `energy_drain_w` is not given",
                c.limits.continuous_current_a
            ),
            number!(
                "energy_budget_j",
                "J",
                SAME,
                1e-9..1e9,
                Default::Computed("1.25 × the heat from ambient to `maximum_temperature_c`, latent heat included"),
                "Heat that fills the wire's account; from 80 % of it on the duty is derated",
                c.limits.energy_budget_j
            ),
            number!(
                "energy_drain_w",
                "W",
                SAME,
                0.0..1e6,
                Default::Computed("what `continuous_current_a` heats the hot wire with"),
                "Rate at which a full account drains; in proportion where it is less full",
                c.limits.energy_drain_w
            ),
            optional_number!(
                "minimum_force_n",
                "N",
                SAME,
                0.0..1e5,
                Default::Computed("none"),
                "Anti-slack: below this tension, reckoned from the load, the wire is heated; not in a joint. No fault",
                c.limits.min_force_n
            ),
            optional_number!(
                "maximum_force_n",
                "N",
                SAME,
                0.0..1e5,
                Default::Computed("none"),
                "Anti-overload: above this tension, reckoned from the load, it is not heated; not in a joint. No fault",
                c.limits.max_force_n
            ),
            number!(
                "default_hold_s",
                "s",
                SAME,
                0.01..86_400.0,
                Default::Computed("0.5, or `maximum_hold_s` where that is less"),
                "Lease of a command that names none",
                c.limits.lease_s
            ),
            number!(
                "maximum_hold_s",
                "s",
                SAME,
                0.01..86_400.0,
                Default::Number(3600.0),
                "Longest lease a command may ask for",
                c.limits.max_lease_s
            ),
        ],
    },
    Section {
        table: "channel.control",
        about: "The controller and what it measures by.",
        optional: false,
        keys: &[
            Key {
                name: "algorithm",
                kind: Kind::Choice(&Algorithm::WORDS),
                default: Default::Text("time_optimal"),
                about: "Control law, see [control.md](control.md); all but the default are there for comparison",
                get: |c| Some(Value::Text(c.control.algorithm.word().into())),
                set: |c, value| {
                    if let Value::Text(text) = value
                        && let Some((_, algorithm)) = Algorithm::ALL.into_iter().find(|(word, _)| *word == text)
                    {
                        c.control.algorithm = algorithm;
                    }
                },
            },
            Key {
                name: "estimator",
                kind: Kind::Choice(&Estimator::WORDS),
                default: Default::Text("fused"),
                about: "What the wire's temperature and martensite are estimated by, see [control.md](control.md): all that is \
                        measured and the model, weighed together; the heat that its \
                        power feeds; the thesis' linear state estimator with constant gains, or with scheduled ones",
                get: |c| Some(Value::Text(c.control.estimator.word().into())),
                set: |c, value| {
                    if let Value::Text(text) = value
                        && let Some((_, estimator)) = Estimator::ALL.into_iter().find(|(word, _)| *word == text)
                    {
                        c.control.estimator = estimator;
                    }
                },
            },
            law_number!(
                "lambda_per_s",
                "1/s",
                SAME,
                0.01..10_000.0,
                Default::Computed("from the wire's heating and cooling limits"),
                "λ of the sliding surface, of the linearised loop or of the servo's integral; not with `relay`, `pi`, `pid`",
                lambda_per_s
            ),
            choice!(
                "rapid_heating",
                [
                    ("off", RapidHeating::Off),
                    ("temperature", RapidHeating::Temperature),
                    ("resistance", RapidHeating::Resistance)
                ],
                Default::Text("off"),
                "Full power to a wire that has to shorten, whatever the law says, until just below its transformation, \
                 as told by the estimated temperature or by the resistance measured",
                c.control.rapid_heating
            ),
            Key {
                name: "heat_loss_feedforward",
                kind: Kind::Boolean,
                default: Default::Computed("`false` with `pi` and `pid`, `true` with input–output linearisation"),
                about: "Whether the estimated loss to the air is added to what the law asks for; with `pi`, `pid` and \
                        input–output linearisation",
                get: |c| {
                    let taken = c.control.algorithm.takes("heat_loss_feedforward");
                    if taken { c.control.heat_loss_feedforward.map(Value::Boolean) } else { None }
                },
                set: |c, value| {
                    if let Value::Boolean(on) = value {
                        c.control.heat_loss_feedforward = Some(on);
                    }
                },
            },
            choice!(
                "sensing",
                [("dual", Sensing::Dual), ("resistance", Sensing::Resistance)],
                Default::Computed("`dual` with taps, else `resistance`"),
                "What the length is measured by",
                c.control.sensing
            ),
            number!(
                "sensing_duty",
                "1",
                SAME,
                0.0..0.5,
                Default::Number(0.02),
                "Duty that is always on so that there is something to measure; below `maximum_duty`",
                c.control.minimum_duty
            ),
            law_number!(
                "pi_proportional_per_mm",
                "1/mm",
                PER_MILLI,
                0.0..1e6,
                Default::Computed("1 / (0.3 stroke)"),
                "Proportional gain of `pi` and `pid`: duty per mm of error",
                pi_proportional_per_m
            ),
            law_number!(
                "pi_integral_per_mm_s",
                "1/(mm s)",
                PER_MILLI,
                0.0..1e6,
                Default::Computed("1 / (0.3 stroke) per second"),
                "Integral gain of `pi` and `pid`",
                pi_integral_per_m_s
            ),
            law_number!(
                "pid_derivative_s_per_mm",
                "s/mm",
                PER_MILLI,
                0.0..1e6,
                Default::Computed("0.05 s / (0.3 stroke)"),
                "Derivative gain of `pid`: duty per mm/s",
                pid_derivative_s_per_m
            ),
            law_number!(
                "relay_band_mm",
                "mm",
                MILLI,
                0.0..1000.0,
                Default::Computed("1 % of the stroke"),
                "Half width of the band of `relay` in which nothing is switched",
                relay_band_m
            ),
        ],
    },
];

/// The words that a key of a channel takes, such as those of `algorithm` in `channel.control`; empty where it takes none.
pub fn words(table: &str, key: &str) -> &'static [&'static str] {
    match find(table, key).map(|key| &key.kind) {
        Some(Kind::Choice(words)) => words,
        _ => &[],
    }
}

/// The word that is in force for such a key.
pub fn word(channel: &Channel, table: &str, key: &str) -> Option<String> {
    match (find(table, key)?.get)(channel) {
        Some(Value::Text(word)) => Some(word),
        _ => None,
    }
}

fn find(table: &str, key: &str) -> Option<&'static Key<Channel>> {
    CHANNEL.iter().find(|section| section.table == table)?.keys.iter().find(|k| k.name == key)
}

/// A channel's table without the `channel.` before it; empty for the channel itself.
pub(crate) fn local(table: &'static str) -> &'static str {
    table.strip_prefix("channel").map_or(table, |t| t.strip_prefix('.').unwrap_or(t))
}

/// The reference of every key as Markdown: one table for each table of the rig file.
/// `docs/rig.md` carries it word for word.
pub fn reference() -> String {
    let mut out = String::new();
    describe(&mut out, &RIG, "[rig]");
    for section in CHANNEL {
        let header = if section.table == "channel" { "[[channel]]".into() } else { format!("[{}]", section.table) };
        describe(&mut out, section, &header);
    }
    describe(&mut out, &JOINT, "[[joint]]");
    for section in OF_RIG {
        describe(&mut out, section, &format!("[{}]", section.table));
    }
    out
}

fn describe<T>(out: &mut String, section: &Section<T>, header: &str) {
    use std::fmt::Write as _;
    // Writing to a String cannot fail.
    let _ = write!(
        out,
        "### `{header}`\n\n{}\n\n| key | unit | default | range | |\n|---|---|---|---|---|\n",
        section.about
    );
    for key in section.keys {
        let (unit, range) = match &key.kind {
            Kind::Number { unit, low, high, .. } => (*unit, format!("{low} to {high}")),
            Kind::Integer { low, high: i64::MAX } => ("", format!("whole, from {low}")),
            Kind::Integer { low, high } => ("", format!("whole, {low} to {high}")),
            Kind::Boolean => ("", "`true`, `false`".into()),
            Kind::Choice(words) => ("", words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ")),
            Kind::Name { .. } => ("", "a name".into()),
            Kind::Text { what, .. } => ("", (*what).into()),
        };
        let default = match &key.default {
            Default::Required(_) => "**required**".into(),
            Default::Number(n) => format!("{n}"),
            Default::Integer(i) => format!("{i}"),
            Default::Text(t) => format!("`{t}`"),
            Default::Computed(words) => (*words).into(),
        };
        let _ = writeln!(out, "| `{}` | {unit} | {default} | {range} | {} |", key.name, key.about);
    }
    out.push('\n');
}

/// Every table in which a key of this name lives, as in its header; not the noise of a column of that name.
pub(crate) fn tables_with(name: &str) -> Vec<&'static str> {
    let of_rig = [&RIG].into_iter().chain(OF_RIG);
    let rig = of_rig.filter(|s| s.keys.iter().any(|k| k.name == name)).map(|s| s.table);
    let channel = CHANNEL.iter().filter(|s| s.table != NOISE && s.keys.iter().any(|k| k.name == name));
    let joint = JOINT.keys.iter().any(|k| k.name == name).then_some(JOINT.table);
    rig.chain(channel.map(|s| s.table)).chain(joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_of_the_alloy_are_those_of_the_physics() {
        let rig = crate::Rig::hexapod();
        assert_eq!(rig.channels[0].model.material, sinew_physics::Material::default());
    }

    #[test]
    fn units_convert_there_and_back() {
        assert_eq!(MILLI.to_si(160.0), 0.16);
        assert_eq!(UOHM_CM.to_si(86.5), 86.5e-8);
        for scale in [SAME, MILLI, GIGA, MEGA, PER_MEGA, UOHM_CM, PER_MILLI] {
            for n in [0.0, 0.1, 0.125, 1.0 / 3.0, 1.96133, 86.5, 160.0, 24_200.0, -0.05, 1e-200, 1e200] {
                assert_eq!(scale.to_file(scale.to_si(n)), n, "{scale:?} {n}");
            }
        }
    }

    #[test]
    fn every_table_starts_with_what_selects_its_kind() {
        for section in CHANNEL {
            let place = section.keys.iter().position(|k| k.name == "kind");
            assert!(place.is_none_or(|p| p == 0), "{}", section.table);
        }
    }

    #[test]
    fn defaults_are_within_their_ranges() {
        fn check<T>(section: &Section<T>) {
            for key in section.keys {
                match (&key.default, &key.kind) {
                    (Default::Number(n), Kind::Number { low, high, .. }) => {
                        assert!((low..=high).contains(&n), "{}", key.name);
                    }
                    (Default::Integer(i), Kind::Integer { low, high }) => {
                        assert!((low..=high).contains(&i), "{}", key.name);
                    }
                    (Default::Text(t), Kind::Choice(words)) => assert!(words.contains(t), "{}", key.name),
                    (Default::Text(t), Kind::Text { longest, .. }) => assert!(t.len() <= *longest, "{}", key.name),
                    (Default::Required(_) | Default::Computed(_), _) => {}
                    _ => panic!("{}: the default is of another kind than the key", key.name),
                }
            }
        }
        check(&RIG);
        OF_RIG.into_iter().for_each(check);
        check(&JOINT);
        CHANNEL.iter().for_each(check);
    }

    #[test]
    fn every_choice_can_be_set_and_read() {
        let mut channel = crate::Rig::hexapod().channels.swap_remove(0);
        for key in CHANNEL.iter().flat_map(|s| s.keys) {
            if let Kind::Choice(words) = key.kind {
                for word in words {
                    (key.set)(&mut channel, Value::Text((*word).into()));
                    assert_eq!((key.get)(&channel), Some(Value::Text((*word).into())), "{}", key.name);
                }
            }
        }
    }

    #[test]
    fn ranges_are_those_of_the_physics() {
        // Keys whose range depends on another key are left to the physics alone.
        let apart = ["l0_mm", "ls_mm", "martensite_temperature_c"];
        for parameter in crate::parameters().filter(|p| !apart.contains(&p.key)) {
            for bound in [parameter.low, parameter.high] {
                let mut rig = crate::Rig::hexapod();
                rig.channels[0].model.taps = None;
                rig.channels[0].model.material.kinetics = Kinetics::Richards { heating_skew: 1.0, cooling_skew: 1.0 };
                rig.channels[0].model.material.martensite_temperature_c = -200.0;
                // A hair inside: the way to SI and back may end a last digit outside.
                let inside =
                    if bound == parameter.low { bound + 1e-12 * bound.abs() } else { bound - 1e-12 * bound.abs() };
                rig.set_parameter(0, parameter.key, inside).unwrap();
                let found = rig.channels[0].model.validate();
                assert_eq!(found, Ok(()), "{} at its bound {bound}", parameter.key);

                let outside = if bound == parameter.low { bound - 1e-7 } else { bound + 1e-3 * bound.abs().max(1.0) };
                assert!(rig.set_parameter(0, parameter.key, outside).is_err());
                let mut model = rig.channels[0].model.clone();
                for section in CHANNEL {
                    for key in section.keys.iter().filter(|k| k.name == parameter.key) {
                        if let Kind::Number { scale, .. } = key.kind {
                            (key.set)(&mut rig.channels[0], Value::Number(scale.to_si(outside)));
                            model = rig.channels[0].model.clone();
                        }
                    }
                }
                if parameter.key == "ambient_c" {
                    model.ambient_c = outside;
                }
                match model.validate() {
                    Err(sinew_physics::Error::OutOfRange { key, low, high, .. }) => {
                        assert_eq!((key, low, high), (parameter.key, parameter.low, parameter.high));
                    }
                    Ok(()) => panic!("the physics takes {} = {outside}", parameter.key),
                }
            }
        }
    }

    #[test]
    fn words_are_those_the_reader_takes() {
        let words = words("channel.control", "algorithm");
        assert!(words.contains(&"sliding_mode") && words.contains(&"pi"));
        for word in words {
            let text = format!(
                "[rig]\nname = \"a\"\n[[channel]]\nname = \"w\"\nwire = {{ diameter_mm = 0.1, length_mm = 100.0 }}\n\
                 drive = {{ supply_v = 5.0 }}\nload = {{ mass_kg = 0.1, damping_n_s_per_m = 10.0 }}\n\
                 control = {{ algorithm = \"{word}\" }}\n"
            );
            let rig = crate::Rig::parse(&text, "a.toml").unwrap_or_else(|e| panic!("{word}: {e}"));
            assert_eq!(super::word(&rig.channels[0], "channel.control", "algorithm").as_deref(), Some(*word));
        }
        let no_words: &[&str] = &[];
        assert_eq!(super::words("channel.control", "lambda_per_s"), no_words);
        assert_eq!(super::words("channel.nothing", "algorithm"), no_words);
        assert_eq!(super::word(&crate::Rig::hexapod().channels[0], "channel.wire", "length_mm"), None);
    }
}
