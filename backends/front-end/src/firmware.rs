//! The firmware's logic: receives frames, keeps the period, samples, answers, and switches off by itself.
//!
//! ```text
//!          configure            two frames of zeros          silence
//!   Boot ------------> Ready ------------------------> Running -------> Tripped
//!                        ^                               |  ^               |
//!                        +-------------- off ------------+  +---------------+
//!                                                           two frames of zeros
//!
//!   any but Boot -- emergency stop open --> Stopped -- closed, two frames of zeros --> Running
//! ```
//!
//! A duty frame's arrival begins a period: outputs on for their share of it, then off. At the end of the longest on-phase, at
//! the latest at three quarters of the period, the samples go up with the frame's own sequence number, in time for the
//! driver's next tick. A late frame is awaited for a quarter of a period with outputs off; then its predecessor's duties
//! are output again, until silence has lasted for the watchdog's time, or for the validity of the last frame where that is
//! shorter. A frame that arrives within half a period of the last one
//! (a stalled line may deliver several at once) waits for the end of the period instead of beginning another, so
//! that no burst of frames heats a wire.
//!
//! The enable pin is on in `Running` alone, if the last frame lets it, until a power stage is found to conduct with duty 0.

use crate::frame::{
    self, ChannelFault, ChannelLimits, Configure, Duty, EnableMode, FULL_DUTY, Frame, Identification, MAX_CHANNELS,
    NOT_SAMPLED, RawSample, Refusal, Samples, State,
};
use crate::guard::{Guard, Period};
use crate::wire::{Decoder, MAX_BODY_TO_DEVICE, MAX_FRAME};

/// Duty frames of nothing but zeros before anything is put out.
const ARMING_FRAMES: u8 = 2;
/// An emergency stop is looked at so often in a period.
const LOOKS: u64 = 4;

/// What the pins of an emergency stop show, whatever their levels are on this board. A broken lead has to look like an open contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StopPins {
    /// Whether its contact is closed: nobody has pressed it.
    pub closed: bool,
    /// Whether its reset button is pressed.
    pub reset_pressed: bool,
}

/// What a firmware needs of its microcontroller.
pub trait Hardware {
    /// Shortest on-phase in which its converters settle and convert, ns. One that short is always left of a duty that is cut down, so that
    /// the current is known; in a shorter one no sample is expected.
    const MIN_ON_NS: u64 = 5_000;

    /// Begins a period now: every output goes on and, after its share of `period_ns` (`duty` of 65535), off, and stays off
    /// until this is called again. Conversions are triggered at the end of each output's on-phase, or at three quarters of
    /// the period where that comes first; where `duty` is 0, at an eighth of it: a current there shows that a power stage conducts
    /// by itself.
    fn begin_period(&mut self, duty: &[u16], period_ns: u32);

    /// Every output off, now.
    fn off(&mut self);

    /// What the conversions of the present period gave, [`NOT_SAMPLED`] where there was none.
    fn samples(&mut self, samples: &mut [RawSample]);

    /// What a channel's power stage says of itself.
    fn stage_fault(&mut self, channel: usize) -> Option<ChannelFault> {
        let _ = channel;
        None
    }

    /// Puts the enable pin on or off: what switches the supply of all power stages, where the board has that. For a watchdog relay this
    /// is called with the other level in every period. It has to be off before the firmware runs, and while its processor is reset.
    fn enable(&mut self, on: bool) {
        let _ = on;
    }

    /// What the pins of an emergency stop show now; `None` where the board has none.
    fn stop_inputs(&mut self) -> Option<StopPins> {
        None
    }

    /// Sends a frame, without waiting; what there is no room for is lost, whole.
    fn send(&mut self, line: &[u8]);

    /// Tells somebody with a screen.
    fn tell(&mut self, event: Event) {
        let _ = event;
    }
}

