//! The session of one open page: curves and state to it, requests from it.
//!
//! Frames of curves are numbered and the page acknowledges each. At most [`IN_FLIGHT`] are unacknowledged, so that a page
//! that is slow, or suspended in the background, is not sent ever older curves: once ready it gets all new bins, in one
//! frame unless that grows too long, and the number of bins it missed if the history does not reach back so far.
//!
//! Pictures of the machine are numbered and acknowledged with the frames: a page that is slow gets fewer, each as the
//! machine is by then.
//!
//! On the network a page says first what opens the lock: the PIN, or the token it had for it. Until then it is no live page, but a
//! connection that ends in time like every other, and it is told nothing.
//!
//! At most one message waits for a page. One that does not fetch it in time, sends too much, or sends what no page of
//! ours does, is ended; that is counted.

use std::convert::Infallible;
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket, close_code};
use serde::{Deserialize, Serialize};
use sinew_server::{Allowance, End, Line, Refusal, part, receive, send, turn_away};
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use crate::command::{self, Answer, Request};
use crate::entrance::Event;
use crate::history::Series;
use crate::lock::{Lock, Try};
use crate::shared::{Shared, Way};
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

/// What a page on the network sends first.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Knock {
    /// The PIN, as its user has typed it.
    Pin { pin: String },
    /// What it was given for the PIN, when it connects anew.
    Token { token: String },
}

/// What it is told.
#[derive(Serialize)]
struct Entry<'a> {
    kind: &'static str,
    ok: bool,
    /// What opens the lock from now on.
    #[serde(skip_serializing_if = "Option::is_none")]
    token: Option<&'a str>,
    /// Why not.
    message: &'a str,
    /// The next PIN is looked at so much later, s.
    wait_s: f64,
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
pub async fn run(mut socket: WebSocket, way: Way, line: Line) {
    let traffic = &way.entrance.traffic;
    let mut allowed = Allowance::new(traffic.limits().messages, Instant::now());
    if let Some(lock) = &way.entrance.lock
        && let Err(end) = enter(&mut socket, &way, lock, &line, &mut allowed).await
    {
        return part(socket, traffic, &line, end).await;
    }
    let Some(_place) = traffic.open_client() else {
        // a browser shows no page the answer to a WebSocket's request, but the reason for which it was closed
        return turn_away(socket, close_code::AGAIN, Refusal::ClientsAtOnce).await;
    };
    line.is_live();
    let Err(end) = serve(&mut socket, &way, &line, allowed).await;
    part(socket, traffic, &line, end).await;
}

/// Waits for what opens the lock.
async fn enter(
    socket: &mut WebSocket,
    way: &Way,
    lock: &Lock,
    line: &Line,
    allowed: &mut Allowance,
) -> Result<(), End> {
    let limits = way.entrance.traffic.limits();
    let text = loop {
        match receive(socket, line, allowed).await? {
            Message::Text(text) => break text,
            Message::Binary(_) => return Err(End::Refused(Refusal::OddMessages)),
            Message::Ping(_) | Message::Pong(_) | Message::Close(_) => {}
        }
    };
    let from = line.peer().map(|peer| peer.ip());
    let tell = |event: &Event| way.shared.events.as_ref().into_iter().for_each(|events| events(event));
    let now = Instant::now();
    let (refusal, message) = match serde_json::from_str(&text) {
        Ok(Knock::Token { token }) if lock.session().matches(&token) => return Ok(()),
        Ok(Knock::Token { .. }) => {
            (Refusal::WrongTokens, "The scope has been started anew: its terminal shows another PIN.")
        }
        Ok(Knock::Pin { pin }) => match lock.open(&pin, now) {
            Try::Right => {
                tell(&Event::Entered { from });
                let token = Some(lock.session().as_str());
                let entry = Entry { kind: "entry", ok: true, token, message: "", wait_s: 0.0 };
                return send(socket, limits, json(&entry)).await;
            }
            Try::Wrong => (Refusal::WrongPins, "That is not the PIN."),
            Try::Renewed(pin) => {
                tell(&Event::renewed(&pin, from));
                (Refusal::WrongPins, "That is not the PIN, and ten were wrong: the terminal shows another one now.")
            }
            Try::TooSoon => (Refusal::PinsASecond, "Too many PINs were wrong, here or on another device."),
        },
        Err(_) => return Err(End::Refused(Refusal::OddMessages)),
    };
    let wait_s = lock.wait(now).as_secs_f64();
    send(socket, limits, json(&Entry { kind: "entry", ok: false, token: None, message, wait_s })).await?;
    Err(End::Refused(refusal))
}

async fn serve(socket: &mut WebSocket, way: &Way, line: &Line, mut allowed: Allowance) -> Result<Infallible, End> {
    let (shared, traffic) = (&way.shared, &way.entrance.traffic);
    let limits = traffic.limits();
    let mut may_command = false;
    let mut shown = Shown::default();
    if let Some(lock) = &way.entrance.lock {
        may_command = shared.options.commands && lock.commands();
        send(socket, limits, may(may_command)).await?;
    }
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
                    // of loopback alone: on the network the lock says who may command
                    Ok(Said::Token { token }) if way.entrance.lock.is_none() => {
                        let right = shared.token.matches(&token);
                        if !right {
                            traffic.refuse(Refusal::WrongTokens);
                        }
                        may_command = shared.options.commands && right;
                        send(socket, limits, may(may_command)).await?;
                    }
                    Ok(Said::Show { generation, series }) => shown.show(generation, series),
                    Ok(Said::Seen { frame }) => shown.seen = frame,
                    // its answer has a place before it is asked: what waits for a page does not grow
                    Ok(Said::Ask { id, what }) => match answers.clone().try_reserve_owned() {
                        Ok(place) => command::ask(way, may_command, id, what, place),
                        Err(_) => {
                            traffic.refuse(Refusal::RequestsUnanswered);
                            send(socket, limits, json(&Answer::too_many(id))).await?;
                        }
                    },
                    // a page of another version, or none of ours
                    Ok(Said::Token { .. }) | Err(_) => return Err(End::Refused(Refusal::OddMessages)),
                }
            }
            Some(answer) = answered.recv() => send(socket, limits, json(&answer)).await?,
            _ = frames.tick() => {
                // before the curves, which would else leave it no room on a page that is slow
                let picture = if count.is_multiple_of(PICTURE_EVERY) { shown.picture(shared) } else { None };
                let (hello, status, frame) = shown.look(shared, count.is_multiple_of(STATUS_EVERY), limits.frame);
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

/// Whether a page may command, as it is told.
fn may(command: bool) -> String {
    json(&serde_json::json!({ "kind": "may", "command": command }))
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
    fn look(
        &mut self,
        shared: &Shared,
        due: bool,
        longest: usize,
    ) -> (Option<String>, Option<String>, Option<Vec<u8>>) {
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
        let bins = history.write(self.next, &self.series, longest, &mut frame);
        frame[12..16].copy_from_slice(&((bins.end - bins.start) as u32).to_le_bytes());
        frame[20..24].copy_from_slice(&u32::from(bins.end < history.next()).to_le_bytes());
        self.next = bins.end;
        (hello, status, Some(frame))
    }
}
