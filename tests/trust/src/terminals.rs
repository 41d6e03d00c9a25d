//! Terminals that nobody reads, on a busy machine: how long outputs take to be zero, beside how long a bare chain of threads takes that
//! does nothing else.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use sinew_driver::wish_of;
use sinew_ipc::{Client, DriverState, Fault, Mode};
use sinew_realtime as realtime;
use sinew_rig::Rig;

use crate::failure::{Failure, expect};
use crate::kind::{Group, Kind, Trials, Unit, between};
use crate::lockstep::rig_text;
use crate::running::{DUTY, LONG, PATIENCE, Process, RATE_HZ, connect, wait_for};
use crate::site::Site;
use crate::witness::now_ns;

const PERIOD_MS: f64 = 1e3 / RATE_HZ;
/// A period, and so much for everything else that is the driver's, ms; what the machine takes comes on top.
const WITHIN_MS: f64 = PERIOD_MS + 5.0;
/// Busy threads for each core.
const BUSY: usize = 2;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    let signalled = |name, injected, terminal| {
        kind(name, injected, SIGNALLED, "the run, and words that found no room", move |site, trials| {
            measure(site, trials, terminal, |driver, rng| driver.signalled(rng))
        })
    };
    vec![
        signalled(
            "signal_with_an_unread_pipe",
            "SIGTERM or SIGINT while stdout and stderr are a full pipe nobody reads, on a busy machine",
            Terminal::Pipe,
        ),
        signalled(
            "signal_with_a_stopped_terminal",
            "SIGTERM or SIGINT while the terminal is full and nobody reads it, on a busy machine",
            Terminal::Full,
        ),
        signalled(
            "signal_in_the_background",
            "SIGTERM or SIGINT to `sinew run &` on a terminal that stops whoever writes to it (`stty tostop`), on a busy machine",
            Terminal::Background,
        ),
        kind(
            "off_with_a_stopped_terminal",
            "a channel is switched off while the terminal is full and nobody reads it, on a busy machine",
            "that channel at the sensing pulse: beyond the machine's own lateness",
            "words that found no room",
            |site, trials| measure(site, trials, Terminal::Full, |driver, _| driver.switched_off()),
        ),
    ]
}

const SIGNALLED: &str = "zero at all outputs, and the process ends: beyond the machine's own lateness";

fn kind(
    name: &'static str,
    injected: &'static str,
    expected: &'static str,
    lost: &'static str,
    carry_out: impl Fn(&Site, &mut Trials) -> Result<(), Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Process,
        injected,
        expected,
        within: WITHIN_MS,
        unit: Unit::Milliseconds,
        lost,
        faults: &[Fault::Stopping],
        carry_out: Box::new(carry_out),
    }
}

/// What a driver's words go to.
#[derive(Debug, Clone, Copy)]
enum Terminal {
    Pipe,
    Full,
    Background,
}

/// Measures drivers and, in between, the bare chain, all on a busy machine; then the first less the worst of the second.
fn measure(
    site: &Site,
    trials: &mut Trials,
    terminal: Terminal,
    one: impl Fn(&mut Driven, &mut Xoshiro256PlusPlus) -> Result<f64, Failure>,
) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    let load: Result<Vec<Process>, Failure> =
        (0..BUSY * cores).map(|_| Process::start(site, Command::new(site.itself()?).arg("occupy"))).collect();
    let load = load?;
    let rig = site.folder()?.join("rig.toml");
    let name = site.name("terminal");
    std::fs::write(&rig, rig_text(&name, 2, RATE_HZ, 7, ""))?;
    let mut chain = Chain::start(site, &rig)?;
    let mut bare_ms = Vec::new();
    // Held to the promise when the machine is known.
    let mut found = Vec::new();
    let mut failed = Vec::new();
    let within_ms = trials.within;
    trials.within = f64::INFINITY;
    trials.each(|rng| {
        let mut driver = Driven::start(site, &rig, &name, terminal)?;
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.02)));
        let took_ms = one(&mut driver, rng)?;
        drop(driver);
        for _ in 0..3 {
            std::thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.02)));
            bare_ms.push(chain.took_ms()?);
        }
        found.push(took_ms);
        Ok(took_ms)
    })?;
    drop(load);
    bare_ms.sort_by(f64::total_cmp);
    // The chain's own period is not the machine's.
    let late_ms = (bare_ms.last().copied().unwrap_or(0.0) - PERIOD_MS).max(0.0);
    for (number, took_ms) in trials.reactions.iter_mut().enumerate() {
        *took_ms = (*took_ms - late_ms).max(0.0);
        if *took_ms > within_ms {
            failed.push((number, format!("{:.1} ms on a machine that is {late_ms:.1} ms late", *took_ms + late_ms)));
        }
    }
    trials.failures.extend(failed);
    found.sort_by(f64::total_cmp);
    let [all, bare] = [&found, &bare_ms].map(|of| (of.last().copied(), of.get(of.len() / 2).copied()));
    eprintln!("    to zero, worst and median: {all:.1?} ms; a bare chain of threads: {bare:.1?} ms");
    Ok(())
}

