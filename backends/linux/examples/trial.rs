//! Tests a rig file's outputs and converters, without the driver:
//! `cargo run -p sinew-linux-backend --example trial -- RIG.toml [CYCLES | hold]`.
//!
//! Each channel gets its sensing duty for so many cycles (default 200), and its inputs' values are printed with the time of an
//! exchange. `hold` continues until it is killed, to test the guard.

use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use sinew_backend::allocations::{CountingAllocator, calls_of_this_thread};
use sinew_backend::{Backend, Sample};
use sinew_linux_backend::{LinuxRig, Settings, guard};
use sinew_rig::Rig;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1).peekable();
    if arguments.next_if(|word| word == guard::WORD).is_some() {
        return guard::main(arguments);
    }
    let arguments: Vec<String> = arguments.filter_map(|argument| argument.into_string().ok()).collect();
    let (file, cycles) = match &arguments[..] {
        [file] => (file, Some(200)),
        [file, word] if word == "hold" => (file, None),
        [file, cycles] => (file, cycles.parse().ok().or(Some(200))),
        _ => {
            eprintln!("usage: trial RIG.toml [CYCLES | hold]");
            return ExitCode::from(2);
        }
    };
    match trial(file, cycles) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn trial(file: &str, cycles: Option<u64>) -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::load(file.as_ref())?;
    let mut backend = LinuxRig::new(Settings::of_rig(&rig))?;
    backend.bring_up()?;
    println!("guard {}, bears {:?} of silence", backend.guard_process().unwrap_or(0), backend.silence());
    let duty: Vec<f64> = rig.channels.iter().map(|channel| channel.control.minimum_duty).collect();
    let mut samples = vec![Sample::NONE; duty.len()];
    let mut last = samples.clone();
    let mut sampled = vec![0u64; duty.len()];
    let mut times = Vec::with_capacity(1 << 16);
    let period = Duration::from_secs_f64(1.0 / rig.rate_hz);
    let mut allocations = 0;
    let mut count = 0;
    while cycles.is_none_or(|cycles| count < cycles) {
        let (since, before) = (Instant::now(), calls_of_this_thread());
        backend.exchange(&duty, &mut samples)?;
        let took = since.elapsed();
        allocations += calls_of_this_thread() - before;
        if times.len() < times.capacity() {
            times.push(took);
        }
        for ((sample, last), sampled) in samples.iter().zip(&mut last).zip(&mut sampled) {
            if sample.current_a.is_finite() {
                (*last, *sampled) = (*sample, *sampled + 1);
            }
        }
        count += 1;
        thread::sleep(period.saturating_sub(took));
    }
    if let Some(inputs) = backend.stop_inputs() {
        println!("emergency stop: {inputs:?}");
    }
    assert_eq!(backend.stop(), sinew_backend::Zero::Confirmed);
    times.sort_unstable();
    let (median, worst) = (times[times.len() / 2], times[times.len() - 1]);
    println!("{count} exchanges, {median:.1?} (median), {worst:.1?} (worst), {allocations} allocations");
    for ((channel, last), sampled) in rig.channels.iter().zip(&last).zip(&sampled) {
        println!("{}: sampled in {sampled} of {count} cycles, last {last:?}", channel.name);
    }
    Ok(())
}
