//! State and streams: what a subscriber gets, what it can count, and what it cannot do.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sinew_ipc::ChannelState;
use sinew_tests::{Driver, PATIENCE, Rig, wait_for, wait_until};
use zenoh::Wait;

use crate::world::{as_the_client_has_them, bridge, cycle, json_of, next, number, query, session, subscribe};

#[test]
fn a_subscriber_gets_every_cycle_bit_by_bit_and_follows_the_driver_through_a_restart() {
    let rig = Rig::bench(&["left", "right"], "");
    let (bridge, endpoint) = bridge(&rig, &[]);
    let session = session(&endpoint);
    let at = |place: &str| format!("sinew/{}/{place}", rig.name);
    // before there is a driver
    assert_eq!(json_of(&session, &at("info"))["state"], "gone");
    let refused =
        query(&session, &at("cycles"), None, PATIENCE).expect("an answer").expect_err("there is nothing to tell");
    assert!(refused.contains(&rig.name), "{refused}");

    let cycles = subscribe(&session, &at("cycles"));
    let infos = subscribe(&session, &at("info"));
    let (driver, client) = Driver::ready(&rig);
    let theirs = as_the_client_has_them(&client, 500);
    let first = next(&cycles);
    assert_eq!(first.encoding().to_string(), "application/cdr;sinew_msgs/msg/Cycle");
    let (mut before, mut place) = (cycle(&first).0, number(&first).0);
    let mut compared = 0;
    while compared < 250 {
        let sample = next(&cycles);
        let ((cycle, bytes), (number, _)) = (cycle(&sample), number(&sample));
        // all of them; and on a machine that is too busy it is said to the last one how many are missing
        assert_eq!(cycle - before, number - place);
        (before, place) = (cycle, number);
        if let Some(known) = theirs.get(&cycle) {
            assert_eq!(&bytes, known, "cycle {cycle}");
            compared += 1;
        }
    }
    let now_ns =
        std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
    assert!(now_ns.abs_diff(number(&next(&cycles)).1) < PATIENCE.as_nanos() as u64, "the time of day");

    // what does not change, with schemas by which any reader of ROS 2 messages understands the cycles
    let info = json_of(&session, &at("info"));
    assert_eq!(
        (&info["state"], &info["pid"], &info["simulated"]),
        (&json!("running"), &json!(driver.pid()), &json!(true))
    );
    assert_eq!(info["channels"][1]["max_duty"], client.channels()[1].max_duty);
    assert_eq!(info["fields"].as_array().map(Vec::len), Some(ChannelState::FIELDS.len()));
    assert!(info["topics"][0]["ros2msg"].as_str().is_some_and(|text| text.contains("sinew_msgs/Channel right")));
    wait_until("word of the driver", || {
        let said: Value = serde_json::from_slice(&next(&infos).payload().to_bytes()).expect("JSON");
        said["state"] == "running"
    });

    // the latest, to whoever asks; of a channel, of all
    let latest = query(&session, &at("cycles"), None, PATIENCE).expect("an answer").expect("a cycle");
    assert!(u64::from_le_bytes(latest[4..12].try_into().expect("eight bytes")) >= before);
    assert!(query(&session, &at("loop"), None, PATIENCE).expect("an answer").expect("figures").len() > 100);
    let left = json_of(&session, &at("channel/left"));
    assert_eq!((&left["name"], &left["mode"], &left["fault"]), (&json!("left"), &json!("off"), &Value::Null));
    let found = left["length_m"].as_f64().expect("a length");
    assert!((found - client.latest().channels()[0].length_m).abs() < 1e-3, "{left}");
    let all = session.get(at("channel/*")).wait().expect("it can be asked");
    assert_eq!(all.iter().filter(|reply| reply.result().is_ok()).count(), 2);
    let right = subscribe(&session, &at("channel/right"));
    let (one, two) = (next(&right), next(&right));
    assert_eq!(number(&two).0, number(&one).0 + 1);

    driver.stop();
    wait_until("word that it is gone", || json_of(&session, &at("info"))["state"] == "gone");
    let (driver, client) = Driver::ready(&rig);
    let theirs = as_the_client_has_them(&client, 100);
    wait_for("cycles of the next driver", || {
        let (number, bytes) = cycle(&next(&cycles));
        theirs.get(&number).filter(|known| **known == bytes).map(drop)
    });
    bridge.signal(libc::SIGTERM);
    let finished = bridge.finish().expect(0);
    assert!(finished.stderr.contains(" 0 cycles lost on the way from the driver"), "{finished:?}");
    driver.stop();
}

