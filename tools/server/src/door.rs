//! The door: accepts connections within the limits.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Instant;

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::net::TcpListener;
use tokio_rustls::TlsAcceptor;

use crate::certificate::Certificate;
use crate::channel::Channel;
use crate::connection::{Connection, Line};
use crate::limits::Allowance;
use crate::traffic::{Refusal, Traffic};

/// Where connections come in.
pub struct Door {
    listener: TcpListener,
    traffic: Arc<Traffic>,
    pace: Allowance,
    tls: Option<TlsAcceptor>,
}

impl Door {
    /// At this listener; with a certificate, for TLS.
    pub fn new(listener: TcpListener, traffic: Arc<Traffic>, certificate: Option<&Certificate>) -> Door {
        let pace = Allowance::new(traffic.limits().connecting, Instant::now());
        Door { listener, traffic, pace, tls: certificate.map(Certificate::acceptor) }
    }
}

impl Listener for Door {
    type Io = Channel;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Channel, SocketAddr) {
        loop {
            // what is refused is closed without a word: whoever comes too often is not to cost more than that
            let (stream, address) = Listener::accept(&mut self.listener).await;
            if !self.pace.take(1.0, Instant::now()) {
                self.traffic.refuse(Refusal::ConnectionsASecond);
            } else if let Some(place) = self.traffic.connect() {
                let connection = Connection::new(stream, address, self.traffic.clone(), place);
                return (Channel::new(connection, self.tls.clone()), address);
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

impl Connected<IncomingStream<'_, Door>> for Line {
    fn connect_info(incoming: IncomingStream<'_, Door>) -> Line {
        incoming.io().line().clone()
    }
}
