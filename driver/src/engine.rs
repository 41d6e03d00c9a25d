//! A cycle of all channels without clock, thread or backend: samples in, duties out. Used by the loop, the tests and the
//! benchmarks.

use sinew_backend::{Backend, BackendError, Sample};
use sinew_ipc::{ChannelState, DriverState, Fault, MAX_CHANNELS, Mode, Snapshot};
use sinew_rig::{EnableSignal, Rig};

use crate::channel::{Channel, Happened, Source, Target, Tick};
use crate::error::Error;
use crate::heat::Recalled;
use crate::joint::Joint;
use crate::orders::{Answer, Ask, Beat, Event, Occurrence, Order};
use crate::program::Program;
use crate::supervisor::{Change, Punctuality};

/// How many periods hardware may take to forget a fault it has latched: there and back, and some to spare.
const CLEAR_PERIODS: u32 = 8;

/// All channels of a rig.
#[derive(Debug, Clone)]
pub struct Engine {
    channels: Vec<Channel>,
    joints: Vec<Joint>,
    /// The joint and the side (0 = agonist) of each channel that turns one.
    places: Vec<Option<(usize, usize)>>,
    /// The order each channel's reset is to be answered to.
    resets: Vec<Option<u64>>,
    /// Channels whose hardware was asked to forget a fault: how many periods more it may take.
    clearing: Vec<u32>,
    /// The ticket of the last `off` each channel has taken: what was asked for before it is not carried out.
    overtook: Vec<u64>,
    program: Option<Program>,
    punctuality: Punctuality,
    /// How long the machine was suspended since the last cycle, s.
    suspended_s: Option<f64>,
    /// The channel whose fault was the first of those that are latched.
    first: Option<usize>,
    /// Whether any was latched at the end of the last cycle; only a cycle latches or clears.
    latched: bool,
    /// An emergency stop holds everything off.
    stopped: bool,
    /// Where a line switches the supply: how long that takes to stand, s.
    settle_s: Option<f64>,
    /// How long it still takes, s.
    settling_s: f64,
    /// All channels are latched, so that nobody needs the supply.
    rests: bool,
    /// An output stage cannot be switched off: everything stays off until the driver is started anew.
    cut: bool,
    /// How the last exchange went.
    exchanged: Result<(), BackendError>,
    period_s: f64,
    start_ns: Option<u64>,
}

impl Engine {
    /// The channels of a rig of which nothing is known: every wire may be at its limit. `program` is what they do while nobody
    /// commands them.
    ///
    /// # Errors
    /// [`Error::Rig`] where a channel cannot be driven or measured.
    pub fn new(rig: &Rig, program: Option<Program>) -> Result<Engine, Error> {
        let mut engine = Engine::at_rest(rig, program)?;
        engine.channels.iter_mut().for_each(|channel| channel.guard.heat_mut().forget());
        Ok(engine)
    }

