//! What the threads of the bridge share: the driver that runs now, who is there, and what is counted.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde_json::{Value, json};
use sinew_bridge::has_ended;
use sinew_ipc::{ChannelState, Client, DriverHealth, FieldKind};
use sinew_recorder::layout;
use sinew_recording::session::topics;

use crate::keys::Keys;

/// What the threads of the bridge share.
pub struct Station {
    /// Name of the rig.
    pub rig: String,
    /// What is where.
    pub keys: Keys,
    /// Set when it is time to end.
    pub stop: AtomicBool,
    /// What is counted.
    pub counts: Counts,
    /// Since when.
    started: Instant,
    client: Mutex<Option<Arc<Client>>>,
    /// Commanders that have declared themselves alive.
    present: Mutex<BTreeSet<String>>,
}

/// A figure that only grows.
#[derive(Debug, Default)]
pub struct Count(AtomicU64);

impl Count {
    /// One more.
    pub fn one(&self) {
        self.many(1);
    }

    /// So many more.
    pub fn many(&self, more: u64) {
        self.0.fetch_add(more, Ordering::Relaxed);
    }

    /// How many.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What is counted, and published.
#[derive(Debug, Default)]
pub struct Counts {
    /// Messages handed to Zenoh.
    pub sent: Count,
    /// Cycles that did not come from the driver.
    pub cycles_lost: Count,
    /// Commands the driver has taken.
    pub taken: Count,
    /// Commands refused, by the driver or for what they say.
    pub refused: Count,
    /// Commands refused because they came too often.
    pub too_many: Count,
    /// Commands refused because their commander had not declared himself alive.
    pub not_alive: Count,
    /// Commands refused because they had waited for too long here.
    pub late: Count,
    /// Times that a commander's channels were put off because he was gone.
    pub put_off: Count,
}

impl Station {
    /// Of this rig, without a driver yet.
    pub fn new(rig: &str) -> Station {
        Station {
            rig: rig.into(),
            keys: Keys::new(rig),
            stop: AtomicBool::new(false),
            counts: Counts::default(),
            started: Instant::now(),
            client: Mutex::default(),
            present: Mutex::default(),
        }
    }

    /// Whether it is time to end.
    pub fn is_over(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// There is a driver, or none any more.
    pub fn meet(&self, client: Option<Arc<Client>>) {
        *locked(&self.client) = client;
    }

    /// The driver that runs now.
    pub fn client(&self) -> Option<Arc<Client>> {
        locked(&self.client).clone().filter(|client| !has_ended(client))
    }

    /// Commanders that have declared themselves alive.
    pub fn present(&self) -> MutexGuard<'_, BTreeSet<String>> {
        locked(&self.present)
    }

    /// [`Keys::info`]: what does not change while a driver runs, and whether one does.
    pub fn info(&self) -> Value {
        let version = env!("CARGO_PKG_VERSION");
        let Some(client) = self.client() else {
            return json!({ "schema": "sinew.zenoh/1", "bridge_version": version, "rig": self.rig, "state": "gone" });
        };
        let info = client.info();
        let channels = client.channels().iter().map(|channel| {
            json!({
                "name": channel.name.as_str(), "min_length_m": channel.min_length_m, "max_length_m": channel.max_length_m,
                "hot_length_m": channel.hot_length_m, "cold_length_m": channel.cold_length_m,
                "rest_length_m": channel.rest_length_m, "max_duty": channel.max_duty,
                "max_current_a": channel.max_current_a, "max_power_w": channel.max_power_w,
                "max_temperature_c": channel.max_temperature_c, "lease_s": channel.lease_s,
            })
        });
        let names = client.channels().iter().map(|channel| channel.name.to_string()).collect();
        // a driver has no two channels of one name
        let topics = layout(names).map_or_else(|_| Vec::new(), |layout| topics(&layout).to_vec());
        let topics = topics
            .iter()
            .map(|topic| json!({ "key": self.keys.topic(topic.name), "type": topic.kind, "ros2msg": topic.schema }));
        let fields = ChannelState::FIELDS.iter().map(|field| {
            let kind = match field.kind {
                FieldKind::Float => "f64",
                FieldKind::Code => "u32",
            };
            json!({ "name": field.name, "type": kind, "unit": field.unit })
        });
        json!({
            "schema": "sinew.zenoh/1", "bridge_version": version, "rig": self.rig, "state": state(client.health()),
            "pid": info.pid, "protocol": info.protocol, "rate_hz": info.rate_hz, "simulated": info.simulated != 0,
            "channels": channels.collect::<Vec<_>>(), "fields": fields.collect::<Vec<_>>(),
            "topics": topics.collect::<Vec<_>>(),
        })
    }

    /// [`Keys::bridge`]: how the bridge does.
    pub fn figures(&self) -> Value {
        let counts = &self.counts;
        json!({
            "seconds": self.started.elapsed().as_secs_f64(),
            "sent": counts.sent.get(),
            "cycles_lost": counts.cycles_lost.get(),
            "commanders": *self.present(),
            "commands": {
                "taken": counts.taken.get(), "refused": counts.refused.get(), "too_many": counts.too_many.get(),
                "not_alive": counts.not_alive.get(), "late": counts.late.get(), "put_off": counts.put_off.get(),
            },
        })
    }
}

/// The state of a channel for people and small programs: the fields of `sinew status --json`, and of which cycle they are.
pub fn channel(client: &Client, number: usize) -> Option<Value> {
    let (cycle, monotonic_ns, state) = client.with_latest(|latest| {
        let state = latest.channels().get(number).copied();
        (latest.cycle, latest.monotonic_ns, state)
    });
    let state = state?;
    let mut map = serde_json::Map::new();
    map.insert("name".into(), json!(client.channels()[number].name.as_str()));
    map.insert("cycle".into(), json!(cycle));
    map.insert("monotonic_ns".into(), json!(monotonic_ns));
    for field in ChannelState::FIELDS.iter().filter(|field| field.in_status) {
        let value = match (field.name, field.kind) {
            ("mode", _) => json!(state.mode().name()),
            ("fault", _) => json!(state.fault().map(|fault| fault.flag())),
            (_, FieldKind::Float) => json!(field.of(&state)),
            (_, FieldKind::Code) => json!(field.of(&state) as u32),
        };
        map.insert(field.name.into(), value);
    }
    Some(Value::Object(map))
}

fn state(health: DriverHealth) -> &'static str {
    match health {
        DriverHealth::Stopped | DriverHealth::Died => "gone",
        health => health.name(),
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
