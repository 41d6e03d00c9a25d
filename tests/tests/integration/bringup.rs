//! `sinew bringup` against a board that is wired wrongly, `sinew-front-end --wrong …`, with a person at the bench who does what each step
//! says. What is wrong is drawn at random; the step that finds it has to call it by its name, nothing may ever be given more than 2 %, and
//! no wire may get warmer than 2 % makes it. The front-end's own word counts for both, not the driver's.

use std::fs;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use serde_json::Value;
use sinew_tests::{PATIENCE, Process, Rig, front_end, sinew};

/// Slow periods and a long silence: on a busy machine both processes are late by many milliseconds.
const RATE_HZ: f64 = 50.0;
/// One bench at a time: a board and its driver are punctual only where both have a processor.
static TABLE: Mutex<()> = Mutex::new(());
const SUPPLY_V: f64 = 6.5;
const OHM: f64 = 11.9;
const CHANNELS: [&str; 3] = ["left", "middle", "right"];
const STEPS: [&str; 5] = ["supply", "estop", "stages", "dummy", "wire"];
/// The largest duty, with the rounding of its code on the line.
const MOST_DUTY: f64 = 0.02 + 1.0 / 65535.0;
/// A wire of the test's rig at 2 % for ever: 3.7 W × 0.02 over its loss to the air, less than 8 K.
const WARM_K: f64 = 8.0;
const AMBIENT_C: f64 = 25.0;

