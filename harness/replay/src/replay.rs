//! The driver's cycle run again over a recording, in lockstep: with the recorded beats, requests and samples.

use sinew_backend::{Backend, BackendError, Sample};
use sinew_control::StrokeRange;
use sinew_driver::heat::Recalled;
use sinew_driver::{Ask, Beat, Engine, Event, Order, Program};
use sinew_ipc::{ChannelState, CommandKind, CycleHeader, DriverState, Fault, Mode, Snapshot};
use sinew_replay_backend::{ReplayBackend, Source};
use sinew_rig::Rig;
use sinew_threads::Thread;

use crate::compare::Comparison;
use crate::error::Error;
use crate::session::SessionCycle;

/// How completely a recording says what the driver was in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Completeness {
    /// Number of the first recorded cycle: from 1 on everything is known, else the driver had a past.
    pub first_cycle: u64,
    /// Cycles the recording lacks between its first and its last.
    pub lost: u64,
    /// The first of them.
    pub first_lost: Option<u64>,
}

impl Completeness {
    /// Whether a replay with the same program and rig has to come out bit for bit the same.
    pub fn is_whole(&self) -> bool {
        self.first_cycle == 1 && self.lost == 0
    }
}

/// A recording on its way through the driver's sensing, estimation, supervision and control.
#[derive(Debug)]
pub struct Replay<S: Source<Cycle = SessionCycle, Error = Error>> {
    backend: ReplayBackend<S>,
    engine: Engine,
    /// Which channels turn a joint: there a force is a tension.
    in_joint: Vec<bool>,
    /// Lease of a request that was refused, ns, for each channel: how long it was to hold is not known.
    lease_ns: Vec<u64>,
    duty: Vec<f64>,
    samples: Vec<Sample>,
    /// Requests of the present cycle with their places in it.
    orders: Vec<(u32, Order)>,
    now: Snapshot,
    comparison: Comparison,
    complete: Completeness,
    /// Number and periods missed of the last cycle.
    before: Option<CycleHeader>,
    /// Whether the recorded cycle before shows that the machine had been suspended.
    slept: bool,
}

impl<S: Source<Cycle = SessionCycle, Error = Error>> Replay<S> {
    /// Of a recording, under this rig: the one it was recorded with, or another with as many channels.
    ///
    /// # Errors
    /// A rig the driver does not take or with another number of channels; a recording that cannot be read.
    pub fn new(rig: &Rig, source: S) -> Result<Replay<S>, Error> {
        let (found, expected) = (rig.channels.len(), source.channels());
        if found != expected {
            return Err(Error::Channels { expected, found });
        }
        let engine = Engine::at_rest(rig, Some(Program::given(found))).map_err(Error::Driver)?;
        let mut backend = ReplayBackend::new(source);
        if backend.start().is_err() {
            return Err(backend
                .trouble()
                .unwrap_or(Error::Driver(sinew_driver::Error::Backend(BackendError::Unavailable { os_error: 0 }))));
        }
        Ok(Replay {
            backend,
            engine,
            in_joint: (0..found).map(|channel| rig.joint_of(channel).is_some()).collect(),
            lease_ns: rig.channels.iter().map(|channel| (channel.limits.lease_s * 1e9) as u64).collect(),
            duty: vec![0.0; found],
            samples: vec![Sample::NONE; found],
            orders: Vec::with_capacity(found),
            now: Snapshot::new(found),
            comparison: Comparison::new(found),
            complete: Completeness::default(),
            before: None,
            slept: false,
        })
    }

    /// One cycle: what was recorded and what comes out now; `tell` hears what happens meanwhile. `None` at the end.
    ///
    /// # Errors
    /// Where the recording cannot be read on.
    pub fn cycle(&mut self, tell: impl FnMut(Event)) -> Result<Option<(&[ChannelState], &Snapshot)>, Error> {
        let Some(between) = self.backend.advance()?.map(|(between, _)| between) else {
            return if self.backend.has_lost_its_reader() { Err(Error::Died(Thread::Reader)) } else { Ok(None) };
        };
        let cycle = self.backend.recorded();
        let head = cycle.0.header;
        // The driver also passed the periods missed before its first cycle to its channels.
        let missed = if head.cycle == 1 { head.missed } else { between };
        self.keep_count(&head);
        if between > 0 {
            self.engine.come_late(missed, &mut self.duty);
            self.backend.missed(between);
        }
        let exchanged = self.backend.exchange(&self.duty, &mut self.samples);
        self.engine.note_outputs(&self.backend);
        let stopped = |state: &ChannelState| state.flags & ChannelState::FLAG_STOPPED != 0;
        self.engine.hold(self.backend.recorded().0.channels.iter().any(stopped));
        self.command(&head);
        if head.cycle == 1 {
            // What the driver believed of its wires when it began.
            for (channel, state) in self.backend.recorded().0.channels.iter().enumerate() {
                self.engine.remember(channel, state.temperature_c, f64::NAN);
            }
        }
        if self.before.is_none() && head.cycle > 1 {
            self.begin_later();
        }
        // No sample shows a suspended machine; its fault does.
        let slept = self.backend.recorded().0.channels.iter().any(|state| state.fault == Fault::Suspended.code());
        if slept && !self.slept {
            // for how long no recording says
            self.engine.was_suspended(0.0);
        }
        self.slept = slept;
        let beat = Beat { now_ns: head.monotonic_ns, missed };
        self.engine.cycle(beat, exchanged, &self.samples, &mut self.duty, tell);
        (self.now.cycle, self.now.monotonic_ns, self.now.missed) = (head.cycle, head.monotonic_ns, head.missed);
        self.engine.describe(head.monotonic_ns, DriverState::Running, &mut self.now);
        let recorded = &self.backend.recorded().0.channels;
        self.comparison.add(&head, recorded, self.now.channels());
        // What went out then is what heats these wires, whatever was decided now.
        for (channel, state) in recorded.iter().enumerate() {
            self.engine.was_given(channel, state.duty);
            self.duty[channel] = state.duty;
        }
        self.before = Some(head);
        Ok(Some((recorded, &self.now)))
    }

