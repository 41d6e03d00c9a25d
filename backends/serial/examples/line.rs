//! Cost and limits of a serial line, over a pseudo-terminal with the firmware on a thread of this process, which gets real time
//! as the loop does where Linux allows it, since a microcontroller is punctual: the exchange, the rates without a lost sample, the
//! samples a late driver loses, and how soon silence is detected. The figures of `docs/front-end.md`:
//!
//! ```sh
//! cargo run --release -p sinew-serial-backend --example line          # all of it, 2 min
//! cargo run --release -p sinew-serial-backend --example line -- bare  # what Linux takes alone
//! ```

use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::{OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use sinew_backend::clock::{now_ns, sleep_until_ns};
use sinew_backend::{Backend, Sample};
use sinew_front_end_host::{Host, Options, What};
use sinew_realtime::{Held, Mode, Wish, prepare_process, prepare_thread};
use sinew_rig::{BackendKind, Rig};
use sinew_serial_backend::SerialBackend;

/// How long each rate is tried.
const SECONDS: f64 = 10.0;
/// Silences that are measured.
const SILENCES: usize = 100;

fn rig(channels: usize, rate_hz: f64) -> Rig {
    let mut rig = Rig::hexapod();
    let wire = rig.channels[0].clone();
    rig.channels = (0..channels).map(|_| wire.clone()).collect();
    for (index, channel) in rig.channels.iter_mut().enumerate() {
        channel.name = format!("wire{index}");
    }
    rig.rate_hz = rate_hz;
    rig.backend.kind = BackendKind::Serial;
    rig
}

/// What a driver's loop asks of Linux, for this thread and those it starts.
fn real_time(priority: u8) -> Held {
    let wish = Wish { mode: Mode::Try, priority, cpu: None };
    let (held, mut report) = prepare_process(&wish);
    prepare_thread(&wish, &mut report);
    held
}

/// The front-end's thread inherits the priority of who starts it; the driver's own is lower.
fn start(rig: &mut Rig) -> Result<(Host, SerialBackend, Held), Box<dyn Error>> {
    drop(real_time(60));
    let host = Host::start(rig, Options::default())?;
    rig.backend.serial.port = Some(host.path().display().to_string());
    let held = real_time(50);
    let mut backend = SerialBackend::connect(rig)?;
    backend.start()?;
    Ok((host, backend, held))
}

/// One rate: shares of the frames that were answered in time, and the time of an exchange.
fn rate(channels: usize, rate_hz: f64) -> Result<(), Box<dyn Error>> {
    let mut rig = rig(channels, rate_hz);
    rig.backend.serial.watchdog_periods = ((0.1 * rate_hz) as u32).clamp(5, 1000);
    let (_host, mut backend, _held) = start(&mut rig)?;
    let (duty, mut samples) = (vec![0.1; channels], vec![Sample::NONE; channels]);
    let period_ns = (1e9 / rate_hz) as u64;
    let count = (SECONDS * rate_hz) as usize;
    let mut times_ns = Vec::with_capacity(count);
    let (mut nan, mut twice, mut before, mut errors, mut missed) = (0u64, 0u64, false, 0u64, 0u64);
    let mut due_ns = now_ns() + period_ns;
    for _ in 0..count {
        sleep_until_ns(due_ns);
        let began_ns = now_ns();
        errors += u64::from(backend.exchange(&duty, &mut samples).is_err());
        let done_ns = now_ns();
        times_ns.push(done_ns - began_ns);
        let dark = samples.iter().any(|sample| sample.current_a.is_nan());
        nan += u64::from(dark);
        twice += u64::from(dark && before);
        before = dark;
        due_ns += period_ns;
        if done_ns > due_ns {
            let gone = (done_ns - due_ns) / period_ns + 1;
            (due_ns, missed) = (due_ns + gone * period_ns, missed + gone);
        }
    }
    times_ns.sort_unstable();
    let at = |share: f64| times_ns[((count - 1) as f64 * share) as usize] as f64 * 1e-3;
    let figures = backend.figures();
    println!(
        "{channels:>3} channels {rate_hz:>6} Hz: exchange p50 {:.1} p99 {:.1} max {:.1} µs; {} frames, {nan} without samples \
         ({twice} twice in a row), {} damaged, {} not taken, {errors} errors, {missed} periods missed here, {} trips",
        at(0.5),
        at(0.99),
        at(1.0),
        figures.sent(),
        figures.damaged(),
        figures.unsent(),
        figures.trips(),
    );
    Ok(())
}

/// What Linux takes to hand eight bytes over, from one thread with real time to another, by a pseudo-terminal and by a socket: bytes
/// of a terminal pass through an ordinary thread of the kernel's, whoever waits for them.
fn bare() -> Result<(), Box<dyn Error>> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let end = open(ptsname(&master, Vec::new())?, OFlags::RDWR | OFlags::NOCTTY, rustix::fs::Mode::empty())?;
    let mut settings = tcgetattr(&end)?;
    settings.make_raw();
    tcsetattr(&end, OptionalActions::Now, &settings)?;
    let (one, other) = UnixStream::pair()?;
    for (what, from, to) in [("a socket", OwnedFd::from(one), OwnedFd::from(other)), ("a pseudo-terminal", master, end)]
    {
        let count = (SECONDS * 1000.0) as usize;
        let _held = real_time(60);
        // Moved in, so that the reader sees the end of a line whose writer has failed.
        let writer = thread::spawn(move || -> Result<(), rustix::io::Errno> {
            let mut due_ns = now_ns();
            for _ in 0..count {
                due_ns += 1_000_000;
                sleep_until_ns(due_ns);
                rustix::io::write(&from, &now_ns().to_ne_bytes())?;
            }
            // Until all is read.
            thread::sleep(Duration::from_secs(1));
            Ok(())
        });
        let mut to = File::from(to);
        let mut took_ns = Vec::with_capacity(count);
        let mut word = [0; 8];
        while took_ns.len() < count {
            to.read_exact(&mut word)?;
            took_ns.push(now_ns().saturating_sub(u64::from_ne_bytes(word)));
        }
        writer.join().map_err(|_| "the writing thread died")??;
        took_ns.sort_unstable();
        let at = |share: f64| took_ns[((count - 1) as f64 * share) as usize] as f64 * 1e-3;
        println!("{what} hands over within p50 {:.0} p99 {:.0} max {:.0} µs", at(0.5), at(0.99), at(1.0));
    }
    Ok(())
}

