//! Mistakes that people make, each made, with what they are told: `tests/mistakes.txt` has the texts word for word, so that whoever changes one
//! reads it as they will. Every text names the place and has a remedy (`hint:`), the exit code is 2 for what the user can mend in his input and 1
//! for what the machine lacks, and stdout stays empty.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-tests --test integration mistakes::` writes the file anew.

use sinew_tests::{Driver, Process, Rig, checkout, sinew};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A rig file of one wire, as `CSV` below was recorded from.
const RIG: &str = "[rig]\nname = \"bench\"\nrate_hz = 100.0\n\n[[channel]]\nname = \"wire\"\n\
                   wire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\n\
                   drive = { supply_v = 6.5, shunt_ohm = 0.1 }\nload = { mass_kg = 0.08 }\n";

/// What a recording of that rig may look like, in short.
fn csv(separator: char, comma: char, factor: f64) -> String {
    let mut text = ["time_s", "duty", "position_m"].join(&separator.to_string()) + "\n";
    for row in 0..200 {
        let time_s = f64::from(row) * 0.05;
        let duty = if (row / 40) % 2 == 0 { 0.02 } else { 0.3 };
        let position = factor * 0.004 * (1.0 + 0.01 * f64::from(row % 7));
        let cells = [time_s, duty, position].map(|value| format!("{value:.6}").replace('.', &comma.to_string()));
        text += &(cells.join(&separator.to_string()) + "\n");
    }
    text
}

/// The files of the bench on which the mistakes are made.
fn lay_out(folder: &Path) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a writable folder");
    let changed = |from: &str, to: &str| {
        assert!(RIG.contains(from), "{from}");
        RIG.replace(from, to)
    };
    write("rig.toml", RIG);
    write("empty.toml", "");
    write("word.toml", "# my first rig\nrig bench\n");
    fs::write(folder.join("latin1.toml"), b"[rig]\nname = \"b\xfcro\"\n").expect("a writable folder");
    write("typo.toml", &changed("supply_v", "suply_v"));
    write("quoted.toml", &changed("length_mm = 160.0", "length_mm = \"160 mm\""));
    write("microns.toml", &changed("diameter_mm = 0.125", "diameter_mm = 125.0"));
    write("metres.toml", &changed("length_mm = 160.0", "length_mm = 0.16"));
    write("taps.toml", &changed("ls_mm = 150.0", "ls_mm = 165.0"));
    write("kind.toml", &changed("diameter_mm = 0.125", "kind = \"flexinol-125\""));
    write("no-wire.toml", &changed("wire = { diameter_mm = 0.125, length_mm = 160.0 }\n", ""));
    write("no-supply.toml", &changed("supply_v = 6.5, ", ""));
    write("space.toml", &changed("name = \"bench\"", "name = \"my bench\""));
    write("law.toml", &(RIG.to_owned() + "control = { algorithm = \"pi\" }\n"));
    write("twice.toml", &(RIG.to_owned() + &RIG[RIG.find("[[channel]]").expect("one")..]));
    write("slow.toml", &changed("rate_hz = 100.0", "rate_hz = 5.0"));
    write("serial.toml", &(RIG.to_owned() + "\n[backend]\nkind = \"serial\"\nserial.port = \"/dev/ttyUSB7\"\n"));
    write("no-port.toml", &(RIG.to_owned() + "\n[backend]\nkind = \"serial\"\n"));
    write("linux.toml", &(RIG.to_owned() + "\n[backend]\nkind = \"linux\"\n"));
    write("program.toml", &changed("rate_hz = 100.0", "rate_hz = 100.0\nprogram = \"wave.csv\""));
    write(
        "joint.toml",
        &(RIG.to_owned()
            + "\n[[joint]]\nname = \"knee\"\nagonist = \"wire\"\nantagonist = \"other\"\nradius_mm = 8.0\n"),
    );
    write(
        "two.toml",
        &(RIG.to_owned() + &RIG[RIG.find("[[channel]]").expect("one")..].replace("\"wire\"", "\"other\"")),
    );

    write("good.csv", &csv(',', '.', 1.0));
    write("german.csv", &csv(';', ',', 1.0));
    write("millimetres.csv", &csv(',', '.', 1000.0));
    write("empty.csv", "");
    write("head.csv", "time_s,duty,position_m\n");
    write("no-time.csv", &csv(',', '.', 1.0).replace("time_s", "t"));
    write("no-input.csv", &csv(',', '.', 1.0).replace("duty", "Heizung"));
    write("ragged.csv", &csv(',', '.', 1.0).replacen("\n0.100000,", "\n0.100000,0.1,", 1));
    write("word.csv", &csv(',', '.', 1.0).replacen("0.020000", "off", 1));
    write("back.csv", &csv(',', '.', 1.0).replacen("\n0.100000,", "\n0.010000,", 1));
    write("setpoints.csv", "time,wire\n0,40%\n");
    write("unitless.csv", "time_s,wire\n0,40\n");
    write("broken.mcap", "\u{89}MCAP0\r\n and then nothing that belongs there");
    write("text.mcap", "this is no recording\n");
    fs::create_dir(folder.join("folder")).expect("a writable folder");
}

