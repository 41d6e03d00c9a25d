//! Selects the backend of a rig: the only place that depends on all of them.

use std::sync::Arc;

use sinew_backend::Backend;
use sinew_demonstrators::{Demonstrator, DemonstratorBackend, Watch};
use sinew_linux_backend::{LinuxRig, Settings};
use sinew_rig::{BackendKind, Rig};
use sinew_serial_backend::{self as serial, LineFigures, SerialBackend};
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
    /// How the line to a front-end does.
    pub line: Option<Arc<LineFigures>>,
    /// The machine that a simulated wire moves.
    pub machine: Option<Watch>,
}

/// The backend that a rig file asks for.
pub fn choose(rig: &Rig) -> Result<Chosen, Failure> {
    match rig.backend.kind {
        BackendKind::Simulated => {
            let backend = SimulatedRig::new(rig).map_err(|error| match error {
                sinew_sim_backend::Error::NotDrivable(error) => rig_failure(&error),
                error => Failure::input(format!("{}: {error}", rig.file())),
            })?;
            let wires = "simulated wires".into();
            let machine = Demonstrator::of(rig).map_err(|error| Failure::input(format!("{}: {error}", rig.file())))?;
            let Some(machine) = machine else {
                return Ok(Chosen { backend: Box::new(backend), simulated: true, wires, line: None, machine: None });
            };
            let seen = Some(machine.watch());
            let backend = Box::new(DemonstratorBackend::new(backend, machine));
            Ok(Chosen { backend, simulated: true, wires, line: None, machine: seen })
        }
        BackendKind::Serial => {
            let backend = SerialBackend::connect(rig).map_err(|error| serial_failure(rig, error))?;
            let wires =
                format!("wires on {}, {}", rig.backend.serial.port.as_deref().unwrap_or(""), backend.front_end());
            let line = Some(backend.figures());
            Ok(Chosen { backend: Box::new(backend), simulated: false, wires, line, machine: None })
        }
        BackendKind::Linux => {
            let backend = LinuxRig::new(Settings::of_rig(rig)).map_err(|error| {
                let remedy = error.remedy();
                Failure::input(format!("{}: {error}", rig.file())).hint(remedy)
            })?;
            let wires = "wires on Linux's own outputs".into();
            Ok(Chosen { backend: Box::new(backend), simulated: false, wires, line: None, machine: None })
        }
    }
}

/// Why a front-end cannot be used: the rig file's to mend, or what is plugged in.
fn serial_failure(rig: &Rig, error: serial::Error) -> Failure {
    if let serial::Error::Thread(_) = error {
        return Failure::own(error);
    }
    let remedy = error.remedy();
    Failure::input(format!("{}: {error}", rig.file())).hint(remedy)
}
