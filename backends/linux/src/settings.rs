//! The backend's configuration: which output and which inputs belong to each channel.

use std::path::PathBuf;
use std::time::Duration;

use sinew_rig::{Backend, EnableSignal, LinuxInput, LinuxPhase, LinuxSampling, Polarity, Rig};

use crate::guard;

/// With free phase, a scan with this share of the supply or of the largest current is of the on-phase.
const ON: f64 = 0.25;

/// The whole backend. [`Settings::of_rig`] makes it from a rig file.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Where `sys` and `dev` are: `/`, but for tests.
    pub root: PathBuf,
    /// Rate of the loop and of the PWM, Hz.
    pub rate_hz: f64,
    /// How the converters are read.
    pub sampling: LinuxSampling,
    /// Name of the trigger that buffered devices are set to; `None` leaves each with the one it has (or needs none).
    pub trigger: Option<String>,
    /// What moment of a period a conversion is of.
    pub phase: LinuxPhase,
    /// How long the guard bears the driver's silence before it puts all outputs to zero, s.
    pub guard_s: f64,
    /// The program that is started as guard and what it is told first; its `main` calls [`guard::main`].
    pub guard: (PathBuf, Vec<String>),
    /// The line that switches the supply, where there is one.
    pub enable: Option<EnableSettings>,
    /// The inputs of an emergency stop, where one is fitted.
    pub stop: Option<StopSettings>,
    /// The channels, in the rig's order.
    pub channels: Vec<ChannelSettings>,
}

/// The line that switches the supply of all power stages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnableSettings {
    /// `chip/number`, or the path of a file below [`Settings::root`], see [`line`](crate::line).
    pub line: String,
    /// Whether it carries an edge a period while outputs may be powered, rather than a level.
    pub pulses: bool,
    /// Whether low lets outputs be powered.
    pub inversed: bool,
    /// So long after the last edge a watchdog relay has dropped out.
    pub dropout: Duration,
}

/// The inputs of an emergency stop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StopSettings {
    /// Its contact, as [`EnableSettings::line`].
    pub line: String,
    /// Its reset button; `None` where it has none here.
    pub reset_line: Option<String>,
    /// Whether low is a closed contact, and a pressed button.
    pub inversed: bool,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSettings {
    /// Its name in the rig file, for messages.
    pub name: String,
    /// Its output: `chip/number`, the chip by its number (`pwmchip0`) or its device's name (`1-0040`).
    pub pwm: String,
    /// Whether the power stage heats while the output is low.
    pub inversed: bool,
    /// Its inputs.
    pub inputs: Inputs<LinuxInput>,
    /// With [`LinuxPhase::Free`]: V3 from which on a scan is of the on-phase, V.
    pub on_voltage_v: f64,
    /// The same of the current, A: a shorted wire has no voltage.
    pub on_current_a: f64,
}

/// Something for each of the five inputs of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inputs<T> {
    /// First tap.
    pub v1: T,
    /// Second tap.
    pub v2: T,
    /// Moving end.
    pub v3: T,
    /// Current.
    pub current: T,
    /// Supply.
    pub supply: T,
}

impl<T> Inputs<T> {
    /// What `make` makes of each, with the input's key in the rig file.
    pub fn try_map<'a, U, E>(
        &'a self,
        mut make: impl FnMut(&'static str, &'a T) -> Result<U, E>,
    ) -> Result<Inputs<U>, E> {
        Ok(Inputs {
            v1: make("v1", &self.v1)?,
            v2: make("v2", &self.v2)?,
            v3: make("v3", &self.v3)?,
            current: make("current", &self.current)?,
            supply: make("supply", &self.supply)?,
        })
    }
}

impl Settings {
    /// What a rig file says, with the program that runs as its own guard.
    pub fn of_rig(rig: &Rig) -> Settings {
        let Backend { linux, enable, estop: stop, .. } = &rig.backend;
        let channels = rig.channels.iter().map(|channel| {
            let places = channel.backend.linux.clone();
            ChannelSettings {
                name: channel.name.clone(),
                pwm: places.pwm.unwrap_or_default(),
                inversed: places.polarity == Polarity::Inversed,
                inputs: Inputs {
                    v1: places.v1,
                    v2: places.v2,
                    v3: places.v3,
                    current: places.current,
                    supply: places.supply,
                },
                on_voltage_v: ON * channel.model.drive.supply_v,
                on_current_a: ON * channel.limits.max_current_a,
            }
        });
        Settings {
            root: PathBuf::from(&linux.root),
            rate_hz: rig.rate_hz,
            sampling: linux.sampling,
            trigger: linux.trigger.clone(),
            phase: linux.phase,
            guard_s: rig.silence_s(),
            guard: guard::this_program(),
            enable: (enable.signal != EnableSignal::None).then(|| EnableSettings {
                line: enable.line.clone().unwrap_or_default(),
                pulses: enable.signal == EnableSignal::Pulses,
                inversed: enable.polarity == Polarity::Inversed,
                dropout: Duration::try_from_secs_f64(enable.dropout_s).unwrap_or(Duration::MAX),
            }),
            stop: stop.fitted.then(|| StopSettings {
                line: stop.line.clone().unwrap_or_default(),
                reset_line: stop.reset_line.clone(),
                inversed: stop.polarity == Polarity::Inversed,
            }),
            channels: channels.collect(),
        }
    }
}
