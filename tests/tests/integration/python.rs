//! The Python package and the node for ROS 2 on top of it: their own tests, against drivers of this build. Skipped where Python or what they
//! need is missing.

use sinew_tests::{built, checkout, sinew};
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

fn python() -> Command {
    Command::new("python3")
}

/// Whether this is there to be imported, besides the standard library.
fn has(modules: &str) -> bool {
    let found = python().args(["-c", &format!("import {modules}")]).output();
    let there = found.is_ok_and(|ran| ran.status.success());
    if !there {
        eprintln!("python3 with {modules} is needed");
    }
    there
}

/// The package as an installed one looks: the pure half, and beside it what was compiled.
fn installed() -> TempDir {
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

/// Runs the tests of a package with these folders to import from.
fn passes(folder: &str, imports: &[&Path]) {
    let before = std::env::var_os("PYTHONPATH");
    let paths: Vec<OsString> = imports.iter().map(|path| path.into()).chain(before).collect();
    let ran = python()
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=5", "tests"])
        .current_dir(checkout().join(folder))
        .env("PYTHONPATH", std::env::join_paths(paths).expect("paths"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("SINEW_BINARY", sinew())
        .output()
        .expect("python3 was there a moment ago");
    let said = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    println!("{said}");
}

#[test]
fn the_package_passes_its_own_tests() {
    if !has("numpy, pandas, pyarrow, pytest") {
        return eprintln!("skipped");
    }
    if !has("nbclient, nbformat, ipykernel, matplotlib") {
        eprintln!("the notebooks are skipped");
    }
    passes("bindings/python", &[installed().path()]);
}

#[test]
fn the_node_for_ros_2_passes_its_own_tests() {
    if !has("numpy, pytest, rclpy, sensor_msgs, trajectory_msgs, diagnostic_msgs, std_srvs") {
        return eprintln!("skipped");
    }
    passes("bindings/ros2", &[installed().path(), &checkout().join("bindings/ros2")]);
}