/// Something that happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Configured, and with what period, ns.
    Configured {
        /// The period.
        period_ns: u32,
    },
    /// A configuration was refused.
    Refused(Refusal),
    /// Outputs follow the duty frames from now on.
    Running,
    /// Outputs are off because no good frame came.
    Silent {
        /// For how long, ns.
        since_ns: u64,
        /// Whether anything was put out when it struck.
        powered: bool,
    },
    /// Outputs are off because the driver said so.
    Off,
    /// Outputs are off because the emergency stop is open.
    Stopped,
    /// A channel is off for a fault of its own.
    Fault {
        /// Which.
        channel: u8,
        /// What.
        fault: ChannelFault,
    },
}

/// The configuration in force.
#[derive(Debug, Clone, Copy)]
struct Session {
    number: u32,
    period_ns: u64,
    silence_ns: u64,
    enable: EnableMode,
    uses_stop: bool,
    channels: usize,
}

/// A front-end without its peripherals. Times are of any monotonic clock, ns.
#[derive(Debug, Clone)]
pub struct Firmware {
    who: Identification,
    decoder: Decoder<MAX_BODY_TO_DEVICE>,
    state: State,
    session: Option<Session>,
    limits: [ChannelLimits; MAX_CHANNELS],
    guard: [Guard; MAX_CHANNELS],
    /// Of the last duty frame that was taken.
    sequence: Option<u32>,
    /// Duty frames of zeros in a row.
    zeros: u8,
    /// What that frame asks, what is put out, and where that is less because of a limit.
    asked: [u16; MAX_CHANNELS],
    put: [u16; MAX_CHANNELS],
    limited: u64,
    /// How long that frame is valid, and whether the enable pin may be on by it.
    valid_ns: u64,
    may_supply: bool,
    /// Whether the power stages have a supply in this period, and the level of the pin.
    is_supplied: bool,
    level: bool,
    /// What the emergency stop showed when it was last looked at, and whether it was open since the last samples frame.
    stop: StopPins,
    was_open: bool,
    /// When the last good frame came, and when one last began a period by coming.
    heard_ns: u64,
    framed_ns: Option<u64>,
    /// The present period: its beginning, when to sample, whether that is done, and the frame it is of; `None` = it repeats one.
    begun_ns: u64,
    sample_ns: u64,
    sampled: bool,
    frame: Option<u32>,
    /// When samples were last taken.
    judged_ns: u64,
    /// Whether a frame waits for the end of the period.
    waiting: bool,
    lost: u16,
    refused: u16,
    /// Session under which anything was put out last, 0 = none since the start, and since when nothing has been.
    user: u32,
    unused_ns: Option<u64>,
}

impl Firmware {
    /// Of a device. What the identification says of limits holds whatever a configuration asks for.
    pub const fn new(who: Identification) -> Firmware {
        let none = ChannelLimits { max_duty: 0, max_current_ma: 0, heat_ma2_s: 0, drain_ma2: 0 };
        Firmware {
            who,
            decoder: Decoder::new(),
            state: State::Boot,
            session: None,
            limits: [none; MAX_CHANNELS],
            guard: [Guard::NEW; MAX_CHANNELS],
            sequence: None,
            zeros: 0,
            asked: [0; MAX_CHANNELS],
            put: [0; MAX_CHANNELS],
            limited: 0,
            valid_ns: 0,
            may_supply: false,
            is_supplied: false,
            level: false,
            stop: StopPins { closed: true, reset_pressed: false },
            was_open: false,
            heard_ns: 0,
            framed_ns: None,
            begun_ns: 0,
            sample_ns: 0,
            sampled: true,
            frame: None,
            judged_ns: 0,
            waiting: false,
            lost: 0,
            refused: 0,
            user: 0,
            unused_ns: None,
        }
    }

    /// What it is about.
    pub fn state(&self) -> State {
        self.state
    }

    /// The duties that are put out in the present period, of 65535.
    pub fn put_out(&self) -> &[u16] {
        self.put.get(..self.channels()).unwrap_or_default()
    }

    fn channels(&self) -> usize {
        self.session.map_or(0, |session| session.channels)
    }

