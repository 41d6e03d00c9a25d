//! One channel's part of a cycle, with all its state in one struct, in the order of access.

use sinew_backend::ChannelFault;
use sinew_control::{
    Algorithm, Controller, Demand, EnthalpyObserver, Estimate, Observation, StateEstimator, StrokeRange, TensionLimits,
};
use sinew_ipc::{ChannelState, CommandKind, Fault};
use sinew_physics::DriveKind;
use sinew_physics::formulas::heating_power_w;
use sinew_rig::{Rig, Sensing};
use sinew_sensing::{Health, LengthSensor, Motion, MotionObserver, Reading, Sample, SlideWatch};

use crate::budget::Budgets;
use crate::cold::ColdWitness;
use crate::error::Error;
use crate::heat::{Cooling, Heat, Passed, Recalled};
use crate::jam::JamWatch;
use crate::orders::Ask;
use crate::setup::{Ends, estimator, observer_of, sensor, settings, slide_watch};
use crate::stage::StageWatch;
use crate::standstill::Standstill;
use crate::supervisor::{Change, Evidence, Guard, Permit};

/// How far above its limit a current must read to be more than noise, in standard deviations of the converter.
const CURRENT_GUARD: f64 = 8.0;

/// What a channel is commanded to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Nothing: the sensing pulse only.
    Idle,
    /// Keep this length, m.
    Length(f64),
    /// Keep this length, m: the one at which the load pulls with the force asked for.
    Force(f64),
    /// Give this duty, 0 ..= 1.
    Duty(f64),
}

/// The source of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Nobody.
    Nobody,
    /// The built-in program.
    Program,
    /// A client, until its lease is over.
    Client {
        /// When the lease is over, ns on the loop's clock; `u64::MAX` = never (only for `off`).
        until_ns: u64,
    },
}

/// When and how long: the same for all channels of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// The loop's clock, ns: CLOCK_MONOTONIC, or simulated.
    pub now_ns: u64,
    /// Time since the last cycle, s: whole periods, because that is what the samples are apart.
    pub dt_s: f64,
}

/// One channel, from its sample to its duty. The fields stand in the order a cycle touches them.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The duty in force in the period the next sample comes from: the largest that may be, where none was confirmed.
    applied_duty: f64,
    /// Whether the duty of the last exchange is known to be at the output.
    is_confirmed: bool,
    /// What has failed of it in that exchange.
    pub(crate) failure: Option<ChannelFault>,
    /// The last sample, as the backend delivered it.
    pub(crate) sample: Sample,
    /// The order taken since the last cycle, and the one taken before it, as in `ChannelState::order`; 0 = none.
    ordered: u32,
    pub(crate) order: u32,
    /// Value of the last setpoint a client asked for.
    asked: f64,
    sensor: LengthSensor,
    /// What its output stage does.
    stage: StageWatch,
    /// Where the length comes from taps and the load says how far the wire is pulled.
    slide: Option<SlideWatch>,
    /// The same, while it is derated.
    standstill: Option<Standstill>,
    /// And it does stand still.
    held: bool,
    /// What the last sample said.
    pub(crate) reading: Reading,
    observer: MotionObserver,
    /// What the wire does.
    pub(crate) motion: Motion,
    /// Power in the on-phase, W: the last one measured.
    on_power_w: f64,
    /// Mean power of the period just past, W.
    pub(crate) power_w: f64,
    estimator: StateEstimator,
    /// Where that one's temperature cannot be trusted with the wire's life: one whose temperature can.
    protector: Option<EnthalpyObserver>,
    /// What tells a cold wire whatever its history; none where nothing does.
    cold: Option<ColdWitness>,
    /// What is believed of the wire.
    pub(crate) estimate: Estimate,
    /// Its supervisor.
    pub(crate) guard: Guard,
    /// What it is to do.
    pub(crate) target: Target,
    /// Who says so.
    pub(crate) source: Source,
    /// Whether the last setpoint's lease ran out and nothing took its place; until the next command or fault.
    pub(crate) lapsed: bool,
    regulator: Algorithm,
    /// What holds the tension within its limits, where there are any.
    tension: Option<TensionLimits>,
    /// Whether the regulator was in charge in the last cycle: else it starts afresh.
    regulating: bool,
    min_duty: f64,
    max_duty: f64,
    max_power_w: f64,
    /// The duty for the next period.
    pub(crate) duty: f64,
    /// `ChannelState::FLAG_…`.
    pub(crate) flags: u32,
    /// Within this of its target it counts as settled, m: 0.5 % of the stroke.
    settled_m: f64,
    /// Where its strokes are counted from.
    pub(crate) stroke: StrokeRange,
}

