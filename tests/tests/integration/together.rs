//! Setpoints for several channels in one request: in force from the same cycle on, or not at all. And as a stream that nobody waits for.

use std::process::Command;
use std::time::{Duration, Instant};

use sinew_ipc::{ChannelState, Client, CommandKind, Error, Mode, Progress, Reason, SetpointOptions, Setpoints, Wanted};
use sinew_tests::{Driver, PATIENCE, Process, Rig, sinew, wait_for, wait_until};

const LONG: Duration = Duration::from_secs(120);

fn stroke(channel: u32, value: f64) -> Wanted {
    Wanted { channel, kind: CommandKind::Stroke, value }
}

/// The cycles from this one on, up to `last`, channel by channel.
fn cycles(client: &Client, from: u64, last: u64, mut stream: sinew_ipc::CycleStream) -> Vec<(u64, Vec<ChannelState>)> {
    let mut found = Vec::new();
    wait_for("the cycle it took force in", || {
        while let Some(cycle) = stream.next().unwrap() {
            if cycle.header.cycle >= from {
                found.push((cycle.header.cycle, cycle.channels.to_vec()));
            }
        }
        (found.last()?.0 >= last).then_some(())
    });
    assert_eq!(stream.lost(), 0, "{}", client.channels().len());
    found
}

#[test]
fn several_channels_obey_from_the_cycle_on_that_the_answer_names() {
    let rig = Rig::bench(&["a", "b", "c"], "");
    let (driver, client) = Driver::ready(&rig);
    let stream = client.stream().unwrap();
    let from = client.latest().cycle + 1;
    let duty = Wanted { channel: 2, kind: CommandKind::Duty, value: 0.05 };
    let taken = client.set_many(&[stroke(1, 0.4), duty, stroke(0, 0.2)], LONG).unwrap();
    assert_eq!(taken.hold_s, 120.0);
    assert!(taken.cycle >= from, "{taken:?}");
    for (number, channels) in cycles(&client, from, taken.cycle, stream) {
        let modes: Vec<Mode> = channels.iter().map(ChannelState::mode).collect();
        let expected = if number < taken.cycle { [Mode::Off; 3] } else { [Mode::Length, Mode::Length, Mode::Duty] };
        assert_eq!(modes, expected, "cycle {number}, taken {taken:?}");
        assert_eq!(channels[0].order().is_some(), number == taken.cycle, "a recording has it in that cycle");
        if number == taken.cycle {
            assert!(channels.iter().all(|state| (state.lease_s - 120.0).abs() < 1e-6), "one lease: {channels:?}");
        }
    }
    // An off beside setpoints does not run out with them.
    let off = Wanted { channel: 2, kind: CommandKind::Off, value: 0.0 };
    client.set_many(&[stroke(0, 0.3), off], LONG).unwrap();
    let state = client.latest();
    assert_eq!((state.channels()[0].mode(), state.channels()[2].mode()), (Mode::Length, Mode::Off));
    driver.stop();
}

