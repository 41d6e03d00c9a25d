//! What the pages see: curves, and what is sent to a page of everything else.

use std::sync::Arc;

use serde::Serialize;
use serde_json::{Map, Value};
use sinew_ipc::Client;
use sinew_plot::Field;

use crate::history::{History, Shape};
use crate::quantity;

/// For how long at most the curves of a driver reach back, s.
const LONGEST_S: f64 = 60.0;

/// What the pages see.
pub struct View {
    /// The curves.
    pub history: History,
    /// Raised whenever the history was begun anew.
    pub epoch: u64,
    /// What does not change, as a message to a page, but for the picture: [`View::hello`].
    pub hello: String,
    /// What does, as a message to a page.
    pub status: String,
    /// The connection to a driver, while there is one.
    pub client: Option<Arc<Client>>,
}

/// What does not change of what is shown: the first message to a page. `C` is what it is told of a channel.
#[derive(Serialize)]
pub(crate) struct Hello<'a, C> {
    kind: &'static str,
    /// What is shown: a driver, or a stream of numbers.
    of: &'static str,
    rig: &'a str,
    simulated: bool,
    version: &'static str,
    epoch: u64,
    /// Values of a bin: 1, or 2 for the least and the largest.
    values: usize,
    capacity: usize,
    span_s: f64,
    commands: bool,
    quantities: Vec<Panel<'a>>,
    channels: Vec<C>,
}

impl<'a, C: Serialize> Hello<'a, C> {
    /// Of curves of this shape; `of` and `name` are what is shown, `commands` is whether a page may ask for anything.
    pub fn new(of: &'static str, name: &'a str, commands: bool, shape: &Shape, epoch: u64) -> Hello<'a, C> {
        Hello {
            kind: "hello",
            of,
            rig: name,
            simulated: false,
            version: env!("CARGO_PKG_VERSION"),
            epoch,
            values: shape.values(),
            capacity: shape.capacity(),
            span_s: shape.span_s(),
            commands,
            quantities: Vec::new(),
            channels: Vec::new(),
        }
    }

    /// With these panels and channels.
    pub fn with(self, quantities: impl Iterator<Item = Panel<'a>>, channels: impl Iterator<Item = C>) -> Hello<'a, C> {
        Hello { quantities: quantities.collect(), channels: channels.collect(), ..self }
    }
}

/// A panel of the page.
#[derive(Serialize)]
pub(crate) struct Panel<'a> {
    pub name: &'a str,
    pub title: String,
    pub unit: &'a str,
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
        let mut view = View::of(shape(&client));
        view.meet(client, commands);
        view
    }

    /// Of something of this shape, of which nothing is known yet.
    pub fn of(shape: Shape) -> View {
        View { history: History::new(shape), epoch: 0, hello: String::new(), status: String::new(), client: None }
    }

    /// Shows something else from here on: what it is, and its curves, of this shape.
    pub fn begin(&mut self, shape: Shape, hello: impl FnOnce(&Shape, u64) -> String) {
        if shape != *self.history.shape() {
            self.history = History::new(shape);
        }
        self.epoch += 1;
        self.hello = hello(self.history.shape(), self.epoch);
    }

    /// The first message to a page. That there is a picture of the machine is added here, once for drivers and streams:
    /// whoever opens a scope says so only afterwards.
    pub fn hello(&self, pictured: bool) -> String {
        if !pictured {
            return self.hello.clone();
        }
        let mut hello: Map<String, Value> = serde_json::from_str(&self.hello).unwrap_or_default();
        hello.insert("picture".into(), true.into());
        json(&hello)
    }

    /// Takes up a driver. One with the same channels and rate as the last goes on in the same curves.
    pub fn meet(&mut self, client: Arc<Client>, commands: bool) {
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
            Panel { name, title, unit }
        });
        self.begin(shape(&client), |shape, epoch| {
            let hello = Hello::new("driver", info.rig.as_str(), commands, shape, epoch).with(quantities, channels);
            json(&Hello { simulated: info.simulated != 0, ..hello })
        });
        self.client = Some(client);
    }
}

fn shape(client: &Client) -> Shape {
    Shape {
        channels: client.channels().len(),
        quantities: quantity::COUNT,
        rate_hz: client.info().rate_hz,
        longest_s: LONGEST_S,
    }
}

/// As JSON; what cannot be written so is not sent.
pub fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|_| "{}".into())
}
