//! Reads a driver's session for replay, and writes a replay as a session.

use std::path::{Path, PathBuf};

use sinew_backend::{BackendError, Sample};
use sinew_ipc::{ChannelField, ChannelState, CycleHeader, Fault, HeldCycle, Mode};
use sinew_recording::rows::DRIVER;
use sinew_recording::session::{CycleView, Layout, Session};
use sinew_replay_backend::{Cycle, Cycles, Source};

use crate::error::Error;

/// A driver's session in a file.
#[derive(Debug, Clone)]
pub struct SessionSource {
    path: PathBuf,
    channels: usize,
}

impl SessionSource {
    /// Checks that a session can be replayed.
    ///
    /// # Errors
    /// [`Error::Lacks`] where it is no driver's or of another version.
    pub fn new(path: &Path, session: &Session) -> Result<SessionSource, Error> {
        let lacks = |what: String| Err(Error::Lacks { file: session.name().into(), what });
        let kind = &session.about().kind;
        if kind != DRIVER {
            return lacks(format!("is a recording of kind {kind:?}, only a driver's can be replayed"));
        }
        // the samples first: an older version's session lacks those
        let (needed, requests): (Vec<&ChannelField>, Vec<_>) =
            ChannelState::FIELDS.iter().filter(|f| f.is_replay_input()).partition(|f| !f.is_replay_output());
        let missing = needed.iter().chain(&requests).find(|field| session.layout().field(field.name).is_none());
        if let Some(ChannelField { name, .. }) = missing {
            return lacks(format!("has no field {name:?}, which a replay starts from"));
        }
        Ok(SessionSource { path: path.to_path_buf(), channels: session.layout().channels.len() })
    }
}

impl Source for SessionSource {
    type Cycle = SessionCycle;
    type Cycles = SessionCycles;
    type Error = Error;

    fn channels(&self) -> usize {
        self.channels
    }

    fn cycles(&self) -> Result<SessionCycles, Error> {
        Session::open(&self.path).map(SessionCycles).map_err(Error::Recording)
    }
}

/// The cycles of an open session.
#[derive(Debug)]
pub struct SessionCycles(Session);

impl Cycles for SessionCycles {
    type Cycle = SessionCycle;
    type Error = Error;

    fn each(self, see: &mut dyn FnMut(&SessionCycle) -> bool) -> Result<(), Error> {
        let layout = self.0.layout();
        let decoder = Decoder::new(layout);
        let mut held = SessionCycle::new(layout.channels.len());
        let mut cycles = self.0.cycles();
        while let Some(cycle) = cycles.next().map_err(Error::Recording)? {
            for (channel, state) in held.0.channels.iter_mut().enumerate() {
                *state = decoder.state(&cycle, channel);
            }
            let head = &cycle.head;
            held.0.header = CycleHeader { cycle: head.cycle, monotonic_ns: head.monotonic_ns, missed: head.missed };
            if !see(&held) {
                break;
            }
        }
        Ok(())
    }
}

/// A cycle as the driver published it.
#[derive(Debug, Clone)]
pub struct SessionCycle(pub HeldCycle);

impl Cycle for SessionCycle {
    fn new(channels: usize) -> SessionCycle {
        SessionCycle(HeldCycle::new(channels))
    }

    fn copy_from(&mut self, other: &SessionCycle) {
        self.0.copy_from(other.0.header, &other.0.channels);
    }

    fn number(&self) -> u64 {
        self.0.header.cycle
    }

    fn period(&self) -> u64 {
        self.0.header.cycle + self.0.header.missed
    }

    fn sample(&self, channel: usize) -> Sample {
        let ChannelState { v1_v, v2_v, v3_v, current_a, supply_v, .. } = self.0.channels[channel];
        Sample { v1_v, v2_v, v3_v, current_a, supply_v }
    }

    fn duty(&self, channel: usize) -> f64 {
        self.0.channels[channel].duty
    }

    fn error(&self, channel: usize) -> Option<BackendError> {
        BackendError::from_code(self.0.channels[channel].backend, channel as u32)
    }
}

/// Finds the fields of a channel's state in a session's cycles, wherever its layout has them.
#[derive(Debug, Clone)]
struct Decoder {
    floats: [Option<usize>; ChannelState::FLOATS],
    codes: [Option<usize>; ChannelState::CODES],
}

impl Decoder {
    fn new(layout: &Layout) -> Decoder {
        Decoder {
            floats: std::array::from_fn(|i| layout.field(ChannelState::FIELDS[i].name)),
            codes: std::array::from_fn(|i| layout.field(ChannelState::FIELDS[ChannelState::FLOATS + i].name)),
        }
    }

    #[inline]
    fn state(&self, cycle: &CycleView<'_>, channel: usize) -> ChannelState {
        let (mut floats, mut codes) = ChannelState::UNKNOWN.parts();
        for (value, field) in floats.iter_mut().zip(self.floats) {
            if let Some(field) = field {
                *value = cycle.get(channel, field);
            }
        }
        for (code, field) in codes.iter_mut().zip(self.codes) {
            if let Some(field) = field {
                *code = cycle.get(channel, field) as u32;
            }
        }
        let state = ChannelState::from_parts(&floats, &codes);
        // Up to protocol 5 a lease that ran out was published as a fault that nobody has to reset.
        match (state.mode(), state.fault()) {
            (Mode::Off, Some(Fault::StaleSetpoint)) => ChannelState { mode: Mode::Lapsed.code(), fault: 0, ..state },
            _ => state,
        }
    }
}

/// The bytes of channels' states as a driver's session has them.
pub fn encode(states: &[ChannelState], bytes: &mut Vec<u8>) {
    bytes.clear();
    for state in states {
        let (floats, codes) = state.parts();
        floats.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        codes.iter().for_each(|code| bytes.extend(code.to_le_bytes()));
    }
}
