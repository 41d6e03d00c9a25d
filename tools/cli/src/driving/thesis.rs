//! `sinew thesis`: the thesis page by page, beside what this program computes.

use sinew_thesis::{Chapter, Verdict};

use crate::args;
use crate::commands::diagnose::write_all;
use crate::commands::fitting::command;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// The book.
const PAGE: &str = "index.html";

/// Runs the command.
pub fn thesis(args: &args::Thesis) -> Outcome {
    let chapters = if args.chapters.is_empty() { Chapter::ALL.to_vec() } else { args.chapters.clone() };
    if args.list {
        return output::print(sinew_thesis::list(&chapters));
    }
    if let Some(out) = &args.out {
        output::can_become_folder(out)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs.map_or(0, usize::from))
        .build()
        .map_err(|error| Failure::own(format!("threads: {error}")).hint("ask for fewer with --jobs"))?;
    let progress = Progress::new();
    let book = pool.install(|| sinew_thesis::run(&chapters, &|share| progress.tell("running", share)));
    progress.clear();
    if let Some(out) = &args.out {
        write_all(out, &[(PAGE, &sinew_thesis::page(&book, &command()))])?;
        output::note(format_args!("written: {}", out.join(PAGE).display()));
    }
    output::print(sinew_thesis::summary(&book))?;
    match book.done.iter().filter(|done| matches!(done.verdict, Verdict::Unexplained(_))).count() {
        0 => Ok(()),
        count => Err(Failure::own(format!("{count} rows did not come out as their source declares"))
            .hint("this is a defect of the program: please report it with the lines above")),
    }
}
