//! `sinew`: the command line. Each command is a file in `commands/`; this one only chooses it and turns its end into an
//! exit code.

mod args;
mod commands;
mod failure;
mod output;
mod screen;
mod setpoint;

use std::process::ExitCode;

use clap::Parser;

use args::{BenchWhat, Cli, Command};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return output::usage(&error),
    };
    let outcome = match &cli.command {
        Command::Simulate(args) => commands::simulate::simulate(args),
        Command::Status(args) => commands::status::status(args),
        Command::Monitor(args) => commands::monitor::monitor(args),
        Command::Set(args) => commands::set::set(args),
        Command::Reset(args) => commands::set::reset(args),
        Command::Stop(args) => commands::set::stop(args),
        Command::Doctor(args) => commands::doctor::doctor(args),
        _ => todo!(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
