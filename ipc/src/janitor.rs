//! Clears away what dead clients have left, on a thread of its own: on a busy machine that takes seconds, in which the thread that
//! answers commands would answer nobody.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, Sender, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::CallbackProgression;

use crate::Error;
use crate::run::shared_memory;
use crate::server::Run;
use crate::service::IpcNode;

/// How often nodes of dead clients are looked for.
const PERIOD: Duration = Duration::from_secs(1);
/// Shared memory that has had no size for so long was made by a client that died before it could give it one.
const HALF_MADE: Duration = Duration::from_secs(2);
/// A folder that has been empty for so long is nobody's who is just coming or going.
const EMPTY: Duration = Duration::from_secs(60);

/// The thread. Dropped, it ends, once it is through with the node it is at.
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
                clear(&run, || stopped.try_recv() == Err(TryRecvError::Disconnected));
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

/// Clears the dead nodes of the run, until it is over. What cannot be cleared now is tried again the next time.
fn clear(run: &Run, is_over: impl Fn() -> bool) {
    remove_half_made(run);
    let config = run.node.config();
    let nodes = PathBuf::from(config.global.node_dir().to_string());
    let each = |state| {
        if let NodeState::Dead(dead) = state
            && half_made(run).is_empty()
        {
            let id = dead.id().value().to_string();
            let home = nodes.join(&id);
            remove_unfinished(&home);
            if dead.details().is_some() {
                // iceoryx2 panics when a node it took for dead turns out to live; that must not take the driver along.
                let _ = catch_unwind(AssertUnwindSafe(|| dead.try_remove_stale_resources()));
            } else {
                remove_rest(&nodes, &home, &format!("{}{id}.", config.global.prefix));
            }
        }
        if is_over() { CallbackProgression::Stop } else { CallbackProgression::Continue }
    };
    let _ = catch_unwind(AssertUnwindSafe(|| IpcNode::list(config, each)));
    // Whoever died between its folder and its monitor is on nobody's list.
    for entry in fs::read_dir(&nodes).into_iter().flatten().flatten() {
        let changed = entry.metadata().and_then(|folder| folder.modified());
        if changed.is_ok_and(|changed| changed.elapsed().is_ok_and(|age| age > EMPTY)) {
            // Only what is an empty folder goes.
            let _ = fs::remove_dir(entry.path());
        }
    }
}

/// Shared memory of the run without a size. Whoever opens it waits for it to get one, in iceoryx2 (0.10) without end: the driver's own
/// threads, and the clearing of the node that made it. A dead node makes no more of it, so once there is none its clearing is safe.
fn half_made(run: &Run) -> Vec<PathBuf> {
    let mut all = shared_memory(run.lock.run());
    all.retain(|path| fs::metadata(path).is_ok_and(|file| file.len() == 0));
    all
}

/// Takes away what has been without a size for longer than a living client leaves it so; whoever waits for it goes on.
fn remove_half_made(run: &Run) {
    for path in half_made(run) {
        let made = fs::metadata(&path).and_then(|file| file.modified());
        if made.is_ok_and(|made| made.elapsed().is_ok_and(|age| age > HALF_MADE)) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A client that is killed in the moment in which it writes a mark of itself (a tag of a service it opens, of a port) leaves a file that
/// is not finished: still writable. iceoryx2 (0.10) does not see such a file, cannot remove the node's folder for it, and does not
/// know the node any more from then on, whose place stays taken. The mark comes before what it marks, so it stands for nothing.
fn remove_unfinished(home: &Path) {
    for entry in fs::read_dir(home).into_iter().flatten().flatten() {
        let unfinished = entry.metadata().is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o200 != 0);
        if unfinished {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The files of a node that died before it had said anything of itself, or after it had taken that back: nothing but its monitor.
fn remove_rest(nodes: &Path, home: &Path, prefix: &str) {
    // What is in there still belongs to somebody.
    if fs::remove_dir(home).is_err_and(|e| e.kind() != std::io::ErrorKind::NotFound) {
        return;
    }
    for entry in fs::read_dir(nodes).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(prefix) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
