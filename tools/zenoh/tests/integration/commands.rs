//! Commands: who may, what becomes of them, and what becomes of wires whose commander is gone.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde_json::json;
use sinew_ipc::{Client, Mode};
use sinew_tests::{Driver, PATIENCE, Process, Rig, SENSING_DUTY, wait_until};
use zenoh::Wait;

use crate::world::{Anna, bridge, certificates, config, cycle, json_of, next, query, run, session_of, subscribe};

/// A bridge that `anna` may command, with a certificate for `bert` besides.
struct Bench {
    driver: Driver,
    client: Client,
    bridge: Process,
    endpoint: String,
    folder: PathBuf,
    rig: Rig,
}

impl Bench {
    #[track_caller]
    fn new() -> Bench {
        let rig = Rig::bench(&["left", "right"], "");
        let folder = certificates(&rig, "keys", &["anna", "bert"]);
        let (driver, client) = Driver::ready(&rig);
        let path = folder.to_str().expect("a plain path").to_string();
        let (bridge, endpoint) = bridge(&rig, &["--certificates", &path, "--commander", "anna"]);
        assert!(endpoint.starts_with("quic/"), "{endpoint}");
        Bench { driver, client, bridge, endpoint, folder, rig }
    }

    /// Anna, declared alive.
    #[track_caller]
    fn anna(&self) -> Anna {
        let mut anna = Anna::connect(&self.rig, &self.endpoint, &self.folder);
        anna.come();
        anna
    }

    fn at(&self, place: &str) -> String {
        format!("sinew/{}/{place}", self.rig.name)
    }

    fn mode(&self, channel: usize) -> Mode {
        self.client.latest().channels()[channel].mode()
    }

    fn duty(&self, channel: usize) -> f64 {
        self.client.latest().channels()[channel].duty
    }

    /// Waits until the wire has no power; how it came to that.
    #[track_caller]
    fn off(&self, channel: usize) -> Mode {
        wait_until("no power", || self.mode(channel) != Mode::Duty && self.mode(channel) != Mode::Length);
        wait_until("no duty", || self.duty(channel) <= SENSING_DUTY);
        self.mode(channel)
    }

    /// The program of another process that holds the left wire at a stroke, and is seen to.
    #[track_caller]
    fn commander(&self) -> Process {
        let folder = Path::new(env!("CARGO_BIN_EXE_sinew-zenoh")).parent().expect("it lies in a folder");
        let mut command = Command::new(folder.join("examples/commander"));
        command.arg(&self.rig.name).arg(&self.endpoint).arg(&self.folder).args(["anna", "left", "0.5"]);
        let mut commander = Process::start(&mut command);
        commander.wait_for_word("cycle");
        wait_until("a wire that is heated", || self.mode(0) == Mode::Length && self.duty(0) > SENSING_DUTY);
        commander
    }
}

#[test]
fn without_certificates_there_are_no_commands() {
    let rig = Rig::bench(&["left"], "");
    let refused = run(&["--rig", &rig.name, "--commander", "anna"]);
    refused.refused(&["over TLS alone", "sinew-zenoh certificates FOLDER anna", "--certificates"]);
    let nowhere = rig.file("nowhere");
    let path = nowhere.to_str().expect("a plain path");
    run(&["--rig", &rig.name, "--commander", "anna", "--certificates", path])
        .refused(&["authority.pem", "sinew-zenoh certificates"]);
    run(&["--rig", &rig.name, "--commander", "a/*", "--certificates", path]).refused(&["a/*", "no name"]);
}

