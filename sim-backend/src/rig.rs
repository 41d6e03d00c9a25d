//! The whole virtual rig as a backend: time, channels, and the calls of the contract.

use std::fmt;

use sinew_backend::{Backend, BackendError, ChannelFault, Sample, StopInputs, Truth, Zero, check_exchange};
use sinew_physics::{EnergyBalance, Inputs, JointMotion, Surroundings, Wire, drawn_meanwhile_a};
use sinew_rig::{EnableSignal, FaultKind, Rig};

use crate::channel::{Channel, World};
use crate::fault::{Acting, FaultHandle, Schedule};

/// Operating system error that a scheduled or switched backend error pretends: EIO.
const EIO: i32 = 5;

/// After a pause longer than this, in s, the wires have long settled under the duty they were left with: the rest of
/// the pause is not computed, so that a loop that was stopped for an hour goes on at once.
const LONGEST_CATCH_UP_S: f64 = 60.0;

/// Why a rig cannot be simulated as a backend.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// The driver could not drive it either, with every reason.
    NotDrivable(sinew_rig::Error),
    /// The physics does not accept a channel's parameters.
    Wire {
        /// Name of the channel.
        channel: String,
        /// Which, and what would be right.
        error: sinew_physics::Error,
    },
}

impl Error {
    fn wire(channel: &sinew_rig::Channel, error: sinew_physics::Error) -> Error {
        Error::Wire { channel: channel.name.clone(), error }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::NotDrivable(error) => error.fmt(f),
            Error::Wire { channel, error } => write!(f, "channel \"{channel}\": {error}"),
        }
    }
}

impl std::error::Error for Error {}

/// A joint and the channels whose wires turn it, agonist first.
#[derive(Debug, Clone)]
struct Joint {
    motion: JointMotion,
    channels: [usize; 2],
    radius_m: f64,
}

impl Joint {
    /// Lets a period pass for the joint and its two wires.
    #[inline]
    fn pass(&mut self, channels: &mut [Channel], period_s: f64) {
        let Ok([agonist, antagonist]) = channels.get_disjoint_mut(self.channels) else { return };
        let (forward, forward_inputs) = agonist.wire_in_joint();
        let (back, back_inputs) = antagonist.wire_in_joint();
        // a pull that makes a wire longer turns the joint to the other wire's side
        let torque_n_m = self.radius_m * (back_inputs.external_n - forward_inputs.external_n);
        self.motion.step([forward, back], [forward_inputs, back_inputs], torque_n_m, period_s);
    }
}

/// The channels that act on one other than by a joint.
#[derive(Debug, Clone)]
struct Ties {
    channel: usize,
    /// Whose wire is beside its wire.
    neighbour: Option<usize>,
    /// Which draw from its supply, too.
    at_supply: Vec<usize>,
}

/// A rig of simulated wires. One `exchange` is one period of the rig's rate, however long it takes: whether a simulated
/// second takes a second is up to the loop that calls it.
#[derive(Debug)]
pub struct SimulatedRig {
    channels: Vec<Channel>,
    joints: Vec<Joint>,
    /// Whether each channel's wire has a load of its own, and not a joint's.
    alone: Vec<bool>,
    /// What the rig file says of channels that act on each other.
    ties: Vec<Ties>,
    period_s: f64,
    /// After so long without a duty a stage switches itself off, s and periods.
    silence_s: f64,
    silence_periods: u64,
    /// Periods that have passed.
    periods: u64,
    started: bool,
    /// The supply is cut off, until it is restored or the next start.
    cut: bool,
    /// A watchdog relay before all stages: so many periods after the last pulse it drops out. And how many those are.
    dropout_periods: Option<u64>,
    unpulsed: u64,
    /// With a switch before all stages: so many periods after it is on the supply stands; and how many it has been on.
    settle_periods: u64,
    enabled: u64,
    /// The emergency stop, where one is fitted.
    stop: Option<StopInputs>,
    faults: FaultHandle,
    schedule: Schedule,
}

