//! Recordings out, in and once more: export, import, replay, and sessions where CSV is taken.

use std::fs::File;
use std::path::Path;

use crate::support::{RIG, Scratch};
use serde_json::Value;
use sinew_backend::{Backend, Sample};
use sinew_driver::{Ask, Beat, Engine, Order};
use sinew_ipc::{DriverState, Snapshot};
use sinew_recorder::layout;
use sinew_recording::session::{About, Ended, Head, SessionWriter, WriteOptions};
use sinew_recording::{Column, Options, read};
use sinew_replay::encode;
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

/// A session as a recorder has it that was there from the driver's first cycle: every wire heated in steps.
fn session(path: &Path, rig_toml: &str, cycles: u64) {
    let rig = Rig::parse(rig_toml, "rig.toml").expect("a rig");
    let names: Vec<String> = rig.channels.iter().map(|channel| channel.name.clone()).collect();
    let mut backend = SimulatedRig::new(&rig).expect("a simulated rig");
    backend.start().expect("it starts");
    let mut engine = Engine::at_rest(&rig, None).expect("an engine");
    let (mut duty, mut samples) = (vec![0.0; names.len()], vec![Sample::NONE; names.len()]);
    let about = About {
        rig: rig.name.clone(),
        rate_hz: rig.rate_hz,
        software: "sinew test".into(),
        kind: "driver".into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: 0,
        rig_toml: Some(rig_toml.into()),
        extra: Default::default(),
    };
    let sink = File::create(path).expect("a file");
    let layout = layout(names.clone()).expect("a layout");
    let mut writer = SessionWriter::create(sink, &about, &layout, WriteOptions::new("session")).expect("a session");
    let (mut state, mut bytes, mut missed) = (Snapshot::new(names.len()), Vec::new(), 0);
    let period_ns = (1e9 / rig.rate_hz) as u64;
    for cycle in 1..=cycles {
        let late = u64::from(cycle % 40 == 0);
        if late > 0 {
            backend.missed(late);
        }
        missed += late;
        let now_ns = (cycle - 1 + missed) * period_ns;
        let exchanged = backend.exchange(&duty, &mut samples);
        if cycle % 50 == 20 {
            let asked = [0.3, 0.02, 0.5, 0.1][(cycle / 50) as usize % 4];
            for channel in 0..names.len() {
                engine.take(&Order { ticket: 0, channel, ask: Ask::Duty(asked), hold_ns: u64::MAX }, now_ns);
            }
        }
        engine.cycle(Beat { now_ns, missed: late }, exchanged, &samples, &mut duty, |_| {});
        engine.describe(now_ns, DriverState::Running, &mut state);
        encode(state.channels(), &mut bytes);
        writer.cycle(&Head { cycle, monotonic_ns: now_ns, missed }, &bytes).expect("a cycle");
    }
    writer.finish(Ended::Complete).expect("an end");
}

/// The contract's wire and a second one.
fn two() -> String {
    let wire = &RIG[RIG.find("[[channel]]").expect("a channel")..];
    format!("{RIG}\n{}", wire.replace("name = \"wire\"", "name = \"other\""))
}

#[test]
fn csv_and_session_tell_every_command_the_same() {
    let scratch = Scratch::new();
    session(&scratch.path("run.mcap"), RIG, 600);
    scratch.file("rig.toml", RIG);
    scratch.sinew(["export", "run.mcap", "-o", "run.csv"]).done();
    let by_csv = read(scratch.path("run.csv"), &Options::default()).expect("CSV");
    let by_session = read(scratch.path("run.mcap"), &Options::default()).expect("a session");
    assert_eq!(by_csv.len(), 599);
    for (one, other) in by_csv.columns().zip(by_session.columns()) {
        assert_eq!(one.0, other.0);
        assert!(one.1.iter().zip(other.1).all(|(x, y)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan())));
    }
    assert_eq!(by_csv.time_s(), by_session.time_s());

    for input in ["run.csv", "run.mcap"] {
        let out = format!("simulated-{}.csv", &input[4..]);
        scratch.sinew(["simulate", "rig.toml", input, "-o", &out]).done();
    }
    let simulated = |end: &str| std::fs::read(scratch.path(&format!("simulated-{end}.csv"))).expect("it was written");
    assert!(simulated("csv") == simulated("mcap"), "the same inputs, the same simulation");

    // what the simulation says agrees with what was measured, to the converter's noise
    let options = Options { ignore_columns: true, ..Options::default() };
    let model = read(scratch.path("simulated-csv.csv"), &options).expect("CSV");
    let (mut sum, mut count) = (0.0, 0.0);
    for (seen, said) in by_csv.get(Column::V3V).expect("v3_v").iter().zip(model.get(Column::V3V).expect("v3_v")) {
        if seen.is_finite() {
            sum += ((seen - said) / 0.0015).powi(2);
            count += 1.0;
        }
    }
    let chi = f64::sqrt(sum / count);
    assert!(count > 500.0 && (0.9..1.1).contains(&chi), "{chi} over {count}");
}

