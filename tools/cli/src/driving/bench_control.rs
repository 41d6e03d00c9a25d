//! `sinew bench control`: every controller, estimator and sensing method on the same plants.

use std::io::{self, IsTerminal};
use std::path::Path;

use sinew_bench::{Answer, Choice, Filter, Plan, Plant, Ran};
use sinew_rig::nearest;

use crate::args;
use crate::commands::diagnose::write_all;
use crate::commands::fitting::command;
use crate::commands::list;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// The answer for programs.
const JSON: &str = "bench.json";
/// The answer for people.
const REPORT: &str = "report.html";
/// Seeds of a full run, and of a quick one, unless told otherwise.
const SEEDS: (u16, u16) = (3, 1);

/// Rows of a run that is long enough for a line at every tenth of it where stderr is no terminal.
const LONG: usize = 100;

/// Runs the command.
pub fn bench_control(args: &args::BenchControl) -> Outcome {
    let plan = plan(args)?;
    for folder in [&args.out, &args.pictures].into_iter().flatten() {
        output::can_become_folder(folder)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs.map_or(0, usize::from))
        .build()
        .map_err(|error| Failure::own(format!("threads: {error}")).hint("ask for fewer with --jobs"))?;
    let (ran, sensing, reachable) = pool.install(|| {
        let ran = run(&plan);
        let shown = plan.plants.first().and_then(|name| Plant::named(name)).filter(|_| !args.quick);
        (ran, sinew_bench::sensing_report(args.quick), shown.map(sinew_bench::reachable).unwrap_or_default())
    });
    let answer = Answer::of(&plan, &ran, sensing, reachable, command());
    let _asked = ending::asked()?;
    let json = output::json(&answer)? + "\n";
    if let Some(out) = &args.out {
        write_all(out, &[(REPORT, &sinew_bench::page(&answer, &ran)), (JSON, &json)])?;
        written(out, &[REPORT, JSON]);
    }
    if let Some(folder) = &args.pictures {
        let pictures = sinew_bench::pictures(&answer, &ran);
        let files: Vec<(&str, &str)> = pictures.iter().map(|(name, svg)| (*name, svg.as_str())).collect();
        write_all(folder, &files)?;
        written(folder, &files.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
    if args.json { output::print(json) } else { output::print(sinew_bench::text(&answer)) }
}

fn written(folder: &Path, names: &[&str]) {
    let names = names.iter().map(|name| folder.join(name).display().to_string()).collect::<Vec<_>>();
    output::note(format_args!("written: {}", names.join(", ")));
}

/// What is to be run, every name checked.
fn plan(args: &args::BenchControl) -> Result<Plan, Failure> {
    let all = Choice::all();
    let of_joint = Choice::of_joint();
    known("controller", &args.controller, all.iter().chain(&of_joint).map(|choice| choice.controller.as_str()))?;
    known("estimator", &args.estimator, all.iter().map(|choice| choice.estimator.as_str()))?;
    known("plant", &args.plant, Plant::all().iter().map(|plant| plant.name))?;
    let filter =
        Filter { controllers: args.controller.clone(), estimators: args.estimator.clone(), plants: args.plant.clone() };
    let seeds = |default: u16| usize::from(args.seeds.unwrap_or(default));
    let plan = if args.quick { Plan::quick(seeds(SEEDS.1)) } else { Plan::full(seeds(SEEDS.0)) };
    Ok(plan.only(&filter))
}

/// Refuses a name there is none of, with what was probably meant.
fn known<'a>(what: &str, asked: &[String], words: impl Iterator<Item = &'a str>) -> Outcome {
    let mut known: Vec<&str> = Vec::new();
    for word in words {
        if !known.contains(&word) {
            known.push(word);
        }
    }
    match asked.iter().find(|word| !known.contains(&word.as_str())) {
        None => Ok(()),
        Some(word) => {
            let failure = Failure::input(format!("--{what} {word}: there is no such {what}"));
            Err(match nearest(word, known.iter().copied()) {
                Some(near) => failure.hint(format!("did you mean \"{near}\"?")),
                None => failure.hint(format!("there are {}", list(known.into_iter()))),
            })
        }
    }
}

/// Runs the rows, with a line that says how far the work is.
fn run(plan: &Plan) -> Vec<Ran> {
    let rows = plan.rows();
    output::note(format_args!("{rows} rows, on {} plants", plan.plants.len()));
    let progress = Progress::new();
    let tenths = !io::stderr().is_terminal() && rows >= LONG;
    let ran = sinew_bench::run(plan, &|done| {
        progress.tell("running", done as f64 / rows.max(1) as f64);
        if tenths && 10 * done / rows > 10 * (done - 1) / rows {
            output::note(format_args!("{} %", 100 * done / rows));
        }
    });
    progress.clear();
    ran
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_checked_before_anything_runs() {
        let words = || ["sliding_mode", "pi"].into_iter();
        assert!(known("controller", &["pi".into()], words()).is_ok());
        let failure = known("controller", &["sliding_mod".into()], words()).unwrap_err();
        assert_eq!(failure.code(), 2);
        assert!(failure.to_string().contains("did you mean \"sliding_mode\"?"), "{failure}");
        let failure = known("plant", &["moon".into()], words()).unwrap_err();
        assert!(failure.to_string().contains("there are sliding_mode, pi"), "{failure}");
    }
}
