//! The guard: a second, small process that sets the outputs to zero when the driver cannot.
//!
//! The kernel keeps generating PWM after the program that configured it has died. So the outputs belong to the guard: it
//! opens them, locks them against other drivers, and watches a socket to the driver.
//!
//! - The socket closes (the driver ended, was killed, ran out of memory): zero, at once, until the write succeeds.
//! - No beat for the agreed time (the driver is stopped, hangs, starves): zero, repeatedly until a beat arrives. A write of
//!   the driver's that was blocked in the kernel meanwhile is overwritten.
//! - The guard itself hangs: the driver detects the missing echo, fails its exchange and sets the outputs to zero, until it answers.
//! - The guard itself dies: the same, and the driver starts another one.
//!
//! Where a line switches the supply of all power stages, the guard holds that too, by a file of its own or by the driver's request of it,
//! which it inherits: the line stays requested while either lives. It is put off together with the outputs, and before them.
//!
//! One byte goes each way: the driver's beat is answered by an echo, and `ZEROED` notifies it that the outputs were set to zero.
//! The guard wakes a few times in a beat, is scheduled above the loop where Linux allows it, locks its memory, and does nothing
//! else. Both killed at once leave the outputs as they are: only hardware protects against that (docs/linux-backend.md).

use std::env;
use std::ffi::OsString;
use std::io::{self, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use rustix::net::{RecvFlags, SendFlags, recv, send};
use sinew_realtime as realtime;
use sinew_realtime::{Held, Mode, Wish};

use crate::Error;
use crate::alone;
use crate::line::{NO_LINE, Output};
use crate::sysfs::Attribute;

/// The word that makes a program a guard: its first argument.
pub const WORD: &str = "pwm-guard";

const READY: u8 = b'r';
const BEAT: u8 = b'b';
/// The guard has put the outputs to zero because the driver was silent.
const ZEROED: u8 = b'z';
/// So many beats in the time of silence the guard bears, and so many times that without an echo until it is given up.
pub(crate) const BEATS: u32 = 5;
const ECHOES: u32 = 2 * BEATS;
/// How long the predecessor's guard may take to release the outputs, and a new one to get ready.
const HANDOVER: Duration = Duration::from_secs(2);
const START: Duration = Duration::from_secs(5);
/// How often and for how long an output that cannot be written is tried again once the driver is gone.
const AGAIN: Duration = Duration::from_millis(10);
const GIVE_UP: Duration = Duration::from_secs(30);
/// How long the driver waits for the end of its guard.
const PARTING: Duration = Duration::from_secs(1);
/// SCHED_FIFO: above any loop (99 belongs to the kernel).
const PRIORITY: u8 = 98;

/// The driver's end.
#[derive(Debug)]
pub(crate) struct Guard {
    child: Child,
    /// Dropped first when it ends, so that the child sees it.
    line: Option<UnixStream>,
    unanswered: u32,
}

/// What the guard has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Watch {
    /// It watches.
    Good,
    /// It has put the outputs to zero, since the driver was silent.
    Zeroed,
    /// It does not answer.
    Silent,
    /// It is gone.
    Gone,
}

impl Guard {
    /// Starts the guard over these outputs (`duty_cycle` files) and the line of the supply, and waits until it holds them.
    pub fn start(
        program: &(PathBuf, Vec<String>),
        silence: Duration,
        supply: Option<&Output>,
        outputs: &[PathBuf],
    ) -> Result<Guard, Error> {
        let failed = |reason: String| Error::Guard { reason };
        let io = |what: &str| {
            let what = what.to_string();
            move |error: io::Error| Error::Guard { reason: format!("{what}: {error}") }
        };
        let (line, other) = UnixStream::pair().map_err(io("socket"))?;
        let (told, handed) = match supply {
            Some(line) => line.hand_over().map_err(io("the enable line"))?,
            None => (vec![NO_LINE.into()], Stdio::null()),
        };
        let child = Command::new(&program.0)
            .args(&program.1)
            .arg(silence.as_micros().to_string())
            .args(told)
            .args(outputs)
            .stdin(Stdio::from(OwnedFd::from(other)))
            .stdout(handed)
            // A Ctrl-C in the terminal is for the driver; the guard ends when that has.
            .process_group(0)
            .spawn()
            .map_err(io(&format!("{}", program.0.display())))?;
        let guard = Guard { child, line: Some(line), unanswered: 0 };
        let line = guard.line.as_ref().ok_or_else(|| failed("no line".into()))?;
        // Its first byte says that it is ready, anything else is a message, which ends with its end.
        line.set_read_timeout(Some(START)).map_err(io("socket"))?;
        let mut said = Vec::new();
        let mut buffer = [0u8; 256];
        loop {
            match recv(line, &mut buffer, RecvFlags::empty()) {
                Ok((_, 1)) if said.is_empty() && buffer[0] == READY => break,
                Ok((_, 0)) | Err(Errno::CONNRESET) => {
                    let words = String::from_utf8_lossy(&said).trim().to_string();
                    let nothing = format!("{} ended without a word", program.0.display());
                    return Err(failed(if words.is_empty() { nothing } else { words }));
                }
                Ok((_, count)) => said.extend_from_slice(&buffer[..count]),
                Err(Errno::INTR) => {}
                Err(errno) => return Err(failed(format!("no answer within {START:?} ({errno})"))),
            }
        }
        line.set_nonblocking(true).map_err(io("socket"))?;
        Ok(guard)
    }

