//! Warnings of the driver's ordinary threads: to stderr, but not across the screen while it is up.

use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

/// What came while the screen was up; `None` while it is not.
static HELD_BACK: Mutex<Option<Vec<u8>>> = Mutex::new(None);

/// Sets up logging of warnings and errors.
pub fn start() {
    tracing_subscriber::fmt()
        .with_max_level(tracing::Level::WARN)
        .with_writer(|| Writer)
        .with_ansi(false)
        .with_target(false)
        .without_time()
        .init();
}

/// Keeps messages back until the guard is dropped, then prints them.
pub fn hold_back() -> HoldBack {
    *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
    HoldBack
}

/// Messages are kept back while this lives.
pub struct HoldBack;

impl Drop for HoldBack {
    fn drop(&mut self) {
        let held = HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner).take();
        let _ = io::stderr().write_all(&held.unwrap_or_default());
    }
}

struct Writer;

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut *HELD_BACK.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(held) => held.extend_from_slice(bytes),
            None => io::stderr().write_all(bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
