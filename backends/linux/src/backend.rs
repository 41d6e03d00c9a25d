//! The backend itself: outputs, converters and guard behind the calls of the contract.
//!
//! A separate thread, the [`Mender`], looks for unplugged devices; the loop continues without them, and takes over the new
//! set of open files when there is one.

use std::path::PathBuf;
use std::time::Duration;

use rustix::io::Errno;
use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, StopInputs, Unused, Zero, check_exchange};
use sinew_rig::LEAST_SILENCE_PERIODS;

use crate::Error;
use crate::guard::{self, Guard, Watch};
use crate::iio::{self, Device};
use crate::line::{self, Contact, Place};
use crate::mender::Mender;
use crate::pwm::{self, Chip, Output};
use crate::sampler::Sampler;
use crate::settings::Settings;
use crate::supply::Supply;

/// A rig whose power stages hang on Linux's PWM outputs and whose converters are IIO devices.
#[derive(Debug)]
pub struct LinuxRig {
    settings: Settings,
    silence: Duration,
    /// Periods from one beat to the next.
    beat_every: u64,
    running: Option<Running>,
    /// Whether each output has what it was last given, zero after a failure; none has, while there are none.
    confirmed: Vec<bool>,
    /// What each output is called, whatever the rig file calls its channel.
    names: Vec<String>,
    /// What was known of each before the last start, and what it shows since.
    past: Vec<Past>,
    marks: Vec<u64>,
    /// While it is started.
    mender: Option<Mender<Running>>,
    /// Whether the supply is to stay off.
    is_cut: bool,
    stop: StopContact,
}

/// The emergency stop's inputs. Apart from everything else that is open: they are read while outputs or guard are looked for.
#[derive(Debug)]
struct StopContact {
    open: Option<Contact>,
    /// While the backend is started, where there is one.
    mender: Option<Mender<Contact>>,
    /// What they showed in the last exchange.
    shown: StopInputs,
}

/// What the names of the settings stand for.
#[derive(Debug)]
struct Found {
    outputs: Vec<(Chip, u32)>,
    devices: Vec<Device>,
    /// The line that switches the supply.
    enable: Option<Place>,
}

/// What the names of the lines stand for.
#[derive(Debug)]
struct Lines {
    enable: Option<Place>,
    contact: Option<Place>,
    reset: Option<Place>,
}

/// What is open between start and stop.
#[derive(Debug)]
struct Running {
    outputs: Vec<Output>,
    /// Whether each channel was given a duty in the period just past.
    driven: Vec<bool>,
    /// What has failed of each channel alone in the last exchange.
    failed: Vec<Option<ChannelFault>>,
    /// What was known of each output before it was set up, and what it shows since.
    witness: (Vec<Past>, Vec<u64>),
    sampler: Sampler,
    supply: Option<Supply>,
    /// Periods until the next beat.
    beat_in: u64,
    /// The output that is written at the next beat whether its duty changes or not: so it is noticed when a chip is gone, or when
    /// somebody else has written to it.
    refresh: usize,
    /// Last, so that it is dropped after everything else.
    guard: Guard,
}

impl LinuxRig {
    /// Finds the outputs and inputs that the settings name. Nothing is put out, nothing is exported yet.
    ///
    /// # Errors
    /// A name that nothing here bears, with what there is.
    pub fn new(settings: Settings) -> Result<LinuxRig, Error> {
        let found = Found::of(&settings)?;
        let name = |(chip, number): &(Chip, u32)| {
            let device = if chip.device.is_empty() { &chip.name } else { &chip.device };
            format!("pwm {} {device}/{number}", settings.root.display())
        };
        let names = found.outputs.iter().map(name).collect();
        let silence_s = silence_s(&settings);
        let beat_every = (silence_s * settings.rate_hz / f64::from(guard::BEATS)) as u64;
        Ok(LinuxRig {
            silence: Duration::from_secs_f64(silence_s),
            beat_every: beat_every.max(1),
            running: None,
            confirmed: vec![true; settings.channels.len()],
            past: vec![Past::UNKNOWN; settings.channels.len()],
            marks: vec![0; settings.channels.len()],
            names,
            mender: None,
            is_cut: false,
            stop: StopContact { open: None, mender: None, shown: StopInputs::OPEN },
            settings,
        })
    }

