//! The backend itself: outputs, converters and guard behind the calls of the contract.
//!
//! A separate thread, the [`Mender`], looks for unplugged devices; the loop continues without them, and takes over the new
//! set of open files when there is one.

use std::path::PathBuf;
use std::time::Duration;

use rustix::io::Errno;
use sinew_backend::{Backend, BackendError, ChannelFault, Sample, Zero, check_exchange};
use sinew_rig::LEAST_SILENCE_PERIODS;

use crate::Error;
use crate::guard::{self, Guard, Watch};
use crate::iio::{self, Device};
use crate::mender::Mender;
use crate::pwm::{self, Chip, Output};
use crate::sampler::Sampler;
use crate::settings::Settings;

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
    /// While it is started.
    mender: Option<Mender<Running>>,
}

/// What the names of the settings stand for.
#[derive(Debug)]
struct Found {
    outputs: Vec<(Chip, u32)>,
    devices: Vec<Device>,
}

/// What is open between start and stop.
#[derive(Debug)]
struct Running {
    outputs: Vec<Output>,
    /// Whether each channel was given a duty in the period just past.
    driven: Vec<bool>,
    sampler: Sampler,
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
            names,
            mender: None,
            settings,
        })
    }

    /// Brings everything up, as [`Backend::start`] does, with the reason in words where that fails.
    ///
    /// # Errors
    /// What a file of the kernel, or the guard, has to say.
    pub fn bring_up(&mut self) -> Result<(), Error> {
        let _ = self.stop();
        self.running = Some(Running::open(&self.settings)?);
        self.confirmed.fill(true);
        let settings = self.settings.clone();
        self.mender = Some(Mender::start(move || Running::open(&settings))?);
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
                return Err(Error::name("", "trigger", trigger, format!("there is no such trigger; there is {there}")));
            }
        }
        Ok(Found { outputs, devices })
    }
}

impl Running {
    /// Finds everything by its name, starts the guard, and opens it with the outputs at zero.
    fn open(settings: &Settings) -> Result<Running, Error> {
        let found = Found::of(settings)?;
        let period_ns = (1e9 / settings.rate_hz).round() as u64;
        let exported = found.outputs.iter().map(|(chip, number)| pwm::export(chip, *number));
        let folders: Vec<PathBuf> = exported.collect::<Result<_, Error>>()?;
        // Before anything is changed, the outputs have to be ours.
        let held: Vec<PathBuf> = folders.iter().map(|folder| folder.join("duty_cycle")).collect();
        let guard = Guard::start(&settings.guard, Duration::from_secs_f64(silence_s(settings)), &held)?;
        let set_up = folders.iter().zip(&settings.channels);
        let outputs = set_up.map(|(folder, channel)| Output::set_up(folder, period_ns, channel.inversed));
        let outputs: Vec<Output> = outputs.collect::<Result<_, Error>>()?;
        let Settings { sampling, trigger, phase, channels, .. } = settings;
        let sampler = Sampler::open(&found.devices, channels, *sampling, trigger.as_deref(), *phase)?;
        Ok(Running { driven: vec![false; outputs.len()], outputs, sampler, beat_in: 0, refresh: 0, guard })
    }

    /// All outputs to zero, as far as they can be written; the guard does it again.
    fn zero(&mut self, confirmed: &mut [bool]) {
        for ((output, driven), confirmed) in self.outputs.iter_mut().zip(&mut self.driven).zip(confirmed) {
            *confirmed = output.put(0.0).is_ok();
            *driven = false;
        }
    }

    fn fail(
        &mut self,
        samples: &mut [Sample],
        confirmed: &mut [bool],
        error: BackendError,
    ) -> Result<(), BackendError> {
        self.zero(confirmed);
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
            failed = failed.or(Some(trouble));
        }
        let Some((channel, fault, errno)) = failed else { return Ok(()) };
        if failures < samples.len() {
            return Err(BackendError::Channel { channel: channel as u32, fault });
        }
        let os_error = errno.raw_os_error();
        let gone = matches!(errno, Errno::NODEV | Errno::NXIO | Errno::NOENT);
        self.fail(
            samples,
            confirmed,
            if gone { BackendError::Unavailable { os_error } } else { BackendError::Io { os_error } },
        )
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
        if let Err(error) = check_exchange(self.settings.channels.len(), duty, samples) {
            return running.fail(samples, confirmed, error);
        }
        // First of all, so that the guard watches before the first duty goes out.
        match running.watch(self.beat_every) {
            Watch::Good => {
                let exchanged = running.exchange(duty, samples, confirmed);
                if matches!(exchanged, Err(BackendError::Unavailable { .. })) {
                    // Files of an unplugged device stay dead even when it returns.
                    mender.lost(&mut self.running);
                }
                exchanged
            }
            Watch::Zeroed => {
                running.outputs.iter_mut().for_each(Output::forget);
                let waited_us = self.silence.as_micros().min(u128::from(u32::MAX)) as u32;
                running.fail(samples, confirmed, BackendError::Timeout { waited_us })
            }
            watch @ (Watch::Silent | Watch::Gone) => {
                // Queried again in the next period, and until it answers nothing is output.
                running.beat_in = 0;
                running.outputs.iter_mut().for_each(Output::forget);
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

    fn silence_s(&self) -> Option<f64> {
        Some(self.silence.as_secs_f64())
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        self.names.get(channel).cloned()
    }

    fn stop(&mut self) -> Zero {
        if let Some(mut running) = self.running.take() {
            running.zero(&mut self.confirmed);
            let Running { guard, outputs, .. } = running;
            drop(outputs);
            // The guard does it again, until it has worked.
            if guard.end() {
                self.confirmed.fill(true);
            }
        }
        self.mender = None;
        Zero::confirmed_if(self.confirmed.iter().all(|confirmed| *confirmed))
    }
}

impl Drop for LinuxRig {
    fn drop(&mut self) {
        let _ = self.stop();
    }
}