/// What happened to a channel in one cycle, beyond its numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Happened {
    /// A fault latched or cleared.
    pub change: Option<Change>,
    /// A setpoint's lease ran out.
    pub lapsed: bool,
}

impl Channel {
    /// A channel of a rig, by its index there, its wire at rest in its air, trusting nothing else.
    ///
    /// # Errors
    /// [`Error::Rig`] where the channel cannot be driven by pulses or measured.
    pub fn new(rig: &Rig, index: usize) -> Result<Channel, Error> {
        let channel = &rig.channels[index];
        let model = &rig.nominal_model(index);
        let refuse = |reason: String| Error::Rig { place: format!("channel {}", channel.name), reason };
        if model.drive.kind != DriveKind::Pwm {
            return Err(refuse("its drive is not \"pwm\": only a wire heated by pulses can be driven".into()));
        }
        let stroke = StrokeRange::of(model).map_err(|error| refuse(error.to_string()))?;
        let (short_m, long_m) = (stroke.hot_m.min(stroke.cold_m), stroke.hot_m.max(stroke.cold_m));
        let (low_m, high_m) = (channel.limits.min_length_m, channel.limits.max_length_m);
        let reaches = low_m.max(short_m) <= high_m.min(long_m);
        // No setpoint could be commanded on such a channel, and every sample would be out of range.
        if !reaches {
            return Err(refuse(format!(
                "its limits leave nothing of its stroke: {:.2} to {:.2} mm, but it is {:.2} to {:.2} mm long",
                low_m * 1e3,
                high_m * 1e3,
                short_m * 1e3,
                long_m * 1e3
            )));
        }
        let hot = Ends::of(model, true, stroke.hot_m);
        let cold = Ends::of(model, false, stroke.cold_m);

        let sensor = sensor(channel, hot.wire, cold.wire).map_err(|error| refuse(error.to_string()))?;
        let middle_m = 0.5 * (stroke.hot_m + stroke.cold_m);
        let volts = cold.current_a * cold.wire.resistance_ohm;
        let sigma_m = sensor.expected_sigma_m(middle_m, volts, cold.current_a).clamp(1e-9, 1e-2);
        let observer =
            MotionObserver::new(rig.rate_hz, observer_of(model, sigma_m)).map_err(|error| refuse(error.to_string()))?;

        let limits = &channel.limits;
        let settings = settings(channel);
        let estimator = estimator(channel);
        // Where something else than its own load can hold it, standstill proves nothing.
        let slide = slide_watch(channel, model, &stroke);
        let standstill = slide.is_some().then(|| Standstill::new(&stroke));
        let jam = slide.is_some().then(|| JamWatch::of(model, &stroke)).flatten();
        let noise_a = sensor.config().converter.current_sigma_a();
        let drive = &model.drive;
        let series_ohm = drive.series_ohm();
        let max_current_a = limits.max_current_a + CURRENT_GUARD * noise_a;
        let full_w = cold.power_w().max(hot.power_w());
        let heat_capacity_j_per_k = model.heat_capacity_j_per_k();
        let most_w = (limits.max_duty * full_w).min(limits.max_power_w);
        let budgets = Budgets {
            energy_j: limits.energy_budget_j,
            drain_w: limits.energy_drain_w,
            temperature_c: limits.max_temperature_c,
            ambient_c: model.ambient_c,
            full_w: most_w,
            full_k_per_s: most_w / heat_capacity_j_per_k,
            period_s: 1.0 / rig.rate_hz,
            silence_s: rig.silence_s(),
        };
        Ok(Channel {
            applied_duty: 0.0,
            is_confirmed: true,
            failure: None,
            sample: Sample::NONE,
            ordered: 0,
            order: 0,
            asked: f64::NAN,
            slide,
            standstill,
            held: false,
            stage: StageWatch::new(&sensor, drive.supply_v, series_ohm, max_current_a, &stroke),
            sensor,
            reading: Reading::none(Default::default()),
            observer,
            motion: Motion { length_m: f64::NAN, velocity_m_s: f64::NAN, acceleration_m_s2: f64::NAN },
            on_power_w: full_w,
            power_w: 0.0,
            estimator: StateEstimator::new(model, estimator),
            protector: (!estimator.is_protective()).then(|| EnthalpyObserver::new(model)),
            cold: ColdWitness::of(model, &stroke).filter(|_| channel.control.sensing == Sensing::Dual),
            estimate: Estimate::UNKNOWN,
            guard: Guard::new(max_current_a, Heat::at_rest(budgets, Cooling::of(model)).watched_for_jams(jam)),
            target: Target::Idle,
            source: Source::Nobody,
            lapsed: false,
            regulator: Algorithm::new(model, &settings),
            tension: TensionLimits::new(model, limits.min_force_n, limits.max_force_n),
            regulating: false,
            min_duty: channel.control.minimum_duty,
            max_duty: limits.max_duty,
            max_power_w: limits.max_power_w,
            duty: 0.0,
            flags: 0,
            settled_m: SETTLED_STROKE * stroke.stroke_m().abs(),
            stroke,
        })
    }

