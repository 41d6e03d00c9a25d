//! Which backend drives a rig: the one place that knows all of them.

use sinew_driver::Backend;
use sinew_linux_backend::{LinuxRig, Settings};
use sinew_rig::{BackendKind, Rig};
use sinew_sim_backend::SimulatedRig;

use crate::commands::rig_failure;
use crate::failure::Failure;

/// A rig's backend, and what a person calls the wires behind it.
pub struct Chosen {
    /// Not started yet.
    pub backend: Box<dyn Backend>,
    /// Whether the wires are simulated by the driver itself.
    pub simulated: bool,
    /// "simulated wires", "wires on /dev/ttyACM0".
    pub wires: String,
}

/// The backend that a rig file asks for.
pub fn choose(rig: &Rig) -> Result<Chosen, Failure> {
    match rig.backend.kind {
        BackendKind::Simulated => {
            let backend = SimulatedRig::new(rig).map_err(|error| match error {
                sinew_sim_backend::Error::NotDrivable(error) => rig_failure(&error),
                error => Failure::input(format!("{}: {error}", rig.file())),
            })?;
            Ok(Chosen { backend: Box::new(backend), simulated: true, wires: "simulated wires".into() })
        }
        BackendKind::Linux => {
            let backend = LinuxRig::new(Settings::of_rig(rig)).map_err(|error| {
                let remedy = error.remedy();
                Failure::input(format!("{}: {error}", rig.file())).hint(remedy)
            })?;
            Ok(Chosen { backend: Box::new(backend), simulated: false, wires: "wires on Linux's own outputs".into() })
        }
        BackendKind::Serial => Err(Failure::input(format!("{}: backend.kind is \"serial\"", rig.file()))
            .hint("this version has no serial backend yet; \"simulated\" drives simulated wires")),
    }
}
