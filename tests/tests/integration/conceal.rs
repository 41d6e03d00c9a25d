//! `sinew conceal`, `sinew diagnose` and `sinew reveal` one after the other, as whoever tries the diagnosis types them.

use std::fs;
use std::path::{Path, PathBuf};

use sinew_tests::{checkout, entries, run};

/// The folders of `examples/concealed`, and the seed each was made with.
const EXAMPLES: [(&str, &str); 1] = [("one", "1")];

fn text(path: &Path) -> String {
    path.to_str().expect("a temporary folder's name").to_string()
}

/// Something plain, made in `folder`: friction at ten times the noise.
fn friction(folder: &Path) -> String {
    let made = run(["conceal", &text(folder), "--effect", "mechanical.friction", "--level", "10", "--seed", "11"]);
    let made = made.expect(0);
    let seal = made.stdout.lines().find_map(|line| line.strip_prefix("seal ")).expect("a seal is printed");
    seal.to_string()
}

#[test]
fn what_is_hidden_is_found_and_opened() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let riddle = folder.path().join("riddle");
    let seal = friction(&riddle);
    assert_eq!(entries(&riddle), ["answer.sealed", "recording.csv", "rig.toml"]);
    for name in ["rig.toml", "recording.csv", "answer.sealed"] {
        let file = fs::read_to_string(riddle.join(name)).expect("a text file");
        assert!(!file.contains("friction"), "{name} gives it away");
    }
    // before a diagnosis it says what is hidden, and that nothing was found yet
    let early = run(["reveal", &text(&riddle)]).expect(0);
    assert!(early.stdout.contains("mechanical.friction") && early.stdout.contains("sinew diagnose"), "{early:#?}");

    let [rig, recording, answer] = ["rig.toml", "recording.csv", "answer"].map(|name| text(&riddle.join(name)));
    run(["diagnose", &rig, &recording, "--out", &answer]).expect(0);
    let opened = run(["reveal", &text(&riddle), "--seal", &seal[..12], "--json"]).expect(0);
    let said = opened.json();
    assert_eq!(said["right"], true, "{said:#}");
    assert_eq!(said["found"]["effects"][0]["id"], "mechanical.friction", "{said:#}");
    assert_eq!(said["changed"], serde_json::json!([]), "{said:#}");
    let truth = said["hidden"]["effects"]["mechanical.friction"]["coulomb_n"].as_f64().expect("its size");
    let found = said["found"]["effects"][0]["sizes"]["coulomb_n"][0].as_f64().expect("its size as found");
    assert!((found / truth - 1.0).abs() < 0.15, "{found} N for {truth} N");
    let opened = run(["reveal", &text(&riddle)]).expect(0);
    for word in ["Hidden: mechanical.friction", "Found:  physics_missing: mechanical.friction", "coulomb_n", "Right."] {
        assert!(opened.stdout.contains(word), "{word}: {opened:#?}");
    }
}

#[test]
fn an_envelope_that_was_changed_is_refused_and_files_that_were_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let riddle = folder.path().join("riddle");
    run(["conceal", &text(&riddle), "--nothing", "--seed", "3"]).expect(0);
    let sealed = fs::read_to_string(riddle.join("answer.sealed")).expect("an envelope");
    run(["reveal", &text(&riddle), "--seal", "0123abcd"]).refused(&["answer.sealed", "0123abcd"]);

    let recording = riddle.join("recording.csv");
    let mut longer = fs::read_to_string(&recording).expect("a recording");
    longer += "\n";
    fs::write(&recording, longer).expect("the folder is writable");
    let opened = run(["reveal", &text(&riddle)]).expect(0);
    assert!(opened.stderr.contains("recording.csv: is not as it was sealed"), "{opened:#?}");
    assert!(opened.stdout.contains("Hidden: nothing"), "{opened:#?}");

    // one letter of what is in it
    let place = sealed.len() - 20;
    let other = if sealed.as_bytes()[place] == b'A' { "B" } else { "A" };
    let changed = format!("{}{other}{}", &sealed[..place], &sealed[place + 1..]);
    fs::write(riddle.join("answer.sealed"), changed).expect("the folder is writable");
    run(["reveal", &text(&riddle)]).refused(&["answer.sealed", "was changed after it was sealed"]);
    fs::write(riddle.join("answer.sealed"), "friction\n").expect("the folder is writable");
    run(["reveal", &text(&riddle)]).refused(&["answer.sealed", "is no sealed answer"]);
    run(["reveal", &text(folder.path())]).refused(&["answer.sealed", "cannot be read"]);
}

#[test]
fn bad_wishes_are_refused_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let riddle = text(&folder.path().join("riddle"));
    run(["conceal", &riddle, "--effect", "mechanical.frction"]).refused(&["mechanical.frction", "mechanical.friction"]);
    run(["conceal", &riddle, "--effect", "kinetic.lag", "--effect", "kinetic.lag"]).refused(&["twice"]);
    run(["conceal", &riddle, "--effect", "kinetic.lag", "--effect", "cosine kinetics"])
        .refused(&["outside the catalogue"]);
    run(["conceal", &riddle, "--level", "300"]).refused(&["--level", "0.5 to 30"]);
    run(["conceal", &riddle, "--nothing", "--effect", "kinetic.lag"]).refused(&["--nothing", "--effect"]);
    run(["conceal"]).refused(&["<FOLDER>"]);
    assert!(entries(folder.path()).is_empty(), "{:?}", entries(folder.path()));
    run(["conceal", &text(folder.path()), "--nothing"]).refused(&["is there already"]);
    assert!(entries(folder.path()).is_empty());
    let list = run(["conceal", "--list"]).expect(0).stdout;
    assert!(list.contains("mechanical.friction") && list.contains("backlash of the encoder"), "{list}");
}

/// The examples are what the command makes: the same rig file and secret, and the same recording but for a last digit now and then, which another
/// processor's exponentials may turn.
#[test]
fn the_examples_are_what_the_command_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut bytes = 0;
    for (name, seed) in EXAMPLES {
        let example: PathBuf = checkout().join("examples/concealed").join(name);
        let made = folder.path().join(name);
        run(["conceal", &text(&made), "--seed", seed]).expect(0);
        assert_eq!(entries(&example), entries(&made), "{name}");
        for file in entries(&made) {
            let [there, now] = [&example, &made].map(|folder| fs::read_to_string(folder.join(&file)).expect("a text"));
            bytes += there.len();
            if file.ends_with(".csv") {
                assert_eq!(there.lines().count(), now.lines().count(), "{name}/{file}");
                let differ = there.lines().zip(now.lines()).filter(|(there, now)| !is_close(there, now)).count();
                assert_eq!(differ, 0, "{name}/{file} is not what `sinew conceal {name} --seed {seed}` makes");
            }
        }
        let [there, now] = [&example, &made].map(|folder| run(["reveal", &text(folder), "--json"]).expect(0).json());
        assert_eq!(there["changed"], serde_json::json!([]), "the example is as it was sealed");
        assert_eq!(there["hidden"]["kind"], now["hidden"]["kind"]);
    }
    assert!(bytes < 300_000, "{bytes} bytes are too many for examples");
}

/// Whether two rows agree, in all words and in numbers to a thousandth.
fn is_close(there: &str, now: &str) -> bool {
    let fields = |row: &str| row.split(',').map(str::to_owned).collect::<Vec<_>>();
    let (there, now) = (fields(there), fields(now));
    there.len() == now.len()
        && there.iter().zip(&now).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= 1e-3 * a.abs().max(b.abs()).max(1e-2),
            _ => a == b,
        })
}
