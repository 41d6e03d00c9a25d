//! The exchange: reads the received frames, writes one frame, never blocks.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::io::Errno;
use sinew_backend::clock::now_ns;
use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, StopInputs, Unused, Zero, check_exchange};
use sinew_front_end::{
    ChannelFault as DeviceFault, Decoder, Duty, EnableMode, Frame, MAX_BODY, MAX_CHANNELS, MAX_FRAME, NOT_SAMPLED,
    Samples, State, decode, encode,
};
use sinew_rig::Rig;

use crate::error::Error;
use crate::figures::LineFigures;
use crate::keeper::Keeper;
use crate::link::{Link, connect};
use crate::plan::{Plan, Scale, duty_code, name, started};

/// Reads in one exchange at most: what a line has piled up beyond is old, and waits for the next one.
const READS: usize = 8;
/// A front-end that has not answered for so long is asked anew who it is, s.
const GIVE_UP_S: f64 = 0.5;
/// Shares of a period after which a duty frame that follows begins one of its own on the front-end (half of one, and a bit for the
/// way there), and after which samples that are not there are late.
const OWN: f64 = 0.625;
const LATE: f64 = 0.875;
/// How long `stop` waits for the answer to a zero, beyond the time in which the front-end goes off by itself.
const STOP_PATIENCE: Duration = Duration::from_millis(20);
/// How long `start` waits for a line that is being had back.
const START_PATIENCE: Duration = Duration::from_secs(2);

/// A front-end on a serial line.
#[derive(Debug)]
pub struct SerialBackend {
    /// What the front-end calls itself, and the same with why it last started.
    name: String,
    front_end: String,
    scales: Vec<Scale>,
    places: Vec<usize>,
    used: u8,
    period_us: f64,
    /// The same shares, ns.
    own_ns: u64,
    late_ns: u64,
    watchdog_periods: u32,
    give_up_periods: u32,
    keeper: Keeper,
    figures: Arc<LineFigures>,
    link: Option<Link>,
    decoder: Decoder<MAX_BODY>,
    started: bool,
    /// Of the duty frame sent last, and when that was.
    sequence: u32,
    sent_ns: u64,
    /// The last samples of it, once they are there.
    answer: Option<Samples>,
    /// Whether the front-end has, for all that was heard of it, what it was last sent; zero after a failure.
    is_confirmed: bool,
    silence_s: f64,
    /// This driver for the front-end, who had driven its outputs before, and the same by what this one has done since.
    session: u32,
    before: u32,
    user: u32,
    /// For how long nothing had been put out when the line was had, s; and the same of one that was had back in the last exchange, where somebody
    /// else may have used it meanwhile.
    unused_s: f64,
    regained: Option<f64>,
    /// How long a duty frame is valid, µs.
    valid_us: u32,
    /// Whether there is an enable line, and whether it was cut.
    has_enable: bool,
    is_cut: bool,
    /// Channels whose faults are to be forgotten, by their places, from the next frame on.
    clears: u64,
    /// Channels whose duty the frame sent last did not carry, by their places.
    withheld: u64,
    /// The emergency stop by the frames since the last exchange, if any came; as the exchange made of it, where one is fitted; and how
    /// many exchanges ago that was heard.
    heard: Option<StopInputs>,
    stop: Option<StopInputs>,
    unheard: u32,
    /// What had failed of each channel by the last frame: no frame since does not mean that it is healthy.
    failures: Vec<Option<ChannelFault>>,
    /// The front-end's state by the last frame.
    state: State,
    /// Exchanges in a row without an answer.
    silent: u32,
    line: [u8; MAX_FRAME],
}

impl SerialBackend {
    /// Opens the line of a rig's `[backend.serial]` and finds its front-end.
    ///
    /// # Errors
    /// Whatever keeps it from being used, or from being what the rig file describes.
    pub fn connect(rig: &Rig) -> Result<SerialBackend, Error> {
        let plan = Plan::of(rig)?;
        let (link, who, scales) = connect(&plan)?;
        let figures = Arc::new(LineFigures::default());
        LineFigures::count(&figures.connections);
        let watchdog_periods = u32::from(plan.watchdog_periods);
        Ok(SerialBackend {
            front_end: format!("{}, {}", name(&who), started(&who)),
            name: name(&who),
            scales,
            places: plan.channels.iter().map(|channel| channel.place).collect(),
            used: plan.used,
            period_us: f64::from(plan.period_ns) * 1e-3,
            own_ns: (f64::from(plan.period_ns) * OWN) as u64,
            late_ns: (f64::from(plan.period_ns) * LATE) as u64,
            watchdog_periods,
            give_up_periods: watchdog_periods.max((GIVE_UP_S * rig.rate_hz).ceil() as u32),
            session: plan.session,
            before: link.user,
            user: link.user,
            unused_s: link.unused_s,
            regained: None,
            valid_us: plan.valid_us(),
            has_enable: plan.enable != EnableMode::None,
            is_cut: false,
            clears: 0,
            withheld: 0,
            heard: None,
            stop: plan.uses_stop.then_some(StopInputs::OPEN),
            unheard: 0,
            keeper: Keeper::start(plan, link, who, figures.clone())?,
            figures,
            link: None,
            decoder: Decoder::new(),
            started: false,
            sequence: 0,
            sent_ns: 0,
            answer: None,
            is_confirmed: true,
            silence_s: rig.silence_s(),
            failures: vec![None; rig.channels.len()],
            state: State::Ready,
            silent: 0,
            line: [0; MAX_FRAME],
        })
    }

