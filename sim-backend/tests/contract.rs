//! The driver's own suite for backends, with every call of the allocator counted.

use sinew_driver::CountingAllocator;
use sinew_driver::conformance::suite;
use sinew_rig::{Rig, SamplingCircuit};
use sinew_sim_backend::SimulatedRig;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn it_keeps_the_contract_of_backends() {
    let mut rig = Rig::hexapod();
    for circuit in [SamplingCircuit::SeparateTaps, SamplingCircuit::Shared] {
        for channel in &mut rig.channels {
            channel.adc.circuit = circuit;
        }
        for rate_hz in [100.0, 1000.0, 10_000.0] {
            rig.rate_hz = rate_hz;
            let counted = suite(|| SimulatedRig::new(&rig).unwrap_or_else(|e| panic!("{e}")));
            assert!(counted, "allocations have to be counted");
        }
    }
}

#[test]
fn it_allocates_nothing_while_faults_come_and_go() {
    use sinew_driver::{Backend, Sample, calls_of_this_thread};
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
