//! The session of one viewer: topics and their messages to it, subscriptions from it.
//!
//! One message at a time is on its way to a viewer; what it has not fetched waits in the feed's ring, where the oldest are
//! overwritten. How many it has lost is said to it, and counted.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket};
use sinew_server::{Allowance, End, Line, Refusal, part, receive, send};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{MissedTickBehavior, interval};

use super::feed::{Fed, Feed, Item};
use super::protocol::{Heard, Level, Said, Subscription, data};

/// Between two words about what was lost.
const WORDS: Duration = Duration::from_secs(1);
/// Most subscriptions of a viewer; there are three topics.
const MOST_SUBSCRIPTIONS: usize = 16;

/// Serves a viewer until it goes, or does what is refused.
pub async fn run(mut socket: WebSocket, feed: Arc<Feed>, line: Line) {
    let Err(end) = serve(&mut socket, &feed, &line).await;
    part(socket, &feed.traffic, &line, end).await;
}

/// What a viewer has been told, and what it wants.
#[derive(Default)]
struct Viewer {
    /// Numbers of the topics it knows.
    known: Vec<u32>,
    subscriptions: Vec<Subscription>,
    /// What it was told of the driver.
    trouble: Option<String>,
    /// Messages it has lost, and how many of them it knows of.
    lost: u64,
    said: u64,
}

async fn serve(socket: &mut WebSocket, feed: &Arc<Feed>, line: &Line) -> Result<Infallible, End> {
    let mut viewer = Viewer::default();
    let mut fed = feed.listen();
    let mut allowed = Allowance::new(feed.traffic.limits().messages, Instant::now());
    let mut words = interval(WORDS);
    words.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let (name, session) = (format!("sinew: {}", feed.rig), std::process::id().to_string());
    say(socket, feed, &Said::ServerInfo { name: &name, capabilities: [], session_id: &session }).await?;
    viewer.hear_notice(socket, feed).await?;
    loop {
        tokio::select! {
            // what a viewer wants comes first: else one that is always behind could never be heard
            biased;
            message = receive(socket, line, &mut allowed) => viewer.heard(socket, feed, message?).await?,
            _ = words.tick() => viewer.say_lost(socket, feed).await?,
            next = fed.recv() => match next {
                Ok(Fed::Item(item)) => viewer.send(socket, feed, &item).await?,
                Ok(Fed::Notice) => viewer.hear_notice(socket, feed).await?,
                Err(RecvError::Lagged(lost)) => {
                    viewer.lost += lost;
                    feed.lost.fetch_add(lost, Ordering::Relaxed);
                    // a notice may be among what was lost
                    viewer.hear_notice(socket, feed).await?;
                }
                Err(RecvError::Closed) => return Err(End::Gone),
            },
        }
    }
}

impl Viewer {
    /// What it wants.
    async fn heard(&mut self, socket: &mut WebSocket, feed: &Feed, message: Message) -> Result<(), End> {
        let text = match message {
            Message::Text(text) => text,
            // data and calls are for servers that take them
            Message::Binary(_) => return only_sends(socket, feed).await,
            Message::Ping(_) | Message::Pong(_) | Message::Close(_) => return Ok(()),
        };
        match serde_json::from_str(&text) {
            Ok(Heard::Subscribe { subscriptions }) => {
                for wanted in subscriptions {
                    // a topic that was taken back meanwhile, or never was
                    if !self.known.contains(&wanted.channel_id) {
                        continue;
                    }
                    self.subscriptions.retain(|subscription| subscription.id != wanted.id);
                    if self.subscriptions.len() >= MOST_SUBSCRIPTIONS {
                        return Err(End::Refused(Refusal::OddMessages));
                    }
                    self.subscriptions.push(wanted);
                }
                Ok(())
            }
            Ok(Heard::Unsubscribe { subscription_ids }) => {
                self.subscriptions.retain(|subscription| !subscription_ids.contains(&subscription.id));
                Ok(())
            }
            Ok(Heard::Other) => only_sends(socket, feed).await,
            Err(_) => Err(End::Refused(Refusal::OddMessages)),
        }
    }

    /// Tells it of topics and of what is amiss, as far as it does not know.
    async fn hear_notice(&mut self, socket: &mut WebSocket, feed: &Feed) -> Result<(), End> {
        let notice = feed.notice();
        let ids: Vec<u32> = notice.channels.iter().map(|channel| channel.id).collect();
        if ids != self.known {
            if !self.known.is_empty() {
                say(socket, feed, &Said::Unadvertise { channel_ids: &self.known }).await?;
            }
            say(socket, feed, &Said::Advertise { channels: &notice.channels }).await?;
            self.subscriptions.clear();
            self.known = ids;
        }
        if notice.trouble != self.trouble {
            let id = "driver";
            match &notice.trouble {
                Some(message) => say(socket, feed, &Said::Status { level: Level::Error, message, id }).await?,
                None => say(socket, feed, &Said::RemoveStatus { status_ids: [id] }).await?,
            }
            self.trouble = notice.trouble;
        }
        Ok(())
    }

    /// A message, as often as it has subscribed to its topic.
    async fn send(&self, socket: &mut WebSocket, feed: &Feed, item: &Item) -> Result<(), End> {
        for subscription in self.subscriptions.iter().filter(|subscription| subscription.channel_id == item.channel) {
            send(socket, feed.traffic.limits(), data(subscription.id, item.unix_ns, &item.message)).await?;
        }
        Ok(())
    }

    /// How many messages it has lost, where it does not know.
    async fn say_lost(&mut self, socket: &mut WebSocket, feed: &Feed) -> Result<(), End> {
        if self.said == self.lost {
            return Ok(());
        }
        self.said = self.lost;
        let message = format!("{} messages lost: they come faster than they are fetched", self.lost);
        say(socket, feed, &Said::Status { level: Level::Warning, message: &message, id: "lost" }).await
    }
}

/// The answer to whoever wants more than to look on.
async fn only_sends(socket: &mut WebSocket, feed: &Feed) -> Result<(), End> {
    let message = "this bridge only shows: it takes no data, parameters or calls";
    say(socket, feed, &Said::Status { level: Level::Warning, message, id: "only_shows" }).await
}

async fn say(socket: &mut WebSocket, feed: &Feed, said: &Said<'_>) -> Result<(), End> {
    // plain structs of text and numbers can always be written
    let Ok(text) = serde_json::to_string(said) else { return Ok(()) };
    send(socket, feed.traffic.limits(), text).await
}
