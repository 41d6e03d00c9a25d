//! Clears away what dead clients have left, on a thread of its own: on a busy machine that takes seconds, in which the thread that
//! answers commands would answer nobody.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::Error;
use crate::server::Run;

/// How often nodes of dead clients are looked for.
const PERIOD: Duration = Duration::from_secs(1);

/// The thread. Dropped, it ends, once it is through with what it is at.
#[derive(Debug)]
pub(crate) struct Janitor {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Janitor {
    /// Looks from now on for what dead clients of this run have left.
    pub fn start(run: &Arc<Run>) -> Result<Janitor, Error> {
        let (stop, stopped) = mpsc::channel::<()>();
        let run = run.clone();
        let work = move || {
            while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                // iceoryx2 panics when a node it took for dead turns out to live; that must not take the driver along.
                let _ = catch_unwind(AssertUnwindSafe(|| run.node.try_cleanup_dead_nodes()));
            }
        };
        let thread = thread::Builder::new().name("sinew-janitor".into()).spawn(work);
        let thread = thread.map_err(|e| Error::Service { what: "command", reason: format!("no thread: {e}") })?;
        Ok(Janitor { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