#[test]
fn where_one_is_refused_none_is_carried_out_and_each_says_why() {
    let rig = Rig::bench(&["a", "b", "c"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("c", 0.1, LONG).unwrap();
    let before = client.latest().channels()[2].target_m;
    let refused = |wanted: &[Wanted]| match client.set_many(wanted, LONG) {
        Err(Error::RefusedTogether(refusals)) => {
            refusals.into_iter().map(|refusal| (refusal.channel, refusal.reason)).collect::<Vec<_>>()
        }
        other => panic!("{other:?}"),
    };
    let range = Reason::OutOfRange { low: 0.0, high: 1.0 };
    let found = refused(&[stroke(0, 0.4), stroke(1, 1.4), stroke(2, 0.5), stroke(7, 0.1)]);
    assert_eq!(found, [("b".into(), range), ("number 7".into(), Reason::UnknownChannel)]);
    assert_eq!(refused(&[stroke(0, 0.4), stroke(0, 0.5)]), [("a".into(), Reason::NotTogether)]);
    let reset = Wanted { channel: 1, kind: CommandKind::Reset, value: 0.0 };
    assert_eq!(refused(&[stroke(0, 0.4), reset]), [("b".into(), Reason::NotTogether)]);
    let found = refused(&[stroke(0, 0.4), stroke(1, f64::NAN)]);
    assert_eq!(found, [("b".into(), Reason::NotFinite)]);
    assert!(matches!(client.set_many(&[], LONG), Err(Error::Channels { found: 0 })));
    assert!(matches!(client.set_many(&[stroke(0, 0.1); 65], LONG), Err(Error::Channels { found: 65 })));
    let state = client.latest();
    assert_eq!((state.channels()[0].mode(), state.channels()[2].target_m), (Mode::Off, before), "nothing of it");
    driver.stop();
}

#[test]
fn the_command_line_takes_turns_of_names_and_setpoints() {
    // Whatever they are called.
    let rig = Rig::bench(&["stroke", "off", "duty"], "");
    let (driver, client) = Driver::ready(&rig);
    let said = rig.ask(&["set", "stroke", "stroke=40%", "off", "stroke=2mm", "duty", "duty=0.1"]).expect(0).stdout;
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    assert!(lines[0].starts_with("stroke: stroke 40.0 % (") && lines[0].ends_with("for 10 s"), "{said}");
    let state = client.latest();
    let [a, b, c] = [0, 1, 2].map(|channel| (state.channels()[channel], client.channels()[channel]));
    assert!((a.0.target_m - a.1.length_at_stroke(0.4)).abs() < 1e-9);
    assert!((b.0.target_m - (b.1.cold_length_m - 0.002)).abs() < 1e-9, "{b:?}");
    assert_eq!((c.0.mode(), c.0.duty), (Mode::Duty, 0.1));
    rig.ask(&["set", "stroke", "off", "off", "off"]).expect(0);
    let modes: Vec<Mode> = client.latest().channels().iter().map(ChannelState::mode).collect();
    assert_eq!(modes, [Mode::Off, Mode::Off, Mode::Duty]);

    rig.ask(&["set", "stroke", "stroke=40%", "off"]).refused(&["off", "setpoint"]);
    rig.ask(&["set", "stroke", "stroke=40%", "off", "length=900mm"]).refused(&["off", "900"]);
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off, "all or none");
    driver.stop();
}

#[test]
fn a_file_is_played_row_by_row_and_leaves_its_channels_off() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, client) = Driver::ready(&rig);
    let file = rig.file("wave.csv");
    std::fs::write(&file, "time_s,b,a\n0,10%,\n2.5,duty=0.05,20%\n5,,off\n").unwrap();
    let path = file.to_str().unwrap();
    let mut stream = client.stream().unwrap();
    // Leases that are shorter than the rows: they are renewed.
    let mut play = Command::new(sinew());
    play.args(["play", path, "--hold", "1.5", "--times", "2", "--rig", &rig.name]);
    let mut play = Process::start(&mut play);
    let mut modes: Vec<[Mode; 2]> = Vec::new();
    let end = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < end, "{modes:?}");
        let has_ended = play.ended().is_some();
        while let Some(cycle) = stream.next().unwrap() {
            let now = [cycle.channels[0].mode(), cycle.channels[1].mode()];
            if modes.last() != Some(&now) {
                modes.push(now);
            }
        }
        // what is off at its end has been published a little later
        if has_ended && modes.last() == Some(&[Mode::Off; 2]) {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(stream.lost(), 0);
    let said = play.finish().expect(0).stdout;
    assert!(said.starts_with("played 6 rows"), "{said}");
    let once = [[Mode::Off, Mode::Length], [Mode::Length, Mode::Duty], [Mode::Off, Mode::Duty]];
    let all = [&[[Mode::Off; 2]], &once[..], &once[..], &[[Mode::Off; 2]]].concat();
    assert_eq!(modes, all, "in between no lease ran out");

    std::fs::write(&file, "time_s,a\n0,10%\n1,140%\n").unwrap();
    rig.ask(&["play", path]).refused(&["wave.csv:3", "140"]);
    std::fs::write(&file, "time_s,elbow\n0,10%\n").unwrap();
    rig.ask(&["play", path]).refused(&["elbow", "wave.csv"]);
    std::fs::write(&file, "time_s,a\n0,10%\n0.1,length=900mm\n").unwrap();
    rig.ask(&["play", path]).refused(&["a: length", "900"]);
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off, "what it began it ended");
    driver.stop();
}