    /// Brings everything up, as [`Backend::start`] does, with the reason in words where that fails.
    ///
    /// # Errors
    /// What a file of the kernel, or the guard, has to say.
    pub fn bring_up(&mut self) -> Result<(), Error> {
        let _ = self.stop();
        self.stop.start(&self.settings)?;
        let mut running = Running::open(&self.settings)?;
        (self.past, self.marks) = std::mem::take(&mut running.witness);
        self.running = Some(running);
        self.confirmed.fill(true);
        self.is_cut = false;
        let settings = self.settings.clone();
        self.mender = Some(Mender::start("the outputs and converters", move || Running::open(&settings))?);
        Ok(())
    }

    /// The process that watches over the outputs, while the backend is started.
    pub fn guard_process(&self) -> Option<u32> {
        self.running.as_ref().map(|running| running.guard.id())
    }

    /// How long the guard bears the driver's silence.
    pub fn silence(&self) -> Duration {
        self.silence
    }
}

fn silence_s(settings: &Settings) -> f64 {
    settings.guard_s.max(LEAST_SILENCE_PERIODS / settings.rate_hz)
}

impl Found {
    fn of(settings: &Settings) -> Result<Found, Error> {
        let chips = pwm::chips(&settings.root);
        let devices = iio::devices(&settings.root);
        let mut outputs: Vec<(Chip, u32)> = Vec::new();
        for channel in &settings.channels {
            let found = pwm::find(&chips, &channel.pwm);
            let output = found.map_err(|reason| Error::name(&channel.name, "pwm", &channel.pwm, reason))?;
            if let Some(other) = outputs.iter().position(|taken| *taken == output) {
                let reason = format!("channel \"{}\" has that output already", settings.channels[other].name);
                return Err(Error::name(&channel.name, "pwm", &channel.pwm, reason));
            }
            outputs.push(output);
            channel.inputs.try_map(|key, input| match &input.name {
                Some(name) => iio::find(&devices, name)
                    .map(|_| ())
                    .map_err(|reason| Error::name(&channel.name, key, name, reason)),
                None if key == "current" => {
                    let reason = "without the current nothing can be told of the wire, expected an input";
                    Err(Error::name(&channel.name, key, "", reason))
                }
                None => Ok(()),
            })?;
        }
        if let Some(trigger) = &settings.trigger {
            let there = iio::triggers(&settings.root);
            if !there.contains(trigger) {
                let there = if there.is_empty() { "none".into() } else { there.join(", ") };
                return Err(Error::name(
                    "",
                    "linux.trigger",
                    trigger,
                    format!("there is no such trigger; there is {there}"),
                ));
            }
        }
        let enable = Found::lines(settings)?.enable;
        Ok(Found { outputs, devices, enable })
    }

    /// What the outputs show now.
    fn marks(&self) -> Vec<u64> {
        self.outputs.iter().map(|(chip, number)| pwm::mark(chip, *number).unwrap_or(0)).collect()
    }

    /// What is known of the outputs before they are set up. An output tells nothing that others may write to.
    fn past(&self, settings: &Settings, were_exported: &[bool]) -> Vec<Past> {
        // A watchdog relay drops out while the machine starts, and stays so until somebody gives it edges.
        let relay = settings.enable.as_ref().filter(|enable| enable.pulses).zip(self.enable.as_ref());
        let since = match relay {
            Some((enable, place)) if place.others().is_none() => {
                Unused::SinceStartOfMachine(enable.dropout.as_secs_f64())
            }
            _ => Unused::Unknown,
        };
        let outputs = self.outputs.iter().zip(were_exported).zip(self.marks()).zip(&settings.channels);
        let past = outputs.map(|((((chip, number), was_exported), mark), channel)| {
            if !was_exported {
                return Past { mark: 0, unused: since };
            }
            match pwm::others(chip, *number) {
                None => Past { mark, unused: Unused::Unknown },
                Some(who) => {
                    tracing::warn!(
                        "{}: {who} may drive {} too, and nobody could tell: how hot its wire is will not be remembered from one start to the \
                         next; let this user alone write to it",
                        channel.name,
                        channel.pwm
                    );
                    Past::UNKNOWN
                }
            }
        });
        past.collect()
    }

