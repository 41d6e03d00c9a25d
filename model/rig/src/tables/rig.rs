//! `[rig]`: the rig as a whole, and what all of it is made of.

use crate::declare::rows::*;
use crate::notes::{Reader, Stated};
use crate::own::Catalogue;
use crate::tables::{Access, Backend, BlackBox, Channel, Demonstrator, Joint, Machine, Mapping, Simulation};
use crate::value::MAX_PATH;

/// Longest name of a rig, in bytes.
pub const MAX_RIG_NAME: usize = 48;
/// The program of a rig that moves only when it is commanded.
pub const NO_PROGRAM: &str = "none";
/// The program of a rig with legs of three wires, as the built-in hexapod has.
pub const WALK: &str = "walk";
/// The program that moves every wire a bit and back, one after the other.
pub const STEPS: &str = "steps";

/// Slowest rate the driver runs a rig at, in Hz.
pub const MIN_DRIVEN_RATE_HZ: f64 = 10.0;
/// Fastest rate the driver runs a rig at, in Hz.
pub const MAX_DRIVEN_RATE_HZ: f64 = 20_000.0;

/// A whole rig: what a rig file says, with every default filled in.
///
/// Comes from [`Rig::load`](crate::Rig::load) or [`Rig::parse`](crate::Rig::parse); fields may be changed and
/// written back with [`Rig::to_toml`](crate::Rig::to_toml). Two rigs are equal when they say the same,
/// whatever the text they came from looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Name of the rig; the driver's services are found by it.
    pub name: String,
    /// Rate of PWM, sampling and control, in Hz.
    pub rate_hz: f64,
    /// Ambient temperature T_∞, in °C; every channel's model carries it too.
    pub ambient_c: f64,
    /// How hard the driver tries for real time.
    pub realtime: Realtime,
    /// What the wires do while nobody commands them: a word ([`NO_PROGRAM`], [`WALK`], [`STEPS`]) or a file.
    pub program: String,
    /// Which other users may look and command.
    pub access: Access,
    /// The wires, in the order of the file; at most [`MAX_CHANNELS`](crate::MAX_CHANNELS).
    pub channels: Vec<Channel>,
    /// The joints that pairs of channels turn, in the order of the file.
    pub joints: Vec<Joint>,
    /// How a foreign recording is written, and how its columns are named and scaled.
    pub recording: Mapping,
    /// What powers and measures the wires.
    pub backend: Backend,
    /// What is kept for the moment something breaks.
    pub black_box: BlackBox,
    /// The simulated backend.
    pub simulation: Simulation,
    /// The machine that a simulated wire moves.
    pub demonstrator: Demonstrator,
    /// The tensile testing machine a wire may be mounted in.
    pub machine: Machine,
    pub(crate) source: Source,
}

/// How hard the driver tries for real time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Realtime {
    /// What a refusal by the system means.
    pub mode: RealtimeMode,
    /// SCHED_FIFO priority of the loop, 1 to 98.
    pub priority: u32,
    /// Core the loop is pinned to; `None` = the driver chooses.
    pub cpu: Option<u32>,
}

words! {
    /// What a refusal of real-time scheduling by the system means.
    pub enum RealtimeMode, default Try {
        /// Do not ask for any of it.
        Off = "off",
        /// Ask, say what was refused, go on.
        Try = "try",
        /// Ask, and refuse to start without.
        Strict = "strict",
    }
}

/// Keys of `[rig]`.
pub(crate) fn section() -> Section<Rig> {
    Section {
        table: "rig",
        about: "The rig as a whole. Required.",
        optional: false,
        keys: keys! {
            Rig;
            /// Name of the rig: clients find the driver by it. Letters, digits, `-`, `_` and `.`, a letter or digit
            /// first, at most 48.
            "name" = at(name), name(MAX_RIG_NAME), Required("a name such as \"tensile-bench\"");
            /// PWM, sampling and control rate. The driver needs at least 10 Hz; recordings may be slower.
            "rate_hz" = at(rate_hz), number(si("Hz"), 0.001, 20_000.0), Number(1000.0);
            /// Temperature of the air, where a recording does not give it.
            "ambient_c" = at(ambient_c), number(si("°C"), -200.0, 800.0), Number(25.0), prior Absolute(2.0);
            /// Real-time scheduling: ask and go on without (`try`), refuse to start without (`strict`), do not ask
            /// (`off`).
            "realtime" = at(realtime.mode), RealtimeMode::KIND, RealtimeMode::DEFAULT;
            /// What the wires do while nobody commands them: `none`, `steps` (each a bit and back, in turns), `walk` (legs of three wires, as the
            /// built-in hexapod's), or a CSV file of setpoints as `sinew play` takes it, which is played again and again.
            "program" = at(program), text("`none`, `steps`, `walk` or a CSV file", MAX_PATH), Text(NO_PROGRAM);
            /// SCHED_FIFO priority of the loop (99 belongs to the kernel).
            "realtime_priority" = at(realtime.priority), integer(1, 98), Integer(80);
            /// Core the loop is pinned to.
            "realtime_cpu" = at(realtime.cpu), integer(0, 4095), Computed("the driver chooses");
        },
        check: Some(Box::new(realtime_is_asked_for)),
    }
}

