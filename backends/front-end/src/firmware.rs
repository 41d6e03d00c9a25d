//! The firmware's logic: receives frames, keeps the period, samples, answers, and switches off by itself.
//!
//! ```text
//!          configure            two frames of zeros          silence
//!   Boot ------------> Ready ------------------------> Running -------> Tripped
//!                        ^                               |  ^               |
//!                        +-------------- off ------------+  +---------------+
//!                                                             two frames of zeros
//! ```
//!
//! A duty frame's arrival begins a period: outputs on for their share of it, then off. At the end of the longest on-phase, at
//! the latest at three quarters of the period, the samples go up with the frame's own sequence number, in time for the
//! driver's next tick. A late frame is awaited for a quarter of a period with outputs off; then its predecessor's duties
//! are output again, until silence has lasted for the watchdog's time. A frame that arrives within half a period of the last one
//! (a stalled line may deliver several at once) waits for the end of the period instead of beginning another, so
//! that no burst of frames heats a wire.

use crate::frame::{
    self, ChannelFault, ChannelLimits, Configure, Duty, FULL_DUTY, Frame, Identification, MAX_CHANNELS, NOT_SAMPLED,
    RawSample, Refusal, Samples, State,
};
use crate::guard::{Guard, Period};
use crate::wire::{Decoder, MAX_BODY_TO_DEVICE, MAX_FRAME};

/// Duty frames of nothing but zeros before anything is put out.
const ARMING_FRAMES: u8 = 2;
/// Shortest on-phase in which a conversion fits, ns.
const MIN_ON_NS: u64 = 5_000;

