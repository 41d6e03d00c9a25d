//! `sinew-trust soak`: all faults at once for half an hour. A driver of many wires with random faults, clients that connect, command
//! and are killed, a recorder, load on all cores; in the end every cycle has to be accounted for and the driver's memory not grown.

use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rustix::process::Signal;
use serde::Serialize;
use sinew_ipc::Error;

use crate::failure::{Failure, expect, unexpected};
use crate::kind::{between, whole};
use crate::lockstep::rig_text;
use crate::running::{self, Process, connect};
use crate::site::Site;

/// How long, how large.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  sinew-trust soak --minutes 30 --channels 64 --rate 2000 --json soak.json")]
pub struct Args {
    /// How long, min.
    #[arg(long, default_value_t = 30.0)]
    minutes: f64,
    /// Wires.
    #[arg(long, default_value_t = 64)]
    channels: usize,
    /// Rate of the loop, Hz.
    #[arg(long = "rate", default_value_t = 2000.0)]
    rate_hz: f64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes what was counted as JSON.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// What was counted.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// `sinew.soak/1`.
    pub schema: &'static str,
    /// How long, s.
    pub seconds: f64,
    /// Wires.
    pub channels: usize,
    /// Rate, Hz.
    pub rate_hz: f64,
    /// Cycles the driver ran.
    pub cycles: u64,
    /// Periods it missed, counted.
    pub missed: u64,
    /// Periods of the run that are neither.
    pub unaccounted: i64,
    /// Allocations in the loop.
    pub allocations: u64,
    /// Cycles no subscriber could get, counted.
    pub unpublished: u64,
    /// Cycles a reader received that looked at all of them.
    pub received: u64,
    /// Cycles it lost, by its own count.
    pub lost: u64,
    /// Cycles the driver ran meanwhile that are neither.
    pub stream_unaccounted: i64,
    /// Faults latched.
    pub faults: u64,
    /// Clients started and killed.
    pub clients: u64,
    /// Recordings made, and those that say that cycles are missing.
    pub recordings: u64,
    /// Of these, the ones with (counted) losses.
    pub recordings_with_losses: u64,
    /// Longest time a client waited for the answer to a command, ms.
    pub slowest_answer_ms: f64,
    /// Resident memory of the driver after the first fifth and at the end, KiB.
    pub resident_kib: [f64; 2],
    /// How fast it grew from then on, KiB a minute, and the standard error of that.
    pub growth_kib_per_min: [f64; 2],
    /// Open files of the driver: the fewest in the first and in the second half from then on (clients come and go).
    pub files: [usize; 2],
    /// Files of the run in /dev/shm, likewise.
    pub shared_memory_files: [usize; 2],
    /// What does not come out even; empty if everything does.
    pub complaints: Vec<String>,
}

/// What is looked at every second.
#[derive(Debug, Clone, Copy)]
struct Look {
    at_min: f64,
    resident_kib: f64,
    files: usize,
    shared: usize,
}

/// Growth that is none: pages the allocator touches for the first time, KiB in all.
const NO_GROWTH_KIB: f64 = 1024.0;

