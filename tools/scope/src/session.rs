//! The session of one open page: curves and state to it, requests from it.
//!
//! Frames of curves are numbered and the page acknowledges each. At most [`IN_FLIGHT`] are unacknowledged, so that a page
//! that is slow, or suspended in the background, is not sent ever older curves: once ready it gets all new bins in one
//! frame, and the number of bins it missed if the history does not reach back so far.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use serde::Deserialize;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval, timeout};

use crate::command::{self, Answer, Request};
use crate::history::Series;
use crate::quantity::COUNT;
use crate::shared::Shared;
use crate::view::json;

/// Between two frames: sixty a second.
const FRAME: Duration = Duration::from_micros(16_000);
/// Frames between two looks at the state: ten a second.
const STATUS_EVERY: u32 = 6;
/// Frames that may be unacknowledged.
const IN_FLIGHT: u32 = 4;
/// A page that takes nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(30);
/// Most series a page may show at once.
const MOST_SERIES: usize = 64 * COUNT;

/// What a page sends.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Said {
    /// The token it was opened with.
    Token { token: String },
    /// What it shows from now on, as `[channel, quantity]`; `generation` comes back with every frame of it.
    Show { generation: u32, series: Vec<[usize; 2]> },
    /// It has drawn up to this frame.
    Seen { frame: u32 },
    /// Anything for the driver or the recorder; `id` comes back with the answer.
    Ask { id: u32, what: Request },
}

/// What it shows, and how far it has got.
struct Shown {
    generation: u32,
    series: Vec<Series>,
    epoch: u64,
    /// Number of the next bin to be sent.
    next: u64,
    /// Bins that were gone before they could be sent.
    lost: u64,
    sent: u32,
    seen: u32,
}

/// Serves a page until it goes.
pub async fn run(mut socket: WebSocket, shared: Arc<Shared>) {
    let mut may_command = false;
    let mut shown = Shown { generation: 0, series: Vec::new(), epoch: 0, next: 0, lost: 0, sent: 0, seen: 0 };
    let (answers, mut answered) = mpsc::unbounded_channel::<Answer>();
    let mut frames = interval(FRAME);
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut count = 0;
    loop {
        let sent = tokio::select! {
            said = socket.recv() => {
                let Some(Ok(message)) = said else { return };
                let Message::Text(text) = message else { continue };
                match serde_json::from_str(&text) {
                    Ok(Said::Token { token }) => {
                        may_command = shared.options.commands && shared.token.matches(&token);
                        send(&mut socket, json(&serde_json::json!({ "kind": "may", "command": may_command }))).await
                    }
                    Ok(Said::Show { generation, series }) => {
                        shown.show(generation, series);
                        true
                    }
                    Ok(Said::Seen { frame }) => {
                        shown.seen = frame;
                        true
                    }
                    Ok(Said::Ask { id, what }) => {
                        command::ask(&shared, may_command, id, what, answers.clone());
                        true
                    }
                    // a page of another version, or none of ours
                    Err(_) => return,
                }
            }
            Some(answer) = answered.recv() => send(&mut socket, json(&answer)).await,
            _ = frames.tick() => {
                let due = count % STATUS_EVERY == 0;
                count += 1;
                let (hello, status, frame) = shown.look(&shared, due);
                (match hello { Some(hello) => send(&mut socket, hello).await, None => true })
                    && (match status { Some(status) => send(&mut socket, status).await, None => true })
                    && match frame { Some(frame) => send(&mut socket, frame).await, None => true }
            }
        };
        if !sent {
            return;
        }
    }
}

async fn send(socket: &mut WebSocket, message: impl Into<Message>) -> bool {
    matches!(timeout(PATIENCE, socket.send(message.into())).await, Ok(Ok(())))
}

impl Shown {
    /// Other curves: from as far back as there is.
    fn show(&mut self, generation: u32, series: Vec<[usize; 2]>) {
        self.generation = generation;
        let known = series.into_iter().filter(|[_, quantity]| *quantity < COUNT);
        self.series = known.take(MOST_SERIES).map(|[channel, quantity]| Series { channel, quantity }).collect();
        self.next = 0;
        self.lost = 0;
    }

    /// What there is to say: the driver where it is another, its state if that is due, new curves if the page is ready.
    fn look(&mut self, shared: &Shared, due: bool) -> (Option<String>, Option<String>, Option<Vec<u8>>) {
        let view = shared.view();
        let hello = (view.epoch != self.epoch).then(|| view.hello.clone());
        self.epoch = view.epoch;
        let status = due.then(|| view.status.clone());
        let history = &view.history;
        let idle = self.series.is_empty() || history.next() <= self.next.max(history.first());
        if hello.is_some() || idle || self.sent.wrapping_sub(self.seen) >= IN_FLIGHT {
            return (hello, status, None);
        }
        let channels = history.shape().channels;
        self.series.retain(|series| series.channel < channels);
        if self.next > 0 {
            self.lost += history.first().saturating_sub(self.next);
        }
        self.sent = self.sent.wrapping_add(1);
        let mut frame = Vec::new();
        // the header, of which the count of bins is filled in below: a whole number of f64 long
        for word in [self.generation, self.sent, self.series.len() as u32, 0, history.shape().values() as u32, 0] {
            frame.extend_from_slice(&word.to_le_bytes());
        }
        frame.extend_from_slice(&(self.lost as f64).to_le_bytes());
        let bins = history.write(self.next, &self.series, &mut frame);
        frame[12..16].copy_from_slice(&(bins as u32).to_le_bytes());
        self.next = history.next();
        (hello, status, Some(frame))
    }
}
