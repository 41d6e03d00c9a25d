//! `sinew monitor`: every channel live, as an ordinary client of a running driver.

use std::io::{self, IsTerminal};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::DriverHealth;

use super::live::{self, Live};
use crate::args;
use crate::driving::screen::plain::{self, Telling};
use crate::driving::screen::terminal;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// Runs the command.
pub fn monitor(args: &args::Monitor) -> Outcome {
    let mut live = Live::new(live::connect(&args.target)?);
    let asked = ending::asked()?;
    log::never_wait()?;
    let end = args.duration_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let over = || asked.load(Ordering::Relaxed) || end.is_some_and(|end| Instant::now() >= end);
    match Look::of(args.plain) {
        Look::Screen => terminal::show(&mut live, "quit", &over, None, None)?,
        Look::Words => {
            let every = args.every_s.map(Duration::from_secs_f64);
            let telling = Telling { quit_word: "quit", every, stdout_taken: false, reset_stop: None };
            plain::tell(&mut live, &over, telling)?;
        }
        Look::Lines => while lines(&mut live, &over, false)? {},
    }
    match live.ended() {
        Some(DriverHealth::Died) => Err(Failure::own(format!(
            "the driver of {} (process {}) died",
            live.client().info().rig,
            live.client().info().pid
        ))
        .hint("its outputs are at zero if its hardware has a watchdog; start it again with `sinew run`")),
        Some(_) => {
            output::note("the driver has stopped");
            Ok(())
        }
        None => Ok(()),
    }
}

/// How a running driver is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// On a screen of its own.
    Screen,
    /// In words, with commands typed as lines.
    Words,
    /// A line a second.
    Lines,
}

impl Look {
    /// How it is shown here. Words are for whoever wants them, and for a terminal that cannot place its cursor.
    pub fn of(wants_words: bool) -> Look {
        let has_cursor = std::env::var_os("TERM").is_some_and(|term| term != "dumb");
        match () {
            () if wants_words => Look::Words,
            () if !io::stdout().is_terminal() || !in_foreground() => Look::Lines,
            () if has_cursor => Look::Screen,
            () => Look::Words,
        }
    }
}

/// Whether a screen can be shown: a terminal that can place its cursor.
pub fn has_screen() -> bool {
    Look::of(false) == Look::Screen
}

/// Whether this process may use its terminal. One started with `&` would be stopped by the kernel at the first touch,
/// and a driver that stands still leaves its wires as they are.
fn in_foreground() -> bool {
    // SAFETY: both calls take and give plain numbers; a terminal that is gone gives -1.
    unsafe { libc::tcgetpgrp(libc::STDOUT_FILENO) == libc::getpgrp() }
}

/// Waits a second, then prints a line (to stderr if stdout is wanted for something else); whether to go on.
pub fn lines(live: &mut Live, over: &dyn Fn() -> bool, stdout_taken: bool) -> Result<bool, Failure> {
    let next = Instant::now() + Duration::from_secs(1);
    while Instant::now() < next {
        if over() || live.ended().is_some() {
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    if sinew_threads::is_struck() {
        return Ok(false);
    }
    let line = live.look().plain_line();
    if stdout_taken {
        output::note(line);
        return Ok(true);
    }
    output::try_print(format_args!("{line}\n"))
}
