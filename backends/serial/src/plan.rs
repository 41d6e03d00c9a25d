//! A rig's requirements of a front-end, and the conversion of the front-end's codes.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};

use sinew_front_end::{
    ChannelLimits, Configure, EnableMode, FULL_DUTY, Identification, MAX_CHANNELS, NOT_SAMPLED, RawSample, ResetCause,
};
use sinew_rig::{Correction, Corrections, EnableSignal, Rig, SamplingCircuit};
use sinew_sensing::Sample;

use crate::error::Error;

/// The device's own limits lie so much outside of the supervisor's: they are there for when that one is not.
const SECOND_LINE: f64 = 1.2;
/// Its limit of the current must stay below what its converter can show, 1.1 times the rig's.
const SECOND_LINE_CURRENT: f64 = 1.05;
/// Ranges that differ by more are not the same converter's.
const SAME: f64 = 0.01;

/// Everything a connection needs to know, made once from the rig file.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// By which the front-end names this driver, see [`Identification::user`]: a random number, not 0.
    pub session: u32,
    pub port: String,
    pub baud_hz: u32,
    pub period_ns: u32,
    pub watchdog_periods: u16,
    pub enable: EnableMode,
    pub uses_stop: bool,
    /// How many of the front-end's channels are used, from its first.
    pub used: u8,
    pub channels: Vec<ChannelPlan>,
}

/// One channel of the rig.
#[derive(Debug, Clone)]
pub(crate) struct ChannelPlan {
    pub name: String,
    /// Which of the front-end's it is.
    pub place: usize,
    pub limits: ChannelLimits,
    /// Full scales as the rig file has them, V and A; a shared input has no range of the current of its own.
    voltage_range_v: f64,
    current_range_a: Option<f64>,
    /// By how much its inputs err.
    inputs: Corrections,
}

impl Plan {
    pub fn of(rig: &Rig) -> Result<Plan, Error> {
        let line = &rig.backend.serial;
        let channels: Vec<ChannelPlan> = (0..rig.channels.len()).map(|index| ChannelPlan::of(rig, index)).collect();
        let used = channels.iter().map(|channel| channel.place + 1).max().unwrap_or(0);
        Ok(Plan {
            session: (RandomState::new().build_hasher().finish() as u32).max(1),
            port: line.port.clone().ok_or(Error::NoPort)?,
            baud_hz: line.baud_hz,
            period_ns: (1e9 / rig.rate_hz).round() as u32,
            watchdog_periods: u16::try_from(line.watchdog_periods).unwrap_or(u16::MAX),
            enable: match rig.backend.enable.signal {
                EnableSignal::None => EnableMode::None,
                EnableSignal::Level => EnableMode::Level,
                EnableSignal::Pulses => EnableMode::Pulses,
            },
            uses_stop: rig.backend.estop.fitted,
            used: used.min(MAX_CHANNELS) as u8,
            channels,
        })
    }

    /// The configuration that holds the front-end to it. Channels the rig does not name may have nothing.
    pub fn configure(&self) -> Configure {
        let mut limits = [ChannelLimits::default(); MAX_CHANNELS];
        for channel in &self.channels {
            limits[channel.place] = channel.limits;
        }
        let Plan { session, period_ns, watchdog_periods, enable, uses_stop, used, .. } = *self;
        Configure { session, period_ns, watchdog_periods, enable, uses_stop, channels: used, limits }
    }

    /// How long a duty frame is valid, µs: until the watchdog's time is over.
    pub fn valid_us(&self) -> u32 {
        let silence_ns = u64::from(self.period_ns) * u64::from(self.watchdog_periods);
        u32::try_from(silence_ns.div_ceil(1000)).unwrap_or(u32::MAX).max(1)
    }

    /// Whether this front-end can drive and measure the rig; how its codes are read then.
    pub fn check(&self, who: &Identification) -> Result<Vec<Scale>, Error> {
        let unfit = |reason: String| Error::Unfit { port: self.port.clone(), front_end: name(who), reason };
        if who.channels < self.used {
            return Err(unfit(format!("has {} channels, the rig needs {}", who.channels, self.used)));
        }
        if !(who.min_period_ns..=who.max_period_ns).contains(&self.period_ns) {
            let hz = |period_ns: u32| 1e9 / f64::from(period_ns.max(1));
            return Err(unfit(format!(
                "keeps {:.1} to {:.1} Hz, rig.rate_hz is {:.1}",
                hz(who.max_period_ns),
                hz(who.min_period_ns),
                hz(self.period_ns)
            )));
        }
        let silence_ns = u64::from(self.period_ns) * u64::from(self.watchdog_periods);
        if silence_ns > who.max_silence_ns.into() {
            return Err(unfit(format!(
                "goes off after {} ms of silence at the latest, backend.serial.watchdog_periods = {} asks for {} ms",
                f64::from(who.max_silence_ns) * 1e-6,
                self.watchdog_periods,
                silence_ns as f64 * 1e-6
            )));
        }
        if self.enable != EnableMode::None && !who.features.enable {
            return Err(unfit("has no enable pin, backend.enable.signal asks for one".into()));
        }
        if self.uses_stop && !who.features.stop {
            return Err(unfit("has no pins for an emergency stop, backend.estop.fitted asks for them".into()));
        }
        if who.full_code == 0 || who.full_code == NOT_SAMPLED {
            return Err(unfit(format!("its converters have {} as their largest code", who.full_code)));
        }
        self.channels.iter().map(|channel| channel.check(who)).collect()
    }
}

