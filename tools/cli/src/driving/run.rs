//! `sinew run`: the driver with the rig's backend, the monitor or plain lines on top, and the report at the end.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Read};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGTSTP, SIGXFSZ};
use sinew_backend::Backend;
use sinew_black_box::{BlackBox, Place};
use sinew_demonstrators::Watch;
use sinew_driver::report::Ending;
use sinew_driver::{Driver, DriverHandle, Error, Options, RunReport, Stopper, Tap, wish_of};
use sinew_ipc::Client;
use sinew_realtime as realtime;
use sinew_realtime::Wish;
use sinew_rig::{BackendKind, Doubt, Pace, Rig};
use sinew_threads::{Comes, Thread};

use super::held::{Held, Hold};
use super::life;
use super::live::{self, Live};
use super::monitor::{Look, lines};
use super::{herald, program};
use crate::args;
use crate::commands::load_rig_with;
use crate::driving::backend::{self, Chosen};
use crate::driving::screen::plain::{self, Telling};
use crate::driving::screen::terminal;
use crate::driving::screen::view::micros;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// How long a run may take to say what it came to, once its outputs are zero and somebody has asked for its end.
const PARTING: Duration = Duration::from_secs(20);
const LOOK: Duration = Duration::from_millis(1);
/// How long a signal is listened for without a break.
const HEARING: Duration = Duration::from_millis(200);

/// Runs the command.
pub fn run(args: &args::Run) -> Outcome {
    let rig = at_speed(load_rig_with(args.rig.as_deref(), &args.laws)?, args.speed)?;
    if args.rig.is_none()
        && let Some(passed_over) = passed_over(Path::new("."))
    {
        output::note(format_args!("note: this is the built-in {}; `sinew run {passed_over}` drives yours", rig.name));
    }
    for Doubt { line, channel, key, says } in rig.doubts() {
        output::note(format_args!("doubt: {}:{line}: channel \"{channel}\": {key}: {says}", rig.file()));
    }
    let asked =
        Asked { duration_s: args.duration_s, report_to: args.report.as_deref(), leaves_traces: true, hold: None };
    drive(&rig, &asked, |driven, over| show(args, driven, over))
}

/// What is asked of a run.
pub struct Asked<'a> {
    /// After so long it ends by itself, s.
    pub duration_s: Option<f64>,
    /// Where its report goes.
    pub report_to: Option<&'a Path>,
    /// Whether it keeps black boxes and the accounts of its wires' lives.
    pub leaves_traces: bool,
    /// What its outputs are held to, beside its supervisor.
    pub hold: Option<Hold>,
}

/// A running driver, for whoever shows it.
pub struct Driven<'a> {
    /// Its rig.
    pub rig: &'a Rig,
    /// What a person calls its wires.
    pub wires: &'a str,
    /// What runs.
    pub driver: &'a DriverHandle,
    /// The machine that a simulated wire moves.
    pub machine: Option<&'a Watch>,
}

impl Driven<'_> {
    /// A separate ordinary client to look with; `None` where a very short run is over before anybody could look.
    pub fn look(&self) -> Result<Option<Live>, Failure> {
        match Client::connect(&self.rig.name) {
            Ok(client) => Ok(Some(Live::new(client))),
            Err(_) if !self.driver.is_running() => Ok(None),
            Err(error) => Err(live::failure(error)),
        }
    }

    /// Shows it on its own terminal until a key, `over` or its end closes that.
    pub fn on_screen(&self, live: &mut Live, over: &dyn Fn() -> bool) -> Outcome {
        let quiet = log::hold_back();
        let reset_stop = || self.driver.reset_emergency_stop();
        let shown = terminal::show(live, "stop", over, Some(&reset_stop), self.machine);
        // The terminal may take its time for what was kept back.
        self.driver.stop();
        drop(quiet);
        shown
    }

    /// Tells of it in words, and takes what is typed, until `over` or its end.
    fn in_words(&self, live: &mut Live, over: &dyn Fn() -> bool, stdout_taken: bool) -> Outcome {
        // it is told here, and once is enough; the report comes behind what was kept back
        let quiet = log::hold_back();
        let reset_stop = || self.driver.reset_emergency_stop();
        let telling = Telling { quit_word: "stop", every: None, stdout_taken, reset_stop: Some(&reset_stop) };
        let told = plain::tell(live, over, telling);
        self.driver.stop();
        drop(quiet);
        told
    }
}

