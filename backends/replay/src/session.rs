//! Driver's sessions as recordings to replay, and what to write a replay as.

use std::path::{Path, PathBuf};

use sinew_ipc::{ChannelField, ChannelState, CycleHeader};
use sinew_recording::rows::DRIVER;
use sinew_recording::session::{CycleView, Layout, Session};

use crate::error::Error;
use crate::source::{Cycles, Source};

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
    type Cycles = SessionCycles;

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
    fn each(self, see: &mut dyn FnMut(&CycleHeader, &[ChannelState]) -> bool) -> Result<(), Error> {
        let layout = self.0.layout();
        let decoder = Decoder::new(layout);
        let mut states = vec![ChannelState::UNKNOWN; layout.channels.len()];
        let mut cycles = self.0.cycles();
        while let Some(cycle) = cycles.next().map_err(Error::Recording)? {
            for (channel, state) in states.iter_mut().enumerate() {
                *state = decoder.state(&cycle, channel);
            }
            let head = &cycle.head;
            if !see(&CycleHeader { cycle: head.cycle, monotonic_ns: head.monotonic_ns, missed: head.missed }, &states) {
                break;
            }
        }
        Ok(())
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
        ChannelState::from_parts(&floats, &codes)
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
