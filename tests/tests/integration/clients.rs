//! Clients that are killed, that sleep, and that come in numbers: none of them costs the others anything.

use sinew_ipc::{Client, ClientOptions, Mode};
use sinew_tests::{Driver, Process, RATE_HZ, Rig, SENSING_DUTY, checkout, gait, wait_for, wait_until};
use std::process::Command;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(120);

fn robot(rig: &Rig, task: &[&str]) -> Process {
    Process::start(Command::new(env!("CARGO_BIN_EXE_sinew-test-robot")).arg(&rig.name).args(task))
}

#[test]
fn a_client_killed_in_the_middle_costs_only_its_own_setpoint() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    observer.set_duty("right", 0.1, LONG).unwrap();
    let mut stream = observer.stream().unwrap();
    for round in 0..4 {
        // The others see every cycle, and keep their setpoint. They read all the time: a stream holds two seconds.
        let mut others_go_on = || {
            while let Some(cycle) = stream.next().unwrap() {
                assert_eq!((cycle.channels[1].mode(), cycle.channels[1].duty), (Mode::Duty, 0.1), "round {round}");
            }
        };
        let holder = robot(&rig, &["hold", "left", "0.3", "1.0"]);
        let reader = robot(&rig, &["stream"]);
        wait_until("the setpoint to be seen and the stream to be read", || {
            others_go_on();
            observer.latest().channels()[0].mode() == Mode::Length && reader.stdout().contains("streaming")
        });
        holder.kill();
        reader.kill();
        let left = wait_for("the lease to run out", || {
            others_go_on();
            let left = observer.latest().channels()[0];
            (left.mode() != Mode::Length).then_some(left)
        });
        others_go_on();
        assert_eq!((left.mode(), left.fault()), (Mode::Lapsed, None), "round {round}: {left:?}");
        assert_eq!(left.duty, SENSING_DUTY, "round {round}");
        assert_eq!(stream.lost(), 0, "round {round}");
    }
    let report = driver.stop();
    assert_eq!(report["leases_lapsed"], 4, "{report:#}");
}

#[test]
fn more_clients_may_be_killed_than_may_be_connected_at_once() {
    let rig = Rig::bench(&["left"], "");
    let (driver, observer) = Driver::ready(&rig);
    // A driver serves 64 streams at once. The dead are cleared away now and then: somebody who finds no room for them tries
    // again.
    let mut turned_away = 0;
    let mut reader = || loop {
        let mut reader = robot(&rig, &["stream"]);
        let ended = wait_for("a reader to stream or to be turned away", || match reader.ended() {
            Some(_) => Some(true),
            None => reader.stdout().contains("streaming").then_some(false),
        });
        if !ended {
            return reader;
        }
        let why = reader.finish().expect(1).stderr;
        assert!(why.contains("serves 64 streams at once") || why.contains("serves 256 clients at once"), "{why}");
        turned_away += 1;
        assert!(turned_away < 1000, "nobody clears away the dead");
        std::thread::sleep(Duration::from_millis(20));
    };
    for _ in 0..20 {
        let four = [reader(), reader(), reader(), reader()];
        four.into_iter().for_each(Process::kill);
    }
    let last = reader();
    println!("{turned_away} times there was no room");
    assert!(observer.is_alive());
    driver.stop();
    last.finish().expect(3);
}

