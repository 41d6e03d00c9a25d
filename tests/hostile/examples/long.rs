//! Damaged inputs by the million, on every core: `cargo run --release -p sinew-hostile --example long -- mcap 1000000 [seed]`

use std::thread::available_parallelism;
use std::time::Instant;

use sinew_hostile::{Format, damaged};

/// Files between two lines of progress.
const ROUND: u64 = 10_000;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let format = arguments.next().and_then(|name| Format::ALL.into_iter().find(|format| format.name() == name));
    let files = arguments.next().and_then(|files| files.parse::<u64>().ok());
    let (Some(format), Some(files)) = (format, files) else {
        let names: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
        eprintln!("error: expected one of {} and how many, as in `mcap 1000000`", names.join(", "));
        std::process::exit(2);
    };
    let seed = arguments.next().and_then(|seed| seed.parse().ok()).unwrap_or(0);
    let threads = available_parallelism().map_or(1, |n| n.get() as u64);
    let start = Instant::now();
    std::thread::scope(|scope| {
        for thread in 0..threads {
            scope.spawn(move || {
                let share = files / threads + u64::from(thread < files % threads);
                for round in 0..share.div_ceil(ROUND) {
                    damaged(format, (seed << 32) + (thread << 24) + round, ROUND.min(share - round * ROUND));
                    if thread == 0 {
                        eprint!("\r{} of {files} files, {}", (round + 1) * ROUND * threads, peak());
                    }
                }
            });
        }
    });
    let seconds = start.elapsed().as_secs_f64();
    println!("\n{files} damaged {} files read or refused in {seconds:.0} s, {}", format.name(), peak());
}

/// The most memory this process ever had.
fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    format!("at most {} of memory", line.map_or("?", str::trim))
}