/// Runs it. Whether everything came out even.
///
/// # Errors
/// A driver that does not start, or dies.
pub fn soak(args: &Args) -> Result<bool, Failure> {
    let site = Site::new()?;
    let name = site.name("soak");
    let folder = site.folder()?;
    let (file, report) = (folder.join("rig.toml"), folder.join("report.json"));
    std::fs::write(&file, rig_text(&name, args.channels, args.rate_hz, args.seed, ""))?;
    let duration = Duration::from_secs_f64(args.minutes * 60.0);
    let mut command = Command::new(site.itself()?);
    command.arg("drive").arg(&file).arg("/dev/null").arg("--report").arg(&report);
    command.args(["--for", "1e6", "--random-faults", &args.seed.to_string()]);
    let (mut driver, client) = running::started(&site, &mut command, &name)?;
    let run = run_name(&name)?;

    let over = AtomicBool::new(false);
    let started = Instant::now();
    let mut looks = Vec::new();
    let counts = std::thread::scope(|scope| {
        let reader = scope.spawn(|| to_the_end(&over, follow(&name, &over)));
        let nurse = scope.spawn(|| to_the_end(&over, nurse(&name, args, &over)));
        let crowd = scope.spawn(|| to_the_end(&over, crowd(&site, &name, args, &over)));
        let recorder = scope.spawn(|| to_the_end(&over, record(&site, &name, &over)));
        let load = scope.spawn(|| to_the_end(&over, load(&site, &over)));
        let mut said = Instant::now();
        let goes_on =
            |driver: &mut Process| !over.load(Ordering::Relaxed) && driver.ended().is_ok_and(|ended| ended.is_none());
        while started.elapsed() < duration && goes_on(&mut driver) {
            looks.extend(look(driver.pid(), &run, started));
            if said.elapsed() > Duration::from_secs(60) {
                said = Instant::now();
                let state = client.latest();
                eprintln!(
                    "{:.0} min: {} cycles, {} missed",
                    started.elapsed().as_secs_f64() / 60.0,
                    state.cycle,
                    state.missed
                );
            }
            std::thread::sleep(Duration::from_secs(1));
        }
        over.store(true, Ordering::Relaxed);
        let gone = || Failure::Unexpected("a part of the soak has panicked".into());
        load.join().map_err(|_| gone())??;
        Ok::<_, Failure>(Counts {
            read: reader.join().map_err(|_| gone())??,
            slowest_answer: nurse.join().map_err(|_| gone())??,
            clients: crowd.join().map_err(|_| gone())??,
            recordings: recorder.join().map_err(|_| gone())??,
        })
    });
    let counts = counts.inspect_err(|_| eprintln!("after {:.1} min:", started.elapsed().as_secs_f64() / 60.0))?;
    expect(driver.ended()?.is_none(), || format!("the driver ended by itself: {}", driver.said()))?;
    driver.signal(Signal::TERM)?;
    driver.finish().map_err(|failure| Failure::Unexpected(format!("the driver, asked to end: {failure}")))?;
    let text = std::fs::read_to_string(&report)?;
    let report: serde_json::Value = serde_json::from_str(&text).map_err(std::io::Error::other)?;
    let summary = summarise(args, &report, &looks, &counts);
    let text = serde_json::to_string_pretty(&summary).map_err(std::io::Error::other)?;
    match &args.json {
        Some(path) => std::fs::write(path, text + "\n")?,
        None => println!("{text}"),
    }
    println!("{}", said(&summary));
    Ok(summary.complaints.is_empty())
}

/// What the parts have counted.
struct Counts {
    /// Cycles received, lost, and run from the first to the last received.
    read: (u64, u64, u64),
    slowest_answer: Duration,
    clients: u64,
    /// All, and those with losses.
    recordings: (u64, u64),
}

/// A part that fails ends the others.
fn to_the_end<T>(over: &AtomicBool, part: Result<T, Failure>) -> Result<T, Failure> {
    over.fetch_or(part.is_err(), Ordering::Relaxed);
    part
}

fn summarise(args: &Args, report: &serde_json::Value, looks: &[Look], counts: &Counts) -> Summary {
    let &Counts { read: (received, lost, span), slowest_answer, clients, recordings } = counts;
    let (recordings, recordings_with_losses) = recordings;
    let number = |key: &str| report[key].as_u64().unwrap_or(u64::MAX);
    let seconds = report["seconds"].as_f64().unwrap_or(f64::NAN);
    let (cycles, missed) = (number("cycles"), number("missed"));
    // The first fifth is for everything to have happened once.
    let steady = &looks[looks.len() / 5..];
    let ends = |what: fn(&Look) -> f64| [steady.first().map_or(f64::NAN, what), steady.last().map_or(f64::NAN, what)];
    let halves = steady.split_at(steady.len() / 2);
    let fewest = |what: fn(&Look) -> usize| [halves.0, halves.1].map(|half| half.iter().map(what).min().unwrap_or(0));
    let resident_kib = ends(|look| look.resident_kib);
    let growth_kib_per_min = slope(steady);
    let steady_min = steady.last().map_or(0.0, |last| last.at_min) - steady.first().map_or(0.0, |first| first.at_min);
    let mut summary = Summary {
        schema: "sinew.soak/1",
        seconds,
        channels: args.channels,
        rate_hz: args.rate_hz,
        cycles,
        missed,
        unaccounted: (seconds * args.rate_hz).round() as i64 - cycles as i64 - missed as i64,
        allocations: number("allocations_in_loop"),
        unpublished: number("unpublished"),
        received,
        lost,
        stream_unaccounted: span as i64 - received as i64 - lost as i64,
        faults: report["faults"].as_array().map_or(0, Vec::len) as u64 + number("faults_not_listed"),
        clients,
        recordings,
        recordings_with_losses,
        slowest_answer_ms: slowest_answer.as_secs_f64() * 1e3,
        resident_kib,
        growth_kib_per_min,
        files: fewest(|look| look.files),
        shared_memory_files: fewest(|look| look.shared),
        complaints: Vec::new(),
    };
    let [growth, error] = growth_kib_per_min;
    let checks = [
        (summary.unaccounted == 0, format!("{} periods are not accounted for", summary.unaccounted)),
        (summary.allocations == 0, format!("{} allocations in the loop", summary.allocations)),
        (
            summary.stream_unaccounted == 0,
            format!("{} cycles of the stream are not accounted for", summary.stream_unaccounted),
        ),
        (received > 0, "the reader got nothing".into()),
        ((growth - 2.0 * error) * steady_min < NO_GROWTH_KIB, format!("memory grows by {growth:.1} KiB a minute")),
        (summary.files[1] <= summary.files[0] + 4, format!("open files: {:?}", summary.files)),
        (
            summary.shared_memory_files[1] <= summary.shared_memory_files[0] + 4,
            format!("files in /dev/shm: {:?}", summary.shared_memory_files),
        ),
        (recordings > 0, "no recording was made".into()),
    ];
    summary.complaints = checks.into_iter().filter(|(good, _)| !good).map(|(_, text)| text).collect();
    summary
}