impl SimulatedRig {
    /// All wires of `rig` at rest in their loads, cold, with nothing put out.
    ///
    /// # Errors
    /// A rig no driver could drive, or parameters the physics does not accept.
    pub fn new(rig: &Rig) -> Result<SimulatedRig, Error> {
        rig.check_drivable().map_err(Error::NotDrivable)?;
        let scheduled = &rig.simulation.faults;
        let mut joints = Vec::new();
        for joint in &rig.joints {
            // the rig file was read, so its joints have channels
            let Some(channels) = rig.channels_of(joint) else { continue };
            let wires = channels.map(|index| &rig.channels[index]);
            let motion = JointMotion::new(&joint.mechanics, wires.map(|wire| &wire.model))
                .map_err(|error| Error::wire(wires[0], error))?;
            joints.push(Joint { motion, channels, radius_m: joint.mechanics.radius_m });
        }
        let place = |index| {
            joints.iter().find_map(|joint| Some((&joint.motion, joint.channels.iter().position(|c| *c == index)?)))
        };
        let channels = rig.channels.iter().enumerate().map(|(index, channel)| {
            let wire = match place(index) {
                Some((motion, side)) => motion.wire(side, &channel.model),
                None => Wire::new(&channel.model),
            };
            let wire = wire.map_err(|error| Error::wire(channel, error))?;
            let seed = channel_seed(rig.simulation.seed, &channel.name);
            Ok(Channel::new(wire, channel, seed, Schedule::of_channel(scheduled, index)))
        });
        let ties = (0..rig.channels.len()).map(|channel| Ties {
            channel,
            neighbour: rig.neighbour_of(channel),
            at_supply: rig.at_supply_of(channel).collect(),
        });
        Ok(SimulatedRig {
            ties: ties.filter(|ties| ties.neighbour.is_some() || !ties.at_supply.is_empty()).collect(),
            channels: channels.collect::<Result<Vec<_>, Error>>()?,
            alone: (0..rig.channels.len()).map(|index| place(index).is_none()).collect(),
            joints,
            period_s: 1.0 / rig.rate_hz,
            silence_s: rig.silence_s(),
            silence_periods: (rig.silence_s() * rig.rate_hz).ceil() as u64,
            periods: 0,
            started: false,
            cut: false,
            dropout_periods: (rig.backend.enable.signal == EnableSignal::Pulses)
                .then(|| (rig.backend.enable.dropout_s * rig.rate_hz).ceil().max(1.0) as u64),
            unpulsed: 0,
            settle_periods: match rig.backend.enable.signal {
                EnableSignal::None => 0,
                EnableSignal::Level | EnableSignal::Pulses => (rig.backend.enable.settle_s * rig.rate_hz) as u64,
            },
            enabled: 0,
            stop: rig.backend.estop.fitted.then_some(StopInputs::OPEN),
            faults: FaultHandle::new(rig.channels.len()),
            schedule: Schedule::of_backend(scheduled),
        })
    }

    /// What breaks things while the rig runs.
    pub fn faults(&self) -> FaultHandle {
        self.faults.clone()
    }

    /// Changes the world around a wire from now on: a draught, warmer air, another pull, a weaker supply. It holds
    /// until it is changed again; faults come on top. A channel there is none of is not disturbed.
    pub fn disturb(&mut self, channel: usize, world: &World) {
        if let Some(channel) = self.channels.get_mut(channel) {
            channel.disturb(world);
        }
    }

    /// Changes the duties within the period that passes, as a power stage does whose outputs can be set at any moment.
    /// Values outside of 0 ..= 1 are taken as the nearest one inside, NaN as 0.
    pub fn put_out(&mut self, duty: &[f64]) {
        for (channel, duty) in self.channels.iter_mut().zip(duty) {
            channel.put(if duty.is_nan() { 0.0 } else { duty.clamp(0.0, 1.0) }, &Acting::NONE);
        }
    }

    /// What acts on a wire now, with nothing driven: what its clone has to be stepped with to go on alone.
    pub fn inputs(&self, channel: usize) -> Option<Inputs> {
        Some(self.channels.get(channel)?.inputs())
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.periods as f64 * self.period_s
    }

    /// Where a wire's energy went since the start: every joule put in, sensing pulses included.
    pub fn energy(&self, channel: usize) -> Option<EnergyBalance> {
        Some(self.channels.get(channel)?.wire.energy())
    }

    /// The simulated wire itself.
    pub fn wire(&self, channel: usize) -> Option<&Wire> {
        Some(&self.channels.get(channel)?.wire)
    }

    /// A joint of the rig, in the order of the rig file.
    pub fn joint(&self, joint: usize) -> Option<&JointMotion> {
        Some(&self.joints.get(joint)?.motion)
    }

    /// A time inside the present period that rounding cannot move across its ends.
    fn middle_s(&self) -> f64 {
        (self.periods as f64 + 0.5) * self.period_s
    }

    /// Lets wires act on each other as they are at the start of a period.
    fn surround(&mut self) {
        for ties in &self.ties {
            let neighbour_c = ties.neighbour.map(|neighbour| self.channels[neighbour].wire.temperature_c());
            let own_duty = self.channels[ties.channel].duty;
            let drawn = |other: &usize| {
                let other = &self.channels[*other];
                drawn_meanwhile_a(own_duty, other.duty, other.wire.current_a())
            };
            let others_a = ties.at_supply.iter().map(drawn).sum();
            self.channels[ties.channel].surround(Surroundings { neighbour_c, others_a });
        }
    }

    /// Lets one period of `duty` pass and samples its on-phase: what a power stage does in the period that
    /// [`Backend::exchange`] begins, and hands out only with the next one. For callers that simulate a power stage.
    ///
    /// # Errors
    /// As [`Backend::exchange`].
    pub fn period(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        for (channel, duty) in self.channels.iter_mut().zip(duty) {
            channel.put(duty.clamp(0.0, 1.0), &Acting::NONE);
        }
        self.exchange(duty, samples)
    }

