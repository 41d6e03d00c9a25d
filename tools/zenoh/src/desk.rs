//! The desk: commanders' requests, one after the other, each with its answer.
//!
//! Who a commander is stands in the certificate of his link and is checked before a request gets here ([`settings`](crate::settings)).
//! He is there as long as his liveliness token is, which Zenoh takes away with his link. Then, and when the bridge ends, everything that
//! he holds is put off at once; where a link is silent instead of closed, his leases run out. The desk renews none.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;
use sinew_bridge::has_ended;
use sinew_ipc::{ALL_CHANNELS, Client, ClientOptions, CommandKind, Wanted};
use sinew_server::{Allowance, Flow};
use zenoh::bytes::Encoding;
use zenoh::query::Query;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use crate::failure::Failure;
use crate::request::{Done, Effect, Refused, Request};
use crate::station::Station;

/// What a commander may ask; what only switches off does not count.
const COMMANDS: Flow = Flow { at_once: 100.0, a_second: 250.0 };
/// Requests that wait.
const MOST_WAITING: usize = 256;
/// How long a request may have waited here: then its commander wants something else.
const LONGEST_WAIT: Duration = Duration::from_millis(500);
/// How long a request may wait for its commander's token, which Zenoh may hand on a little later than what was sent after it.
const GRACE: Duration = Duration::from_millis(250);
/// How long the driver's answer is waited for.
const ANSWER: Duration = Duration::from_millis(500);

/// What has come for the desk.
#[derive(Default)]
pub struct Tray {
    content: Mutex<Content>,
    changed: Condvar,
}

#[derive(Default)]
struct Content {
    /// Requests in their order.
    requests: VecDeque<Asked>,
    /// Commanders that have gone.
    gone: VecDeque<String>,
}

/// A request as it has come.
struct Asked {
    commander: String,
    query: Query,
    request: Result<Request, Refused>,
    since: Instant,
}

impl Asked {
    /// Whether it can be answered, with these commanders there.
    fn is_ripe(&self, present: &BTreeSet<String>) -> bool {
        let needs_commander = self.request.as_ref().is_ok_and(|request| !request.only_switches_off());
        !needs_commander || present.contains(&self.commander) || self.since.elapsed() >= GRACE
    }
}

impl Tray {
    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a request in, or gives it back.
    fn put(&self, commander: &str, query: Query) -> Option<Query> {
        let mut content = self.content();
        if content.requests.len() >= MOST_WAITING {
            return Some(query);
        }
        let request = Request::read(&query.payload().map(|payload| payload.to_bytes()).unwrap_or_default());
        content.requests.push_back(Asked { commander: commander.into(), query, request, since: Instant::now() });
        self.changed.notify_one();
        None
    }

    fn gone(&self, commander: &str) {
        self.content().gone.push_back(commander.into());
        self.changed.notify_one();
    }
}

/// A commander: his own connection to the driver, so that what he claims is his, and what he holds.
struct Commander {
    name: String,
    allowance: Allowance,
    client: Option<Arc<Client>>,
    /// Channels with his setpoints, until when.
    held: BTreeMap<u32, Instant>,
}

/// Who answers.
pub struct Desk {
    station: Arc<Station>,
    tray: Arc<Tray>,
    commanders: Vec<Commander>,
}

impl Desk {
    /// For these commanders, on this session.
    ///
    /// # Errors
    /// Zenoh's own.
    pub fn open(session: &Session, station: Arc<Station>, commanders: &[String]) -> Result<Desk, Failure> {
        let tray = Arc::<Tray>::default();
        for name in commanders {
            let key = station.keys.command(name);
            let (station, tray, commander) = (station.clone(), tray.clone(), name.clone());
            let asked = move |query: Query| {
                if let Some(query) = tray.put(&commander, query) {
                    station.counts.too_many.one();
                    refuse(
                        &query,
                        Refused::new("too many requests wait", "ask again when those before have been answered"),
                    );
                }
            };
            let queryable = session.declare_queryable(key.clone()).complete(true).callback(asked);
            queryable.background().wait().map_err(|error| Failure::own(format_args!("{key}: {error}")))?;
        }
        if !commanders.is_empty() {
            let key = station.keys.alive("*");
            let (watched, tray) = (station.clone(), tray.clone());
            let seen = move |sample: zenoh::sample::Sample| {
                let Some(name) = watched.keys.commander_of(sample.key_expr().as_str()) else { return };
                match sample.kind() {
                    SampleKind::Put => {
                        watched.present().insert(name.into());
                        tray.changed.notify_one();
                    }
                    SampleKind::Delete => {
                        // in this order: no request of his is taken up any more
                        watched.present().remove(name);
                        tray.gone(name);
                    }
                }
            };
            let subscriber = session.liveliness().declare_subscriber(key.clone()).history(true).callback(seen);
            subscriber.background().wait().map_err(|error| Failure::own(format_args!("{key}: {error}")))?;
        }
        let now = Instant::now();
        let commander = |name: &String| Commander {
            name: name.clone(),
            allowance: Allowance::new(COMMANDS, now),
            client: None,
            held: BTreeMap::new(),
        };
        Ok(Desk { station, tray, commanders: commanders.iter().map(commander).collect() })
    }