/// What a firmware needs of its microcontroller.
pub trait Hardware {
    /// Begins a period now: every output goes on and, after its share of `period_ns` (`duty` of 65535), off, and stays off
    /// until this is called again. Conversions are triggered at the end of each output's on-phase, or at three quarters of
    /// the period where that comes first.
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
    period_ns: u64,
    silence_ns: u64,
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
    /// What that frame asks, within the limits, and what is put out.
    asked: [u16; MAX_CHANNELS],
    put: [u16; MAX_CHANNELS],
    limited: u64,
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
        for byte in bytes {
            let frame = match self.decoder.push(*byte) {
                None => continue,
                Some(body) => body.and_then(frame::decode),
            };
            match frame {
                Ok(Frame::Hello { nonce }) => {
                    self.who.nonce = nonce;
                    send(&Frame::Identification(self.who), hardware);
                }
                Ok(Frame::Configure(wanted)) => self.configure(&wanted, now_ns, hardware),
                Ok(Frame::Duty(duty)) => self.duty(&duty, now_ns, hardware),
                Ok(Frame::Off) => self.switch_off(hardware),
                // Frames of the front-end's own kinds and damaged ones are dropped.
                Ok(_) | Err(_) => self.refused = self.refused.wrapping_add(1),
            }
        }
    }

    /// Does what time asks for; to be called at the time it gives back, or earlier. `None`: nothing, until a frame comes.
    pub fn poll(&mut self, now_ns: u64, hardware: &mut impl Hardware) -> Option<u64> {
        let session = self.session?;
        let silent_ns = self.heard_ns.saturating_add(session.silence_ns);
        if self.may_heat() && now_ns >= silent_ns {
            self.trip(now_ns, hardware);
        }
        if !self.sampled && now_ns >= self.sample_ns {
            self.sample(now_ns, hardware);
        }
        if now_ns >= self.end_ns(&session) {
            self.begin(now_ns, self.waiting, hardware);
        }
        let next_ns = if self.sampled { self.end_ns(&session) } else { self.sample_ns };
        Some(if self.may_heat() { next_ns.min(silent_ns) } else { next_ns })
    }

    /// Whether silence has to be cut short: something is on, or will be in the next period.
    fn may_heat(&self) -> bool {
        self.state == State::Running && self.put.iter().chain(&self.asked).any(|duty| *duty > 0)
    }

    /// When the next period begins, should no frame begin it.
    fn end_ns(&self, session: &Session) -> u64 {
        let grace_ns = if self.waiting { 0 } else { session.period_ns / 4 };
        self.begun_ns.saturating_add(session.period_ns).saturating_add(grace_ns)
    }

    fn configure(&mut self, wanted: &Configure, now_ns: u64, hardware: &mut impl Hardware) {
        hardware.off();
        self.put_zero();
        self.session = None;
        self.state = State::Boot;
        let period_ns = wanted.period_ns;
        let silence_ns = u64::from(period_ns) * u64::from(wanted.watchdog_periods);
        let refusal = match () {
            () if wanted.channels == 0 || wanted.channels > self.who.channels => Some(Refusal::Channels),
            () if period_ns < self.who.min_period_ns.max(1) || period_ns > self.who.max_period_ns => {
                Some(Refusal::Period)
            }
            () if silence_ns == 0 || silence_ns > u64::from(self.who.max_silence_ns) => Some(Refusal::Silence),
            () => None,
        };
        match refusal {
            Some(refusal) => hardware.tell(Event::Refused(refusal)),
            None => {
                for ((limits, range), wanted) in self.limits.iter_mut().zip(&self.who.channel).zip(&wanted.limits) {
                    *limits = range.limits.narrower(wanted);
                }
                // I²t and faults are kept: a new configuration cools no wire.
                (self.sequence, self.limited, self.lost, self.refused) = (None, 0, 0, 0);
                (self.begun_ns, self.heard_ns, self.judged_ns, self.framed_ns) = (now_ns, now_ns, now_ns, None);
                (self.sampled, self.frame) = (true, None);
                self.session =
                    Some(Session { period_ns: period_ns.into(), silence_ns, channels: wanted.channels.into() });
                self.state = State::Ready;
                hardware.tell(Event::Configured { period_ns });
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
        self.limited = 0;
        let channels = duty.duty.iter().zip(&mut self.asked).zip(&self.limits).zip(&mut self.guard);
        for (channel, (((wanted, asked), limits), guard)) in channels.take(session.channels).enumerate() {
            guard.asked(*wanted);
            *asked = (*wanted).min(limits.max_duty);
            self.limited |= u64::from(asked != wanted) << channel;
        }
        let nothing = duty.duty.iter().take(session.channels).all(|duty| *duty == 0);
        self.zeros = if nothing { self.zeros.saturating_add(1) } else { 0 };
        (self.sequence, self.heard_ns) = (Some(duty.sequence), now_ns);
        if matches!(self.state, State::Ready | State::Tripped) && self.zeros >= ARMING_FRAMES {
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
    fn begin(&mut self, now_ns: u64, framed: bool, hardware: &mut impl Hardware) {
        let Some(session) = self.session else { return };
        if !self.sampled {
            self.sample(now_ns, hardware);
        }
        let running = self.state == State::Running;
        let mut longest = 0;
        for ((put, asked), guard) in self.put.iter_mut().zip(&self.asked).zip(&self.guard).take(session.channels) {
            *put = if running && guard.fault.is_none() { *asked } else { 0 };
            longest = longest.max(*put);
        }
        hardware.begin_period(self.put.get(..session.channels).unwrap_or_default(), session.period_ns as u32);
        let on_ns = session.period_ns * u64::from(longest) / u64::from(FULL_DUTY);
        self.begun_ns = now_ns;
        self.sample_ns = now_ns.saturating_add(on_ns.clamp(session.period_ns / 8, session.period_ns / 4 * 3));
        (self.sampled, self.waiting) = (false, false);
        self.frame = self.sequence.filter(|_| framed);
    }

    /// Takes the samples of the present period, judges them, and sends them if a frame began it.
    fn sample(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        let Some(session) = self.session else { return };
        self.sampled = true;
        let mut samples = [RawSample::NONE; MAX_CHANNELS];
        let samples = samples.get_mut(..session.channels).unwrap_or_default();
        hardware.samples(samples);
        let elapsed_us = (now_ns.saturating_sub(self.judged_ns) / 1000).min(u32::MAX.into()) as u32;
        self.judged_ns = now_ns;
        let full = u64::from(self.who.full_code).max(1);
        let channels = self.guard.iter_mut().zip(&self.limits).zip(&self.who.channel).zip(&self.put).zip(&mut *samples);
        for (channel, ((((guard, limits), range), duty), raw)) in channels.enumerate() {
            let on_ns = session.period_ns * u64::from(*duty) / u64::from(FULL_DUTY);
            let current_ma = (raw.current != NOT_SAMPLED)
                .then(|| (u64::from(raw.current) * u64::from(range.current_ua) / full / 1000) as u32);
            let period = Period {
                duty: *duty,
                current_ma,
                measurable: on_ns >= MIN_ON_NS,
                stage: hardware.stage_fault(channel),
                elapsed_us,
            };
            if let Some(fault) = guard.judge(limits, &period) {
                hardware.tell(Event::Fault { channel: channel as u8, fault });
            }
            // Without an on-phase there is nothing to measure of the wire, whatever a converter picked up.
            if guard.fault.is_some() {
                *raw = RawSample::NONE;
            } else if *duty == 0 {
                *raw = RawSample { supply: raw.supply, ..RawSample::NONE };
            }
        }
        if let Some(sequence) = self.frame {
            self.answer(sequence, now_ns, samples, hardware);
        }
    }

    fn answer(&mut self, sequence: u32, now_ns: u64, samples: &[RawSample], hardware: &mut impl Hardware) {
        let mut answer = Samples {
            sequence,
            state: self.state,
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
    }

    /// Silence: off, and reported.
    fn trip(&mut self, now_ns: u64, hardware: &mut impl Hardware) {
        hardware.off();
        let powered = self.put_out().iter().any(|duty| *duty > 0);
        self.put_zero();
        self.state = State::Tripped;
        hardware.tell(Event::Silent { since_ns: now_ns.saturating_sub(self.heard_ns), powered });
        let nothing = [RawSample::NONE; MAX_CHANNELS];
        let nothing = nothing.get(..self.channels()).unwrap_or_default();
        self.answer(self.sequence.unwrap_or(0), now_ns, nothing, hardware);
    }

    fn switch_off(&mut self, hardware: &mut impl Hardware) {
        hardware.off();
        self.put_zero();
        if self.state != State::Boot {
            self.state = State::Ready;
        }
        hardware.tell(Event::Off);
    }

    fn put_zero(&mut self) {
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