    /// What the front-end calls itself: name, version, serial number; and why it had last started when it was connected.
    pub fn front_end(&self) -> &str {
        &self.front_end
    }

    /// How the line does.
    pub fn figures(&self) -> Arc<LineFigures> {
        self.figures.clone()
    }

    /// A line, from the keeper if there was none. Whether there is one.
    fn has_line(&mut self) -> bool {
        if self.link.is_none()
            && let Some(link) = self.keeper.take()
        {
            if !self.started {
                (self.before, self.unused_s) = (link.user, link.unused_s);
            } else if link.user != self.user {
                self.regained = Some(link.unused_s);
            }
            self.user = link.user;
            self.link = Some(link);
            self.decoder = Decoder::new();
            (self.answer, self.state, self.silent) = (None, State::Ready, 0);
            self.failures.fill(None);
            // A configuration has just put everything to zero.
            self.is_confirmed = true;
        }
        self.link.is_some()
    }

    /// Leaves the line to the keeper.
    fn lose_line(&mut self) {
        if let Some(link) = self.link.take() {
            self.keeper.give_up(link);
        }
        (self.answer, self.heard) = (None, None);
        self.stop = self.stop.map(|_| StopInputs::OPEN);
        // What a client asked of the one that is gone is not asked of the next one.
        self.clears = 0;
    }

    /// Takes in what has arrived.
    fn receive(&mut self) -> Result<(), Errno> {
        let Some(link) = &self.link else { return Ok(()) };
        let mut buffer = [0; 2048];
        for _ in 0..READS {
            let count = link.port.read(&mut buffer)?;
            for byte in &buffer[..count] {
                let samples = match self.decoder.push(*byte).map(|body| body.and_then(decode)) {
                    Some(Ok(Frame::Samples(samples))) => samples,
                    Some(Err(_)) => {
                        LineFigures::count(&self.figures.damaged);
                        continue;
                    }
                    // The rest of the identification.
                    Some(Ok(_)) | None => continue,
                };
                if samples.state == State::Tripped && self.state != State::Tripped {
                    LineFigures::count(&self.figures.trips);
                }
                self.state = samples.state;
                self.heard = Some(stop_inputs(&samples, self.heard));
                if samples.sequence == self.sequence && samples.channels == self.used {
                    self.answer = Some(samples);
                } else {
                    LineFigures::count(&self.figures.late);
                }
            }
            if count < buffer.len() {
                break;
            }
        }
        Ok(())
    }

    /// Sends the next duty frame, nothing but zeros where `duty` is `None`. Whether the line has taken it.
    fn send(&mut self, duty: Option<&[f64]>) -> Result<bool, Errno> {
        let Some(link) = &self.link else { return Ok(false) };
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = Duty {
            sequence: self.sequence,
            valid_us: self.valid_us,
            supply: self.started && !self.is_cut,
            channels: self.used,
            duty: [0; MAX_CHANNELS],
        };
        for (place, duty) in self.places.iter().zip(duty.unwrap_or_default()) {
            // A duty that is not zero stays so: no on-phase would read as a broken wire.
            frame.duty[*place] = duty_code(*duty).max(u16::from(*duty > 0.0));
        }
        // One write: what is to be forgotten, and then the period that shows whether it was.
        let (mut length, mut clears) = (0, self.clears);
        while clears != 0 {
            let channel = clears.trailing_zeros() as u8;
            clears &= clears - 1;
            length += encode(&Frame::Clear { channel }, &mut self.line[length..]).unwrap_or(0);
        }
        let taken = match encode(&Frame::Duty(frame), &mut self.line[length..]) {
            Ok(more) => link.port.write(&self.line[..length + more])?,
            Err(_) => false,
        };
        if frame.duty.iter().any(|duty| *duty > 0) {
            self.user = self.session;
        }
        if taken {
            self.clears = 0;
        }
        self.sent_ns = now_ns();
        LineFigures::count(if taken { &self.figures.sent } else { &self.figures.unsent });
        Ok(taken)
    }

