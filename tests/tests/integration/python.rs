//! The Python package and the node for ROS 2 on top of it: their own tests, against drivers of this build. Skipped where Python or what they
//! need is missing.

use sinew_tests::{Process, built, checkout, sinew};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// How long all tests of a package may take before they are given up.
const LONGEST: Duration = Duration::from_secs(900);

/// Whether this interpreter has these modules, besides the standard library.
pub(super) fn has(python: &OsStr, modules: &str) -> bool {
    let found = Command::new(python).args(["-c", &format!("import {modules}")]).output();
    let there = found.is_ok_and(|ran| ran.status.success());
    if !there {
        eprintln!("{} with {modules} is needed", python.display());
    }
    there
}

/// The package as an installed one looks: the pure half, and beside it what was compiled.
pub(super) fn installed() -> TempDir {
    let installed = tempfile::Builder::new().prefix("sinew-python-").tempdir().expect("a temporary folder");
    let package = installed.path().join("sinew");
    fs::create_dir(&package).expect("the folder is writable");
    for entry in fs::read_dir(checkout().join("bindings/python/python/sinew")).expect("the pure half") {
        let file = entry.expect("an entry").path();
        if file.extension().is_some_and(|end| end == "py") {
            symlink(&file, package.join(file.file_name().expect("a name"))).expect("a link");
        }
    }
    symlink(built("lib_sinew.so"), package.join("_sinew.abi3.so")).expect("a link");
    installed
}

/// What `PYTHONPATH` is with these folders to import from, before those that are there.
pub(super) fn import_path(imports: &[&Path]) -> OsString {
    let before = std::env::var_os("PYTHONPATH").unwrap_or_default();
    let imports = imports.iter().map(|path| path.to_path_buf());
    let paths: Vec<PathBuf> = imports.chain(std::env::split_paths(&before)).collect();
    std::env::join_paths(paths).expect("paths")
}

/// Runs the tests of a package with these folders to import from.
fn passes(python: &OsStr, folder: &str, imports: &[&Path]) {
    let mut pytest = Command::new(python);
    pytest
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=5", "tests"])
        .current_dir(checkout().join(folder))
        .env("PYTHONPATH", import_path(imports))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("SINEW_BINARY", sinew());
    let mut pytest = Process::start(&mut pytest);
    // many tests, each with a patience of its own
    let begun = Instant::now();
    while pytest.ended().is_none() && begun.elapsed() < LONGEST {
        std::thread::sleep(Duration::from_millis(20));
    }
    let ran = pytest.finish();
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    println!("{}", ran.stdout);
}

#[test]
fn the_package_passes_its_own_tests() {
    let python = OsStr::new("python3");
    if !has(python, "numpy, pandas, pyarrow, pytest") {
        return eprintln!("skipped");
    }
    if !has(python, "nbclient, nbformat, ipykernel, matplotlib") {
        eprintln!("the notebooks are skipped");
    }
    passes(python, "bindings/python", &[installed().path()]);
}

#[test]
fn the_node_for_ros_2_passes_its_own_tests() {
    // what PyPI has of ROS 2 needs an environment of its own
    let python = std::env::var_os("SINEW_ROS2_PYTHON").unwrap_or_else(|| "python3".into());
    if !has(&python, "numpy, pytest, rclpy, sensor_msgs.msg, trajectory_msgs.msg, diagnostic_msgs.msg, std_srvs.srv") {
        return eprintln!("skipped");
    }
    passes(&python, "bindings/ros2", &[installed().path(), &checkout().join("bindings/ros2")]);
}