#[test]
fn a_claimed_channel_is_its_owners_alone_and_goes_to_a_higher_priority() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, owner) = Driver::ready(&rig);
    let other = rig.client();
    let (pid, hold) = (std::process::id(), Duration::from_secs(60));
    owner.claim(&[0], 5, hold).unwrap();
    owner.set_stroke("a", 0.3, LONG).unwrap();
    let reason = |asked: Result<sinew_ipc::Reply, Error>| match asked {
        Err(Error::Refused(refusal)) => refusal.reason,
        other => panic!("{other:?}"),
    };
    let is_claimed =
        |reason, wanted| matches!(reason, Reason::Claimed { owner, priority, .. } if (owner, priority) == wanted);
    assert!(is_claimed(reason(other.set_stroke("a", 0.1, LONG)), (pid, 5)));
    assert!(is_claimed(reason(other.reset("a")), (pid, 5)));
    let together = other.set_many(&[stroke(0, 0.1), stroke(1, 0.1)], LONG);
    assert!(
        matches!(&together, Err(Error::RefusedTogether(all)) if all.len() == 1 && all[0].channel == "a"),
        "{together:?}"
    );
    assert_eq!(other.latest().channels()[1].mode(), Mode::Off, "none of it");
    assert!(matches!(other.claim(&[1, 0], 5, hold), Err(Error::RefusedTogether(_))), "not without a higher priority");
    other.set_stroke("b", 0.1, LONG).unwrap();

    // It is published, and said.
    wait_until("it is published", || {
        let state = owner.latest();
        state.channels().iter().map(|channel| (channel.owner, channel.priority)).eq([(pid, 5), (0, 0)])
    });
    let said = rig.ask(&["status"]).expect(0).stdout;
    assert!(said.contains(&format!("a: claimed by process {pid} (")), "{said}");
    let refused = rig.ask(&["set", "a", "stroke=10%"]).expect(1);
    assert!(refused.stderr.contains(&format!("claimed by process {pid} with priority 5")), "{refused:?}");

    // Switching off is everybody's, and leaves the claim as it is.
    rig.ask(&["set", "a", "off"]).expect(0);
    assert_eq!(owner.latest().channels()[0].mode(), Mode::Off);
    assert!(is_claimed(reason(other.set_stroke("a", 0.1, LONG)), (pid, 5)));

    // Taken over, which the loser is told; then let go of.
    other.claim(&[0], 6, hold).unwrap();
    assert!(is_claimed(reason(owner.set_stroke("a", 0.3, LONG)), (pid, 6)));
    owner.release(&[0]).unwrap();
    assert!(is_claimed(reason(owner.set_stroke("a", 0.3, LONG)), (pid, 6)), "it was not its own");
    other.release(&[0]).unwrap();
    owner.set_stroke("a", 0.3, LONG).unwrap();

    // One of a client that says nothing more lapses; every word of its owner renews it.
    let short = Duration::from_secs(2);
    other.claim(&[0], 9, short).unwrap();
    let since = std::time::Instant::now();
    let mut spoken = std::time::Instant::now();
    while since.elapsed() < 2 * short {
        spoken = std::time::Instant::now();
        other.set_stroke("a", 0.2, LONG).unwrap();
        std::thread::sleep(short / 20);
    }
    wait_until("it has lapsed", || owner.set_stroke("a", 0.3, LONG).is_ok());
    assert!(spoken.elapsed() > short / 2, "it was held for {:?} after its owner's last word", spoken.elapsed());

    // What cannot be is refused.
    for (asked, words) in [
        (owner.claim(&[0], 10, hold), "outside"),
        (owner.claim(&[7], 5, hold), "no channel"),
        (owner.claim(&[0, 0], 5, hold), "twice"),
        (owner.claim(&[0], 5, Duration::from_secs(1_000_000)), "hold is outside"),
        (owner.claim(&[], 5, hold), "0 channels"),
    ] {
        let error = asked.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let mixed = [stroke(0, 0.1), Wanted { channel: 1, kind: CommandKind::Claim, value: 5.0 }];
    assert!(owner.set_many(&mixed, LONG).unwrap_err().to_string().contains("beside something else"));

    // A program that is killed loses its channels with its claim; the file that is played has them to itself meanwhile.
    let file = rig.file("long.csv");
    std::fs::write(&file, "time_s,a\n0,10%\n600,off\n").unwrap();
    let mut play = std::process::Command::new(sinew_tests::sinew());
    play.args(["play", file.to_str().unwrap(), "--priority", "5", "--hold", "0.5", "--rig", &rig.name]);
    let player = sinew_tests::Process::start(&mut play);
    wait_until("it plays", || owner.latest().channels()[0].owner == player.pid());
    assert!(is_claimed(reason(owner.set_stroke("a", 0.3, LONG)), (player.pid(), 5)));
    player.kill();
    wait_until("it has lapsed", || owner.set_stroke("a", 0.3, LONG).is_ok());
    driver.stop();
}

