//! `sinew scope`: the running driver in a browser.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_scope::{Error, Options, Scope};

use super::live;
use super::monitor::signals;
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// Runs the command.
pub fn scope(args: &args::Scope) -> Outcome {
    if !args.record_dir.is_dir() {
        return Err(Failure::input(format!("{}: is no folder", args.record_dir.display()))
            .hint(format!("mkdir -p {}", args.record_dir.display())));
    }
    // the same driver from here on, through its restarts
    let rig = live::connect(&args.target)?.info().rig.to_string();
    let options = Options { rig, port: args.port, record_dir: args.record_dir.clone(), commands: !args.no_commands };
    let scope = Scope::open(options).map_err(failure)?;
    let asked = signals()?;
    log::never_wait()?;
    output::print(format_args!("{}\n", scope.url(!args.no_commands)))?;
    if !args.no_commands {
        output::note(format_args!("to watch only: {}", scope.url(false)));
    }
    output::note("Ctrl-C ends it");
    let end = args.duration_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let traffic = scope.traffic();
    let served = scope.serve(|| asked.load(Ordering::Relaxed) || end.is_some_and(|end| Instant::now() >= end));
    output::note(traffic.figures());
    served.map_err(failure)
}

fn failure(error: Error) -> Failure {
    match error {
        Error::Driver(error) => live::failure(error),
        Error::Port { .. } => Failure::input(&error).hint("choose another with --port, or leave it out for a free one"),
        Error::Died(_) => Failure::own(error).hint("start it again, and please report this"),
        Error::Random { .. } | Error::System { .. } => Failure::own(error),
    }
}
