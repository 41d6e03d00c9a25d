//! What the service manager (systemd) is told of a driver: that its loop runs, that it goes on, that it stops. Nothing where nobody
//! asks: without `NOTIFY_SOCKET` there is not even a thread.
//!
//! A thread of its own tells it, beside the loop and beside what shows the driver, which may wait for a terminal. What it goes by
//! is the count of the loop's cycles: a loop that stands still is not vouched for.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use sd_notify::NotifyState;
use sinew_driver::{DriverHandle, Progress, Stats};
use sinew_rig::Rig;
use sinew_threads::Thread;

use crate::failure::Failure;
use crate::output::counted;

/// Cycles after which a driver is ready: its backend has brought something back, and the loop has gone on.
const FIRST_CYCLES: u64 = 3;
/// Between two looks at the loop.
const LOOK: Duration = Duration::from_millis(10);
/// Words for people are sent at most so often.
const WORDS: Duration = Duration::from_secs(2);
/// The watchdog is told so many times in the time it waits.
const TIMES: u32 = 4;

/// Tells the service manager, if there is one, until the driver has ended.
pub fn start(rig: &Rig, driver: &DriverHandle) -> Result<Option<JoinHandle<Option<()>>>, Failure> {
    if std::env::var_os("NOTIFY_SOCKET").is_none() {
        return Ok(None);
    }
    let (progress, over, stopper) = (driver.progress(), driver.stopper(), driver.stopper());
    let what = format!("{}: {} at {} Hz", rig.name, counted(rig.channels.len(), "channel"), rig.rate_hz);
    let start = Thread::Herald.start().ends_when(move || over.has_ended()).on_death(move || stopper.fail());
    let failed = |error: std::io::Error| Failure::own(format!("no thread to tell the service manager: {error}"));
    start.spawn(move || Herald::new(progress, what).tell()).map(Some).map_err(failed)
}

struct Herald {
    progress: Progress,
    what: String,
    /// Time between two words to the watchdog, where there is one.
    watchdog: Option<Duration>,
    /// Whether a word that did not arrive was complained of.
    complained: bool,
}

impl Herald {
    fn new(progress: Progress, what: String) -> Herald {
        let watchdog = sd_notify::watchdog_enabled().map(|patience| patience / TIMES);
        Herald { progress, what, watchdog, complained: false }
    }

    fn tell(mut self) {
        let mut ready = false;
        // the cycles the watchdog was last told of, and when
        let (mut vouched, mut vouched_at) = (0, Instant::now());
        let mut worded_at = Instant::now();
        while !sinew_threads::is_struck() {
            let stats = self.progress.stats();
            if !stats.running {
                self.say(&[NotifyState::Stopping, NotifyState::Status(&format!("{}: stopping", self.what))]);
                return;
            }
            if !ready && stats.cycles >= FIRST_CYCLES {
                ready = true;
                (vouched, vouched_at, worded_at) = (stats.cycles, Instant::now(), Instant::now());
                self.say(&[NotifyState::Ready, NotifyState::Watchdog, NotifyState::Status(&self.words(&stats))]);
            } else if ready {
                let due = self.watchdog.is_some_and(|period| vouched_at.elapsed() >= period);
                if due && stats.cycles > vouched {
                    (vouched, vouched_at) = (stats.cycles, Instant::now());
                    self.say(&[NotifyState::Watchdog]);
                }
                if worded_at.elapsed() >= WORDS {
                    worded_at = Instant::now();
                    self.say(&[NotifyState::Status(&self.words(&stats))]);
                }
            }
            std::thread::sleep(LOOK.min(self.watchdog.unwrap_or(LOOK)));
        }
    }

    /// One line for people.
    fn words(&self, stats: &Stats) -> String {
        let Stats { cycles, missed, faults, .. } = stats;
        format!("{}: {cycles} cycles, {missed} periods missed, {faults} faults so far", self.what)
    }

    fn say(&mut self, words: &[NotifyState<'_>]) {
        if let Err(error) = sd_notify::notify(words)
            && !std::mem::replace(&mut self.complained, true)
        {
            tracing::warn!("the service manager cannot be told how the driver does: {error}");
        }
    }
}