/// Clients killed at any time in each call there is, over and over: the others go on, the driver does not notice, and there is room for
/// the next.
#[test]
fn a_client_killed_in_the_middle_of_any_call_is_nobodys_loss() {
    const KILLS: u64 = 20;
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, observer) = Driver::ready(&rig);
    observer.set_duty("right", 0.1, LONG).unwrap();
    let mut stream = observer.stream().unwrap();
    let calls = ["connect", "latest", "stream", "wait", "set", "reset", "off"];
    std::thread::scope(|scope| {
        for (place, call) in (0..).zip(calls) {
            let rig = &rig;
            scope.spawn(move || {
                for kill in 0..KILLS {
                    let mut victim = robot(rig, &["repeat", call, "left"]);
                    victim.wait_for_word("repeating");
                    // Some other time in the call at each kill.
                    std::thread::sleep(Duration::from_micros((place * 37 + kill * 611) % 5000));
                    victim.kill();
                }
            });
        }
    });
    let mut received = 0;
    while let Some(cycle) = stream.next().unwrap() {
        assert_eq!((cycle.channels[1].mode(), cycle.channels[1].duty), (Mode::Duty, 0.1));
        received += 1;
    }
    println!("{} kills, {received} cycles seen meanwhile, {} lost", KILLS * calls.len() as u64, stream.lost());
    // Who comes now finds everything as it should be.
    let next = rig.client();
    next.set_stroke("left", 0.2, Duration::from_secs(1)).unwrap();
    assert!(next.stream().unwrap().next_within(sinew_tests::PATIENCE).unwrap().is_some());
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().map(Vec::len), Some(0), "{report:#}");
}

/// Killed while it asks the driver to stop: the driver has stopped or has not, and in both cases is whole.
#[test]
fn a_client_killed_while_it_stops_the_driver() {
    for delay in 0..4 {
        let rig = Rig::bench(&["left"], "");
        let (driver, observer) = Driver::ready(&rig);
        let mut stopper = Command::new(sinew_tests::sinew());
        let stopper = Process::start(stopper.args(["stop", "--rig", &rig.name]));
        std::thread::sleep(Duration::from_millis(2 * delay));
        stopper.kill();
        if observer.is_alive() {
            driver.process.signal(libc::SIGTERM);
        }
        assert_eq!(driver.stopped()["ended"], "stopped");
    }
}

#[test]
fn a_slow_reader_knows_exactly_what_it_lost_and_delays_nobody() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    let mut slow = client.stream().unwrap();
    let mut fast = rig.client().stream().unwrap();
    // The first cycle says where its counting starts; then it sleeps, much longer than the two seconds that are buffered.
    let first = wait_for("a first cycle", || slow.next().unwrap().map(|cycle| cycle.header.cycle));
    let until = first + (8.0 * RATE_HZ) as u64;
    let mut expected = None;
    wait_until("eight seconds of cycles", || {
        while let Some(cycle) = fast.next().unwrap() {
            assert_eq!(cycle.lost, 0);
            assert_eq!(cycle.header.cycle, expected.unwrap_or(cycle.header.cycle));
            expected = Some(cycle.header.cycle + 1);
        }
        expected.is_some_and(|next| next > until)
    });
    assert_eq!(fast.lost(), 0, "the fast reader has every cycle");

    let (mut last, mut lost, mut received) = (first, 0, 1);
    let mut gaps = 0;
    wait_until("the slow reader to catch up", || {
        while let Some(cycle) = slow.next().unwrap() {
            assert_eq!(cycle.header.cycle - last - 1, cycle.lost, "the gap is what it says was lost");
            gaps += u64::from(cycle.lost > 0);
            last = cycle.header.cycle;
            lost += cycle.lost;
            received += 1;
        }
        last > until
    });
    assert_eq!((slow.received(), slow.lost()), (received, lost));
    assert_eq!(received + lost, last - first + 1, "nothing is unaccounted for");
    assert!(lost > 0 && gaps == 1, "it slept once, and lost {lost} cycles in {gaps} gaps");
    assert!(received as f64 > RATE_HZ, "only the oldest are lost, {received} received");
    let report = driver.stop();
    assert_eq!(report["unpublished"], 0, "{report:#}");
}