impl ChannelPlan {
    fn of(rig: &Rig, index: usize) -> ChannelPlan {
        let channel = &rig.channels[index];
        let (limits, drive, adc) = (&channel.limits, &channel.model.drive, &channel.adc);
        // I²t from heat: the least resistance lets the most current through for it.
        let ohm = channel.model.geometry.resistance_ohm(channel.model.material.least_resistivity());
        let whole = |value: f64| value.ceil().clamp(0.0, u32::MAX.into()) as u32;
        let low_ohm = drive.low_ohm();
        let inputs = channel.backend.serial.inputs;
        // The front-end compares what it reads, and knows of no correction.
        let reads_a = |current_a: f64| ((current_a - inputs.current.offset) / inputs.current.gain).max(0.0);
        ChannelPlan {
            name: channel.name.clone(),
            place: rig.front_end_index(index).unwrap_or(0) as usize,
            limits: ChannelLimits {
                max_duty: duty_code(limits.max_duty),
                max_current_ma: whole(reads_a(SECOND_LINE_CURRENT * limits.max_current_a) * 1e3).min(u16::MAX.into())
                    as u16,
                heat_ma2_s: whole(SECOND_LINE * limits.energy_budget_j / ohm * 1e6),
                drain_ma2: whole(SECOND_LINE * limits.energy_drain_w / ohm * 1e6),
            },
            voltage_range_v: adc.voltage_range_v,
            current_range_a: match adc.circuit {
                SamplingCircuit::SeparateTaps => Some(adc.current_range_a),
                SamplingCircuit::Shared if low_ohm > 0.0 => Some(adc.voltage_range_v / low_ohm),
                SamplingCircuit::Shared => None,
            },
            inputs,
        }
    }

    fn check(&self, who: &Identification) -> Result<Scale, Error> {
        let range = &who.channel[self.place];
        let full = f64::from(who.full_code);
        let scale = Scale {
            voltage_v: f64::from(range.voltage_uv) * 1e-6 / full,
            current_a: f64::from(range.current_ua) * 1e-6 / full,
            supply_v: f64::from(range.supply_uv) * 1e-6 / full,
            inputs: self.inputs,
        };
        let same = |key: &'static str, file: f64, device: f64| {
            if (device - file).abs() <= SAME * file {
                return Ok(());
            }
            let reason = format!("is {file:.4}, the front-end's converter has {device:.4}");
            Err(Error::Contradiction { channel: self.name.clone(), key, reason })
        };
        same("adc.voltage_range_v", self.voltage_range_v, scale.voltage_v * full)?;
        if let Some(current_range_a) = self.current_range_a {
            same("adc.current_range_a", current_range_a, scale.current_a * full)?;
        }
        Ok(scale)
    }
}

/// What one code is worth, and what the value is short of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    voltage_v: f64,
    current_a: f64,
    supply_v: f64,
    inputs: Corrections,
}

impl Scale {
    #[inline]
    pub fn sample(&self, raw: &RawSample) -> Sample {
        let value = |code: u16, unit: f64, short: &Correction| match code {
            NOT_SAMPLED => f64::NAN,
            code => short.apply(f64::from(code) * unit),
        };
        let Corrections { v1, v2, v3, current, supply } = &self.inputs;
        Sample {
            v1_v: value(raw.v1, self.voltage_v, v1),
            v2_v: value(raw.v2, self.voltage_v, v2),
            v3_v: value(raw.v3, self.voltage_v, v3),
            current_a: value(raw.current, self.current_a, current),
            supply_v: value(raw.supply, self.supply_v, supply),
        }
    }
}

/// A duty on the line.
#[inline]
pub(crate) fn duty_code(duty: f64) -> u16 {
    (duty * f64::from(FULL_DUTY)).round() as u16
}

/// What a front-end calls itself.
pub(crate) fn name(who: &Identification) -> String {
    let end = who.name.iter().position(|byte| *byte == 0).unwrap_or(who.name.len());
    let [major, minor, patch] = who.version;
    let name = String::from_utf8_lossy(&who.name[..end]).replace(char::is_control, "?");
    format!("{name} {major}.{minor}.{patch} ({:016x})", who.serial)
}

/// Why it last started, in words that follow its name.
pub(crate) fn started(who: &Identification) -> &'static str {
    match who.reset {
        ResetCause::Unknown => "started for a reason it does not know",
        ResetCause::PowerOn => "started after power-on",
        ResetCause::BrownOut => "started after a brown-out",
        ResetCause::Watchdog => "started after its own watchdog had struck",
        ResetCause::Software => "started after a reset by software",
    }
}
