//! What `sinew --version` says beside the number: the commit a release was built from, its date, for which machine and with which features. A development build says that it is one,
//! and is not compiled anew for every commit.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // what of the half that drives is there: all of it is Linux's
    println!("cargo::rustc-check-cfg=cfg(driver, network, thesis)");
    for of_linux in ["driver", "network", "thesis"].into_iter().filter(|feature| has(feature)) {
        println!("cargo::rustc-cfg={of_linux}");
    }
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let from = if is_release { of_release() } else { "development build".into() };
    println!("cargo::rustc-env=SINEW_BUILT_FROM={from}");
    println!("cargo::rustc-env=SINEW_BUILT_FOR={}", std::env::var("TARGET").expect("cargo tells it"));
    println!("cargo::rustc-env=SINEW_FEATURES={}", features());
}

/// The features that may be left out, and whether each is for Linux alone.
const FEATURES: [(&str, bool); 5] =
    [("driver", true), ("formats", false), ("network", true), ("png", false), ("thesis", true)];

/// Whether it is built with a feature.
fn has(feature: &str) -> bool {
    let is_linux = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux");
    let of_linux = FEATURES.contains(&(feature, true));
    std::env::var(format!("CARGO_FEATURE_{}", feature.to_uppercase())).is_ok() && (is_linux || !of_linux)
}

/// Those it is built with, and those it is built without.
fn features() -> String {
    let (there, left_out): (Vec<&str>, Vec<&str>) =
        FEATURES.map(|(name, _)| name).into_iter().partition(|name| has(name));
    let list = |names: Vec<&str>| if names.is_empty() { "none".into() } else { names.join(", ") };
    format!("{}; left out: {}", list(there), list(left_out))
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
