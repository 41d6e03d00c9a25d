//! What the tests across processes share: the `sinew` binary, rig files of their own, drivers that never outlive their test.
//!
//! Every test has its own folder and its own rig name, so that all of them run at the same time, beside whatever else runs
//! on the machine. Nothing here asserts how fast something is: [`PATIENCE`] is only where waiting becomes a failure.

pub mod browser;
pub mod page;

use serde_json::Value;
use sinew_ipc::{Client, ClientOptions, DriverHealth};
use sinew_recording::session::Session;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// How long anything may take before a test gives up on it. Machines are busy.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// A driver whose test died without cleaning up ends by itself after so long, s.
const LONGEST_TEST_S: &str = "300";
/// Rate of the tests' rigs, Hz: fast enough to control, light enough for many drivers on two cores.
pub const RATE_HZ: f64 = 500.0;
/// Duty of the sensing pulse.
pub const SENSING_DUTY: f64 = 0.02;

/// The checkout.
pub fn checkout() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in the checkout")
}

/// The `sinew` binary of the same profile as this test. `SINEW_BINARY` names another one.
pub fn sinew() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| match std::env::var_os("SINEW_BINARY") {
        Some(path) => path.into(),
        None => built("sinew"),
    })
}

/// The robot program `examples/gait.rs`.
pub fn gait() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| built("examples/gait"))
}

/// The machine that injects faults, `sinew-trust`.
pub fn trust() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| built("sinew-trust"))
}

/// The firmware of a front-end as a process, `sinew-front-end`. `SINEW_FRONT_END` names another one.
pub fn front_end() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| match std::env::var_os("SINEW_FRONT_END") {
        Some(path) => path.into(),
        None => built("sinew-front-end"),
    })
}

/// A rig's wires as Linux would show them, `sinew-linux-tree`.
pub fn linux_tree() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| built("sinew-linux-tree"))
}

/// The folder of the libraries for C, `libsinew.so` and `libsinew.a`. `SINEW_C_LIBRARIES` names another one.
pub fn c_libraries() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| match std::env::var_os("SINEW_C_LIBRARIES") {
        Some(path) => path.into(),
        None => built("libsinew.so").parent().expect("it lies in a folder").into(),
    })
}

/// Where a program or library of the workspace lies, such as the compiled half of the Python package, `lib_sinew.so`. All that tests start are built at once, as parts of the workspace and with an example
/// among them: so the other crates get the same features as in `cargo test --workspace`, and are not built once more.
pub fn built(program: &str) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let programs = ["sinew", "sinew-trust", "sinew-front-end", "sinew-linux-tree"];
    let folder = FOLDER.get_or_init(|| {
        let bins = programs.iter().flat_map(|program| ["--bin", program]);
        build(
            &["--workspace", "--lib", "--example", "gait", "--example", "robot"]
                .into_iter()
                .chain(bins)
                .collect::<Vec<_>>(),
        )
    });
    folder.join(program)
}

/// Builds what `which` names with the profile, target and target folder this test was built with; returns where it lands.
fn build(which: &[&str]) -> PathBuf {
    let exe = std::env::current_exe().expect("a test has a path");
    // …/target[/TRIPLE]/PROFILE/deps/TEST-HASH
    let folder = exe.ancestors().nth(2).expect("tests lie in PROFILE/deps");
    let above = folder.parent().expect("PROFILE lies in the target folder");
    let name = |path: &Path| path.file_name().and_then(OsStr::to_str).expect("a folder has a name").to_string();
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(checkout()).arg("build").args(which);
    match name(folder).as_str() {
        "debug" => {}
        profile => drop(cargo.args(["--profile", profile])),
    }
    // cargo marks its target folder, but not the folder of a triple in it
    if above.join("CACHEDIR.TAG").is_file() {
        cargo.arg("--target-dir").arg(above);
    } else {
        cargo.arg("--target").arg(name(above));
        cargo.arg("--target-dir").arg(above.parent().expect("a triple lies in the target folder"));
    }
    let built = cargo.stdin(Stdio::null()).output().expect("cargo can be started");
    assert!(built.status.success(), "{cargo:?}:\n{}", String::from_utf8_lossy(&built.stderr));
    folder.into()
}

/// Looks again and again until `look` finds something.
///
/// # Panics
/// When it has found nothing for [`PATIENCE`].
#[track_caller]
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(started.elapsed() < PATIENCE, "waited {PATIENCE:?} in vain for: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until it is so.
///
/// # Panics
/// When it was not so for [`PATIENCE`].
#[track_caller]
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    wait_for(what, || is_so().then_some(()));
}

