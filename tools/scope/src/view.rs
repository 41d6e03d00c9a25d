//! What the pages see of the driver: its curves, and what is sent to a page of everything else.

use std::sync::Arc;

use serde::Serialize;
use sinew_ipc::Client;
use sinew_plot::Field;

use crate::history::{History, Shape};
use crate::quantity;

/// What the pages see of the driver.
pub struct View {
    /// The curves.
    pub history: History,
    /// Raised whenever the history was begun anew.
    pub epoch: u64,
    /// What does not change, as a message to a page.
    pub hello: String,
    /// What does, as a message to a page.
    pub status: String,
    /// The connection, while there is one.
    pub client: Option<Arc<Client>>,
}

#[derive(Serialize)]
struct Hello<'a> {
    kind: &'static str,
    rig: &'a str,
    rate_hz: f64,
    simulated: bool,
    version: &'static str,
    epoch: u64,
    /// Values of a bin: 1, or 2 for the least and the largest.
    values: usize,
    capacity: usize,
    span_s: f64,
    commands: bool,
    quantities: Vec<Named>,
    channels: Vec<Channel<'a>>,
}

#[derive(Serialize)]
struct Named {
    name: &'static str,
    title: String,
    unit: &'static str,
}

#[derive(Serialize)]
struct Channel<'a> {
    name: &'a str,
    min_length_m: f64,
    max_length_m: f64,
    cold_m: f64,
    hot_m: f64,
    max_duty: f64,
}

impl View {
    /// Of a driver that was just found.
    pub fn new(client: Arc<Client>, commands: bool) -> View {
        let mut view = View {
            history: History::new(shape(&client)),
            epoch: 0,
            hello: String::new(),
            status: String::new(),
            client: None,
        };
        view.meet(client, commands);
        view
    }

    /// Takes up a driver. One with the same channels and rate as the last goes on in the same curves.
    pub fn meet(&mut self, client: Arc<Client>, commands: bool) {
        let shape = shape(&client);
        if shape != *self.history.shape() {
            self.history = History::new(shape.clone());
        }
        self.epoch += 1;
        let info = client.info();
        let channels = client.channels().iter().map(|c| Channel {
            name: c.name.as_str(),
            min_length_m: c.min_length_m,
            max_length_m: c.max_length_m,
            cold_m: c.cold_length_m,
            hot_m: c.hot_length_m,
            max_duty: c.max_duty,
        });
        let quantities = quantity::names().map(|name| {
            let Field { title, unit } = Field::of(name);
            Named { name, title, unit }
        });
        self.hello = json(&Hello {
            kind: "hello",
            rig: info.rig.as_str(),
            rate_hz: info.rate_hz,
            simulated: info.simulated != 0,
            version: env!("CARGO_PKG_VERSION"),
            epoch: self.epoch,
            values: shape.values(),
            capacity: shape.capacity(),
            span_s: shape.span_s(),
            commands,
            quantities: quantities.collect(),
            channels: channels.collect(),
        });
        self.client = Some(client);
    }
}

fn shape(client: &Client) -> Shape {
    Shape { channels: client.channels().len(), rate_hz: client.info().rate_hz }
}

/// As JSON; what cannot be written so is not sent.
pub fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|_| "{}".into())
}
