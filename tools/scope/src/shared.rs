//! What the watching thread, the server and the pages share.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sinew_server::Traffic;

use crate::Options;
use crate::access::{AccessControl, Token};
use crate::record::Button;
use crate::view::View;

/// Draws the machine as it is when called, as JSON: [`Scope::with_picture`](crate::Scope::with_picture).
pub(crate) type Picture = Box<dyn Fn() -> String + Send + Sync>;

/// What the watching thread, the server and the pages share.
pub struct Shared {
    /// Of the rig, or of the stream.
    pub name: String,
    pub options: Options,
    pub token: Token,
    pub access: AccessControl,
    pub traffic: Arc<Traffic>,
    pub stop: AtomicBool,
    pub recorder: Mutex<Button>,
    pub(crate) picture: Option<Picture>,
    pub(crate) view: Mutex<View>,
    /// Time 0 of the curves, CLOCK_MONOTONIC, ns.
    pub(crate) origin_ns: u64,
}

impl Shared {
    /// The driver as it is seen now.
    pub fn view(&self) -> MutexGuard<'_, View> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A moment of CLOCK_MONOTONIC on the curves' axis, s.
    pub fn seconds(&self, monotonic_ns: u64) -> f64 {
        (monotonic_ns as f64 - self.origin_ns as f64) * 1e-9
    }
}