/// The mistakes: what was done, and how.
const MISTAKES: &[(&str, &str)] = &[
    ("a command that is none", "sinew runn rig.toml"),
    ("an option that is none", "sinew run rig.toml --fro 5"),
    ("a time that is none", "sinew run rig.toml --for five"),
    ("no rig file of that name", "sinew run bench.toml"),
    ("a folder for a rig file", "sinew run folder"),
    ("an empty rig file", "sinew check empty.toml"),
    ("no TOML", "sinew check word.toml"),
    ("a rig file of another encoding", "sinew check latin1.toml"),
    ("a slip of the fingers in a key", "sinew check typo.toml"),
    ("a unit written into a number", "sinew check quoted.toml"),
    ("microns for millimetres", "sinew check microns.toml"),
    ("metres for millimetres", "sinew check metres.toml"),
    ("taps beyond the wire", "sinew check taps.toml"),
    ("a wire that is not known", "sinew check kind.toml"),
    ("no wire", "sinew check no-wire.toml"),
    ("no supply", "sinew check no-supply.toml"),
    ("a blank in a name", "sinew check space.toml"),
    ("a law that is not known", "sinew check law.toml"),
    ("a name twice", "sinew check twice.toml"),
    ("a joint with a wire that is not there", "sinew check joint.toml"),
    ("a rate that no wire can be driven with", "sinew run slow.toml --no-monitor"),
    ("a port that is not there", "sinew run serial.toml --no-monitor"),
    ("no port", "sinew run no-port.toml --no-monitor"),
    ("no lines for Linux's outputs", "sinew run linux.toml --no-monitor"),
    ("a program that is not there", "sinew run program.toml --no-monitor"),
    ("speed for hardware", "sinew run serial.toml --speed 10"),
    ("a report into a folder that is not there", "sinew run rig.toml --report reports/run.json"),
    ("a second driver", "sinew run RUNNING.toml --no-monitor"),
    ("no driver to look at", "sinew status --rig bench"),
    ("no driver to command", "sinew set wire stroke=40% --rig bench"),
    ("no driver to stop", "sinew stop --rig bench"),
    ("no driver to record", "sinew record new.mcap --rig bench"),
    ("no driver to draw", "sinew scope --rig bench"),
    ("a channel that is not there", "sinew set lfet stroke=40% --rig RUNNING"),
    ("a setpoint without its kind", "sinew set left 40% --rig RUNNING"),
    ("a length without a unit", "sinew set left length=0.158 --rig RUNNING"),
    ("a length beyond the stroke", "sinew set left length=200mm --rig RUNNING"),
    ("a stroke as a whole number", "sinew set left stroke=40 --rig RUNNING"),
    ("a duty in percent", "sinew set left duty=40 --rig RUNNING"),
    ("a hold that is longer than allowed", "sinew set left stroke=40% --hold 1e6 --rig RUNNING"),
    ("a reset of a channel that is not there", "sinew reset wire --rig RUNNING"),
    ("setpoints without a time", "sinew play setpoints.csv --rig RUNNING"),
    ("setpoints without a unit", "sinew play unitless.csv --rig RUNNING"),
    ("a recording over another file", "sinew record good.csv --rig RUNNING"),
    ("a recording into a folder that is not there", "sinew record runs/new.mcap --rig RUNNING"),
    ("no recording of that name", "sinew simulate rig.toml monday.csv -o out.csv"),
    ("an empty recording", "sinew simulate rig.toml empty.csv -o out.csv"),
    ("a recording of a header", "sinew simulate rig.toml head.csv -o out.csv"),
    ("a recording without a time", "sinew simulate rig.toml no-time.csv -o out.csv"),
    ("a recording without what heats", "sinew simulate rig.toml no-input.csv -o out.csv"),
    ("a row with a cell too many", "sinew simulate rig.toml ragged.csv -o out.csv"),
    ("a word where a number belongs", "sinew simulate rig.toml word.csv -o out.csv"),
    ("a time that goes back", "sinew simulate rig.toml back.csv -o out.csv"),
    ("semicolons and decimal commas", "sinew simulate rig.toml german.csv -o out.csv"),
    ("millimetres in a column of metres", "sinew identify rig.toml millimetres.csv -o fitted.toml"),
    ("which of two wires", "sinew simulate two.toml good.csv -o out.csv"),
    ("a result over what it is made from", "sinew identify rig.toml good.csv -o rig.toml"),
    ("the same recording twice", "sinew diagnose rig.toml good.csv --holdout good.csv --out answer"),
    ("a recording that is none", "sinew recording info text.mcap"),
    ("a recording that is damaged", "sinew recording info broken.mcap"),
    ("a replay of a table", "sinew replay good.csv"),
    ("a figure of a kind that is none", "sinew plot good.csv -o figure.gif"),
    ("a quantity that is not there", "sinew plot good.csv -o figure.svg --quantity temprature"),
    ("an export of another kind", "sinew export good.csv -o good.xlsx"),
    ("a demand no wire meets", "sinew design --force 2kN --stroke 6mm"),
    ("a routine that is none", "sinew test pull rig.toml"),
    ("a chapter the thesis has not", "sinew thesis 99 --out book"),
    ("a bench that is there already", "sinew new folder"),
    ("a wire that nobody sells", "sinew new arm --wire flexinol-125-lt"),
    ("a weight without a unit", "sinew new arm --weight 100"),
];