    /// What a record of its output says of the wire, before the first cycle. The estimators begin where it says, and not at the air's
    /// temperature: what they lack there would be held against the wire by its slowest law, for tens of seconds for a thick one.
    pub fn recall(&mut self, recalled: &Recalled) {
        if self.guard.heat_mut().recall(recalled) {
            self.begin_at(self.guard.heat().temperature_c());
        }
    }

    /// The estimators forget what they know of the wire, but that it is as hot as this, °C.
    #[inline]
    fn begin_at(&mut self, temperature_c: f64) {
        self.estimator.begin_at(temperature_c);
        self.protector.iter_mut().for_each(|protector| protector.begin_at(temperature_c));
    }

    /// One cycle: the sample of the period just past in, the duty for the next period out (in `Channel::duty`).
    /// `program` is the stroke a built-in program wants, if there is one.
    #[inline]
    pub fn step(&mut self, sample: &Sample, tick: &Tick, program: Option<f64>) -> Happened {
        let seen = self.sense(sample, tick);
        self.estimate = self.estimator.update(&seen);
        let protective = match &mut self.protector {
            Some(protector) => protector.update(&seen),
            None => self.estimate,
        };
        let (permit, change) = self.supervise(sample, &protective, tick);
        let lapsed = self.put_in_charge(permit, tick, program);
        let duty = self.regulate(permit, tick);
        self.put_out(duty, permit, tick);
        Happened { change, lapsed }
    }

    /// Sensing: what the sample says, and what the wire does. Where nothing was driven there is nothing to see, whatever the
    /// converter picked up.
    #[inline]
    pub(crate) fn sense(&mut self, sample: &Sample, tick: &Tick) -> Observation {
        self.sample = *sample;
        self.order = std::mem::take(&mut self.ordered);
        let driven = self.applied_duty > 0.0;
        self.reading = if driven { self.sensor.read(sample) } else { Reading::none(Health::NoCurrent) };
        if self.reading.health.is_ok() {
            self.on_power_w = heating_power_w(1.0, sample.current_a, self.reading.resistance_ohm);
        }
        self.power_w = self.applied_duty * self.on_power_w;
        let sticks = self.slide.as_mut().is_some_and(|slide| slide.sticks(&self.reading, self.power_w, tick.dt_s));
        if sticks || (self.held && self.reading.health.is_ok()) {
            self.reading = Reading { resistance_ohm: self.reading.resistance_ohm, ..Reading::none(Health::ProbeStuck) };
        }
        self.motion = self.observer.update_weighted(self.reading.length(), self.reading.length_sigma_m, tick.dt_s);
        Observation {
            power_w: self.power_w,
            duty: self.applied_duty,
            length_m: self.reading.length_m,
            length_sigma_m: self.reading.length_sigma_m,
            resistance_ohm: self.reading.resistance_ohm,
            resistance_sigma_ohm: self.reading.resistance_sigma_ohm,
            tension_n: f64::NAN,
            dt_s: tick.dt_s,
        }
    }

