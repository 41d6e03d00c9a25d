//! The robot program as a process of its own, and the line on which its sensor talks to it.

use std::io::{self, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

use rustix::fs::OFlags;
use sinew_demonstrators::Watch;
use sinew_driver::DriverHandle;
use sinew_threads::Thread;

use super::machines::Demo;
use crate::failure::{Failure, Outcome};

/// How often it is looked whether the sensor has said something.
const LOOK: Duration = Duration::from_millis(1);
/// How long a robot program may take to end once its sensor is gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// A robot program that runs.
pub struct Robot {
    process: Child,
    said: tempfile::NamedTempFile,
    over: Arc<AtomicBool>,
    feeder: JoinHandle<Option<()>>,
}

impl Robot {
    /// Starts it, with a thread that hands it what its sensor says.
    pub fn start(demo: &'static Demo, machine: &Watch, driver: &DriverHandle) -> Result<Robot, Failure> {
        let failed = |what: &str| {
            let what = what.to_string();
            move |error: io::Error| Failure::own(format!("{what}: {error}"))
        };
        let program = std::env::current_exe().map_err(failed("where this program lies is not known"))?;
        let said =
            tempfile::NamedTempFile::new().map_err(failed("no temporary file for what the robot program says"))?;
        let words = said.reopen().map_err(failed("no temporary file for what the robot program says"))?;
        let mut process = Command::new(program)
            .args(["demo", demo.name, "--robot"])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(words)
            // Ctrl-C is for the driver: the robot program ends when its sensor does
            .process_group(0)
            .spawn()
            .map_err(failed("the robot program cannot be started"))?;
        let line = process.stdin.take().ok_or_else(|| Failure::own("the robot program has no line to its sensor"))?;
        // A robot program that hangs misses what its sensor says; nothing waits for it.
        rustix::fs::fcntl_setfl(&line, OFlags::NONBLOCK)
            .map_err(|error| Failure::own(format!("the robot program's line: {error}")))?;
        let over = Arc::new(AtomicBool::new(false));
        let (asked, is_over) = (over.clone(), over.clone());
        let stopper = driver.stopper();
        let start =
            Thread::Feeder.start().ends_when(move || is_over.load(Ordering::Relaxed)).on_death(move || stopper.fail());
        let machine = machine.clone();
        let feeder = start
            .spawn(move || feed(line, demo, &machine, &asked))
            .map_err(failed("no thread for the robot program's sensor"))?;
        Ok(Robot { process, said, over, feeder })
    }

    /// Whether it, or its sensor, has come to an end.
    pub fn has_ended(&self) -> bool {
        self.feeder.is_finished()
    }

    /// Ends it: takes its sensor away, on which it lets go of the wire and ends. `has_left`: it has ended by itself while its driver ran.
    pub fn finish(mut self, has_left: bool) -> Outcome {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.feeder.join();
        let until = Instant::now() + PATIENCE;
        let status = loop {
            match self.process.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if Instant::now() < until => sleep(LOOK),
                _ => break None,
            }
        };
        let Some(status) = status else {
            let _ = self.process.kill();
            let _ = self.process.wait();
            return Err(Failure::own("the robot program did not end and was killed"));
        };
        if has_left {
            let words = std::fs::read_to_string(self.said.path()).unwrap_or_default();
            return Err(Failure::own(format!("the robot program has ended ({status}): {}", words.trim())));
        }
        Ok(())
    }
}

/// Hands on what the sensor says, a line each, until it is over or nobody reads.
fn feed(mut line: ChildStdin, demo: &Demo, machine: &Watch, over: &AtomicBool) {
    let mut said = machine.reading().count;
    while !over.load(Ordering::Relaxed) && !sinew_threads::is_struck() {
        let reading = machine.reading();
        if reading.count != said {
            said = reading.count;
            let words = demo.says.iter().zip(demo.said(&reading));
            let words = words.map(|((name, _), value)| format!("{name}: {value:.3}"));
            let text = words.collect::<Vec<_>>().join(" ") + "\n";
            match line.write_all(text.as_bytes()) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => {
                    over.store(true, Ordering::Relaxed);
                    return;
                }
                Ok(()) => {}
            }
        }
        sleep(LOOK);
    }
}