    /// The lines that the settings name.
    fn lines(settings: &Settings) -> Result<Lines, Error> {
        let Settings { root, enable, stop, .. } = settings;
        // No node is opened where no line is wanted.
        let chips = if enable.is_some() || stop.is_some() { line::chips(root) } else { Vec::new() };
        let mut taken: Vec<(&str, Place)> = Vec::new();
        let mut find = |key, name: &str| {
            let place = line::find(root, &chips, name).map_err(|reason| Error::name("", key, name, reason))?;
            if let Some((other, _)) = taken.iter().find(|(_, there)| *there == place) {
                return Err(Error::name("", key, name, format!("{other} is that line already")));
            }
            taken.push((key, place.clone()));
            Ok(place)
        };
        let enable = enable.as_ref().map(|enable| find("enable.line", &enable.line)).transpose()?;
        let contact = stop.as_ref().map(|stop| find("estop.line", &stop.line)).transpose()?;
        let reset = stop.as_ref().and_then(|stop| stop.reset_line.as_ref());
        let reset = reset.map(|name| find("estop.reset_line", name)).transpose()?;
        Ok(Lines { enable, contact, reset })
    }
}

impl StopContact {
    /// Opens it where the settings have one.
    fn start(&mut self, settings: &Settings) -> Result<(), Error> {
        let Some(stop) = &settings.stop else { return Ok(()) };
        let (inversed, settings) = (stop.inversed, settings.clone());
        let open = move || {
            let Lines { contact, reset, .. } = Found::lines(&settings)?;
            let contact = contact.ok_or_else(|| Error::name("", "estop.line", "", "expected a line"))?;
            Contact::open(&contact, reset.as_ref(), inversed)
        };
        self.open = Some(open()?);
        self.mender = Some(Mender::start("the emergency stop's lines", open)?);
        Ok(())
    }

    fn end(&mut self) {
        (self.open, self.mender, self.shown) = (None, None, StopInputs::OPEN);
    }

    /// What it shows now; where that cannot be read, as if it were open.
    #[inline]
    fn look(&mut self) {
        let Some(mender) = &self.mender else { return };
        if self.open.is_none() {
            self.open = mender.found();
        }
        self.shown = match self.open.as_ref().map(Contact::read) {
            Some(Ok((is_closed, is_reset_pressed))) => StopInputs { is_closed, is_reset_pressed },
            Some(Err(errno)) => {
                if is_gone(errno) {
                    mender.lost(&mut self.open);
                }
                StopInputs::OPEN
            }
            None => StopInputs::OPEN,
        };
    }

    /// Whether the supply may be on, as far as it is about the contact: it is not waited for the driver's latch.
    fn permits(&self) -> bool {
        self.mender.is_none() || self.shown.is_closed
    }
}

/// Whether a file is of a device that is no longer there, and stays dead even when it returns.
fn is_gone(errno: Errno) -> bool {
    matches!(errno, Errno::NODEV | Errno::NXIO | Errno::NOENT)
}

fn whole(errno: Errno) -> BackendError {
    let os_error = errno.raw_os_error();
    if is_gone(errno) { BackendError::Unavailable { os_error } } else { BackendError::Io { os_error } }
}

impl Running {
    /// Finds everything by its name, starts the guard, and opens it with the outputs at zero.
    fn open(settings: &Settings) -> Result<Running, Error> {
        let found = Found::of(settings)?;
        let period_ns = (1e9 / settings.rate_hz).round() as u64;
        let were_exported: Vec<bool> =
            found.outputs.iter().map(|(chip, number)| pwm::is_exported(chip, *number)).collect();
        let exported = found.outputs.iter().map(|(chip, number)| pwm::export(chip, *number));
        let folders: Vec<PathBuf> = exported.collect::<Result<_, Error>>()?;
        // Before anything is changed, the outputs have to be ours.
        let held: Vec<PathBuf> = folders.iter().map(|folder| folder.join("duty_cycle")).collect();
        let enable = found.enable.as_ref().zip(settings.enable.as_ref());
        let line = enable.map(|(place, enable)| line::Output::open(place, enable.inversed)).transpose()?;
        let silence = Duration::from_secs_f64(silence_s(settings));
        let guard = Guard::start(&settings.guard, silence, line.as_ref(), &held)?;
        // A guard of the driver before has put them to zero by now.
        let past = found.past(settings, &were_exported);
        let supply = line.zip(settings.enable.as_ref()).map(|(line, enable)| Supply::set_up(line, enable.pulses));
        let supply = supply.transpose()?;
        let set_up = folders.iter().zip(&settings.channels);
        let outputs = set_up.map(|(folder, channel)| Output::set_up(folder, period_ns, channel.inversed));
        let outputs: Vec<Output> = outputs.collect::<Result<_, Error>>()?;
        let witness = (past, found.marks());
        let Settings { sampling, trigger, phase, channels, .. } = settings;
        let sampler = Sampler::open(&found.devices, channels, *sampling, trigger.as_deref(), *phase)?;
        let (driven, failed) = (vec![false; outputs.len()], vec![None; outputs.len()]);
        Ok(Running { driven, failed, witness, outputs, sampler, supply, beat_in: 0, refresh: 0, guard })
    }