    /// The channels of a rig whose wires are known to be at rest in their air, as simulated ones are when they are new.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn at_rest(rig: &Rig, program: Option<Program>) -> Result<Engine, Error> {
        rig.check_drivable().map_err(|error| Error::Rig { place: rig.name.clone(), reason: error.to_string() })?;
        let channels: Vec<Channel> =
            (0..rig.channels.len()).map(|index| Channel::new(rig, index)).collect::<Result<_, _>>()?;
        let joints: Vec<Joint> = rig.joints.iter().map(|joint| Joint::new(rig, joint)).collect::<Result<_, _>>()?;
        let enable = &rig.backend.enable;
        // And two periods for the way there.
        let settle_s = (enable.signal != EnableSignal::None).then_some(enable.settle_s + 2.0 / rig.rate_hz);
        let mut places = vec![None; channels.len()];
        for (index, joint) in joints.iter().enumerate() {
            for (side, &channel) in joint.channels.iter().enumerate() {
                places[channel] = Some((index, side));
            }
        }
        Ok(Engine {
            joints,
            places,
            resets: vec![None; channels.len()],
            overtook: vec![0; channels.len()],
            clearing: vec![0; channels.len()],
            channels,
            program,
            punctuality: Punctuality::default(),
            suspended_s: None,
            first: None,
            latched: false,
            stopped: false,
            settle_s,
            settling_s: settle_s.unwrap_or(0.0),
            rests: false,
            cut: false,
            exchanged: Ok(()),
            period_s: 1.0 / rig.rate_hz,
            start_ns: None,
        })
    }

    /// The channels, in the rig's order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// What a memory says of a wire before the first cycle: that it may be this hot, °C, and its heat account, J. NaN: nothing.
    pub fn remember(&mut self, channel: usize, temperature_c: f64, account_j: f64) {
        if let Some(channel) = self.channels.get_mut(channel) {
            channel.guard.heat_mut().remember(temperature_c, account_j);
        }
    }

    /// Another duty than the last cycle decided on went out for a channel, 0 ..= 1: that of the recording it is replayed from.
    pub fn was_given(&mut self, channel: usize, duty: f64) {
        if let Some(channel) = self.channels.get_mut(channel) {
            channel.was_given(duty);
        }
    }

    /// What a record of an output says of its wire, before the first cycle.
    pub fn recall(&mut self, channel: usize, recalled: &Recalled) {
        if let Some(channel) = self.channels.get_mut(channel) {
            channel.recall(recalled);
        }
    }

    /// A wire of unknown history to which, before the first cycle, nothing was given for so long, s.
    pub fn was_unused(&mut self, channel: usize, since_s: f64) {
        if let Some(channel) = self.channels.get_mut(channel) {
            channel.guard.heat_mut().was_unused(since_s);
        }
    }

    /// How long an output can stay as it is with a dead driver, s, where that is not what the rig file's backend says.
    pub fn bear_silence(&mut self, silence_s: f64) {
        self.channels.iter_mut().for_each(|channel| channel.guard.heat_mut().bear_silence(silence_s));
    }

    /// What the backend knows of its outputs after an exchange, before the cycle: whether the duty of each is the one that was asked for
    /// (zero, where the exchange failed), which have failed, and whether they were out of sight. Without a call all are, and none has but the one
    /// the exchange names.
    #[inline]
    pub fn note_outputs(&mut self, backend: &impl Backend) {
        // Somebody else may have driven them meanwhile.
        if let Some(unused_s) = backend.regained() {
            self.channels.iter_mut().for_each(|channel| channel.guard.heat_mut().was_unused(unused_s));
        }
        for (index, channel) in self.channels.iter_mut().enumerate() {
            channel.note_output(backend.is_confirmed(index), backend.failure(index));
        }
    }

    /// Asks the backend to forget what it has latched of the channels that were reset since the last cycle.
    #[inline]
    pub fn clear(&self, backend: &mut impl Backend) {
        for (index, left) in self.clearing.iter().enumerate() {
            if *left == CLEAR_PERIODS {
                backend.clear(index);
            }
        }
    }

    /// Whether the last exchange has failed for a channel, or as a whole.
    fn is_failing(&self, channel: usize) -> bool {
        match self.exchanged {
            Ok(()) => false,
            Err(BackendError::Channel { channel: named, .. }) if (named as usize) < self.channels.len() => {
                named as usize == channel || self.channels[channel].failure.is_some()
            }
            Err(_) => true,
        }
    }

    /// Before an exchange that comes late, by so many periods: holds back what the last cycle decided, which did not know that its predecessor
    /// would be in force for so long. Two stalls with a cycle in between would otherwise heat like one twice as long.
    #[inline]
    pub fn come_late(&mut self, missed: u64, duty: &mut [f64]) {
        let seconds = missed as f64 * self.period_s;
        for (channel, duty) in self.channels.iter_mut().zip(duty) {
            channel.come_late(seconds);
            *duty = channel.duty;
        }
    }

    /// The joints, in the rig's order.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The channel at the other end of the joint that a channel turns.
    fn partner(&self, channel: usize) -> Option<usize> {
        let (joint, side) = self.places[channel]?;
        Some(self.joints[joint].channels[1 - side])
    }

    /// What a channel is to do now, or does where that is of another kind, in the unit of what is asked for: where the way there begins. `None`
    /// where there is no way there.
    #[inline]
    pub(crate) fn wanted_or_present(&self, channel: usize, ask: Ask) -> Option<f64> {
        let channel = self.channels.get(channel)?;
        match ask {
            Ask::Length(_) | Ask::Force(_) => Some(channel.wanted_or_present_m()),
            Ask::Duty(_) => Some(if let Target::Duty(duty) = channel.target { duty } else { channel.duty }),
            Ask::Tension(_) | Ask::Off | Ask::Reset => None,
        }
    }

    /// Whether a channel does what was asked of it with a lease until then, and nothing else has come in between.
    #[inline]
    pub(crate) fn obeys(&self, channel: usize, ask: Ask, until_ns: u64) -> bool {
        let target = match ask {
            Ask::Length(length_m) => Target::Length(length_m),
            Ask::Force(length_m) => Target::Force(length_m),
            Ask::Duty(duty) => Target::Duty(duty),
            Ask::Tension(_) | Ask::Off | Ask::Reset => return false,
        };
        let channel = &self.channels[channel];
        !channel.has_order() && channel.target == target && channel.source == Source::Client { until_ns }
    }

    /// Whether a channel has taken an order since the last cycle: a cycle has room for one, see
    /// [`ChannelState::order`](sinew_ipc::ChannelState::order). A second one would be taken all the same, and only that recorded.
    #[inline]
    pub fn has_order(&self, channel: usize) -> bool {
        self.channels.get(channel).is_some_and(Channel::has_order)
    }

    /// Whether an `off`, or an order for several channels, that was asked for later than this order has been taken already. A reset is not
    /// overtaken: it moves nothing.
    #[inline]
    pub fn is_overtaken(&self, order: &Order) -> bool {
        order.ask != Ask::Reset && self.overtook.get(order.channel).is_some_and(|last| order.ticket < *last)
    }

    /// What was asked of this channel before it, and of the other end of its joint, is overtaken by this order.
    fn overtake(&mut self, order: &Order) {
        for channel in self.partner(order.channel).into_iter().chain([order.channel]) {
            self.overtook[channel] = self.overtook[channel].max(order.ticket);
        }
    }

    /// Why a setpoint or an `off` would not be taken now.
    #[inline]
    fn objection(&self, order: &Order) -> Option<Answer> {
        if self.is_overtaken(order) {
            return Some(Answer::Overtaken);
        }
        if order.ask == Ask::Off {
            // A faulted channel is off already.
            return None;
        }
        let fault = |channel: usize| self.channels[channel].guard.fault();
        let moves = matches!(order.ask, Ask::Length(_) | Ask::Force(_) | Ask::Tension(_));
        let of_joint = || self.partner(order.channel).filter(|_| moves).and_then(fault);
        fault(order.channel).or_else(of_joint).map(Answer::Latched)
    }

    /// Takes setpoints for several channels before a cycle at `now_ns`, all or none; `tell` hears the answer to each.
    #[inline]
    pub fn take_together(&mut self, orders: &[Order], now_ns: u64, mut tell: impl FnMut(&Order, Answer)) {
        if orders.iter().any(|order| self.objection(order).is_some()) {
            for order in orders {
                tell(order, self.objection(order).unwrap_or(Answer::WithOthers));
            }
            return;
        }
        for order in orders {
            self.overtake(order);
            if let Some(answer) = self.take(order, now_ns) {
                tell(order, answer);
            }
        }
    }

    /// Whether an output stage conducts with its gate closed, an emergency stop is latched, or all channels are, so that the supply has to, or
    /// may as well, be taken from all: the backend is to be told so, see [`Backend::cut`](sinew_backend::Backend::cut). What is
    /// latched may be blind, and whether its stage conducts nobody sees then.
    #[inline]
    pub fn must_cut(&self) -> bool {
        self.cut || self.stopped || self.rests
    }

    /// Whether an [emergency stop](crate::EmergencyStop) holds everything off, from the next cycle on.
    #[inline]
    pub fn hold(&mut self, is_stopped: bool) {
        self.stopped = is_stopped;
    }

    /// The channel whose fault was the first of those that are latched now; of several in the same cycle the lowest, and none
    /// that only follows from another's.
    pub fn first_to_fail(&self) -> Option<usize> {
        self.first
    }

    /// What the channels do while nobody commands them, to be changed between cycles.
    pub fn program_mut(&mut self) -> Option<&mut Program> {
        self.program.as_mut()
    }

    /// The machine was suspended since the last cycle, for so long, s: the next one switches everything off. Its clock stood still
    /// meanwhile, so that leases do not know; the outputs may have been as they were left all along.
    #[inline]
    pub fn was_suspended(&mut self, seconds: f64) {
        self.suspended_s = Some(seconds);
    }

    /// Takes an order before a cycle at `now_ns`. `None`: the answer comes later, as an event.
    #[inline]
    pub fn take(&mut self, order: &Order, now_ns: u64) -> Option<Answer> {
        if self.is_overtaken(order) {
            return Some(Answer::Overtaken);
        }
        let place = 1 + self.channels.iter().filter(|channel| channel.has_order()).count() as u32;
        self.channels[order.channel].note(order.ask, place);
        let partner = self.partner(order.channel);
        if order.ask == Ask::Off {
            // One end of a joint moves the other.
            self.overtake(order);
        }
        let (is_failing, is_whole) =
            (self.is_failing(order.channel), self.exchanged.is_err_and(|error| error.channel().is_none()));
        let partners_fault = partner.and_then(|partner| self.channels[partner].guard.fault());
        // A faulted channel is off already; requesting `off` is not an error.
        let objection = if order.ask == Ask::Reset { None } else { self.objection(order) };
        let channel = &mut self.channels[order.channel];
        let target = match order.ask {
            Ask::Length(length_m) => Target::Length(length_m),
            Ask::Force(length_m) => Target::Force(length_m),
            // where it is to be already, else where it is
            Ask::Tension(_) => Target::Force(channel.wanted_or_present_m()),
            Ask::Duty(duty) => Target::Duty(duty),
            Ask::Off => Target::Idle,
            Ask::Reset => {
                if self.stopped && channel.guard.fault().is_some() {
                    return Some(Answer::CauseRemains(Fault::EmergencyStop));
                }
                // An output that may still be on is no place to begin anew from.
                if let Some(fault) = channel.guard.fault()
                    && !channel.is_confirmed()
                {
                    return Some(Answer::CauseRemains(fault));
                }
                // What the channel itself cannot know: whether backend and loop are well again.
                if let Some(fault) = channel.guard.fault()
                    && (is_whole || !self.punctuality.on_time())
                    && matches!(fault, Fault::Backend | Fault::CycleOverrun)
                {
                    return Some(Answer::CauseRemains(fault));
                }
                // Without supply no channel can finish proving.
                if self.cut && channel.guard.fault().is_some() {
                    let stuck = channel.guard.must_cut();
                    return Some(Answer::CauseRemains(if stuck { Fault::StageOn } else { Fault::SupplyCut }));
                }
                // The partner's fault is the cause.
                if let Some(fault @ Fault::JointPartner) = channel.guard.fault()
                    && partners_fault.is_some_and(|cause| cause != Fault::JointPartner)
                {
                    return Some(Answer::CauseRemains(fault));
                }
                // What its hardware has latched it may forget; whether it does, the next exchanges tell.
                if channel.guard.fault().is_some() {
                    self.clearing[order.channel] = CLEAR_PERIODS;
                    if is_failing {
                        self.resets[order.channel] = Some(order.ticket);
                        return None;
                    }
                }
                return match channel.guard.reset() {
                    Err(fault) => Some(channel.refuse_reset(fault)),
                    Ok(false) => Some(Answer::Done),
                    Ok(true) => {
                        // A repeated reset during proving: the later one gets the result.
                        self.resets[order.channel] = Some(order.ticket);
                        None
                    }
                };
            }
        };
        if objection.is_some() {
            return objection;
        }
        if channel.guard.fault().is_some() {
            return Some(Answer::Done);
        }
        let source = Source::Client { until_ns: now_ns.saturating_add(order.hold_ns) };
        channel.obey(target, source);
        if let (Some((joint, side)), Some(partner)) = (self.places[order.channel], partner) {
            let other = &mut self.channels[partner];
            other.note_partners();
            let joint = &mut self.joints[joint];
            joint.set_tension(if let Ask::Tension(tension_n) = order.ask { Some(tension_n) } else { None });
            match target {
                Target::Length(length_m) => other.obey(Target::Length(joint.opposite_m(side, length_m)), source),
                Target::Force(length_m) => other.obey(Target::Force(joint.opposite_m(side, length_m)), source),
                Target::Idle if other.guard.fault().is_none() => other.obey(Target::Idle, source),
                // A duty commands one wire alone; the joint is then without a target.
                _ if matches!(other.target, Target::Length(_) | Target::Force(_)) => {
                    other.obey(Target::Idle, Source::Nobody)
                }
                _ => {}
            }
        }
        Some(Answer::Done)
    }

    /// One cycle: what `exchange` brought in, the duties of the next period out. Constant time for a rig, no allocation.
    #[inline]
    pub fn cycle(
        &mut self,
        beat: Beat,
        exchanged: Result<(), BackendError>,
        samples: &[Sample],
        duty: &mut [f64],
        mut tell: impl FnMut(Event),
    ) {
        // The samples are a whole number of periods apart, however late the loop woke.
        let awake_s = self.period_s * (1 + beat.missed) as f64;
        let dt_s = awake_s + self.suspended_s.unwrap_or(0.0);
        let tick = Tick { now_ns: beat.now_ns, dt_s };
        let time_s = (beat.now_ns - *self.start_ns.get_or_insert(beat.now_ns)) as f64 * 1e-9;
        let outside = self.faults_from_outside(&beat, awake_s, exchanged, &mut tell);
        self.exchanged = exchanged;

        self.finish_clearing(&beat, &mut tell);
        let sample = |index: usize| if outside.has_no_samples() { Sample::NONE } else { samples[index] };
        let program = |index: usize| self.program.as_ref().and_then(|program| program.stroke(index, time_s));
        if self.first.is_some_and(|index| self.channels[index].guard.fault().is_none()) {
            self.first = None;
        }
        let mut reports = Reports {
            at_ns: beat.now_ns,
            resets: &mut self.resets,
            none_latched: self.first.is_none() && !self.latched,
            first: self.first,
            tell,
        };

        for (index, channel) in self.channels.iter_mut().enumerate() {
            if self.places[index].is_some() {
                continue;
            }
            let before = outside.of(index, channel).and_then(|fault| channel.trip(fault));
            let happened = channel.step(&sample(index), &tick, program(index));
            duty[index] = channel.duty;
            reports.add(index, before, happened);
        }
        for joint in &mut self.joints {
            let [agonist, antagonist] = joint.channels;
            let Ok([forward, back]) = self.channels.get_disjoint_mut([agonist, antagonist]) else { continue };
            let before = [
                outside.of(agonist, forward).and_then(|fault| forward.trip(fault)),
                outside.of(antagonist, back).and_then(|fault| back.trip(fault)),
            ];
            let samples = [&sample(agonist), &sample(antagonist)];
            let tripped = before.map(|change| change.is_some());
            let happened = joint.step([forward, back], samples, tripped, &tick, program(agonist));
            for (side, index) in [agonist, antagonist].into_iter().enumerate() {
                duty[index] = self.channels[index].duty;
                reports.add(index, before[side], happened[side]);
            }
        }
        self.latched = false;
        for channel in &self.channels {
            self.latched |= channel.guard.fault().is_some();
            self.cut |= channel.guard.must_cut();
        }
        if self.cut {
            for (index, channel) in self.channels.iter_mut().enumerate() {
                let change = channel.cut_off();
                duty[index] = 0.0;
                reports.add(index, None, Happened { change, lapsed: false });
            }
        }
        self.first = reports.first;
        self.settle(tick.dt_s, duty);
    }

    /// Gives nothing to anybody while the supply does not stand.
    #[inline]
    fn settle(&mut self, dt_s: f64, duty: &mut [f64]) {
        let Some(settle_s) = self.settle_s else { return };
        self.rests = self.channels.iter().all(|channel| channel.guard.is_latched());
        if self.must_cut() {
            self.settling_s = settle_s;
        } else if self.settling_s > 0.0 {
            self.settling_s -= dt_s;
            for (channel, duty) in self.channels.iter_mut().zip(duty) {
                channel.rest();
                *duty = 0.0;
            }
        }
    }

    /// Goes on with resets that wait for hardware to forget its fault.
    #[inline]
    fn finish_clearing(&mut self, beat: &Beat, tell: &mut impl FnMut(Event)) {
        for index in 0..self.channels.len() {
            if self.clearing[index] == 0 {
                continue;
            }
            let is_failing = self.is_failing(index);
            self.clearing[index] = if is_failing { self.clearing[index] - 1 } else { 0 };
            let answer = match self.resets[index] {
                None => None,
                Some(_) if is_failing => (self.clearing[index] == 0).then_some(Answer::CauseRemains(Fault::Backend)),
                Some(_) if self.stopped => Some(Answer::CauseRemains(Fault::EmergencyStop)),
                Some(_) => match self.channels[index].guard.reset() {
                    Ok(true) => None,
                    Ok(false) => Some(Answer::Done),
                    Err(fault) => Some(self.channels[index].refuse_reset(fault)),
                },
            };
            if let Some(answer) = answer
                && let Some(ticket) = self.resets[index].take()
            {
                let what = Occurrence::Answered { ticket, answer };
                tell(Event { at_ns: beat.now_ns, channel: index as u32, what });
            }
        }
    }

    /// What loop, machine and backend report of a cycle before any sample is looked at.
    #[inline]
    fn faults_from_outside(
        &mut self,
        beat: &Beat,
        dt_s: f64,
        exchanged: Result<(), BackendError>,
        tell: &mut impl FnMut(Event),
    ) -> Outside {
        let mut outside = Outside {
            everything: self.punctuality.lost(beat.missed, dt_s).then_some(Fault::CycleOverrun),
            failed: None,
        };
        if self.suspended_s.take().is_some() {
            outside.everything = Some(Fault::Suspended);
        }
        if self.stopped {
            outside.everything = Some(Fault::EmergencyStop);
        }
        let Err(error) = exchanged else { return outside };
        match error {
            BackendError::Channel { channel, .. } if (channel as usize) < self.channels.len() => {
                outside.failed = Some(channel as usize);
            }
            // An unknown channel, or a duty that kept all others from being output: no sample is trusted.
            _ => outside.everything = Some(Fault::Backend),
        }
        if exchanged != self.exchanged {
            let channel = error.channel().unwrap_or(0) as u32;
            tell(Event { at_ns: beat.now_ns, channel, what: Occurrence::Complained(error) });
        }
        outside
    }

    /// Writes the state after a cycle into a snapshot: copies, no allocation. Its cycle number, time and count of missed periods
    /// are the loop's to fill in.
    #[inline]
    pub fn describe(&self, now_ns: u64, state: DriverState, snapshot: &mut Snapshot) {
        snapshot.state = state.code();
        snapshot.channels = self.channels.len().min(MAX_CHANNELS) as u32;
        let (code, whom) = match self.exchanged {
            Ok(()) => (0, None),
            Err(error @ BackendError::Channel { channel, .. }) => (error.code(), Some(channel as usize)),
            Err(error) => (error.code(), None),
        };
        for (index, (channel, state)) in self.channels.iter().zip(&mut snapshot.channel).enumerate() {
            channel.describe(now_ns, state);
            state.flags |= if self.first == Some(index) { ChannelState::FLAG_FIRST } else { 0 };
            state.flags |= if self.stopped { ChannelState::FLAG_STOPPED } else { 0 };
            state.backend = match whom {
                None => code,
                Some(whom) if whom == index => code,
                Some(_) => channel.failure.map_or(0, |fault| BackendError::Channel { channel: 0, fault }.code()),
            };
        }
    }
}

