//! A connection as HTTP reads it: as it is, or through TLS.
//!
//! Where there is a certificate, the first byte tells TLS from an address that was typed without its `https`: the latter is served as it
//! is, and told by its [`Line`], so that whoever serves it can say where to go. Nothing is waited for here but by the connection itself:
//! a handshake takes place when it is first read, within the bounds of the connection beneath.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio_rustls::server::TlsStream;
use tokio_rustls::{Accept, TlsAcceptor};

use crate::connection::{Connection, Line};

/// What TLS begins with: a record of a handshake.
const HANDSHAKE: u8 = 22;

/// One connection.
pub struct Channel {
    line: Line,
    state: State,
}

enum State {
    Bare(Connection),
    /// Nothing has come yet.
    Met(Connection, TlsAcceptor),
    ShakingHands(Box<Accept<Connection>>),
    Secured(Box<TlsStream<Connection>>),
    Over,
}

impl Channel {
    pub(crate) fn new(connection: Connection, tls: Option<TlsAcceptor>) -> Channel {
        let line = connection.line().clone();
        let state = match tls {
            None => State::Bare(connection),
            Some(acceptor) => State::Met(connection, acceptor),
        };
        Channel { line, state }
    }

    pub(crate) fn line(&self) -> &Line {
        &self.line
    }

    /// Until it is known what it is, and hands are shaken.
    fn poll_settled(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            match &mut self.state {
                State::Bare(_) | State::Secured(_) => return Poll::Ready(Ok(())),
                State::Over => return Poll::Ready(Err(io::ErrorKind::NotConnected.into())),
                State::Met(connection, _) => {
                    let first = ready!(connection.poll_first(cx))?;
                    let State::Met(connection, acceptor) = std::mem::replace(&mut self.state, State::Over) else {
                        continue;
                    };
                    self.state = match first {
                        HANDSHAKE => State::ShakingHands(Box::new(acceptor.accept(connection))),
                        _ => State::Bare(connection),
                    };
                }
                State::ShakingHands(accept) => {
                    let shaken = ready!(Pin::new(accept).poll(cx));
                    self.state = State::Over;
                    self.state = State::Secured(Box::new(shaken?));
                    self.line.is_secure();
                }
            }
        }
    }
}

/// Polls what is beneath once it is settled.
macro_rules! settled {
    ($channel:expr, $cx:expr, $call:ident $(, $argument:expr)*) => {{
        let channel = $channel.get_mut();
        ready!(channel.poll_settled($cx))?;
        match &mut channel.state {
            State::Bare(connection) => Pin::new(connection).$call($cx $(, $argument)*),
            State::Secured(stream) => Pin::new(stream).$call($cx $(, $argument)*),
            State::Met(..) | State::ShakingHands(_) | State::Over => Poll::Ready(Err(io::ErrorKind::NotConnected.into())),
        }
    }};
}

impl AsyncRead for Channel {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        settled!(self, cx, poll_read, into)
    }
}

impl AsyncWrite for Channel {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        settled!(self, cx, poll_write, bytes)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        settled!(self, cx, poll_write_vectored, bytes)
    }

    fn is_write_vectored(&self) -> bool {
        match &self.state {
            State::Bare(connection) | State::Met(connection, _) => connection.is_write_vectored(),
            State::ShakingHands(_) | State::Secured(_) | State::Over => true,
        }
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        settled!(self, cx, poll_flush)
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        settled!(self, cx, poll_shutdown)
    }
}
