//! Makes concealed cases with a simulator of its own and scores the diagnosis on them.
#![forbid(unsafe_code)]

mod generator;
#[cfg(test)]
mod held;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::{Parser, Subcommand};
use rayon::prelude::*;

use generator::plan::{self, Seeds, Spec};

/// Concealed cases, and how the diagnosis does on them.
#[derive(Debug, Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    which: Which,
}

/// Which cases.
#[derive(Debug, clap::Args)]
struct Which {
    /// The first so many cases of the plan
    #[arg(long, global = true)]
    cases: Option<usize>,
    /// Which seeds: nothing is ever tuned on those for scoring
    #[arg(long, global = true, value_enum, default_value = "score")]
    seeds: Seeds,
    /// About thirty cases that have some of everything
    #[arg(long, global = true)]
    quick: bool,
    /// Only cases whose name or content has this in it
    #[arg(long, global = true)]
    only: Option<String>,
    /// Cases at once
    #[arg(long, global = true, default_value_t = 2)]
    jobs: usize,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Only write the cases, each in a folder of its own
    Generate {
        /// Folder to write into
        #[arg(long)]
        out: PathBuf,
    },
}

impl Which {
    fn specs(&self) -> Vec<Spec> {
        let mut specs = if self.quick { plan::quick(self.seeds) } else { plan::plan(self.seeds, self.cases) };
        if let Some(only) = &self.only {
            specs.retain(|s| s.name.contains(only) || format!("{:?}", s.what).contains(only));
        }
        specs
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match arguments.command {
        Some(Command::Generate { out }) => match generate(&arguments.which, &out) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("sinew-proof: {error}");
                ExitCode::FAILURE
            }
        },
        None => ExitCode::FAILURE,
    }
}

fn generate(which: &Which, out: &std::path::Path) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let specs = which.specs();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(which.jobs.max(1)).build()?;
    let done = AtomicUsize::new(0);
    pool.install(|| {
        specs.par_iter().try_for_each(|spec| {
            let case = generator::case::make(spec);
            case.write(&out.join(&spec.name))?;
            let a = &case.answer;
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            eprintln!("{done}/{} {} {}: {} level {:.2}", specs.len(), a.name, a.group, a.kind, a.level);
            Ok(())
        })
    })
}