#[test]
fn several_channels_are_several_files_and_a_part_is_a_part() {
    let scratch = Scratch::new();
    session(&scratch.path("run.mcap"), &two(), 300);
    scratch.sinew(["export", "run.mcap", "-o", "out.csv.gz"]).done();
    for channel in ["wire", "other"] {
        let one = read(scratch.path(&format!("out-{channel}.csv.gz")), &Options::default()).expect("CSV");
        assert_eq!(one.len(), 299);
    }
    scratch.sinew(["export", "run.mcap", "-o", "one.csv", "--channel", "other", "--from", "1", "--to", "2"]).done();
    let part = read(scratch.path("one.csv"), &Options::default()).expect("CSV");
    let (first, last) = (part.time_s()[0], part.time_s()[part.len() - 1]);
    assert!((1.0..1.02).contains(&first) && (1.97..2.0).contains(&last), "{first} to {last}");
    let whole = read(scratch.path("out-other.csv.gz"), &Options::default()).expect("CSV");
    let from = whole.time_s().iter().position(|t| *t == first).expect("the same times");
    let same = |column| part.get(column).unwrap()[3].to_bits() == whole.get(column).unwrap()[from + 3].to_bits();
    assert!(same(Column::Duty) && same(Column::V1V), "and the same rows");

    scratch.sinew(["export", "run.mcap", "-o", "x.csv", "--channel", "othr"]).refused(&["did you mean \"other\""]);
    scratch.sinew(["export", "run.mcap", "-o", "x.xls"]).refused(&["no format", ".parquet"]);
    scratch.sinew(["export", "run.mcap", "-o", "x.csv", "--from", "2", "--to", "1"]).refused(&["nothing in between"]);
    scratch.file("rig.toml", two());
    scratch.sinew(["simulate", "rig.toml", "run.mcap", "-o", "x.csv"]).refused(&["--channel"]);
    scratch.sinew(["simulate", "rig.toml", "run.mcap", "-o", "x.csv", "--channel", "other"]).done();
}

#[test]
fn a_foreign_recording_comes_in_by_the_rig_files_map_and_out_again_unchanged() {
    let scratch = Scratch::new();
    let map = "\n[recording.columns]\ntime_s = { column = \"t_ms\", scale = 0.001 }\n\
        position_m = { column = \"Pos\", scale = -0.001 }\nduty = { column = \"PWM\", scale = 0.01 }\n";
    scratch.file("rig.toml", format!("{RIG}{map}"));
    scratch.file("lab.csv", "t_ms,PWM,Pos\n0,0,-0.1\n10,50,\n20,100,-0.30000000000000004\n30,7,1e-300\n");
    let import = |out| scratch.sinew(["import", "lab.csv", "--rig", "rig.toml", "-o", out]).done();
    import("lab-own.csv");
    import("lab.mcap");
    import("lab.parquet");
    scratch.sinew(["export", "lab.mcap", "-o", "back.csv"]).done();
    let text = |name: &str| std::fs::read_to_string(scratch.path(name)).expect("it was written");
    assert_eq!(text("back.csv"), text("lab-own.csv"));
    assert!(
        text("back.csv").starts_with("time_s,duty,position_m\n0.0,0.0,0.0001\n0.01,0.5,\n"),
        "{}",
        text("back.csv")
    );
    scratch.sinew(["simulate", "rig.toml", "lab.mcap", "-o", "simulated.csv"]).done();
    scratch.sinew(["import", "lab.mcap", "--rig", "rig.toml", "-o", "x.csv"]).refused(&["session already"]);
    scratch.sinew(["import", "lab.csv", "--rig", "rig.toml", "-o", "x.txt"]).refused(&["no format", ".mcap"]);
    scratch.sinew(["replay", "lab.mcap"]).refused(&["import", "only a driver's can be replayed"]);
    scratch.file("lab-bad.csv", "t_ms,PWM,Pos\n0,0,-0.1\n10,5000,\n20,100,0\n");
    scratch.sinew(["import", "lab-bad.csv", "--rig", "rig.toml", "-o", "x.csv"]).refused(&["lab-bad.csv:3", "PWM"]);
}