    /// Lets one period pass without sampling.
    fn pass(&mut self) {
        let time_s = self.middle_s();
        self.surround();
        self.unpulsed += 1;
        let is_on = self.started && !self.cut && self.dropout_periods.is_none_or(|most| self.unpulsed <= most);
        self.enabled = if is_on { self.enabled + 1 } else { 0 };
        let has_supply = is_on && self.enabled > self.settle_periods;
        for (index, channel) in self.channels.iter_mut().enumerate() {
            let acting = self.faults.acting(index, &channel.schedule, time_s);
            channel.watch(self.silence_periods);
            channel.begin(self.period_s, &acting, has_supply);
            if self.alone[index] {
                channel.pass();
            }
        }
        for joint in &mut self.joints {
            joint.pass(&mut self.channels, self.period_s);
        }
        self.periods += 1;
    }

    /// A failed exchange: time passes, zero is put out from here on.
    fn fail(&mut self, samples: &mut [Sample], error: BackendError) -> Result<(), BackendError> {
        self.pass();
        let _ = self.zero();
        samples.fill(Sample::NONE);
        Err(error)
    }

    /// Reads the emergency stop's inputs, which belong to no channel: what is said of any is said of the rig.
    fn look_at_stop(&mut self, time_s: f64) {
        if self.stop.is_none() {
            return;
        }
        let has = |kind| {
            let acts =
                |(index, channel): (usize, &Channel)| self.faults.acting(index, &channel.schedule, time_s).has(kind);
            self.channels.iter().enumerate().any(acts)
        };
        let inputs = StopInputs { is_closed: !has(FaultKind::EstopOpen), is_reset_pressed: has(FaultKind::EstopReset) };
        self.stop = Some(inputs);
    }

    /// Puts zero out on all channels.
    fn zero(&mut self) -> Zero {
        let time_s = self.middle_s();
        for (index, channel) in self.channels.iter_mut().enumerate() {
            let acting = self.faults.acting(index, &channel.schedule, time_s);
            channel.put(0.0, &acting);
        }
        Zero::confirmed_if(self.channels.iter().all(|channel| channel.is_confirmed))
    }
}

/// A seed of its own for every channel of a rig, the same wherever in the rig it stands: FNV-1a over its name.
fn channel_seed(seed: u64, name: &str) -> u64 {
    let start = 0xcbf2_9ce4_8422_2325 ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    name.bytes().fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

impl Backend for SimulatedRig {
    fn channels(&self) -> usize {
        self.channels.len()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        if self.zero() == Zero::Unconfirmed {
            return Err(BackendError::Io { os_error: EIO });
        }
        self.channels.iter_mut().for_each(Channel::at_rest);
        (self.started, self.cut) = (true, false);
        Ok(())
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        if !self.started {
            return Err(BackendError::NotStarted);
        }
        if let Err(error) = check_exchange(self.channels.len(), duty, samples) {
            return self.fail(samples, error);
        }
        self.unpulsed = 0;
        let time_s = self.middle_s();
        self.look_at_stop(time_s);
        if self.faults.backend_error() || self.schedule.any_acts_at(time_s) {
            return self.fail(samples, BackendError::Io { os_error: EIO });
        }
        self.pass();
        let mut failed = None;
        for (index, ((channel, duty), sample)) in self.channels.iter_mut().zip(duty).zip(samples).enumerate() {
            let acting = self.faults.acting(index, &channel.schedule, time_s);
            *sample = channel.sample(self.period_s, &acting);
            let broken = acting.has(FaultKind::BackendError);
            channel.failure = None;
            channel.put(if broken { 0.0 } else { *duty }, &acting);
            if broken || !channel.is_confirmed {
                *sample = Sample::NONE;
                let fault = if broken { ChannelFault::Converter } else { ChannelFault::Stage };
                channel.failure = Some(fault);
                failed = failed.or(Some(BackendError::Channel { channel: index as u32, fault }));
            }
        }
        failed.map_or(Ok(()), Err)
    }

    fn missed(&mut self, periods: u64) {
        if self.started {
            let computed = periods.min((LONGEST_CATCH_UP_S / self.period_s) as u64);
            self.periods = self.periods.saturating_add(periods - computed);
            for _ in 0..computed {
                self.pass();
            }
        }
    }

    fn cut(&mut self) -> bool {
        self.cut = true;
        true
    }

    fn restore(&mut self) {
        self.cut = false;
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.stop
    }

    fn is_confirmed(&self, channel: usize) -> bool {
        self.channels.get(channel).is_none_or(|channel| channel.is_confirmed)
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.channels.get(channel)?.failure
    }

    fn silence_s(&self) -> Option<f64> {
        Some(self.silence_s)
    }

    fn is_at_rest(&self) -> bool {
        self.periods == 0
    }

    fn stop(&mut self) -> Zero {
        let zero = self.zero();
        self.channels.iter_mut().for_each(Channel::at_rest);
        self.started = false;
        zero
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        Some(self.channels.get(channel)?.truth())
    }
}
