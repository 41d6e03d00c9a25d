//! Runs the cases: each made in a folder, diagnosed by a process of its own, judged from what that left behind.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use rustix::process::Signal;
use sinew_concealed::generator::plan::Spec;
use sinew_concealed::judged::Judged;
use sinew_concealed::reported::{CRASHED, Reported, Took};

use crate::failure::Failure;
use crate::frozen;
use crate::made;
use crate::score::{figures, judged};

/// What the diagnosis of a case said, in its folder.
const SAID: &str = "said.json";
/// Cores of the long cases, which are timed.
const LONG_THREADS: usize = 2;

/// How long it may take.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// A diagnosis whose threads compute for longer, each, is ended and counts as none; a busy machine's waits do not count.
    pub case: Duration,
    /// No case is begun later than this after the first.
    pub begin: Option<Duration>,
}

/// Makes and diagnoses every case of `specs` in folders under `out`, `jobs` at once on one thread each; the long ones
/// afterwards, one at a time on two. Every answer is written at once; with `resume`, what has been made already, or
/// reported by this very program, is taken as it is.
///
/// # Errors
/// What kept a case from being made or judged; a diagnosis that fails is a case like any other.
pub fn run(specs: &[Spec], out: &Path, jobs: usize, resume: bool, limits: Limits) -> Result<Vec<Judged>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.max(1)).build()?;
    let done = Mutex::new(Vec::new());
    let started = Instant::now();
    let all = |spec: &Spec, threads: usize| -> Result<(), Failure> {
        if limits.begin.is_some_and(|begin| started.elapsed() > begin) {
            return Ok(());
        }
        let case = judge(spec, &out.join(&spec.name), threads, resume, limits.case)?;
        let mut done = done.lock().map_err(|_| "another case failed")?;
        done.push(case);
        report(&done, specs.len());
        Ok(())
    };
    // the order of the plan is kept, so that any moment has some of everything
    let (long, short): (Vec<&Spec>, Vec<&Spec>) = specs.iter().partition(|spec| spec.long);
    pool.install(|| short.par_iter().with_max_len(1).try_for_each(|spec| all(spec, 1)))?;
    long.iter().try_for_each(|spec| all(spec, LONG_THREADS))?;
    let mut judged = done.into_inner().map_err(|_| "a case failed")?;
    judged.sort_by(|a, b| a.answer.name.cmp(&b.answer.name));
    Ok(judged)
}

fn judge(spec: &Spec, folder: &Path, threads: usize, resume: bool, limit: Duration) -> Result<Judged, Failure> {
    let said_file = folder.join(SAID);
    let before = if resume { made::found(spec, folder)? } else { None };
    let answer = match before {
        Some(answer) => match said(&said_file)? {
            Some(said) if said.program == frozen::program()? => return Ok(judged(spec, answer, said)),
            _ => answer,
        },
        None => made::write(spec, folder)?,
    };
    if said_file.exists() {
        fs::remove_file(&said_file)?;
    }
    let reported = match diagnosed(folder, threads, limit) {
        Ok(()) => serde_json::from_slice(&fs::read(said_file)?)?,
        Err(Ended { why, took }) => {
            let mut none = Reported::refused(&format!("{CRASHED}: {why}"));
            (none.took, none.program) = (took, frozen::program()?);
            fs::write(said_file, serde_json::to_string_pretty(&none)? + "\n")?;
            none
        }
    };
    Ok(judged(spec, answer, reported))
}

/// What was reported in that file, if there is one.
fn said(file: &Path) -> Result<Option<Reported>, Failure> {
    Ok(if file.exists() { Some(serde_json::from_slice(&fs::read(file)?)?) } else { None })
}

/// What earlier runs left in folders under `out`, of these cases.
///
/// # Errors
/// A file that is there and cannot be read; reports of more than one program.
pub fn left_behind(specs: &[Spec], out: &Path) -> Result<Vec<Judged>, Failure> {
    let left = |spec: &Spec| -> Result<Option<Judged>, Failure> {
        let folder = out.join(&spec.name);
        let Some(answer) = made::found(spec, &folder)? else { return Ok(None) };
        Ok(said(&folder.join(SAID))?.map(|said| judged(spec, answer, said)))
    };
    let all: Result<Vec<_>, Failure> = specs.iter().map(left).collect();
    let all: Vec<Judged> = all?.into_iter().flatten().collect();
    let programs: BTreeSet<&str> = all.iter().map(|judged| judged.reported.program.as_str()).collect();
    if programs.len() > 1 {
        let out = out.display();
        let count = programs.len();
        return Err(format!(
            "{out}: holds what {count} builds of the diagnosis said; score one of them, with --resume"
        )
        .into());
    }
    Ok(all)
}

/// A diagnosis that ended without an answer.
struct Ended {
    why: String,
    took: Took,
}

/// Runs this program again for the one case, and waits.
fn diagnosed(folder: &Path, threads: usize, limit: Duration) -> Result<(), Ended> {
    let started = Instant::now();
    let ended = |why: String| {
        let seconds = started.elapsed().as_secs_f64();
        Ended { why, took: Took { seconds, ..Took::default() } }
    };
    let program = std::env::current_exe().map_err(|e| ended(e.to_string()))?;
    let errors = fs::File::create(folder.join("errors.txt")).map_err(|e| ended(e.to_string()))?;
    let mut command = Command::new(program);
    command.arg("one").arg(folder).arg("--threads").arg(threads.to_string());
    command.arg("--limit").arg(limit.as_secs().to_string());
    let status = command.stdout(Stdio::null()).stderr(errors).stdin(Stdio::null()).status();
    let status = status.map_err(|e| ended(e.to_string()))?;
    if status.success() {
        return Ok(());
    }
    if status.signal() != Some(Signal::XCPU.as_raw()) {
        return Err(ended(status.to_string()));
    }
    let mut over = ended(format!("stopped after {} s of computing", limit.as_secs()));
    over.took.computing_s = limit.as_secs_f64() * threads as f64;
    Err(over)
}

/// A line on the last case, and the score so far.
fn report(done: &[Judged], of: usize) {
    let Some(last) = done.last() else { return };
    let f = figures(done);
    let held = last.reported.held.map_or_else(String::new, |chi| format!(", held chi {chi:.2}"));
    eprintln!(
        "{}/{of} {} {}: {} (level {:.1}) said {}{held}, {:.0} s | alarms {}/{}, first {}/{}, pairs {}/{}, outside {}/{}",
        done.len(),
        last.answer.name,
        if last.right() { "right" } else { "WRONG" },
        last.answer.kind,
        last.answer.level,
        last.first(),
        last.reported.took.computing_s,
        f.false_alarms.count,
        f.false_alarms.of,
        f.first.count,
        f.first.of,
        f.pairs.count,
        f.pairs.of,
        f.outside_said.count,
        f.outside_said.of,
    );
}
