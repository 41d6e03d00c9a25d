//! `sinew tour`: what the program does, shown by its own commands in a folder of their own, which is gone at the end.

use std::fs::{self, File};
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use sinew_report::wrapped;

use crate::args;
use crate::commands::fitting::width;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Name of the rig, of its folder and of its file.
const RIG: &str = "tour";
/// Where a path is short.
const SHORT: &str = "/tmp";
/// How long a driver may take until it is seen, and until it has ended.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often it is looked whether somebody asks for the end.
const LOOK: Duration = Duration::from_millis(50);
/// Longest line of what is told, characters.
const WIDEST: usize = 100;

/// Runs the command.
pub fn tour(args: &args::Tour) -> Outcome {
    if let Some(folder) = &args.keep {
        output::can_keep_in(folder)?;
    }
    let mut guide = Guide::new(args)?;
    let seen = guide.show(args);
    guide.leave();
    match seen {
        // Who has asked for the end wants no error of what it has cut off.
        Err(_) if guide.is_over() => output::print("\nThe tour ends here, and leaves nothing behind.\n"),
        seen => seen,
    }
}

/// Who leads: types the commands, waits for whoever looks on, and clears away.
struct Guide {
    /// This program.
    program: PathBuf,
    /// Where everything is written.
    folder: tempfile::TempDir,
    /// Where its driver is found: sockets need a short path, which that of temporary files need not be.
    running: tempfile::TempDir,
    /// The driver that runs, and what it says.
    driver: Option<(Child, PathBuf)>,
    asked: Arc<AtomicBool>,
    waits: bool,
}

impl Guide {
    fn new(args: &args::Tour) -> Result<Guide, Failure> {
        let program = std::env::current_exe()
            .map_err(|error| Failure::own(format!("where this program lies is not known: {error}")))?;
        let mut new = tempfile::Builder::new();
        new.prefix("sinew-tour-");
        let folder = new.tempdir().map_err(|error| {
            Failure::own(format!("no folder for temporary files: {error}"))
                .hint("set TMPDIR to one where you may write")
        })?;
        let running =
            new.tempdir_in(SHORT).map_err(|error| Failure::own(format!("{SHORT}: cannot be written: {error}")))?;
        let waits = !args.no_wait && io::stdin().is_terminal() && io::stdout().is_terminal();
        Ok(Guide { program, folder, running, driver: None, asked: ending::asked()?, waits })
    }

    fn show(&mut self, args: &args::Tour) -> Outcome {
        output::print("A tour in three parts: a wire moves, a program dies, physics is missing.\n")?;
        self.a_wire_moves()?;
        self.a_program_dies()?;
        self.physics_is_missing(args)
    }

    fn a_wire_moves(&mut self) -> Outcome {
        self.tell(
            "1 · A wire moves",
            "What lies on the bench stands in one file. Here it is a wire of Flexinol and the spring that stretches it; as long as there is no \
             hardware, the full physics of the wire stands in for it.",
        )?;
        self.run(&["new", RIG, "--wire", "flexinol-150-lt"])?;
        self.tell(
            "",
            "The driver measures and switches it a thousand times a second. Nothing but two voltages tells its length.",
        )?;
        self.drive(&["run", "tour/tour.toml", "--no-monitor"])?;
        self.run(&["set", "wire", "stroke=80%", "--hold", "4"])?;
        self.pause(2.0)?;
        self.run(&["status"])?;
        self.tell("", "80 % of its stroke, hot, and held there by little power.")
    }

    fn a_program_dies(&mut self) -> Outcome {
        self.tell(
            "2 · A program dies",
            "That setpoint was a lease of four seconds, and nobody has renewed it: to the driver, its program has died. A robot program that \
             crashes heats no wire any longer. This wire goes back to what its rig file asks for meanwhile, a few steps up and down:",
        )?;
        self.pause(3.0)?;
        self.run(&["status"])?;
        self.tell("", "`program`, it says now. This ends the driver, outputs first:")?;
        self.run(&["stop"])?;
        self.driver_ends()
    }

    fn physics_is_missing(&mut self, args: &args::Tour) -> Outcome {
        self.tell(
            "3 · Physics is missing",
            "Now a recording of another wire, in which something happens that its rig file knows nothing of. It is made by a simulator that \
             shares no code with this program's own, and what it is lies in a sealed envelope.",
        )?;
        let seed = args.seed.map(|seed| seed.to_string());
        let conceal = ["conceal", "riddle", "--level", "10"];
        let seed = seed.as_deref().map(|seed| ["--seed", seed]);
        self.run(&conceal.into_iter().chain(seed.into_iter().flatten()).collect::<Vec<_>>())?;
        self.tell("", "Where do recording and simulation differ, and which physics was left out?")?;
        self.run(&["diagnose", "riddle/rig.toml", "riddle/recording.csv", "--out", "riddle/answer"])?;
        self.tell("", "And what was it? Not always what was found: how often stands in docs/proof.md.")?;
        self.run(&["reveal", "riddle"])?;
        let kept = match &args.keep {
            Some(folder) => self.keep(folder)?,
            None => "All of it is gone now; `sinew tour --keep FOLDER` keeps the files, the report among them.".into(),
        };
        self.tell(
            "",
            &format!("{kept} Next: `sinew new bench` with what lies on yours, and the tutorials in docs/book."),
        )
    }

