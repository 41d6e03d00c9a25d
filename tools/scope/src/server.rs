//! The server: the page's files and the WebSocket, on loopback and on the network.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::extract::{ConnectInfo, Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use sinew_ipc::{Client, CycleStream};
use sinew_server::{Certificate, Figures, Limits, Line, Port, Refusal, Traffic, listen, serve};
use sinew_threads::Thread;

use crate::access::{AccessControl, Token, numbered};
use crate::entrance::{Entrance, Event, Invitation};
use crate::history::FINEST_HZ;
use crate::lock::Lock;
use crate::record::Button;
use crate::shared::{self, Shared, Way};
use crate::stream::{self, Stream};
use crate::view::{View, json};
use crate::watch::watch;
use crate::{Error, Network, Options, page, session};

/// A scope that is open: its port is taken, its source found.
pub struct Scope {
    shared: Shared,
    listener: TcpListener,
    network: Option<Taken>,
    source: Source,
    port: u16,
}

/// A port on the network.
struct Taken {
    listener: TcpListener,
    certificate: Certificate,
    invitation: Invitation,
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
    /// [`Error::Driver`] when it does not run, [`Error::Port`] and [`Error::Address`] when a port is taken, [`Error::Certificate`],
    /// [`Error::Random`].
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
    /// [`Error::Port`] and [`Error::Address`] when a port is taken, [`Error::Certificate`], [`Error::Random`].
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
        let (network, entrance) = options.network.as_ref().map(take).transpose()?.unzip();
        let shared = Shared {
            name: name.to_string(),
            token: Token::new()?,
            loopback: Arc::new(Entrance {
                access: AccessControl::loopback(port),
                traffic: Arc::new(Traffic::new(Limits::default())),
                lock: None,
            }),
            network: entrance.map(Arc::new),
            stop: AtomicBool::new(false),
            recorder: Mutex::new(button),
            picture: None,
            events: None,
            view: Mutex::new(view),
            origin_ns: sinew_ipc::monotonic_ns(),
            options,
        };
        Ok(Scope { shared, listener, network, source, port })
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

    /// Tells what happens on the network. It is called by the thread that serves all pages: it has to return at once, and must not panic.
    pub fn with_events(mut self, events: impl Fn(&Event) + Send + Sync + 'static) -> Scope {
        self.shared.events = Some(Box::new(events));
        self
    }

    /// What those on the network need to come in, if they may.
    pub fn invitation(&self) -> Option<&Invitation> {
        self.network.as_ref().map(|network| &network.invitation)
    }

    /// The page's address on loopback. With the token it may command; without, whoever has it may look.
    pub fn url(&self, token: bool) -> String {
        let token = if token { format!("#{}", self.shared.token.as_str()) } else { String::new() };
        format!("http://127.0.0.1:{}/{token}", self.port)
    }

    /// Who is connected and what was refused, to be read at any time: also after [`serve`](Scope::serve).
    pub fn figures(&self) -> impl Fn() -> Figures + use<> {
        let (loopback, network) = (self.shared.loopback.clone(), self.shared.network.clone());
        move || shared::figures(&loopback, network.as_deref())
    }

    /// Serves until `stop` says so. A recording that runs is ended in order.
    ///
    /// # Errors
    /// [`Error::System`] when there is no thread or event loop to be had, [`Error::Died`] when the one that watches has died.
    pub fn serve(self, stop: impl Fn() -> bool) -> Result<(), Error> {
        let system = |e: std::io::Error| Error::System { reason: e.to_string() };
        let Scope { shared, listener, network, source, .. } = self;
        let shared = Arc::new(shared);
        let ports = ports(&shared, listener, network.map(|taken| (taken.listener, taken.certificate)));
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
        let served = serve(ports, is_over);
        shared.stop.store(true, Ordering::Relaxed);
        let is_watched = watcher.join().is_ok_and(|watched| watched.is_some());
        // a running recording is completed; without one there is nothing to report
        let _ = shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).stop();
        served.map_err(system)?;
        if is_watched { Ok(()) } else { Err(Error::Died(Thread::Watcher)) }
    }
}

