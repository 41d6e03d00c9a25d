//! The Python package: its own tests, against a driver of this build. Skipped where Python or what they need is missing.

use sinew_tests::{built, checkout, sinew};
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

/// What the tests import besides the standard library.
const NEEDED: &str = "import numpy, pandas, pyarrow, pytest";

#[test]
fn the_package_passes_its_own_tests() {
    let python = || Command::new("python3");
    let has = |program: &str| python().args(["-c", program]).output().is_ok_and(|ran| ran.status.success());
    if !has(NEEDED) {
        eprintln!("skipped: python3 with numpy, pandas, pyarrow and pytest is needed");
        return;
    }
    if !has("import nbclient, nbformat, ipykernel, matplotlib") {
        eprintln!("the notebooks are skipped: nbclient, nbformat, ipykernel and matplotlib are needed");
    }
    // The package as an installed one looks: the pure half, and beside it what was compiled.
    let source = checkout().join("bindings/python");
    let installed = tempfile::Builder::new().prefix("sinew-python-").tempdir().expect("a temporary folder");
    let package = installed.path().join("sinew");
    fs::create_dir(&package).expect("the folder is writable");
    for entry in fs::read_dir(source.join("python/sinew")).expect("the pure half") {
        let file = entry.expect("an entry").path();
        if file.extension().is_some_and(|end| end == "py") {
            symlink(&file, package.join(file.file_name().expect("a name"))).expect("a link");
        }
    }
    symlink(built("lib_sinew.so"), package.join("_sinew.abi3.so")).expect("a link");
    let paths = std::env::var_os("PYTHONPATH");
    let paths: Vec<OsString> = [Some(installed.path().into()), paths].into_iter().flatten().collect();
    let ran = python()
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=5", "tests"])
        .current_dir(&source)
        .env("PYTHONPATH", std::env::join_paths(paths).expect("paths"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("SINEW_BINARY", sinew())
        .output()
        .expect("python3 was there a moment ago");
    let said = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    println!("{said}");
}