/// A driver whose words nobody reads.
struct Driven {
    child: Child,
    client: Client,
    /// What keeps its terminal full, or there.
    _ends: Vec<OwnedFd>,
}

impl Driven {
    fn start(site: &Site, rig: &std::path::Path, name: &str, terminal: Terminal) -> Result<Driven, Failure> {
        let run = |command: &mut Command| -> Result<(), Failure> {
            command.arg("run").arg(rig).args(["--no-monitor", "--for", "300"]);
            command.env("SINEW_STATE_DIR", site.folder()?);
            Ok(())
        };
        let (child, ends) = match terminal {
            Terminal::Pipe => {
                let (reader, writer) = std::io::pipe()?;
                let writer = OwnedFd::from(writer);
                fill(&writer)?;
                let mut command = Command::new(site.sinew()?);
                run(&mut command)?;
                command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
                (command.spawn()?, vec![reader.into()])
            }
            Terminal::Full => {
                let (ours, theirs) = terminal_pair()?;
                let mut command = Command::new(site.sinew()?);
                run(&mut command)?;
                command.stdin(Stdio::null()).stdout(theirs.try_clone()?).stderr(theirs.try_clone()?);
                fill(&theirs)?;
                (command.spawn()?, vec![ours, theirs])
            }
            Terminal::Background => {
                let (ours, theirs) = terminal_pair()?;
                let mut command = Command::new("setsid");
                command.args(["-c", "sh", "-mc", "stty tostop; \"$0\" \"$@\" & wait $!"]).arg(site.sinew()?);
                run(&mut command)?;
                command.stdin(theirs.try_clone()?).stdout(theirs.try_clone()?).stderr(theirs.try_clone()?);
                (command.spawn()?, vec![ours, theirs])
            }
        };
        let mut child = child;
        wait_for("the driver to start", || match child.try_wait()? {
            Some(status) => Err(Failure::Unexpected(format!("the driver ended with {status}"))),
            // An earlier one has been waited for: this is no other.
            None => Ok(Client::connect(name).ok().filter(|client| client.latest().cycle > 0).map(drop)),
        })
        .inspect_err(|_| drop(child.kill()))?;
        let driver = Driven { child, client: connect(name)?, _ends: ends };
        let all = |so: &dyn Fn(&sinew_ipc::ChannelState) -> bool| driver.client.latest().channels().iter().all(so);
        wait_for("proved sensors", || Ok(all(&|channel| channel.mode() == Mode::Off).then_some(())))?;
        for channel in ["wire0", "wire1"] {
            driver.client.set_duty(channel, DUTY, LONG)?;
        }
        wait_for("power", || Ok(all(&|channel| channel.duty == DUTY).then_some(())))?;
        Ok(driver)
    }

    /// Asks it to end: ms until its outputs were zero.
    fn signalled(&mut self, rng: &mut Xoshiro256PlusPlus) -> Result<f64, Failure> {
        let signal = if rng.random() { Signal::TERM } else { Signal::INT };
        let from = now_ns();
        send(self.client.info().pid, signal)?;
        let zero_ns = wait_for("its outputs to be zero", || {
            let last = self.client.latest();
            Ok((last.state() == DriverState::Stopped).then_some(last.monotonic_ns))
        })?;
        let last = self.client.latest();
        expect(last.channels().iter().all(|channel| channel.duty == 0.0), || "it ended with a duty".into())?;
        let status: ExitStatus = wait_for("its end", || Ok(self.child.try_wait()?))?;
        expect(status.success(), || format!("it ended with {status}"))?;
        Ok(zero_ns.saturating_sub(from) as f64 * 1e-6)
    }

    /// Switches a channel off: ms until its output was at the sensing pulse.
    fn switched_off(&mut self) -> Result<f64, Failure> {
        const SENSING: f64 = 0.021;
        let mut stream = self.client.stream()?;
        let from = now_ns();
        self.client.off("wire0")?;
        let mut is_decided = false;
        // What a cycle decides goes out with the exchange of the next one.
        let at_ns = wait_for("its output", || {
            while let Some(cycle) = stream.next()? {
                if is_decided {
                    return Ok(Some(cycle.header.monotonic_ns));
                }
                is_decided = cycle.header.monotonic_ns >= from && cycle.channels[0].duty <= SENSING;
            }
            Ok(None)
        })?;
        drop(stream);
        send(self.client.info().pid, Signal::TERM)?;
        wait_for("its end", || Ok(self.child.try_wait()?))?;
        Ok(at_ns.saturating_sub(from) as f64 * 1e-6)
    }
}

