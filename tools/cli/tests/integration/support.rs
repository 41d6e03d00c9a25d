//! What the tests of the command line share: running it, and small files to run it on.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A scratch folder with files of the test's own.
pub struct Scratch {
    folder: TempDir,
}

impl Scratch {
    /// An empty one.
    pub fn new() -> Scratch {
        Scratch { folder: tempfile::tempdir().expect("a scratch folder") }
    }

    /// Where a file of that name is.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).expect("a scratch file");
        path
    }

    /// Runs the program in this folder, with no driver of anybody else's in sight.
    pub fn sinew<'a>(&self, args: impl IntoIterator<Item = &'a str>) -> Ran {
        let output = program()
            .args(args)
            .current_dir(self.folder.path())
            .env("SINEW_RUNTIME_DIR", self.runtime())
            .env("SINEW_STATE_DIR", self.path("state"))
            .env("NO_COLOR", "1")
            .output()
            .expect("the program runs");
        Ran(output)
    }

    /// A runtime folder of this test's own. A socket's name leaves it few letters, so it stands beside, not in, a deep folder.
    pub fn runtime(&self) -> PathBuf {
        let name = self.folder.path().file_name().expect("a name").to_string_lossy().replace(".tmp", "");
        Path::new("/tmp").join(format!("sinew-{name}"))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(self.runtime());
    }
}

/// The program, not started yet, its signals as from a terminal: whoever starts the tests may ignore some (`nohup`, a job in the
/// background, CI runners), and what is ignored stays so from one program to the next.
pub fn program() -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sinew"));
    // SAFETY: `signal` is a plain system call and may be called between fork and exec.
    unsafe {
        program.pre_exec(|| {
            // All but those of real time; SIGKILL and SIGSTOP refuse and are as they should be.
            for signal in 1..32 {
                libc::signal(signal, libc::SIG_DFL);
            }
            Ok(())
        });
    }
    program
}

/// What a run of the program came to.
pub struct Ran(Output);

impl Ran {
    /// Its exit code.
    pub fn code(&self) -> i32 {
        self.0.status.code().expect("an exit code")
    }

    /// What it printed as its result.
    pub fn stdout(&self) -> String {
        String::from_utf8(self.0.stdout.clone()).expect("text")
    }

    /// What it printed besides.
    pub fn stderr(&self) -> String {
        String::from_utf8(self.0.stderr.clone()).expect("text")
    }

    /// Bad input or use: exit 2, nothing on stdout, an error with all `needles` and a hint.
    #[track_caller]
    pub fn refused(&self, needles: &[&str]) {
        let stderr = self.stderr();
        assert_eq!(self.code(), 2, "{stderr}");
        assert_eq!(self.stdout(), "", "{stderr}");
        assert!(stderr.starts_with("error: "), "{stderr}");
        assert!(stderr.contains("\nhint: "), "{stderr}");
        for needle in needles {
            assert!(stderr.contains(needle), "expected {needle:?} in:\n{stderr}");
        }
    }

    /// Done: exit 0; gives what it printed.
    #[track_caller]
    pub fn done(&self) -> String {
        assert_eq!(self.code(), 0, "{}", self.stderr());
        self.stdout()
    }
}

/// A wire that lifts a weight, as in the contract's example.
pub const RIG: &str = r#"
[rig]
name = "tensile-bench"
rate_hz = 100.0

[[channel]]
name = "wire"

[channel.wire]
diameter_mm = 0.125
length_mm = 160.0

[channel.taps]
l0_mm = 0.0
ls_mm = 150.0

[channel.drive]
supply_v = 6.0
shunt_ohm = 0.1
switch_ohm = 0.02

[channel.load]
mass_kg = 0.2
damping_n_s_per_m = 40.0
preload_n = 1.96133
"#;

/// The same wire in a furnace under a given force.
pub const FURNACE: &str = r#"
[rig]
name = "furnace"
rate_hz = 1.0

[[channel]]
name = "wire"

[channel.wire]
diameter_mm = 0.5
length_mm = 100.0

[channel.drive]
kind = "temperature"

[channel.load]
kind = "imposed_force"
"#;

/// A wire pulled through a strain cycle while a given power heats it.
pub const WORK_LOOP: &str = r#"
[rig]
name = "work-loop"
rate_hz = 10.0

[[channel]]
name = "wire"

[channel.wire]
diameter_mm = 0.4
length_mm = 100.0

[channel.drive]
kind = "power"

[channel.load]
kind = "imposed_position"
"#;