/// What a command left behind.
#[derive(Debug)]
pub struct Finished {
    /// Its exit code; `None` = killed by a signal.
    pub code: Option<i32>,
    /// All it said on stdout.
    pub stdout: String,
    /// All it said on stderr.
    pub stderr: String,
}

impl Finished {
    /// Expects this exit code.
    #[track_caller]
    pub fn expect(self, code: i32) -> Finished {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Expects exit 2 and all of these words on stderr, an `error:` and a `hint:` line among them; and nothing on stdout.
    #[track_caller]
    pub fn refused(self, words: &[&str]) -> Finished {
        assert_eq!(self.code, Some(2), "{self:#?}");
        assert_eq!(self.stdout, "", "{self:#?}");
        for word in words.iter().chain(&["error: ", "hint: "]) {
            assert!(self.stderr.contains(word), "stderr lacks {word:?}: {self:#?}");
        }
        self
    }

    /// Stdout as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:#?}"))
    }
}

/// Runs `sinew` with these arguments to its end.
#[track_caller]
pub fn run<A: AsRef<OsStr>>(args: impl IntoIterator<Item = A>) -> Finished {
    Process::start(Command::new(sinew()).args(args)).finish()
}

/// A rig file of a test's own, in a folder of its own, under a name nobody else has.
#[derive(Debug)]
pub struct Rig {
    folder: TempDir,
    /// Its name, by which clients find its driver.
    pub name: String,
}

impl Rig {
    /// A bench of simulated wires called `channels`, with more tables at the end of the file (such as `[[simulation.fault]]`).
    pub fn bench(channels: &[&str], more: &str) -> Rig {
        let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = {RATE_HZ:?}\n"));
        for name in channels {
            rig.add(&Rig::wire(name));
        }
        rig.add(more);
        rig
    }

    /// A channel like the built-in hexapod's: 0.125 mm × 160 mm against a spring, 6.5 V.
    pub fn wire(name: &str) -> String {
        format!(
            "\n[[channel]]\nname = \"{name}\"\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
             taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\n\
             drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}\n"
        )
    }

    /// A file of any text, which gets the name to put into it.
    pub fn named(text: impl FnOnce(&str) -> String) -> Rig {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = format!("test-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = tempfile::Builder::new().prefix("sinew-tests-").tempdir().expect("a temporary folder");
        let rig = Rig { folder, name };
        fs::write(rig.path(), text(&rig.name)).expect("the folder is writable");
        rig
    }

    /// Adds text at the end of the file.
    pub fn add(&mut self, text: &str) {
        let before = fs::read_to_string(self.path()).expect("written before");
        fs::write(self.path(), before + text).expect("the folder is writable");
    }

    /// The rig file.
    pub fn path(&self) -> PathBuf {
        self.file("rig.toml")
    }

    /// A file of this name in the test's folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `sinew COMMAND … --rig NAME`, run to its end.
    #[track_caller]
    pub fn ask(&self, args: &[&str]) -> Finished {
        run(args.iter().chain(&["--rig", &self.name]))
    }

    /// A client of this rig's driver.
    #[track_caller]
    pub fn client(&self) -> Client {
        Client::connect_with(&self.name, ClientOptions { connect: PATIENCE, answer: PATIENCE })
            .unwrap_or_else(|e| panic!("{e}"))
    }

    /// `sinew run` for this rig, not started yet.
    pub fn command(&self, more: &[&str]) -> Command {
        let mut command = Command::new(sinew());
        command.arg("run").arg(self.path()).arg("--no-monitor").args(more);
        command.env("SINEW_STATE_DIR", self.folder.path());
        command
    }
}

/// A process that is killed at the latest when it goes out of scope. What it says goes into files: a pipe nobody reads would
/// hold it up.
#[derive(Debug)]
pub struct Process {
    child: Child,
    said: TempDir,
}

/// Lets a program have its signals as from a terminal. Whoever starts the tests may ignore some (`nohup`, a job in the background,
/// CI runners), and what is ignored stays so from one program to the next.
fn with_default_signals(command: &mut Command) {
    // SAFETY: `signal` is a plain system call and may be called between fork and exec.
    unsafe {
        command.pre_exec(|| {
            // All but those of real time; SIGKILL and SIGSTOP refuse and are as they should be.
            for signal in 1..32 {
                libc::signal(signal, libc::SIG_DFL);
            }
            Ok(())
        });
    }
}

