//! The server: a page of metrics for each scrape.

use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use prometheus_client::encoding::{prometheus_text, text};
use sinew_server::{Limits, Port, Traffic, listen, serve};

use super::metrics::{Look, registry};
use crate::finder::Finder;
use crate::{Error, Options};

/// The form of a page in which Prometheus asks for OpenMetrics.
const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// A bridge to Prometheus that is open: its port is taken.
pub struct Prometheus {
    rig: Arc<Rig>,
    listener: TcpListener,
    address: SocketAddr,
    traffic: Arc<Traffic>,
}

/// The rig that is asked about.
struct Rig {
    name: String,
    finder: Mutex<Finder>,
}

impl Prometheus {
    /// Takes the port. The driver need not be there yet.
    ///
    /// # Errors
    /// [`Error::Rig`], [`Error::Address`].
    pub fn open(options: &Options) -> Result<Prometheus, Error> {
        let finder = Finder::new(&options.rig).map_err(Error::Rig)?;
        let refused = |e: std::io::Error| Error::Address { address: options.listen, reason: e.to_string() };
        let listener = listen(options.listen).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        let rig = Arc::new(Rig { name: options.rig.clone(), finder: Mutex::new(finder) });
        Ok(Prometheus { rig, listener, address, traffic: Arc::new(Traffic::new(Limits::default())) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Who is connected and what was refused, to be read at any time: also after [`serve`](Prometheus::serve).
    pub fn traffic(&self) -> Arc<Traffic> {
        self.traffic.clone()
    }

    /// Serves until `stop` says so.
    ///
    /// # Errors
    /// [`Error::System`] when there is no event loop to be had.
    pub fn serve(self, stop: impl Fn() -> bool) -> Result<(), Error> {
        let router = Router::new().route("/", get(whereabouts)).route("/metrics", get(metrics)).with_state(self.rig);
        let port = Port { listener: self.listener, router, traffic: self.traffic, certificate: None };
        serve([port], stop).map_err(|e| Error::System { reason: e.to_string() })
    }
}

async fn whereabouts() -> &'static str {
    "the metrics are at /metrics\n"
}

async fn metrics(State(rig): State<Arc<Rig>>, headers: HeaderMap) -> Response {
    let accepted = headers.get(header::ACCEPT).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let is_open = accepted.contains("application/openmetrics-text");
    // to look for a driver means to look into folders
    let page = tokio::task::spawn_blocking(move || {
        let client = rig.finder.lock().unwrap_or_else(PoisonError::into_inner).find();
        let registry = registry(&rig.name, Look::at(client.as_deref()));
        let mut page = String::new();
        let written = match is_open {
            true => text::encode(&mut page, &registry),
            false => prometheus_text::encode(&mut page, &registry),
        };
        written.map(|()| page)
    });
    let kind = if is_open { OPEN_METRICS } else { prometheus_text::CONTENT_TYPE };
    match page.await {
        Ok(Ok(page)) => ([(header::CONTENT_TYPE, kind)], page).into_response(),
        Ok(Err(_)) | Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the metrics cannot be written\n").into_response(),
    }
}
