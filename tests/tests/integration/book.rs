//! The book (`docs/SUMMARY.md`): the pages that lead a newcomer are followed to the letter, every block of them, the README command by command, and no
//! link leads nowhere.
//!
//! What stands after a fence besides the language is not shown to readers, and says here how a reader takes the block:
//!
//! - `sh`: typed into the first terminal, or into that of `terminal=2`; to its end, which has to be a good one, or with `fails` a refusal.
//!   `stays`: it goes on until Ctrl-C is pressed in its terminal, at the latest at the end of the page. `look`: it is typed
//!   again until it shows what the page does. `installs`: it fetches and compiles; what it leaves is here already.
//! - `text`: what the commands before it show. Lines may be left out, `…` as a word of its own stands for any words, numbers agree to 10 % or to one in their last
//!   digit; with `varies` to nothing at all.
//! - `file=NAME`: saved under that name. `in=NAME`: an extract of that file.

use sinew_tests::page::{Block, anchors, blocks, links};
use sinew_tests::{Finished, PATIENCE, Process, checkout, sinew, wait_until};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use tempfile::TempDir;

use crate::python;

/// Whoever follows a page: in a folder with the project's examples, with `sinew` on the path and as its module in Python.
struct Reader {
    page: &'static str,
    folder: TempDir,
    /// Runtime folder and black boxes.
    own: TempDir,
    /// The package for Python, where the page uses it.
    package: Option<TempDir>,
    /// Where each terminal is.
    terminals: BTreeMap<String, PathBuf>,
    /// What goes on in which.
    staying: BTreeMap<String, Process>,
}

impl Reader {
    fn of(page: &'static str) -> Reader {
        Reader { package: Some(python::installed()), ..Reader::without_python(page) }
    }

    fn without_python(page: &'static str) -> Reader {
        let new = || tempfile::tempdir().expect("a temporary folder");
        let (folder, own) = (new(), new());
        symlink(checkout().join("examples"), folder.path().join("examples")).expect("a link");
        let (terminals, staying) = (BTreeMap::new(), BTreeMap::new());
        Reader { page, folder, own, package: None, terminals, staying }
    }

