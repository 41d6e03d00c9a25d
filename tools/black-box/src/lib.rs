//! The black box: the last seconds before a fault, and the second after it, in a file.
//!
//! [`BlackBox::start`] gives a [`sinew_driver::Tap`] to put into a driver. It keeps the cycles of the last seconds in memory. When a
//! fault is latched it waits for the second after it and hands both to a separate thread, which writes them: an ordinary
//! session, which `sinew plot`, `replay`, `export` and `recording doctor` read. Faults within that second are in the same
//! file, and those that follow at once in the next one, which begins where the first ends: however many faults there are, there
//! is at most one file in the time a file covers before its fault.
//!
//! Memory is bounded ([`sinew_rig::BlackBox::memory_bytes`]), including data being written: where the rig is too large or too
//! fast for it, or the disk too slow, a file has a shorter history before its fault, and notes that. A file gets its name when it is complete.
//! A failed write loses that file with a warning and never affects the driver: the loop is not involved, and the publisher
//! only copies.
//!
//! # Example
//! Files go into a folder for the rig, which keeps the newest of them:
//!
//! ```no_run
//! use sinew_black_box::{BlackBox, Place, folder};
//! use sinew_rig::Rig;
//!
//! let rig = Rig::hexapod();
//! let place = Place::new(folder()?, &rig.name, rig.black_box.keep as usize);
//! let (black_box, tap) = BlackBox::start(&rig, place, true)?;
//! // `tap` goes into the driver, which drops it when its loop has ended; then
//! drop(tap);
//! println!("{} files", black_box.finish().files.len());
//! # Ok::<(), sinew_black_box::Error>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod history;
mod place;
mod tap;
mod watch;
mod writer;
mod written;

use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use sinew_driver::Tap;
use sinew_recorder::layout;
use sinew_rig::Rig;
use sinew_threads::Thread;

pub use error::Error;
pub use place::{Place, folder, state_folder};
use tap::Keeper;
use writer::Writer;
pub use written::Written;

/// How long the end of a driver waits at most for its last file. Outputs are at zero by then.
const PATIENCE: Duration = Duration::from_secs(30);

/// A black box that runs beside a driver.
#[derive(Debug)]
pub struct BlackBox {
    written: Arc<Mutex<Written>>,
    /// Disconnected when the writer has ended.
    ended: Receiver<()>,
    thread: JoinHandle<Option<()>>,
}

impl BlackBox {
    /// A black box for a driver of this rig, as its `[black_box]` says, and the tap that fills it. Files go into `place`.
    ///
    /// # Errors
    /// [`Error::Layout`], [`Error::Thread`].
    pub fn start(rig: &Rig, place: Place, simulated: bool) -> Result<(BlackBox, Box<dyn Tap>), Error> {
        let layout = layout(rig.channels.iter().map(|channel| channel.name.clone()).collect())?;
        let written = Arc::new(Mutex::new(Written::default()));
        let (jobs, work) = mpsc::channel();
        let (ends, ended) = mpsc::channel::<()>();
        let open = Arc::new(());
        let fed = Arc::downgrade(&open);
        let keeper = Keeper::new(&rig.black_box, rig.channels.len(), jobs, open);
        let writer = Writer::new(rig, layout, place, simulated, written.clone());
        let thread = Thread::BlackBox
            .start()
            .ends_when(move || fed.strong_count() == 0)
            .spawn(move || {
                // dropped at the end, however that comes
                let _ends = ends;
                writer.run(&work);
            })
            .map_err(Error::Thread)?;
        Ok((BlackBox { written, ended, thread }, Box::new(keeper)))
    }

    /// Waits until everything is written; the driver has ended. A disk that does not answer is not waited for longer than half a minute.
    pub fn finish(self) -> Written {
        let BlackBox { written, ended, thread } = self;
        let is_given_up = ended.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout);
        let has_died = !is_given_up && !thread.join().is_ok_and(|worked| worked.is_some());
        let mut written = written.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if is_given_up {
            tracing::warn!("the last black box is still being written after {} s and is given up", PATIENCE.as_secs());
        }
        if has_died {
            written.failure = Some("the thread that writes black boxes has died: there were none from then on".into());
        }
        written
    }
}