/// A German program's file: semicolons, decimal commas, Windows-1252, remarks above and below, shortening counted from cold.
fn messy(duty_name: &str) -> Vec<u8> {
    let mut text = format!("Versuch;FGL 7\nPrüfer;Müller\n\nZeit;{duty_name};Verkürzung\nms;%;µm\n");
    let (mut heat, comma) = (0.0, |value: f64| format!("{value:.2}").replace('.', ","));
    for row in 0..200 {
        let duty = if row % 100 < 50 { 0.0 } else { 40.0 };
        heat += 0.05 * (duty / 40.0 - heat);
        text += &format!("{};{};{}\n", comma(f64::from(row) * 20.0), comma(duty), comma(5000.0 * heat));
    }
    text += "Ende der Messung\n";
    text.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin-1")).collect()
}

#[test]
fn a_messy_file_is_understood_confirmed_and_brought_in() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    std::fs::write(scratch.path("messung.csv"), messy("Tastgrad")).expect("a file");
    scratch.sinew(["import", "messung.csv", "--rig", "rig.toml", "-o", "x.csv"]).refused(&["messung.csv:1", "--guess"]);
    let said = scratch.sinew(["import", "--guess", "messung.csv", "--rig", "rig.toml", "-o", "map.toml"]).done();
    for part in ["windows-1252", "decimal comma", "200 rows", "TURNED ROUND", "position_zero", "line 206 is text"] {
        assert!(said.contains(part), "{said}");
    }
    let import =
        |file: &str, out: &str| scratch.sinew(["import", file, "--map", "map.toml", "--rig", "rig.toml", "-o", out]);
    import("messung.csv", "out.csv").done();
    let out = read(scratch.path("out.csv"), &Options::default()).expect("a recording");
    assert_eq!((out.len(), out.time_s()[50]), (200, 1.0));
    assert_eq!(out.get(Column::Duty).expect("duty")[50], 0.4);
    assert!((out.get(Column::PositionM).expect("position_m")[50] + 250e-6).abs() < 1e-12, "5 % of 5 mm, and shorter");
    import("messung.csv", "out.mcap").done();
    // the mapping is part of a rig file, too
    let map = std::fs::read_to_string(scratch.path("map.toml")).expect("the mapping");
    scratch.file("with-map.toml", format!("{RIG}\n{map}"));
    scratch.sinew(["import", "messung.csv", "--rig", "with-map.toml", "-o", "again.csv"]).done();
    let again = read(scratch.path("again.csv"), &Options::default()).expect("a recording");
    assert!(again.has_the_samples_of(&out));

    // a mapped column that is missing is an error, whatever else is passed over
    std::fs::write(scratch.path("renamed.csv"), messy("Leistung")).expect("a file");
    import("renamed.csv", "x.csv").refused(&[
        "renamed.csv",
        "\"Tastgrad\"",
        "is mapped to duty and is not in the file",
    ]);
    scratch.file("bad.toml", "[recording.columns]\nposition = \"x\"\n");
    scratch
        .sinew(["import", "messung.csv", "--map", "bad.toml", "--rig", "rig.toml", "-o", "x.csv"])
        .refused(&["bad.toml:2"]);
    scratch.sinew(["import", "--guess", "messung.csv", "-o", "x.csv"]).refused(&["no name for a mapping", ".toml"]);
    scratch.sinew(["import", "--guess", "nowhere.csv"]).refused(&["nowhere.csv", "cannot be read"]);
    scratch.file("letter.txt", "Dear colleague,\nthe files are elsewhere.\n");
    scratch.sinew(["import", "--guess", "letter.txt"]).refused(&["letter.txt", "no rows of numbers"]);
}

