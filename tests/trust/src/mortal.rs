//! A driver of one wire on a simulated clock, that may die at any instant while its wire goes on, and the record of the wire's heat that
//! outlives it.
//!
//! No `sinew_lockstep::Lockstep`: that one's driver is born at rest and never dies, and its wire is not watched while a period is missed.

use sinew_backend::{Backend, BackendError, Sample};
use sinew_driver::heat::Recalled;
use sinew_driver::{Beat, Engine, SupplySwitch};
use sinew_ipc::{DriverState, Snapshot};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

/// A record of the output as the driver keeps it.
#[derive(Debug, Clone, Copy)]
pub struct Record {
    recalled: Recalled,
    at_s: f64,
}

impl Record {
    /// Of a wire that has rested until the clock began.
    pub fn rested(rig: &Rig) -> Record {
        let temperature_c = rig.channels[0].model.ambient_c;
        let surely_c = temperature_c;
        Record { recalled: Recalled { temperature_c, surely_c, account_j: 0.0, given_w: 0.0, since_s: 0.0 }, at_s: 0.0 }
    }
}

/// The driver while it lives. A period of it is an exchange, then [`Mortal::look`], then [`Mortal::cycle`].
pub struct Mortal {
    /// What decides.
    pub engine: Engine,
    /// What it puts out next.
    pub duty: [f64; 1],
    /// What it publishes.
    pub snapshot: Box<Snapshot>,
    supply: SupplySwitch,
}

impl Mortal {
    /// Comes up on wires that are started, and finds the record of their output, or none.
    ///
    /// # Errors
    /// A rig that is refused.
    pub fn started(rig: &Rig, wires: &mut SimulatedRig, record: Option<Record>) -> Result<Mortal, sinew_driver::Error> {
        let mut engine = Engine::new(rig, None)?;
        engine.bear_silence(wires.silence_s().unwrap_or(f64::NAN));
        if let Some(Record { recalled, at_s }) = record {
            engine.recall(0, &Recalled { since_s: wires.time_s() - at_s, ..recalled });
        }
        let mut supply = SupplySwitch::default();
        supply.begin(wires);
        Ok(Mortal { engine, duty: [0.0], snapshot: Box::new(Snapshot::new(1)), supply })
    }

    /// Takes in what the exchange has shown of outputs and supply.
    pub fn look(&mut self, wires: &mut SimulatedRig, resets_stop: bool) {
        self.engine.note_outputs(wires);
        self.engine.clear(wires);
        self.supply.look(wires, &mut self.engine, resets_stop);
    }

    /// Decides and publishes; gives the record that it leaves.
    pub fn cycle(
        &mut self,
        wires: &mut SimulatedRig,
        beat: Beat,
        exchanged: Result<(), BackendError>,
        samples: &[Sample; 1],
    ) -> Record {
        self.engine.cycle(beat, exchanged, samples, &mut self.duty, |_| {});
        self.supply.switch(&self.engine, wires);
        self.engine.describe(beat.now_ns, DriverState::Running, &mut self.snapshot);
        Record { recalled: self.engine.channels()[0].to_recall(), at_s: wires.time_s() }
    }
}

/// The loop's clock, ns, after so many seconds of it.
pub fn clock_ns(seconds: f64) -> u64 {
    (seconds * 1e9) as u64 + 1_000_000_000
}
