//! The server: a WebSocket for each viewer.

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::Router;
use axum::extract::ws::close_code;
use axum::extract::{ConnectInfo, State, WebSocketUpgrade};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use sinew_server::{Limits, Line, Port, Refusal, Traffic, listen, serve, turn_away};
use sinew_threads::Thread;

use super::feed::{Feed, Feeding};
use super::protocol::SUBPROTOCOLS;
use super::session;
use crate::finder::Finder;
use crate::watch::watch;
use crate::{Error, Options};

/// A bridge to Foxglove that is open: its port is taken.
pub struct Foxglove {
    feed: Arc<Feed>,
    finder: Finder,
    rate_hz: Option<f64>,
    listener: TcpListener,
    address: SocketAddr,
}

impl Foxglove {
    /// Takes the port. The driver need not be there yet. Of its cycles every one is sent, or at most `rate_hz` a second.
    ///
    /// # Errors
    /// [`Error::Rig`], [`Error::Address`].
    pub fn open(options: &Options, rate_hz: Option<f64>) -> Result<Foxglove, Error> {
        let finder = Finder::new(&options.rig).map_err(Error::Rig)?;
        let refused = |e: std::io::Error| Error::Address { address: options.listen, reason: e.to_string() };
        let listener = listen(options.listen).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        Ok(Foxglove { feed: Arc::new(Feed::new(&options.rig, Limits::default())), finder, rate_hz, listener, address })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Who is connected and what was refused, to be read at any time: also after [`serve`](Foxglove::serve).
    pub fn traffic(&self) -> Arc<Traffic> {
        self.feed.traffic.clone()
    }

    /// Reads how many messages viewers have lost because they were too slow, at any time.
    pub fn lost(&self) -> impl Fn() -> u64 + use<> {
        let feed = self.feed.clone();
        move || feed.lost.load(Ordering::Relaxed)
    }

    /// Serves until `stop` says so.
    ///
    /// # Errors
    /// [`Error::System`] when there is no thread or event loop to be had, [`Error::Died`] when the one that watches has died.
    pub fn serve(self, stop: impl Fn() -> bool) -> Result<(), Error> {
        let system = |e: std::io::Error| Error::System { reason: e.to_string() };
        let Foxglove { feed, finder, rate_hz, listener, .. } = self;
        let watcher = {
            let (over, mut feeding) = (feed.clone(), Feeding { feed: feed.clone(), numbers: [0; 3] });
            let start = Thread::Watcher.start().ends_when(move || over.stop.load(Ordering::Relaxed));
            start.spawn(move || watch(&mut feeding, finder, rate_hz)).map_err(system)?
        };
        let router = Router::new().route("/", get(connected)).with_state(feed.clone());
        let port = Port { listener, router, traffic: feed.traffic.clone(), certificate: None };
        let served = serve([port], || stop() || watcher.is_finished());
        feed.stop.store(true, Ordering::Relaxed);
        let is_watched = watcher.join().is_ok_and(|watched| watched.is_some());
        served.map_err(system)?;
        if is_watched { Ok(()) } else { Err(Error::Died(Thread::Watcher)) }
    }
}

async fn connected(
    State(feed): State<Arc<Feed>>,
    ConnectInfo(line): ConnectInfo<Line>,
    socket: WebSocketUpgrade,
) -> Response {
    let longest = feed.traffic.limits().message;
    let socket = socket.max_message_size(longest).max_frame_size(longest).protocols(SUBPROTOCOLS);
    if socket.selected_protocol().is_none() {
        feed.traffic.refuse(Refusal::OddMessages);
        let words = format!("this speaks {}\n", SUBPROTOCOLS.join(" and "));
        return (StatusCode::BAD_REQUEST, words).into_response();
    }
    let Some(place) = feed.traffic.open_client() else {
        return socket.on_upgrade(|socket| turn_away(socket, close_code::AGAIN, Refusal::ClientsAtOnce));
    };
    socket.on_upgrade(move |socket| async move {
        line.is_live();
        session::run(socket, feed, line).await;
        drop(place);
    })
}
