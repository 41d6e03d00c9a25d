//! `sinew doctor`: checks what this machine lacks for real time and for the rig and which hardware is attached, with cost and
//! remedy.

use std::ffi::CString;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use sinew_driver::baseline;
use sinew_driver::report::BareLoop;
use sinew_driver::wish_of;
use sinew_ipc::{Client, ClientOptions};
use sinew_realtime as realtime;
use sinew_realtime::Wish;
use sinew_rig::{RealtimeMode, Rig};
use sinew_threads::Row;

use super::check::{Check, Verdict, check};
use super::{admission, attached};
use crate::args;
use crate::commands::load_rig;
use crate::driving::screen::view::micros;
use crate::failure::Outcome;
use crate::output::{self, counted};

/// Shared memory below this may not hold a driver of 64 channels with its streams, bytes.
const SHARED_MEMORY_NEEDED: u64 = 64 << 20;
/// How long the bare timer loop is watched, s.
const WATCH_S: f64 = 1.0;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    schema: &'static str,
    rig: &'a str,
    lacking: usize,
    checks: &'a [Check],
    bare_loop: &'a BareLoop,
}

/// Runs the command.
pub fn doctor(args: &args::Doctor) -> Outcome {
    let rig = load_rig(args.rig.as_deref())?;
    let mut wish = wish_of(&rig);
    if rig.realtime.mode == RealtimeMode::Off {
        // the rig does not ask for it, but the question here is what the machine would give
        wish = Wish { mode: realtime::Mode::Try, priority: 80, cpu: None };
    }
    let mut checks: Vec<Check> = realtime::survey(&wish).rows.into_iter().map(of_realtime).collect();
    checks.push(cores());
    checks.extend(governor(&wish));
    checks.extend(clock_source());
    checks.extend(throttling(&rig));
    checks.push(shared_memory());
    checks.push(runtime_folder());
    checks.extend(admission::admission(&rig));
    checks.push(drivable(&rig));
    checks.extend(threads(&rig));
    checks.extend(attached::attached(&rig));
    let watched = baseline::bare_loop_with(&wish, rig.rate_hz, WATCH_S);
    checks.push(punctuality(&rig, &watched));

    let lacking = checks.iter().filter(|check| check.verdict == Verdict::Lacking).count();
    if args.json {
        let schema = "sinew.doctor/1";
        return output::print_json(&Report { schema, rig: &rig.name, lacking, checks: &checks, bare_loop: &watched });
    }
    output::print(text(&rig, &checks, lacking))
}

/// The checks for a person.
fn text(rig: &Rig, checks: &[Check], lacking: usize) -> String {
    let mut text = format!("rig {}: {} at {} Hz\n\n", rig.name, counted(rig.channels.len(), "channel"), rig.rate_hz);
    let width = checks.iter().map(|check| check.id.len()).max().unwrap_or(0);
    for check in checks {
        let mark = match check.verdict {
            Verdict::Good => "✔",
            Verdict::Advice => "▲",
            Verdict::Lacking => "✖",
        };
        let _ = writeln!(text, "{mark} {:<width$}  {}: {}", check.id, check.wanted, check.found);
        if check.verdict != Verdict::Good {
            for (label, words) in [("costs", &check.cost), ("type", &check.remedy)] {
                if !words.is_empty() {
                    let _ = writeln!(text, "  {:<width$}  {label}: {words}", "");
                }
            }
        }
    }
    let _ = match lacking {
        0 => writeln!(text, "\nnothing is lacking"),
        1 => writeln!(text, "\n1 thing is lacking (✖)"),
        n => writeln!(text, "\n{n} things are lacking (✖)"),
    };
    text
}

fn of_realtime(row: realtime::Row) -> Check {
    let verdict = match (row.granted, row.required) {
        (true, _) => Verdict::Good,
        (false, true) => Verdict::Lacking,
        (false, false) => Verdict::Advice,
    };
    let cost = if row.granted { String::new() } else { row.cost.into() };
    Check { id: row.id, verdict, wanted: row.asked, found: row.found, cost, remedy: row.remedy }
}

