//! Live clients: what is said to one within its bounds, and how one that does not keep to them is ended.

use std::time::{Duration, Instant};

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use tokio::time::timeout;

use crate::connection::Line;
use crate::limits::{Allowance, Limits};
use crate::traffic::{Refusal, Traffic};

/// How long a client that is turned away may take to go.
const FAREWELL: Duration = Duration::from_secs(1);

/// Why a live client has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// It has gone, or its connection was refused.
    Gone,
    /// For this, which is yet to be counted.
    Refused(Refusal),
}

/// The next thing it says, within what it is allowed. May be dropped while it waits.
///
/// # Errors
/// Its end.
pub async fn receive(socket: &mut WebSocket, line: &Line, allowed: &mut Allowance) -> Result<Message, End> {
    let message = match socket.recv().await {
        None => return Err(End::Gone),
        Some(Err(_)) if line.is_over() => return Err(End::Gone),
        Some(Err(_)) => return Err(End::Refused(Refusal::OddMessages)),
        Some(Ok(message)) => message,
    };
    if allowed.take(1.0, Instant::now()) { Ok(message) } else { Err(End::Refused(Refusal::MessagesASecond)) }
}

/// Sends one message whole, before there is another: a client that does not fetch it in time is ended.
///
/// # Errors
/// Its end.
pub async fn send(socket: &mut WebSocket, limits: &Limits, message: impl Into<Message>) -> Result<(), End> {
    match timeout(limits.patience, socket.send(message.into())).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) => Err(End::Gone),
        Err(_) => Err(End::Refused(Refusal::SlowClients)),
    }
}

/// Ends one, counts what it is refused for, and tells it.
pub async fn part(socket: WebSocket, traffic: &Traffic, line: &Line, end: End) {
    if let End::Refused(why) = end {
        traffic.refuse(why);
        line.is_refused();
        // to one that fetches nothing there is nothing to be said
        if why != Refusal::SlowClients {
            turn_away(socket, close_code::POLICY, why).await;
        }
    }
}

/// Closes one, and tells it why. Whether it listens is its own affair.
pub async fn turn_away(mut socket: WebSocket, code: u16, why: Refusal) {
    let reason = Message::Close(Some(CloseFrame { code, reason: why.words().into() }));
    let _ = timeout(FAREWELL, async {
        if socket.send(reason).await.is_ok() {
            // what it has sent meanwhile is read: closed with that unread, a socket takes back what it has said
            while let Some(Ok(_)) = socket.recv().await {}
        }
    })
    .await;
}
