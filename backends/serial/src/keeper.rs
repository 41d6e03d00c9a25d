//! The reconnection thread of a lost line: all blocking operations are here and not in the loop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use sinew_front_end::Identification;
use sinew_ring::{Consumer, Producer, ring};
use sinew_threads::Thread;

use crate::error::Error;
use crate::figures::LineFigures;
use crate::link::{Link, connect};
use crate::plan::{Plan, name, started};

/// How often it looks whether a line came back from the loop, and, having none, tries to open one.
const LOOK: Duration = Duration::from_millis(20);
const RETRY: Duration = Duration::from_millis(100);
/// Links that may be on their way: one there, one back.
const LINKS: usize = 2;

/// The loop's end of it: good lines come, lost ones go, without a lock.
#[derive(Debug)]
pub(crate) struct Keeper {
    good: Consumer<Option<Link>>,
    lost: Producer<Option<Link>>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<Option<()>>>,
}

impl Keeper {
    /// Starts it with a line to hand over.
    pub fn start(plan: Plan, link: Link, who: Identification, figures: Arc<LineFigures>) -> Result<Keeper, Error> {
        let (mut give, good) = ring((0..LINKS).map(|_| None));
        let (lost, take) = ring((0..LINKS).map(|_| None));
        give.push(Some(link));
        let over = Arc::new(AtomicBool::new(false));
        let (watch, is_over) = (over.clone(), over.clone());
        let thread = Thread::Line
            .start()
            .ends_when(move || is_over.load(Ordering::Relaxed))
            .spawn(move || keep(&plan, &who, give, take, &figures, &watch))
            .map_err(Error::Thread)?;
        Ok(Keeper { good, lost, over, thread: Some(thread) })
    }

    /// A line, should there be a new one.
    #[inline]
    pub fn take(&mut self) -> Option<Link> {
        self.good.take(Option::take)?
    }

    /// Gives a lost line back; closing it may take a while.
    #[inline]
    pub fn give_up(&mut self, link: Link) {
        self.lost.push(Some(link));
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

fn keep(
    plan: &Plan,
    first: &Identification,
    mut give: Producer<Option<Link>>,
    mut take: Consumer<Option<Link>>,
    figures: &LineFigures,
    over: &AtomicBool,
) {
    let mut wanted = false;
    let mut said = String::new();
    while !over.load(Ordering::Relaxed) && !sinew_threads::is_struck() {
        if let Some(Some(link)) = take.take(Option::take) {
            drop(link);
            if !std::mem::replace(&mut wanted, true) {
                tracing::warn!("the front-end on {} is gone; the wires are off, trying to have it back", plan.port);
            }
        }
        if !wanted {
            thread::park_timeout(LOOK);
            continue;
        }
        match connect(plan) {
            // Another one's codes would mean something else.
            Ok((_, who, _)) if !same(&who, first) => {
                tell(
                    &mut said,
                    &format!("another front-end is on {}: {}; start anew to use it", plan.port, name(&who)),
                );
            }
            Ok((link, who, _)) => {
                wanted = false;
                said.clear();
                LineFigures::count(&figures.connections);
                tracing::warn!(
                    "the front-end on {} is back, {}; channels stay off until they are reset",
                    plan.port,
                    started(&who)
                );
                give.push(Some(link));
                continue;
            }
            Err(error) => tell(&mut said, &error.to_string()),
        }
        thread::park_timeout(RETRY);
    }
}

fn same(one: &Identification, other: &Identification) -> bool {
    let Identification { nonce, reset, user, unused_ms, .. } = *one;
    *one == Identification { nonce, reset, user, unused_ms, ..*other }
}

/// Says something once, however often it is tried in vain.
fn tell(said: &mut String, what: &str) {
    if said != what {
        tracing::warn!("{what}");
        *said = what.to_string();
    }
}