#[test]
fn a_commander_moves_wires_by_the_names_and_refusals_of_the_client() {
    let bench = Bench::new();
    let mut anna = Anna::connect(&bench.rig, &bench.endpoint, &bench.folder);
    // nobody would see her go
    let refused = anna.duty("left", 0.1, 1.0).expect_err("not declared alive");
    assert!(refused["remedy"].as_str().is_some_and(|remedy| remedy.contains("/commander/anna/alive")), "{refused}");
    assert_eq!(bench.client.loop_stats().commands, 0);
    anna.come();
    let done = anna.duty("left", 0.1, 2.0).expect("she may");
    assert_eq!(done["hold_s"], 2.0);
    let cycle = done["cycle"].as_u64().expect("a number");
    assert!(cycle > 0 && cycle <= bench.client.latest().cycle);
    wait_until("the duty", || bench.duty(0) == 0.1);
    assert_eq!(bench.mode(1), Mode::Off);

    // together, and off
    let pose = json!([
        { "channel": "left", "kind": "stroke", "value": 0.2 },
        { "channel": "right", "kind": "stroke", "value": 0.3 },
    ]);
    anna.ask(json!({ "call": "set_many", "wanted": pose, "hold_s": 2.0 })).expect("both may be moved");
    wait_until("both", || [0, 1].map(|channel| bench.mode(channel)) == [Mode::Length; 2]);
    anna.ask(json!({ "call": "off", "channel": "left" })).expect("it may be put off");
    assert_eq!(bench.off(0), Mode::Off);
    anna.ask(json!({ "call": "claim", "channels": ["right"], "priority": 3, "hold_s": 2.0 })).expect("nobody else has");
    wait_until("her claim", || bench.client.latest().channels()[1].owner == bench.bridge.pid());
    let refused = bench.client.set_duty("right", 0.1, Duration::from_secs(1)).expect_err("it is hers");
    assert!(refused.message().contains("claimed"), "{}", refused.message());
    anna.ask(json!({ "call": "release", "channels": ["right"] })).expect("hers");
    anna.ask(json!({ "call": "all_off" })).expect("it may be put off");
    assert_eq!(bench.off(1), Mode::Off);

    // the driver's refusals and our own, with remedies; nothing moves
    for (request, word) in [
        (json!({ "call": "set", "channel": "lft", "kind": "duty", "value": 0.1 }), "lft"),
        (json!({ "call": "set", "channel": "left", "kind": "duty", "value": 7.0 }), "left"),
        (json!({ "call": "set", "channel": "left", "kind": "duty", "value": 0.1, "hold_s": 60.0 }), "hold"),
        (json!({ "call": "set", "channel": "left", "kind": "warmth", "value": 0.1 }), "no request"),
        (json!({ "call": "set_many", "wanted": [] }), "channels"),
        (json!("nonsense"), "no request"),
    ] {
        let refused = anna.ask(request.clone()).expect_err("no such thing");
        let says = |key: &str| refused[key].as_str().expect("text").to_string();
        assert!(says("message").contains(word) && !says("remedy").is_empty(), "{request}: {refused}");
    }
    assert_eq!([0, 1].map(|channel| bench.mode(channel)), [Mode::Off; 2]);
    let commands = &json_of(&anna.session, &bench.at("bridge"))["commands"];
    assert!(commands["not_alive"] == 1 && commands["refused"].as_u64() >= Some(6), "{commands}");

    // in force to the last: the bridge's end is hers
    anna.duty("left", 0.1, 3.0).expect("she may");
    wait_until("the duty", || bench.duty(0) == 0.1);
    bench.bridge.signal(libc::SIGTERM);
    assert_eq!(bench.off(0), Mode::Off, "put off, long before the lease is over");
    bench.bridge.finish().expect(0);
    bench.driver.stop();
}

#[test]
fn without_the_right_certificate_nothing_commands() {
    let bench = Bench::new();
    // bert may look, and no more
    let bert = session_of(&bench.endpoint, &bench.folder, "bert");
    cycle(&next(&subscribe(&bert, &bench.at("cycles"))));
    let _alive = bert.liveliness().declare_token(bench.at("commander/anna/alive")).wait().expect("he may try");
    let ask = json!({ "call": "set", "channel": "left", "kind": "duty", "value": 0.1 });
    for place in ["commander/anna/command", "commander/bert/command", "commander/*/command", "**"] {
        let answer = query(&bert, &bench.at(place), Some(ask.clone()), Duration::from_secs(1));
        assert!(!matches!(answer, Some(Ok(_))), "{place}: {answer:?}");
    }
    assert_eq!(json_of(&bert, &bench.at("bridge"))["commanders"], json!([]), "and passes for nobody");

    // another authority's anna, somebody without a certificate, and one in the clear are not let in at all
    let other = certificates(&bench.rig, "other", &["anna"]);
    std::fs::copy(bench.folder.join("authority.pem"), other.join("authority.pem")).expect("ours");
    let clear = bench.endpoint.replace("quic/", "tcp/");
    // the bridge's own certificate is none of a client
    for (endpoint, certificate) in [
        (&bench.endpoint, Some((other.as_path(), "anna"))),
        (&bench.endpoint, Some((bench.folder.as_path(), ""))),
        (&bench.endpoint, Some((bench.folder.as_path(), "bridge"))),
        (&clear, None),
    ] {
        let mut config = config(endpoint, certificate);
        config.insert_json5("connect/timeout_ms", "2000").expect("a setting");
        // with TLS 1.3 a client may hear of its refusal only when it says something
        if let Ok(session) = zenoh::open(config).wait() {
            let answer = query(&session, &bench.at("info"), None, Duration::from_secs(2));
            assert!(!matches!(answer, Some(Ok(_))), "{certificate:?}: {answer:?}");
        }
    }
    assert_eq!((bench.mode(0), bench.client.loop_stats().commands), (Mode::Off, 0));
    // while anna goes on as she is used to
    bench.anna().duty("left", 0.1, 3.0).expect("she may");
    wait_until("the duty", || bench.duty(0) == 0.1);
    bench.bridge.kill();
    bench.driver.stop();
}

