//! Clears away what dead clients have left, on a thread of its own: on a busy machine that takes seconds, in which the thread that
//! answers commands would answer nobody.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::CallbackProgression;
use sinew_threads::{Thread, caught};

use crate::Error;
use crate::remains::{Since, entries, half_made, remove_rest, remove_unfinished, unlisted, unmarked};
use crate::run::shared_memory;
use crate::service::{IpcNode, Run};

/// How often nodes of dead clients are looked for.
const PERIOD: Duration = Duration::from_secs(1);
/// What is not finished for so long, or nobody's, was a client's that died over it.
const LASTING: Duration = Duration::from_secs(2);
/// A node that nobody lists for so long is none that is just coming or going, not even on a machine that has no time for it.
const UNLISTED: Duration = Duration::from_secs(60);

/// The thread. Dropped, it ends, once it is through with the node it is at.
#[derive(Debug)]
pub(crate) struct Janitor {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<Option<()>>>,
}

impl Janitor {
    /// Looks from now on for what dead clients of this run have left.
    pub fn start(run: &Arc<Run>) -> Result<Janitor, Error> {
        let over = Arc::new(AtomicBool::new(false));
        let is_over = {
            let over = over.clone();
            move || over.load(Ordering::Acquire)
        };
        let mut rounds = Rounds {
            run: run.clone(),
            half_made: Since::default(),
            unmarked: Since::default(),
            unlisted: Since::default(),
        };
        let start = Thread::Janitor.start().ends_when(is_over.clone());
        let thread = start.spawn(move || {
            loop {
                thread::park_timeout(PERIOD);
                if is_over() || sinew_threads::is_struck() {
                    return;
                }
                rounds.round(&is_over);
            }
        });
        let thread = thread.map_err(|e| Error::Service { what: "command", reason: format!("no thread: {e}") })?;
        Ok(Janitor { over, thread: Some(thread) })
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

/// One look after the other, and what has been seen in those before.
struct Rounds {
    run: Arc<Run>,
    half_made: Since,
    unmarked: Since,
    unlisted: Since,
}

impl Rounds {
    /// Clears the dead nodes of the run and what killed clients leave besides, until it is over. What cannot be cleared now is tried
    /// again the next time.
    fn round(&mut self, is_over: impl Fn() -> bool) {
        let config = self.run.node.config();
        let root = PathBuf::from(config.global.root_path().to_string());
        let nodes = PathBuf::from(config.global.node_dir().to_string());
        let prefix = config.global.prefix.to_string();
        let shared = || shared_memory(self.run.lock.run());

        for path in self.half_made.longer_than(LASTING, half_made(shared())) {
            let _ = fs::remove_file(path);
        }
        let mut listed = BTreeSet::new();
        let each = |state: NodeState<_>| {
            listed.insert(state.node_id().value());
            if let NodeState::Dead(dead) = state
                // A dead node makes no more of it, so once there is none the clearing waits for nothing.
                && half_made(shared()).is_empty()
            {
                let home = nodes.join(dead.id().value().to_string());
                remove_unfinished(&home);
                if dead.details().is_some() {
                    // iceoryx2 panics when a node it took for dead turns out to live; that must not take the driver along.
                    let _ = caught(|| dead.try_remove_stale_resources());
                } else {
                    remove_rest(&nodes, &home, &prefix);
                }
            }
            if is_over() { CallbackProgression::Stop } else { CallbackProgression::Continue }
        };
        let all_listed = matches!(caught(|| IpcNode::list(config, each)), Ok(Ok(())));
        if !all_listed || is_over() {
            return;
        }
        for home in self.unlisted.longer_than(UNLISTED, unlisted(&nodes, &prefix, &listed)) {
            remove_rest(&nodes, &home, &prefix);
        }
        let files = shared().into_iter().chain(entries(&root)).collect();
        for path in self.unmarked.longer_than(LASTING, unmarked(files, &prefix, &nodes)) {
            let _ = fs::remove_file(path);
        }
    }
}
