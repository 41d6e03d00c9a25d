//! `sinew-trust`: inject every fault, measure what happens, write the table.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, Subcommand};
use sinew_backend::allocations::CountingAllocator;
use sinew_linux_backend::guard;
use sinew_trust::failure::Failure;
use sinew_trust::site::Site;
use sinew_trust::{burn, clients, drive, kinds, process, restart, soak, table, terminals};

#[derive(Debug, Parser)]
#[command(
    name = "sinew-trust",
    about = "Injects every fault, measures what happens at the output, and writes the table"
)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Every kind of fault, at random phases.
    #[command(
        after_help = "Examples:\n  sinew-trust faults --tries 100 --table docs/trust-table.md\n  sinew-trust faults --only open --tries 1000"
    )]
    Faults(Faults),
    /// Everything at once, for half an hour: random faults, clients, a recorder, load.
    Soak(soak::Args),
    /// A driver with a witness, that breaks on demand (used by the others).
    #[command(hide = true)]
    Drive(drive::Args),
    /// A client that is struck (used by the others).
    #[command(hide = true)]
    Client {
        /// Name of the rig.
        rig: String,
        /// What it does.
        task: Vec<String>,
    },
    /// Random histories of kills, restarts, stalls, faults and commands; judges by the true temperature.
    #[command(
        after_help = "Examples:\n  sinew-trust burn\n  sinew-trust burn --histories 10000\n  sinew-trust burn --seed 4711 --histories 1 --verbose"
    )]
    Burn(burn::Args),
    /// Drivers that are killed and started again: whether the same demand gets the same duty three seconds later.
    Restart,
    /// A driver's threads between a signal and its outputs, and nothing else (used by the others).
    #[command(hide = true)]
    Chain {
        /// The rig file.
        rig: PathBuf,
        /// Where the times go.
        stamps: PathBuf,
    },
    /// Takes all of a core (used by the others).
    #[command(hide = true)]
    Occupy,
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[derive(Debug, clap::Args)]
struct Faults {
    /// Tries of each kind.
    #[arg(long, default_value_t = 100)]
    tries: usize,
    /// Only kinds whose name contains this.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Seed of all random phases.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes everything measured as JSON, after each kind.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Takes what this run does not measure from the JSON of an earlier one.
    #[arg(long, value_name = "FILE.json")]
    with: Vec<PathBuf>,
    /// Writes the table as Markdown.
    #[arg(long, value_name = "FILE.md")]
    table: Option<PathBuf>,
    /// Only lists the kinds.
    #[arg(long)]
    list: bool,
}

fn main() -> ExitCode {
    // A driver of Linux's own outputs starts its own program as their guard.
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|word| word == guard::WORD) {
        return guard::main(arguments);
    }
    let result = match Args::parse().command {
        Command::Faults(args) => faults(&args),
        Command::Soak(args) => soak::soak(&args),
        Command::Drive(args) => drive::drive(&args).map(|()| true),
        Command::Client { rig, task } => clients::client_main(&rig, &task).map(|()| true),
        Command::Burn(args) => burn::burn(&args),
        Command::Restart => restart::restart(),
        Command::Chain { rig, stamps } => terminals::chain(&rig, &stamps).map(|()| true),
        Command::Occupy => {
            process::occupy();
            Ok(true)
        }
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

/// Whether every promise was kept.
fn faults(args: &Faults) -> Result<bool, Failure> {
    let wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|part| name.contains(part.as_str()));
    let kinds: Vec<_> = kinds().into_iter().filter(|kind| wanted(kind.name)).collect();
    if kinds.is_empty() {
        eprintln!("error: no kind is called like that\nhint: `sinew-trust faults --list` lists them");
        return Ok(false);
    }
    if args.list {
        for kind in &kinds {
            println!("{:<32} {}", kind.name, kind.injected);
        }
        return Ok(true);
    }
    let earlier = args.with.iter().map(|path| table::earlier(path)).collect::<Result<Vec<_>, _>>()?;
    let site = Site::new()?;
    let started = Instant::now();
    let mut report =
        table::Report { schema: table::SCHEMA, tries: args.tries, seed: args.seed, seconds: 0.0, rows: Vec::new() };
    for kind in sinew_trust::kinds() {
        let row = if wanted(kind.name) {
            let row = kind.measure(&site, args.tries, args.seed);
            println!("{}", table::line(&row));
            row
        } else {
            match earlier.iter().rev().find_map(|rows| rows.get(kind.name)) {
                Some(measured) => kind.row(measured.clone()),
                None => continue,
            }
        };
        report.rows.push(row);
        report.seconds = started.elapsed().as_secs_f64();
        if let Some(path) = &args.json {
            let text = serde_json::to_string_pretty(&report).map_err(std::io::Error::other)?;
            std::fs::write(path, text + "\n")?;
        }
    }
    let (kept, all) = (report.kept(), report.rows.len());
    println!("{all} kinds, kept in {kept}, {:.0} s", report.seconds);
    if let Some(path) = &args.table {
        std::fs::write(path, table::markdown(&report))?;
    }
    Ok(kept == all)
}
