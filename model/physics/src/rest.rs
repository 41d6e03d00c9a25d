//! What acts on a wire that is left alone.

use crate::model::WireModel;
use crate::params::DriveKind;
use crate::signals::Inputs;

impl WireModel {
    /// Drive off (an imposed temperature stays at its start), nominal supply and ambient, nothing pulling; an imposed
    /// position or force is 0.
    pub fn rest_inputs(&self) -> Inputs {
        let drive = match self.drive.kind {
            DriveKind::Temperature => self.initial.temperature_c.unwrap_or(self.ambient_c),
            _ => 0.0,
        };
        Inputs { drive, supply_v: self.drive.supply_v, ambient_c: self.ambient_c, external_n: 0.0, imposed: 0.0 }
    }
}