#[test]
fn a_replay_is_identical_until_something_is_changed() {
    let scratch = Scratch::new();
    session(&scratch.path("run.mcap"), &two(), 400);
    let same = scratch.sinew(["replay", "run.mcap", "--expect-identical"]).done();
    assert!(same.contains("400 cycles of 2 channels") && same.contains("identical: every field"), "{same}");

    let changed = ["replay", "run.mcap", "--set", "other:limits.maximum_duty=0.25", "--json"];
    let told: Value = serde_json::from_str(&scratch.sinew(changed).done()).expect("JSON");
    assert_eq!((told["identical"].as_bool(), told["cycles"].as_u64()), (Some(false), Some(400)));
    assert_eq!(told["channel"][0]["fields"].as_array().map(Vec::len), Some(0), "{told}");
    let duty = told["channel"][1]["fields"].as_array().unwrap().iter().find(|f| f["field"] == "duty").expect("duty");
    assert!((duty["max"].as_f64().unwrap() - 0.25).abs() < 1e-9, "{duty}");

    // Written down, what came out now is a session like any other. Its duties were decided and never given: taken for given, as a
    // recording's are, they are other powers, and what was measured is the same.
    let again =
        ["replay", "run.mcap", "--set", "other:limits.maximum_duty=0.25", "-o", "again.mcap", "--expect-identical"];
    assert_eq!(scratch.sinew(again).code(), 1);
    let told: Value = serde_json::from_str(&scratch.sinew(["replay", "again.mcap", "--json"]).done()).expect("JSON");
    let fields = told["channel"][1]["fields"].as_array().unwrap();
    assert!(
        fields.iter().any(|f| f["field"] == "power_w") && fields.iter().all(|f| f["field"] != "measured_length_m"),
        "{told}"
    );
    assert_eq!(told["channel"][0]["fields"].as_array().map(Vec::len), Some(0), "{told}");
    scratch.sinew(["recording", "doctor", "again.mcap"]).done();

    scratch.sinew(["replay", "run.mcap", "--set", "control.algorithm=nonsense"]).refused(&["control.algorithm"]);
    scratch.sinew(["replay", "run.mcap", "--set", "nonsense"]).refused(&["KEY=VALUE"]);
    scratch.sinew(["replay", "run.mcap", "-o", "run.mcap"]).refused(&["the recording itself"]);
    scratch.file("one.toml", RIG);
    scratch.sinew(["replay", "run.mcap", "one.toml"]).refused(&["2 channels, but the rig has 1"]);
    scratch.sinew(["replay", "none.mcap"]).refused(&["none.mcap"]);
}

#[test]
fn parquet_opens_in_python() {
    let scratch = Scratch::new();
    session(&scratch.path("run.mcap"), &two(), 300);
    scratch.sinew(["export", "run.mcap", "-o", "run.parquet"]).done();
    let script = "import pyarrow.parquet as p, json\n\
        f = p.ParquetFile('run.parquet')\n\
        t = f.read()\n\
        about = json.loads(f.metadata.metadata[b'sinew'])\n\
        print(t.num_rows, t.num_columns, t.schema.field('wire.mode').type, t.schema.field('cycle').type)\n\
        print(repr(t['other.v3_v'][99].as_py()), t['cycle'][299].as_py(), about['rig'], about['fields'][0]['unit'])\n\
        print(b'[rig]' in f.metadata.metadata[b'rig.toml'])\n";
    let python = std::process::Command::new("python3").args(["-c", script]).current_dir(scratch.path(".")).output();
    let Ok(output) = python else { return eprintln!("skipped: no python3") };
    if !output.status.success() && String::from_utf8_lossy(&output.stderr).contains("No module named 'pyarrow'") {
        return eprintln!("skipped: python3 without pyarrow");
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let session = sinew_recording::session::Session::open(scratch.path("run.mcap")).expect("a session");
    let mut cycles = session.cycles();
    let field = session.layout().field("v3_v").expect("v3_v");
    for _ in 0..99 {
        cycles.next().expect("a cycle");
    }
    let v3_v = cycles.next().expect("a cycle").expect("the hundredth").get(1, field);
    let columns = 4 + 2 * session.layout().fields.len();
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        format!("300 {columns} uint32 uint64\n{v3_v:?} 300 tensile-bench m\nTrue\n")
    );
}