    /// Follows the page to its end.
    fn follow(mut self) {
        let text = fs::read_to_string(checkout().join(self.page)).expect("it is in the checkout");
        let blocks = blocks(&text);
        assert!(blocks.iter().any(|block| block.language == "sh"), "{} has nothing to follow", self.page);
        let mut rest = blocks.iter().peekable();
        while let Some(block) = rest.next() {
            let shown = rest.next_if(|next| block.language == "sh" && next.language == "text");
            if let Some(terminal @ ("2" | "3")) = block.value("terminal") {
                let word = if terminal == "2" { "second terminal" } else { "third terminal" };
                let before: Vec<&str> = text.lines().take(block.line).collect();
                assert!(before.join(" ").contains(word), "{}: a reader is not told of a {word}", self.place(block));
            }
            match (block.language.as_str(), block.value("file"), block.value("in")) {
                ("sh", None, None) => self.type_in(block, shown, &text),
                ("python" | "toml" | "csv", Some(name), None) => self.save(name, &block.text),
                ("python" | "toml" | "csv", None, Some(name)) => {
                    let there =
                        fs::read_to_string(self.terminal("1").join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
                    for line in block.text.lines().filter(|line| line.trim() != "…") {
                        assert!(there.contains(line), "{}: {name} has no {line:?}:\n{there}", self.place(block));
                    }
                }
                _ => panic!("{}: a block that nobody runs: {block:#?}", self.place(block)),
            }
        }
        for terminal in self.staying.keys().cloned().collect::<Vec<_>>() {
            self.leave(&terminal, &text);
        }
    }

    fn place(&self, block: &Block) -> String {
        format!("{}:{}", self.page, block.line)
    }

    fn terminal(&self, name: &str) -> PathBuf {
        self.terminals.get(name).cloned().unwrap_or_else(|| self.folder.path().into())
    }

    fn save(&self, name: &str, text: &str) {
        fs::write(self.terminal("1").join(name), text).expect("the folder is writable");
    }

    /// What runs in a terminal is ended as a page says: it is gone already, or Ctrl-C ends it, in order.
    fn leave(&mut self, terminal: &str, page: &str) {
        let Some(mut process) = self.staying.remove(terminal) else { return };
        if process.ended().is_none() {
            assert!(page.contains("Ctrl-C"), "{}: nobody says how what goes on in terminal {terminal} ends", self.page);
            process.signal(libc::SIGINT);
        }
        process.finish().expect(0);
    }

    fn command(&self, terminal: &str, script: &str) -> Command {
        let mut command = Command::new("bash");
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folder = sinew().parent().expect("it lies in a folder");
        let path = std::iter::once(folder.to_path_buf()).chain(std::env::split_paths(&path));
        command
            .args(["-e", "-c", script])
            .current_dir(self.terminal(terminal))
            .env("PATH", std::env::join_paths(path).expect("paths"))
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("MPLBACKEND", "agg")
            .env("NO_COLOR", "1")
            .env("SINEW_RUNTIME_DIR", self.own.path())
            .env("SINEW_STATE_DIR", self.own.path());
        if let Some(package) = &self.package {
            command.env("PYTHONPATH", python::import_path(&[package.path()]));
        }
        command
    }

    /// Types a block into its terminal, and sees that it shows what the page does.
    fn type_in(&mut self, block: &Block, shown: Option<&Block>, page: &str) {
        let place = self.place(block);
        let terminal = block.value("terminal").unwrap_or("1").to_owned();
        self.leave(&terminal, page);
        if block.is("installs") {
            assert!(shown.is_none(), "{place}: what it shows is not known");
            return eprintln!("{place}: fetches and compiles: not typed");
        }
        if block.is("stays") {
            assert_eq!(block.text.lines().count(), 1, "{place}: one command stays");
            let mut process = Process::start(&mut self.command(&terminal, &format!("exec 2>&1; exec {}", block.text)));
            wait_until(&format!("{place} to say something"), || {
                let said = process.stdout();
                if let Some(status) = process.ended() {
                    panic!("{place}: it ended with {status}: {said}");
                }
                shown.map_or(!said.is_empty(), |shown| lacks(&shown.text, &said, shown.is("varies")).is_none())
            });
            self.staying.insert(terminal, process);
            return;
        }
        let cwd = self.own.path().join("cwd");
        let script = format!("exec 2>&1\n{}\npwd > {}", block.text, cwd.display());
        let begun = Instant::now();
        loop {
            let ended: Finished = Process::start(&mut self.command(&terminal, &script)).finish();
            let shows = shown.map(|shown| lacks(&shown.text, &ended.stdout, shown.is("varies")));
            if block.is("look") && begun.elapsed() < PATIENCE && !matches!(shows, Some(None)) {
                continue;
            }
            assert_eq!(ended.code, Some(if block.is("fails") { 2 } else { 0 }), "{place}: {ended:#?}");
            if let Some(Some(line)) = shows {
                panic!("{place}: the page shows {line:?}, the program:\n{}", ended.stdout);
            }
            break;
        }
        if !block.is("fails") {
            self.terminals.insert(terminal, fs::read_to_string(cwd).expect("written").trim().into());
        }
    }
}

/// The first line of what is shown that is not in what was said, in this order.
fn lacks<'a>(shown: &'a str, said: &str, varies: bool) -> Option<&'a str> {
    let mut said = said.lines();
    shown.lines().filter(|line| !matches!(line.trim(), "" | "…")).find(|line| {
        let line = words(line);
        !said.any(|there| is_like(&line, &words(there), varies))
    })
}

/// A line in words, numbers apart from what stands before and behind them.
fn words(line: &str) -> Vec<&str> {
    let mut found = Vec::new();
    for mut word in line.split_whitespace() {
        while let Some(first) = word.chars().next() {
            let is_number = |letter: char| letter.is_ascii_digit() || letter == '.';
            let end = word.find(|letter| is_number(letter) != is_number(first)).unwrap_or(word.len());
            found.push(&word[..end]);
            word = &word[end..];
        }
    }
    found
}

