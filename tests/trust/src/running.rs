//! Processes under test: a driver with its output log and a client of it, or any other with a separate runtime folder.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use sinew_ipc::{Client, ClientOptions, Mode};

use crate::failure::{Failure, expect, unexpected};
use crate::lockstep::rig_text;
use crate::site::Site;
use crate::witness::{self, Put};

/// How long anything may take before a try gives up on it. Machines are busy.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// A machine whose host takes a core away now and then is that late, ms, besides what is measured.
pub const SLACK_MS: f64 = 60.0;
/// Rate of the drivers here, Hz.
pub const RATE_HZ: f64 = 1000.0;
/// Duty the wires have when they are struck.
pub const DUTY: f64 = 0.1;
/// Longer than any try.
pub const LONG: Duration = Duration::from_secs(200);

/// Looks again and again until `look` finds something.
///
/// # Errors
/// When it has found nothing for [`PATIENCE`], or fails itself.
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Result<Option<T>, Failure>) -> Result<T, Failure> {
    let started = Instant::now();
    loop {
        if let Some(found) = look()? {
            return Ok(found);
        }
        expect(started.elapsed() < PATIENCE, || format!("waited {PATIENCE:?} in vain for {what}"))?;
        std::thread::sleep(Duration::from_micros(500));
    }
}

/// A process that does not outlive its try.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    said: PathBuf,
}