/// Least squares of resident memory over time: KiB a minute, and the standard error.
fn slope(looks: &[Look]) -> [f64; 2] {
    let n = looks.len() as f64;
    let mean = |what: fn(&Look) -> f64| looks.iter().map(what).sum::<f64>() / n;
    let (x0, y0) = (mean(|look| look.at_min), mean(|look| look.resident_kib));
    let xx: f64 = looks.iter().map(|look| (look.at_min - x0).powi(2)).sum();
    let xy: f64 = looks.iter().map(|look| (look.at_min - x0) * (look.resident_kib - y0)).sum();
    let slope = xy / xx;
    let rest: f64 = looks.iter().map(|look| (look.resident_kib - y0 - slope * (look.at_min - x0)).powi(2)).sum();
    [slope, (rest / (n - 2.0) / xx).sqrt()]
}

fn said(summary: &Summary) -> String {
    let Summary { seconds, cycles, missed, received, lost, faults, clients, recordings, .. } = summary;
    let mut text = format!(
        "{:.1} min, {} channels at {} Hz: {cycles} cycles, {missed} missed and counted, {} unaccounted; a stream: {received} received, \
         {lost} lost and counted, {} unaccounted; {faults} faults, {clients} clients, {recordings} recordings; slowest answer {:.0} ms; {:.0} to {:.0} KiB resident, \
         {:+.2} ± {:.2} KiB a minute; {} allocations in the loop",
        seconds / 60.0,
        summary.channels,
        summary.rate_hz,
        summary.unaccounted,
        summary.stream_unaccounted,
        summary.slowest_answer_ms,
        summary.resident_kib[0],
        summary.resident_kib[1],
        summary.growth_kib_per_min[0],
        2.0 * summary.growth_kib_per_min[1],
        summary.allocations,
    );
    for complaint in &summary.complaints {
        text += &format!("\n  not in order: {complaint}");
    }
    text
}

/// Name of the run, as the rig's lock file has it; part of the name of everything in /dev/shm.
fn run_name(rig: &str) -> Result<String, Failure> {
    let lock = std::fs::read_to_string(sinew_ipc::runtime_dir()?.join(format!("{rig}.lock")))?;
    let run = lock.lines().find_map(|line| line.strip_prefix("run "));
    run.map(|run| run.trim().to_owned()).ok_or_else(|| Failure::Unexpected("the driver's lock names no run".into()))
}

fn look(pid: u32, run: &str, started: Instant) -> Option<Look> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let shared = std::fs::read_dir("/dev/shm").ok()?.flatten();
    Some(Look {
        at_min: started.elapsed().as_secs_f64() / 60.0,
        resident_kib: resident.split_whitespace().next()?.parse().ok()?,
        files: std::fs::read_dir(format!("/proc/{pid}/fd")).ok()?.count(),
        shared: shared.filter(|entry| entry.file_name().to_string_lossy().contains(run)).count(),
    })
}

/// Reads every cycle: how many came, how many it says it lost, and how many the driver ran from the first to the last it got.
fn follow(rig: &str, over: &AtomicBool) -> Result<(u64, u64, u64), Failure> {
    let client = connect(rig)?;
    let mut stream = client.stream()?;
    let (mut first, mut last) = (None, 0);
    while !over.load(Ordering::Relaxed) {
        if let Some(cycle) = stream.next_within(Duration::from_millis(100))? {
            first.get_or_insert(cycle.header.cycle);
            expect(cycle.header.cycle > last, || format!("cycle {} after {last}", cycle.header.cycle))?;
            last = cycle.header.cycle;
        }
    }
    Ok((stream.received(), stream.lost(), first.map_or(0, |first| last - first + 1)))
}

