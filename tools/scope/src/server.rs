//! The server: the page's files and the WebSocket.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::extract::ws::close_code;
use axum::extract::{ConnectInfo, Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use sinew_ipc::{Client, CycleStream};
use sinew_server::{Limits, Line, Refusal, Traffic, listen, serve, turn_away};
use sinew_threads::Thread;

use crate::access::{AccessControl, Token};
use crate::history::FINEST_HZ;
use crate::record::Button;
use crate::shared::Shared;
use crate::stream::{self, Stream};
use crate::view::{View, json};
use crate::watch::watch;
use crate::{Error, Options, page, session};

/// A scope that is open: its port is taken, its source found.
pub struct Scope {
    shared: Shared,
    listener: TcpListener,
    source: Source,
    port: u16,
}

/// Where what is shown comes from.
enum Source {
    Driver(CycleStream),
    Stream(Stream),
}

impl Scope {
    /// Of the driver of this rig, through all its restarts: finds it and takes the port.
    ///
    /// # Errors
    /// [`Error::Driver`] when it does not run, [`Error::Port`] when the port is taken, [`Error::Random`].
    pub fn open(rig: &str, options: Options) -> Result<Scope, Error> {
        let client = Client::connect(rig).map_err(Error::Driver)?;
        let source = Source::Driver(client.stream().map_err(Error::Driver)?);
        let view = View::new(Arc::new(client), options.commands);
        let button = Button::of_driver(&options.record_dir, rig);
        Scope::of(rig, source, view, button, options)
    }

    /// Of a stream of numbers: takes the port.
    ///
    /// # Errors
    /// [`Error::Port`] when the port is taken, [`Error::Random`].
    pub fn plot(stream: Stream, options: Options) -> Result<Scope, Error> {
        let name = stream.name().to_string();
        let mut view = View::of(stream::shape(0, FINEST_HZ));
        let records = options.commands;
        view.begin(stream::shape(0, FINEST_HZ), |shape, epoch| stream::hello(&name, &[], records, shape, epoch));
        let button = Button::of_stream(&options.record_dir, &name);
        Scope::of(&name, Source::Stream(stream), view, button, options)
    }

    fn of(name: &str, source: Source, view: View, button: Button, options: Options) -> Result<Scope, Error> {
        let refused = |e: std::io::Error| Error::Port { port: options.port, reason: e.to_string() };
        let listener = listen((Ipv4Addr::LOCALHOST, options.port).into()).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        let shared = Shared {
            name: name.to_string(),
            token: Token::new()?,
            access: AccessControl::new(port),
            traffic: Arc::new(Traffic::new(Limits::default())),
            stop: AtomicBool::new(false),
            recorder: Mutex::new(button),
            picture: None,
            view: Mutex::new(view),
            origin_ns: sinew_ipc::monotonic_ns(),
            options,
        };
        Ok(Scope { shared, listener, source, port })
    }

    /// With a picture of the machine above the curves: `picture` draws it as it is at the moment of the call, as JSON.
    ///
    /// ```json
    /// {
    ///   "shapes": [
    ///     {"line": [-0.1, 0.0, 0.1, 0.01], "width": 0.004, "ink": "body"},
    ///     {"disc": [0.03, 0.02], "radius": 0.012, "ink": "load"}
    ///   ],
    ///   "half_size": [0.15, 0.06],
    ///   "says": "ball +30.0 mm, beam +2.9°"
    /// }
    /// ```
    ///
    /// Everything is in metres, x to the right, y up, from the middle of the picture, of which `half_size` is half the width
    /// and half the height. What comes first is hindmost. Lines, from `x0, y0` to `x1, y1`, have round ends. An ink is one of
    /// `frame` (what stands still), `body` (what moves), `wire`, `load` and `goal`. What `says` is written beneath, and is
    /// all that whoever does not see the page has of it.
    ///
    /// The scope passes it on as it is, 31 times a second at most to each page, and only if it differs from the last one. It
    /// is called by the thread that serves all pages: it has to return at once, and must not panic.
    pub fn with_picture(mut self, picture: impl Fn() -> String + Send + Sync + 'static) -> Scope {
        self.shared.picture = Some(Box::new(picture));
        self
    }

    /// The page's address. With the token it may command; without, whoever has it may look.
    pub fn url(&self, token: bool) -> String {
        let token = if token { format!("#{}", self.shared.token.as_str()) } else { String::new() };
        format!("http://127.0.0.1:{}/{token}", self.port)
    }

    /// Who is connected and what was refused, to be read at any time: also after [`serve`](Scope::serve).
    pub fn traffic(&self) -> Arc<Traffic> {
        self.shared.traffic.clone()
    }

    /// Serves until `stop` says so. A recording that runs is ended in order.
    ///
    /// # Errors
    /// [`Error::System`] when there is no thread or event loop to be had, [`Error::Died`] when the one that watches has died.
    pub fn serve(self, stop: impl Fn() -> bool) -> Result<(), Error> {
        let system = |e: std::io::Error| Error::System { reason: e.to_string() };
        let Scope { shared, listener, source, .. } = self;
        let shared = Arc::new(shared);
        let watcher = {
            let (over, shared) = (shared.clone(), shared.clone());
            let start = Thread::Watcher.start().ends_when(move || over.stop.load(Ordering::Relaxed));
            let watched = move || match source {
                Source::Driver(cycles) => watch(&shared, cycles),
                Source::Stream(stream) => stream::watch(&shared, stream),
            };
            start.spawn(watched).map_err(system)?
        };
        let is_over = || stop() || watcher.is_finished();
        let served = serve(listener, router(shared.clone()), shared.traffic.clone(), is_over);
        shared.stop.store(true, Ordering::Relaxed);
        let is_watched = watcher.join().is_ok_and(|watched| watched.is_some());
        // a running recording is completed; without one there is nothing to report
        let _ = shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).stop();
        served.map_err(system)?;
        if is_watched { Ok(()) } else { Err(Error::Died(Thread::Watcher)) }
    }
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = Router::new().route("/live", get(live)).route("/figures", get(figures));
    for file in &page::FILES {
        router = router.route(file.path, get(|| async { ([(header::CONTENT_TYPE, file.kind)], file.text) }));
    }
    router.layer(from_fn_with_state(shared.clone(), guard)).with_state(shared)
}

