//! `sinew`: the command line. Each command is a file: in `driving/` where it drives a rig or talks to what does, which is Linux's and may be left
//! out, else in `commands/`. This file dispatches to it and converts its result to an exit code.

// what both halves share has parts that only the driving one uses
#![cfg_attr(not(driver), allow(dead_code))]

mod args;
mod commands;
#[cfg(driver)]
mod driving;
mod ending;
mod failure;
mod format;
mod log;
mod output;
mod progress;
mod table;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command, RecordingWhat};

/// Counts allocations by thread, so that a run can report those of its loop.
#[cfg(driver)]
#[global_allocator]
static ALLOCATOR: sinew_backend::allocations::CountingAllocator = sinew_backend::allocations::CountingAllocator;

fn main() -> ExitCode {
    #[cfg(driver)]
    if let Some(ended) = driving::guard() {
        return ended;
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return output::usage(&error),
    };
    log::start(cli.wordiness());
    let outcome = match &cli.command {
        #[cfg(driver)]
        Command::Driving(command) => driving::dispatch(command),
        Command::Simulate(args) => commands::simulate::simulate(args),
        Command::Identify(args) => commands::identify::identify(args),
        Command::Diagnose(args) if args.whole_rig => commands::whole_rig::diagnose(args),
        Command::Diagnose(args) => commands::diagnose::diagnose(args),
        Command::Repeat(args) => commands::repeat::repeat(args),
        Command::Conceal(args) => commands::conceal::conceal(args),
        Command::Reveal(args) => commands::conceal::reveal(args),
        Command::Recording(recording) => match &recording.what {
            RecordingWhat::Info(args) => commands::recording::info(args),
            RecordingWhat::Doctor(args) => commands::recording::doctor(args),
            RecordingWhat::Recover(args) => commands::recording::recover(args),
        },
        Command::Plot(args) => commands::plot::plot(args),
        Command::Astm(args) => commands::astm::astm(args),
        Command::Tune(args) => commands::tune::tune(args),
        Command::Export(args) => commands::export::export(args),
        Command::Import(args) => commands::import::import(args),
        Command::New(args) => commands::new::new(args),
        Command::Check(args) => commands::rig_file::check(args),
        Command::Schema(args) => commands::rig_file::schema(args),
        Command::Completions(args) => commands::shell::completions(args),
        Command::Man(args) => commands::shell::man(args),
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
