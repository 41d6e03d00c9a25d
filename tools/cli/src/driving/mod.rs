//! What drives a rig, or talks to a driver that does: a command a file, and what they share.

mod admission;
mod attached;
mod backend;
mod bench;
#[cfg(thesis)]
mod bench_control;
#[cfg(network)]
mod bridge;
mod bringup;
mod characterise;
mod check;
mod demo;
mod design;
mod doctor;
mod held;
mod herald;
mod life;
mod live;
mod monitor;
mod mounted;
mod on_rig;
mod play;
mod program;
mod record;
mod replay;
mod robots;
mod run;
#[cfg(network)]
mod scope;
mod score;
mod screen;
mod set;
mod setpoint;
mod status;
mod test;
#[cfg(thesis)]
mod thesis;
mod tour;
mod typed;

use std::process::ExitCode;

use sinew_linux_backend::guard as watch;

#[cfg(network)]
use crate::args::BridgeWhat;
use crate::args::{BenchWhat, Driving};
use crate::failure::Outcome;

pub use program::of as program;

/// A driver on Linux's own outputs starts this very program a second time, to watch over them: then it does that, and no more.
pub fn guard() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    (arguments.next()? == watch::WORD).then(|| watch::main(arguments))
}

/// Runs the command.
pub fn dispatch(command: &Driving) -> Outcome {
    match command {
        Driving::Run(args) => run::run(args),
        Driving::Status(args) => status::status(args),
        Driving::Monitor(args) => monitor::monitor(args),
        #[cfg(network)]
        Driving::Scope(args) => scope::scope(args),
        #[cfg(network)]
        Driving::Bridge(bridge) => match &bridge.what {
            BridgeWhat::Prometheus(args) => bridge::prometheus(args),
            BridgeWhat::Foxglove(args) => bridge::foxglove(args),
            BridgeWhat::Zenoh(args) => bridge::zenoh(args),
        },
        Driving::Set(args) => set::set(args),
        Driving::Play(args) => play::play(args),
        Driving::Reset(args) => set::reset(args),
        Driving::Stop(args) => set::stop(args),
        Driving::Record(args) => record::record(args),
        Driving::Life(args) => life::life(args),
        Driving::Tour(args) => tour::tour(args),
        Driving::Demo(args) => demo::demo(args),
        Driving::Replay(args) => replay::replay(args),
        Driving::Design(args) => design::design(args),
        Driving::Test(args) => test::test(args),
        Driving::Doctor(args) => doctor::doctor(args),
        Driving::Bringup(args) => bringup::bringup(args),
        Driving::Bench(bench) => match &bench.what {
            BenchWhat::Loop(args) => bench::bench_loop(args),
            #[cfg(thesis)]
            BenchWhat::Control(args) => bench_control::bench_control(args),
        },
        #[cfg(thesis)]
        Driving::Thesis(args) => thesis::thesis(args),
    }
}