    /// Sends a beat and reads what has been said since the last one.
    #[inline]
    pub fn beat(&mut self) -> Watch {
        let Some(line) = &self.line else { return Watch::Gone };
        let mut said = [0u8; 64];
        let mut watch = Watch::Good;
        match recv(line, &mut said[..], RecvFlags::DONTWAIT) {
            Ok((_, 0)) => return Watch::Gone,
            Ok((count, _)) => {
                for byte in &said[..count] {
                    match *byte {
                        BEAT => self.unanswered = self.unanswered.saturating_sub(1),
                        ZEROED => watch = Watch::Zeroed,
                        _ => {}
                    }
                }
            }
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(_) => return Watch::Gone,
        }
        if self.unanswered >= ECHOES {
            return Watch::Silent;
        }
        match send(line, &[BEAT], SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
            Ok(_) => {
                self.unanswered += 1;
                watch
            }
            // Full: it has read nothing for long.
            Err(Errno::AGAIN | Errno::INTR) => Watch::Silent,
            Err(_) => Watch::Gone,
        }
    }

    /// The guard's process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Ends it: it puts everything to zero once more. Whether it has said so within [`PARTING`]; otherwise it goes on trying by
    /// itself, without anybody who waits for it.
    pub fn end(mut self) -> bool {
        self.part()
    }

    fn part(&mut self) -> bool {
        // The end of the line is what it waits for.
        self.line = None;
        let since = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return status.success(),
                Ok(None) if since.elapsed() < PARTING => thread::sleep(Duration::from_millis(1)),
                Ok(None) | Err(_) => return false,
            }
        }
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        self.part();
    }
}

