//! Fault events of a recording: one for each channel whose fault has changed.

use std::mem::offset_of;

use sinew_ipc::{ChannelState, Fault};
use sinew_recording::session::{Event, FAULT, Head};

/// Finds faults that come and go, cycle by cycle.
#[derive(Debug)]
pub struct FaultEvents {
    /// The fault of each channel as of the last cycle, 0 = none.
    known: Vec<u32>,
}

impl FaultEvents {
    /// Of so many channels, none of them with a fault: one that is there in the first cycle is an event of that cycle.
    pub fn new(channels: usize) -> FaultEvents {
        FaultEvents { known: vec![0; channels] }
    }

    /// The events of a cycle of these channels, `bytes` being their states one after the other.
    pub fn of<'a>(
        &'a mut self,
        head: &'a Head,
        bytes: &'a [u8],
        channels: &'a [String],
    ) -> impl Iterator<Item = Event> + 'a {
        const OFFSET: usize = offset_of!(ChannelState, fault);
        let states = bytes.chunks_exact(size_of::<ChannelState>());
        self.known.iter_mut().zip(states).zip(channels).filter_map(|((known, state), channel)| {
            let found = state[OFFSET..].first_chunk().map(|bytes| u32::from_le_bytes(*bytes))?;
            if std::mem::replace(known, found) == found {
                return None;
            }
            let text = match (found, Fault::from_code(found)) {
                (0, _) => "cleared".to_string(),
                (_, Some(fault)) => format!("{}: {}", fault.flag(), fault.cause()),
                (code, None) => format!("fault {code}"),
            };
            Some(Event {
                cycle: head.cycle,
                monotonic_ns: head.monotonic_ns,
                kind: FAULT.into(),
                channel: channel.clone(),
                code: found,
                text,
                ..Event::default()
            })
        })
    }
}