#[test]
fn twenty_clients_at_once() {
    let names: Vec<String> = (0..20).map(|i| format!("wire{i:02}")).collect();
    let rig = Rig::bench(&names.iter().map(String::as_str).collect::<Vec<_>>(), "");
    let (driver, observer) = Driver::ready(&rig);
    let robots: Vec<Process> = names.iter().map(|name| robot(&rig, &["work", name, "1500"])).collect();
    for (robot, name) in robots.into_iter().zip(&names) {
        let said = robot.finish().expect(0).stdout;
        let numbers: Vec<u64> = said.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
        let [received, lost, commands] = numbers[..] else { panic!("{name}: {said}") };
        assert_eq!((received, commands), (1500, 10), "{name}: {said}");
        // Twenty processes on a few cores may well be starved for longer than is buffered; they know it then.
        println!("{name}: {lost} lost");
    }
    wait_until("all commands to be counted", || observer.loop_stats().commands >= 200);
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().map(Vec::len), Some(0), "{report:#}");
}

/// Many systems start programs with room for 1024 open files and allow far more: the driver helps itself.
#[test]
fn a_driver_takes_as_many_open_files_as_it_may_have() {
    let rig = Rig::bench(&["left"], "");
    let usual = rig.command(&["--for", "120"]);
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -S -n 200 && exec \"$0\" \"$@\""]).arg(usual.get_program()).args(usual.get_args());
    command.envs(usual.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let driver = Process::start(&mut command);
    wait_until("the driver", || Client::connect(&rig.name).is_ok());
    let limits = std::fs::read_to_string(format!("/proc/{}/limits", driver.pid())).unwrap();
    let files = limits.lines().find_map(|line| line.strip_prefix("Max open files")).unwrap();
    let [soft, hard] = files.split_whitespace().take(2).collect::<Vec<_>>()[..] else { panic!("{files}") };
    assert!(soft == hard && soft != "200", "{files}");
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
}

/// Every place taken by a client that looks, sleeps and commands; the next one is told so and what to do, the others go on, and of those that
/// are killed neither places nor descriptors stay taken.
#[test]
fn as_many_clients_as_promised_and_not_one_more() {
    const MOST: usize = 256;
    sinew_ipc::descriptors::raise_limit();
    let rig = Rig::bench(&["left"], "");
    let (driver, observer) = Driver::ready(&rig);
    // The driver's own look at itself is a client as well.
    let there = 2;
    let before = driver.process.resources();
    let at_once = ClientOptions { connect: Duration::ZERO, ..ClientOptions::default() };
    let crowds: Vec<Process> = (0..5).map(|_| robot(&rig, &["crowd", "50", "left"])).collect();
    let crowded = |mut crowd: Process| {
        crowd.wait_for_word("crowded");
        crowd
    };
    let mut crowds: Vec<Process> = crowds.into_iter().map(crowded).collect();
    let mut rest = Vec::new();
    let full = loop {
        match Client::connect_with(&rig.name, at_once) {
            Ok(client) => rest.push(client),
            Err(error) => break error,
        }
        assert!(rest.len() + 250 + there <= MOST, "more than the {MOST} that are promised");
    };
    assert_eq!(rest.len() + 250 + there, MOST, "{full}");
    let why = full.to_string();
    assert!(why.contains("serves 256 clients at once, and all are taken; end programs"), "{why}");
    // Those who are in go on.
    let cycle = observer.latest().cycle;
    wait_until("the loop to go on", || observer.latest().cycle > cycle + RATE_HZ as u64 / 10);
    for client in [&observer, rest.first().expect("some are left over")] {
        client.set_stroke("left", 0.3, LONG).expect("places are full, not the desk");
    }
    let during = driver.process.resources();
    let dropped = observer.loop_stats().ring_drops;
    // Fifty of them are killed. What they have left is cleared away with time, their descriptors too; then as many others may come.
    drop(rest);
    crowds.pop().expect("five crowds").kill();
    wait_until("the crowd's descriptors to be closed", || {
        driver.process.resources().open_files + 50 * 4 <= during.open_files
    });
    let mut newcomers = Vec::new();
    wait_until("room for as many others", || {
        newcomers.extend(Client::connect_with(&rig.name, at_once));
        newcomers.len() == 50
    });
    assert!(crowds.iter_mut().all(|crowd| crowd.ended().is_none()), "the other two hundred go on");
    println!(
        "none and {MOST} connected: {} and {} files open, {} and {} MiB; {dropped} cycles not published",
        before.open_files,
        during.open_files,
        before.memory_bytes >> 20,
        during.memory_bytes >> 20,
    );
    assert!((during.open_files as u64) < sinew_ipc::descriptors::ALL_CLIENTS, "{during:?}");
    // A machine on which 256 clients share two cores may starve the publisher; what it could not publish is counted.
    drop(newcomers);
    driver.stop();
    crowds.into_iter().for_each(|crowd| drop(crowd.finish().expect(3)));
}

