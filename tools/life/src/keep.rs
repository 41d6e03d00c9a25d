//! Accounts that a running driver keeps: the publisher's thread counts, one of its own writes.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use sinew_driver::Tap;
use sinew_ipc::{ChannelState, CycleHeader};
use sinew_recording::Utc;
use sinew_rig::Rig;
use sinew_threads::Thread;

use crate::account::{Account, Report};
use crate::error::Error;
use crate::store::Store;
use crate::wire::Wire;

/// How often accounts are written while the driver runs, s. What is lost with the machine is so much of them.
const EVERY_S: f64 = 60.0;
/// How often the thread looks whether it is to go on.
const LOOK: Duration = Duration::from_millis(100);
/// How long the end of a driver waits at most for the last of them. Outputs are at zero by then.
const PATIENCE: Duration = Duration::from_secs(30);
/// Longest time that a gap in the cycles is taken to have been like the one after it, s.
const MOST_GAP_S: f64 = 1.0;

/// Accounts kept beside a driver.
#[derive(Debug)]
pub struct Accounts {
    kept: Arc<Mutex<Kept>>,
    notes: Vec<String>,
    /// Disconnected when the writer has ended.
    ended: Receiver<()>,
    thread: JoinHandle<Option<()>>,
}

/// What has become of them.
#[derive(Debug, Clone, Default)]
pub struct Kept {
    /// What the accounts come to, as they were last written.
    pub reports: Vec<Report>,
    /// How many could not be written.
    pub failed: u64,
    /// Why not, the last one.
    pub failure: Option<String>,
}

impl Accounts {
    /// Accounts of the wires of this rig, and the tap that keeps them. A wire whose file cannot be read has none in this run: [`Accounts::notes`]
    /// says so.
    ///
    /// # Errors
    /// [`Error::Thread`].
    pub fn start(rig: &Rig, store: Store, simulated: bool) -> Result<(Accounts, Box<dyn Tap>), Error> {
        let mut notes = Vec::new();
        let open = |index: usize| {
            let (name, wire) = (&rig.channels[index].name, Wire::of(rig, index));
            let mut account = match store.read(&rig.name, name, simulated) {
                Ok(there) => there.unwrap_or_else(|| Account::new(&rig.name, name, simulated, &wire)),
                Err(error) => {
                    notes.push(format!("no account of {name} in this run: {error}; {}", error.remedy()));
                    return None;
                }
            };
            if !account.wire.may_be(&wire.identity) {
                let size = |m: f64| (m * 1e6).round() / 1e3;
                let (was, is) = (&account.wire, &wire.identity);
                notes.push(format!(
                    "{name}: its account is that of a wire of {} mm × {} mm {}, the rig file's is {} mm × {} mm {}: it goes on as if it were \
                     the same; if it is not, `sinew life RIG.toml {name} --new-wire` begins anew",
                    size(was.diameter_m),
                    size(was.length_m),
                    was.kind,
                    size(is.diameter_m),
                    size(is.length_m),
                    is.kind
                ));
            }
            account.runs += 1;
            Some(Open { wire, account })
        };
        let wires: Vec<Option<Open>> = (0..rig.channels.len()).map(open).collect();
        let kept = Arc::new(Mutex::new(Kept::default()));
        let (jobs, work) = mpsc::channel();
        let (ends, ended) = mpsc::channel::<()>();
        let open = Arc::new(());
        let fed = Arc::downgrade(&open);
        let every = (EVERY_S * rig.rate_hz).max(1.0) as u64;
        let keeper = Keeper { _open: open, wires, rate_hz: rig.rate_hz, last: None, every, since: 0, jobs };
        let written = kept.clone();
        let thread = Thread::Account
            .start()
            .ends_when(move || fed.strong_count() == 0)
            .spawn(move || {
                // dropped at the end, however that comes
                let _ends = ends;
                write(&store, &work, &written);
            })
            .map_err(Error::Thread)?;
        Ok((Accounts { kept, notes, ended, thread }, Box::new(keeper)))
    }

    /// What is to be said of them before the run.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Waits until everything is written; the driver has ended. A disk that does not answer is not waited for longer than half a minute.
    pub fn finish(self) -> Kept {
        let Accounts { kept, ended, thread, .. } = self;
        let is_given_up = ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout);
        let has_died = !is_given_up && !thread.join().is_ok_and(|worked| worked.is_some());
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if is_given_up {
            kept.failure = Some(format!("still being written after {} s, and given up", PATIENCE.as_secs()));
        }
        if has_died {
            kept.failure =
                Some("the thread that writes accounts has died: nothing was added to them from then on".into());
        }
        kept
    }
}

/// A wire whose account is kept.
#[derive(Debug)]
struct Open {
    wire: Wire,
    account: Account,
}

