//! What the watching thread, the server and the pages share.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sinew_server::Figures;

use crate::Options;
use crate::access::Token;
use crate::entrance::{Entrance, Event};
use crate::record::Button;
use crate::view::View;

/// Draws the machine as it is when called, as JSON: [`Scope::with_picture`](crate::Scope::with_picture).
pub(crate) type Picture = Box<dyn Fn() -> String + Send + Sync>;

/// Is told what happens on the network: [`Scope::with_events`](crate::Scope::with_events).
pub(crate) type Events = Box<dyn Fn(&Event) + Send + Sync>;

/// What the watching thread, the server and the pages share.
pub struct Shared {
    /// Of the rig, or of the stream.
    pub name: String,
    pub options: Options,
    pub token: Token,
    pub loopback: Arc<Entrance>,
    pub network: Option<Arc<Entrance>>,
    pub stop: AtomicBool,
    pub recorder: Mutex<Button>,
    pub(crate) picture: Option<Picture>,
    pub(crate) events: Option<Events>,
    pub(crate) view: Mutex<View>,
    /// Time 0 of the curves, CLOCK_MONOTONIC, ns.
    pub(crate) origin_ns: u64,
}

/// What is behind an entrance, and the entrance: what all that serves a page needs.
#[derive(Clone)]
pub struct Way {
    pub shared: Arc<Shared>,
    pub entrance: Arc<Entrance>,
}

impl Shared {
    /// The driver as it is seen now.
    pub fn view(&self) -> MutexGuard<'_, View> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Who is connected and what was refused, by all ways in.
    pub fn figures(&self) -> Figures {
        figures(&self.loopback, self.network.as_deref())
    }

    /// A moment of CLOCK_MONOTONIC on the curves' axis, s.
    pub fn seconds(&self, monotonic_ns: u64) -> f64 {
        (monotonic_ns as f64 - self.origin_ns as f64) * 1e-9
    }
}

/// Who is connected and what was refused, by both ways in.
pub fn figures(loopback: &Entrance, network: Option<&Entrance>) -> Figures {
    let figures = loopback.traffic.figures();
    match network {
        None => figures,
        Some(network) => figures + network.traffic.figures(),
    }
}