fn is_like(shown: &[&str], said: &[&str], varies: bool) -> bool {
    match (shown, said) {
        ([], []) => true,
        (["…", rest @ ..], _) => (0..=said.len()).any(|from| is_like(rest, &said[from..], varies)),
        ([word, rest @ ..], [there, others @ ..]) => {
            (word == there || is_near(word, there, varies)) && is_like(rest, others, varies)
        }
        _ => false,
    }
}

fn is_near(shown: &str, said: &str, varies: bool) -> bool {
    let (Ok(a), Ok(b)) = (shown.parse::<f64>(), said.parse::<f64>()) else { return false };
    let digits = shown.split_once('.').map_or(0, |(_, behind)| behind.len());
    varies || (a - b).abs() <= f64::max(0.1 * a.abs(), 1.001 * 0.1_f64.powi(digits as i32))
}

#[test]
fn what_a_page_shows_is_told_from_what_it_does_not() {
    let said = "arm: made. Next:\n\nwire 35.8 % of 164.2mm, about 84 °C\nwritten: a.svg\n";
    assert_eq!(lacks("arm: made. …\n…\nwire 36.0 % of 164.0mm, about 80 °C", said, false), None);
    assert_eq!(lacks("wire … about 85 °C\nwritten: a.svg", said, false), None);
    for wrong in ["wire 40.0 % of …", "wire 36 %", "written: a.png", "made", "… °F"] {
        assert_eq!(lacks(wrong, said, false), Some(wrong));
    }
    assert_eq!(lacks("written: a.svg\narm: …", said, false), Some("arm: …"), "in this order");
    assert_eq!(lacks("wire 99 % of 1mm, about 1 °C", said, true), None, "whatever the numbers");
    assert_eq!(lacks("wire 99 K of 1mm, about 1 °C", said, true), Some("wire 99 K of 1mm, about 1 °C"));
}

#[test]
fn start_here_is_followed() {
    Reader::without_python("docs/book/start.md").follow();
}

/// Commands of the README that are not typed here, but only read by the program (it says its help behind them, or what is wrong with them), and why.
const ONLY_READ: [(&str, &str); 5] = [
    ("sinew tour", "three minutes of somebody's time; tour.rs takes it"),
    ("sinew conceal", "a minute with the diagnosis of it, which why_does_my_recording_differ follows"),
    ("sinew diagnose", "that diagnosis"),
    (
        "sinew test characterise",
        "some minutes of a simulated test machine; tools/cli/tests/integration/test_machine.rs runs it",
    ),
    ("sinew doctor", "what it finds is this machine's, and so is whether that is good; usage.rs runs it"),
];

/// The README, command by command as they stand there: whoever types them in this order, in two terminals, gets what is promised. What cargo does is
/// `.ci/run`'s.
#[test]
fn the_readme_is_followed() {
    let page = fs::read_to_string(checkout().join("README.md")).expect("it is in the checkout");
    let mut reader = Reader::without_python("README.md");
    let (mut typed, mut read) = (Vec::new(), BTreeSet::new());
    for block in blocks(&page) {
        assert_eq!(block.language, "sh", "{}: a block that nobody runs", reader.place(&block));
        for (at, text) in block.text.lines().enumerate().filter(|(_, text)| !text.starts_with("cargo ")) {
            let step = |words: &[&str], text: &str| Block {
                line: block.line + 1 + at,
                language: "sh".into(),
                words: words.iter().map(ToString::to_string).collect(),
                text: format!("{text}\n"),
            };
            let command = text.split(" #").next().unwrap_or(text).trim();
            if let Some((start, _)) = ONLY_READ.iter().find(|(start, _)| command.starts_with(start)) {
                reader.type_in(&step(&["terminal=2"], &format!("{command} --help")), None, &page);
                read.insert(*start);
                continue;
            }
            typed.push(command.split(' ').take(2).collect::<Vec<_>>().join(" "));
            let there = reader.terminal("1");
            match typed.last().map(String::as_str) {
                Some("sinew run") => {
                    reader.type_in(&step(&["stays"], text), None, &page);
                    wait_until("its wires to be measured", || {
                        let status = reader.command("1", "sinew status").output().expect("bash starts");
                        String::from_utf8_lossy(&status.stdout).contains(" program ")
                    });
                    reader.terminals.insert("2".into(), there);
                }
                Some("sinew monitor") => {
                    reader.terminals.insert("3".into(), there);
                    reader.type_in(&step(&["stays", "terminal=3"], text), None, &page);
                }
                _ if reader.staying.is_empty() => reader.type_in(&step(&[], text), None, &page),
                _ => reader.type_in(&step(&["terminal=2"], text), None, &page),
            }
        }
    }
    for word in ["new", "run", "monitor", "set", "record", "design"] {
        assert!(typed.contains(&format!("sinew {word}")), "nobody typed {word}: {typed:?}");
    }
    assert_eq!(read.len(), ONLY_READ.len(), "the README has no more of these: {read:?}");
    let drawn = reader.terminal("2").join("walk.html");
    assert!(fs::metadata(&drawn).is_ok_and(|file| file.len() > 1000), "{}", drawn.display());
    for terminal in ["3", "1"] {
        reader.leave(terminal, &page);
    }
}

