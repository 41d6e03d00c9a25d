//! Decides when a file is due: a fault was latched, and the time after it has passed.

use sinew_ipc::{ChannelState, CycleHeader};

/// What a file is written for, and what it covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Due {
    /// The file begins here, as far as that is still known.
    pub(crate) from_ns: u64,
    /// And ends here.
    pub(crate) until_ns: u64,
    /// The first fault: the cycle it was latched in, when, on which channel, its code.
    pub(crate) cycle: u64,
    pub(crate) at_ns: u64,
    pub(crate) channel: usize,
    pub(crate) fault: u32,
    /// How many were latched in that time.
    pub(crate) faults: u32,
}

/// Watches every cycle for faults.
#[derive(Debug)]
pub(crate) struct Watch {
    before_ns: u64,
    after_ns: u64,
    /// The latched fault of each channel as of the last cycle, 0 = none.
    latched: Vec<u32>,
    due: Option<Due>,
    /// Where the last file ended.
    covered_ns: Option<u64>,
}

impl Watch {
    pub(crate) fn new(channels: usize, before_ns: u64, after_ns: u64) -> Watch {
        Watch { before_ns, after_ns, latched: vec![0; channels], due: None, covered_ns: None }
    }

    /// From where on cycles must be kept, at this moment.
    pub(crate) fn keep_from_ns(&self, now_ns: u64) -> u64 {
        let quiet = now_ns.saturating_sub(self.before_ns);
        self.due.map_or(quiet, |due| quiet.min(due.from_ns))
    }

    /// Takes a cycle; what is due with it, if its time has passed.
    pub(crate) fn see(&mut self, header: &CycleHeader, channels: &[ChannelState]) -> Option<Due> {
        let now_ns = header.monotonic_ns;
        for (channel, (known, state)) in self.latched.iter_mut().zip(channels).enumerate() {
            if std::mem::replace(known, state.fault) == state.fault || state.fault == 0 {
                continue;
            }
            match &mut self.due {
                Some(due) => due.faults += 1,
                None => {
                    // One file in the time it covers: in a series of faults they follow each other without a gap.
                    let least_ns = self.covered_ns.map_or(0, |covered| covered.saturating_add(self.before_ns));
                    let until_ns = now_ns.saturating_add(self.after_ns).max(least_ns);
                    let from_ns = until_ns.saturating_sub(self.before_ns.saturating_add(self.after_ns));
                    let (cycle, fault) = (header.cycle, state.fault);
                    self.due = Some(Due { from_ns, until_ns, cycle, at_ns: now_ns, channel, fault, faults: 1 });
                }
            }
        }
        if self.due.is_some_and(|due| now_ns >= due.until_ns) { self.over(now_ns) } else { None }
    }

    /// The driver has ended: what is due is due now.
    pub(crate) fn over(&mut self, now_ns: u64) -> Option<Due> {
        let due = self.due.take()?;
        self.covered_ns = Some(now_ns);
        Some(due)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sinew_ipc::{Fault, Mode};

    const MS: u64 = 1_000_000;

    fn state(fault: u32) -> ChannelState {
        let mode = if fault == 0 { Mode::Length } else { Mode::Fault };
        ChannelState { mode: mode.code(), fault, ..ChannelState::UNKNOWN }
    }

    fn header(ms: u64) -> CycleHeader {
        CycleHeader { cycle: ms, monotonic_ns: ms * MS, missed: 0 }
    }

    #[test]
    fn a_fault_is_due_with_the_time_before_and_after_it_and_the_first_cause() {
        let mut watch = Watch::new(2, 1000 * MS, 100 * MS);
        let (open, probe) = (Fault::OpenWire.code(), Fault::ProbeLost.code());
        let mut found = None;
        for ms in 1..=6000 {
            let faults = [if ms >= 5050 { probe } else { 0 }, if ms >= 5000 { open } else { 0 }];
            if let Some(due) = watch.see(&header(ms), &faults.map(state)) {
                assert_eq!((ms, found.replace(due)), (5100, None), "once");
            }
        }
        let due = found.unwrap();
        assert_eq!((due.from_ns, due.until_ns), (4000 * MS, 5100 * MS));
        assert_eq!((due.cycle, due.channel, due.fault, due.faults), (5000, 1, open, 2));
    }

    #[test]
    fn what_the_end_of_the_driver_cuts_short_is_due_then() {
        let mut watch = Watch::new(1, 1000 * MS, 100 * MS);
        assert!(watch.see(&header(500), &[state(3)]).is_none());
        assert_eq!(watch.over(520 * MS).map(|due| due.cycle), Some(500));
        assert_eq!(watch.over(520 * MS), None);
    }

    proptest! {
        #[test]
        fn a_storm_is_covered_without_a_hole_and_costs_one_file_in_its_time(
            storm in prop::collection::vec((0usize..3, 0u32..5, 1u64..400), 1..200),
        ) {
            let mut watch = Watch::new(3, 1000 * MS, 100 * MS);
            let (mut faults, mut ms) = ([0; 3], 0);
            let mut latched = Vec::new();
            let mut files: Vec<Due> = Vec::new();
            for (channel, fault, quiet) in storm.into_iter().chain([(0, 0, 3000)]) {
                if fault != 0 && fault != faults[channel] {
                    latched.push((ms + 1) * MS);
                }
                faults[channel] = fault;
                for _ in 0..quiet {
                    ms += 1;
                    files.extend(watch.see(&header(ms), &faults.map(state)));
                }
            }
            for at in &latched {
                prop_assert!(files.iter().any(|due| due.from_ns <= *at && *at <= due.until_ns), "{at} is in no file");
            }
            prop_assert_eq!(latched.len(), files.iter().map(|due| due.faults as usize).sum::<usize>());
            for pair in files.windows(2) {
                prop_assert!(pair[1].until_ns >= pair[0].until_ns + 1000 * MS, "{:?}", pair);
                prop_assert!(pair[1].at_ns >= pair[0].until_ns);
                let hole = pair[1].from_ns > pair[0].until_ns && pair[1].at_ns < pair[1].from_ns + 1000 * MS;
                prop_assert!(!hole, "{:?}", pair);
            }
            for due in &files {
                prop_assert!(due.until_ns - due.from_ns <= 1100 * MS);
            }
        }
    }
}