fn bench() -> Rig {
    let mut rig = Rig::named(|name| format!("# a bench\n[rig]\nname = \"{name}\" # its name\nrate_hz = {RATE_HZ:?}\n"));
    for (at, name) in CHANNELS.into_iter().enumerate() {
        let l0_mm = if at == 0 { 10.0 } else { 0.0 };
        rig.add(&format!(
            "\n[[channel]]\nname = \"{name}\" # a wire\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
             taps = {{ l0_mm = {l0_mm:?}, ls_mm = 140.0 }}\n\
             drive = {{ supply_v = {SUPPLY_V:?}, shunt_ohm = 0.5, switch_ohm = 0.05 }}\n\
             load = {{ mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}\n"
        ));
    }
    let port = rig.file("front-end");
    rig.add(&format!(
        "\n[backend]\nkind = \"serial\"\nserial.port = \"{}\"\nserial.watchdog_periods = 20\nenable.signal = \"level\"\nestop.fitted = true\n",
        port.display()
    ));
    rig
}

/// What came of a bring-up.
struct Outcome {
    code: Option<i32>,
    report: Value,
    said: String,
    most_duty: f64,
    hottest_c: f64,
}

impl Outcome {
    /// Causes by step, channel and name, each once.
    fn causes(&self) -> Vec<(String, String, String)> {
        let word = |value: &Value| value.as_str().unwrap_or("").to_string();
        let looks = self.report["looks"].as_array().into_iter().flatten();
        let found = looks.flat_map(|look| {
            let of = |found: &Value| (word(&look["step"]), word(&found["channel"]), word(&found["cause"]));
            look["findings"].as_array().into_iter().flatten().map(of).collect::<Vec<_>>()
        });
        found.collect()
    }

    /// Steps that were looked at.
    fn steps(&self) -> Vec<&str> {
        self.report["looks"].as_array().into_iter().flatten().filter_map(|look| look["step"].as_str()).collect()
    }
}

/// Brings a bench up with this wrong, by a person who does what is asked and gives up at the first thing that is wrong.
#[track_caller]
fn bring_up(rig: &Rig, wrong: &[String], more: &[&str]) -> Outcome {
    let _table = TABLE.lock().unwrap_or_else(PoisonError::into_inner);
    let supply = wrong
        .iter()
        .find_map(|wrong| wrong.strip_prefix("supply "))
        .map_or(1.0, |factor| factor.parse().expect("a number"));
    let mut command = Command::new(front_end());
    command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args([
        "--for",
        "300",
        "--mount",
        "nothing",
        "--outputs",
    ]);
    command.arg("--truth").arg(rig.file("truth.csv"));
    for wrong in wrong {
        command.arg("--wrong").arg(wrong);
    }
    let mut board = Process::start_to_be_told(&mut command);
    board.wait_for_word("\"event\":\"port\"");
    let mut command = Command::new(sinew());
    command.arg("bringup").arg(rig.path()).arg("--report").arg(rig.file("report.json")).args(more);
    command.env("SINEW_STATE_DIR", rig.file("state"));
    let mut bench = Process::start_to_be_told(&mut command);
    let (mut read, began) = (0, Instant::now());
    while bench.ended().is_none() {
        assert!(began.elapsed() < PATIENCE, "{wrong:?}: still at it: {}{}", bench.stdout(), bench.stderr());
        let said = bench.stdout();
        let Some((question, end)) = question(&said[read..]) else {
            std::thread::sleep(std::time::Duration::from_millis(5));
            continue;
        };
        read += end;
        let answer = answer(&question, &mut board, supply);
        bench.tell(&answer);
    }
    let finished = bench.finish();
    board.tell("quit");
    let board = board.finish();
    let outputs = board.stdout.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let duties = outputs.filter(|event| event["event"] == "outputs").flat_map(|event| {
        let duty = event["duty"].as_array().cloned().unwrap_or_default();
        duty.into_iter().filter_map(|duty| duty.as_f64()).collect::<Vec<_>>()
    });
    let most_duty = duties.fold(0.0, f64::max) / 65535.0;
    let truth = fs::read_to_string(rig.file("truth.csv")).expect("the front-end writes it");
    let temperatures =
        truth.lines().skip(1).flat_map(|row| row.split(',').skip(1).map(|cell| cell.parse::<f64>().expect("a number")));
    let hottest_c = temperatures.fold(f64::MIN, f64::max);
    let report = fs::read_to_string(rig.file("report.json")).expect("the report is written");
    Outcome {
        code: finished.code,
        report: serde_json::from_str(&report).expect("JSON"),
        said: finished.stdout + &finished.stderr,
        most_duty,
        hottest_c,
    }
}

/// The question that stands at the end of what was said, by its name, and where it ends.
fn question(said: &str) -> Option<(String, usize)> {
    let start = said.rfind("\n[")?;
    let (name, text) = said[start + 2..].split_once("] ")?;
    (!text.contains('\n') && text.ends_with(' ')).then(|| (name.to_string(), said.len()))
}

/// What a person at the bench does about it, and answers.
fn answer(question: &str, board: &mut Process, supply: f64) -> String {
    let mut mount = |name: &str, what: &str| {
        for channel in CHANNELS {
            board.tell(&format!("mount {channel} {}", if channel == name { what } else { "nothing" }));
        }
    };
    match question.split_once(' ') {
        Some(("supply", "meter")) => return format!("{:.4}", SUPPLY_V * supply),
        Some(("dummy", "ohm")) => return OHM.to_string(),
        Some(("dummy", name)) => mount(name, &OHM.to_string()),
        Some(("wire", name)) => mount(name, "wire"),
        Some(("mended", _)) => return "q".into(),
        Some(("estop", rest)) if rest.starts_with("pressed") => board.tell("fault 0 estop_open"),
        Some(("estop", _)) => board.tell("whole 0 estop_open"),
        _ => {}
    }
    // the firmware's loop takes one order each time round, at the latest after 5 ms
    std::thread::sleep(std::time::Duration::from_millis(60));
    String::new()
}

/// Something wrong, drawn at random: the words for the front-end, the cause it has to be called by, the channels that may be named with
/// it (none: it is the board's), and the step that is to find it.
struct Draw {
    wrong: String,
    cause: &'static str,
    channels: Vec<&'static str>,
    step: &'static str,
}

/// How many kinds there are.
const KINDS: usize = 31;

fn draw(kind: usize, random: &mut SmallRng) -> Draw {
    let at = random.random_range(0..CHANNELS.len());
    let (a, b) = (CHANNELS[at], CHANNELS[(at + random.random_range(1..CHANNELS.len())) % CHANNELS.len()]);
    // wrong by a factor in these bounds, or by its inverse
    let mut factor = |low: f64, high: f64| {
        let factor: f64 = random.random_range(low..high);
        if random.random_bool(0.5) { factor } else { 1.0 / factor }
    };
    let of = |wrong: String, cause, step| Draw { wrong, cause, channels: vec![a], step };
    let rig = |wrong: String, cause, step| Draw { wrong, cause, channels: vec![""], step };
    let two = |what: &str, cause| Draw { wrong: format!("{what} {a} {b}"), cause, channels: vec![a, b], step: "dummy" };
    match kind {
        0 => two("outputs", "outputs_exchanged"),
        1 => two("senses", "senses_exchanged"),
        2 => two("channels", "channels_exchanged"),
        3 => of(format!("shunt {a} {:.3}", factor(1.2, 1.9)), "shunt_value", "dummy"),
        4 => of(format!("shunt {a} 0.2"), "shunt_value", "dummy"),
        5 => of(format!("shunt-shorted {a}"), "current_unseen", "dummy"),
        6 => rig("supply-sense-reversed".into(), "supply_sense", "supply"),
        7 => rig("supply-sense-open".into(), "supply_sense", "supply"),
        8 => rig(format!("supply {:.3}", random.random_range(0.6..0.97)), "supply_low", "supply"),
        9 => rig(format!("supply {:.3}", random.random_range(1.03..1.2)), "supply_high", "supply"),
        10 => of(format!("tap-missing {a} v1"), "tap_missing", "stages"),
        11 => of(format!("tap-missing {a} v2"), "tap_missing", "stages"),
        12 => of(format!("tap-missing {a} v3"), "tap_missing", "stages"),
        13 => of(format!("taps-swapped {a}"), "taps_exchanged", "wire"),
        14 => of(format!("tap-end-swapped {a}"), "tap_end_exchanged", "wire"),
        15 => of(format!("lead-open {a}"), "lead_open", "dummy"),
        16 => of(format!("wire-open {a}"), "wire_open", "wire"),
        17 => of(format!("wire-bridged {a}"), "wire_bridged", "wire"),
        18 => of(format!("wire-diameter {a} {:.3}", factor(1.2, 1.35)), "wrong_wire", "wire"),
        19 => of(format!("tap-distance {a} {:.3}", random.random_range(0.85..0.95)), "taps_apart", "wire"),
        20 => of(format!("stage-on {a}"), "stage_on", "stages"),
        21 => of(format!("stage-dead {a}"), "stage_dead", "stages"),
        22 => of(format!("stage-weak {a}"), "stage_weak", "dummy"),
        23 => rig("enable-open".into(), "no_supply_at_stages", "stages"),
        24 => rig("stop-normally-open".into(), "stop_normally_open", "estop"),
        25 => rig("stop-open".into(), "stop_open", "estop"),
        26 => rig("stop-bridged".into(), "stop_bridged", "estop"),
        27 => of(format!("gain {a} v3 {:.3}", factor(1.1, 1.25)), "gain", "dummy"),
        28 => of(format!("gain {a} v2 {:.3}", factor(1.1, 1.25)), "gain", "dummy"),
        29 => of(format!("offset {a} v2 {:.3}", random.random_range(0.1..0.3)), "offset", "dummy"),
        30 => of(format!("offset {a} current {:.4}", random.random_range(0.01..0.02)), "offset", "dummy"),
        _ => unreachable!("there are {KINDS} kinds"),
    }
}

/// One of every kind, each with its channel and size drawn by the seed.
fn each_is_named(seed: u64, kinds: impl Iterator<Item = usize>) {
    println!("seed {seed}");
    let mut random = SmallRng::seed_from_u64(seed);
    let all: Vec<Draw> = (0..KINDS).map(|kind| draw(kind, &mut random)).collect();
    for kind in kinds {
        let Draw { wrong, cause, channels, step } = &all[kind];
        let rig = bench();
        let outcome = bring_up(&rig, std::slice::from_ref(wrong), &[]);
        let told = format!("seed {seed}, {wrong}:\n{}", outcome.said);
        let causes = outcome.causes();
        println!("{wrong}: {causes:?}, duty {:.4}, {:.1} °C", outcome.most_duty, outcome.hottest_c);
        let is_named = |(at, channel, name): &(String, String, String)| {
            at == step && name == cause && channels.contains(&channel.as_str())
        };
        assert!(
            causes.first().is_some_and(is_named),
            "wanted {cause} of {channels:?} in {step}, found {causes:?}; {told}"
        );
        assert_eq!(outcome.code, Some(1), "{told}");
        assert!(outcome.most_duty <= MOST_DUTY, "{} was put out; {told}", outcome.most_duty);
        assert!(outcome.hottest_c < AMBIENT_C + WARM_K, "{} °C; {told}", outcome.hottest_c);
    }
}

#[test]
fn what_is_wrong_before_anything_is_connected_is_named() {
    each_is_named(22, (6..13).chain(20..22).chain(23..27));
}

#[test]
fn what_is_wrong_with_channels_and_inputs_is_named() {
    each_is_named(2205, (0..6).chain([15, 22]).chain(27..31));
}

#[test]
fn what_is_wrong_with_a_wire_and_its_taps_is_named() {
    each_is_named(5, [13, 14, 16, 17, 18, 19].into_iter());
}

#[test]
fn a_board_that_is_right_is_brought_up_and_its_rig_file_corrected() {
    let rig = bench();
    let before = fs::read_to_string(rig.path()).expect("it is there");
    // by what one per cent resistors do
    let (v2, v3, amps) = (1.013, 0.985, 1.021);
    let wrong = [format!("gain left v2 {v2}"), format!("gain left v3 {v3}"), format!("gain left current {amps}")];
    let outcome = bring_up(&rig, &wrong, &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.said);
    assert!(outcome.causes().is_empty(), "{}", outcome.said);
    assert!(STEPS.iter().all(|step| outcome.steps().contains(step)), "{:?}", outcome.steps());
    assert!(outcome.most_duty > 0.0 && outcome.most_duty <= MOST_DUTY, "{}", outcome.most_duty);
    assert!(outcome.hottest_c > AMBIENT_C && outcome.hottest_c < AMBIENT_C + WARM_K, "{} °C", outcome.hottest_c);

    let text = fs::read_to_string(rig.path()).expect("it is there");
    for line in before.lines().filter(|line| !line.is_empty()) {
        assert!(text.contains(line), "{line} is lost:\n{text}");
    }
    let copy = outcome.report["copy"].as_str().expect("a copy");
    assert_eq!(fs::read_to_string(copy).expect("it is there"), before);
    let now = sinew_rig::Rig::load(&rig.path()).expect("a rig file");
    let left = &now.channels[0].backend.serial;
    for (input, wrong) in [(left.inputs.v2, v2), (left.inputs.v3, v3), (left.inputs.current, amps)] {
        assert!((input.gain * wrong - 1.0).abs() < 0.004, "{input:?} for {wrong}");
    }
    assert!(now.channels[1].backend.serial.inputs.v3.gain - 1.0 < 0.002);
    let measured = left.measured.as_deref().expect("a date");
    assert!(measured.contains("UTC") && measured.contains("11.9 Ω"), "{measured}");

    // what was corrected is right the next time, and stays as it is
    let again =
        bring_up(&rig, &wrong, &["--from", "stages", "--channel", "left", "--supply-meter", "6.5", "--dummy", "11.9"]);
    assert_eq!(again.code, Some(0), "{}", again.said);
    let then = sinew_rig::Rig::load(&rig.path()).expect("a rig file").channels[0].backend.serial.inputs;
    assert!((then.v3.gain - left.inputs.v3.gain).abs() < 0.002, "{then:?} {left:?}");
}

#[test]
fn nobody_at_the_bench_ends_it_with_outputs_at_zero() {
    let rig = bench();
    let mut command = Command::new(front_end());
    command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args(["--for", "300", "--mount", "nothing"]);
    let mut board = Process::start_to_be_told(&mut command);
    board.wait_for_word("\"event\":\"port\"");
    let mut command = Command::new(sinew());
    command.arg("bringup").arg(rig.path()).env("SINEW_STATE_DIR", rig.file("state"));
    let mut bench = Process::start_to_be_told(&mut command);
    bench.wait_for_word("[supply]");
    bench.signal(libc::SIGINT);
    let ended = bench.finish();
    assert_eq!(ended.code, Some(1), "{}{}", ended.stdout, ended.stderr);
    assert!(ended.stderr.contains("outputs are at zero"), "{}", ended.stderr);
    board.tell("quit");
    let board = board.finish();
    let last = board.stdout.lines().rfind(|line| line.contains("\"off\"") || line.contains("\"running\""));
    assert!(last.is_some_and(|last| last.contains("\"off\"")), "{}", board.stdout);
}

#[test]
fn what_cannot_be_brought_up_is_refused_with_what_to_do() {
    let simulated = Rig::bench(&["wire"], "");
    let refused = sinew_tests::run(["bringup", simulated.path().to_str().expect("text")]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("simulated") && refused.stderr.contains("sinew-front-end"), "{}", refused.stderr);
    let rig = bench();
    let path = rig.path();
    let refused = sinew_tests::run(["bringup", path.to_str().expect("text"), "--channel", "lefft"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("did you mean \"left\"?"), "{}", refused.stderr);
}