/// Takes the port on the network.
fn take(network: &Network) -> Result<(Taken, Entrance), Error> {
    let refused = |e: std::io::Error| Error::Address { address: network.listen, reason: e.to_string() };
    let listener = listen(network.listen).map_err(refused)?;
    let port = listener.local_addr().map_err(refused)?.port();
    let addresses = sinew_server::addresses(network.listen.ip()).map_err(refused)?;
    let names = sinew_server::names();
    let known: Vec<String> = names.iter().cloned().chain(addresses.iter().map(ToString::to_string)).collect();
    let certificate = Certificate::kept(&network.certificate, &known)
        .map_err(|e| Error::Certificate { path: network.certificate.clone(), reason: e.to_string() })?;
    let limits = Limits::default();
    let lock = Lock::new(limits.pins, network.commands)?;
    let access = AccessControl::network(&names, port);
    let numbers = addresses.iter().map(|address| format!("https://{}/", numbered((*address, port).into())));
    let invitation = Invitation {
        urls: numbers.chain(access.urls()).collect(),
        pin: lock.pin().spaced(),
        fingerprint: certificate.fingerprint(),
        is_new: certificate.is_new(),
    };
    let entrance = Entrance { access, traffic: Arc::new(Traffic::new(limits)), lock: Some(lock) };
    Ok((Taken { listener, certificate, invitation }, entrance))
}

/// The ports to be served: that on loopback, and that on the network if there is one.
fn ports(shared: &Arc<Shared>, loopback: TcpListener, network: Option<(TcpListener, Certificate)>) -> Vec<Port> {
    let port = |listener, entrance: &Arc<Entrance>, certificate| {
        let way = Way { shared: shared.clone(), entrance: entrance.clone() };
        Port { listener, traffic: entrance.traffic.clone(), router: router(way), certificate }
    };
    let mut ports = vec![port(loopback, &shared.loopback, None)];
    if let (Some((listener, certificate)), Some(entrance)) = (network, &shared.network) {
        ports.push(port(listener, entrance, Some(certificate)));
    }
    ports
}

fn router(way: Way) -> Router {
    let mut router = Router::new().route("/live", get(live));
    // on the network nothing is shown to whoever just asks
    if way.entrance.lock.is_none() {
        router = router.route("/figures", get(figures));
    }
    for file in &page::FILES {
        router = router.route(file.path, get(|| async { ([(header::CONTENT_TYPE, file.kind)], file.text) }));
    }
    router.layer(from_fn_with_state(way.clone(), guard)).with_state(way)
}

/// Rejects requests for other hosts, sends those on that came without TLS where there has to be, and adds the security headers to every
/// response.
async fn guard(State(way): State<Way>, ConnectInfo(line): ConnectInfo<Line>, request: Request, next: Next) -> Response {
    let Entrance { access, traffic, lock } = &*way.entrance;
    let host = access.host(request.headers(), line.reached());
    let mut response = match &host {
        None => {
            traffic.refuse(Refusal::ForeignHosts);
            (
                StatusCode::MISDIRECTED_REQUEST,
                "this is not the host you think it is: open the address as `sinew scope` has printed it\n",
            )
                .into_response()
        }
        Some(host) if lock.is_some() && !line.is_secured() => {
            let url = format!("https://{host}/");
            let words = format!("on the network this is to be had by HTTPS alone: {url}\n");
            (StatusCode::TEMPORARY_REDIRECT, [(header::LOCATION, url)], words).into_response()
        }
        Some(_) => next.run(request).await,
    };
    response.headers_mut().extend(access.headers(host.as_deref()));
    response
}

/// The scope's own figures, as JSON.
async fn figures(State(way): State<Way>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], json(&way.shared.figures())).into_response()
}

async fn live(
    State(way): State<Way>,
    ConnectInfo(line): ConnectInfo<Line>,
    headers: HeaderMap,
    socket: WebSocketUpgrade,
) -> Response {
    let Entrance { access, traffic, .. } = &*way.entrance;
    if !access.accepts_websocket(&headers, line.reached()) {
        traffic.refuse(Refusal::ForeignOrigins);
        return (StatusCode::FORBIDDEN, "only the scope's own page may connect\n").into_response();
    }
    let longest = traffic.limits().message;
    let socket = socket.max_message_size(longest).max_frame_size(longest);
    socket.on_upgrade(|socket| session::run(socket, way, line))
}

#[cfg(test)]
mod tests;