#[test]
fn a_slow_subscriber_counts_what_it_loses_and_nobody_waits_for_it() {
    // large messages, so that what sockets hold is full soon
    let names: Vec<String> = (0..32).map(|number| format!("wire{number}")).collect();
    let rig = Rig::bench(&names.iter().map(String::as_str).collect::<Vec<_>>(), "");
    let driver = Driver::start(&rig);
    let (bridge, endpoint) = bridge(&rig, &[]);
    let key = format!("sinew/{}/cycles", rig.name);
    let (slow, fast) = (session(&endpoint), session(&endpoint));
    let (told, heard) = std::sync::mpsc::channel();
    let (mut before, mut lost) = (None, 0);
    let count = move |sample: zenoh::sample::Sample| {
        let (number, _) = number(&sample);
        if let Some(before) = before.replace(number) {
            lost += number - before - 1;
        }
        if lost == 0 {
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = told.send(lost);
    };
    let _slow = slow.declare_subscriber(key.clone()).callback_mut(count).wait().expect("a subscription");
    let fast = subscribe(&fast, &key);
    // the other one goes on meanwhile, and afterwards
    let end = Instant::now() + PATIENCE;
    let mut before = number(&next(&fast)).0;
    let (mut received, mut fast_lost) = (0_u64, 0);
    let mut fast_goes_on = || {
        let number = number(&next(&fast)).0;
        fast_lost += number - before - 1;
        received += 1;
        before = number;
    };
    while heard.try_iter().last().is_none_or(|lost| lost == 0) {
        assert!(Instant::now() < end, "nothing is lost");
        fast_goes_on();
    }
    (0..200).for_each(|_| fast_goes_on());
    assert!(
        fast_lost < received,
        "one that keeps up gets most, also on a busy machine: {received} and not {fast_lost}"
    );
    bridge.signal(libc::SIGTERM);
    let finished = bridge.finish().expect(0);
    assert!(finished.stderr.contains(" 0 cycles lost on the way from the driver"), "{finished:?}");
    driver.stop();
}

#[test]
fn nobody_passes_for_the_driver_by_way_of_a_bridge() {
    let rig = Rig::bench(&["left"], "");
    let (driver, client) = Driver::ready(&rig);
    let (bridge, endpoint) = bridge(&rig, &["--rate", "20"]);
    let (liar, looker) = (session(&endpoint), session(&endpoint));
    let key = format!("sinew/{}/cycles", rig.name);
    let cycles = subscribe(&looker, &key);
    let from = next(&cycles);
    let queryable = liar.declare_queryable(key.clone()).callback(|query| {
        drop(query.reply(query.key_expr().clone(), "lies").wait());
    });
    let _queryable = queryable.wait().expect("it may try");
    for _ in 0..50 {
        liar.put(key.clone(), "lies").wait().expect("it may try");
        let answer = query(&looker, &key, None, PATIENCE).expect("an answer").expect("a cycle");
        assert_ne!(answer, b"lies");
    }
    // at the rate that was asked for, and nothing else among them
    let samples: Vec<_> = (0..20).map(|_| next(&cycles)).collect();
    assert!(samples.iter().all(|sample| sample.payload().len() == 28 + size_of::<ChannelState>()));
    let hz = 20.0 / ((number(&samples[19]).1 - number(&from).1) as f64 * 1e-9);
    assert!((15.0..=20.5).contains(&hz), "{hz} cycles a second");

    // there is nothing to command with
    let ask = json!({ "call": "set", "channel": "left", "kind": "duty", "value": 0.1 });
    for place in ["commander/anna/command", "commander/*/command", "**", "command"] {
        let key = format!("sinew/{}/{place}", rig.name);
        let answer = query(&looker, &key, Some(ask.clone()), Duration::from_secs(1));
        assert!(!matches!(answer, Some(Ok(_))), "{place}: {answer:?}");
    }
    assert_eq!(client.latest().channels()[0].mode(), sinew_ipc::Mode::Off);
    assert_eq!(client.loop_stats().commands, 0);
    bridge.kill();
    driver.stop();
}
