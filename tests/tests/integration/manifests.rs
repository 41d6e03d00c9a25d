//! What every manifest keeps to: who may know whom, which ARCHITECTURE.md says in lines `crate -> crate, room/; tests: crate`; and that
//! no tests are switched off.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use sinew_tests::checkout;
use toml::{Table, Value};

/// What a crate depends on, as folders of the workspace.
#[derive(Debug, Default, Clone)]
struct Needs {
    always: Vec<String>,
    /// For its tests, examples and benches alone.
    in_tests: Vec<String>,
}

/// What a line of ARCHITECTURE.md allows a crate.
#[derive(Debug)]
struct Line<'a> {
    folder: &'a str,
    always: Vec<&'a str>,
    in_tests: Vec<&'a str>,
}

impl Line<'_> {
    /// The line `folder -> names; tests: names`.
    fn read(line: &str) -> Line<'_> {
        let (folder, rest) = line.split_once("->").unwrap_or_else(|| panic!("ARCHITECTURE.md: no arrow in {line:?}"));
        let (always, in_tests) = rest.split_once("; tests:").unwrap_or((rest, ""));
        fn names(list: &str) -> Vec<&str> {
            list.split(',').map(str::trim).filter(|name| !matches!(*name, "" | "nothing")).collect()
        }
        Line { folder: folder.trim(), always: names(always), in_tests: names(in_tests) }
    }
}

/// Whether `name` means the crate in `folder`: it is that, or a room (`model/`) around it.
fn means(name: &str, folder: &str) -> bool {
    match name.strip_suffix('/') {
        Some(room) => folder == room || folder.starts_with(name),
        None => folder == name,
    }
}

/// What is wrong with these crates, or with the page, a sentence each.
fn complaints(page: &str, crates: &BTreeMap<String, Needs>) -> Vec<String> {
    let (_, block) = page.split_once("```rooms\n").expect("ARCHITECTURE.md has a block that begins with ```rooms");
    let (block, _) = block.split_once("```").expect("the block ends");
    let lines: Vec<Line> = block.lines().filter(|line| !line.trim().is_empty()).map(Line::read).collect();
    let mut wrong = Vec::new();

    for folder in crates.keys().filter(|folder| !lines.iter().any(|line| line.folder == folder.as_str())) {
        wrong.push(format!("ARCHITECTURE.md has no line that says what {folder} may depend on."));
    }
    for (i, line) in lines.iter().enumerate() {
        let Line { folder, always, in_tests } = line;
        let Some(needs) = crates.get(*folder) else {
            wrong.push(format!("ARCHITECTURE.md has a line for {folder}, where there is no crate."));
            continue;
        };
        let is_above = |name: &str| lines[..i].iter().any(|above| means(name, above.folder));
        for name in always.iter().filter(|name| !is_above(name)) {
            wrong.push(format!("ARCHITECTURE.md lets {folder} depend on {name}, which is on no line above it."));
        }
        for name in in_tests.iter().filter(|name| !crates.keys().any(|folder| means(name, folder))) {
            wrong
                .push(format!("ARCHITECTURE.md lets the tests of {folder} depend on {name}, where there is no crate."));
        }
        let allowed = if always.is_empty() { "nothing".into() } else { always.join(", ") };
        let may = |need: &str| always.iter().any(|name| means(name, need)) && is_above(need);
        for need in needs.always.iter().filter(|need| !may(need)) {
            wrong.push(format!(
                "{folder} depends on {need}, but ARCHITECTURE.md (\"Who may know whom\") allows it {allowed}: either it does \
                 not need {need}, or that page is to say so and why."
            ));
        }
        for need in needs.in_tests.iter().filter(|need| !may(need) && !in_tests.iter().any(|name| means(name, need))) {
            wrong.push(format!(
                "the tests of {folder} depend on {need}, but ARCHITECTURE.md (\"Who may know whom\") allows them {allowed} \
                 and for themselves {}.",
                if in_tests.is_empty() { "nothing".into() } else { in_tests.join(", ") }
            ));
        }
    }
    wrong
}