/// Drives a rig for as long as `show` shows it, or it ends by itself; then reports.
pub fn drive(rig: &Rig, asked: &Asked<'_>, show: impl FnOnce(&Driven<'_>, &dyn Fn() -> bool) -> Outcome) -> Outcome {
    let Asked { duration_s, report_to, leaves_traces, .. } = *asked;
    if let Some(path) = report_to {
        output::has_place(path)?;
    }
    // Before anything is opened: every client takes some.
    sinew_ipc::descriptors::raise_limit();
    let signals = signal_line()?;
    let Chosen { backend, simulated, wires, line, machine } = backend::choose(rig)?;
    let backend: Box<dyn Backend> = match &asked.hold {
        Some(hold) => Box::new(Held::new(backend, hold.clone())),
        None => backend,
    };
    let options = Options { duration_s, program: program::of(rig)?, simulated, ..Options::default() };
    // Nor does a file that may not grow any further (`ulimit -f`) end it: that is the black box's to find out.
    signal_hook::flag::register(SIGXFSZ, Arc::default())
        .map_err(|error| Failure::own(format!("signal {SIGXFSZ} cannot be handled: {error}")))?;
    let (black_box, seconds) = leaves_traces.then(|| black_box(rig, simulated)).flatten().unzip();
    let (accounts, lives) = leaves_traces.then(|| life::keep(rig, simulated)).flatten().unzip();
    let taps = seconds.into_iter().chain(lives).collect();
    log::never_wait()?;
    let driver = Driver::start_tapped(rig, backend, options, taps).map_err(|error| driver_failure(rig, error))?;
    stop_when_asked(signals, driver.stopper(), wish_of(rig))?;
    let told = herald::start(rig, &driver)?;
    let stopper = driver.stopper();
    // A panic stops the driver before the terminal is put back, which nobody may be reading.
    let main = Thread::Main.start().on_death(move || stopper.fail());
    let driven = Driven { rig, wires: &wires, driver: &driver, machine: machine.as_ref() };
    let shown = main.run(|| show(&driven, &|| !driver.is_running())).unwrap_or(Ok(()));
    driver.stop();
    let mut report = driver.join();
    if let Some(told) = told {
        // it says that the driver stops, before the report takes its time
        let _ = told.join();
    }
    log::part();
    if let Some(black_box) = black_box {
        let written = black_box.finish();
        (report.black_boxes, report.black_box_error) = (written.files, written.failure);
    }
    let lives = accounts.map_or_else(String::new, |accounts| life::summary(&accounts.finish()));
    // who holds it tells what it found in words of its own
    if asked.hold.is_none() {
        output::note((summary(&report) + &lives).trim_end());
    }
    if let Some(line) = line.filter(|_| asked.hold.is_none()) {
        output::note(format_args!(
            "  line      {} frames sent, {} answered in time, {} late, {} damaged, {} not taken; {} connections, {} trips",
            line.sent(),
            line.answered(),
            line.late(),
            line.damaged(),
            line.unsent(),
            line.connections(),
            line.trips()
        ));
    }
    if let Some(path) = report_to {
        let text = output::json(&report)? + "\n";
        if path == Path::new("-") { output::print(text)? } else { output::write_file(path, &text)? }
    }
    shown?;
    if !report.outputs_confirmed_zero {
        let remedy = "take the supply away; the run report and what stands above say which output it is";
        return Err(Failure::own("not every output has confirmed zero: a wire may still be heated").hint(remedy));
    }
    match report.ended {
        Ending::Panicked => Err(Failure::own(format!("{}; outputs are at zero", deaths(&report)))
            .hint("please report it, with what stands above")),
        Ending::Duration | Ending::Stopped => Ok(()),
    }
}

/// A rig file in this folder, which nobody has named: the first by its name.
fn passed_over(folder: &Path) -> Option<String> {
    let files = std::fs::read_dir(folder).ok()?.flatten();
    // A pipe of that name would have us wait for a writer.
    let files = files.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let names = files.filter_map(|entry| entry.file_name().into_string().ok());
    let has_rig = |name: &String| Rig::load(&folder.join(name)).is_ok();
    names.filter(|name| name.ends_with(".toml")).filter(has_rig).min()
}

/// The rig with the speed of time that is asked for.
fn at_speed(mut rig: Rig, speed: Option<f64>) -> Result<Rig, Failure> {
    let Some(speed) = speed else { return Ok(rig) };
    if rig.backend.kind != BackendKind::Simulated && speed != 1.0 {
        return Err(Failure::input(format!(
            "--speed {speed}: the wires of {} are not simulated, and have the clock's own time",
            rig.file()
        ))
        .hint("leave --speed out"));
    }
    (rig.simulation.pace, rig.simulation.speed) =
        if speed.is_finite() { (Pace::RealTime, speed) } else { (Pace::AsFastAsPossible, 1.0) };
    Ok(rig)
}