    /// The supply for this period, or none.
    #[inline]
    fn drive_supply(&mut self, on: bool) -> Result<(), Errno> {
        self.supply.as_mut().map_or(Ok(()), |supply| supply.drive(on))
    }

    /// All outputs to zero, as far as they can be written; the guard does it again.
    fn zero(&mut self, confirmed: &mut [bool]) {
        for ((output, driven), confirmed) in self.outputs.iter_mut().zip(&mut self.driven).zip(confirmed) {
            *confirmed = output.put(0.0).is_ok();
            *driven = false;
        }
    }

    /// Whatever the outputs and the supply have now, by the guard or without one: the supply is off, and zero is to be written.
    fn give_up(&mut self) {
        if let Some(supply) = &mut self.supply {
            supply.forget();
        }
        let _ = self.drive_supply(false);
        self.outputs.iter_mut().for_each(Output::forget);
    }

    fn fail(
        &mut self,
        samples: &mut [Sample],
        confirmed: &mut [bool],
        error: BackendError,
    ) -> Result<(), BackendError> {
        self.zero(confirmed);
        self.failed.fill(None);
        samples.fill(Sample::NONE);
        Err(error)
    }

    /// What the guard has to say, when it is time to ask.
    #[inline]
    fn watch(&mut self, every: u64) -> Watch {
        if let Some(left) = self.beat_in.checked_sub(1) {
            self.beat_in = left;
            return Watch::Good;
        }
        self.beat_in = every - 1;
        if let Some(output) = self.outputs.get_mut(self.refresh) {
            output.forget();
        }
        if let Some(supply) = &mut self.supply {
            supply.forget();
        }
        self.refresh = (self.refresh + 1) % self.outputs.len().max(1);
        self.guard.beat()
    }

    /// Samples and duties of all channels. An error is reported for the lowest channel, or for all where all failed.
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample], confirmed: &mut [bool]) -> Result<(), BackendError> {
        let mut failed: Option<(usize, ChannelFault, Errno)> = None;
        let mut failures = 0;
        // Reading first: what is converted on demand is then still of the period just past.
        self.sampler.fetch();
        for (channel, sample) in samples.iter_mut().enumerate() {
            let sampled = self.sampler.sample(channel, self.driven[channel]);
            *sample = sampled.unwrap_or(Sample::NONE);
            let asked = if sampled.is_ok() { duty[channel] } else { 0.0 };
            let put = self.outputs[channel].put(asked);
            self.driven[channel] = asked > 0.0 && put.is_ok();
            confirmed[channel] = put.is_ok();
            self.failed[channel] = None;
            let trouble = match (sampled, put) {
                (Ok(_), Ok(())) => continue,
                (Err(errno), _) => (channel, ChannelFault::Converter, errno),
                (Ok(_), Err(errno)) => {
                    // The write may have succeeded in part; the cached duty must not differ from the real one.
                    confirmed[channel] = self.outputs[channel].put(0.0).is_ok();
                    *sample = Sample::NONE;
                    (channel, ChannelFault::Stage, errno)
                }
            };
            failures += 1;
            self.failed[channel] = Some(trouble.1);
            failed = failed.or(Some(trouble));
        }
        let Some((channel, fault, errno)) = failed else { return Ok(()) };
        if failures < samples.len() {
            return Err(BackendError::Channel { channel: channel as u32, fault });
        }
        self.fail(samples, confirmed, whole(errno))
    }

    /// A period under the guard's eyes: samples, duties, and the supply once they are put out.
    fn period(
        &mut self,
        supplied: bool,
        duty: &[f64],
        samples: &mut [Sample],
        confirmed: &mut [bool],
    ) -> Result<(), BackendError> {
        let exchanged = self.exchange(duty, samples, confirmed);
        // Nothing is lost with the supply where the exchange has failed as a whole, and an output that may not be at zero is off by it.
        let is_alone = matches!(exchanged, Ok(()) | Err(BackendError::Channel { .. }));
        let supplied = supplied && (is_alone || confirmed.iter().all(|confirmed| *confirmed));
        match self.drive_supply(supplied) {
            Ok(()) => exchanged,
            Err(errno) => {
                let _ = self.drive_supply(false);
                self.fail(samples, confirmed, whole(errno))
            }
        }
    }
}