fn manifest(folder: &str) -> Table {
    let path = checkout().join(folder).join("Cargo.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The tables of this kind of dependencies, for every target.
fn dependencies<'a>(manifest: &'a Table, kind: &'a str) -> impl Iterator<Item = (&'a String, &'a Value)> {
    let targets = manifest.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let tables = targets.filter_map(Value::as_table).chain([manifest]);
    tables.filter_map(move |table| table.get(kind)?.as_table()).flatten()
}

/// The crates of the workspace by their folders, with what they depend on.
fn workspace() -> BTreeMap<String, Needs> {
    let root = manifest("");
    let members = root["workspace"]["members"].as_array().expect("a list");
    let manifests: Vec<(&str, Table)> = members
        .iter()
        .map(|member| member.as_str().expect("a folder"))
        .map(|folder| (folder, manifest(folder)))
        .collect();
    let by_name: BTreeMap<&str, &str> =
        manifests.iter().map(|(folder, table)| (table["package"]["name"].as_str().expect("a name"), *folder)).collect();
    let needs = |manifest: &Table, kinds: &[&str]| -> Vec<String> {
        let all = kinds.iter().flat_map(|kind| dependencies(manifest, kind));
        let names = all.map(|(key, value)| value.get("package").and_then(Value::as_str).unwrap_or(key));
        names.filter_map(|name| by_name.get(name)).map(|folder| folder.to_string()).collect()
    };
    let crates = manifests.iter().map(|(folder, manifest)| {
        let always = needs(manifest, &["dependencies", "build-dependencies"]);
        (folder.to_string(), Needs { always, in_tests: needs(manifest, &["dev-dependencies"]) })
    });
    crates.collect()
}

#[test]
fn no_crate_knows_a_room_that_the_architecture_does_not_allow() {
    let page = fs::read_to_string(checkout().join("ARCHITECTURE.md")).expect("it is in the checkout");
    let wrong = complaints(&page, &workspace());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The room a crate is in; the contract of backends is below the rooms that are on both sides of it.
fn room(folder: &str) -> &str {
    if folder == "backends/contract" { folder } else { folder.split('/').next().unwrap_or(folder) }
}

/// The rooms and what each is built on, as a Mermaid flowchart without the arrows that follow from others.
fn picture(crates: &BTreeMap<String, Needs>) -> String {
    let mut built_on: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (folder, needs) in crates {
        let below = needs.always.iter().map(|need| room(need)).filter(|below| *below != room(folder));
        built_on.entry(room(folder)).or_default().extend(below);
    }
    fn reaches(from: &str, to: &str, built_on: &BTreeMap<&str, BTreeSet<&str>>) -> bool {
        built_on[from].iter().any(|below| *below == to || reaches(below, to, built_on))
    }
    let mut out = "```mermaid\nflowchart TD\n".to_string();
    for (above, below) in &built_on {
        writeln!(out, "    {}[\"{above}/\"]", above.replace('/', "_")).unwrap();
        for to in below {
            if !below.iter().any(|other| other != to && reaches(other, to, &built_on)) {
                writeln!(out, "    {} --> {}", above.replace('/', "_"), to.replace('/', "_")).unwrap();
            }
        }
    }
    out + "```\n"
}

#[test]
fn the_picture_is_that_of_the_manifests() {
    let path = checkout().join("ARCHITECTURE.md");
    let page = fs::read_to_string(&path).expect("it is in the checkout");
    let (before, rest) = page.split_once("<!-- picture -->\n").expect("the picture's place");
    let (shown, after) = rest.split_once("<!-- /picture -->").expect("its end");
    let drawn = picture(&workspace());
    if std::env::var_os("SINEW_BLESS").is_some() {
        // whole at once: other tests read the page meanwhile
        let beside = path.with_extension("blessed");
        fs::write(&beside, format!("{before}<!-- picture -->\n{drawn}<!-- /picture -->{after}"))
            .expect("a writable folder");
        fs::rename(beside, &path).expect("a writable page");
    } else {
        assert_eq!(shown, drawn, "ARCHITECTURE.md shows another picture; SINEW_BLESS=1 draws it anew");
    }
}

/// The sources in a folder and in those below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    paths.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

/// `test = false` spares a program or library without tests an empty harness. One that gets its first test has to be built with it.
#[test]
fn what_is_not_tested_has_no_tests() {
    let is_off = |target: &Value| target.get("test").and_then(Value::as_bool) == Some(false);
    for folder in workspace().keys() {
        let (manifest, folder) = (manifest(folder), checkout().join(folder));
        let mut untested = Vec::new();
        if manifest.get("lib").is_some_and(is_off) {
            untested.extend(sources(&folder.join("src")));
        }
        let programs = manifest.get("bin").and_then(Value::as_array).into_iter().flatten();
        for program in programs.filter(|program| is_off(program)) {
            untested.push(folder.join(program["path"].as_str().expect("a path")));
            assert!(
                folder.join("src/lib.rs").is_file(),
                "{}: a program alone has its tests in itself",
                folder.display()
            );
        }
        for path in untested {
            let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            let has_tests = ["#[test]", "proptest!"].iter().any(|mark| text.contains(mark));
            assert!(!has_tests, "{} has tests that never run: its target says `test = false`", path.display());
        }
    }
}

#[test]
fn each_kind_of_mistake_is_told() {
    let page = "# Page\n```rooms\na -> nothing\nroom/b -> a; tests: c\n\nc -> room/\n```\n";
    let needs = |always: &[&str], in_tests: &[&str]| Needs {
        always: always.iter().map(|name| name.to_string()).collect(),
        in_tests: in_tests.iter().map(|name| name.to_string()).collect(),
    };
    let good = BTreeMap::from([
        ("a".to_string(), needs(&[], &[])),
        ("room/b".to_string(), needs(&["a"], &["c"])),
        ("c".to_string(), needs(&["room/b"], &[])),
    ]);
    assert_eq!(complaints(page, &good), [""; 0]);
    let told = |page: &str, folder: &str, now: Option<Needs>, words: &str| {
        let mut crates = good.clone();
        match now {
            Some(needs) => drop(crates.insert(folder.into(), needs)),
            None => drop(crates.remove(folder)),
        }
        let wrong = complaints(page, &crates);
        assert!(wrong.iter().any(|sentence| sentence.contains(words)), "{words:?} is not said in {wrong:#?}");
    };
    told(page, "c", Some(needs(&["a"], &[])), "c depends on a, but");
    told(page, "a", Some(needs(&["room/b"], &[])), "allows it nothing");
    told(page, "c", Some(needs(&[], &["a"])), "the tests of c depend on a, but");
    told(page, "d", Some(needs(&[], &[])), "no line that says what d may depend on");
    told(page, "c", None, "a line for c, where there is no crate");
    let upward = page.replace("a -> nothing", "a -> c");
    told(&upward, "d", Some(needs(&[], &[])), "lets a depend on c, which is on no line above it");
    let astray = page.replace("tests: c", "tests: e");
    told(&astray, "d", Some(needs(&[], &[])), "lets the tests of room/b depend on e, where there is no crate");
}
