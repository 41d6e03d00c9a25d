//! What is published: every cycle, event and figure by the watching thread, and now and then what is for people, by the main one.
//!
//! Nobody waits for a subscriber: what finds no room on its link is lost to it. Each message has an attachment of 16 bytes: its number
//! among those of its key, from 0, by which a subscriber counts what it has lost, and its time of day in ns since 1970 (both little
//! endian).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;
use sinew_bridge::watch::Audience;
use sinew_ipc::Client;
use sinew_recording::session::{CYCLES, EVENTS, LOOP, Layout, topics};
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

use crate::failure::Failure;
use crate::station::{Station, channel};

/// Between two states of a channel for people.
const CHANNELS_EVERY: Duration = Duration::from_millis(100);
/// Between two of the bridge's own figures.
const FIGURES_EVERY: Duration = Duration::from_secs(1);

/// A key and the messages published there.
struct Outlet {
    publisher: Publisher<'static>,
    /// Whether anybody listens.
    is_heard: Arc<AtomicBool>,
    number: u64,
}

impl Outlet {
    fn open(session: &Session, key: String, encoding: Encoding, priority: Priority) -> Result<Outlet, Failure> {
        let failed = |error: zenoh::Error| Failure::own(format_args!("{key}: {error}"));
        let publisher = session
            .declare_publisher(key.clone())
            .encoding(encoding)
            .congestion_control(CongestionControl::Drop)
            .priority(priority)
            .wait()
            .map_err(failed)?;
        let is_heard = Arc::new(AtomicBool::new(false));
        let heard = is_heard.clone();
        let listener =
            publisher.matching_listener().callback(move |status| heard.store(status.matching(), Ordering::Relaxed));
        listener.background().wait().map_err(failed)?;
        // who was there before the listener
        let status = publisher.matching_status().wait().map_err(failed)?;
        is_heard.fetch_or(status.matching(), Ordering::Relaxed);
        Ok(Outlet { publisher, is_heard, number: 0 })
    }

    fn is_heard(&self) -> bool {
        self.is_heard.load(Ordering::Relaxed)
    }

    /// Hands a message to Zenoh.
    fn put(&mut self, unix_ns: u64, message: Vec<u8>, station: &Station) {
        let attachment = [self.number.to_le_bytes(), unix_ns.to_le_bytes()].concat();
        match self.publisher.put(message).attachment(attachment).wait() {
            Ok(()) => station.counts.sent.one(),
            Err(error) => tracing::debug!("{}: {error}", self.publisher.key_expr()),
        }
        self.number += 1;
    }
}

/// The watching thread's end: the streams.
pub struct Stage {
    station: Arc<Station>,
    cycles: Outlet,
    events: Outlet,
    figures: Outlet,
}

impl Stage {
    /// Of this session.
    ///
    /// # Errors
    /// Zenoh's own.
    pub fn open(session: &Session, station: Arc<Station>) -> Result<Stage, Failure> {
        let open = |topic, priority| Outlet::open(session, station.keys.topic(topic), cdr(topic), priority);
        // the many behind the few, and behind the answers to commands, which go as Zenoh's data
        let (cycles, events, figures) =
            (open(CYCLES, Priority::DataLow)?, open(EVENTS, Priority::DataHigh)?, open(LOOP, Priority::DataLow)?);
        Ok(Stage { station, cycles, events, figures })
    }
}

/// The encoding of a topic's messages.
pub fn cdr(topic: &str) -> Encoding {
    // a type's name does not depend on which channels there are
    let kind = sinew_recorder::layout(vec!["any".into()])
        .ok()
        .and_then(|layout| topics(&layout).into_iter().find(|known| known.name == topic).map(|known| known.kind));
    Encoding::APPLICATION_CDR.with_schema(kind.unwrap_or_default())
}

impl Audience for Stage {
    fn is_over(&self) -> bool {
        self.station.is_over()
    }

    fn meet(&mut self, client: &Arc<Client>, _: &Layout) {
        self.station.meet(Some(client.clone()));
    }

    fn gone(&mut self) {
        self.station.meet(None);
    }

    fn is_heard(&self) -> bool {
        self.cycles.is_heard() || self.events.is_heard() || self.figures.is_heard()
    }

    fn put(&mut self, topic: &'static str, unix_ns: u64, message: Vec<u8>) {
        let outlet = match topic {
            CYCLES => &mut self.cycles,
            EVENTS => &mut self.events,
            _ => &mut self.figures,
        };
        outlet.put(unix_ns, message, &self.station);
    }

    fn lost(&mut self, cycles: u64) {
        self.station.counts.cycles_lost.many(cycles);
    }
}

/// What is published for people and small programs, in JSON.
pub struct Board {
    station: Arc<Station>,
    info: Outlet,
    figures: Outlet,
    channels: Vec<Outlet>,
    /// Whose channels these are.
    of: Option<Arc<Client>>,
    /// What was last said of the driver.
    said: Value,
    channels_at: Instant,
    figures_at: Instant,
}

impl Board {
    /// Of this session.
    ///
    /// # Errors
    /// Zenoh's own.
    pub fn open(session: &Session, station: Arc<Station>) -> Result<Board, Failure> {
        let info = Outlet::open(session, station.keys.info(), Encoding::APPLICATION_JSON, Priority::DataHigh)?;
        let figures = Outlet::open(session, station.keys.bridge(), Encoding::APPLICATION_JSON, Priority::DataLow)?;
        let now = Instant::now();
        Ok(Board {
            station,
            info,
            figures,
            channels: Vec::new(),
            of: None,
            said: Value::Null,
            channels_at: now,
            figures_at: now,
        })
    }

    /// Publishes what is due.
    ///
    /// # Errors
    /// Zenoh's own.
    pub fn look(&mut self, session: &Session) -> Result<(), Failure> {
        let now = Instant::now();
        if now >= self.channels_at {
            self.channels_at = now + CHANNELS_EVERY;
            self.follow(session)?;
            self.put_channels();
        }
        if now >= self.figures_at {
            self.figures_at = now + FIGURES_EVERY;
            if self.figures.is_heard() {
                let text = self.station.figures().to_string().into_bytes();
                self.figures.put(unix_ns(), text, &self.station);
            }
        }
        Ok(())
    }

    /// Follows the driver: says what there is, where that has changed.
    fn follow(&mut self, session: &Session) -> Result<(), Failure> {
        let client = self.station.client();
        let is_same = match (&client, &self.of) {
            (Some(client), Some(of)) => Arc::ptr_eq(client, of),
            (client, of) => client.is_none() && of.is_none(),
        };
        if !is_same {
            let names = client.iter().flat_map(|client| client.channels()).map(|channel| channel.name.as_str());
            let open = |name| {
                Outlet::open(session, self.station.keys.channel(name), Encoding::APPLICATION_JSON, Priority::DataLow)
            };
            self.channels = names.map(open).collect::<Result<_, _>>()?;
            self.of = client;
        }
        let info = self.station.info();
        if info != self.said {
            self.info.put(unix_ns(), info.to_string().into_bytes(), &self.station);
            self.said = info;
        }
        Ok(())
    }

    fn put_channels(&mut self) {
        let Some(client) = &self.of else { return };
        for (number, outlet) in self.channels.iter_mut().enumerate().filter(|(_, outlet)| outlet.is_heard()) {
            if let Some(state) = channel(client, number) {
                outlet.put(unix_ns(), state.to_string().into_bytes(), &self.station);
            }
        }
    }
}

fn unix_ns() -> u64 {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}
