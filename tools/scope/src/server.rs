//! The server: the page's files and the WebSocket.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use sinew_ipc::{Client, CycleStream};

use crate::access::{AccessControl, Token};
use crate::record::Button;
use crate::shared::Shared;
use crate::view::View;
use crate::watch::watch;
use crate::{Error, Options, page, session};

/// Longest message a page may send.
const LONGEST_MESSAGE: usize = 64 << 10;
/// How soon the server notices that it is to stop.
const NOTICE: Duration = Duration::from_millis(50);

/// A scope that is open: its port is taken, its driver found.
pub struct Scope {
    shared: Arc<Shared>,
    listener: TcpListener,
    stream: CycleStream,
    port: u16,
}

impl Scope {
    /// Finds the driver and takes the port.
    ///
    /// # Errors
    /// [`Error::Driver`] when it does not run, [`Error::Port`] when the port is taken, [`Error::Random`].
    pub fn open(options: Options) -> Result<Scope, Error> {
        let client = Client::connect(&options.rig).map_err(Error::Driver)?;
        let stream = client.stream().map_err(Error::Driver)?;
        let refused = |e: std::io::Error| Error::Port { port: options.port, reason: e.to_string() };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, options.port)).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        listener.set_nonblocking(true).map_err(refused)?;
        let shared = Shared {
            token: Token::new()?,
            access: AccessControl::new(port),
            stop: AtomicBool::new(false),
            recorder: Mutex::new(Button::new(&options)),
            view: Mutex::new(View::new(Arc::new(client), options.commands)),
            origin_ns: sinew_ipc::monotonic_ns(),
            options,
        };
        Ok(Scope { shared: Arc::new(shared), listener, stream, port })
    }

    /// The page's address. With the token it may command; without, whoever has it may look.
    pub fn url(&self, token: bool) -> String {
        let token = if token { format!("#{}", self.shared.token.as_str()) } else { String::new() };
        format!("http://127.0.0.1:{}/{token}", self.port)
    }

    /// Serves until `stop` says so. A recording that runs is ended in order.
    ///
    /// # Errors
    /// [`Error::System`] when there is no thread or event loop to be had.
    pub fn serve(self, stop: impl Fn() -> bool) -> Result<(), Error> {
        let system = |e: std::io::Error| Error::System { reason: e.to_string() };
        let Scope { shared, listener, stream, .. } = self;
        let watcher = {
            let shared = shared.clone();
            let thread = std::thread::Builder::new().name("scope-watch".into());
            thread.spawn(move || watch(&shared, stream)).map_err(system)?
        };
        let served = tokio::runtime::Builder::new_current_thread().enable_all().build().and_then(|runtime| {
            let served = runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(listener)?;
                tokio::select! {
                    served = axum::serve(listener, router(shared.clone())) => served,
                    () = async { while !stop() { tokio::time::sleep(NOTICE).await } } => Ok(()),
                }
            });
            // a command that still waits for its answer is not waited for
            runtime.shutdown_background();
            served
        });
        shared.stop.store(true, Ordering::Relaxed);
        let _ = watcher.join();
        // a running recording is completed; without one there is nothing to report
        let _ = shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).stop();
        served.map_err(system)
    }
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = Router::new().route("/live", get(live));
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
        (
            StatusCode::MISDIRECTED_REQUEST,
            "this is not the host you think it is: open the address as `sinew scope` has printed it\n",
        )
            .into_response()
    };
    response.headers_mut().extend(shared.access.headers());
    response
}

async fn live(State(shared): State<Arc<Shared>>, headers: HeaderMap, socket: WebSocketUpgrade) -> Response {
    if !shared.access.accepts_websocket(&headers) {
        return (StatusCode::FORBIDDEN, "only the scope's own page may connect\n").into_response();
    }
    socket.max_message_size(LONGEST_MESSAGE).on_upgrade(move |socket| session::run(socket, shared))
}
