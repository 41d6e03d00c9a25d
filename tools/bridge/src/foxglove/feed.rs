//! What the watching thread hands to the viewers: the topics there are, and the latest messages in a ring.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::body::Bytes;
use sinew_ipc::Client;
use sinew_recording::session::{CYCLES, EVENTS, Layout, topics};
use sinew_server::{Limits, Traffic};
use tokio::sync::broadcast;

use super::protocol::Channel;
use crate::watch::Audience;

/// Messages that are kept for viewers who are behind: a second at 1 kHz, 12 MB at the most.
const KEPT: usize = 1024;

/// A message for whoever has subscribed to its topic.
#[derive(Debug, Clone)]
pub struct Item {
    /// Number of its topic.
    pub channel: u32,
    /// Its time of day, ns since 1970.
    pub unix_ns: u64,
    /// CDR.
    pub message: Bytes,
}

/// What goes through the ring.
#[derive(Debug, Clone)]
pub enum Fed {
    /// A message.
    Item(Item),
    /// Topics or words have changed: look at the notice.
    Notice,
}

/// What does not change with every message.
#[derive(Debug, Clone, Default)]
pub struct Notice {
    /// The topics there are.
    pub channels: Vec<Channel>,
    /// What is amiss with the driver, if anything is.
    pub trouble: Option<String>,
}

/// What the watching thread, the server and the viewers share.
pub struct Feed {
    /// Name of the rig.
    pub rig: String,
    /// Set when it is time to end.
    pub stop: AtomicBool,
    /// Who is connected.
    pub traffic: Arc<Traffic>,
    /// Messages that viewers have lost because they were too slow.
    pub lost: AtomicU64,
    ring: broadcast::Sender<Fed>,
    notice: Mutex<Notice>,
}

impl Feed {
    /// Of this rig, without a driver yet.
    pub fn new(rig: &str, limits: Limits) -> Feed {
        Feed {
            rig: rig.into(),
            stop: AtomicBool::new(false),
            traffic: Arc::new(Traffic::new(limits)),
            lost: AtomicU64::new(0),
            ring: broadcast::channel(KEPT).0,
            notice: Mutex::new(Notice { channels: Vec::new(), trouble: Some(format!("no driver of {rig} runs")) }),
        }
    }

    /// Everything from now on.
    pub fn listen(&self) -> broadcast::Receiver<Fed> {
        self.ring.subscribe()
    }

    /// Whether anybody listens.
    pub fn is_heard(&self) -> bool {
        self.ring.receiver_count() > 0
    }

    /// A message of a topic, for those who listen.
    pub fn put(&self, item: Item) {
        // an error says that nobody listens
        let _ = self.ring.send(Fed::Item(item));
    }

    /// The topics and words of now.
    pub fn notice(&self) -> Notice {
        self.locked().clone()
    }

    /// The driver has gone.
    pub fn gone(&self) {
        self.locked().trouble = Some(format!("the driver of {} has gone; what is shown is the past", self.rig));
        let _ = self.ring.send(Fed::Notice);
    }

    /// There is a driver with these channels. One like the last goes on with the same topics; another gets others. Returns the
    /// numbers of the topics: of the cycles, the events and the loop's figures.
    pub fn meet(&self, layout: &Layout) -> [u32; 3] {
        let numbers = {
            let mut notice = self.locked();
            let first = notice.channels.first().map_or(1, |channel| channel.id);
            let under = |first: u32| {
                let numbered = (first..).zip(topics(layout)).map(|(id, topic)| Channel::new(id, topic));
                numbered.collect::<Vec<_>>()
            };
            let mut channels = under(first);
            if !notice.channels.is_empty() && channels != notice.channels {
                channels = under(first.wrapping_add(channels.len() as u32));
            }
            let numbers = [channels[0].id, channels[1].id, channels[2].id];
            *notice = Notice { channels, trouble: None };
            numbers
        };
        let _ = self.ring.send(Fed::Notice);
        numbers
    }

    fn locked(&self) -> MutexGuard<'_, Notice> {
        self.notice.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The watching thread's end of it.
pub struct Feeding {
    pub feed: Arc<Feed>,
    /// Numbers of the topics: of the cycles, the events and the loop's figures.
    pub numbers: [u32; 3],
}

impl Audience for Feeding {
    fn is_over(&self) -> bool {
        self.feed.stop.load(Ordering::Relaxed)
    }

    fn meet(&mut self, _: &Arc<Client>, layout: &Layout) {
        self.numbers = self.feed.meet(layout);
    }

    fn gone(&mut self) {
        self.feed.gone();
    }

    fn is_heard(&self) -> bool {
        self.feed.is_heard()
    }

    fn put(&mut self, topic: &'static str, unix_ns: u64, message: Vec<u8>) {
        let [cycles, events, figures] = self.numbers;
        let channel = match topic {
            CYCLES => cycles,
            EVENTS => events,
            _ => figures,
        };
        self.feed.put(Item { channel, unix_ns, message: message.into() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_channels_keep_their_topics_and_others_get_others() {
        let feed = Feed::new("bench", Limits::default());
        let layout = |names: &[&str]| sinew_recorder::layout(names.iter().map(ToString::to_string).collect()).unwrap();
        assert!(feed.notice().trouble.is_some() && feed.notice().channels.is_empty());
        assert_eq!(feed.meet(&layout(&["left"])), [1, 2, 3]);
        assert!(feed.notice().trouble.is_none());
        feed.gone();
        assert_eq!((feed.notice().channels.len(), feed.notice().trouble.is_some()), (3, true));
        assert_eq!(feed.meet(&layout(&["left"])), [1, 2, 3]);
        assert_eq!(feed.meet(&layout(&["left", "right"])), [4, 5, 6]);
        let ids: Vec<u32> = feed.notice().channels.iter().map(|channel| channel.id).collect();
        assert_eq!(ids, [4, 5, 6]);
    }
}