fn realtime_is_asked_for(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.realtime.mode == RealtimeMode::Off {
        for key in ["realtime_priority", "realtime_cpu"] {
            let message = "makes no sense with realtime = \"off\"; take one of the two out";
            reader.out_of_place(stated, ("rig", key), message);
        }
    }
}

impl Rig {
    /// A rig of which nothing is read yet.
    pub(crate) fn unread() -> Rig {
        Rig {
            name: String::UNREAD,
            rate_hz: f64::UNREAD,
            ambient_c: f64::UNREAD,
            program: String::UNREAD,
            realtime: Realtime { mode: Field::UNREAD, priority: Field::UNREAD, cpu: Field::UNREAD },
            access: Unread::UNREAD,
            channels: Vec::new(),
            joints: Vec::new(),
            recording: Mapping::default(),
            backend: Unread::UNREAD,
            black_box: Unread::UNREAD,
            simulation: Simulation::unread(),
            demonstrator: Unread::UNREAD,
            machine: Unread::UNREAD,
            source: Source::default(),
        }
    }
}

impl Rig {
    /// The channel of this name and its index.
    pub fn channel(&self, name: &str) -> Option<(usize, &Channel)> {
        self.channels.iter().enumerate().find(|(_, c)| c.name == name)
    }

    /// The joint a channel's wire turns and its side there, 0 = agonist; `None` where it has a load of its own.
    pub fn joint_of(&self, channel: usize) -> Option<(&Joint, usize)> {
        let name = &self.channels.get(channel)?.name;
        self.joints.iter().find_map(|joint| Some((joint, joint.side(name)?)))
    }

    /// The channel whose wire is the neighbour of another channel's (`thermal.neighbour`), by indices.
    pub fn neighbour_of(&self, channel: usize) -> Option<usize> {
        Some(self.channel(self.channels.get(channel)?.neighbour.as_deref()?)?.0)
    }

    /// The other channels at the supply of a channel, which sags under all of their currents (`electrical.supply_sag`).
    pub fn at_supply_of(&self, channel: usize) -> impl Iterator<Item = usize> + '_ {
        let supply = self.channels.get(channel).and_then(|c| c.supply.as_deref());
        let others = self.channels.iter().enumerate().filter(move |(other, _)| *other != channel);
        others.filter(move |(_, other)| supply.is_some() && other.supply.as_deref() == supply).map(|(other, _)| other)
    }

    /// The indices of a joint's channels, agonist first; `None` where one was renamed since the rig was read.
    pub fn channels_of(&self, joint: &Joint) -> Option<[usize; 2]> {
        Some([self.channel(&joint.agonist)?.0, self.channel(&joint.antagonist)?.0])
    }

    /// The wire of a channel in the load its stroke and limits are reckoned with, see [`Channel::nominal_model`].
    pub fn nominal_model(&self, channel: usize) -> sinew_physics::WireModel {
        self.channels[channel].nominal_model(self.joint_of(channel).map(|(joint, _)| joint))
    }

    /// Which channel of a serial front-end a channel of the rig is.
    pub fn front_end_index(&self, channel: usize) -> Option<u32> {
        let own = self.channels.get(channel)?.backend.serial.index;
        own.or(u32::try_from(channel).ok())
    }

    /// The file this rig came from, as it was asked for.
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// The text it was read from, as it was; later changes of fields are not in it, see [`Rig::to_toml`].
    pub fn text(&self) -> &str {
        &self.source.text
    }
}

/// The text a rig came from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Source {
    pub file: String,
    pub text: String,
    /// Laws that were there besides those in the text.
    pub catalogue: Catalogue,
}

/// Where a rig came from is no part of what it says.
impl PartialEq for Source {
    fn eq(&self, _: &Source) -> bool {
        true
    }
}
