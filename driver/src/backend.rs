//! The contract between the loop and whatever powers and measures the wires.
//!
//! A backend is the only thing that knows how volts come about: a power stage with converters, or a simulated rig. The
//! loop knows it by a few calls of [`Backend`], in one fixed order:
//!
//! ```text
//! start() -> ( is_due()* -> missed(n)? -> exchange(duty, samples) )* -> stop()
//! ```
//!
//! **Timing.** [`Backend::exchange`] is called once a period, from the real-time thread. It hands over the duty of the
//! period that begins now and brings back what was sampled in the on-phase of the period just past. It must return well
//! within the period (aim at a tenth of it), in a time that does not grow with run length, and must neither allocate,
//! lock, log nor unwind. The only system calls allowed in it are the ones its hardware needs.
//!
//! **Ranges.** Duty is finite and in 0 ..= 1, one for each channel in the rig's order; the driver guarantees it and a
//! backend checks it anyway. Samples are SI; a value not sampled is NaN, never a stale or invented number. With duty 0
//! there is no on-phase, so voltages and current are NaN (or what the converter really saw). Where one input is shared
//! (`circuit = "shared"` in the rig file), V3 is NaN, the supply is what that input saw in the off-phase of the same
//! period (NaN where duty 1 leaves none), the current is what it saw in the on-phase, over shunt and switch.
//!
//! **Dark.** With duty 0 a backend that can samples all the same, with the gate closed: a current there is the one sign by which
//! a power stage that conducts on its own can be told ([`crate::stage`]). A backend that cannot look leaves NaN, and reports such a
//! stage as [`ChannelFault::Stage`] if its hardware can tell.
//!
//! **Zero.** Outputs are zero after [`Backend::start`], after [`Backend::stop`], after a failed `exchange` and after drop.

use std::fmt;

pub use sinew_sensing::Sample;

/// What powers and measures the wires, seen from the loop. The module's text is the contract, and
/// `sinew_driver::conformance` the suite every implementation has to pass.
pub trait Backend: Send {
    /// How many channels there are: constant for the life of the backend, and the length of both slices of `exchange`.
    fn channels(&self) -> usize;

    /// Brings the backend up with all outputs at zero. May allocate, block and take long: the loop does not run yet.
    ///
    /// # Errors
    /// Anything that keeps even one channel from being driven and measured.
    fn start(&mut self) -> Result<(), BackendError>;

    /// One period: `duty` (0 ..= 1, of the supply) for the period that begins now, `samples` from the on-phase just past.
    ///
    /// # Errors
    /// A whole-backend error means that no sample is valid; the backend has put all outputs to zero and the driver switches
    /// every channel off. [`BackendError::Channel`] concerns that channel alone: its sample is all NaN and its output zero,
    /// the others are valid. Where several channels fail at once the lowest is named; the NaN samples tell of the rest.
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError>;

    /// Whether the duty of the last exchange has had the time it takes to be sampled. Where that exchange came late, the next
    /// point of the grid may follow too soon for it: the sample is not missing then, and no fault of the sensor's. The loop lets
    /// such a period pass as one it missed, but never two in a row. Called before `exchange`, under the same rules; a backend that is
    /// sampled by the exchange itself is always due, which is the default.
    fn is_due(&mut self) -> bool {
        true
    }

    /// `periods` (at least 1) went by since the last `exchange` without one, because the loop was late. A power stage has
    /// held the last duty meanwhile and needs to do nothing, which is the default; a simulated one advances its wires.
    /// Called right before `exchange`, under the same rules.
    fn missed(&mut self, periods: u64) {
        let _ = periods;
    }

    /// Takes the supply from all power stages together, by whatever is there for it beside their own gates (a master switch,
    /// an enable line), until the next [`Backend::start`]: the answer to a stage that conducts although it is given no duty.
    /// Called under the rules of `exchange`, which goes on being called and may go on sampling; idempotent. Returns whether there
    /// is such a thing; where there is not, which is the default, only a hand at the plug is left.
    fn cut(&mut self) -> bool {
        false
    }

    /// All outputs to zero, now. Idempotent, callable in any state (also before `start`), never fails, never unwinds: it is
    /// what the driver calls on its way out, whatever the reason.
    fn stop(&mut self);

    /// What is really the case with a wire: simulated backends only, for tests and reports. `None` where nobody can know.
    fn truth(&self, channel: usize) -> Option<Truth> {
        let _ = channel;
        None
    }
}

impl<B: Backend + ?Sized> Backend for Box<B> {
    fn channels(&self) -> usize {
        (**self).channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        (**self).start()
    }

    #[inline]
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        (**self).exchange(duty, samples)
    }

    fn is_due(&mut self) -> bool {
        (**self).is_due()
    }

    fn missed(&mut self, periods: u64) {
        (**self).missed(periods);
    }

    fn cut(&mut self) -> bool {
        (**self).cut()
    }

    fn stop(&mut self) {
        (**self).stop();
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        (**self).truth(channel)
    }
}

/// What a simulated wire is really doing, without converter, noise or estimator in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Length of the wire, m.
    pub length_m: f64,
    /// Rate of change of the length, m/s, positive when it gets longer.
    pub velocity_m_s: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Martensite fraction, 0 ..= 1.
    pub martensite: f64,
    /// Tension, N.
    pub force_n: f64,
    /// Resistance of the wire alone, Ω.
    pub resistance_ohm: f64,
    /// Mean electrical power of the period just past, W.
    pub power_w: f64,
    /// The duty that was in force in the period just past, 0 ..= 1.
    pub duty: f64,
}

