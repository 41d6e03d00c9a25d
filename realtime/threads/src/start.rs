//! How a thread is started, and what happens when it dies.

use std::io;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::{Builder, JoinHandle};

use crate::notice::caught_with;
use crate::strike;
use crate::table::{Comes, Thread};

/// Threads of this process that have died: their bits.
static DEAD: AtomicU32 = AtomicU32::new(0);

/// Which threads of this process have died, as a driver publishes it: their [bits](Thread::bit).
#[inline]
pub fn dead() -> u32 {
    DEAD.load(Ordering::Relaxed)
}

impl Thread {
    /// A way to start it: by default on the system's default stack, with an end that is in order whenever it comes, and nothing to
    /// be done at once when it dies.
    pub fn start(self) -> Start {
        Start { thread: self, stack: 0, is_over: Box::new(|| true), on_death: Box::new(|| {}) }
    }

    /// Keeps in mind that it has died: for one that catches its own panics.
    pub fn has_died(self) {
        DEAD.fetch_or(self.bit(), Ordering::Relaxed);
    }
}

/// A thread that is to be started.
#[must_use]
pub struct Start {
    thread: Thread,
    stack: usize,
    is_over: Box<dyn Fn() -> bool + Send>,
    on_death: Box<dyn FnOnce() + Send>,
}

impl Start {
    /// With a stack of so many bytes; 0 = the system's default.
    pub fn stack(self, bytes: usize) -> Start {
        Start { stack: bytes, ..self }
    }

    /// Its end is in order if this says so then: it was asked to end, or its work is done. Else it has died.
    pub fn ends_when(self, is_over: impl Fn() -> bool + Send + 'static) -> Start {
        Start { is_over: Box::new(is_over), ..self }
    }

    /// Done at once when it dies, after a panic before anything is unwound: nothing that waits, locks or may panic.
    pub fn on_death(self, act: impl FnOnce() + Send + 'static) -> Start {
        Start { on_death: Box::new(act), ..self }
    }

    /// Starts it. What it gives is `None` when it died.
    ///
    /// # Errors
    /// The system's, when there are no more threads.
    pub fn spawn<T: Send + 'static>(
        self,
        body: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<JoinHandle<Option<T>>> {
        strike::watch();
        let builder = Builder::new().name(format!("sinew-{}", self.thread.row().name));
        let builder = if self.stack > 0 { builder.stack_size(self.stack) } else { builder };
        builder.spawn(move || self.run(body))
    }

    /// Lets the present thread be it. `None` when it died.
    pub fn run<T>(self, body: impl FnOnce() -> T) -> Option<T> {
        let Start { thread, is_over, on_death, .. } = self;
        // A panic takes it, an end that is not in order finds it still there.
        let act = std::rc::Rc::new(std::cell::Cell::new(Some(on_death)));
        let for_hook = act.clone();
        let at_once = move || {
            thread.has_died();
            for_hook.take().into_iter().for_each(|act| act());
        };
        strike::this_is(Some(thread));
        let result = caught_with(Some(Box::new(at_once)), body);
        strike::this_is(None);
        let how = match result {
            Ok(done) if is_over() => return Some(done),
            Ok(_) => {
                thread.has_died();
                act.take().into_iter().for_each(|act| act());
                "it ended by itself".to_string()
            }
            Err(words) => words,
        };
        let row = thread.row();
        match row.comes {
            Comes::End => tracing::error!("the thread that {} has died: {how}; {}", row.does, row.words),
            Comes::Less => tracing::warn!("the thread that {} has died: {how}; {}", row.does, row.words),
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn an_end_in_order_is_no_death_and_one_that_is_not_is_one() {
        for is_over in [true, false] {
            let acted = Arc::new(AtomicBool::new(false));
            let act = acted.clone();
            let start = Thread::Mender.start().ends_when(move || is_over);
            let worked = start.on_death(move || act.store(true, Ordering::Relaxed)).spawn(|| 7).unwrap();
            assert_eq!(worked.join().unwrap(), is_over.then_some(7));
            assert_eq!(acted.load(Ordering::Relaxed), !is_over);
            assert_eq!(dead() & Thread::Mender.bit() != 0, !is_over);
        }
    }
}
