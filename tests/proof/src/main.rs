//! Makes concealed cases with a simulator of its own and scores the diagnosis on them.
#![forbid(unsafe_code)]

mod diagnose_case;
mod document;
mod failure;
mod frozen;
mod holdout;
mod made;
mod order;
mod run;
mod score;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use clap::{Parser, Subcommand};
use rayon::prelude::*;
use sinew_concealed::generator::plan::{self, Seeds, Spec};
use sinew_concealed::judged::Judged;

use failure::Failure;
use run::Limits;

/// Concealed cases, and how the diagnosis does on them.
#[derive(Debug, Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    which: Which,
    /// Keep every case's files here; a temporary folder otherwise
    #[arg(long)]
    out: Option<PathBuf>,
    /// Take what an earlier run into the same folder has made or diagnosed already
    #[arg(long, requires = "out")]
    resume: bool,
    /// Page to write; docs/proof.md for a full scoring run, none otherwise
    #[arg(long)]
    docs: Option<PathBuf>,
}

/// Which cases.
#[derive(Debug, clap::Args)]
struct Which {
    /// The first so many cases of the plan
    #[arg(long, global = true)]
    cases: Option<usize>,
    /// Which seeds; by default those for scoring where all of the plan runs, those for development otherwise
    #[arg(long, global = true, value_enum)]
    seeds: Option<Seeds>,
    /// About thirty cases that have some of everything
    #[arg(long, global = true)]
    quick: bool,
    /// Only cases whose name or content has this in it
    #[arg(long, global = true)]
    only: Option<String>,
    /// Cases at once; the long ones always run one after the other, on two threads
    #[arg(long, global = true, default_value_t = 1)]
    jobs: usize,
    /// Seconds of computing, on each of its threads, after which a diagnosis is ended and counts as none
    #[arg(long, global = true, default_value_t = 300)]
    limit: u64,
    /// Seconds after which no further case is begun; how many those are is said, and they count nowhere
    #[arg(long, global = true, value_name = "SECONDS")]
    within: Option<u64>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Only write the cases, each in a folder of its own
    Generate {
        /// Folder to write into
        #[arg(long)]
        out: PathBuf,
    },
    /// Whether an answer depends on the order of the recordings, the blocks kept back or the number of threads
    Order(order::Order),
    /// Write the plan of a scoring run with its hash and that of the generators, to be committed before anything is scored
    Plan,
    /// Write the page from what earlier runs left in a folder, running nothing
    Document {
        /// Folder of the cases
        #[arg(long)]
        out: PathBuf,
    },
    /// Diagnose the case in one folder; every case is run so, in a process of its own
    #[command(hide = true)]
    One {
        /// Its folder
        folder: PathBuf,
        /// Threads
        #[arg(long, default_value_t = 1)]
        threads: usize,
    },
}

impl Which {
    /// Nothing is left out of the plan.
    fn is_full(&self) -> bool {
        self.cases.is_none() && self.only.is_none() && !self.quick
    }

    /// What one looks at while building must not be what is scored.
    fn seeds(&self) -> Seeds {
        self.seeds.unwrap_or(if self.is_full() { Seeds::Score } else { Seeds::Dev })
    }

    fn limits(&self) -> Limits {
        Limits { case: Duration::from_secs(self.limit), begin: self.within.map(Duration::from_secs) }
    }

    fn specs(&self) -> Vec<Spec> {
        let seeds = self.seeds();
        let mut specs = if self.quick { plan::quick(seeds) } else { plan::plan(seeds, self.cases) };
        if let Some(only) = &self.only {
            specs.retain(|s| s.name.contains(only) || format!("{:?}", s.what).contains(only));
        }
        specs
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match &arguments.command {
        Some(Command::Generate { out }) => generate(&arguments.which, out),
        Some(Command::One { folder, threads }) => one(&arguments.which, folder, *threads),
        Some(Command::Order(order)) => order.run(),
        Some(Command::Plan) => frozen::write().map(|path| println!("{}", path.display())),
        Some(Command::Document { out }) => document(&arguments, out),
        None => proof(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sinew-proof: {error}");
            ExitCode::FAILURE
        }
    }
}

fn one(which: &Which, folder: &Path, threads: usize) -> Result<(), Failure> {
    let done = diagnose_case::compute_at_most(which.limits().case, threads)
        .and_then(|()| diagnose_case::diagnose_case(folder, threads));
    done.map(|_| ()).map_err(|error| error.to_string().into())
}

fn generate(which: &Which, out: &Path) -> Result<(), Failure> {
    let specs = which.specs();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(which.jobs.max(1)).build()?;
    let done = AtomicUsize::new(0);
    pool.install(|| {
        specs.par_iter().with_max_len(1).try_for_each(|spec| {
            let a = made::write(spec, &out.join(&spec.name))?;
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            eprintln!("{done}/{} {} {}: {}, level {:.2}", specs.len(), a.name, a.group, a.kind, a.level);
            Ok(())
        })
    })
}

fn proof(arguments: &Arguments) -> Result<(), Failure> {
    let which = &arguments.which;
    let specs = which.specs();
    if specs.is_empty() {
        return Err("there is no such case in the plan".into());
    }
    if which.seeds() == Seeds::Score {
        frozen::check()?;
    }
    let temporary = tempfile::tempdir()?;
    let out = arguments.out.as_deref().unwrap_or(temporary.path());
    let judged = run::run(&specs, out, which.jobs, arguments.resume, which.limits())?;
    if judged.len() < specs.len() {
        eprintln!(
            "{} of {} cases were not begun within {} s",
            specs.len() - judged.len(),
            specs.len(),
            which.within.unwrap_or(0)
        );
    }
    page(arguments, &judged, out)
}

fn document(arguments: &Arguments, out: &Path) -> Result<(), Failure> {
    let specs = arguments.which.specs();
    if arguments.which.seeds() == Seeds::Score {
        frozen::check()?;
    }
    let judged = run::left_behind(&specs, out)?;
    if judged.len() < specs.len() {
        eprintln!("{} of {} cases have been diagnosed", judged.len(), specs.len());
    }
    page(arguments, &judged, out)
}

/// Writes `score.json` beside the cases, and the page.
fn page(arguments: &Arguments, judged: &[Judged], out: &Path) -> Result<(), Failure> {
    let which = &arguments.which;
    let figures = serde_json::json!({
        "figures": score::figures(judged),
        "confusion": score::confusion(judged),
        "cases": judged.iter().map(|j| serde_json::json!({ "answer": j.answer, "said": j.reported })).collect::<Vec<_>>(),
    });
    fs::write(out.join("score.json"), serde_json::to_string_pretty(&figures)? + "\n")?;
    let full = which.is_full() && which.seeds() == Seeds::Score;
    let docs = arguments.docs.clone().or_else(|| full.then(|| PathBuf::from("docs/proof.md")));
    let before = docs.as_ref().and_then(|path| fs::read_to_string(path).ok()).unwrap_or_default();
    let hashes = if which.seeds() == Seeds::Score { Some(frozen::check()?) } else { None };
    let page = document::page(judged, hashes.as_ref(), &before);
    match docs {
        Some(path) => fs::write(path, page)?,
        None => print!("{page}"),
    }
    Ok(())
}