    /// Answers what has come, waiting for it for so long at the most.
    pub fn serve(&mut self, wait: Duration) {
        let end = Instant::now() + wait;
        loop {
            let mut content = self.tray.content();
            let ripe = |content: &Content| {
                let present = self.station.present();
                content.requests.iter().position(|asked| asked.is_ripe(&present))
            };
            if content.gone.is_empty() && ripe(&content).is_none() {
                let left = end.saturating_duration_since(Instant::now());
                content = self.tray.changed.wait_timeout(content, left).unwrap_or_else(PoisonError::into_inner).0;
            }
            // who has gone comes first
            if let Some(name) = content.gone.pop_front() {
                drop(content);
                tracing::info!("{name} is gone");
                self.put_off(&name);
            } else if let Some(asked) = ripe(&content).and_then(|place| content.requests.remove(place)) {
                drop(content);
                self.answer(asked);
            }
            if Instant::now() >= end {
                return;
            }
        }
    }

    /// Puts off everything that anybody holds.
    pub fn close(&mut self) {
        let names: Vec<String> = self.commanders.iter().map(|commander| commander.name.clone()).collect();
        names.iter().for_each(|name| self.put_off(name));
    }

    fn answer(&mut self, Asked { commander: name, query, request, since }: Asked) {
        let counts = &self.station.counts;
        let Some(commander) = self.commanders.iter_mut().find(|commander| commander.name == name) else { return };
        let now = Instant::now();
        let asked = request.inspect_err(|_| counts.refused.one()).and_then(|request| {
            if request.only_switches_off() {
                return Ok(request);
            }
            if !self.station.present().contains(&name) {
                counts.not_alive.one();
                let remedy =
                    format!("declare the liveliness token {} first, and keep it", self.station.keys.alive(&name));
                return Err(Refused::new(
                    format!("{name} has not declared itself alive, so nobody would see it go"),
                    remedy,
                ));
            }
            if now.duration_since(since) > LONGEST_WAIT {
                counts.late.one();
                return Err(Refused::new("the request has waited for too long", "ask for what is wanted now"));
            }
            if !commander.allowance.take(1.0, now) {
                counts.too_many.one();
                let remedy = format!(
                    "ask at most {} times a second; `set_many` is for many channels at once",
                    COMMANDS.a_second
                );
                return Err(Refused::new("too many requests", remedy));
            }
            Ok(request)
        });
        let done = asked.and_then(|request| {
            let done = commander.carry_out(&request, &self.station.rig);
            if done.is_ok() { &counts.taken } else { &counts.refused }.one();
            done
        });
        match done {
            Ok(done) => reply(&query, &done),
            Err(refused) => refuse(&query, refused),
        }
    }

    fn put_off(&mut self, name: &str) {
        let Some(commander) = self.commanders.iter_mut().find(|commander| commander.name == name) else { return };
        let now = Instant::now();
        let held = std::mem::take(&mut commander.held).into_iter().filter(|(_, until)| *until > now);
        let off: Vec<Wanted> =
            held.map(|(channel, _)| Wanted { channel, kind: CommandKind::Off, value: 0.0 }).collect();
        if let (Some(client), false) = (&commander.client, off.is_empty()) {
            self.station.counts.put_off.one();
            match client.set_many(&off, Duration::ZERO) {
                Ok(_) => tracing::info!("what {name} held is off: {} channels", off.len()),
                Err(error) => tracing::warn!("what {name} held could not be put off: {}", error.message()),
            }
        }
    }
}

impl Commander {
    /// His connection to the driver that runs now.
    fn client(&mut self, rig: &str) -> Result<Arc<Client>, Refused> {
        match &self.client {
            Some(client) if !has_ended(client) => Ok(client.clone()),
            _ => {
                // what was held was the last driver's
                self.held.clear();
                let options = ClientOptions { connect: Duration::ZERO, answer: ANSWER };
                Ok(self.client.insert(Arc::new(Client::connect_with(rig, options)?)).clone())
            }
        }
    }

    /// Asks the driver for him, and keeps in mind what he holds by that.
    fn carry_out(&mut self, request: &Request, rig: &str) -> Result<Done, Refused> {
        let client = self.client(rig)?;
        let Effect { leased, hold, released } = request.effect(&client)?;
        let done = request.carry_out(&client, hold);
        let is_taken = done.is_ok();
        if is_taken && released.contains(&ALL_CHANNELS) {
            self.held.clear();
        } else if is_taken {
            self.held.retain(|channel, _| !released.contains(channel));
        }
        // the lease began when the driver took it: at the latest now; and who has had no answer may have one
        if is_taken || done.as_ref().is_err_and(|refused| refused.is_open) {
            let until = Instant::now() + hold;
            self.held.extend(leased.into_iter().map(|channel| (channel, until)));
        }
        done
    }
}

fn reply(query: &Query, done: &Done) {
    let sent = query.reply(query.key_expr().clone(), json(done)).encoding(Encoding::APPLICATION_JSON).wait();
    if let Err(error) = sent {
        tracing::debug!("an answer is lost: {error}");
    }
}

fn refuse(query: &Query, refused: Refused) {
    let sent = query.reply_err(json(&refused)).encoding(Encoding::APPLICATION_JSON).wait();
    if let Err(error) = sent {
        tracing::debug!("a refusal is lost: {error}");
    }
}

fn json(value: &impl Serialize) -> Vec<u8> {
    // plain structs of text and numbers can always be written
    serde_json::to_vec(value).unwrap_or_default()
}