    /// What differs so far.
    pub fn comparison(&self) -> &Comparison {
        &self.comparison
    }

    /// How completely the recording says what the driver was in, so far.
    pub fn completeness(&self) -> Completeness {
        self.complete
    }

    /// The estimators begin at the temperatures that were published then, as after a restart.
    fn begin_later(&mut self) {
        for (channel, state) in self.backend.recorded().0.channels.iter().enumerate() {
            let temperature_c = state.temperature_c;
            let (surely_c, account_j) = (f64::NAN, f64::NAN);
            self.engine.recall(channel, &Recalled { temperature_c, surely_c, account_j, given_w: 0.0, since_s: 0.0 });
        }
    }

    fn keep_count(&mut self, head: &CycleHeader) {
        match self.before {
            None => self.complete.first_cycle = head.cycle,
            Some(before) => {
                let lost = head.cycle.saturating_sub(before.cycle + 1);
                if lost > 0 {
                    self.complete.first_lost.get_or_insert(before.cycle + 1);
                }
                self.complete.lost += lost;
            }
        }
    }

    /// Asks of the engine what was asked then, and gives it what the driver's own program wanted then.
    fn command(&mut self, head: &CycleHeader) {
        let begins = self.before.is_none() && head.cycle != 1;
        self.orders.clear();
        for (channel, state) in self.backend.recorded().0.channels.iter().enumerate() {
            // Without an order, a recording that begins later still contains the target in force.
            let (kind, place) = match state.order() {
                Some(order) => order,
                None => match in_force(state).filter(|_| begins) {
                    Some(kind) => (kind, channel as u32 + 1),
                    None => continue,
                },
            };
            let ask = match kind {
                CommandKind::Reset => Ask::Reset,
                CommandKind::Off => Ask::Off,
                CommandKind::Duty if !state.asked.is_finite() && state.mode() == Mode::Lapsed => Ask::Duty(0.0),
                // It fell to a fault in the same cycle.
                _ if !state.asked.is_finite() => continue,
                CommandKind::Duty => Ask::Duty(state.asked),
                CommandKind::Force if self.in_joint[channel] => Ask::Tension(state.asked),
                CommandKind::Force => Ask::Force(state.asked),
                _ => Ask::Length(state.asked),
            };
            let hold_ns = match state.lease_s {
                // over before it began: that is how a lease that ran out then runs out again
                _ if begins && state.order().is_none() && state.mode() == Mode::Lapsed => 0,
                lease_s if lease_s.is_nan() => self.lease_ns[channel],
                // Seconds were made of whole nanoseconds, and become them again.
                lease_s if lease_s.is_finite() => (lease_s * 1e9).round() as u64,
                _ => u64::MAX,
            };
            self.orders.push((place, Order { ticket: 0, channel, ask, hold_ns }));
        }
        self.orders.sort_by_key(|(place, _)| *place);
        for (_, order) in &self.orders {
            // The recorded client has its answer already.
            let _ = self.engine.take(order, head.monotonic_ns);
        }
        for (channel, state) in self.backend.recorded().0.channels.iter().enumerate() {
            let by_program = state.lease_s == f64::INFINITY && state.target_m.is_finite();
            let stroke = by_program.then(|| stroke_at(&self.engine.channels()[channel].stroke_range(), state.target_m));
            if let Some(program) = self.engine.program_mut() {
                program.give(channel, stroke);
            }
        }
    }
}

/// The stroke that [`StrokeRange::length_m`] makes exactly this length of, where there is one; else the nearest.
fn stroke_at(range: &StrokeRange, length_m: f64) -> f64 {
    let near = range.stroke(length_m);
    // a stroke resolves lengths far below their last bit: half of such a bit is a step, and rounding is a few of them
    let step = 0.5 * (length_m.next_up() - length_m) / range.stroke_m();
    let tried = (-8..=8).map(|k| near + f64::from(k) * step);
    tried.into_iter().find(|stroke| range.length_m(*stroke) == length_m).unwrap_or(near)
}

/// The request that has to have been made for a channel to be where it is; `None` where nobody commands it.
fn in_force(state: &ChannelState) -> Option<CommandKind> {
    match state.mode() {
        Mode::Lapsed => Some(CommandKind::Duty),
        Mode::Off if !state.lease_s.is_nan() => Some(CommandKind::Off),
        Mode::Length if state.asked.is_finite() => Some(CommandKind::Length),
        Mode::Force if state.asked.is_finite() => Some(CommandKind::Force),
        Mode::Duty if state.asked.is_finite() => Some(CommandKind::Duty),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_length_that_came_from_a_stroke_comes_from_one_again(
            cold_m in 0.01..2.0f64,
            share in 0.001..0.09f64,
            stroke in 0.0..=1.0f64,
        ) {
            let range = StrokeRange { cold_m, hot_m: cold_m * (1.0 - share) };
            let length_m = range.length_m(stroke);
            prop_assert_eq!(range.length_m(stroke_at(&range, length_m)), length_m);
        }
    }
}