    /// Supervisor: whether the wire may be powered. `protective` is an estimate that can be trusted with its life.
    #[inline]
    pub(crate) fn supervise(
        &mut self,
        sample: &Sample,
        protective: &Estimate,
        tick: &Tick,
    ) -> (Permit, Option<Change>) {
        let driven = self.applied_duty > 0.0;
        let heat = Passed {
            power_w: self.power_w,
            dt_s: tick.dt_s,
            estimate_c: protective.temperature_c,
            martensite: protective.martensite,
            is_measured: self.reading.length_m.is_finite(),
            cooling_curve_c: protective.cooling_curve_c,
            length_m: self.motion.length_m,
            cold_c: self.cold.as_ref().and_then(|cold| cold.bound_c(&self.reading)),
        };
        let was_jammed = self.guard.heat().is_jammed();
        let (permit, change) = self.guard.judge(&Evidence {
            driven,
            health: self.reading.health,
            stage: self.stage.fault(sample, &self.reading, driven),
            current_a: sample.current_a,
            heat,
        });
        if let Some(Change::Tripped(_)) = change {
            self.forget_target();
            (self.held, self.lapsed) = (false, false);
        }
        // What the estimators have learned of the wire from a held load (a loss to explain that it does not shorten) would outlast it.
        if was_jammed && !self.guard.heat().is_jammed() {
            self.begin_at(self.guard.heat().temperature_c());
        }
        (permit, change)
    }

    /// Selects the source of the target (client or program), and whether a setpoint's lease expired.
    #[inline]
    pub(crate) fn put_in_charge(&mut self, permit: Permit, tick: &Tick, program: Option<f64>) -> bool {
        let mut lapsed = false;
        match self.source {
            Source::Client { until_ns } if tick.now_ns >= until_ns => {
                // An expired `off` is no loss of control, and neither is one where a program continues; otherwise a client
                // was lost.
                lapsed = self.target != Target::Idle && program.is_none();
                self.lapsed = lapsed;
                self.forget_target();
            }
            _ => {}
        }
        if permit != Permit::Off && !matches!(self.source, Source::Client { .. }) {
            (self.target, self.source) = match program {
                Some(stroke) => (Target::Length(self.stroke.length_m(stroke)), Source::Program),
                None => (Target::Idle, Source::Nobody),
            };
        }

        lapsed
    }

    /// Controller: the duty it wants.
    #[inline]
    fn regulate(&mut self, permit: Permit, tick: &Tick) -> f64 {
        let mut regulating = false;
        let wanted = match (permit, self.target) {
            (Permit::Off, _) => 0.0,
            (Permit::SensingPulse, _) | (Permit::Power, Target::Idle) => self.min_duty,
            (Permit::Power, Target::Duty(duty)) => duty.clamp(self.min_duty, self.max_duty),
            (Permit::Power, Target::Length(reference_m) | Target::Force(reference_m)) => {
                regulating = true;
                if !self.regulating {
                    self.regulator.reset();
                }
                self.regulator.duty(&Demand {
                    reference_m,
                    length_m: self.motion.length_m,
                    velocity_m_s: self.motion.velocity_m_s,
                    acceleration_m_s2: self.motion.acceleration_m_s2,
                    resistance_ohm: self.reading.resistance_ohm,
                    dt_s: tick.dt_s,
                    estimate: self.estimate,
                })
            }
        };
        self.regulating = regulating;
        // Off is off: a wire without a setpoint is not kept under tension either.
        match (&mut self.tension, permit, self.target) {
            (Some(tension), Permit::Power, Target::Length(_) | Target::Force(_) | Target::Duty(_)) => {
                tension.limit(wanted, &self.estimate).max(self.min_duty).min(self.max_duty)
            }
            _ => wanted,
        }
    }

    /// The duty a wire of a joint gets while `regulated` is what the joint's law wants of it; `None` where that is not in
    /// charge.
    #[inline]
    pub(crate) fn regulate_in_joint(&mut self, permit: Permit, regulated: Option<f64>) -> f64 {
        self.regulating = regulated.is_some();
        match (permit, self.target, regulated) {
            (Permit::Off, ..) => 0.0,
            (Permit::Power, _, Some(duty)) => duty,
            (Permit::Power, Target::Duty(duty), None) => duty.clamp(self.min_duty, self.max_duty),
            _ => self.min_duty,
        }
    }

