//! What the backend has to know of a rig: which output and which inputs belong to each channel.

use std::path::PathBuf;

/// The whole backend. [`Settings::of_rig`] makes it from a rig file.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Where `sys` and `dev` are: `/`, but for tests.
    pub root: PathBuf,
    /// Rate of the loop and of the PWM, Hz.
    pub rate_hz: f64,
    /// How the converters are read.
    pub sampling: Sampling,
    /// Name of the trigger that buffered devices are set to; `None` leaves each with the one it has (or needs none).
    pub trigger: Option<String>,
    /// What a scan is a sample of.
    pub phase: Phase,
    /// How long the guard bears the driver's silence before it puts all outputs to zero, s.
    pub guard_s: f64,
    /// The program that is started as guard, and its first argument: one whose `main` calls [`crate::guard::main`].
    pub guard: (PathBuf, Vec<String>),
    /// The channels, in the rig's order.
    pub channels: Vec<ChannelSettings>,
}

/// How the converters are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// From `/dev/iio:deviceN`: the converter runs by itself and the newest scan is taken.
    Buffer,
    /// From `in_…_raw` (or `_input`) in sysfs: each input is converted when it is read, within the cycle.
    Sysfs,
}

/// What a scan is a sample of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// The hardware sees to it that it is of an on-phase: a trigger from the PWM, or a sample-and-hold gated by it.
    Synchronised,
    /// It may be of any moment: the newest whose voltage or current shows the on-phase is taken.
    Free,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSettings {
    /// Its name in the rig file, for messages.
    pub name: String,
    /// Its output: `chip/number`, the chip by its number (`pwmchip0`) or its device's name (`1-0040`).
    pub pwm: String,
    /// Whether the power stage heats while the output is low.
    pub inverted: bool,
    /// Its inputs; the voltages of the taps, the moving end and the supply may be missing, the current may not.
    pub inputs: Inputs<Option<InputSettings>>,
    /// With [`Phase::Free`]: V3 from which on a scan is of the on-phase, V.
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
    pub fn try_map<U, E>(self, mut make: impl FnMut(&'static str, T) -> Result<U, E>) -> Result<Inputs<U>, E> {
        Ok(Inputs {
            v1: make("v1", self.v1)?,
            v2: make("v2", self.v2)?,
            v3: make("v3", self.v3)?,
            current: make("current", self.current)?,
            supply: make("supply", self.supply)?,
        })
    }

    /// All five, in this order.
    pub fn as_array(&self) -> [&T; 5] {
        [&self.v1, &self.v2, &self.v3, &self.current, &self.supply]
    }
}

/// One input: value = `gain` · what the kernel's scaled value is in V (or A) + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct InputSettings {
    /// `device:input`, the device by its number (`iio:device0`), name (`ina219`), label or its parent's name (`1-0041`), the
    /// input as IIO calls it (`in_voltage0`).
    pub name: String,
    /// Of the divider or shunt before the input: V/V, or A/V for a voltage across a shunt.
    pub gain: f64,
    /// Added after it, V or A.
    pub offset: f64,
}