    /// Tells something, under a heading or under none, once whoever looks on wants it.
    fn tell(&self, heading: &str, words: &str) -> Outcome {
        if !heading.is_empty() {
            self.wait_for_enter()?;
            output::print(format_args!("\n{heading}\n"))?;
        }
        output::print(format_args!("\n{}\n", wrapped(words, width().min(WIDEST)).join("\n")))
    }

    fn wait_for_enter(&self) -> Outcome {
        if !self.waits {
            return self.go_on();
        }
        output::print("\n[Enter] goes on, Ctrl-C ends the tour ")?;
        let stdin = io::stdin();
        let look = Timespec::try_from(LOOK).unwrap_or_default();
        loop {
            self.go_on()?;
            // interrupted by a signal: the next round sees it
            if poll(&mut [PollFd::new(&stdin, PollFlags::IN)], Some(&look)).is_ok_and(|ready| ready > 0) {
                // a terminal that is gone has no line, and asks for the end by a signal
                let _ = stdin.read_line(&mut String::new());
                return Ok(());
            }
        }
    }

    /// Types a command, and waits for its end.
    fn run(&self, words: &[&str]) -> Outcome {
        self.type_out(words)?;
        let status = self.command(words).status();
        let status =
            status.map_err(|error| Failure::own(format!("`sinew {}` cannot be run: {error}", words.join(" "))))?;
        self.go_on()?;
        if status.success() { Ok(()) } else { Err(self.broken(words)) }
    }

    /// Types the command of a driver, which goes on beside what follows, and waits until it is seen.
    fn drive(&mut self, words: &[&str]) -> Outcome {
        self.type_out(words)?;
        let said = self.folder.path().join("driver.txt");
        let failed = |error: io::Error| Failure::own(format!("`sinew {}` cannot be run: {error}", words.join(" ")));
        let (out, err) = File::create(&said).and_then(|file| Ok((file.try_clone()?, file))).map_err(failed)?;
        let child = self.command(words).stdout(out).stderr(err).spawn().map_err(failed)?;
        self.driver = Some((child, said));
        let begun = Instant::now();
        loop {
            self.pause(0.3)?;
            let seen = self.command(&["status"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
            if seen.is_ok_and(|status| status.success()) {
                return Ok(());
            }
            let has_ended = self.driver.as_mut().is_some_and(|(child, _)| !matches!(child.try_wait(), Ok(None)));
            if has_ended || begun.elapsed() > PATIENCE {
                return Err(self.broken(words));
            }
        }
    }

    /// What the driver has to say at its end, once it has ended.
    fn driver_ends(&mut self) -> Outcome {
        let Some((mut child, said)) = self.driver.take() else { return Ok(()) };
        wait_for_end(&mut child);
        let said = fs::read_to_string(said).unwrap_or_default();
        let report: Vec<&str> = said.lines().skip_while(|line| !line.starts_with(&format!("{RIG}: "))).collect();
        output::print(format_args!("{}\n", report.join("\n")))
    }

    fn type_out(&self, words: &[&str]) -> Outcome {
        output::print(format_args!("\n$ sinew {}\n", words.join(" ")))
    }

    /// A command of this program, in a folder and with a driver of its own.
    fn command(&self, words: &[&str]) -> Command {
        let folder = self.folder.path();
        let mut command = Command::new(&self.program);
        command.args(words).current_dir(folder).stdin(Stdio::null());
        command.env("SINEW_RUNTIME_DIR", self.running.path()).env("SINEW_STATE_DIR", folder.join("state"));
        command
    }

    fn broken(&self, words: &[&str]) -> Failure {
        let failure = Failure::own(format!("`sinew {}` has failed, and the tour ends", words.join(" ")));
        match self.driver.as_ref().and_then(|(_, said)| fs::read_to_string(said).ok()) {
            Some(said) if !said.trim().is_empty() => failure.also(said.trim_end()),
            _ => failure.hint("`sinew doctor` says what this machine lacks"),
        }
    }

    /// Copies the folder to where it may stay.
    fn keep(&self, to: &Path) -> Result<String, Failure> {
        let failed = |error: io::Error| {
            Failure::own(format!("{}: cannot be written: {error}", to.display()))
                .hint("choose a folder where you may write")
        };
        fs::create_dir_all(to).map_err(failed)?;
        for part in [RIG, "riddle"] {
            copy(&self.folder.path().join(part), &to.join(part)).map_err(failed)?;
        }
        Ok(format!("Kept in {}; open riddle/answer/report.html there.", to.display()))
    }

    fn pause(&self, seconds: f64) -> Outcome {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < until {
            self.go_on()?;
            sleep(LOOK);
        }
        self.go_on()
    }

    fn is_over(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    fn go_on(&self) -> Outcome {
        if self.is_over() { Err(Failure::own("the tour was ended")) } else { Ok(()) }
    }

    /// Ends the driver, if one runs: the folder goes with the guide.
    fn leave(&mut self) {
        if let Some((mut child, _)) = self.driver.take() {
            if let Some(pid) = Pid::from_raw(child.id().cast_signed()) {
                // one that has ended already needs no signal
                let _ = kill_process(pid, Signal::TERM);
            }
            wait_for_end(&mut child);
        }
    }
}

/// Waits for a driver to end, and kills one that does not: its wires are simulated.
fn wait_for_end(child: &mut Child) {
    let begun = Instant::now();
    while matches!(child.try_wait(), Ok(None)) && begun.elapsed() < PATIENCE {
        sleep(LOOK);
    }
    let _ = child.kill();
    let _ = child.wait();
}

fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to)?;
        } else {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}
