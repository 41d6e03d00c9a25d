//! A demonstrator and its wires as the driver's backend.

use sinew_backend::{Backend, BackendError, ChannelFault, Sample, StopInputs, Truth, Zero};
use sinew_sim_backend::SimulatedRig;

use crate::demonstrator::Demonstrator;

/// Most periods that were missed in which the machine is followed; after a longer break it has stood still.
const MOST_FOLLOWED: u64 = 100_000;

/// Simulated wires with the machine that one of them moves.
#[derive(Debug)]
pub struct DemonstratorBackend {
    wires: SimulatedRig,
    demonstrator: Demonstrator,
}

impl DemonstratorBackend {
    /// Of these wires, which are those of the demonstrator's rig.
    pub fn new(mut wires: SimulatedRig, demonstrator: Demonstrator) -> DemonstratorBackend {
        demonstrator.make_room(&mut wires);
        DemonstratorBackend { wires, demonstrator }
    }
}

impl Backend for DemonstratorBackend {
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        let exchanged = self.wires.exchange(duty, samples);
        self.demonstrator.pass(&mut self.wires);
        exchanged
    }

    fn missed(&mut self, periods: u64) {
        let followed = periods.min(MOST_FOLLOWED);
        if periods > followed {
            self.wires.missed(periods - followed);
        }
        for _ in 0..followed {
            self.wires.missed(1);
            self.demonstrator.pass(&mut self.wires);
        }
    }

    fn channels(&self) -> usize {
        self.wires.channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.wires.start()
    }

    fn cut(&mut self) -> bool {
        self.wires.cut()
    }

    fn restore(&mut self) {
        self.wires.restore();
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.wires.stop_inputs()
    }

    fn is_confirmed(&self, channel: usize) -> bool {
        self.wires.is_confirmed(channel)
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.wires.failure(channel)
    }

    fn silence_s(&self) -> Option<f64> {
        self.wires.silence_s()
    }

    fn is_at_rest(&self) -> bool {
        self.wires.is_at_rest()
    }

    fn stop(&mut self) -> Zero {
        self.wires.stop()
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        self.wires.truth(channel)
    }
}