    /// A failed exchange: nothing measured, nothing put out.
    fn fail(&mut self, samples: &mut [Sample], error: BackendError) -> Result<(), BackendError> {
        samples.fill(Sample::NONE);
        (self.answer, self.withheld) = (None, u64::MAX);
        // One that has tripped has said that it is off.
        self.is_confirmed = self.state == State::Tripped;
        if self.send(None).is_err() {
            self.lose_line();
        }
        Err(error)
    }

    /// Waits for the front-end to answer a frame of zeros, for no longer than its watchdog and the machine need.
    fn hears_of_zero(&mut self) -> bool {
        let began = Instant::now();
        let patience = Duration::from_secs_f64(self.silence_s) + STOP_PATIENCE;
        while self.link.is_some() && began.elapsed() < patience {
            if self.receive().is_err() || self.send(None).is_err() {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(self.period_us * 1e-6));
            match self.receive() {
                Ok(()) if self.answer.take().is_some() => return true,
                Ok(()) => {}
                Err(_) => break,
            }
        }
        false
    }

    /// The same however long it has been: one that changed from cycle to cycle would be reported in each.
    fn timeout(&self) -> BackendError {
        BackendError::Timeout { waited_us: (f64::from(self.watchdog_periods) * self.period_us) as u32 }
    }

    /// What an answer says of each channel.
    fn read_out(&mut self, answer: &Samples, samples: &mut [Sample]) {
        let channels = samples.iter_mut().zip(&mut self.failures).zip(self.places.iter().zip(&self.scales));
        for ((sample, failure), (place, scale)) in channels {
            let raw = &answer.sample[*place];
            *failure = match answer.fault[*place] {
                // What a stage was found to conduct by comes with the fault, once: the driver's own watch judges it.
                Some(DeviceFault::Stage) if raw.current != NOT_SAMPLED => None,
                None => None,
                Some(DeviceFault::OverCurrent | DeviceFault::Heat) => Some(ChannelFault::OverCurrent),
                Some(DeviceFault::Converter) => Some(ChannelFault::Converter),
                Some(DeviceFault::StageHot) => Some(ChannelFault::OverTemperature),
                Some(DeviceFault::Stage) => Some(ChannelFault::Stage),
            };
            let is_withheld = self.withheld >> place & 1 != 0;
            *sample = match failure {
                Some(_) => Sample::NONE,
                None if is_withheld => Sample { supply_v: scale.sample(raw).supply_v, ..Sample::NONE },
                None => scale.sample(raw),
            };
        }
    }

    /// The lowest channel that has failed.
    fn failed(&self) -> Option<BackendError> {
        let failed = |(channel, failure): (usize, &Option<ChannelFault>)| {
            failure.map(|fault| BackendError::Channel { channel: channel as u32, fault })
        };
        self.failures.iter().enumerate().find_map(failed)
    }

    /// What the exchange that begins knows of the emergency stop.
    fn look_at_stop(&mut self) {
        let heard = self.heard.take();
        self.unheard = if heard.is_some() { 0 } else { self.unheard.saturating_add(1) };
        let is_known = self.link.is_some() && self.unheard < self.watchdog_periods;
        if let Some(stop) = &mut self.stop {
            *stop = if is_known { heard.unwrap_or(*stop) } else { StopInputs::OPEN };
        }
    }
}

/// What samples say of the emergency stop; once open since the last exchange is open.
fn stop_inputs(samples: &Samples, before: Option<StopInputs>) -> StopInputs {
    // A front-end that has been stopped says so by its state for as long as it has not been armed anew, whatever frame got lost.
    let is_open = samples.stop_open || matches!(samples.state, State::Boot | State::Stopped);
    StopInputs {
        is_closed: !is_open && before.is_none_or(|before| before.is_closed),
        is_reset_pressed: samples.reset_pressed,
    }
}

