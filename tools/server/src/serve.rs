//! Serving until it is time to end.

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::Response;
use tokio::task::JoinSet;

use crate::certificate::Certificate;
use crate::connection::Line;
use crate::door::Door;
use crate::traffic::Traffic;

/// How soon a server notices that it is to stop.
const NOTICE: Duration = Duration::from_millis(50);

/// Takes a port; 0 = any that is free.
///
/// # Errors
/// The system's, when it cannot be had.
pub fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// A port that was taken, and what is to be had there. Handlers of `router` find the [`Line`] of their connection as `ConnectInfo`.
pub struct Port {
    /// Where they come in.
    pub listener: TcpListener,
    /// What they find.
    pub router: Router,
    /// What they are allowed, and what they are counted in.
    pub traffic: Arc<Traffic>,
    /// With one, TLS is spoken here. Whoever does not speak it is served all the same: by [`Line::is_secured`] the router tells him so.
    pub certificate: Option<Certificate>,
}

/// Answers whoever connects to one of these ports, on this thread, until `is_over` says that it is time.
///
/// # Errors
/// The system's, when there is no event loop to be had.
pub fn serve(ports: impl IntoIterator<Item = Port>, is_over: impl Fn() -> bool) -> std::io::Result<()> {
    tokio::runtime::Builder::new_current_thread().enable_all().build().and_then(|runtime| {
        let served = runtime.block_on(async {
            let mut answering: JoinSet<_> = ports.into_iter().map(answer).collect();
            tokio::select! {
                Some(ended) = answering.join_next() => ended.unwrap_or_else(|died| Err(std::io::Error::other(died))),
                () = async { while !is_over() { tokio::time::sleep(NOTICE).await } } => Ok(()),
            }
        });
        // what still waits for somebody else is not waited for
        runtime.shutdown_background();
        served
    })
}

/// Answers whoever connects to this port.
///
/// # Errors
/// The system's.
pub async fn answer(port: Port) -> std::io::Result<()> {
    let Port { listener, router, traffic, certificate } = port;
    let door = Door::new(tokio::net::TcpListener::from_std(listener)?, traffic, certificate.as_ref());
    let router = router.layer(from_fn(one_request));
    axum::serve(door, router.into_make_service_with_connect_info::<Line>()).await
}

/// A connection that does not become live ends with the response, so that the limits of connections are those of requests too.
async fn one_request(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    if response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}