#[test]
fn one_client_may_command_while_others_only_look() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    assert!(Client::discover().unwrap().contains(&rig.name));
    assert_eq!(client.info().rig.as_str(), rig.name);
    assert_eq!((client.info().simulated, client.info().rate_hz), (1, RATE_HZ));
    let names: Vec<&str> = client.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["left", "right"]);
    for info in client.channels() {
        assert!(info.hot_length_m < info.cold_length_m && info.rest_length_m == 0.16, "{info:?}");
        assert!(info.min_length_m < info.max_length_m && info.lease_s == 0.5, "{info:?}");
    }
    // A sleeping client is woken.
    assert!(client.wait(sinew_tests::PATIENCE).unwrap());
    // Plain lines of the monitor, one a second, where there is no terminal.
    let said = rig.ask(&["monitor", "--for", "4"]).expect(0).stdout;
    assert!(said.lines().count() >= 2, "{said}");
    driver.stop();
}

/// The robot program that is shown to people, on the rig that is shown to people.
#[test]
fn the_gait_walks_the_hexapod_and_stops_cleanly() {
    walks_and_lets_go(|rig| {
        let mut robot = Command::new(gait());
        robot.arg(&rig.name);
        robot
    });
}

/// The built-in hexapod, under a name of the test's own.
pub fn hexapod() -> Rig {
    let text = std::fs::read_to_string(checkout().join("examples/hexapod.toml")).unwrap();
    assert_eq!(text.matches("name = \"hexapod\"").count(), 1);
    Rig::named(|name| text.replace("name = \"hexapod\"", &format!("name = \"{name}\"")))
}

/// Lets a robot program walk the hexapod, in whatever language it is written, and ends it as from a terminal.
#[track_caller]
pub fn walks_and_lets_go(robot: impl FnOnce(&Rig) -> Command) {
    let rig = hexapod();
    let (driver, observer) = Driver::ready(&rig);
    assert_eq!(observer.channels().len(), 18);
    let mut robot = Process::start(&mut robot(&rig));
    // Every wire is taken over, and femora lift their legs by a good part of the stroke.
    wait_until("the robot to command all wires", || {
        if let Some(status) = robot.ended() {
            panic!("the gait ended with {status}: {}{}", robot.stdout(), robot.stderr());
        }
        observer.latest().channels().iter().all(|c| c.mode() == Mode::Length)
    });
    let mut ranges = [(f64::MAX, f64::MIN); 18];
    wait_until("all wires to walk", || {
        let state = observer.latest();
        for ((range, channel), info) in ranges.iter_mut().zip(state.channels()).zip(observer.channels()) {
            assert_eq!(channel.fault(), None, "{}: {channel:?}", info.name);
            let stroke = info.stroke_at_length(channel.length_m);
            *range = (range.0.min(stroke), range.1.max(stroke));
        }
        ranges.iter().all(|(low, high)| high - low > 0.1)
    });
    robot.signal(libc::SIGINT);
    robot.finish().expect(0);
    // It has let go: nothing is heated any more, and no setpoint was left to run out.
    wait_until("all wires to be off", || observer.latest().channels().iter().all(|c| c.mode() == Mode::Off));
    assert!(observer.latest().channels().iter().all(|c| c.duty <= SENSING_DUTY));
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().unwrap().len(), 0, "{report:#}");
}
