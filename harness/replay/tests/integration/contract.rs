//! The conformance suite for backends, over a recording of simulated wires that were driven all the time.

use crate::common::{Memory, Turn, record};
use sinew_backend::conformance::{Bench, suite};
use sinew_backend::{Backend, BackendError, Sample};
use sinew_driver::{Ask, Order};
use sinew_replay_backend::ReplayBackend;
use sinew_rig::{Rig, SamplingCircuit};

/// A recording, replayed from its beginning by every backend.
struct Recorded(Memory);

impl Bench for Recorded {
    type Backend = ReplayBackend<Memory>;

    fn backend(&mut self) -> ReplayBackend<Memory> {
        ReplayBackend::new(self.0.clone())
    }
}

#[test]
fn it_keeps_the_contract_of_backends() {
    for circuit in [SamplingCircuit::SeparateTaps, SamplingCircuit::Shared] {
        let mut rig = Rig::hexapod();
        rig.channels.iter_mut().for_each(|channel| channel.adc.circuit = circuit);
        let recording = record(&rig, None, 600, |_, _| Turn::default());
        let findings = suite(&mut Recorded(recording));
        assert!(findings.counts_allocations, "{findings:?}");
        assert_eq!(findings.skipped.len(), 2, "a recording cannot be unplugged, and breaks as it broke then");
    }
}

#[test]
fn it_brings_back_the_samples_of_then_and_nothing_beyond() {
    let rig = Rig::hexapod();
    let recording = record(&rig, None, 40, |cycle, _| {
        let order = Order { ticket: 0, channel: 3, ask: Ask::Duty(0.2), hold_ns: u64::MAX };
        Turn { missed: if cycle == 20 { 2 } else { 0 }, orders: if cycle == 15 { vec![order] } else { Vec::new() } }
    });
    let mut backend = ReplayBackend::new(recording.clone());
    backend.start().unwrap();
    let (mut samples, sensing) = (vec![Sample::NONE; 18], vec![0.02; 18]);
    let mut period = 0;
    for (head, states) in recording.cycles.iter() {
        // as the recorded loop had it: nothing before the first cycle, the sensing pulse from then on
        let duty = if head.cycle == 1 { vec![0.0; 18] } else { sensing.clone() };
        let missed = head.cycle + head.missed - period - 1;
        if missed > 0 {
            backend.missed(missed);
        }
        period = head.cycle + head.missed;
        assert_eq!(backend.exchange(&duty, &mut samples), Ok(()));
        for (sample, state) in samples.iter().zip(states) {
            let found = [sample.v1_v, sample.v2_v, sample.v3_v, sample.current_a, sample.supply_v];
            let expected = [state.v1_v, state.v2_v, state.v3_v, state.current_a, state.supply_v];
            assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "cycle {}", head.cycle);
        }
    }
    let over = Err(BackendError::Unavailable { os_error: 0 });
    assert_eq!(backend.exchange(&sensing, &mut samples), over);
    assert!(samples.iter().all(|sample| sample.supply_v.is_nan()));
}

#[test]
fn a_period_without_a_cycle_and_a_wire_driven_otherwise_have_no_sample() {
    let rig = Rig::hexapod();
    let recording = record(&rig, None, 40, |cycle, _| Turn { missed: u64::from(cycle == 20), orders: Vec::new() });
    let mut backend = ReplayBackend::new(recording);
    backend.start().unwrap();
    let (mut samples, mut duty) = (vec![Sample::NONE; 18], vec![0.02; 18]);
    duty[5] = 0.0;
    for period in 1..=30 {
        backend.exchange(&duty, &mut samples).unwrap();
        match period {
            20 => assert!(samples.iter().all(|sample| sample.supply_v.is_nan()), "a missed period"),
            10.. => {
                assert!(samples[4].current_a.is_finite() && samples[4].v1_v.is_finite(), "{period}: {:?}", samples[4]);
                assert!(samples[5].current_a.is_nan() && samples[5].v1_v.is_nan(), "not driven now");
                assert!(samples[5].supply_v.is_finite(), "the supply is there whatever is driven");
            }
            _ => {}
        }
    }
}
