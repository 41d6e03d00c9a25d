//! The environment of the tries: the programs they start and the folders they use.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::TempDir;

use crate::failure::Failure;

/// The programs and a folder for everything that is written.
#[derive(Debug)]
pub struct Site {
    folder: TempDir,
    sinew: OnceLock<Result<PathBuf, String>>,
    itself: Option<PathBuf>,
    count: AtomicU64,
}

impl Site {
    /// A folder of its own; the programs are looked for when they are needed.
    ///
    /// # Errors
    /// Where no folder can be made.
    pub fn new() -> Result<Site, Failure> {
        // Short: a socket's path has little room.
        let folder = tempfile::Builder::new().prefix("st-").tempdir_in("/tmp")?;
        Ok(Site { folder, sinew: OnceLock::new(), itself: None, count: AtomicU64::new(0) })
    }

    /// Like this, with the `sinew` program given.
    #[must_use]
    pub fn with_sinew(self, path: &Path) -> Site {
        let _ = self.sinew.set(Ok(path.into()));
        self
    }

    /// Like this, with the `sinew-trust` program given: for those who only use the library.
    #[must_use]
    pub fn with_itself(self, path: &Path) -> Site {
        Site { itself: Some(path.into()), ..self }
    }

    /// A number nobody had before.
    pub fn number(&self) -> u64 {
        self.count.fetch_add(1, Ordering::Relaxed)
    }

    /// A new folder.
    ///
    /// # Errors
    /// Where it cannot be made.
    pub fn folder(&self) -> Result<PathBuf, Failure> {
        let path = self.folder.path().join(format!("{}", self.number()));
        std::fs::create_dir(&path)?;
        Ok(path)
    }

    /// A rig name that no driver on this machine has.
    pub fn name(&self, kind: &str) -> String {
        let mut name = format!("trust-{}-{kind}", std::process::id());
        name.truncate(40);
        format!("{name}-{}", self.number())
    }

    /// This very program, which can also be a driver with a witness, or a client.
    ///
    /// # Errors
    /// Where it has no path.
    pub fn itself(&self) -> Result<PathBuf, Failure> {
        match &self.itself {
            Some(path) => Ok(path.clone()),
            None => Ok(std::env::current_exe()?),
        }
    }

    /// The program `sinew` of the same build: `SINEW_BINARY`, or built beside this one.
    ///
    /// # Errors
    /// Where it cannot be built.
    pub fn sinew(&self) -> Result<PathBuf, Failure> {
        let found = self.sinew.get_or_init(|| match std::env::var_os("SINEW_BINARY") {
            Some(path) => Ok(path.into()),
            None => beside("sinew-cli", "sinew"),
        });
        found.clone().map_err(Failure::Unexpected)
    }
}

/// Builds a program with the profile this one was built with: `TARGET/PROFILE/PROGRAM`.
fn beside(package: &str, program: &str) -> Result<PathBuf, String> {
    let exe = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut folder = exe.parent().unwrap_or(Path::new(".")).to_path_buf();
    if folder.file_name() == Some(OsStr::new("deps")) {
        folder.pop();
    }
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("."));
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(checkout).args(["build", "--quiet", "-p", package, "--bin", program]);
    if let Some(target) = folder.parent() {
        cargo.arg("--target-dir").arg(target);
    }
    if folder.file_name() != Some(OsStr::new("debug")) {
        cargo.arg("--release");
    }
    let built = cargo.stdin(Stdio::null()).output().map_err(|error| format!("cargo: {error}"))?;
    let path = folder.join(program);
    if built.status.success() && path.is_file() {
        Ok(path)
    } else {
        Err(format!("{cargo:?}: {}", String::from_utf8_lossy(&built.stderr)))
    }
}