/// Resets what has broken, once it can be, and keeps the wires at work; the longest it waited for an answer.
fn nurse(rig: &str, args: &Args, over: &AtomicBool) -> Result<Duration, Failure> {
    let client = connect(rig)?;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(args.seed + 1);
    let mut slowest = Duration::ZERO;
    while !over.load(Ordering::Relaxed) {
        let channel = format!("wire{}", rng.random_range(0..args.channels));
        let asked = Instant::now();
        let answer = match client.latest().channels()[client.channel(&channel)?].fault() {
            Some(_) => client.reset(&channel),
            None => client.set_stroke(
                &channel,
                between(&mut rng, 0.0, 0.9),
                Duration::from_secs_f64(between(&mut rng, 0.5, 10.0)),
            ),
        };
        match answer {
            Ok(_) | Err(Error::Refused(_)) => slowest = slowest.max(asked.elapsed()),
            Err(error) => return Err(error.into()),
        }
        std::thread::sleep(Duration::from_millis(whole(&mut rng, 5, 50)));
    }
    Ok(slowest)
}

/// Clients that come, do something, and are killed.
fn crowd(site: &Site, rig: &str, args: &Args, over: &AtomicBool) -> Result<u64, Failure> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(args.seed + 2);
    let mut clients = 0;
    while !over.load(Ordering::Relaxed) {
        let channel = format!("wire{}", rng.random_range(0..args.channels));
        let task: Vec<&str> = match whole(&mut rng, 0, 3) {
            0 => vec!["hold", &channel, "0.05", "0.3"],
            1 => vec!["crowd", "10", &channel],
            2 => vec!["flood", &channel, "0.2"],
            _ => vec!["everything", &channel],
        };
        let client = Process::start(site, Command::new(site.itself()?).args(["client", rig]).args(task))?;
        std::thread::sleep(Duration::from_millis(whole(&mut rng, 5, 1500)));
        // Dropped, it is killed.
        drop(client);
        clients += 1;
    }
    Ok(clients)
}

/// Recordings of 20 s, one after the other; how many, and how many of them say that they lack cycles.
fn record(site: &Site, rig: &str, over: &AtomicBool) -> Result<(u64, u64), Failure> {
    let folder = site.folder()?;
    let (mut recordings, mut with_losses) = (0, 0);
    while !over.load(Ordering::Relaxed) {
        let mut command = Command::new(site.sinew()?);
        command.arg("record").arg(folder.join("soak.mcap")).args(["--for", "20", "--force", "--rig", rig]);
        let mut process = Process::start(site, &mut command)?;
        let status = loop {
            if let Some(status) = process.ended()? {
                break status;
            }
            if over.load(Ordering::Relaxed) {
                process.signal(Signal::INT)?;
                let ended = process.finish();
                break ended
                    .map_err(|failure| Failure::Unexpected(format!("the recorder, asked to end: {failure}")))?;
            }
            std::thread::sleep(Duration::from_millis(50));
        };
        // 3: recorded, cycles were lost, and the summary says which.
        match status.code() {
            Some(0) => {}
            Some(3) => with_losses += 1,
            _ => return unexpected(format!("the recorder ended with {status}: {}", process.said())),
        }
        recordings += 1;
    }
    Ok((recordings, with_losses))
}

/// All cores busy for five seconds of every ten.
fn load(site: &Site, over: &AtomicBool) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    let wait = |seconds: u64| {
        let until = Instant::now() + Duration::from_secs(seconds);
        while Instant::now() < until && !over.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    while !over.load(Ordering::Relaxed) {
        let occupied: Result<Vec<Process>, Failure> =
            (0..cores).map(|_| Process::start(site, Command::new(site.itself()?).arg("occupy"))).collect();
        let occupied = occupied?;
        wait(5);
        drop(occupied);
        wait(5);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_told_from_noise() {
        let looks = |per_min: f64| -> Vec<Look> {
            (0..600)
                .map(|k| {
                    let at_min = f64::from(k) / 60.0;
                    let noise = f64::from(k * 7919 % 13) * 4.0;
                    Look { at_min, resident_kib: 20_000.0 + per_min * at_min + noise, files: 9, shared: 4 }
                })
                .collect()
        };
        let [still, error] = slope(&looks(0.0));
        assert!(still.abs() < 4.0 * error && error < 1.0, "{still} ± {error}");
        let [grows, error] = slope(&looks(50.0));
        assert!((grows - 50.0).abs() < 4.0 * error, "{grows} ± {error}");
    }
}
