//! What `sinew --version` says beside the number: the commit a release was built from, its date, for which machine and with which features. A development build says that it is one,
//! and is not compiled anew for every commit.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // the half of the program that drives, which is Linux's
    println!("cargo::rustc-check-cfg=cfg(driver)");
    if drives() {
        println!("cargo::rustc-cfg=driver");
    }
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let from = if is_release { of_release() } else { "development build".into() };
    println!("cargo::rustc-env=SINEW_BUILT_FROM={from}");
    println!("cargo::rustc-env=SINEW_BUILT_FOR={}", std::env::var("TARGET").expect("cargo tells it"));
    println!("cargo::rustc-env=SINEW_FEATURES={}", features());
}

fn drives() -> bool {
    let is = |name, value| std::env::var(name).is_ok_and(|found| found == value);
    is("CARGO_CFG_TARGET_OS", "linux") && std::env::var("CARGO_FEATURE_DRIVER").is_ok()
}

/// Those it is built with, of those that may be left out.
fn features() -> &'static str {
    match (drives(), std::env::var("CARGO_FEATURE_DRIVER").is_ok()) {
        (true, _) => "driver; none is left out",
        (false, true) => "none; driver is for Linux only",
        (false, false) => "none; driver is left out",
    }
}

/// The commit and its date; where there is no repository (a source archive), that it is not known.
fn of_release() -> String {
    // a commit, a checkout and a reset all write this file
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    let commit = git(&["log", "-1", "--format=%h, %cs"]).unwrap_or_else(|| "commit unknown".into());
    let is_changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| !changes.is_empty());
    if is_changed { commit + ", with changes" } else { commit }
}

fn git(words: &[&str]) -> Option<String> {
    let said = Command::new("git").args(words).output().ok().filter(|said| said.status.success())?;
    Some(String::from_utf8(said.stdout).ok()?.trim().to_owned())
}
