//! `sinew diagnose --bundle` and `sinew repeat`: one archive, made again elsewhere, and what is refused.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use sinew_tests::{Finished, checkout, entries, run};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// A bundle of the example, made from a folder that is gone afterwards.
struct Made {
    here: tempfile::TempDir,
    bundle: PathBuf,
}

impl Made {
    fn new() -> Made {
        let here = tempfile::tempdir().expect("a temporary folder");
        let elsewhere = tempfile::tempdir().expect("another one");
        for name in ["rig.toml", "recording.csv"] {
            fs::copy(checkout().join("examples/concealed/one").join(name), elsewhere.path().join(name))
                .expect("a copy");
        }
        let at = |name: &str| elsewhere.path().join(name);
        let bundle = here.path().join("one.zip");
        let (rig, recording, out) = (at("rig.toml"), at("recording.csv"), at("answer"));
        let words = [Path::new("diagnose"), &rig, &recording, Path::new("--out"), &out, Path::new("--bundle"), &bundle];
        let done = run(words).expect(0);
        assert!(done.stderr.contains("one.zip"), "{done:#?}");
        // Nothing overwrites it, and that is said before the work.
        run(words).refused(&["one.zip", "is there already"]);
        Made { here, bundle }
    }

    fn repeat(&self, bundle: &Path, out: &str) -> Finished {
        run([Path::new("repeat"), bundle, Path::new("--out"), &self.here.path().join(out)])
    }

    /// The bundle with one file changed, or left out.
    fn changed(&self, name: &str, change: impl Fn(String) -> Option<String>) -> PathBuf {
        let mut archive = ZipArchive::new(fs::File::open(&self.bundle).expect("the bundle")).expect("an archive");
        let path = self.here.path().join("changed.zip");
        let mut changed = ZipWriter::new(fs::File::create(&path).expect("a file"));
        for index in 0..archive.len() {
            let mut entry = archive.by_index(index).expect("an entry");
            let place = entry.name().expect("a name").into_owned();
            let mut text = String::new();
            entry.read_to_string(&mut text).expect("a text");
            let text = if place == name { change(text) } else { Some(text) };
            if let Some(text) = text {
                changed.start_file(place, SimpleFileOptions::default()).expect("an entry");
                changed.write_all(text.as_bytes()).expect("its text");
            }
        }
        changed.finish().expect("an archive");
        path
    }
}

#[test]
fn a_bundle_is_repeated_where_nothing_of_its_maker_is_left() {
    let made = Made::new();
    let done = made.repeat(&made.bundle, "again").expect(0);
    assert!(done.stdout.contains("The same answer as in the bundle, to the last digit"), "{done:#?}");
    let again = made.here.path().join("again");
    assert_eq!(entries(&again), ["diagnosis.json", "improved.toml", "report.html"]);
    made.repeat(&made.bundle, "again").refused(&["again", "is there already"]);

    // An answer that says something else is told as such, with exit code 1.
    let said = |text: String| Some(text.replace("\"verdict\": \"", "\"verdict\": \"not_"));
    let answer = made.changed("answer/diagnosis.json", said);
    made.repeat(&answer, "other").refused(&["answer/diagnosis.json", "is not as it was put in"]);
    let digest = |path: &Path, name: &str| {
        let mut archive = ZipArchive::new(fs::File::open(path).expect("the bundle")).expect("an archive");
        let mut bytes = Vec::new();
        archive.by_name(name).expect("an entry").read_to_end(&mut bytes).expect("bytes");
        Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    };
    let [old, new] = [&made.bundle, &answer].map(|path| digest(path, "answer/diagnosis.json"));
    fs::rename(&answer, &made.bundle).expect("in its place");
    let answer = made.changed("bundle.json", |text| Some(text.replace(&old, &new)));
    let differs = made.repeat(&answer, "differs").expect(1);
    assert!(
        differs.stderr.contains("another answer than in the bundle") && differs.stderr.contains("not_"),
        "{differs:#?}"
    );
}

#[test]
fn what_is_no_bundle_or_names_what_is_not_in_it_is_refused() {
    let made = Made::new();
    let none = made.here.path().join("none.zip");
    made.repeat(&none, "a").refused(&["none.zip", "cannot be read"]);
    fs::write(&none, "not an archive").expect("a file");
    made.repeat(&none, "a").refused(&["none.zip", "is no archive"]);
    let without = |_| None;
    made.repeat(&made.changed("bundle.json", without), "a").refused(&["has no bundle.json"]);
    made.repeat(&made.changed("inputs/recording.csv", without), "a").refused(&["inputs/recording.csv is missing"]);
    let dented = |text: String| Some(text.replacen('1', "2", 1));
    made.repeat(&made.changed("inputs/rig.toml", dented), "a").refused(&["inputs/rig.toml is not as it was put in"]);
    for (from, to, words) in [
        ("sinew.bundle/1", "sinew.bundle/9", "sinew.bundle/9"),
        // a command may name what is in the archive, and be a diagnosis
        ("\"inputs/recording.csv\",", "\"/etc/passwd\",", "/etc/passwd"),
        ("\"diagnose\"", "\"simulate\"", "its command"),
        ("--seed=", "--sown=", "--sown"),
    ] {
        let bundle = made.changed("bundle.json", |text| Some(text.replacen(from, to, 1)));
        made.repeat(&bundle, "a").refused(&["changed.zip", words, "sinew"]);
    }
    assert!(!made.here.path().join("a").exists(), "nothing is made of what is refused");
}
