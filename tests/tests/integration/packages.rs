//! What a release is made of: the packages' lists of files, the texts they install, and the manifests of what goes to crates.io hold
//! together. Nothing is built here; `release/make` does that.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use sinew_tests::checkout;
use sinew_tests::page::blocks;
use toml::{Table, Value};

/// The crates that are packages for Debian, by their folders.
const PACKAGED: [&str; 3] = ["tools/cli", "bindings/python", "bindings/c"];

fn text(path: &str) -> String {
    fs::read_to_string(checkout().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn manifest(folder: &str) -> Table {
    text(&format!("{folder}/Cargo.toml")).parse().unwrap_or_else(|e| panic!("{folder}/Cargo.toml: {e}"))
}

fn root() -> Table {
    text("Cargo.toml").parse().expect("the manifest of the workspace")
}

fn word(value: &Value) -> &str {
    value.as_str().expect("a text")
}

/// The package of a crate: where each of its files comes from, and where it goes.
fn assets(folder: &str) -> Vec<(String, String)> {
    let manifest = manifest(folder);
    let list = manifest["package"]["metadata"]["deb"]["assets"].as_array().expect("a list").clone();
    list.iter().map(|asset| (word(&asset[0]).to_string(), word(&asset[1]).to_string())).collect()
}

#[test]
fn what_a_package_is_made_of_is_there() {
    let make = text("release/make");
    for folder in PACKAGED {
        let manifest = manifest(folder);
        let deb = &manifest["package"]["metadata"]["deb"];
        let licence = checkout().join(folder).join(word(&deb["license-file"][0]));
        assert!(licence.is_file(), "{folder}: there is no {}", licence.display());
        let glibc = make.lines().find_map(|line| line.strip_prefix("glibc=")).expect("it says for which");
        let asks = word(&deb["depends"]);
        assert!(
            asks.starts_with(&format!("libc6 (>= {glibc})")),
            "{folder}: built for glibc {glibc}, but asks for {asks}"
        );
        for (from, to) in assets(folder) {
            assert!(!to.starts_with('/'), "{folder}: {to} begins with a slash");
            if let Some(staged) = from.strip_prefix("target/release/packaged/") {
                // what release/make writes: the folder itself, or that of the crate
                let first = staged.split('/').next().expect("a name");
                assert!(make.contains(&format!("$staged/{first}")), "release/make does not write {from} of {folder}");
            } else if let Some(program) = from.strip_prefix("target/release/") {
                let programs = manifest["bin"].as_array().expect("a list");
                assert!(programs.iter().any(|of| word(&of["name"]) == program), "{folder} has no program {program}");
            } else {
                let place = checkout().join(folder).join(from.trim_end_matches("/*").trim_end_matches("/**"));
                let is_there = if from.contains('*') {
                    fs::read_dir(&place).is_ok_and(|mut entries| entries.next().is_some())
                } else {
                    place.is_file()
                };
                assert!(is_there, "{folder}: there is no {from}");
            }
        }
    }
}

/// A file below `/etc` that is not said to be one is overwritten by every upgrade, whatever its owner wrote into it.
#[test]
fn an_upgrade_asks_before_it_overwrites_what_is_below_etc() {
    for folder in PACKAGED {
        let deb = manifest(folder)["package"]["metadata"]["deb"].clone();
        let said: BTreeSet<String> = deb
            .get("conf-files")
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
            .map(|file| word(file).to_string())
            .collect();
        let there: BTreeSet<String> = assets(folder)
            .into_iter()
            .filter(|(_, to)| to.starts_with("etc/"))
            .map(|(_, to)| format!("/{to}"))
            .collect();
        assert_eq!(said, there, "{folder}: conf-files, and what goes below etc/");
    }
}

/// The names behind a mark, each to its end.
fn names_after<'a>(text: &'a str, mark: &str) -> Vec<&'a str> {
    let rests = text.match_indices(mark).map(|(at, _)| &text[at + mark.len()..]);
    rests.filter_map(|rest| rest.split(['"', ' ', '\n']).find(|name| !name.is_empty())).collect()
}

#[test]
fn every_group_that_is_named_is_made_and_explained() {
    let sysusers = text("release/sinew.sysusers");
    let made: BTreeSet<&str> = sysusers
        .lines()
        .filter(|line| line.starts_with("g ") || line.starts_with("u "))
        .map(|line| line.split_whitespace().nth(1).expect("a name"))
        .collect();
    assert!(made.len() >= 5, "{made:?}");
    let (rules, limits, unit) =
        (text("release/70-sinew.rules"), text("release/sinew.limits"), text("examples/systemd/sinew@.service"));
    let mut named = names_after(&rules, "GROUP=\"");
    named.extend(names_after(&rules, "chgrp -R "));
    named.extend(names_after(&limits, "\n@"));
    named.extend(names_after(&unit, "\nUser="));
    let groups = unit.lines().find_map(|line| line.strip_prefix("SupplementaryGroups=")).expect("it has some");
    named.extend(groups.split_whitespace());
    assert!(named.len() >= 12, "{named:?}");
    for name in named.iter().filter(|name| **name != "dialout") {
        assert!(made.contains(name), "release/sinew.sysusers does not make {name}");
    }
    let page = text("docs/install.md");
    for name in &made {
        assert!(page.contains(&format!("`{name}`")), "docs/install.md does not say what {name} is for");
        assert!(named.contains(name), "{name} is made, and nothing uses it");
    }
    // SCHED_FIFO 98 is the guard's, and the most a rig file may ask for
    assert!(limits.contains("rtprio 98"), "{limits}");
}