/// Strokes for all channels.
fn strokes(strokes: &[f64]) -> Vec<Wanted> {
    (0..).zip(strokes).map(|(channel, stroke)| Wanted { channel, kind: CommandKind::Stroke, value: *stroke }).collect()
}

/// Looks for answers until nothing is on its way.
#[track_caller]
fn settled(setpoints: &mut Setpoints<&Client>) -> Progress {
    wait_for("every message's answer", || {
        let progress = setpoints.poll().expect("nothing is refused");
        let Progress { sent, taken, overtaken, late, refused, held_back, .. } = progress;
        (taken + overtaken + late + refused + held_back == sent).then_some(progress)
    })
}

#[test]
fn of_a_stream_of_setpoints_the_newest_is_in_force_and_none_is_lost_without_a_word() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, client) = Driver::ready(&rig);
    let mut setpoints = client.setpoints(SetpointOptions { hold: LONG, within: None, ..SetpointOptions::default() });
    for message in 0..500 {
        let stroke = 0.1 + 0.3 * f64::from(message) / 499.0;
        setpoints.send(&strokes(&[stroke, 0.5 - stroke])).unwrap();
    }
    let last = settled(&mut setpoints);
    assert_eq!((last.sent, last.late, last.refused), (500, 0, 0), "{last:?}");
    assert!(last.taken >= 1 && last.taken + last.overtaken + last.held_back == 500, "{last:?}");
    // sent while there was room, it is what holds
    setpoints.send(&strokes(&[0.25, 0.35])).unwrap();
    let last = settled(&mut setpoints);
    let infos = client.channels();
    let length_m = |channel: usize, stroke: f64| {
        infos[channel].cold_length_m + stroke * (infos[channel].hot_length_m - infos[channel].cold_length_m)
    };
    wait_until("the last one", || {
        let state = client.latest();
        state.cycle >= last.cycle
            && (state.channels()[0].target_m - length_m(0, 0.25)).abs() < 1e-9
            && (state.channels()[1].target_m - length_m(1, 0.35)).abs() < 1e-9
    });
    // an off is obeyed at once, and the stream may go on after it
    client.off("a").unwrap();
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off);
    setpoints.send(&strokes(&[0.2, 0.2])).unwrap();
    settled(&mut setpoints);
    wait_until("the next message", || client.latest().channels()[0].mode() == Mode::Length);
    driver.stop();
}

#[test]
fn what_switches_off_in_a_stream_is_never_late_nor_held_back_nor_overtaken() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, client) = Driver::ready(&rig);
    let options = SetpointOptions { hold: LONG, within: Some(Duration::ZERO), ..SetpointOptions::default() };
    let off = |channel| Wanted { channel, kind: CommandKind::Off, value: 0.0 };
    for round in 0..50 {
        client.set_many(&strokes(&[0.3, 0.3]), LONG).unwrap();
        // One stream is full of messages that are all too late or wait, its off is not; nor what the next message of it takes back.
        let mut setpoints =
            client.setpoints(if round % 2 == 0 { options } else { SetpointOptions { within: None, ..options } });
        for _ in 0..20 {
            setpoints.send(&strokes(&[0.2, 0.2])).unwrap();
        }
        setpoints.send(&[off(0)]).unwrap();
        for _ in 0..20 {
            setpoints.send(&[Wanted { channel: 1, kind: CommandKind::Stroke, value: 0.1 }]).unwrap();
        }
        settled(&mut setpoints);
        assert_eq!(client.latest().channels()[0].mode(), Mode::Off, "round {round}: {:?}", setpoints.progress());
        assert_eq!(client.latest().channels()[1].mode(), Mode::Length, "round {round}");
    }
    driver.stop();
}

