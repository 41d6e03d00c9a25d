//! Everything there is to know of one wire.

use crate::effects::all::Effects;
use crate::params::{Drive, Geometry, Initial, Load, Material, Taps};

/// Everything there is to know of one wire: the reference model's parameters, and the effects beyond it.
#[derive(Debug, Clone, PartialEq)]
pub struct WireModel {
    /// Size.
    pub geometry: Geometry,
    /// Alloy.
    pub material: Material,
    /// Dual measurement, where there is one.
    pub taps: Option<Taps>,
    /// Heating circuit.
    pub drive: Drive,
    /// Load.
    pub load: Load,
    /// State at the first sample.
    pub initial: Initial,
    /// Ambient temperature T_∞, in °C.
    pub ambient_c: f64,
    /// Physics beyond the reference model.
    pub effects: Effects,
}

impl WireModel {
    /// Parts of the wire whose phase is followed apart: what a step of it costs, beside that of a wire all alike.
    pub fn parts(&self) -> usize {
        self.effects.kinetic.parts() + self.effects.thermal.end_conduction.parts()
    }
}