    /// Takes bytes received on the line. After a long pause call [`Firmware::poll`] first.
    pub fn receive(&mut self, bytes: &[u8], now_ns: u64, hardware: &mut impl Hardware) {
        self.unused_ns.get_or_insert(now_ns);
        self.look_at_stop(now_ns, hardware);
        for byte in bytes {
            let frame = match self.decoder.push(*byte) {
                None => continue,
                Some(body) => body.and_then(frame::decode_on_device),
            };
            match frame {
                Ok(Frame::Hello { nonce }) => self.identify(nonce, now_ns, hardware),
                Ok(Frame::Configure(wanted)) => self.configure(&wanted, now_ns, hardware),
                Ok(Frame::Duty(duty)) => self.duty(&duty, now_ns, hardware),
                Ok(Frame::Off) => self.switch_off(now_ns, hardware),
                Ok(Frame::Clear { channel }) => self.clear(channel, hardware),
                // Frames of the front-end's own kinds and damaged ones are dropped.
                Ok(_) | Err(_) => self.refused = self.refused.wrapping_add(1),
            }
        }
    }

    /// Does what time asks for; to be called at the time it gives back, or earlier: at once where a pin of the emergency stop changes.
    /// `None`: nothing, until a frame comes.
    pub fn poll(&mut self, now_ns: u64, hardware: &mut impl Hardware) -> Option<u64> {
        self.unused_ns.get_or_insert(now_ns);
        let session = self.session?;
        self.look_at_stop(now_ns, hardware);
        let silent_ns = self.heard_ns.saturating_add(session.silence_ns.min(self.valid_ns));
        if self.may_heat() && now_ns >= silent_ns {
            self.trip(now_ns, hardware);
        }
        if !self.sampled && now_ns >= self.sample_ns {
            self.sample(now_ns, hardware);
        }
        if now_ns >= self.end_ns(&session) {
            self.begin(now_ns, self.waiting, hardware);
        }
        let mut next_ns = if self.sampled { self.end_ns(&session) } else { self.sample_ns };
        if session.uses_stop {
            next_ns = next_ns.min(now_ns.saturating_add((session.period_ns / LOOKS).max(1)));
        }
        Some(if self.may_heat() { next_ns.min(silent_ns) } else { next_ns })
    }

    /// Whether silence has to be cut short: something is on, or will be in the next period, or only a gate keeps it off.
    fn may_heat(&self) -> bool {
        let is_on = || self.put.iter().chain(&self.asked).any(|duty| *duty > 0);
        self.state == State::Running && (self.is_supplied || is_on())
    }

    /// When the next period begins, should no frame begin it.
    fn end_ns(&self, session: &Session) -> u64 {
        let grace_ns = if self.waiting { 0 } else { session.period_ns / 4 };
        self.begun_ns.saturating_add(session.period_ns).saturating_add(grace_ns)
    }

    fn identify(&mut self, nonce: u32, now_ns: u64, hardware: &mut impl Hardware) {
        // A stage that conducts by itself is in use, whoever by.
        let is_used = self.put_out().iter().any(|duty| *duty > 0) || self.guard.iter().any(|guard| guard.conducts);
        let unused_ns = if is_used { 0 } else { now_ns.saturating_sub(self.unused_ns.unwrap_or(now_ns)) };
        let unused_ms = u32::try_from(unused_ns / 1_000_000).unwrap_or(u32::MAX);
        self.who = Identification { nonce, user: self.user, unused_ms, ..self.who };
        send(&Frame::Identification(self.who), hardware);
    }

