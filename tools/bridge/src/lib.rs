//! A running driver for other programs, also on other machines: each bridge is an ordinary client of the driver with a port.
//!
//! | bridge | speaks | for |
//! |---|---|---|
//! | [`Prometheus`] | OpenMetrics over HTTP | Prometheus, Grafana, alerts |
//! | [`Foxglove`] | the Foxglove WebSocket protocol | Foxglove, Lichtblick, PlotJuggler |
//!
//! No socket of the network belongs to a driver: a bridge is a process of its own, started by whoever wants it, and it only
//! reads: nothing that comes over the network becomes a command. It waits for a driver that is not there yet, and finds it again
//! after a restart ([`Finder`]). What is sent of every cycle is made once ([`watch`]), also for the bridge to Zenoh, which is a program of
//! its own (`tools/zenoh`). Connections, clients and rates are bounded and refusals counted by `sinew_server`.
//!
//! ```no_run
//! use sinew_bridge::{Options, Prometheus};
//!
//! let options = Options { rig: "hexapod".into(), listen: "127.0.0.1:9464".parse()? };
//! let bridge = Prometheus::open(&options)?;
//! println!("scrape http://{}/metrics", bridge.address());
//! bridge.serve(|| false)?; // until the closure says that it is time
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod finder;
mod foxglove;
mod options;
mod prometheus;
pub mod watch;

pub use error::Error;
pub use finder::{Finder, has_ended};
pub use foxglove::Foxglove;
pub use options::Options;
pub use prometheus::{Prometheus, metric_table_markdown};
pub use sinew_server::{Figures, Traffic};
