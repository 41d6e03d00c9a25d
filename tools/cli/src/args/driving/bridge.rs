//! Bridges: a running driver for other programs and machines.

use std::ffi::OsString;
use std::net::{Ipv4Addr, SocketAddr};

use clap::{Args, Subcommand};

use super::Target;
use crate::args::numbers::{positive, seconds};

/// `sinew bridge`.
#[derive(Debug, Args)]
pub struct Bridge {
    /// To what.
    #[command(subcommand)]
    pub what: BridgeWhat,
}

/// To what.
#[derive(Debug, Subcommand)]
pub enum BridgeWhat {
    /// Metrics for Prometheus, and so for Grafana and its alerts.
    Prometheus(Prometheus),
    /// Every cycle, live, for Foxglove, Lichtblick and PlotJuggler.
    Foxglove(Foxglove),
    /// State and streams for Zenoh, and commands by certificate: starts `sinew-zenoh`, a program of its own.
    Zenoh(Zenoh),
}

/// `sinew bridge prometheus`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bridge prometheus                              then `curl http://127.0.0.1:9464/metrics`
  sinew bridge prometheus --rig hexapod --listen 0.0.0.0:9464

A process of its own that only reads; the driver has no port. It waits for its driver and finds it again: `sinew_up` is 0
meanwhile. Whoever reaches the port sees every channel's state, and can do nothing. Ctrl-C ends it.")]
pub struct Prometheus {
    /// Which driver; of a named rig it need not run yet.
    #[command(flatten)]
    pub target: Target,
    /// Where to listen; port 0 = any that is free. Other machines reach it only at an address of this machine's network.
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = loopback(9464))]
    pub listen: SocketAddr,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
}

/// `sinew bridge foxglove`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bridge foxglove                        then open a connection to ws://127.0.0.1:8765 in Foxglove
  sinew bridge foxglove --rate 100             a hundred cycles a second instead of all
  sinew bridge foxglove --rig hexapod --listen 0.0.0.0:8765

Topics are those of a recording: /cycles, /events, /loop. A viewer that is too slow loses messages, which is counted and said
to it; the driver never waits. A process of its own that only reads; the driver has no port. Whoever reaches the port sees
every channel's state, and can do nothing: also a web page of anybody's in a browser of this machine. Ctrl-C ends it.")]
pub struct Foxglove {
    /// Which driver; of a named rig it need not run yet.
    #[command(flatten)]
    pub target: Target,
    /// Where to listen; port 0 = any that is free. Other machines reach it only at an address of this machine's network.
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = loopback(8765))]
    pub listen: SocketAddr,
    /// At most so many cycles a second, Hz; otherwise every one.
    #[arg(long = "rate", value_name = "HZ", value_parser = positive, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
}

/// `sinew bridge zenoh`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bridge zenoh                           state and streams at tcp/127.0.0.1:7447
  sinew bridge zenoh -- --help                 what else there is

It is a program of its own, sinew-zenoh, beside this one or in PATH: Zenoh is 270 crates, which nobody compiles who does
not want it. In a clone: `cargo build --release --manifest-path tools/zenoh/Cargo.toml`.")]
pub struct Zenoh {
    /// What sinew-zenoh is told.
    #[arg(value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

fn loopback(port: u16) -> SocketAddr {
    (Ipv4Addr::LOCALHOST, port).into()
}