    fn configure(&mut self, wanted: &Configure, now_ns: u64, hardware: &mut impl Hardware) {
        self.put_off(now_ns, hardware);
        self.session = None;
        self.state = State::Boot;
        let period_ns = wanted.period_ns;
        let silence_ns = u64::from(period_ns) * u64::from(wanted.watchdog_periods);
        let has = self.who.features;
        let refusal = match () {
            () if wanted.channels == 0 || wanted.channels > self.who.channels => Some(Refusal::Channels),
            () if period_ns < self.who.min_period_ns.max(1) || period_ns > self.who.max_period_ns => {
                Some(Refusal::Period)
            }
            () if silence_ns == 0 || silence_ns > u64::from(self.who.max_silence_ns) => Some(Refusal::Silence),
            () if wanted.enable != EnableMode::None && !has.enable => Some(Refusal::Features),
            () if wanted.uses_stop && !has.stop => Some(Refusal::Features),
            () => None,
        };
        match refusal {
            Some(refusal) => hardware.tell(Event::Refused(refusal)),
            None => {
                let channels = self.limits.iter_mut().zip(&mut self.guard).zip(&self.who.channel).zip(&wanted.limits);
                for (((limits, guard), range), wanted) in channels {
                    let before = core::mem::replace(limits, range.limits.narrower(wanted));
                    // I²t and faults are kept: a new configuration cools no wire.
                    guard.configure(&before, limits);
                }
                (self.sequence, self.limited, self.lost, self.refused) = (None, 0, 0, 0);
                (self.valid_ns, self.may_supply, self.was_open) = (u64::MAX, false, false);
                (self.begun_ns, self.heard_ns, self.judged_ns, self.framed_ns) = (now_ns, now_ns, now_ns, None);
                (self.sampled, self.frame) = (true, None);
                let Configure { enable, uses_stop, channels, .. } = *wanted;
                self.session = Some(Session {
                    number: wanted.session,
                    period_ns: period_ns.into(),
                    silence_ns,
                    enable,
                    uses_stop,
                    channels: channels.into(),
                });
                self.state = State::Ready;
                hardware.tell(Event::Configured { period_ns });
                self.look_at_stop(now_ns, hardware);
            }
        }
        send(&Frame::Configured { session: wanted.session, refusal }, hardware);
    }

    fn duty(&mut self, duty: &Duty, now_ns: u64, hardware: &mut impl Hardware) {
        let Some(session) = self.session else {
            // So that a driver detects that its front-end has restarted.
            return self.answer(duty.sequence, now_ns, &[], hardware);
        };
        if usize::from(duty.channels) != session.channels {
            self.refused = self.refused.wrapping_add(1);
            return;
        }
        if let Some(last) = self.sequence {
            let ahead = duty.sequence.wrapping_sub(last);
            if ahead == 0 || ahead > u32::MAX / 2 {
                self.refused = self.refused.wrapping_add(1);
                return;
            }
            self.lost = self.lost.wrapping_add((ahead - 1).min(u16::MAX.into()) as u16);
        }
        self.asked = duty.duty;
        let nothing = duty.duty.iter().take(session.channels).all(|duty| *duty == 0);
        let arms = nothing && self.state != State::Running && self.stop.closed;
        self.zeros = if arms { self.zeros.saturating_add(1) } else { 0 };
        (self.valid_ns, self.may_supply) = (u64::from(duty.valid_us) * 1000, duty.supply);
        if !duty.supply {
            self.supply(false, hardware);
        }
        (self.sequence, self.heard_ns) = (Some(duty.sequence), now_ns);
        if self.zeros >= ARMING_FRAMES {
            self.state = State::Running;
            hardware.tell(Event::Running);
        }
        if self.framed_ns.is_some_and(|before| now_ns.saturating_sub(before) < session.period_ns / 2) {
            self.waiting = true;
        } else {
            self.framed_ns = Some(now_ns);
            self.begin(now_ns, true, hardware);
        }
    }