/// The signals that end a driver. One that stands still leaves its wires as they are, heated or not: Ctrl-Z ends it like Ctrl-C.
fn ending() -> impl Iterator<Item = i32> {
    ending::SIGNALS.into_iter().chain([SIGTSTP])
}

/// The end of a line that every signal to end writes to: whoever reads it needs nobody else to notice. From now on no thread but the
/// one that listens is interrupted by them: the kernel would choose the first, which may wait long for a processor.
fn signal_line() -> Result<UnixStream, Failure> {
    let (heard, told) =
        UnixStream::pair().map_err(|error| Failure::own(format!("signals cannot be listened for: {error}")))?;
    for signal in ending() {
        told.try_clone()
            .and_then(|told| signal_hook::low_level::pipe::register(signal, told))
            .map_err(|error| Failure::own(format!("signal {signal} cannot be handled: {error}")))?;
    }
    mask(libc::SIG_BLOCK).map_err(|error| Failure::own(format!("signals cannot be kept for one thread: {error}")))?;
    Ok(heard)
}

/// Keeps the signals to end from this thread and those it starts (`SIG_BLOCK`), or lets them through (`SIG_UNBLOCK`).
fn mask(how: i32) -> io::Result<()> {
    // SAFETY: the set is this function's own and initialised by sigemptyset before it is used; nothing is asked back.
    let refused = unsafe {
        let mut set: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&mut set);
        for signal in ending() {
            libc::sigaddset(&mut set, signal);
        }
        libc::pthread_sigmask(how, &set, std::ptr::null_mut())
    };
    if refused == 0 { Ok(()) } else { Err(io::Error::from_raw_os_error(refused)) }
}

/// Ends the driver at the first signal, on a thread of its own: the one that shows it may be waiting for a terminal that nobody reads. Where
/// it goes on doing so the process ends without it.
fn stop_when_asked(mut heard: UnixStream, stopper: Stopper, wish: Wish) -> Outcome {
    let failed = |error: io::Error| Failure::own(format!("no thread to listen for signals: {error}"));
    heard.set_read_timeout(Some(HEARING)).map_err(failed)?;
    let deaf = stopper.clone();
    let listen = move || {
        realtime::go_first(&wish);
        if mask(libc::SIG_UNBLOCK).is_err() {
            return;
        }
        loop {
            match heard.read(&mut [0]) {
                Ok(1..) => break,
                Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => {}
                // a line that is gone has nothing more to say
                Ok(_) | Err(_) => return,
            }
            if sinew_threads::is_struck() {
                return;
            }
        }
        stopper.stop();
        while !stopper.has_ended() {
            thread::sleep(LOOK);
        }
        thread::sleep(PARTING);
        std::process::exit(1);
    };
    let start = Thread::Signals.start().ends_when(|| false).on_death(move || deaf.fail());
    start.spawn(listen).map(drop).map_err(failed)
}

/// The black box the rig file asks for, and the tap that fills it. A driver without one is better than none: what is wrong is a
/// warning.
fn black_box(rig: &Rig, simulated: bool) -> Option<(BlackBox, Box<dyn Tap>)> {
    if !rig.black_box.enabled {
        return None;
    }
    let warn = |error: &sinew_black_box::Error| {
        output::note(format_args!("warning: no black box: {error}; {}", error.remedy()));
    };
    let folder = sinew_black_box::folder().inspect_err(warn).ok()?;
    let place = Place::new(folder, &rig.name, rig.black_box.keep as usize);
    // The folder may be usable by the time of a fault.
    let _ = place.prepare().inspect_err(warn);
    BlackBox::start(rig, place, simulated).inspect_err(warn).ok()
}