impl Backend for LinuxRig {
    fn channels(&self) -> usize {
        self.settings.channels.len()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.bring_up().map_err(|error| {
            // The loop does not run yet, and a number says little.
            tracing::error!("{error}; {}", error.remedy());
            BackendError::Unavailable { os_error: error.os_error() }
        })
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        let Some(mender) = &self.mender else { return Err(BackendError::NotStarted) };
        self.stop.look();
        if self.running.is_none() {
            self.running = mender.found();
            if self.running.is_some() {
                // What has just been set up is at zero.
                self.confirmed.fill(true);
            }
        }
        let confirmed = &mut self.confirmed[..];
        let Some(running) = &mut self.running else {
            samples.fill(Sample::NONE);
            return Err(BackendError::Unavailable { os_error: Errno::NODEV.raw_os_error() });
        };
        let supplied = !self.is_cut && self.stop.permits();
        if !supplied {
            // Before anything else, which may take its time; one that has failed is tried again below.
            let _ = running.drive_supply(false);
        }
        if let Err(error) = check_exchange(self.settings.channels.len(), duty, samples) {
            return running.fail(samples, confirmed, error);
        }
        // First of all, so that the guard watches before the first duty goes out.
        match running.watch(self.beat_every) {
            Watch::Good => {
                let exchanged = running.period(supplied, duty, samples, confirmed);
                if matches!(exchanged, Err(BackendError::Unavailable { .. })) {
                    // Files of an unplugged device stay dead even when it returns.
                    mender.lost(&mut self.running);
                }
                exchanged
            }
            Watch::Zeroed => {
                running.give_up();
                let waited_us = self.silence.as_micros().min(u128::from(u32::MAX)) as u32;
                running.fail(samples, confirmed, BackendError::Timeout { waited_us })
            }
            watch @ (Watch::Silent | Watch::Gone) => {
                // Queried again in the next period, and until it answers nothing is output.
                running.beat_in = 0;
                running.give_up();
                let gone = BackendError::Unavailable { os_error: Errno::PIPE.raw_os_error() };
                let failed = running.fail(samples, confirmed, gone);
                if watch == Watch::Gone {
                    // Everything is opened anew, under another guard.
                    mender.lost(&mut self.running);
                }
                failed
            }
        }
    }

    fn missed(&mut self, periods: u64) {
        if let Some(running) = &mut self.running {
            running.beat_in = running.beat_in.saturating_sub(periods);
        }
    }

    fn is_confirmed(&self, channel: usize) -> bool {
        self.confirmed.get(channel).is_none_or(|confirmed| *confirmed)
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.running.as_ref()?.failed.get(channel).copied().flatten()
    }

    fn silence_s(&self) -> Option<f64> {
        Some(self.silence.as_secs_f64())
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        self.names.get(channel).cloned()
    }

    fn past(&self, channel: usize) -> Past {
        self.past.get(channel).copied().unwrap_or(Past::UNKNOWN)
    }

    fn mark(&self, channel: usize) -> u64 {
        self.marks.get(channel).copied().unwrap_or(0)
    }

    fn cut(&mut self) -> bool {
        self.is_cut = self.settings.enable.is_some();
        if let Some(running) = &mut self.running {
            // One that has failed is off with the next exchange, or fails that.
            let _ = running.drive_supply(false);
        }
        self.is_cut
    }

    fn restore(&mut self) {
        self.is_cut = false;
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.settings.stop.is_some().then_some(self.stop.shown)
    }

    fn stop(&mut self) -> Zero {
        if let Some(mut running) = self.running.take() {
            let _ = running.drive_supply(false);
            running.zero(&mut self.confirmed);
            let Running { guard, outputs, supply, .. } = running;
            drop((outputs, supply));
            // The guard does it again, until it has worked.
            if guard.end() {
                self.confirmed.fill(true);
            }
        }
        self.mender = None;
        self.stop.end();
        Zero::confirmed_if(self.confirmed.iter().all(|confirmed| *confirmed))
    }
}

impl Drop for LinuxRig {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}