/// Counts. Dropped by the publisher when the loop has ended.
#[derive(Debug)]
struct Keeper {
    /// Gone before `jobs`: the writer's end is in order only then.
    _open: Arc<()>,
    wires: Vec<Option<Open>>,
    rate_hz: f64,
    /// Number of the cycle before.
    last: Option<u64>,
    /// After how many cycles accounts are written, and how many it has been.
    every: u64,
    since: u64,
    jobs: Sender<Vec<Account>>,
}

impl Keeper {
    fn hand_over(&mut self) {
        let accounts = self.wires.iter().flatten().map(|open| open.account.clone()).collect();
        // The writer is only gone when it has died, which is published.
        let _ = self.jobs.send(accounts);
    }
}

impl Tap for Keeper {
    fn cycle(&mut self, header: &CycleHeader, channels: &[ChannelState]) {
        let periods = self.last.map_or(1, |last| header.cycle.saturating_sub(last));
        self.last = Some(header.cycle);
        let seconds = (periods as f64 / self.rate_hz).min(MOST_GAP_S);
        for (open, state) in self.wires.iter_mut().zip(channels) {
            if let Some(Open { wire, account }) = open {
                account.see(wire, &wire.sample(state, seconds));
            }
        }
        self.since += 1;
        if self.since >= self.every {
            self.since = 0;
            self.hand_over();
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if self.last.is_some() {
            self.hand_over();
        }
    }
}

/// Writes accounts until there will be no more.
fn write(store: &Store, work: &Receiver<Vec<Account>>, kept: &Mutex<Kept>) {
    let mut failing = false;
    while !sinew_threads::is_struck() {
        let accounts = match work.recv_timeout(LOOK) {
            Ok(accounts) => accounts,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        let (mut reports, mut failed, mut failure) = (Vec::new(), 0, None);
        for mut account in accounts {
            account.updated = Utc::now().to_string();
            match store.write(&account) {
                Ok(()) => reports.push(account.report()),
                Err(error) => {
                    failed += 1;
                    if !failing {
                        tracing::warn!(
                            "the account of {} is not written: {error}; {}",
                            account.channel,
                            error.remedy()
                        );
                    }
                    failing = true;
                    failure = Some(error.to_string());
                }
            }
        }
        failing = failure.is_some();
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.failed += failed;
        kept.failure = failure.or(kept.failure.take());
        kept.reports = reports;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(tap: &mut dyn Tap, channels: usize, cycles: std::ops::Range<u64>, rate_hz: f64) {
        for cycle in cycles {
            let t = cycle as f64 / rate_hz;
            let martensite = 0.5 + 0.5 * (t * std::f64::consts::TAU).cos();
            let state = ChannelState { duty: 0.5, martensite, temperature_c: 80.0, ..ChannelState::UNKNOWN };
            let header = CycleHeader { cycle, monotonic_ns: (t * 1e9) as u64, missed: 0 };
            tap.cycle(&header, &vec![state; channels]);
        }
    }

    #[test]
    fn what_a_run_adds_is_there_in_the_next_one_and_a_changed_wire_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let mut rig = Rig::hexapod();
        let (count, rate_hz) = (rig.channels.len(), rig.rate_hz);
        let name = rig.channels[0].name.clone();
        for run in 1..=2u64 {
            let (accounts, mut tap) = Accounts::start(&rig, store.clone(), true).unwrap();
            assert!(accounts.notes().is_empty(), "{:?}", accounts.notes());
            drive(&mut *tap, count, 1..(10.0 * rate_hz) as u64 + 1, rate_hz);
            drop(tap);
            let kept = accounts.finish();
            assert!(kept.failure.is_none() && kept.reports.len() == count, "{kept:?}");
            let report = store.read(&rig.name, &name, true).unwrap().unwrap().report();
            assert_eq!(report.runs, run);
            assert!((report.cycles - 10.0 * run as f64).abs() < 0.6, "{}", report.cycles);
            assert!((report.hours_powered * 360.0 - run as f64).abs() < 0.01, "{}", report.hours_powered);
        }
        rig.channels[0].model.geometry.diameter_m *= 1.5;
        let (accounts, tap) = Accounts::start(&rig, store.clone(), true).unwrap();
        assert!(accounts.notes().len() == 1 && accounts.notes()[0].contains("--new-wire"), "{:?}", accounts.notes());
        drop(tap);
        accounts.finish();
    }

    #[test]
    fn a_damaged_file_is_left_alone_and_the_others_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let rig = Rig::hexapod();
        let (first, second) = (rig.channels[0].name.clone(), rig.channels[1].name.clone());
        let path = store.path(&rig.name, &first, true);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "precious").unwrap();
        let (accounts, mut tap) = Accounts::start(&rig, store.clone(), true).unwrap();
        assert!(accounts.notes()[0].contains(&first) && accounts.notes()[0].contains("--new-wire"));
        drive(&mut *tap, rig.channels.len(), 1..100, rig.rate_hz);
        drop(tap);
        accounts.finish();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
        assert!(store.read(&rig.name, &second, true).unwrap().is_some());
    }
}