/// What a backend can report. `Copy`, because it travels through the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BackendError {
    /// `exchange` before `start`, or after `stop`.
    NotStarted,
    /// A slice has the wrong length.
    WrongCount {
        /// Channels of the backend.
        expected: u32,
        /// Length of the slice.
        found: u32,
    },
    /// A duty is NaN or outside 0 ..= 1; nothing was put out.
    BadDuty {
        /// The channel it was meant for.
        channel: u32,
    },
    /// The hardware is not there, or belongs to somebody else.
    Unavailable {
        /// The operating system's error number, 0 when there is none.
        os_error: i32,
    },
    /// The hardware did not answer in time.
    Timeout {
        /// How long it was waited for, µs.
        waited_us: u32,
    },
    /// Reading or writing failed.
    Io {
        /// The operating system's error number.
        os_error: i32,
    },
    /// One channel alone has failed; the others are good.
    Channel {
        /// Which, counted from 0 in the rig's order.
        channel: u32,
        /// What it reports.
        fault: ChannelFault,
    },
}

/// What a backend can report of a single channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelFault {
    /// The power stage has switched itself off: over-current.
    OverCurrent,
    /// The power stage has switched itself off: it is too hot itself.
    OverTemperature,
    /// The converter does not answer.
    Converter,
    /// The power stage does not follow its duty.
    Stage,
}

/// What every backend asks of the slices of an exchange before it does anything: as many values as it has channels, and
/// duties in 0 ..= 1.
///
/// # Errors
/// [`BackendError::WrongCount`] or [`BackendError::BadDuty`], by which the exchange has failed.
#[inline]
pub fn check_exchange(channels: usize, duty: &[f64], samples: &[Sample]) -> Result<(), BackendError> {
    for found in [duty.len(), samples.len()] {
        if found != channels {
            return Err(BackendError::WrongCount { expected: channels as u32, found: found as u32 });
        }
    }
    match duty.iter().position(|duty| !(0.0..=1.0).contains(duty)) {
        Some(channel) => Err(BackendError::BadDuty { channel: channel as u32 }),
        None => Ok(()),
    }
}

impl BackendError {
    /// From here on the codes are those of a single channel's faults.
    const CHANNEL: u32 = 16;

    /// The number that stands for it in `ChannelState::backend`: what failed, without the details.
    pub fn code(&self) -> u32 {
        match self {
            BackendError::NotStarted => 1,
            BackendError::WrongCount { .. } => 2,
            BackendError::BadDuty { .. } => 3,
            BackendError::Unavailable { .. } => 4,
            BackendError::Timeout { .. } => 5,
            BackendError::Io { .. } => 6,
            BackendError::Channel { fault, .. } => {
                BackendError::CHANNEL
                    + match fault {
                        ChannelFault::OverCurrent => 0,
                        ChannelFault::OverTemperature => 1,
                        ChannelFault::Converter => 2,
                        ChannelFault::Stage => 3,
                    }
            }
        }
    }

    /// The error with this number, reported of `channel`; its details are 0. `None` for 0 and unknown numbers.
    pub fn from_code(code: u32, channel: u32) -> Option<BackendError> {
        let fault = match code {
            1 => return Some(BackendError::NotStarted),
            2 => return Some(BackendError::WrongCount { expected: 0, found: 0 }),
            3 => return Some(BackendError::BadDuty { channel }),
            4 => return Some(BackendError::Unavailable { os_error: 0 }),
            5 => return Some(BackendError::Timeout { waited_us: 0 }),
            6 => return Some(BackendError::Io { os_error: 0 }),
            16 => ChannelFault::OverCurrent,
            17 => ChannelFault::OverTemperature,
            18 => ChannelFault::Converter,
            19 => ChannelFault::Stage,
            _ => return None,
        };
        Some(BackendError::Channel { channel, fault })
    }

    /// The one channel this concerns, or `None` when it is the whole backend.
    pub fn channel(&self) -> Option<usize> {
        match self {
            BackendError::Channel { channel, .. } | BackendError::BadDuty { channel } => Some(*channel as usize),
            _ => None,
        }
    }
}

impl fmt::Display for ChannelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ChannelFault::OverCurrent => "the power stage switched off for over-current",
            ChannelFault::OverTemperature => "the power stage switched off because it is too hot",
            ChannelFault::Converter => "the converter does not answer",
            ChannelFault::Stage => "the power stage does not follow its duty",
        })
    }
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BackendError::NotStarted => f.write_str("the backend is not started"),
            BackendError::WrongCount { expected, found } => {
                write!(f, "the backend has {expected} channels, but was given {found} values")
            }
            BackendError::BadDuty { channel } => write!(f, "duty of channel {channel} is not in 0 to 1"),
            BackendError::Unavailable { os_error } => write!(f, "the backend is not available (os error {os_error})"),
            BackendError::Timeout { waited_us } => write!(f, "the backend did not answer within {waited_us} µs"),
            BackendError::Io { os_error } => write!(f, "the backend failed to read or write (os error {os_error})"),
            BackendError::Channel { channel, fault } => write!(f, "channel {channel}: {fault}"),
        }
    }
}

impl std::error::Error for BackendError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_survive_the_way_there_and_back() {
        let known: Vec<BackendError> = (0..64).filter_map(|code| BackendError::from_code(code, 3)).collect();
        assert_eq!(known.len(), 10);
        for error in known {
            assert_eq!(BackendError::from_code(error.code(), 3), Some(error));
        }
    }
}
