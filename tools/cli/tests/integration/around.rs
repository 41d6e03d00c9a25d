//! `sinew check`, `schema`, `completions`, `man`: what stands around a rig file and a shell.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::support::Scratch;

const RIG: &str = "[rig]\nname = \"bench\"\n[[channel]]\nname = \"left\"\n\
                   wire = { diameter_mm = 0.125, length_mm = 160.0 }\n\
                   drive = { supply_v = 6.5, shunt_ohm = 0.1 }\nload = { mass_kg = 0.2 }\n";

#[test]
fn a_rig_file_is_told_what_it_comes_to_or_all_that_is_wrong() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    let said = scratch.sinew(["check", "rig.toml"]).done();
    assert!(said.starts_with("rig.toml: right. Rig bench: 1 wire at") && said.contains("\nleft "), "{said}");
    let json: Value = serde_json::from_str(&scratch.sinew(["check", "rig.toml", "--json"]).done()).unwrap();
    assert_eq!((&json["schema"], &json["channel"][0]["name"]), (&"sinew.check/1".into(), &"left".into()));
    assert!(json["channel"][0]["stroke_mm"].as_f64().is_some_and(|stroke| (3.0..9.0).contains(&stroke)), "{json}");
    scratch.file("bad.toml", RIG.replace("diameter_mm", "diametre_mm").replace("0.2", "-1"));
    scratch.sinew(["check", "bad.toml"]).refused(&[
        "bad.toml:5",
        "diameter_mm?",
        "bad.toml:7",
        "mass_kg",
        "docs/rig.md",
    ]);
    scratch.sinew(["check", "nowhere.toml"]).refused(&["nowhere.toml"]);
}

/// Checks files by the schema as an editor would, with an independent reader of both.
const VALIDATE: &str = r#"
import json, sys, tomllib
import jsonschema
schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
for path in sys.argv[2:]:
    for error in validator.iter_errors(tomllib.load(open(path, "rb"))):
        print(path, list(error.absolute_path), error.message)
"#;

#[test]
fn the_schema_takes_what_the_reader_takes_and_finds_slips() {
    let scratch = Scratch::new();
    scratch.file("schema.json", scratch.sinew(["schema"]).done());
    let has_them = Command::new("python3").args(["-c", "import jsonschema, tomllib"]).output();
    if !has_them.is_ok_and(|ran| ran.status.success()) {
        eprintln!("skipped: python3 from 3.11 on with jsonschema is needed");
        return;
    }
    let validate = |files: &[&Path]| {
        let mut python = Command::new("python3");
        python.args(["-c", VALIDATE]).arg(scratch.path("schema.json")).args(files);
        let ran = python.output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        String::from_utf8_lossy(&ran.stdout).into_owned()
    };
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let rigs: Vec<_> = std::fs::read_dir(&examples)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .collect();
    assert!(rigs.len() >= 3);
    let rich = RIG.to_string()
        + "[channel.effects.\"mechanical.friction\"]\ncoulomb_n = 0.1\n[channel.effects.\"own.mine\"]\nany = 1\n\
           [channel.priors]\nconvection_w_per_m2_k = \"10 %\"\n[recording.columns]\nduty = { column = \"PWM\", scale = 0.01 }\n\
           [[simulation.fault]]\nchannel = \"left\"\nkind = \"open_wire\"\nstart_s = 1.0\n";
    scratch.file("rich.toml", &rich);
    let rich = scratch.path("rich.toml");
    let good: Vec<&Path> = rigs.iter().map(|path| path.as_path()).chain([rich.as_path()]).collect();
    assert_eq!(validate(&good), "");
    for (slip, right, words) in [
        ("diametre_mm = 0.125", "diameter_mm = 0.125", "diametre_mm"),
        ("length_mm = -160.0", "length_mm = 160.0", "-160.0"),
        ("supply_v = \"6.5\"", "supply_v = 6.5", "not of type 'number'"),
        ("[[chanel]]", "[[channel]]", "chanel"),
    ] {
        scratch.file("slip.toml", RIG.replace(right, slip));
        let found = validate(&[&scratch.path("slip.toml")]);
        assert!(found.contains(words), "{slip}: {found}");
        scratch.sinew(["check", "slip.toml"]).refused(&["slip.toml"]);
    }
}

#[test]
fn a_shell_completes_every_command_and_each_has_its_page() {
    let scratch = Scratch::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = scratch.sinew(["completions", shell]).done();
        assert!(script.contains("diagnose") && script.contains("hold"), "{shell}: {script}");
    }
    // A shell of the kind that is there completes by it.
    scratch.file("sinew.bash", scratch.sinew(["completions", "bash"]).done());
    let program =
        "source sinew.bash; COMP_WORDS=(sinew dia); COMP_CWORD=1; _sinew sinew dia sinew; echo \"${COMPREPLY[@]}\"";
    let ran = Command::new("bash").args(["-c", program]).current_dir(scratch.path(".")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&ran.stdout).trim(), "diagnose", "{}", String::from_utf8_lossy(&ran.stderr));

    scratch.sinew(["man", "--out", "man"]).done();
    let page = std::fs::read_to_string(scratch.path("man/sinew-diagnose.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("holdout"), "{page}");
    // every command that does something has its page, with an example
    let pages: Vec<String> = std::fs::read_dir(scratch.path("man"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(pages.len() > 35, "{pages:?}");
    let mut without = Vec::new();
    for page in &pages {
        let words: Vec<&str> = page.trim_end_matches(".1").split('-').skip(1).collect();
        let is_a_group = pages.iter().any(|other| other.starts_with(&format!("{}-", page.trim_end_matches(".1"))));
        let text = std::fs::read_to_string(scratch.path("man").join(page)).unwrap();
        if !is_a_group && !text.contains("Example") {
            without.push(words.join(" "));
        }
    }
    assert!(without.is_empty(), "no example of: {without:?}");
    let single = scratch.sinew(["man", "diagnose"]).done();
    assert_eq!(single, page);
    scratch.sinew(["man", "walk"]).refused(&["walk", "sinew --help"]);
    let first = std::fs::read_to_string(scratch.path("man/sinew.1")).unwrap();
    assert!(first.contains("sinew\\-run") || first.contains("sinew-run"), "{first}");
    scratch.file("file", "mine");
    let failed = scratch.sinew(["man", "--out", "file/man"]);
    assert!(failed.code() == 1 && failed.stderr().contains("file/man"), "{}", failed.stderr());
}
