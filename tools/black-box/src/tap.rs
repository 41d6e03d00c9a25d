//! The black box' part on the publisher's thread: copies a cycle, checks for faults, hands over files that are due.

use std::sync::Arc;
use std::sync::mpsc::Sender;

use sinew_driver::Tap;
use sinew_ipc::{ChannelState, CycleHeader};

use crate::history::{History, Kept};
use crate::watch::{Due, Watch};

/// A file to write.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) due: Due,
    pub(crate) blocks: Vec<Arc<Kept>>,
    /// The driver has ended before the time behind the fault had passed.
    pub(crate) cut_short: bool,
}

/// Keeps the last seconds. Dropped by the publisher when the loop has ended.
#[derive(Debug)]
pub(crate) struct Keeper {
    /// Gone before `jobs`: the writer's end is in order only then.
    _open: Arc<()>,
    history: History,
    watch: Watch,
    now_ns: u64,
    jobs: Sender<Job>,
}

impl Keeper {
    pub(crate) fn new(wish: &sinew_rig::BlackBox, channels: usize, jobs: Sender<Job>, open: Arc<()>) -> Keeper {
        let ns = |seconds: f64| (seconds * 1e9) as u64;
        Keeper {
            _open: open,
            history: History::new(channels, wish.memory_bytes),
            watch: Watch::new(channels, ns(wish.before_s), ns(wish.after_s)),
            now_ns: 0,
            jobs,
        }
    }

    fn hand_over(&mut self, due: Due, cut_short: bool) {
        let blocks = self.history.since(due.from_ns);
        // The writer is only gone when it has died, which is published.
        let _ = self.jobs.send(Job { due, blocks, cut_short });
    }
}

impl Tap for Keeper {
    fn cycle(&mut self, header: &CycleHeader, channels: &[ChannelState]) {
        self.now_ns = header.monotonic_ns;
        self.history.push(header, channels, self.watch.keep_from_ns(self.now_ns));
        if let Some(due) = self.watch.see(header, channels) {
            self.hand_over(due, false);
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if let Some(due) = self.watch.over(self.now_ns) {
            self.hand_over(due, true);
        }
    }
}