/// Shows the running driver until `over`.
fn show(args: &args::Run, driven: &Driven<'_>, over: &dyn Fn() -> bool) -> Outcome {
    let Driven { rig, wires, .. } = *driven;
    let Some(mut live) = driven.look()? else { return Ok(()) };
    let look = if args.no_monitor { Look::Lines } else { Look::of(args.plain) };
    if look == Look::Screen {
        return driven.on_screen(&mut live, over);
    }
    let info = live.client().info();
    output::note(format_args!(
        "driving {} ({} {wires} at {} Hz) as process {}; Ctrl-C or `sinew stop` ends it",
        info.rig, info.channels, info.rate_hz, info.pid
    ));
    output::note(program::says(rig));
    if rig.backend.estop.fitted {
        let how = if look == Look::Words { "or by reset-stop" } else { "alone" };
        output::note(format_args!(
            "the emergency stop is latched; without a screen here it is reset by its own button {how}"
        ));
    }
    // the report has stdout to itself
    let quiet = args.report.as_deref() == Some(Path::new("-"));
    if look == Look::Words {
        return driven.in_words(&mut live, over, quiet);
    }
    while lines(&mut live, over, quiet)? {}
    Ok(())
}

/// Which threads the driver has ended for.
fn deaths(report: &RunReport) -> String {
    let died =
        sinew_threads::TABLE.iter().filter(|row| row.comes == Comes::End && report.threads_died.contains(&row.name));
    let who: Vec<String> = died.map(|row| format!("the thread that {} has died", row.does)).collect();
    if who.is_empty() { "the driver has died".into() } else { who.join(", ") }
}

/// Why there is no driver, with what to do about it.
pub fn driver_failure(rig: &Rig, error: Error) -> Failure {
    match error {
        Error::Services(error) => live::failure(error),
        Error::Rig { place, reason } => Failure::input(format!("{}: {place}: {reason}", rig.file())),
        Error::NotRealtime { .. } => {
            Failure::own(error).hint("`sinew doctor` tells more; realtime = \"try\" in [rig] goes on without")
        }
        error => Failure::own(error),
    }
}

/// What a run came to, for a person.
fn summary(report: &RunReport) -> String {
    let mut text = String::new();
    let (late, cycle) = (report.lateness_us, report.cycle_us);
    let _ = writeln!(
        text,
        "{}: {:.1} s, {} cycles at {} Hz, {} missed{}",
        report.rig,
        report.seconds,
        report.cycles,
        report.rate_hz,
        report.missed,
        match report.missed {
            0 => String::new(),
            _ => format!(" ({} woken too late, {} cycles too long)", report.missed_by_wakeup, report.missed_by_cycle),
        }
    );
    for (what, q) in [("lateness", late), ("cycle", cycle)] {
        if q.max.is_finite() {
            let (p50, p99, p999, max) = (micros(q.p50), micros(q.p99), micros(q.p999), micros(q.max));
            let _ = writeln!(text, "  {what:<9} p50 {p50}  p99 {p99}  p999 {p999}  max {max} µs");
        }
    }
    for row in sinew_threads::TABLE.iter().filter(|row| report.threads_died.contains(&row.name)) {
        let _ = writeln!(text, "  thread    {} has died", row.name);
    }
    if let Some(count @ 1..) = report.allocations_in_loop {
        let _ = writeln!(text, "  {count} allocations in the loop, expected none");
    }
    if report.unpublished > 0 {
        let _ = writeln!(text, "  {} cycles no stream could get", report.unpublished);
    }
    let faults = report.faults.len() as u64 + report.faults_not_listed;
    let _ = writeln!(text, "  faults    {}", if faults == 0 { "none".into() } else { faults.to_string() });
    for fault in report.faults.iter().take(10) {
        let _ = writeln!(text, "    {:.3} s  {}: {} ({})", fault.time_s, fault.channel, fault.flag, fault.cause);
    }
    if faults > 10 {
        let _ = writeln!(text, "    … and {} more; --report FILE.json lists them", faults - 10);
    }
    for file in &report.black_boxes {
        let _ = writeln!(text, "  black box {}", file.display());
    }
    if let Some(error) = &report.black_box_error {
        let _ = writeln!(text, "  black box {error}");
    }
    if !report.outputs_confirmed_zero {
        let _ = writeln!(text, "  outputs   zero was NOT confirmed by all of them");
    }
    if let Some(error) = &report.backend_error {
        let _ = writeln!(text, "  backend   {error}");
    }
    text + &refused(report)
}

/// What Linux refused, each remedy once.
fn refused(report: &RunReport) -> String {
    let mut by_remedy: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for row in report.rt.missing() {
        by_remedy.entry(&row.remedy).or_default().push(&row.asked);
    }
    let mut text = String::new();
    for (remedy, asked) in by_remedy {
        let _ = writeln!(text, "  real time: {} refused\n    type: {remedy}", asked.join(", "));
    }
    if !text.is_empty() {
        text += "    `sinew doctor` says what each costs\n";
    }
    text
}