#[test]
fn a_message_of_a_stream_that_comes_too_late_or_is_refused_is_told_and_not_carried_out() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, client) = Driver::ready(&rig);
    let options = SetpointOptions { hold: LONG, ..SetpointOptions::default() };
    // nobody gets to it within no time at all
    let mut late = client.setpoints(SetpointOptions { within: Some(Duration::ZERO), ..options });
    late.send(&strokes(&[0.3, 0.3])).unwrap();
    assert_eq!(settled(&mut late), Progress { sent: 1, late: 1, ..Progress::default() });
    assert!(client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off));

    let refused = |setpoints: &mut Setpoints<&Client>| {
        let Error::RefusedTogether(refusals) = wait_for("the refusal", || setpoints.poll().err()) else { panic!() };
        refusals
            .into_iter()
            .map(|refusal| (refusal.channel.clone(), refusal.message(), refusal.remedy()))
            .collect::<Vec<_>>()
    };
    let mut setpoints = client.setpoints(options);
    setpoints.send(&strokes(&[0.3, 1.7])).unwrap();
    let [(channel, ..)] = &refused(&mut setpoints)[..] else { panic!("one channel's reason") };
    assert_eq!((channel.as_str(), setpoints.progress().refused), ("b", 1));
    let mut slow =
        client.setpoints(SetpointOptions { hold: Duration::from_secs(1), over: Duration::from_secs(2), ..options });
    slow.send(&strokes(&[0.3, 0.3])).unwrap();
    let told = refused(&mut slow);
    assert!(told[0].1.contains("outside 0 s to 1 s") && told[0].2.contains("longer hold"), "{told:?}");
    assert!(client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off), "nothing of it all");

    // claimed by somebody else, and gone with the driver
    let owner = rig.client();
    owner.claim(&[0], 5, LONG).unwrap();
    setpoints.send(&strokes(&[0.3, 0.3])).unwrap();
    assert!(refused(&mut setpoints)[0].1.contains("claimed"));
    driver.stop();
    let gone = wait_for("the driver's end", || setpoints.send(&strokes(&[0.3, 0.3])).err());
    assert!(matches!(gone, Error::DriverGone { .. }), "{gone:?}");
}

#[test]
fn a_slow_planner_moves_a_fast_loop_in_a_straight_line() {
    let rig = Rig::bench(&["a", "b"], "");
    let (driver, client) = Driver::ready(&rig);
    let mut stream = client.stream().unwrap();
    let over = Duration::from_millis(400);
    let mut setpoints = client.setpoints(SetpointOptions { hold: LONG, over, within: None });
    setpoints.send(&strokes(&[0.4, 0.0])).unwrap();
    let begun = settled(&mut setpoints).cycle;
    let mut begun_ns = 0;
    // time since it was taken, s, and what is wanted then, m
    let mut way: Vec<(f64, f64)> = Vec::new();
    while way.last().is_none_or(|(at_s, _)| *at_s < over.as_secs_f64() + 0.02) {
        let Some(cycle) = stream.next_within(PATIENCE).unwrap() else { panic!("no cycle comes") };
        if cycle.header.cycle == begun {
            begun_ns = cycle.header.monotonic_ns;
        }
        if begun_ns > 0 {
            let at_s = (cycle.header.monotonic_ns - begun_ns) as f64 * 1e-9;
            way.push((at_s, cycle.channels[0].target_m));
        }
    }
    let (first, last) = (way[0].1, way.last().unwrap().1);
    let info = client.channels()[0];
    assert!((last - (info.cold_length_m + 0.4 * (info.hot_length_m - info.cold_length_m))).abs() < 1e-9);
    assert!((first - info.cold_length_m).abs() < 0.1 * (first - last).abs(), "from where the cold wire is: {first}");
    for (at_s, target_m) in &way {
        let wanted_m = first + (at_s / over.as_secs_f64()).min(1.0) * (last - first);
        assert!((target_m - wanted_m).abs() < 1e-4 * (first - last).abs(), "{at_s} s: {target_m} for {wanted_m}");
    }
    driver.stop();
}