/// The faults of a cycle that come from outside of the channels.
struct Outside {
    /// Concerns all of them.
    everything: Option<Fault>,
    /// The lowest of the channels whose hardware failed, the others being good.
    failed: Option<usize>,
}

impl Outside {
    #[inline]
    fn of(&self, index: usize, channel: &Channel) -> Option<Fault> {
        let failed = self.failed.is_some_and(|lowest| lowest == index || channel.failure.is_some());
        self.everything.or(failed.then_some(Fault::Backend))
    }

    #[inline]
    fn has_no_samples(&self) -> bool {
        self.everything == Some(Fault::Backend)
    }
}

/// Makes events of what happened to the channels in a cycle, and finds the first fault among them.
struct Reports<'a, F> {
    at_ns: u64,
    resets: &'a mut [Option<u64>],
    /// Whether no fault was latched before this cycle: only then can one be the first.
    none_latched: bool,
    first: Option<usize>,
    tell: F,
}

impl<F: FnMut(Event)> Reports<'_, F> {
    #[inline]
    fn add(&mut self, index: usize, before: Option<Change>, happened: Happened) {
        let (at_ns, channel) = (self.at_ns, index as u32);
        let event = |what| Event { at_ns, channel, what };
        if happened.lapsed {
            (self.tell)(event(Occurrence::Lapsed));
        }
        let (what, answer) = match before.or(happened.change) {
            None => return,
            Some(Change::Tripped(fault)) => {
                if self.none_latched && !fault.follows_another() {
                    self.first = Some(self.first.map_or(index, |first| first.min(index)));
                }
                (Occurrence::Tripped(fault), Answer::CauseRemains(fault))
            }
            Some(Change::Proved) => (Occurrence::Proved, Answer::Done),
        };
        (self.tell)(event(what));
        if let Some(ticket) = self.resets[index].take() {
            (self.tell)(event(Occurrence::Answered { ticket, answer }));
        }
    }
}