#[test]
fn every_mistake_is_told_with_its_place_and_remedy() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    lay_out(folder.path());
    let rig = Rig::bench(&["left", "right"], "");
    fs::copy(rig.path(), folder.path().join("RUNNING.toml")).expect("a writable folder");
    let (driver, _client) = Driver::ready(&rig);
    let pid = driver.process.pid().to_string();

    let mut text = String::new();
    for (mistake, command) in MISTAKES {
        let words = command.split(' ').skip(1).map(|word| if word == "RUNNING" { rig.name.as_str() } else { word });
        let mut process = Command::new(sinew());
        process.args(words).current_dir(folder.path()).env("COLUMNS", "100");
        let ran = Process::start(&mut process).finish();
        let said = ran.stderr.replace(&rig.name, "RUNNING").replace(&pid, "PID");
        let said = said.replace(&folder.path().display().to_string(), "FOLDER");
        assert_eq!(ran.stdout, "", "{mistake}: {ran:#?}");
        assert!(matches!(ran.code, Some(1 | 2)), "{mistake}: {ran:#?}");
        assert!(said.starts_with("error: ") && said.contains("\nhint: "), "{mistake}: {said}");
        // writing to a String cannot fail
        let _ = writeln!(text, "{mistake}\n$ {command}\n{}exit {}\n", said, ran.code.unwrap_or_default());
    }
    driver.stop();

    let page = checkout().join("tests/mistakes.txt");
    if std::env::var_os("SINEW_BLESS").is_some() {
        fs::write(&page, &text).expect("a writable checkout");
    }
    let written = fs::read_to_string(&page).expect("tests/mistakes.txt");
    for (now, then) in text.split("\n\n").zip(written.split("\n\n")) {
        assert_eq!(now, then, "SINEW_BLESS=1 writes it anew; read it as somebody who made the mistake");
    }
    assert_eq!(text.len(), written.len());
}