fn cores() -> Check {
    let cores = realtime::allowed_cores();
    let cost = "the loop shares its only core with everything else, its own publisher included";
    let trouble = (cores.len() < 2).then(|| {
        let remedy = "give the machine, container or `taskset` a second core".to_string();
        (Verdict::Lacking, cost, remedy)
    });
    check("cores", "two cores or more", format!("{} allowed", cores.len()), trouble)
}

/// The governor of the core the loop would run on; not there in most virtual machines.
fn governor(wish: &Wish) -> Option<Check> {
    let cpu = wish.cpu.or_else(|| realtime::allowed_cores().last().copied())?;
    let path = format!("/sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor");
    let found = fs::read_to_string(&path).ok()?.trim().to_string();
    let trouble = (found != "performance").then(|| {
        let cost = "the core runs slowly between cycles: cycles take up to three times as long";
        (Verdict::Lacking, cost, format!("echo performance | sudo tee {path}"))
    });
    Some(check("governor", "frequency governor \"performance\"", format!("{found} on core {cpu}"), trouble))
}

fn clock_source() -> Option<Check> {
    let path = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
    let found = fs::read_to_string(path).ok()?.trim().to_string();
    let quick = matches!(found.as_str(), "tsc" | "kvm-clock" | "hyperv_clocksource_tsc_page" | "arch_sys_counter");
    let trouble = (!quick).then(|| {
        let cost = "every look at the clock is a system call of a microsecond or so";
        (Verdict::Advice, cost, format!("echo tsc | sudo tee {path}   (where the processor has a steady one)"))
    });
    Some(check("clock", "a clock that is read without a system call", found, trouble))
}

/// The kernel takes the processor from real-time threads that use more than their share of every second.
fn throttling(rig: &Rig) -> Option<Check> {
    let path = "/proc/sys/kernel/sched_rt_runtime_us";
    let found = fs::read_to_string(path).ok()?.trim().to_string();
    let trouble = (found != "-1" && rig.rate_hz > 2000.0).then(|| {
        let cost = "a loop that needs more than 95 % of its core is stopped for 50 ms in every second";
        (Verdict::Advice, cost, "sudo sysctl kernel.sched_rt_runtime_us=-1".to_string())
    });
    Some(check("throttling", "real-time threads keep their core", format!("sched_rt_runtime_us {found}"), trouble))
}

fn shared_memory() -> Check {
    let (id, wanted, folder) = ("shared_memory", "64 MiB free in /dev/shm, open to this user", "/dev/shm");
    let cost = "the driver cannot publish: it does not start, or dies when the memory is touched";
    let lacking = |found: String, remedy: &str| check(id, wanted, found, Some((Verdict::Lacking, cost, remedy.into())));
    let Some(free) = free_bytes(folder) else {
        return lacking("not there".into(), "sudo mount -t tmpfs -o size=256m tmpfs /dev/shm");
    };
    // permission is determined by trying
    let probe = Path::new(folder).join(format!(".sinew-doctor-{}", std::process::id()));
    let written = fs::OpenOptions::new().write(true).create_new(true).open(&probe).and_then(|mut file| {
        let written = file.write_all(b"sinew");
        // only what was made here
        fs::remove_file(&probe).and(written)
    });
    let found = format!("{} MiB free", free >> 20);
    match written {
        Err(error) => lacking(format!("{found}, but: {error}"), "sudo chmod 1777 /dev/shm"),
        Ok(()) if free < SHARED_MEMORY_NEEDED => {
            lacking(found, "sudo mount -o remount,size=256m /dev/shm   (docker: --shm-size=256m)")
        }
        Ok(()) => check(id, wanted, found, None),
    }
}

/// Bytes an ordinary user may still write in a folder's file system.
fn free_bytes(folder: &str) -> Option<u64> {
    let path = CString::new(folder).ok()?;
    // SAFETY: statvfs is a plain structure of integers, for which all zero is a valid value.
    let mut answer: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: `path` is a string with a final zero and `answer` is writable; both outlive the call.
    let code = unsafe { libc::statvfs(path.as_ptr(), &mut answer) };
    (code == 0).then(|| answer.f_bavail.saturating_mul(answer.f_frsize))
}