#[test]
fn wires_of_a_commander_that_is_killed_are_put_off_at_once() {
    let bench = Bench::new();
    let commander = bench.commander();
    commander.kill();
    // by an off, not by the end of the lease: that is another mode
    assert_eq!(bench.off(0), Mode::Off);
    // as by one who leaves, though her session goes on
    let mut anna = bench.anna();
    anna.duty("right", 0.1, 3.0).expect("she may");
    wait_until("the duty", || bench.duty(1) == 0.1);
    anna.alive = None;
    assert_eq!(bench.off(1), Mode::Off);
    assert!(anna.duty("right", 0.1, 3.0).is_err(), "she is not there");
    assert_eq!(json_of(&anna.session, &bench.at("bridge"))["commands"]["put_off"], 2);
    bench.bridge.kill();
    bench.driver.stop();
}

#[test]
fn leases_run_out_where_the_link_is_silent_or_the_bridge_is_killed() {
    let bench = Bench::new();
    let commander = bench.commander();
    // its link stays open; Zenoh sees after a second that nothing comes, or the lease of three is over
    commander.signal(libc::SIGSTOP);
    assert!([Mode::Off, Mode::Lapsed].contains(&bench.off(0)));
    commander.kill();

    let anna = bench.anna();
    anna.duty("left", 0.1, 3.0).expect("she may");
    wait_until("the duty", || bench.duty(0) == 0.1);
    bench.bridge.signal(libc::SIGKILL);
    assert_eq!(bench.off(0), Mode::Lapsed, "nobody is left to put it off");
    bench.driver.stop();
}

#[test]
fn commands_are_bounded_and_what_switches_off_is_not() {
    let bench = Bench::new();
    let anna = bench.anna();
    anna.duty("left", 0.1, 3.0).expect("she may");
    let ask = json!({ "call": "set", "channel": "left", "kind": "duty", "value": 0.1, "hold_s": 3.0 }).to_string();
    let key = bench.at("commander/anna/command");
    let replies: Vec<_> =
        (0..2000).map(|_| anna.session.get(&key).payload(ask.clone()).timeout(PATIENCE).wait()).collect();
    let (mut taken, mut refused) = (0, 0);
    for reply in replies {
        match reply.expect("it can be asked").recv().expect("each is answered").into_result() {
            Ok(_) => taken += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 0 && taken + refused == 2000, "{taken} taken, {refused} refused");
    let commands = &json_of(&anna.session, &bench.at("bridge"))["commands"];
    let count = |key: &str| commands[key].as_u64().expect("a figure");
    // on a busy machine some wait for too long, or the driver's answer does; the one before them was taken
    let all_refused = count("too_many") + count("late") + count("refused");
    assert!(count("taken") == taken + 1 && all_refused >= refused, "{taken} taken, {refused} refused: {commands}");
    assert!(count("too_many") > 0, "{commands}");
    for _ in 0..300 {
        anna.ask(json!({ "call": "off", "channel": "left" })).expect("always");
    }
    assert_eq!(bench.off(0), Mode::Off);
    bench.bridge.kill();
    bench.driver.stop();
}
