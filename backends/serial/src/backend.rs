//! The exchange: reads the received frames, writes one frame, never blocks.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::io::Errno;
use sinew_backend::clock::now_ns;
use sinew_backend::{Backend, BackendError, ChannelFault, Sample, Zero, check_exchange};
use sinew_front_end::ChannelFault as DeviceFault;
use sinew_front_end::{Decoder, Duty, Frame, MAX_BODY, MAX_CHANNELS, MAX_FRAME, Samples, State, decode, encode};
use sinew_rig::Rig;

use crate::error::Error;
use crate::figures::LineFigures;
use crate::keeper::Keeper;
use crate::link::{Link, connect};
use crate::plan::{Plan, Scale, duty_code, name};

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
    /// What the front-end calls itself.
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
    /// The channel that had failed by the last frame: no frame since does not mean that it is healthy.
    failed: Option<BackendError>,
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
            front_end: name(&who),
            scales,
            places: plan.channels.iter().map(|channel| channel.place).collect(),
            used: plan.used,
            period_us: f64::from(plan.period_ns) * 1e-3,
            own_ns: (f64::from(plan.period_ns) * OWN) as u64,
            late_ns: (f64::from(plan.period_ns) * LATE) as u64,
            watchdog_periods,
            give_up_periods: watchdog_periods.max((GIVE_UP_S * rig.rate_hz).ceil() as u32),
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
            failed: None,
            state: State::Ready,
            silent: 0,
            line: [0; MAX_FRAME],
        })
    }

    /// What the front-end calls itself: name, version, serial number.
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
            self.link = Some(link);
            self.decoder = Decoder::new();
            (self.answer, self.failed, self.state, self.silent) = (None, None, State::Ready, 0);
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
        self.answer = None;
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
        let mut frame = Duty { sequence: self.sequence, channels: self.used, duty: [0; MAX_CHANNELS] };
        for (place, duty) in self.places.iter().zip(duty.unwrap_or_default()) {
            // A duty that is not zero stays so: no on-phase would read as a broken wire.
            frame.duty[*place] = duty_code(*duty).max(u16::from(*duty > 0.0));
        }
        let taken = match encode(&Frame::Duty(frame), &mut self.line) {
            Ok(length) => link.port.write(&self.line[..length])?,
            Err(_) => false,
        };
        self.sent_ns = now_ns();
        LineFigures::count(if taken { &self.figures.sent } else { &self.figures.unsent });
        Ok(taken)
    }

    /// A failed exchange: nothing measured, nothing put out.
    fn fail(&mut self, samples: &mut [Sample], error: BackendError) -> Result<(), BackendError> {
        samples.fill(Sample::NONE);
        self.answer = None;
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

    /// What an answer says of each channel; the lowest that has failed.
    fn read_out(&self, answer: &Samples, samples: &mut [Sample]) -> Option<BackendError> {
        let mut failed = None;
        for (channel, ((sample, place), scale)) in samples.iter_mut().zip(&self.places).zip(&self.scales).enumerate() {
            *sample = match answer.fault[*place] {
                None => scale.sample(&answer.sample[*place]),
                Some(fault) => {
                    let fault = match fault {
                        DeviceFault::OverCurrent | DeviceFault::Heat => ChannelFault::OverCurrent,
                        DeviceFault::Converter => ChannelFault::Converter,
                        DeviceFault::StageHot => ChannelFault::OverTemperature,
                        DeviceFault::Stage => ChannelFault::Stage,
                    };
                    failed = failed.or(Some(BackendError::Channel { channel: channel as u32, fault }));
                    Sample::NONE
                }
            };
        }
        failed
    }
}

impl Backend for SerialBackend {
    fn channels(&self) -> usize {
        self.places.len()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        let began = Instant::now();
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
            if self.state == State::Running {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(self.period_us * 1e-6));
        }
        (self.started, self.silent, self.answer, self.failed) = (true, 0, None, None);
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
        if !self.has_line() {
            return Err(BackendError::Unavailable { os_error: Errno::NODEV.raw_os_error() });
        }
        if let Err(error) = self.receive() {
            self.lose_line();
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
            self.failed = self.read_out(answer, samples);
        }
        // A front-end that is not armed yet gets zero duty, which arms it.
        let duty = (self.state == State::Running).then_some(duty);
        match self.send(duty) {
            // Whether it has arrived is known with its answer; that of the one before says that they do.
            Ok(taken) => self.is_confirmed = taken && answer.is_some(),
            Err(error) => {
                self.lose_line();
                self.is_confirmed = false;
                samples.fill(Sample::NONE);
                return Err(BackendError::Io { os_error: error.raw_os_error() });
            }
        }
        self.failed.map_or(Ok(()), Err)
    }

    fn is_confirmed(&self, _channel: usize) -> bool {
        self.is_confirmed
    }

    fn silence_s(&self) -> Option<f64> {
        Some(self.silence_s)
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        let place = self.places.get(channel)?;
        Some(format!("front-end {}/{place}", self.front_end))
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