    /// Puts a duty out, within what the wire may have.
    #[inline]
    pub(crate) fn put_out(&mut self, wanted: f64, permit: Permit, tick: &Tick) {
        // The next sample comes from the duty output at this tick; one that was not confirmed may be there, or the one before it.
        self.applied_duty = if self.is_confirmed { self.duty } else { self.duty.max(self.applied_duty) };
        self.observer.set_duty(self.applied_duty);
        // The supply may be higher than configured; NaN is ignored.
        let most = self.max_duty.min(self.max_power_w / self.on_power_w);
        self.duty = if wanted > 0.0 { wanted.min(most.max(0.0)) } else { 0.0 };

        self.flags = 0;
        if self.regulating {
            let at_limit = wanted <= self.min_duty || wanted >= self.max_duty;
            self.flags |= if at_limit { ChannelState::FLAG_SATURATED } else { 0 };
            let off_target_m = (self.motion.length_m - self.target_m()).abs();
            self.flags |= if off_target_m <= self.settled_m { ChannelState::FLAG_SETTLED } else { 0 };
        }
        if permit == Permit::Power {
            self.hold_down();
        }
        // The sensing pulse heats as well: a wire that has no room even for that rests until it has.
        if self.duty > 0.0 && !self.guard.heat().allows(self.min_duty.min(self.duty) * self.on_power_w) {
            self.duty = 0.0;
            self.flags |= ChannelState::FLAG_DARK;
        }
        let limited = self.target != Target::Idle && self.tension.as_ref().is_some_and(TensionLimits::is_limited);
        self.flags |= if self.duty < wanted || limited { ChannelState::FLAG_LIMITED } else { 0 };
        if permit == Permit::Power {
            let low = self.duty <= self.min_duty;
            let derated = self.flags & (ChannelState::FLAG_HEAT_BUDGET | ChannelState::FLAG_TEMPERATURE_BUDGET) != 0;
            let target_m = self.target_m();
            if let Some(standstill) = &mut self.standstill {
                // What the observer makes of a length that was not measured is no motion.
                let length_m = if self.reading.health.is_ok() { self.motion.length_m } else { f64::NAN };
                self.held = standstill.is_held(self.guard.heat().filled(), derated, length_m, target_m, tick.dt_s);
            }
            let spare_s = self.guard.heat().spare_s();
            if self.stage.wants_dark(low, derated, spare_s, &self.motion, tick.dt_s) {
                self.duty = 0.0;
                self.flags |= ChannelState::FLAG_DARK;
            }
        }
    }

    /// Another duty goes out than the one that was decided.
    pub(crate) fn was_given(&mut self, duty: f64) {
        self.duty = duty;
    }

    /// The exchange at hand comes late: its duty was decided before so many seconds under the one before it.
    pub(crate) fn come_late(&mut self, seconds: f64) {
        let allowed_w = self.guard.heat().allowance_after(self.applied_duty * self.on_power_w, seconds).power_w;
        // Written so that an unknown power allows nothing.
        let fits = |duty: f64| duty * self.on_power_w <= allowed_w;
        if self.duty > 0.0 && !fits(self.duty) {
            let less = if fits(self.min_duty) { (allowed_w / self.on_power_w).max(self.min_duty) } else { 0.0 };
            self.duty = less.min(self.duty);
        }
    }

    /// Derates the duty to what keeps the wire's budgets, but not below the sensing pulse: a wire that is not measured is no safer.
    #[inline]
    fn hold_down(&mut self) {
        let allowance = self.guard.heat().allowance();
        // Written so that an unknown power allows no duty, and without a division where the budget suffices.
        let enough = allowance.power_w >= self.duty * self.on_power_w;
        if !enough && self.duty > self.min_duty {
            self.duty = (allowance.power_w / self.on_power_w).max(self.min_duty);
            self.flags |= allowance.flag;
        }
    }

    /// Latches a fault found outside of the channel, and drops its target. The duty of the next period is zero.
    #[inline]
    pub fn trip(&mut self, fault: Fault) -> Option<Change> {
        // A backend that failed has asked zero of its outputs; otherwise the duty of this exchange heats for one more period, which
        // is accounted for with its real length.
        if fault == Fault::Backend {
            self.duty = 0.0;
        }
        self.regulating = false;
        self.forget_target();
        self.guard.trip(fault)
    }