/// It stays short enough for a screen, and says what nobody may miss.
#[test]
fn the_readme_stays_short() {
    let page = fs::read_to_string(checkout().join("README.md")).expect("it is in the checkout");
    assert!(page.lines().count() <= 60, "{} lines", page.lines().count());
    for line in page.lines().filter(|line| !line.contains("](")) {
        assert!(line.chars().count() <= 100, "{line}");
    }
    let pictures = page.lines().filter(|line| line.starts_with("![")).count();
    assert_eq!(pictures, 2, "the monitor, and what a diagnosis makes of a recording");
    let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("No hardware backend has been tested on real hardware yet"));
}

#[test]
fn a_wire_moves() {
    Reader::without_python("docs/book/a-wire-moves.md").follow();
}

#[test]
fn a_robot_of_your_own() {
    if !python::has(OsStr::new("python3"), "numpy, pandas, matplotlib") {
        return eprintln!("skipped");
    }
    Reader::of("docs/book/a-robot-of-your-own.md").follow();
}

#[test]
fn why_does_my_recording_differ() {
    Reader::without_python("docs/book/why-does-my-recording-differ.md").follow();
}

/// All pages below a folder, by their path from the checkout.
fn pages(below: &str) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    let mut folders = vec![checkout().join(below)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "md") {
                found.insert(path.strip_prefix(checkout()).expect("it lies in it").into());
            }
        }
    }
    found
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::ParentDir => drop(plain.pop()),
            std::path::Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

#[test]
fn every_page_has_its_place_in_the_book() {
    let summary = fs::read_to_string(checkout().join("docs/SUMMARY.md")).expect("the book has a table of contents");
    let listed: Vec<PathBuf> =
        links(&summary).into_iter().map(|(_, page)| plain(&Path::new("docs").join(page))).collect();
    let mut all = pages("docs");
    all.remove(Path::new("docs/SUMMARY.md"));
    assert_eq!(all, listed.iter().cloned().collect(), "docs/SUMMARY.md lists each page of docs/, and none that is not");
    assert_eq!(all.len(), listed.len(), "docs/SUMMARY.md lists a page twice");
}

#[test]
fn every_link_leads_somewhere() {
    let mut looked_at: BTreeSet<PathBuf> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(PathBuf::from).into();
    looked_at.extend(["docs", "examples", "bindings"].iter().flat_map(|folder| pages(folder)));
    let read = |page: &Path| fs::read_to_string(checkout().join(page)).expect("it is in the checkout");
    let mut wrong = Vec::new();
    for page in &looked_at {
        for (line, link) in links(&read(page)) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone(),
                file => plain(&page.parent().expect("it lies in a folder").join(file)),
            };
            let is_page = target.extension().is_some_and(|end| end == "md");
            if !checkout().join(&target).exists() {
                wrong.push(format!("{}:{line}: there is no {link}", page.display()));
            } else if !anchor.is_empty() && is_page && !anchors(&read(&target)).iter().any(|there| there == anchor) {
                wrong.push(format!("{}:{line}: {} has no heading #{anchor}", page.display(), target.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