impl Channel {
    /// What a reset is answered that the supervisor does not take.
    fn refuse_reset(&self, fault: Fault) -> Answer {
        match self.guard.cooldown().filter(|_| !fault.needs_restart()) {
            Some(cooldown) => Answer::TooHot(fault, cooldown),
            None => Answer::CauseRemains(fault),
        }
    }

    #[inline]
    fn describe(&self, now_ns: u64, state: &mut ChannelState) {
        let latched = self.guard.fault();
        let mode = match (latched, self.source, self.target) {
            (Some(_), ..) => Mode::Fault,
            _ if self.guard.is_proving() => Mode::Waiting,
            (None, Source::Program, _) => Mode::Program,
            (None, _, Target::Idle) if self.lapsed => Mode::Lapsed,
            (None, _, Target::Idle) => Mode::Off,
            (None, _, Target::Length(_)) => Mode::Length,
            (None, _, Target::Force(_)) => Mode::Force,
            (None, _, Target::Duty(_)) => Mode::Duty,
        };
        *state = ChannelState {
            measured_length_m: self.reading.length_m,
            // the observer goes on predicting when samples stop; that is not a measurement
            length_m: if self.reading.health.is_ok() { self.motion.length_m } else { f64::NAN },
            velocity_m_s: self.motion.velocity_m_s,
            acceleration_m_s2: self.motion.acceleration_m_s2,
            target_m: self.target_m(),
            duty: self.duty,
            resistance_ohm: self.reading.resistance_ohm,
            temperature_c: self.guard.heat().temperature_c(),
            martensite: self.estimate.martensite,
            power_w: self.power_w,
            surface: self.surface(),
            lease_s: match self.source {
                Source::Nobody => f64::NAN,
                Source::Program => f64::INFINITY,
                Source::Client { until_ns: u64::MAX } => f64::INFINITY,
                Source::Client { until_ns } => until_ns.saturating_sub(now_ns) as f64 * 1e-9,
            },
            asked: self.asked(),
            supply_v: self.sample.supply_v,
            v1_v: self.sample.v1_v,
            v2_v: self.sample.v2_v,
            v3_v: self.sample.v3_v,
            current_a: self.sample.current_a,
            mode: mode.code(),
            fault: latched.map_or(0, Fault::code),
            health: u32::from(self.reading.health.code()),
            flags: self.flags | if self.is_confirmed() { 0 } else { ChannelState::FLAG_UNCONFIRMED },
            order: self.order,
            backend: 0,
            owner: 0,
            priority: 0,
        };
    }
}
