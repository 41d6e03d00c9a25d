//! Recordings in memory, made by the driver's own cycle over simulated wires.

use std::sync::Arc;

use sinew_backend::{Backend, Sample};
use sinew_driver::{Beat, Engine, Order, Program};
use sinew_ipc::{ChannelState, CycleHeader, DriverState, HeldCycle, Snapshot};
use sinew_replay::{Error, Replay, SessionCycle};
use sinew_replay_backend::{Cycles, Source};
use sinew_rig::Rig;
use sinew_sim_backend::{FaultHandle, SimulatedRig};

/// A recording in memory.
#[derive(Debug, Clone)]
pub struct Memory {
    pub cycles: Arc<Vec<(CycleHeader, Vec<ChannelState>)>>,
}

impl Source for Memory {
    type Cycle = SessionCycle;
    type Cycles = Memory;
    type Error = Error;

    fn channels(&self) -> usize {
        self.cycles[0].1.len()
    }

    fn cycles(&self) -> Result<Memory, Error> {
        Ok(self.clone())
    }
}

impl Cycles for Memory {
    type Cycle = SessionCycle;
    type Error = Error;

    fn each(self, see: &mut dyn FnMut(&SessionCycle) -> bool) -> Result<(), Error> {
        let held = |(header, states): &(CycleHeader, Vec<ChannelState>)| {
            SessionCycle(HeldCycle { header: *header, channels: states.clone().into() })
        };
        let _ = self.cycles.iter().all(|cycle| see(&held(cycle)));
        Ok(())
    }
}

/// What happens in a cycle of a script besides the cycle itself.
#[derive(Debug, Default)]
pub struct Turn {
    /// Periods missed before it.
    pub missed: u64,
    /// Requests taken before it.
    pub orders: Vec<Order>,
}

/// Runs a rig for so many cycles, in lockstep and late by some µs now and then, and keeps what a recorder would have.
pub fn record(
    rig: &Rig,
    program: Option<Program>,
    cycles: u64,
    mut script: impl FnMut(u64, &FaultHandle) -> Turn,
) -> Memory {
    let mut backend = SimulatedRig::new(rig).unwrap_or_else(|e| panic!("{e}"));
    let faults = backend.faults();
    let mut engine = Engine::at_rest(rig, program).unwrap_or_else(|e| panic!("{e}"));
    backend.start().unwrap();
    let channels = rig.channels.len();
    let (mut duty, mut samples) = (vec![0.0; channels], vec![Sample::NONE; channels]);
    let period_ns = (1e9 / rig.rate_hz).round() as u64;
    let (mut due_ns, mut missed) = (7_000_000_000_123, 0);
    let mut recorded = Vec::new();
    let mut state = Snapshot::new(channels);
    for cycle in 1..=cycles {
        let turn = script(cycle, &faults);
        if turn.missed > 0 {
            engine.come_late(turn.missed, &mut duty);
            backend.missed(turn.missed);
        }
        due_ns += (1 + turn.missed) * period_ns;
        missed += turn.missed;
        let now_ns = due_ns + cycle * 7919 % 60_000;
        samples.fill(Sample::NONE);
        let exchanged = backend.exchange(&duty, &mut samples);
        engine.note_outputs(&backend);
        for order in &turn.orders {
            engine.take(order, now_ns);
        }
        engine.cycle(Beat { now_ns, missed: turn.missed }, exchanged, &samples, &mut duty, |_| {});
        engine.describe(now_ns, DriverState::Running, &mut state);
        recorded.push((CycleHeader { cycle, monotonic_ns: now_ns, missed }, state.channels().to_vec()));
    }
    Memory { cycles: Arc::new(recorded) }
}

/// A recording replayed to its end.
pub fn replay_all(rig: &Rig, recording: &Memory) -> Replay<Memory> {
    let mut replay = Replay::new(rig, recording.clone()).unwrap_or_else(|e| panic!("{e}"));
    while replay.cycle(|_| {}).unwrap_or_else(|e| panic!("{e}")).is_some() {}
    assert_eq!(replay.comparison().cycles(), recording.cycles.len() as u64);
    replay
}
