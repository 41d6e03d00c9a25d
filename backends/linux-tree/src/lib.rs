//! A simulated rig as Linux devices: `/sys/class/pwm`, `/sys/bus/iio/devices`, `/dev/iio:deviceN` and `/sys/class/gpio` under any
//! folder, behaving like the kernel, with simulated wires behind them.
//!
//! It is a file system in user space, so that every read and write behaves as in the kernel: a state of PWM is applied or
//! refused as a whole, an output is exported once, a running buffer cannot be changed, a full one drops its newest scans, a
//! node is open once, and an unplugged device returns ENODEV through open files. Unlike the kernel: the device
//! nodes are regular files that never block (a blocking read gets EAGAIN too, `poll` always reports ready), there are no uevents,
//! and all files belong to root.
//!
//! ```no_run
//! use sinew_linux_tree::{Scans, Tree};
//!
//! let folder = tempfile::tempdir()?;
//! let mut tree = Tree::mount(&sinew_rig::Rig::hexapod(), Scans::OnPhase, folder.path())?;
//! tree.run(); // from now on time passes: `root` of the rig file's [backend.linux] is this folder
//! println!("see {}/sys/class/pwm", tree.root().display());
//! # Ok::<(), std::io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod files;
mod gpio;
mod iio;
mod kernel;
mod mounts;
mod pwm;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use fuser::{BackgroundSession, Config, MountOption};
use sinew_rig::Rig;

pub use gpio::{ENABLE, Line, RESET, STOP, value_file};
pub use iio::{Converter, Input};
pub use kernel::{Kernel, Scans, TRIGGER};
pub use pwm::{Chip, Output};

/// A mounted tree. It is gone when this is dropped, whoever still has files of it open; should its process be killed, the next
/// tree that is mounted clears it away.
pub struct Tree {
    root: PathBuf,
    kernel: Arc<Mutex<Kernel>>,
    clock: Option<(Arc<AtomicBool>, JoinHandle<()>)>,
    session: Option<BackgroundSession>,
    period: Duration,
}

impl Tree {
    /// Shows a rig under `root`, a folder that exists: channel n on output n % 16 of `pwmchip(n / 16 · 16)`, with a converter of
    /// its own, `iio:deviceN`, whose inputs `in_voltage0` to `in_voltage3` are V1, V2, V3 and the supply, and whose
    /// `in_current0` is the current. The line [`ENABLE`] switches the supply of all stages where the rig has one that does, [`STOP`] is the
    /// contact of its emergency stop and [`RESET`] the button, with the rig's polarities. Time stands still until [`Tree::pass`] or [`Tree::run`].
    ///
    /// # Errors
    /// No FUSE here, or a rig that cannot be simulated.
    pub fn mount(rig: &Rig, scans: Scans, root: &Path) -> io::Result<Tree> {
        mounts::clear()?;
        let kernel = Kernel::new(rig, scans).map_err(|error| io::Error::other(error.to_string()))?;
        let kernel = Arc::new(Mutex::new(kernel));
        let files = files::Files { kernel: kernel.clone(), inodes: Mutex::default() };
        let mut config = Config::default();
        config.mount_options = vec![MountOption::FSName(mounts::name()), MountOption::NoExec];
        let session = fuser::spawn_mount(files, root, &config)?;
        let period = Duration::from_secs_f64(1.0 / rig.rate_hz);
        Ok(Tree { root: root.into(), kernel, clock: None, session: Some(session), period })
    }

    /// Where it is mounted.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The kernel behind the files.
    pub fn kernel(&self) -> MutexGuard<'_, Kernel> {
        lock(&self.kernel)
    }

    /// Lets one period pass.
    pub fn pass(&self) {
        self.kernel().pass();
    }

    /// Lets time pass by itself from now on.
    pub fn run(&mut self) {
        let (stop, kernel, period) = (Arc::new(AtomicBool::new(false)), self.kernel.clone(), self.period);
        let stopped = stop.clone();
        let clock = thread::spawn(move || {
            let mut due = Instant::now() + period;
            while !stopped.load(Ordering::Relaxed) {
                thread::sleep(due.saturating_duration_since(Instant::now()));
                // A clock that was not let run makes up for it: hardware would not have stood still.
                while due <= Instant::now() {
                    lock(&kernel).pass();
                    due += period;
                }
            }
        });
        self.clock = Some((stop, clock));
    }
}

fn lock(kernel: &Mutex<Kernel>) -> MutexGuard<'_, Kernel> {
    kernel.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Tree {
    fn drop(&mut self) {
        if let Some((stop, clock)) = self.clock.take() {
            stop.store(true, Ordering::Relaxed);
            let _ = clock.join();
        }
        if let Some(session) = self.session.take() {
            mounts::take_away(&self.root);
            drop(session);
        }
    }
}
