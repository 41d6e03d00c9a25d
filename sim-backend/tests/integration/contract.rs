//! The conformance suite for backends, with every call of the allocator counted.

use sinew_backend::ChannelFault;
use sinew_backend::conformance::{Bench, suite};
use sinew_rig::{FaultKind, Rig, SamplingCircuit};
use sinew_sim_backend::{FaultHandle, SimulatedRig};

/// Simulated wires, and the hold on what can break in them.
struct Simulated {
    rig: Rig,
    faults: Option<FaultHandle>,
}

impl Simulated {
    fn faults(&self) -> &FaultHandle {
        self.faults.as_ref().expect("a backend is made before it is broken")
    }
}

impl Bench for Simulated {
    type Backend = SimulatedRig;

    fn backend(&mut self) -> SimulatedRig {
        let backend = SimulatedRig::new(&self.rig).unwrap_or_else(|e| panic!("{e}"));
        self.faults = Some(backend.faults());
        backend
    }

    fn unplug(&mut self) -> bool {
        self.faults().set_backend_error(true);
        true
    }

    fn plug_in(&mut self) {
        self.faults().set_backend_error(false);
    }

    fn break_channel(&mut self, channel: usize) -> Option<ChannelFault> {
        self.faults().set(channel, FaultKind::BackendError);
        Some(ChannelFault::Converter)
    }

    fn mend_channel(&mut self, channel: usize) {
        self.faults().clear(channel, FaultKind::BackendError);
    }
}

#[test]
fn it_keeps_the_contract_of_backends() {
    let mut rig = Rig::hexapod();
    for circuit in [SamplingCircuit::SeparateTaps, SamplingCircuit::Shared] {
        for channel in &mut rig.channels {
            channel.adc.circuit = circuit;
        }
        for rate_hz in [100.0, 1000.0, 10_000.0] {
            rig.rate_hz = rate_hz;
            let findings = suite(&mut Simulated { rig: rig.clone(), faults: None });
            assert!(findings.counts_allocations && findings.skipped.is_empty(), "{findings:?}");
        }
    }
}

#[test]
fn it_allocates_nothing_while_faults_come_and_go() {
    use sinew_backend::allocations::calls_of_this_thread;
    use sinew_backend::{Backend, Sample};
    use sinew_rig::FaultKind;

    let mut backend = SimulatedRig::new(&Rig::hexapod()).unwrap_or_else(|e| panic!("{e}"));
    backend.start().unwrap();
    let faults = backend.faults();
    let duty = vec![0.3; backend.channels()];
    let mut samples = vec![Sample::NONE; duty.len()];
    let before = calls_of_this_thread();
    for (_, kind) in FaultKind::ALL {
        for channel in 0..duty.len() {
            faults.set(channel, kind);
        }
        for _ in 0..20 {
            let _ = backend.exchange(&duty, &mut samples);
        }
        faults.clear_all();
        faults.set_backend_error(true);
        assert!(backend.exchange(&duty, &mut samples).is_err());
        faults.set_backend_error(false);
    }
    assert_eq!(calls_of_this_thread(), before);
}