    /// Begins a period: a frame's own, or one with the same duties again.
    fn begin<H: Hardware>(&mut self, now_ns: u64, framed: bool, hardware: &mut H) {
        let Some(session) = self.session else { return };
        if !self.sampled {
            self.sample(now_ns, hardware);
        }
        let running = self.state == State::Running;
        let conducts = self.guard.iter().take(session.channels).any(|guard| guard.conducts);
        self.supply(running && self.may_supply && !conducts, hardware);
        let least = (H::MIN_ON_NS * u64::from(FULL_DUTY)).div_ceil(session.period_ns).min(FULL_DUTY.into()) as u16;
        let period_us = (session.period_ns / 1000) as u32;
        let mut longest = 0;
        self.limited = 0;
        let channels = self.put.iter_mut().zip(&self.asked).zip(&self.limits).zip(&self.guard);
        for (channel, (((put, asked), limits), guard)) in channels.take(session.channels).enumerate() {
            let on = running && guard.fault.is_none();
            *put = if on { guard.permit(limits, (*asked).min(limits.max_duty), least, period_us) } else { 0 };
            self.limited |= u64::from(on && put != asked) << channel;
            longest = longest.max(*put);
        }
        hardware.begin_period(self.put.get(..session.channels).unwrap_or_default(), session.period_ns as u32);
        let on_ns = session.period_ns * u64::from(longest) / u64::from(FULL_DUTY);
        self.begun_ns = now_ns;
        if longest > 0 {
            (self.user, self.unused_ns) = (session.number, Some(now_ns.saturating_add(on_ns)));
        }
        self.sample_ns = now_ns.saturating_add(on_ns.clamp(session.period_ns / 8, session.period_ns / 4 * 3));
        (self.sampled, self.waiting) = (false, false);
        self.frame = self.sequence.filter(|_| framed);
    }

    /// Takes the samples of the present period, judges them, and sends them if a frame began it.
    fn sample(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        let mut samples = [RawSample::NONE; MAX_CHANNELS];
        let samples = samples.get_mut(..self.channels()).unwrap_or_default();
        hardware.samples(samples);
        self.judge(samples, true, now_ns, hardware);
        if let Some(sequence) = self.frame {
            self.answer(sequence, now_ns, samples, hardware);
        }
    }

    /// Judges the present period by its samples, of which it leaves what the driver is to have. One that is not `whole` was not sampled.
    fn judge<H: Hardware>(&mut self, samples: &mut [RawSample], whole: bool, now_ns: u64, hardware: &mut H) {
        let Some(session) = self.session else { return };
        self.sampled = true;
        let elapsed_us = (now_ns.saturating_sub(self.judged_ns) / 1000).min(u32::MAX.into()) as u32;
        self.judged_ns = now_ns;
        let full = u64::from(self.who.full_code).max(1);
        let duties = self.put.iter().zip(&self.asked);
        let channels = self.guard.iter_mut().zip(&self.limits).zip(&self.who.channel).zip(duties).zip(samples);
        for (channel, ((((guard, limits), range), (duty, asked)), raw)) in channels.enumerate() {
            let on_ns = session.period_ns * u64::from(*duty) / u64::from(FULL_DUTY);
            let milliamperes =
                |code: u16| (u64::from(code) * u64::from(range.current_ua) / full / 1000).min(u32::MAX.into()) as u32;
            let period = Period {
                duty: *duty,
                current_ma: (raw.current != NOT_SAMPLED).then(|| milliamperes(raw.current)),
                full_scale_ma: range.current_ua / 1000,
                measurable: whole && on_ns >= H::MIN_ON_NS,
                stage: hardware.stage_fault(channel),
                elapsed_us,
            };
            let conducted = guard.conducts;
            let new = guard.judge(limits, &period);
            if let Some(fault) = new {
                hardware.tell(Event::Fault { channel: channel as u8, fault });
            }
            // The driver is to see by what the stage was found to conduct.
            let shows = guard.conducts && !conducted;
            if guard.fault.is_some() && !shows {
                *raw = RawSample::NONE;
            } else if *duty == 0 && *asked > 0 {
                // It was not put out, and says nothing of the wire.
                *raw = RawSample { supply: raw.supply, ..RawSample::NONE };
            }
        }
        if self.guard.iter().take(session.channels).any(|guard| guard.conducts) {
            self.unused_ns = Some(now_ns);
            self.supply(false, hardware);
        }
    }

