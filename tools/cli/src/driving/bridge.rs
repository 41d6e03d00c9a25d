//! `sinew bridge`: the running driver for other programs and machines.

use std::io;
use std::net::SocketAddr;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_bridge::{Error, Foxglove, Options, Prometheus, Traffic};

use super::live;
use crate::args;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// `sinew bridge prometheus`.
pub fn prometheus(args: &args::Prometheus) -> Outcome {
    let options = Options { rig: rig(&args.target)?, listen: args.listen };
    let bridge = Prometheus::open(&options).map_err(failure)?;
    let (address, traffic) = (bridge.address(), bridge.traffic());
    until_asked(&format!("http://{address}/metrics"), address, args.duration_s, &traffic, |over| bridge.serve(over))
}

/// `sinew bridge foxglove`.
pub fn foxglove(args: &args::Foxglove) -> Outcome {
    let options = Options { rig: rig(&args.target)?, listen: args.listen };
    let bridge = Foxglove::open(&options, args.rate_hz).map_err(failure)?;
    let (address, traffic, lost) = (bridge.address(), bridge.traffic(), bridge.lost());
    let served = until_asked(&format!("ws://{address}"), address, args.duration_s, &traffic, |over| bridge.serve(over));
    output::note(format_args!("messages lost by viewers that were too slow: {}", lost()));
    served
}

/// `sinew bridge zenoh`: becomes that program, beside this one or wherever programs are.
pub fn zenoh(args: &args::Zenoh) -> Outcome {
    const PROGRAM: &str = "sinew-zenoh";
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name(PROGRAM)).filter(|path| path.is_file());
    // comes back only where it cannot be started
    let error = Command::new(beside.as_deref().unwrap_or(Path::new(PROGRAM))).args(&args.arguments).exec();
    Err(match error.kind() {
        io::ErrorKind::NotFound => Failure::input(format!(
            "the bridge to Zenoh is a program of its own, {PROGRAM}: neither beside this one nor in PATH"
        ))
        .hint(format!(
            "in a clone: `cargo build --release --manifest-path tools/zenoh/Cargo.toml`, then put {PROGRAM} into PATH"
        )),
        _ => Failure::own(format!("{PROGRAM} cannot be started: {error}")),
    })
}

/// The rig that is meant; a named one may have no driver yet.
fn rig(target: &args::Target) -> Result<String, Failure> {
    live::rig(target).map_err(|failure| match failure.code() {
        1 => failure.hint("start one with `sinew run RIG.toml`, or name the rig with --rig: its driver is waited for"),
        _ => failure,
    })
}

/// Serves until a signal or the end of the time; says where, and afterwards who came.
fn until_asked(
    url: &str,
    address: SocketAddr,
    duration_s: Option<f64>,
    traffic: &Arc<Traffic>,
    serve: impl FnOnce(&dyn Fn() -> bool) -> Result<(), Error>,
) -> Outcome {
    let asked = ending::asked()?;
    log::never_wait()?;
    output::print(format_args!("{url}\n"))?;
    if !address.ip().is_loopback() {
        output::note(format_args!("whoever reaches {address} sees the state of every channel"));
    }
    output::note("Ctrl-C ends it");
    let end = duration_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let served = serve(&|| asked.load(Ordering::Relaxed) || end.is_some_and(|end| Instant::now() >= end));
    output::note(traffic.figures());
    served.map_err(failure)
}

fn failure(error: Error) -> Failure {
    match error {
        Error::Rig(error) => live::failure(error),
        Error::Address { .. } => {
            Failure::input(&error).hint("choose another with --listen; port 0 is any that is free")
        }
        Error::Died(_) => Failure::own(error).hint("start it again, and please report this"),
        Error::System { .. } => Failure::own(error),
    }
}