/// The guard's whole life: `arguments` are the time of silence in µs, the line of the supply and the outputs' `duty_cycle` files, standard
/// input is the socket to the driver, standard output the request of that line where a chip has it. A program that is to be its own
/// guard calls this first thing in `main` when its first argument is [`WORD`].
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let line = io::stdin();
    let line = line.as_fd();
    match watch(line, arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            let _ = send(line, reason.as_bytes(), SendFlags::NOSIGNAL);
            let _ = writeln!(io::stderr(), "sinew pwm-guard: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn watch(line: impl AsFd, mut arguments: impl Iterator<Item = OsString>) -> Result<(), String> {
    let silence = arguments.next().and_then(|text| text.to_str()?.parse().ok()).map(Duration::from_micros);
    let Some(silence) = silence.filter(|silence| !silence.is_zero()) else {
        return Err("this is a part of `sinew run`, which starts it by itself".into());
    };
    let supply = Output::take_over(&mut arguments)?;
    let open = |path: OsString| Attribute::to_write(path.into()).map_err(|error| error.to_string());
    let outputs: Vec<Attribute> = arguments.map(open).collect::<Result<_, String>>()?;
    // A request of a line is exclusive by itself.
    let file_of_supply = supply.as_ref().and_then(Output::attribute);
    for output in outputs.iter().chain(file_of_supply) {
        own(output)?;
    }
    let zero = || zero(supply.as_ref(), &outputs);
    let _held = last_long();
    send(&line, &[READY], SendFlags::NOSIGNAL).map_err(|errno| format!("the driver is gone: {errno}"))?;

    // Nothing can be put out before the first beat: the driver sends it before its first duty.
    let mut last_beat: Option<Instant> = None;
    let mut told = false;
    let mut said = [0u8; 64];
    loop {
        let patience = last_beat.map(|beat| silence.saturating_sub(beat.elapsed()));
        let timeout =
            patience.map(|time| Timespec { tv_sec: time.as_secs() as i64, tv_nsec: time.subsec_nanos().into() });
        let mut lines = [PollFd::new(&line, PollFlags::IN)];
        match poll(&mut lines, timeout.as_ref()) {
            Ok(0) => {}
            Ok(_) => match recv(&line, &mut said[..], RecvFlags::DONTWAIT) {
                Ok((0, _)) => break,
                Ok((count, _)) => {
                    last_beat = Some(Instant::now());
                    told = false;
                    // An echo that does not fit is missed by the driver, as it should be.
                    let _ = send(&line, &said[..count], SendFlags::DONTWAIT | SendFlags::NOSIGNAL);
                    continue;
                }
                Err(Errno::AGAIN | Errno::INTR) => continue,
                Err(_) => break,
            },
            Err(Errno::INTR) => continue,
            Err(_) => break,
        }
        if last_beat.is_some_and(|beat| beat.elapsed() >= silence) {
            zero();
            if !told {
                told = send(&line, &[ZEROED], SendFlags::DONTWAIT | SendFlags::NOSIGNAL).is_ok();
            }
            // Once more after the same time: a write of the driver's may still have been on its way.
            last_beat = Some(Instant::now());
        }
    }
    let since = Instant::now();
    while !zero() {
        if since.elapsed() > GIVE_UP {
            return Err("some outputs could not be put to zero; take the supply away".into());
        }
        thread::sleep(AGAIN);
    }
    Ok(())
}

/// The supply off and all outputs to zero; whether that worked, or there is nothing left to be put off.
fn zero(supply: Option<&Output>, outputs: &[Attribute]) -> bool {
    let is_done = |written| matches!(written, Ok(()) | Err(Errno::NODEV | Errno::NXIO | Errno::NOENT));
    // A file of a line that is an input still, and is nothing to be put off, answers EPERM.
    let is_off = supply.is_none_or(|line| match line.put(false) {
        Err(Errno::PERM) => true,
        written => is_done(written),
    });
    // every one of them, whatever became of those before
    outputs.iter().map(|output| is_done(output.write(0))).fold(is_off, |all, one| all & one)
}

/// Takes an output for this driver alone.
fn own(output: &Attribute) -> Result<(), String> {
    let since = Instant::now();
    loop {
        match flock(output.file(), FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => return Ok(()),
            Err(Errno::WOULDBLOCK) if since.elapsed() < HANDOVER => thread::sleep(AGAIN),
            Err(Errno::WOULDBLOCK) if alone::is_locked_by_strangers(output.file()) => {
                let path = output.path().display();
                let _ = writeln!(
                    io::stderr(),
                    "sinew pwm-guard: a lock on {path} of somebody who may not write to it is passed over"
                );
                return Ok(());
            }
            Err(Errno::WOULDBLOCK) => {
                return Err(format!("{} belongs to another driver that still runs", output.path().display()));
            }
            Err(errno) => return Err(format!("{}: lock: {errno}", output.path().display())),
        }
    }
}

/// Sees to it that the guard outlives and outruns what it guards, as far as it is allowed.
fn last_long() -> Held {
    use rustix::thread::{CpuSet, sched_setaffinity};
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP};

    // A signal to the whole process group must not end the guard before the driver.
    for signal in [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP] {
        let _ = signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)));
    }
    // The driver's loop keeps to one core, which its child inherits; the guard may use any.
    let mut all = CpuSet::new();
    (0..CpuSet::MAX_CPU).for_each(|cpu| all.set(cpu));
    let _ = sched_setaffinity(None, &all);
    let wish = Wish { mode: Mode::Try, priority: PRIORITY, cpu: realtime::allowed_cores().first().copied() };
    let (held, mut report) = realtime::prepare_process(&wish);
    realtime::prepare_thread(&wish, &mut report);
    held
}

/// The program that is running, as its own guard.
pub fn this_program() -> (PathBuf, Vec<String>) {
    let program = env::current_exe().unwrap_or_else(|_| PathBuf::from("/proc/self/exe"));
    (program, vec![WORD.into()])
}