/// What a process has of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resources {
    /// Threads.
    pub threads: usize,
    /// Descriptors.
    pub open_files: usize,
    /// Memory it has touched, bytes.
    pub memory_bytes: usize,
}

impl Process {
    /// Starts it.
    #[track_caller]
    pub fn start(command: &mut Command) -> Process {
        Process::spawn(command, Stdio::null())
    }

    /// Starts it so that it can be told something, see [`Process::tell`].
    #[track_caller]
    pub fn start_to_be_told(command: &mut Command) -> Process {
        Process::spawn(command, Stdio::piped())
    }

    /// Starts it with this as its standard input.
    #[track_caller]
    pub fn start_reading(command: &mut Command, stdin: impl Into<Stdio>) -> Process {
        Process::spawn(command, stdin.into())
    }

    #[track_caller]
    fn spawn(command: &mut Command, stdin: Stdio) -> Process {
        let said = tempfile::Builder::new().prefix("sinew-said-").tempdir().expect("a temporary folder");
        let file = |name| File::create(said.path().join(name)).expect("the folder is writable");
        let (stdout, stderr) = (file("stdout"), file("stderr"));
        command.stdin(stdin).stdout(stdout).stderr(stderr);
        with_default_signals(command);
        let child = command.spawn().unwrap_or_else(|e| panic!("{command:?}: {e}"));
        Process { child, said }
    }

    /// Its process id.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Writes a line to its standard input.
    #[track_caller]
    pub fn tell(&mut self, line: &str) {
        let stdin = self.child.stdin.as_mut().expect("it was started to be told something");
        writeln!(stdin, "{line}").and_then(|()| stdin.flush()).unwrap_or_else(|e| panic!("{line}: {e}"));
    }

    fn read(&self, name: &str) -> String {
        String::from_utf8_lossy(&fs::read(self.said.path().join(name)).unwrap_or_default()).into_owned()
    }

    /// What it has said on stdout so far.
    pub fn stdout(&self) -> String {
        self.read("stdout")
    }

    /// What it has said on stderr so far.
    pub fn stderr(&self) -> String {
        self.read("stderr")
    }

    /// How it ended, if it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("it is our child")
    }

    /// Waits until it has said this on stdout.
    #[track_caller]
    pub fn wait_for_word(&mut self, word: &str) {
        wait_until(word, || {
            let said = self.stdout().contains(word);
            if !said && let Some(status) = self.ended() {
                panic!("it ended with {status} before it said {word:?}: {}{}", self.stdout(), self.stderr());
            }
            said
        });
    }

    /// Sends it a signal.
    pub fn signal(&self, signal: libc::c_int) {
        // SAFETY: plain system call; the process is our child and has not been waited for, so the id is still its own.
        let sent = unsafe { libc::kill(self.child.id() as libc::pid_t, signal) };
        assert_eq!(sent, 0, "{}", std::io::Error::last_os_error());
    }

    /// What it has of the machine at this moment.
    #[track_caller]
    pub fn resources(&self) -> Resources {
        let proc = format!("/proc/{}", self.pid());
        let status = fs::read_to_string(format!("{proc}/status")).expect("our child");
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a process has memory");
        let kib = resident.trim().trim_end_matches(" kB").parse::<usize>().expect("a number of KiB");
        Resources {
            threads: fs::read_dir(format!("{proc}/task")).expect("our child").count(),
            open_files: fs::read_dir(format!("{proc}/fd")).expect("our child").count(),
            memory_bytes: kib << 10,
        }
    }

    /// Kills it as the kernel would when memory runs out, and waits until it is gone.
    pub fn kill(mut self) {
        self.child.kill().expect("it is our child");
        self.child.wait().expect("it is our child");
    }

    /// Waits for its end.
    #[track_caller]
    pub fn finish(mut self) -> Finished {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = self.ended() {
                break status;
            }
            assert!(started.elapsed() < PATIENCE, "still running: {}{}", self.stdout(), self.stderr());
            std::thread::sleep(Duration::from_millis(2));
        };
        Finished { code: status.code(), stdout: self.stdout(), stderr: self.stderr() }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if !matches!(self.child.try_wait(), Ok(Some(_))) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        if std::thread::panicking() {
            eprintln!("--- process {} said:\n{}{}---", self.pid(), self.stdout(), self.stderr());
        }
    }
}

/// A running driver of a [`Rig`].
#[derive(Debug)]
pub struct Driver {
    /// Its process.
    pub process: Process,
    report: PathBuf,
}

