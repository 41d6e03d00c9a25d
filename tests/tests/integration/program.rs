//! What a rig does while nobody commands it: `program` in its `[rig]`.

use sinew_ipc::{Client, Mode};
use sinew_tests::{Process, Rig, run, wait_for, wait_until};
use std::time::Duration;

/// Two wires with this program.
fn rig(program: &str) -> Rig {
    let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = 500.0\nprogram = \"{program}\"\n"));
    ["a", "b"].iter().for_each(|name| rig.add(&Rig::wire(name)));
    rig
}

fn connected(rig: &Rig) -> Client {
    wait_for("its driver", || Client::connect(&rig.name).ok())
}

fn stroke(client: &Client, channel: usize) -> f64 {
    client.channels()[channel].stroke_at_length(client.latest().channels()[channel].length_m)
}

#[test]
fn steps_move_every_wire_and_a_command_takes_one_over() {
    let rig = rig("steps");
    let driver = Process::start(&mut rig.command(&[]));
    let client = connected(&rig);
    let is_moved =
        |channel: usize| client.latest().channels()[channel].mode() == Mode::Program && stroke(&client, channel) > 0.3;
    wait_until("the first wire is up", || is_moved(0));
    wait_until("the second one is", || is_moved(1));
    wait_until("the first one is down again", || stroke(&client, 0) < 0.2);
    client.off("a").unwrap();
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off);
    assert_eq!(client.latest().channels()[1].mode(), Mode::Program);
    assert!(driver.stderr().contains("up and down in turns"), "it says what it does: {}", driver.stderr());
    rig.ask(&["stop"]).expect(0);
    driver.finish().expect(0);
}

#[test]
fn a_file_beside_the_rig_file_is_played_again_and_again() {
    let rig = rig("wave.csv");
    std::fs::write(rig.file("wave.csv"), "time_s,b\n0,10%\n1,stroke=2mm\n2,\n").unwrap();
    let driver = Process::start(rig.command(&[]).current_dir("/"));
    let client = connected(&rig);
    let target = |client: &Client| {
        let state = client.latest().channels()[1];
        (state.mode() == Mode::Program).then(|| client.channels()[1].stroke_at_length(state.target_m))
    };
    let two_mm = 0.002 / (client.channels()[1].cold_length_m - client.channels()[1].hot_length_m);
    for _ in 0..2 {
        for wanted in [0.1, two_mm] {
            wait_until("the next row", || target(&client).is_some_and(|now| (now - wanted).abs() < 1e-9));
        }
    }
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off, "a wire that is not in it stands still");
    // a command overrides it, and at the end of its lease it goes on
    client.set_stroke("b", 0.3, Duration::from_millis(500)).unwrap();
    assert_eq!(client.latest().channels()[1].mode(), Mode::Length);
    wait_until("it goes on", || target(&client).is_some());
    rig.ask(&["stop"]).expect(0);
    driver.finish().expect(0);
}

#[test]
fn a_program_that_cannot_be_is_refused_with_its_place() {
    let refused = |program: &str, file: Option<&str>, words: &[&str]| {
        let rig = rig(program);
        if let Some(text) = file {
            std::fs::write(rig.file(program), text).unwrap();
        }
        run(["run".as_ref(), rig.path().as_os_str()]).refused(words);
    };
    refused("nowhere.csv", None, &["nowhere.csv", "no file of that name", "beside the rig file"]);
    refused("wlak", None, &["wlak", "did you mean \"walk\"?"]);
    refused("walk", None, &["legs of 3 wires, the rig has 2", "steps"]);
    refused("wave.csv", Some("time_s,c\n0,10%\n"), &["wave.csv", "no channel \"c\""]);
    refused("wave.csv", Some("time_s,a\n0,duty=0.1\n"), &["wave.csv", "a at 0 s", "sinew play"]);
    refused(
        "wave.csv",
        Some("time_s,a\n0,60mm\n"),
        &["wave.csv:2: a: length 60.00 mm is outside", "the nearest is length="],
    );
    refused("wave.csv", Some("time_s,a\n0,140%\n"), &["wave.csv:2", "outside the stroke"]);
}
