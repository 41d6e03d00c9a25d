//! The session of one open page: curves and state to it, requests from it.
//!
//! Frames of curves are numbered and the page acknowledges each. At most [`IN_FLIGHT`] are unacknowledged, so that a page
//! that is slow, or suspended in the background, is not sent ever older curves: once ready it gets all new bins, in one
//! frame unless that grows too long, and the number of bins it missed if the history does not reach back so far.
//!
//! Pictures of the machine are numbered and acknowledged with the frames: a page that is slow gets fewer, each as the
//! machine is by then.
//!
//! At most one message waits for a page. One that does not fetch it in time, sends too much, or sends what no page of
//! ours does, is ended; that is counted.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket};
use serde::Deserialize;
use sinew_server::{Allowance, End, Line, Refusal, part, receive, send};
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use crate::command::{self, Answer, Request};
use crate::history::Series;
use crate::shared::Shared;
use crate::view::json;

/// Between two frames: sixty a second.
const FRAME: Duration = Duration::from_micros(16_000);
/// Frames between two looks at the state: ten a second.
const STATUS_EVERY: u32 = 6;
/// Frames between two pictures of the machine: thirty-one a second.
const PICTURE_EVERY: u32 = 2;
/// Frames and pictures that may be unacknowledged.
const IN_FLIGHT: u32 = 4;
/// Most series a page may show at once.
const MOST_SERIES: usize = 64 * 64;

/// What a page sends.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Said {
    /// The token it was opened with.
    Token { token: String },
    /// What it shows from now on, as `[channel, quantity]`; `generation` comes back with every frame of it.
    Show { generation: u32, series: Vec<[usize; 2]> },
    /// It has taken in what came up to this frame or picture.
    Seen { frame: u32 },
    /// Anything for the driver or the recorder; `id` comes back with the answer.
    Ask { id: u32, what: Request },
}

/// What it shows, and how far it has got.
#[derive(Default)]
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
    /// The picture it has.
    picture: String,
}

/// Serves a page until it goes, or does what is refused.
pub async fn run(mut socket: WebSocket, shared: Arc<Shared>, line: Line) {
    let Err(end) = serve(&mut socket, &shared, &line).await;
    part(socket, &shared.traffic, &line, end).await;
}

async fn serve(socket: &mut WebSocket, shared: &Arc<Shared>, line: &Line) -> Result<Infallible, End> {
    let limits = shared.traffic.limits();
    let mut may_command = false;
    let mut shown = Shown::default();
    let mut allowed = Allowance::new(limits.messages, Instant::now());
    let (answers, mut answered) = mpsc::channel::<Answer>(limits.unanswered);
    let mut frames = interval(FRAME);
    frames.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut count: u32 = 0;
    loop {
        tokio::select! {
            message = receive(socket, line, &mut allowed) => {
                let message = message?;
                let text = match message {
                    Message::Text(text) => text,
                    Message::Binary(_) => return Err(End::Refused(Refusal::OddMessages)),
                    Message::Ping(_) | Message::Pong(_) | Message::Close(_) => continue,
                };
                match serde_json::from_str(&text) {
                    Ok(Said::Token { token }) => {
                        let right = shared.token.matches(&token);
                        if !right {
                            shared.traffic.refuse(Refusal::WrongTokens);
                        }
                        may_command = shared.options.commands && right;
                        let may = json(&serde_json::json!({ "kind": "may", "command": may_command }));
                        send(socket, limits, may).await?;
                    }
                    Ok(Said::Show { generation, series }) => shown.show(generation, series),
                    Ok(Said::Seen { frame }) => shown.seen = frame,
                    // its answer has a place before it is asked: what waits for a page does not grow
                    Ok(Said::Ask { id, what }) => match answers.clone().try_reserve_owned() {
                        Ok(place) => command::ask(shared, may_command, id, what, place),
                        Err(_) => {
                            shared.traffic.refuse(Refusal::RequestsUnanswered);
                            send(socket, limits, json(&Answer::too_many(id))).await?;
                        }
                    },
                    // a page of another version, or none of ours
                    Err(_) => return Err(End::Refused(Refusal::OddMessages)),
                }
            }
            Some(answer) = answered.recv() => send(socket, limits, json(&answer)).await?,
            _ = frames.tick() => {
                // before the curves, which would else leave it no room on a page that is slow
                let picture = if count.is_multiple_of(PICTURE_EVERY) { shown.picture(shared) } else { None };
                let (hello, status, frame) = shown.look(shared, count.is_multiple_of(STATUS_EVERY));
                count = count.wrapping_add(1);
                for text in [hello, status, picture].into_iter().flatten() {
                    send(socket, limits, text).await?;
                }
                if let Some(frame) = frame {
                    send(socket, limits, frame).await?;
                }
            }
        }
    }
}

impl Shown {
    /// Other curves: from as far back as there is.
    fn show(&mut self, generation: u32, series: Vec<[usize; 2]>) {
        self.generation = generation;
        let wanted = series.into_iter().take(MOST_SERIES);
        self.series = wanted.map(|[channel, quantity]| Series { channel, quantity }).collect();
        self.next = 0;
        self.lost = 0;
    }

    /// The number of the next frame or picture; none while too many of them are unacknowledged.
    fn number(&mut self) -> Option<u32> {
        if self.sent.wrapping_sub(self.seen) >= IN_FLIGHT {
            return None;
        }
        self.sent = self.sent.wrapping_add(1);
        Some(self.sent)
    }

    /// The machine as it is now: if there is a picture of it, which the page does not have yet and is ready for.
    fn picture(&mut self, shared: &Shared) -> Option<String> {
        let picture = shared.picture.as_ref()?();
        if picture == self.picture {
            return None;
        }
        let number = self.number()?;
        // not parsed here: it is between its maker and the page
        let message = format!(r#"{{"kind":"picture","frame":{number},"picture":{picture}}}"#);
        self.picture = picture;
        Some(message)
    }

    /// What there is to say: the driver where it is another, its state if that is due, new curves if the page is ready.
    fn look(&mut self, shared: &Shared, due: bool) -> (Option<String>, Option<String>, Option<Vec<u8>>) {
        let view = shared.view();
        let hello = (view.epoch != self.epoch).then(|| view.hello(shared.picture.is_some()));
        self.epoch = view.epoch;
        let status = due.then(|| view.status.clone());
        let history = &view.history;
        let idle = self.series.is_empty() || history.next() <= self.next.max(history.first());
        if hello.is_some() || idle {
            return (hello, status, None);
        }
        let Some(number) = self.number() else { return (hello, status, None) };
        let shape = history.shape();
        self.series.retain(|series| series.channel < shape.channels && series.quantity < shape.quantities);
        if self.next > 0 {
            self.lost += history.first().saturating_sub(self.next);
        }
        let mut frame = Vec::new();
        // the header, of which the count of bins and whether more follow is filled in below: a whole number of f64 long
        for word in [self.generation, number, self.series.len() as u32, 0, history.shape().values() as u32, 0] {
            frame.extend_from_slice(&word.to_le_bytes());
        }
        frame.extend_from_slice(&(self.lost as f64).to_le_bytes());
        let bins = history.write(self.next, &self.series, shared.traffic.limits().frame, &mut frame);
        frame[12..16].copy_from_slice(&((bins.end - bins.start) as u32).to_le_bytes());
        frame[20..24].copy_from_slice(&u32::from(bins.end < history.next()).to_le_bytes());
        self.next = bins.end;
        (hello, status, Some(frame))
    }
}