impl Process {
    /// Starts it; what it says goes into a file.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub fn start(site: &Site, command: &mut Command) -> Result<Process, Failure> {
        let folder = site.folder()?;
        let said = folder.join("said");
        let file = File::create(&said)?;
        command.stdin(Stdio::piped()).stdout(file.try_clone()?).stderr(file);
        let child = command.spawn().map_err(|error| Failure::Unexpected(format!("{command:?}: {error}")))?;
        Ok(Process { name: format!("{command:?}"), child, said })
    }

    /// Its number.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// What it has said so far.
    pub fn said(&self) -> String {
        String::from_utf8_lossy(&std::fs::read(&self.said).unwrap_or_default()).into_owned()
    }

    /// Tells it something on its standard input.
    ///
    /// # Errors
    /// One that does not listen.
    pub fn tell(&mut self, line: &str) -> Result<(), Failure> {
        match &mut self.child.stdin {
            Some(pipe) => Ok(writeln!(pipe, "{line}")?),
            None => unexpected("it does not listen"),
        }
    }

    /// Sends it a signal.
    ///
    /// # Errors
    /// One that is gone.
    pub fn signal(&self, signal: Signal) -> Result<(), Failure> {
        let Some(pid) = Pid::from_raw(self.child.id() as i32) else { return unexpected("it has no number") };
        kill_process(pid, signal).map_err(|error| Failure::Unexpected(format!("{signal:?}: {error}")))
    }

    /// Stops it by SIGSTOP, and waits until it stands still.
    ///
    /// # Errors
    /// One that is gone.
    pub fn hold(&self) -> Result<(), Failure> {
        self.signal(Signal::STOP)?;
        let stat = format!("/proc/{}/stat", self.pid());
        // `PID (NAME) STATE …`: a name may hold anything.
        wait_for("a process to stand still", || {
            let stat = std::fs::read_to_string(&stat)?;
            Ok(stat.rsplit_once(')').filter(|(_, rest)| rest.trim_start().starts_with('T')).map(drop))
        })
    }

    /// How it ended, if it has.
    ///
    /// # Errors
    /// Where that cannot be known.
    pub fn ended(&mut self) -> Result<Option<ExitStatus>, Failure> {
        Ok(self.child.try_wait()?)
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// When it does not come.
    pub fn finish(&mut self) -> Result<ExitStatus, Failure> {
        let ended = wait_for("its end", || self.ended());
        ended.map_err(|failure| Failure::Unexpected(format!("{}: {failure}; it said: {}", self.name, self.said())))
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A driver with its witness, and a client of it.
pub struct Running {
    /// The driver.
    pub process: Process,
    /// Name of the rig.
    pub rig: String,
    /// Its channels.
    pub channels: usize,
    log: PathBuf,
    /// Its report, once it has ended in order.
    pub report: PathBuf,
    /// A client of it.
    pub client: Client,
}

/// How a driver is started.
#[derive(Debug, Clone, Default)]
pub struct How<'a> {
    /// Lines for the rig file's `[rig]` table.
    pub rig: &'a str,
    /// Put before the command, such as `prlimit`.
    pub wrapper: &'a [&'a str],
    /// Set in its environment.
    pub env: Vec<(&'a str, PathBuf)>,
}

/// The command that drives a rig of so many channels called `name`; its log and report.
///
/// # Errors
/// Files that cannot be written.
pub fn command(site: &Site, name: &str, channels: usize, how: &How) -> Result<(Command, PathBuf, PathBuf), Failure> {
    let folder = site.folder()?;
    let (file, log, report) = (folder.join("rig.toml"), folder.join("log"), folder.join("report.json"));
    let text = rig_text(name, channels, RATE_HZ, 7, "");
    let text = text.replacen("\n\n[simulation]", &format!("\n{}\n\n[simulation]", how.rig), 1);
    std::fs::write(&file, text)?;
    let itself = site.itself()?;
    let mut command = match how.wrapper {
        [] => Command::new(&itself),
        [wrapper, more @ ..] => {
            let mut command = Command::new(wrapper);
            command.args(more).arg(&itself);
            command
        }
    };
    command.arg("drive").arg(&file).arg(&log).arg("--report").arg(&report);
    for (name, value) in &how.env {
        command.env(name, value);
    }
    Ok((command, log, report))
}

/// A client of a driver that may just be starting.
///
/// # Errors
/// One that is not to be had.
pub fn connect(rig: &str) -> Result<Client, Failure> {
    Ok(Client::connect_with(rig, ClientOptions { connect: PATIENCE, answer: PATIENCE })?)
}

/// Starts a driver of the rig called `rig`, and waits until it is there; a client of it.
///
/// # Errors
/// One that does not come that far.
pub fn started(site: &Site, command: &mut Command, rig: &str) -> Result<(Process, Client), Failure> {
    let mut process = Process::start(site, command)?;
    wait_for("the driver to start", || {
        if let Some(status) = process.ended()? {
            return unexpected(format!("the driver ended with {status}: {}", process.said()));
        }
        match Client::connect(rig) {
            Ok(client) if client.info().pid == process.pid() => Ok(Some(())),
            _ => Ok(None),
        }
    })?;
    Ok((process, connect(rig)?))
}

impl Running {
    /// A driver with both wires at work.
    ///
    /// # Errors
    /// One that does not come that far.
    pub fn start(site: &Site, name: &str, how: &How) -> Result<Running, Failure> {
        let channels = 2;
        let (mut command, log, report) = command(site, name, channels, how)?;
        let (process, client) = started(site, &mut command, name)?;
        let running = Running { process, rig: name.into(), channels, log, report, client };
        running.at_work()?;
        Ok(running)
    }

    /// Waits until the sensors are proved, and powers both wires.
    ///
    /// # Errors
    /// When that does not come.
    pub fn at_work(&self) -> Result<(), Failure> {
        wait_for("proved sensors", || {
            let state = self.client.latest();
            Ok(state.channels().iter().all(|c| c.mode() == Mode::Off && state.cycle > 0).then_some(()))
        })?;
        for channel in 0..self.channels {
            self.client.set_duty(&format!("wire{channel}"), DUTY, LONG)?;
        }
        wait_for("power", || {
            Ok(self.put()?.last().is_some_and(|put| put.duty.iter().all(|d| *d == DUTY)).then_some(()))
        })
    }

    /// Everything it has put out so far.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub fn put(&self) -> Result<Vec<Put>, Failure> {
        witness::read(&self.log, self.channels)
    }

    /// When it last powered a wire, ms after `from_ns`; 0 if not at all since.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub fn powered_until_ms(&self, from_ns: u64) -> Result<f64, Failure> {
        let last = self.put()?.iter().rfind(|put| put.powers()).map_or(0, |put| put.at_ns);
        Ok(last.saturating_sub(from_ns) as f64 * 1e-6)
    }

    /// Waits until outputs are zero, as the witness sees it: ms from `from_ns` to the first put of nothing after which there is
    /// none of anything.
    ///
    /// # Errors
    /// When that does not come.
    pub fn zero_ms(&self, from_ns: u64) -> Result<f64, Failure> {
        wait_for("zero outputs", || {
            let put = self.put()?;
            let from = put.iter().rposition(Put::powers).map_or(0, |last| last + 1);
            Ok(put.get(from).map(|zero| zero.at_ns.saturating_sub(from_ns) as f64 * 1e-6))
        })
    }

    /// The report of a driver that has ended in order: as JSON, checked for what has to be true of each.
    ///
    /// # Errors
    /// One that is not there, or says that something is not accounted for.
    pub fn ended_in_order(&mut self) -> Result<serde_json::Value, Failure> {
        let status = self.process.finish()?;
        expect(status.success(), || format!("it ended with {status}: {}", self.process.said()))?;
        accounted(&self.report)
    }

    /// Ends it by SIGTERM; its report.
    ///
    /// # Errors
    /// As [`Running::ended_in_order`].
    pub fn stop(mut self) -> Result<serde_json::Value, Failure> {
        self.process.signal(Signal::TERM)?;
        self.ended_in_order()
    }
}

/// A report in which everything is accounted for: cycles and missed periods make up the time, no allocation in the loop, nothing
/// that subscribers did not get, zero at the end.
///
/// # Errors
/// One in which something is not.
pub fn accounted(path: &Path) -> Result<serde_json::Value, Failure> {
    let text = std::fs::read_to_string(path)?;
    let report: serde_json::Value = serde_json::from_str(&text).map_err(std::io::Error::other)?;
    let number = |key: &str| report[key].as_f64().unwrap_or(f64::NAN);
    let periods = number("seconds") * number("rate_hz");
    let counted = number("cycles") + number("missed");
    expect((periods - counted).abs() < 0.5, || format!("{periods} periods, {counted} accounted for"))?;
    expect(number("allocations_in_loop") == 0.0, || format!("allocations: {}", report["allocations_in_loop"]))?;
    expect(number("unpublished") == 0.0, || format!("unpublished: {}", report["unpublished"]))?;
    let zero = report["channel"].as_array().is_some_and(|c| c.iter().all(|c| c["duty"].as_f64() == Some(0.0)));
    expect(zero, || format!("it did not end at zero: {}", report["channel"]))?;
    Ok(report)
}