/// Rejects requests for other hosts, and adds the security headers to every response.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = if shared.access.accepts_request(request.headers()) {
        next.run(request).await
    } else {
        shared.traffic.refuse(Refusal::ForeignHosts);
        (
            StatusCode::MISDIRECTED_REQUEST,
            "this is not the host you think it is: open the address as `sinew scope` has printed it\n",
        )
            .into_response()
    };
    response.headers_mut().extend(shared.access.headers());
    response
}

/// The scope's own figures, as JSON.
async fn figures(State(shared): State<Arc<Shared>>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], json(&shared.traffic.figures())).into_response()
}

async fn live(
    State(shared): State<Arc<Shared>>,
    ConnectInfo(line): ConnectInfo<Line>,
    headers: HeaderMap,
    socket: WebSocketUpgrade,
) -> Response {
    if !shared.access.accepts_websocket(&headers) {
        shared.traffic.refuse(Refusal::ForeignOrigins);
        return (StatusCode::FORBIDDEN, "only the scope's own page may connect\n").into_response();
    }
    let longest = shared.traffic.limits().message;
    let socket = socket.max_message_size(longest).max_frame_size(longest);
    let Some(place) = shared.traffic.open_client() else {
        // a browser shows no page the answer to a WebSocket's request, but the reason for which it was closed
        return socket.on_upgrade(|socket| turn_away(socket, close_code::AGAIN, Refusal::ClientsAtOnce));
    };
    socket.on_upgrade(move |socket| async move {
        line.is_live();
        session::run(socket, shared, line).await;
        drop(place);
    })
}

#[cfg(test)]
mod tests;