impl Backend for SerialBackend {
    fn channels(&self) -> usize {
        self.places.len()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        let began = Instant::now();
        (self.started, self.is_cut, self.clears, self.withheld) = (false, false, 0, 0);
        self.stop = self.stop.map(|_| StopInputs::OPEN);
        while !self.has_line() {
            if began.elapsed() > START_PATIENCE {
                return Err(BackendError::Unavailable { os_error: Errno::NODEV.raw_os_error() });
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        // Arms it: the loop's sensing pulses are to be measured from the first one on.
        loop {
            let lost = self.receive().and_then(|()| self.send(None));
            if lost.is_err() || self.state == State::Boot || began.elapsed() > START_PATIENCE {
                self.lose_line();
                return Err(BackendError::Timeout { waited_us: began.elapsed().as_micros() as u32 });
            }
            // Whether it may go on from a stop is the driver's to say.
            if matches!(self.state, State::Running | State::Stopped) {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(self.period_us * 1e-6));
        }
        (self.started, self.silent, self.answer) = (true, 0, None);
        self.failures.fill(None);
        self.is_confirmed = true;
        Ok(())
    }

    /// A frame that is sent too soon after the last one waits on the front-end for the end of that one's period, so that its samples
    /// would be late as well.
    fn is_due(&mut self) -> bool {
        let gone_ns = now_ns().saturating_sub(self.sent_ns);
        if self.link.is_none() || gone_ns >= self.late_ns {
            return true;
        }
        // The exchange reports errors of the line.
        self.receive().is_err() || self.state != State::Running || (self.answer.is_some() && gone_ns >= self.own_ns)
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        if !self.started {
            return Err(BackendError::NotStarted);
        }
        if let Err(error) = check_exchange(self.places.len(), duty, samples) {
            return self.fail(samples, error);
        }
        samples.fill(Sample::NONE);
        self.regained = None;
        if !self.has_line() {
            self.look_at_stop();
            return Err(BackendError::Unavailable { os_error: Errno::NODEV.raw_os_error() });
        }
        let received = self.receive();
        if received.is_err() {
            self.lose_line();
        }
        self.look_at_stop();
        if let Err(error) = received {
            self.is_confirmed = false;
            return Err(BackendError::Io { os_error: error.raw_os_error() });
        }
        // It restarted and has lost its configuration.
        if self.state == State::Boot {
            self.lose_line();
            self.is_confirmed = true;
            return Err(BackendError::Unavailable { os_error: 0 });
        }
        let answer = self.answer.take();
        self.silent = if answer.is_some() { 0 } else { self.silent.saturating_add(1) };
        if self.silent >= self.give_up_periods {
            self.lose_line();
            self.is_confirmed = false;
            return Err(self.timeout());
        }
        if self.silent >= self.watchdog_periods || self.state == State::Tripped {
            let error = self.timeout();
            return self.fail(samples, error);
        }
        if let Some(answer) = &answer {
            LineFigures::count(&self.figures.answered);
            self.read_out(answer, samples);
        }
        // A front-end that is not armed yet gets zero duty, which arms it.
        let is_armed = self.state == State::Running;
        let asked = self.places.iter().zip(duty).filter(|(_, duty)| **duty > 0.0);
        self.withheld = if is_armed { 0 } else { asked.fold(0, |places, (place, _)| places | 1 << place) };
        match self.send(is_armed.then_some(duty)) {
            // Whether it has arrived is known with its answer; that of the one before says that they do.
            Ok(taken) => self.is_confirmed = taken && answer.is_some(),
            Err(error) => {
                self.lose_line();
                self.is_confirmed = false;
                samples.fill(Sample::NONE);
                return Err(BackendError::Io { os_error: error.raw_os_error() });
            }
        }
        self.failed().map_or(Ok(()), Err)
    }

    fn is_confirmed(&self, _channel: usize) -> bool {
        self.is_confirmed
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.failures.get(channel).copied().flatten()
    }

    /// The front-end's pin goes off with the next frame, and by itself where none comes.
    fn cut(&mut self) -> bool {
        self.is_cut = true;
        self.has_enable
    }

    fn restore(&mut self) {
        self.is_cut = false;
    }

    fn clear(&mut self, channel: usize) {
        if let Some(place) = self.places.get(channel) {
            self.clears |= 1 << place;
        }
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.stop
    }

    fn silence_s(&self) -> Option<f64> {
        Some(self.silence_s)
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        let place = self.places.get(channel)?;
        Some(format!("front-end {}/{place}", self.name))
    }

    /// By the front-end's own witness.
    fn past(&self, _channel: usize) -> Past {
        Past { mark: self.before.into(), unused: Unused::For(self.unused_s) }
    }

    fn mark(&self, _channel: usize) -> u64 {
        self.user.into()
    }

    fn regained(&self) -> Option<f64> {
        self.regained
    }

    fn stop(&mut self) -> Zero {
        let was_started = std::mem::take(&mut self.started);
        self.answer = None;
        // If this frame is lost, the watchdog does the same.
        if let Some(link) = &self.link
            && let Ok(length) = encode(&Frame::Off, &mut self.line)
            && link.port.write(&self.line[..length]).is_err()
        {
            self.lose_line();
            self.is_confirmed = false;
        }
        if was_started {
            self.is_confirmed = self.hears_of_zero();
        }
        self.state = State::Ready;
        Zero::confirmed_if(self.is_confirmed)
    }
}

impl Drop for SerialBackend {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}
