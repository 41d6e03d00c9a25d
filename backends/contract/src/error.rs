//! The errors a backend can report, and the numbers they are published as.

use std::fmt;

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
    /// The hardware is missing, or in use by another process.
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
