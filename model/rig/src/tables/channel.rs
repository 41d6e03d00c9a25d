//! `[[channel]]`: one wire with all that belongs to it.

use std::collections::BTreeMap;

use sinew_physics::effects::Effects;
use sinew_physics::{Drive, Geometry, Initial, Material, WireModel};

use crate::declare::rows::*;
use crate::key::Prior;
use crate::tables::{Adc, BackendChannel, Control, Limits, PositionZero};
use crate::wires::WireKind;

/// Most channels a rig can have.
pub const MAX_CHANNELS: usize = 64;
/// Longest name of a channel, in bytes.
pub const MAX_CHANNEL_NAME: usize = 32;

/// One wire with its drive, load, limits and control.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name, unique within the rig.
    pub name: String,
    /// What the wire is sold as, where the file says it.
    pub wire_kind: Option<&'static WireKind>,
    /// Wire, taps, drive, load, initial state and the effects beyond the reference model.
    pub model: WireModel,
    /// Whether an offset of the measured position means anything.
    pub position_zero: PositionZero,
    /// `[channel.sensors.noise]`: RMS by the name of a recording's column, in the column's unit; above 0.
    pub noise: BTreeMap<String, f64>,
    /// The rig file's own `[channel.priors]`; for those in force use [`Channel::priors_in_force`].
    pub priors: BTreeMap<String, Prior>,
    /// The converter that measures voltages and current.
    pub adc: Adc,
    /// Where it is for each kind of backend.
    pub backend: BackendChannel,
    /// What the supervisor holds the channel within.
    pub limits: Limits,
    /// The controller.
    pub control: Control,
    /// Name of the channel whose wire is the neighbour of `thermal.neighbour`; `None` = a body at ambient temperature.
    /// All other effects are in the model.
    pub neighbour: Option<String>,
    /// Name of the supply of `electrical.supply_sag`, which sags under the sum of the currents of all channels that
    /// name it; `None` = one of its own.
    pub supply: Option<String>,
}

/// Keys of `[[channel]]` itself.
pub(crate) fn section() -> Section<Channel> {
    Section {
        table: "channel",
        about: "One wire each: `[[channel]]`, at least one and at most 64. Its own tables follow it.",
        optional: false,
        keys: keys! {
            Channel;
            /// Name of the channel, unique in the rig. Letters, digits, `-`, `_` and `.`, a letter or digit first, at
            /// most 32.
            "name" = at(name), name(MAX_CHANNEL_NAME), Required("a name such as \"wire\"");
        },
        check: None,
    }
}

impl Channel {
    /// Power in the on-phase with the wire at its most conductive, W: what bounds a duty of 1.
    pub fn full_power_w(&self) -> f64 {
        let model = &self.model;
        model.drive.on_power_w(model.geometry.resistance_ohm(model.material.least_resistivity()))
    }

    /// A channel before anything is read.
    pub(crate) fn unread(ambient_c: f64) -> Channel {
        Channel {
            name: String::UNREAD,
            wire_kind: None,
            model: WireModel {
                geometry: Geometry { diameter_m: f64::UNREAD, length_m: f64::UNREAD },
                material: Material::default(),
                taps: None,
                drive: Drive { kind: Field::UNREAD, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 },
                load: Field::UNREAD,
                initial: Initial::default(),
                ambient_c,
                effects: Effects::default(),
            },
            position_zero: Field::UNREAD,
            noise: BTreeMap::new(),
            priors: BTreeMap::new(),
            adc: Unread::UNREAD,
            backend: Unread::UNREAD,
            limits: Unread::UNREAD,
            control: Unread::UNREAD,
            neighbour: None,
            supply: None,
        }
    }
}