/// A driver that is late by up to three periods in every tenth cycle: the samples it misses, and how often two in a row, which is
/// what the supervisor takes for a broken sensor. `asks`: as the loop does, it lets a period pass in which nothing is due.
fn late(asks: bool) -> Result<(), Box<dyn Error>> {
    const RATE_HZ: f64 = 1000.0;
    let mut rig = rig(4, RATE_HZ);
    rig.backend.serial.watchdog_periods = 20;
    let (_host, mut backend, _held) = start(&mut rig)?;
    let mut samples = vec![Sample::NONE; 4];
    let period_ns = (1e9 / RATE_HZ) as u64;
    let (mut cycles, mut nan, mut twice, mut passed) = (0u64, 0u64, 0u64, 0u64);
    let (mut dark, mut waited) = (false, false);
    let mut due_ns = now_ns() + period_ns;
    while (cycles as f64) < SECONDS * RATE_HZ {
        // All parts of a period, evenly.
        let late = if cycles % 10 == 0 { 3.0 * (cycles as f64 * 0.1 * 0.618_034).fract() } else { 0.0 };
        sleep_until_ns(due_ns + (late * period_ns as f64) as u64);
        due_ns += now_ns().saturating_sub(due_ns) / period_ns * period_ns + period_ns;
        waited = asks && !waited && !backend.is_due();
        if waited {
            passed += 1;
            continue;
        }
        // From the sensing pulse to what heats fastest.
        let duty = [0.02, 0.3, 0.5, 0.75][(cycles / 100 % 4) as usize];
        let _ = backend.exchange(&[duty; 4], &mut samples);
        let before = std::mem::replace(&mut dark, samples.iter().any(|sample| sample.current_a.is_nan()));
        nan += u64::from(dark);
        twice += u64::from(dark && before);
        cycles += 1;
    }
    println!(
        "a late driver that {}: {cycles} cycles, every tenth late by up to 3 periods; {nan} without samples ({twice} twice in a \
         row), {passed} periods let pass",
        if asks { "lets a period pass in which nothing is due" } else { "exchanges all the same" }
    );
    Ok(())
}

/// The time from the last frame's arrival to all outputs off, by the front-end's own clock, against what it promises.
fn silence() -> Result<(), Box<dyn Error>> {
    let mut rig = rig(4, 1000.0);
    rig.backend.serial.watchdog_periods = 5;
    let (host, mut backend, _held) = start(&mut rig)?;
    let (duty, mut samples) = (vec![0.2; 4], vec![Sample::NONE; 4]);
    let mut over_us = Vec::new();
    while over_us.len() < SILENCES {
        let mut due_ns = now_ns();
        let driven = Instant::now();
        while driven.elapsed() < Duration::from_millis(50) {
            due_ns += 1_000_000;
            sleep_until_ns(due_ns);
            let _ = backend.exchange(&duty, &mut samples);
        }
        while host.told().is_some() {}
        thread::sleep(Duration::from_millis(30));
        while let Some(told) = host.told() {
            if let What::Off { silent_ns: Some(silent_ns), powered: Some(true), .. } = told.what {
                over_us.push((silent_ns as f64 - 5e6) * 1e-3);
            }
        }
    }
    over_us.sort_by(f64::total_cmp);
    println!(
        "silence: {} times off after 5 periods of 1 ms; later than that by {:.0} µs (median), {:.0} µs (worst)",
        over_us.len(),
        over_us[over_us.len() / 2],
        over_us[over_us.len() - 1]
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    bare()?;
    if std::env::args().nth(1).is_some_and(|word| word == "bare") {
        return Ok(());
    }
    for (channels, rate_hz) in
        [(1, 1000.0), (18, 1000.0), (64, 1000.0), (4, 2000.0), (18, 2000.0), (64, 2000.0), (4, 5000.0), (18, 5000.0)]
    {
        thread::spawn(move || rate(channels, rate_hz).map_err(|error| error.to_string()))
            .join()
            .map_err(|_| "the measuring thread died")??;
    }
    late(false)?;
    late(true)?;
    silence()
}
