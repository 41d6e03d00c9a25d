//! Long work for Python: with the interpreter's lock released, its progress told and Ctrl-C obeyed.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pyo3::prelude::*;

/// So often Python is asked whether somebody has pressed Ctrl-C, and told how far the work is.
const LOOK: Duration = Duration::from_millis(50);

/// What ends work that nobody waits for any more: it unwinds from where it tells its progress.
struct Interrupted;

/// Runs `work` on a thread of its own and waits for it. `progress` is called with the stage and how far it is, 0..1, on the thread
/// that waits; what it raises ends the work, as Ctrl-C does.
pub fn wait<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&(dyn Fn(&str, f64) + Sync)) -> T + Send,
) -> PyResult<T> {
    let is_unwanted = AtomicBool::new(false);
    let told: Mutex<Option<(String, f64)>> = Mutex::new(None);
    let tell = |stage: &str, share: f64| {
        if is_unwanted.load(Ordering::Relaxed) {
            panic::resume_unwind(Box::new(Interrupted));
        }
        if let Ok(mut told) = told.lock() {
            *told = Some((stage.to_string(), share));
        }
    };
    let look = || -> PyResult<()> {
        py.check_signals()?;
        let news = told.lock().ok().and_then(|mut told| told.take());
        match (progress, news) {
            (Some(progress), Some(news)) => progress.call1(news).map(drop),
            _ => Ok(()),
        }
    };
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| panic::catch_unwind(AssertUnwindSafe(|| work(&tell))));
        let mut asked = Ok(());
        while !worker.is_finished() {
            py.detach(|| std::thread::sleep(LOOK));
            if asked.is_ok() {
                asked = look();
                is_unwanted.store(asked.is_err(), Ordering::Relaxed);
            }
        }
        let done = worker.join().unwrap_or_else(Err);
        asked?;
        match done {
            Ok(value) => Ok(value),
            Err(panicked) => panic::resume_unwind(panicked),
        }
    })
}