    /// Gives it nothing in the present cycle, after its duty was put out: its supply does not stand yet.
    #[inline]
    pub(crate) fn rest(&mut self) {
        self.duty = 0.0;
        self.flags |= ChannelState::FLAG_DARK;
    }

    /// Switches it off in the present cycle, after its duty was put out: its supply is gone.
    #[inline]
    pub(crate) fn cut_off(&mut self) -> Option<Change> {
        self.duty = 0.0;
        self.regulating = false;
        self.forget_target();
        self.guard.trip(Fault::SupplyCut)
    }

    /// The commanded length, or else the present one, m.
    pub(crate) fn wanted_or_present_m(&self) -> f64 {
        match self.target {
            Target::Length(length_m) | Target::Force(length_m) => length_m,
            _ => self.motion.length_m,
        }
    }

    /// Records an order, accepted or refused, for recordings.
    #[inline]
    pub(crate) fn note(&mut self, ask: Ask, place: u32) {
        let (kind, asked) = match ask {
            Ask::Length(length_m) => (CommandKind::Length, length_m),
            Ask::Force(length_m) => (CommandKind::Force, length_m),
            Ask::Tension(tension_n) => (CommandKind::Force, tension_n),
            Ask::Duty(duty) => (CommandKind::Duty, duty),
            Ask::Off => (CommandKind::Off, f64::NAN),
            Ask::Reset => (CommandKind::Reset, self.asked),
        };
        self.ordered = ChannelState::order_code(kind, place);
        self.asked = asked;
    }

    /// Whether an order was taken since the last cycle.
    pub(crate) fn has_order(&self) -> bool {
        self.ordered != 0
    }

    /// Notes that its partner in a joint was given an order that this channel follows.
    pub(crate) fn note_partners(&mut self) {
        if !self.has_order() {
            self.asked = f64::NAN;
        }
    }

    /// Value of the client's setpoint, that of an order refused right before this cycle included; NaN without one.
    pub(crate) fn asked(&self) -> f64 {
        if self.order != 0 || matches!(self.source, Source::Client { .. }) { self.asked } else { f64::NAN }
    }

    /// Takes a target from somebody.
    #[inline]
    pub(crate) fn obey(&mut self, target: Target, source: Source) {
        (self.target, self.source, self.lapsed) = (target, source, false);
    }

    fn forget_target(&mut self) {
        (self.target, self.source) = (Target::Idle, Source::Nobody);
    }

    /// What the backend knows of the last exchange: whether its duty is at the output, and what has failed.
    #[inline]
    pub(crate) fn note_output(&mut self, is_confirmed: bool, failure: Option<ChannelFault>) {
        (self.is_confirmed, self.failure) = (is_confirmed, failure);
    }

    /// Whether more may be at the output than was asked of it.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.is_confirmed
    }

    /// Whether its controller is in charge.
    pub fn is_powered(&self) -> bool {
        self.regulating
    }

    /// What is believed of its wire's heat.
    #[inline]
    pub fn heat(&self) -> &Heat {
        self.guard.heat()
    }

    /// What a record of its output has to say at this moment. The most that is given until the output hears of another duty is by the
    /// one in force, or the one it is given next.
    #[inline]
    pub fn to_recall(&self) -> Recalled {
        let heat = self.guard.heat();
        Recalled {
            temperature_c: heat.temperature_c(),
            surely_c: heat.surely_c(),
            account_j: heat.account_j(),
            given_w: self.applied_duty.max(self.duty) * self.on_power_w,
            since_s: 0.0,
        }
    }

    /// Where its strokes are counted from.
    pub fn stroke_range(&self) -> StrokeRange {
        self.stroke
    }

    /// Length as the observer has it, m; NaN before anything was measured.
    pub fn length_m(&self) -> f64 {
        self.motion.length_m
    }

    /// What is believed of the wire.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// Target length, m; NaN while it has none.
    pub fn target_m(&self) -> f64 {
        match self.target {
            Target::Length(length_m) | Target::Force(length_m) => length_m,
            _ => f64::NAN,
        }
    }

    /// The sliding surface, 0 while no controller is in charge.
    pub fn surface(&self) -> f64 {
        if self.regulating { self.regulator.surface() } else { 0.0 }
    }
}

/// Share of the stroke within which a target counts as reached.
const SETTLED_STROKE: f64 = 0.005;
