//! What went wrong, for the report and in words: the faults as they happened, the leases that ended, and one line for each cause.

use std::collections::BTreeSet;

use sinew_ipc::Fault;

use crate::orders::{Event, Occurrence};
use crate::report::MAX_FAULTS;

/// So many channels are named in a line; of more, the first ones and how many others.
const NAMED: usize = 6;

/// The fault log: faults and lapsed leases as they happened.
#[derive(Debug, Default)]
pub(crate) struct FaultLog {
    /// When (ns on the loop's clock), which channel, what; the first [`MAX_FAULTS`].
    pub faults: Vec<(u64, u32, Fault)>,
    /// Those beyond.
    pub not_listed: u64,
    /// Setpoints whose lease ran out.
    pub lapsed: u64,
    /// What has been noted and not been said yet.
    line: Option<Line>,
}

/// What is said of several channels at once: the same happened to them in the same cycle.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    at_ns: u64,
    /// A fault, or the end of a lease.
    fault: Option<Fault>,
    channels: BTreeSet<u32>,
}

impl FaultLog {
    /// Takes an event. It is said with the others of its cycle and cause, once an event of another one comes or [`FaultLog::say`] is called.
    pub fn note(&mut self, event: &Event, names: &[String]) {
        let fault = match event.what {
            Occurrence::Tripped(fault) => Some(fault),
            Occurrence::Lapsed => None,
            Occurrence::Complained(error) => {
                self.say(names);
                tracing::error!("{error}");
                return;
            }
            Occurrence::Proved | Occurrence::Answered { .. } => return,
        };
        match fault {
            None => self.lapsed += 1,
            Some(fault) if self.faults.len() < MAX_FAULTS => self.faults.push((event.at_ns, event.channel, fault)),
            Some(_) => self.not_listed += 1,
        }
        let goes_on = |line: &&mut Line| (line.at_ns, line.fault) == (event.at_ns, fault);
        match self.line.as_mut().filter(goes_on) {
            Some(line) => drop(line.channels.insert(event.channel)),
            None => {
                self.say(names);
                self.line = Some(Line { at_ns: event.at_ns, fault, channels: BTreeSet::from([event.channel]) });
            }
        }
    }

    /// Says what has been noted and not been said yet.
    pub fn say(&mut self, names: &[String]) {
        let Some(Line { fault, channels, .. }) = self.line.take() else { return };
        let channel = listed(&channels, names);
        match fault {
            Some(fault) => {
                let (cause, reaction, remedy) = (fault.cause(), fault.reaction(), fault.remedy());
                tracing::warn!(channel, flag = fault.flag(), "{cause}; {reaction}; {remedy}");
            }
            None => tracing::info!(channel, "the setpoint's lease has ended: off until the next setpoint"),
        }
    }
}

/// The names of these channels, as far as people would read them.
fn listed(channels: &BTreeSet<u32>, names: &[String]) -> String {
    let count = channels.len();
    if count == names.len() && count > NAMED {
        return format!("all {count}");
    }
    let mut text = String::new();
    for &channel in channels.iter().take(if count > NAMED { NAMED - 1 } else { NAMED }) {
        let comma = if text.is_empty() { "" } else { ", " };
        text += comma;
        text += names.get(channel as usize).map_or("?", String::as_str);
    }
    if count > NAMED {
        text += &format!(" and {} others", count - (NAMED - 1));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(count: usize) -> Vec<String> {
        (0..count).map(|i| format!("w{i}")).collect()
    }

    #[test]
    fn few_are_named_and_of_many_it_is_said_how_many() {
        let text = |channels: &[u32], count| listed(&channels.iter().copied().collect(), &names(count));
        assert_eq!(text(&[3], 64), "w3");
        assert_eq!(text(&[2, 0, 1], 3), "w0, w1, w2");
        assert_eq!(text(&[0, 1, 2, 3, 4, 5], 7), "w0, w1, w2, w3, w4, w5");
        assert_eq!(text(&[0, 1, 2, 3, 4, 5, 9], 64), "w0, w1, w2, w3, w4 and 2 others");
        assert_eq!(text(&(0..64).collect::<Vec<_>>(), 64), "all 64");
        assert_eq!(text(&[7], 2), "?", "nothing that comes of a wrong number is fatal");
    }

    #[test]
    fn what_happened_to_many_at_once_is_one_line_and_every_fault_is_listed() {
        let (mut log, names) = (FaultLog::default(), names(64));
        let event = |at_ns, channel, what| Event { at_ns, channel, what };
        let late = Occurrence::Tripped(Fault::CycleOverrun);
        (0..64).for_each(|channel| log.note(&event(5, channel, late), &names));
        assert_eq!(log.line.as_ref().map(|line| line.channels.len()), Some(64), "nothing has been said yet");
        // The same cause in another cycle is another line, and so is another cause in the same one.
        log.note(&event(6, 0, late), &names);
        assert_eq!(log.line.as_ref().map(|line| line.channels.len()), Some(1));
        log.note(&event(6, 1, Occurrence::Lapsed), &names);
        log.note(&event(6, 2, Occurrence::Lapsed), &names);
        assert_eq!(log.line.as_ref().map(|line| (line.fault, line.channels.len())), Some((None, 2)));
        log.say(&names);
        assert_eq!((log.line, log.faults.len(), log.lapsed, log.not_listed), (None, 65, 2, 0));
    }
}