impl Driver {
    /// Starts `sinew run` and waits until its loop runs.
    #[track_caller]
    pub fn start(rig: &Rig) -> Driver {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let report = rig.file(&format!("report-{}.json", COUNT.fetch_add(1, Ordering::Relaxed)));
        let mut command = rig.command(&["--for", LONGEST_TEST_S]);
        let mut process = Process::start(command.arg("--report").arg(&report));
        wait_until("the driver's loop", || {
            if let Some(status) = process.ended() {
                panic!("the driver ended with {status}: {}{}", process.stdout(), process.stderr());
            }
            Client::connect(&rig.name).is_ok_and(|client| {
                client.info().pid == process.pid()
                    && client.health() == DriverHealth::Running
                    && client.latest().cycle > 0
            })
        });
        Driver { process, report }
    }

    /// Starts it, and waits until every channel has proved its sensors.
    #[track_caller]
    pub fn ready(rig: &Rig) -> (Driver, Client) {
        let driver = Driver::start(rig);
        let client = rig.client();
        wait_until("sensors to prove themselves", || {
            client.latest().channels().iter().all(|c| c.mode() != sinew_ipc::Mode::Waiting)
        });
        (driver, client)
    }

    /// Its process id.
    pub fn pid(&self) -> u32 {
        self.process.pid()
    }

    /// Ends it by SIGTERM; its report.
    #[track_caller]
    pub fn stop(self) -> Value {
        self.process.signal(libc::SIGTERM);
        self.stopped()
    }

    /// Waits for its end, which has to be in order; its report, checked for what has to be true of every run.
    #[track_caller]
    pub fn stopped(self) -> Value {
        let Driver { process, report } = self;
        process.finish().expect(0);
        let text = fs::read_to_string(&report).unwrap_or_else(|e| panic!("{}: {e}", report.display()));
        let report: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        check_report(&report);
        report
    }
}

/// What has to be true of the report of every run that ended in order: the form of `sinew.run/1`, no allocation in the loop,
/// outputs at zero.
#[track_caller]
pub fn check_report(report: &Value) {
    assert_eq!(report["schema"], "sinew.run/1", "{report:#}");
    assert_eq!(report["allocations_in_loop"], 0, "{report:#}");
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number: {report:#}"));
    assert!(number(&report["seconds"]) > 0.0);
    let cycles = report["cycles"].as_u64().unwrap_or_else(|| panic!("cycles: {report:#}"));
    let missed = report["missed"].as_u64().unwrap_or_else(|| panic!("missed: {report:#}"));
    assert!(cycles > 0, "{report:#}");
    let periods = number(&report["seconds"]) * number(&report["rate_hz"]);
    assert!((periods - (cycles + missed) as f64).abs() < 0.5, "{periods} periods: {report:#}");
    for histogram in ["lateness_us", "cycle_us"] {
        let q = ["p50", "p99", "p999", "max"].map(|key| number(&report[histogram][key]));
        assert!(q[0] >= 0.0 && q.is_sorted() && q[3].is_finite(), "{histogram}: {report:#}");
    }
    let rt = &report["rt"];
    assert!(matches!(rt["policy"].as_str(), Some("SCHED_FIFO" | "SCHED_OTHER")), "{report:#}");
    assert!(rt["locked"].is_boolean(), "{report:#}");
    assert!(report["faults"].is_array(), "{report:#}");
    let channels = report["channel"].as_array().unwrap_or_else(|| panic!("channel: {report:#}"));
    assert_eq!(report["channels"].as_u64(), Some(channels.len() as u64), "{report:#}");
    for channel in channels {
        assert!(channel["name"].is_string(), "{channel:#}");
        assert_eq!(channel["duty"].as_f64(), Some(0.0), "outputs end at zero: {channel:#}");
        for key in ["length_m", "target_m"] {
            assert!(matches!(channel.get(key), Some(Value::Number(_) | Value::Null)), "{key}: {channel:#}");
        }
        assert!(matches!(channel.get("fault"), Some(Value::String(_) | Value::Null)), "{channel:#}");
    }
}

/// Numbers of the cycles that are safe in a recording which may still be being written.
pub fn recorded_so_far(path: &Path) -> Vec<u64> {
    let mut found = Vec::new();
    if let Ok(session) = Session::open(path) {
        let mut cycles = session.cycles();
        while let Ok(Some(cycle)) = cycles.next() {
            found.push(cycle.head.cycle);
        }
    }
    found
}

/// Files in a folder, sorted.
pub fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("a readable folder").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