    fn answer(&mut self, sequence: u32, now_ns: u64, samples: &[RawSample], hardware: &mut impl Hardware) {
        let mut answer = Samples {
            sequence,
            state: self.state,
            stop_open: self.was_open,
            reset_pressed: self.stop.reset_pressed,
            after_us: (now_ns.saturating_sub(self.begun_ns) / 1000).min(u16::MAX.into()) as u16,
            clock_us: (now_ns / 1000) as u32,
            lost: self.lost,
            refused: self.refused,
            channels: samples.len() as u8,
            sample: [RawSample::NONE; MAX_CHANNELS],
            fault: [None; MAX_CHANNELS],
            limited: self.limited,
        };
        for (place, raw) in answer.sample.iter_mut().zip(samples) {
            *place = *raw;
        }
        for (place, guard) in answer.fault.iter_mut().zip(&self.guard).take(samples.len()) {
            *place = guard.fault;
        }
        send(&Frame::Samples(answer), hardware);
        self.was_open = false;
    }

    /// An answer without samples, at once: everything is off.
    fn answer_nothing(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        let nothing = [RawSample::NONE; MAX_CHANNELS];
        let nothing = nothing.get(..self.channels()).unwrap_or_default();
        self.answer(self.sequence.unwrap_or(0), now_ns, nothing, hardware);
    }

    /// Silence: off, and reported.
    fn trip(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        let powered = self.put_out().iter().any(|duty| *duty > 0);
        self.put_off(now_ns, hardware);
        self.state = State::Tripped;
        hardware.tell(Event::Silent { since_ns: now_ns.saturating_sub(self.heard_ns), powered });
        self.answer_nothing(now_ns, hardware);
    }

    /// The emergency stop: off as soon as its contact is seen open, and reported.
    fn look_at_stop(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        if !self.session.is_some_and(|session| session.uses_stop) {
            self.stop = StopPins { closed: true, reset_pressed: false };
            return;
        }
        // One that was there and shows nothing is as good as open.
        self.stop = hardware.stop_inputs().unwrap_or(StopPins { closed: false, reset_pressed: false });
        if self.stop.closed {
            return;
        }
        self.was_open = true;
        if self.state != State::Stopped {
            self.put_off(now_ns, hardware);
            self.state = State::Stopped;
            hardware.tell(Event::Stopped);
            self.answer_nothing(now_ns, hardware);
        }
        self.zeros = 0;
    }

    fn switch_off(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        self.put_off(now_ns, hardware);
        self.state = match self.state {
            State::Boot => State::Boot,
            State::Stopped if !self.stop.closed => State::Stopped,
            _ => State::Ready,
        };
        hardware.tell(Event::Off);
    }

    fn clear(&mut self, channel: u8, hardware: &mut impl Hardware) {
        let channel = usize::from(channel);
        match (self.guard.get_mut(channel), self.limits.get(channel)) {
            (Some(guard), Some(limits)) if channel < usize::from(self.who.channels) => {
                guard.clear(limits, hardware.stage_fault(channel));
            }
            _ => self.refused = self.refused.wrapping_add(1),
        }
    }

    /// The enable pin, for a period.
    fn supply(&mut self, on: bool, hardware: &mut impl Hardware) {
        self.level = match self.session.map(|session| session.enable) {
            Some(EnableMode::Level) => on,
            Some(EnableMode::Pulses) => on && !self.level,
            Some(EnableMode::None) | None => false,
        };
        self.is_supplied = on && self.session.is_some_and(|session| session.enable != EnableMode::None);
        hardware.enable(self.level);
    }

    /// Everything off, now, and nothing asked for. A period that is cut short counts as one with its whole on-phase.
    fn put_off(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        hardware.off();
        self.supply(false, hardware);
        if !self.sampled {
            let mut nothing = [RawSample::NONE; MAX_CHANNELS];
            let nothing = nothing.get_mut(..self.channels()).unwrap_or_default();
            self.judge(nothing, false, now_ns, hardware);
        }
        self.put = [0; MAX_CHANNELS];
        self.asked = [0; MAX_CHANNELS];
        (self.zeros, self.waiting) = (0, false);
    }
}

/// Sends a frame of its own making, which always fits.
fn send(frame: &Frame, hardware: &mut impl Hardware) {
    let mut line = [0; MAX_FRAME];
    if let Some(bytes) = frame::encode(frame, &mut line).ok().and_then(|length| line.get(..length)) {
        hardware.send(bytes);
    }
}
