//! One connection: ended where it stalls or sends too much.
//!
//! A connection carries one request, and becomes a live client's or ends in time: neither one that sends nothing nor one that
//! sends a byte now and then (slowloris) keeps its place. The check is in the connection itself, beneath TLS and HTTP, which have no
//! timeout of their own here; it waits for nobody else.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Instant;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::{Sleep, sleep};

use crate::limits::Allowance;
use crate::traffic::{Refusal, Traffic};

/// What a connection and those who serve it tell each other.
#[derive(Debug, Clone)]
pub struct Line(Arc<Flags>);

#[derive(Debug)]
struct Flags {
    /// Who is at its other end, and which of our addresses they have reached.
    ends: Option<(SocketAddr, SocketAddr)>,
    secure: AtomicBool,
    live: AtomicBool,
    left: AtomicBool,
    refused: AtomicBool,
}

impl Line {
    fn of(stream: &TcpStream, peer: SocketAddr) -> Line {
        let [secure, live, left, refused] = [const { AtomicBool::new(false) }; 4];
        let ends = stream.local_addr().ok().map(|own| (plain(peer), plain(own)));
        Line(Arc::new(Flags { ends, secure, live, left, refused }))
    }

    /// Where it comes from.
    pub fn peer(&self) -> Option<SocketAddr> {
        self.0.ends.map(|(peer, _)| peer)
    }

    /// The address of this machine that was reached.
    pub fn reached(&self) -> Option<SocketAddr> {
        self.0.ends.map(|(_, own)| own)
    }

    pub(crate) fn is_secure(&self) {
        self.0.secure.store(true, Ordering::Relaxed);
    }

    /// Whether nobody on the way reads or changes what it carries: it goes through TLS.
    pub fn is_secured(&self) -> bool {
        self.0.secure.load(Ordering::Relaxed)
    }

    /// It is a live client's from here on, which may last.
    pub fn is_live(&self) {
        self.0.live.store(true, Ordering::Relaxed);
    }

    /// What is amiss with it has been counted: nothing that comes on it counts again.
    pub fn is_refused(&self) {
        self.0.refused.store(true, Ordering::Relaxed);
    }

    /// Whether it has ended: the other side closed it, or it was refused and that has been counted.
    pub fn is_over(&self) -> bool {
        self.0.left.load(Ordering::Relaxed) || self.0.refused.load(Ordering::Relaxed)
    }
}

/// As users write it: an address of IPv4 as such, also where it comes in through a socket of IPv6.
fn plain(address: SocketAddr) -> SocketAddr {
    SocketAddr::new(address.ip().to_canonical(), address.port())
}

/// One connection.
pub struct Connection {
    stream: TcpStream,
    traffic: Arc<Traffic>,
    line: Line,
    bytes: Allowance,
    deadline: Pin<Box<Sleep>>,
    _place: OwnedSemaphorePermit,
}

impl Connection {
    pub(crate) fn new(
        stream: TcpStream,
        peer: SocketAddr,
        traffic: Arc<Traffic>,
        place: OwnedSemaphorePermit,
    ) -> Connection {
        let bytes = Allowance::new(traffic.limits().bytes, Instant::now());
        let deadline = Box::pin(sleep(traffic.limits().request));
        let line = Line::of(&stream, peer);
        Connection { stream, traffic, line, bytes, deadline, _place: place }
    }

    pub(crate) fn line(&self) -> &Line {
        &self.line
    }

    /// The first byte that comes, which is still there to be read.
    pub(crate) fn poll_first(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<u8>> {
        self.is_in_time(cx)?;
        let mut byte = [0];
        let mut into = ReadBuf::new(&mut byte);
        if ready!(self.stream.poll_peek(cx, &mut into))? == 0 {
            self.line.0.left.store(true, Ordering::Relaxed);
            return Poll::Ready(Err(io::ErrorKind::UnexpectedEof.into()));
        }
        Poll::Ready(Ok(byte[0]))
    }

    /// Ends it; counted once, however often it is asked afterwards.
    fn refuse(&self, what: Refusal) -> io::Error {
        if !self.line.0.refused.swap(true, Ordering::Relaxed) {
            self.traffic.refuse(what);
        }
        io::Error::new(io::ErrorKind::TimedOut, what.words())
    }

    /// An error once it has lasted too long. Wakes whoever asks when that is so.
    fn is_in_time(&mut self, cx: &mut Context<'_>) -> io::Result<()> {
        let late = !self.line.0.live.load(Ordering::Relaxed) && self.deadline.as_mut().poll(cx).is_ready();
        if late { Err(self.refuse(Refusal::StalledConnections)) } else { Ok(()) }
    }
}

impl AsyncRead for Connection {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        self.is_in_time(cx)?;
        let (before, room) = (into.filled().len(), into.remaining());
        let read = ready!(Pin::new(&mut self.stream).poll_read(cx, into));
        let bytes = into.filled().len() - before;
        if read.is_err() || (bytes == 0 && room > 0) {
            self.line.0.left.store(true, Ordering::Relaxed);
        } else if !self.bytes.take(bytes as f64, Instant::now()) {
            return Poll::Ready(Err(self.refuse(Refusal::BytesASecond)));
        }
        Poll::Ready(read)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.is_in_time(cx)?;
        Pin::new(&mut self.stream).poll_write(cx, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.is_in_time(cx)?;
        Pin::new(&mut self.stream).poll_write_vectored(cx, bytes)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}