impl Drop for Driven {
    fn drop(&mut self) {
        if !matches!(self.child.try_wait(), Ok(Some(_))) {
            let _ = send(self.client.info().pid, Signal::KILL);
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

fn send(pid: u32, signal: Signal) -> Result<(), Failure> {
    let pid = Pid::from_raw(pid as i32).ok_or_else(|| Failure::Unexpected("it has no number".into()))?;
    kill_process(pid, signal).map_err(|error| Failure::Unexpected(format!("{signal:?}: {error}")))
}

/// Both ends of a new terminal.
fn terminal_pair() -> Result<(OwnedFd, OwnedFd), Failure> {
    let impossible = |error: rustix::io::Errno| Failure::Impossible(format!("a terminal: {error}"));
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).map_err(impossible)?;
    grantpt(&ours).and_then(|()| unlockpt(&ours)).map_err(impossible)?;
    let name = ptsname(&ours, Vec::new()).map_err(impossible)?;
    let flags = OFlags::RDWR | OFlags::NOCTTY;
    let theirs = rustix::fs::open(name, flags, rustix::fs::Mode::empty()).map_err(impossible)?;
    Ok((ours, theirs))
}

/// Writes until not a byte more goes in.
fn fill(end: &OwnedFd) -> Result<(), Failure> {
    let wrong = |error: rustix::io::Errno| Failure::Unexpected(error.to_string());
    let flags = fcntl_getfl(end).map_err(wrong)?;
    fcntl_setfl(end, flags | OFlags::NONBLOCK).map_err(wrong)?;
    for size in [1024, 1] {
        while rustix::io::write(end, &vec![b'x'; size]).is_ok() {}
    }
    fcntl_setfl(end, flags).map_err(wrong)
}

/// A process with the threads of a driver between a signal and its outputs, and nothing else: what the machine takes.
struct Chain {
    process: Process,
    stamps: File,
}

impl Chain {
    fn start(site: &Site, rig: &std::path::Path) -> Result<Chain, Failure> {
        let path = site.folder()?.join("stamps");
        File::create(&path)?;
        let process = Process::start(site, Command::new(site.itself()?).arg("chain").arg(rig).arg(&path))?;
        let mut stamps = File::open(&path)?;
        let mut ready = [0; 8];
        wait_for("the chain", || Ok(stamps.read_exact(&mut ready).is_ok().then_some(())))?;
        Ok(Chain { process, stamps })
    }

    /// From a signal to what would be the output, ms.
    fn took_ms(&mut self) -> Result<f64, Failure> {
        let from = now_ns();
        self.process.signal(Signal::TERM)?;
        let mut stamp = [0; 8];
        wait_for("the chain's stamp", || Ok(self.stamps.read_exact(&mut stamp).is_ok().then_some(())))?;
        Ok(u64::from_ne_bytes(stamp).saturating_sub(from) as f64 * 1e-6)
    }
}

/// `sinew-trust chain RIG STAMPS`: threads like a driver's of this rig, and no driver. For every SIGTERM the time at which its loop would
/// have put its outputs to zero.
///
/// # Errors
/// Files and signals that cannot be had.
pub fn chain(rig: &std::path::Path, stamps: &std::path::Path) -> Result<(), Failure> {
    let rig = Rig::load(rig).map_err(|error| Failure::Unexpected(error.to_string()))?;
    let wish = wish_of(&rig);
    let mut stamps = OpenOptions::new().append(true).open(stamps)?;
    let (mut heard, told) = UnixStream::pair()?;
    signal_hook::low_level::pipe::register(signal_hook::consts::SIGTERM, told)?;
    let asked = Arc::new(AtomicBool::new(false));
    let hears = asked.clone();
    std::thread::spawn(move || {
        realtime::go_first(&wish);
        while heard.read_exact(&mut [0]).is_ok() {
            hears.store(true, Ordering::Relaxed);
        }
    });
    let looping = std::thread::spawn(move || -> std::io::Result<()> {
        let (_held, mut report) = realtime::prepare_process(&wish);
        realtime::prepare_thread(&wish, &mut report);
        stamps.write_all(&0u64.to_ne_bytes())?;
        let period = Duration::from_secs_f64(1.0 / RATE_HZ);
        let until = std::time::Instant::now() + 30 * PATIENCE;
        while std::time::Instant::now() < until {
            std::thread::sleep(period);
            if asked.swap(false, Ordering::Relaxed) {
                stamps.write_all(&now_ns().to_ne_bytes())?;
            }
        }
        Ok(())
    });
    match looping.join() {
        Ok(ended) => Ok(ended?),
        Err(_) => Err(Failure::Unexpected("the chain has died".into())),
    }
}
