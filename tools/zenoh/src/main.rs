//! `sinew-zenoh`: a running driver for Zenoh. Its state and streams for whoever may connect, and commands by whoever has a certificate
//! for it.
//!
//! A bridge as those of `sinew bridge` are: an ordinary client of the driver, a process of its own, started by whoever wants it. A program
//! of its own because Zenoh is 270 crates, which nobody compiles who does not want it.
//!
//! The watching thread publishes every cycle, encoded as in recordings ([`stage`]); the main thread answers commanders ([`desk`]) and
//! publishes what is for people. What is allowed stands in [`settings`], what is where in [`keys`].

mod args;
mod bridge;
mod certificates;
mod desk;
mod failure;
mod keys;
mod request;
mod settings;
mod stage;
mod station;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use sinew_ipc::Client;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use crate::args::{Args, What};
use crate::bridge::{Bridge, Options};
use crate::failure::{Failure, Outcome};

fn main() -> ExitCode {
    let args = Args::parse();
    log();
    let done = match args.what {
        Some(What::Certificates { folder, hosts, names }) => certificates::make(&folder, &hosts, &names).map(|made| {
            for name in made {
                println!("{}", folder.join(format!("{name}.pem")).display());
            }
        }),
        None => serve(args.bridge),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            failure.code().into()
        }
    }
}

fn serve(args: args::Bridge) -> Outcome {
    let asked = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, asked.clone()).map_err(Failure::own)?;
    }
    let options = Options {
        rig: args.rig.map_or_else(only_rig, Ok)?,
        listen: args.listen,
        certificates: args.certificates,
        commanders: args.commanders,
        rate_hz: args.rate_hz,
    };
    let bridge = Bridge::open(&options)?;
    println!("{}", bridge.endpoint());
    if !options.listen.ip().is_loopback() && options.certificates.is_none() {
        eprintln!("whoever reaches {} sees the state of every channel", options.listen);
    }
    if !options.commanders.is_empty() {
        eprintln!("commands are taken from {}", options.commanders.join(", "));
    }
    eprintln!("Ctrl-C ends it");
    let station = bridge.station();
    let end = args.duration_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let served = bridge.serve(|| asked.load(Ordering::Relaxed) || end.is_some_and(|end| Instant::now() >= end));
    let counts = &station.counts;
    eprintln!(
        "{} messages sent, {} cycles lost on the way from the driver; {} commands taken, {} refused",
        counts.sent.get(),
        counts.cycles_lost.get(),
        counts.taken.get(),
        counts.refused.get() + counts.too_many.get() + counts.not_alive.get() + counts.late.get()
    );
    served
}

/// The rig of the only driver that runs.
fn only_rig() -> Result<String, Failure> {
    let rigs = Client::discover()?;
    match rigs.as_slice() {
        [rig] => Ok(rig.clone()),
        [] => Err(Failure::own("no driver is running")
            .hint("start one with `sinew run RIG.toml`, or name the rig with --rig: its driver is waited for")),
        several => Err(Failure::input(format_args!("several drivers are running: {}", several.join(", ")))
            .hint("choose one with --rig NAME")),
    }
}

/// Our own information and everybody's warnings, on stderr; `RUST_LOG` has the last word.
fn log() {
    let usual = Targets::new()
        .with_default(LevelFilter::WARN)
        .with_target("sinew", LevelFilter::INFO)
        // it warns of what is wanted, and of what is refused in words of our own
        .with_target("zenoh::net", LevelFilter::ERROR);
    let asked = std::env::var("RUST_LOG").ok().filter(|asked| !asked.is_empty());
    let targets = asked.and_then(|asked| asked.parse().ok()).unwrap_or(usual);
    let layer = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(false).with_target(false);
    tracing_subscriber::registry().with(layer.without_time()).with(targets).init();
}