#[test]
fn the_page_shows_the_rules_as_they_are() {
    let rules = text("release/70-sinew.rules");
    let page = text("docs/linux-backend.md");
    assert!(blocks(&page).iter().any(|block| block.text == rules), "docs/linux-backend.md shows other rules:\n{rules}");
    if let Ok(ran) = Command::new("udevadm").arg("verify").arg(checkout().join("release/70-sinew.rules")).output()
        && !String::from_utf8_lossy(&ran.stderr).contains("nknown command")
    {
        // groups that this machine lacks are no fault of the rules
        let said = String::from_utf8_lossy(&ran.stdout) + String::from_utf8_lossy(&ran.stderr);
        let faults: Vec<&str> =
            said.lines().filter(|line| line.contains("rules:") && !line.contains("nknown group")).collect();
        assert!(faults.is_empty(), "{said}");
    }
}

#[test]
fn shells_can_read_the_scripts() {
    let scripts = ["make", "debian/postinst", "debian/postrm", "debian/python/postinst", "debian/python/prerm"];
    for script in scripts {
        let path = checkout().join("release").join(script);
        let head = text(&format!("release/{script}"));
        let shell = if head.starts_with("#!/bin/sh\n") { "sh" } else { "bash" };
        let ran = Command::new(shell).arg("-n").arg(&path).output().expect("there is a shell");
        assert!(ran.status.success(), "{script}: {}", String::from_utf8_lossy(&ran.stderr));
    }
    let refused = Command::new(checkout().join("release/make")).output().expect("it may be run");
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("release/make FOLDER"));
}

#[test]
fn there_is_one_version() {
    let root = root();
    let version = word(&root["workspace"]["package"]["version"]).to_string();
    for (name, found) in root["workspace"]["dependencies"].as_table().expect("a table") {
        if found.get("path").is_some() {
            let asked = found.get("version").map(word);
            assert_eq!(
                asked,
                Some(version.as_str()),
                "Cargo.toml: {name} is of the workspace, and crates.io needs its version"
            );
        }
    }
    assert!(
        text("CITATION.cff").contains(&format!("\nversion: {version}\n")),
        "CITATION.cff is of another version than {version}"
    );
    assert!(
        text("docs/install.md").contains(&format!("sinew_{version}-1_")),
        "docs/install.md names packages of another version"
    );
}

/// What crates.io refuses, without asking it: a crate it would not have, or one without a word about itself.
#[test]
fn what_is_published_needs_nothing_that_is_not() {
    let root = root();
    let members = root["workspace"]["members"].as_array().expect("a list").clone();
    let manifests: Vec<Table> = members.iter().map(|folder| manifest(word(folder))).collect();
    let is_published = |table: &Table| table["package"].get("publish").and_then(Value::as_bool) != Some(false);
    let unpublished: BTreeSet<&str> =
        manifests.iter().filter(|table| !is_published(table)).map(|table| word(&table["package"]["name"])).collect();
    assert!(unpublished.contains("sinew-tests") && unpublished.len() < manifests.len() / 2, "{unpublished:?}");
    for table in manifests.iter().filter(|table| is_published(table)) {
        let name = word(&table["package"]["name"]);
        assert!(table["package"].get("description").is_some(), "{name} has no description");
        for kind in ["dependencies", "build-dependencies", "dev-dependencies"] {
            for needed in table.get(kind).and_then(Value::as_table).into_iter().flatten().map(|(name, _)| name) {
                assert!(!unpublished.contains(needed.as_str()), "{name} needs {needed}, which is not published");
            }
        }
    }
    // a file from outside of its crate is not in what crates.io has of it
    for folder in members.iter().map(word).filter(|folder| !folder.starts_with("tests")) {
        outside(&checkout().join(folder).join("src"), 1);
    }
}

/// Fails where a source takes in a file from above the folder of its crate, `depth` folders up.
fn outside(folder: &Path, depth: usize) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            outside(&path, depth + 1);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let source = fs::read_to_string(&path).expect("a readable file");
            let above = "../".repeat(depth + 1);
            for mark in ["include_str!(\"", "include_bytes!(\""] {
                let found = format!("{mark}{above}");
                assert!(!source.contains(&found), "{} takes in a file from outside of its crate", path.display());
            }
        }
    }
}