fn runtime_folder() -> Check {
    let (id, wanted) = ("runtime_folder", "a folder for locks and sockets of this user alone");
    match sinew_ipc::runtime_dir() {
        Ok(path) => check(id, wanted, path.display().to_string(), None),
        Err(error) => {
            let cost = "drivers and clients cannot find each other";
            check(id, wanted, error.message(), Some((Verdict::Lacking, cost, error.remedy())))
        }
    }
}

fn drivable(rig: &Rig) -> Check {
    let (id, wanted) = ("rig", "every channel can be driven");
    match rig.check_drivable() {
        Ok(()) => check(id, wanted, "yes".into(), None),
        Err(error) => {
            let found = format!("{} reasons against it", error.problems().len());
            let cost = "the rig file serves `simulate` only";
            check(id, wanted, found, Some((Verdict::Lacking, cost, error.to_string())))
        }
    }
}

/// Whether all threads of a driver of this rig live, where one runs.
fn threads(rig: &Rig) -> Option<Check> {
    let options = ClientOptions { connect: Duration::ZERO, ..ClientOptions::default() };
    let client = Client::connect_with(&rig.name, options).ok()?;
    let dead: Vec<_> = client.loop_stats().dead_threads().collect();
    let (id, wanted) = ("thread", "all threads of the running driver live");
    if dead.is_empty() {
        return Some(check(id, wanted, "yes".into(), None));
    }
    let list = |of: fn(&Row) -> &'static str| dead.iter().map(|row| of(row)).collect::<Vec<_>>().join("; ");
    let found = format!("died: {}", list(|row| row.name));
    let cost = list(|row| row.words);
    let remedy = format!("sinew stop --rig {}   (and start it again)", rig.name);
    Some(check(id, wanted, found, Some((Verdict::Lacking, &cost, remedy))))
}

/// What a bare timer loop at the rig's rate has to put up with.
fn punctuality(rig: &Rig, watched: &BareLoop) -> Check {
    let period_us = 1e6 / rig.rate_hz;
    let late = watched.lateness_us;
    let found = format!(
        "p50 {} p99 {} max {} µs of {period_us:.0}, {} of {} periods missed",
        micros(late.p50),
        micros(late.p99),
        micros(late.max),
        watched.missed,
        watched.cycles + watched.missed
    );
    let trouble = (watched.missed > 0 || late.p99 > 0.5 * period_us).then(|| {
        let cost = "cycles are skipped (and counted) whatever the driver does";
        let remedy = "mend what is lacking above, stop other load, or lower rate_hz in the rig file".to_string();
        (Verdict::Lacking, cost, remedy)
    });
    check("wakeups", "a bare timer loop of one second wakes on time", found, trouble)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lacking_comes_with_its_cost_and_what_to_type() {
        let rig = Rig::hexapod();
        let good = check("cores", "two cores or more", "4 allowed".into(), None);
        let bad = check("rig", "all", "no".into(), Some((Verdict::Lacking, "everything", "mend it".into())));
        let text = text(&rig, &[good, bad], 1);
        assert!(text.contains("✔ cores  two cores or more: 4 allowed\n"), "{text}");
        assert!(text.contains("costs: everything") && text.contains("type: mend it"), "{text}");
        assert!(text.contains("1 thing is lacking"), "{text}");
    }

    #[test]
    fn missed_periods_are_lacking() {
        let rig = Rig::hexapod();
        let quantiles = |p99| sinew_driver::report::Quantiles { p50: 5.0, p99, p999: p99, max: p99 };
        let watched = |missed, p99| BareLoop {
            seconds: 1.0,
            rate_hz: rig.rate_hz,
            cycles: 1000,
            missed,
            lateness_us: quantiles(p99),
            lateness: sinew_ipc::Histogram::new(),
        };
        assert_eq!(punctuality(&rig, &watched(0, 60.0)).verdict, Verdict::Good);
        assert_eq!(punctuality(&rig, &watched(2, 60.0)).verdict, Verdict::Lacking);
        assert_eq!(punctuality(&rig, &watched(0, 0.6e6 / rig.rate_hz)).verdict, Verdict::Lacking);
    }

    #[test]
    fn free_memory_is_known_for_a_folder_and_not_for_nothing() {
        assert!(free_bytes("/").is_some());
        assert_eq!(free_bytes("/no/such/folder"), None);
    }
}
