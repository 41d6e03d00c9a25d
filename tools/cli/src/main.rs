//! `sinew`: the command line. Each command is a file in `commands/`; this one dispatches to it and converts its result to an
//! exit code.

mod args;
mod backend;
mod commands;
mod failure;
mod format;
mod log;
mod output;
mod progress;
mod robots;
mod score;
mod screen;
mod setpoint;
mod typed;

use std::process::ExitCode;

use clap::Parser;
use sinew_linux_backend::guard;

use args::{BenchWhat, BridgeWhat, Cli, Command, RecordingWhat};

/// Counts allocations by thread, so that a run can report those of its loop.
#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

fn main() -> ExitCode {
    // A driver on Linux's own outputs starts this very program a second time, to watch over them.
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|word| word == guard::WORD) {
        return guard::main(arguments);
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return output::usage(&error),
    };
    log::start(cli.wordiness());
    let outcome = match &cli.command {
        Command::Simulate(args) => commands::simulate::simulate(args),
        Command::Identify(args) => commands::identify::identify(args),
        Command::Diagnose(args) if args.whole_rig => commands::whole_rig::diagnose(args),
        Command::Diagnose(args) => commands::diagnose::diagnose(args),
        Command::Tour(args) => commands::tour::tour(args),
        Command::Demo(args) => commands::demo::demo(args),
        Command::Repeat(args) => commands::repeat::repeat(args),
        Command::Conceal(args) => commands::conceal::conceal(args),
        Command::Reveal(args) => commands::conceal::reveal(args),
        Command::Status(args) => commands::status::status(args),
        Command::Monitor(args) => commands::monitor::monitor(args),
        Command::Scope(args) => commands::scope::scope(args),
        Command::Bridge(bridge) => match &bridge.what {
            BridgeWhat::Prometheus(args) => commands::bridge::prometheus(args),
            BridgeWhat::Foxglove(args) => commands::bridge::foxglove(args),
        },
        Command::Set(args) => commands::set::set(args),
        Command::Play(args) => commands::play::play(args),
        Command::Reset(args) => commands::set::reset(args),
        Command::Stop(args) => commands::set::stop(args),
        Command::Record(args) => commands::record::record(args),
        Command::Recording(recording) => match &recording.what {
            RecordingWhat::Info(args) => commands::recording::info(args),
            RecordingWhat::Doctor(args) => commands::recording::doctor(args),
            RecordingWhat::Recover(args) => commands::recording::recover(args),
        },
        Command::Life(args) => commands::life::life(args),
        Command::Plot(args) => commands::plot::plot(args),
        Command::Astm(args) => commands::astm::astm(args),
        Command::Tune(args) => commands::tune::tune(args),
        Command::Export(args) => commands::export::export(args),
        Command::Import(args) => commands::import::import(args),
        Command::Replay(args) => commands::replay::replay(args),
        Command::Design(args) => commands::design::design(args),
        Command::Test(args) => commands::test::test(args),
        Command::New(args) => commands::new::new(args),
        Command::Check(args) => commands::rig_file::check(args),
        Command::Schema(args) => commands::rig_file::schema(args),
        Command::Completions(args) => commands::shell::completions(args),
        Command::Man(args) => commands::shell::man(args),
        Command::Doctor(args) => commands::doctor::doctor(args),
        Command::Bringup(args) => commands::bringup::bringup(args),
        Command::Run(args) => commands::run::run(args),
        Command::Bench(bench) => match &bench.what {
            BenchWhat::Loop(args) => commands::bench::bench_loop(args),
            BenchWhat::Control(args) => commands::bench_control::bench_control(args),
        },
        Command::Thesis(args) => commands::thesis::thesis(args),
    };
    let code = match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::error(&failure);
            ExitCode::from(failure.code())
        }
    };
    log::finish();
    code
}
