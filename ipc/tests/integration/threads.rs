//! Driver and clients in threads of one process.

use crate::common::*;
use sinew_ipc::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const ANSWER: Duration = Duration::from_millis(300);

#[test]
fn a_state_is_never_torn_however_fast_it_is_written_and_read() {
    let rig = rig("torn");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 64, 1000.0)).unwrap();
    let (mut writer, _cycles, _commands) = server.split();
    writer.update(&state(1, 64));
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let readers: Vec<_> = (0..3)
            .map(|_| {
                scope.spawn(|| {
                    let client = Client::connect(&rig).unwrap();
                    let (mut reads, mut last, mut changes) = (0u64, 0, 0u64);
                    while !done.load(Ordering::Relaxed) || reads < 1000 {
                        client.with_latest(|s| {
                            assert_whole(s.cycle, s.missed, s.channels());
                            assert!(s.cycle >= last, "back from {last} to {}", s.cycle);
                            changes += u64::from(s.cycle != last);
                            last = s.cycle;
                        });
                        reads += 1;
                    }
                    changes
                })
            })
            .collect();
        until("all readers are connected", || {
            // Written at full speed from the start: connecting must not be disturbed by it either.
            for cycle in 2..1000 {
                writer.update(&state(cycle, 64));
            }
            true
        });
        for cycle in 1000..200_000 {
            writer.update(&state(cycle, 64));
        }
        done.store(true, Ordering::Relaxed);
        for reader in readers {
            assert!(reader.join().unwrap() > 0);
        }
    });
}

#[test]
fn what_a_client_sees_is_what_was_written() {
    let rig = rig("same");
    let known = info(&rig, 18, 1000.0);
    let mut server = Server::create(RigLock::acquire(&rig).unwrap(), &known).unwrap();
    let client = Client::connect(&rig).unwrap();
    assert_eq!(client.info().rig.as_str(), rig);
    assert_eq!(client.info().pid, std::process::id());
    assert_eq!(client.channels().len(), 18);
    assert_eq!(client.channel("c17").unwrap(), 17);
    assert!(matches!(client.channel("c18"), Err(Error::UnknownChannel { .. })));
    let first = client.latest();
    assert_eq!((first.cycle, first.channels().len(), first.state()), (0, 18, DriverState::Starting));
    assert_eq!(client.health(), DriverHealth::Starting);
    for cycle in 1..=5 {
        let written = state(cycle, 18);
        server.state.update(&written);
        let mut read = Snapshot::default();
        client.latest_into(&mut read);
        assert_eq!(read.channels(), written.channels());
        assert_eq!(read.header(), written.header());
    }
    let mut stats = LoopStats::new();
    stats.lateness.record(12_345);
    stats.missed = 7;
    stats.realtime = LoopStats::RT_FIFO | LoopStats::RT_LOCKED;
    server.state.update_stats(&stats);
    assert_eq!(client.loop_stats(), stats);
    assert!(Client::discover().unwrap().contains(&rig));
}

#[test]
fn the_stream_has_every_cycle_in_order() {
    let rig = rig("stream");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 5, 1000.0)).unwrap();
    let (_state, mut cycles, _commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    let mut stream = client.stream().unwrap();
    assert!(stream.next().unwrap().is_none());
    for cycle in 1..=95 {
        cycles.push_snapshot(&state(cycle, 5));
    }
    cycles.flush();
    for expected in 1..=95 {
        let cycle = stream.next().unwrap().unwrap();
        assert_eq!((cycle.header.cycle, cycle.lost, cycle.channels.len()), (expected, 0, 5));
        assert_whole(cycle.header.cycle, cycle.header.missed, cycle.channels);
    }
    assert!(stream.next().unwrap().is_none());
    assert_eq!((stream.received(), stream.lost()), (95, 0));
}

#[test]
fn a_stream_begins_where_it_was_opened_whatever_its_first_batch_holds() {
    let rig = rig("open");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 5, 1000.0)).unwrap();
    let (mut latest, mut cycles, _commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    for cycle in 1..=5 {
        latest.update(&state(cycle, 5));
        cycles.push_snapshot(&state(cycle, 5));
    }
    let mut stream = client.stream().unwrap();
    cycles.flush();
    assert!(stream.next().unwrap().is_none(), "all of that was before");
    for cycle in 6..=8 {
        cycles.push_snapshot(&state(cycle, 5));
    }
    cycles.flush();
    for expected in 6..=8 {
        assert_eq!(stream.next().unwrap().unwrap().header.cycle, expected);
    }
    assert_eq!((stream.received(), stream.lost()), (3, 0));
}

#[test]
fn a_slow_reader_loses_the_oldest_counts_them_exactly_and_delays_nobody() {
    let rig = rig("slow");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 18, 1000.0)).unwrap();
    let (_state, mut cycles, _commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    let (mut slow, mut quick) = (client.stream().unwrap(), client.stream().unwrap());
    const TOTAL: u64 = 20_000;
    let mut first = None;
    for cycle in 1..=TOTAL {
        cycles.push_snapshot(&state(cycle, 18));
        while let Some(c) = quick.next().unwrap() {
            assert_whole(c.header.cycle, c.header.missed, c.channels);
        }
        if cycle == 1000 {
            // The slow one looks once, holds on to what it sees, and is away for the next 19 s.
            let c = slow.next().unwrap().unwrap();
            first = Some(c.header.cycle);
        }
    }
    cycles.flush();
    while quick.next().unwrap().is_some() {}
    assert_eq!((quick.received(), quick.lost()), (TOTAL, 0));
    assert_eq!(cycles.unsent(), 0);
    let mut last = first.unwrap();
    let mut gaps = 0;
    while let Some(c) = slow.next().unwrap() {
        assert_whole(c.header.cycle, c.header.missed, c.channels);
        assert_eq!(c.header.cycle, last + 1 + c.lost);
        gaps += c.lost;
        last = c.header.cycle;
    }
    assert_eq!(last, TOTAL);
    assert_eq!(slow.lost(), gaps);
    assert_eq!(slow.received() + slow.lost() + first.unwrap() - 1, TOTAL);
    assert!(slow.lost() > 0 && slow.received() >= 1000, "{} {}", slow.received(), slow.lost());
}

#[test]
fn as_many_streams_as_promised_all_of_them_slow() {
    let rig = rig("streams");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 2, 1000.0)).unwrap();
    let (_state, mut cycles, _commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    let mut streams: Vec<_> = (0..64).map(|_| client.stream().unwrap()).collect();
    assert!(matches!(client.stream(), Err(Error::Full { what: "streams", most: 64, .. })));
    // Each holds another batch while the buffers run over many times.
    for (i, stream) in streams.iter_mut().enumerate() {
        for cycle in 0..10 {
            cycles.push_snapshot(&state(i as u64 * 10 + cycle + 1, 2));
        }
        cycles.flush();
        assert!(stream.next().unwrap().is_some());
    }
    for cycle in 641..=20_000 {
        cycles.push_snapshot(&state(cycle, 2));
    }
    cycles.flush();
    assert_eq!(cycles.unsent(), 0, "samples ran out");
    for stream in &mut streams {
        let mut last = 0;
        while let Some(c) = stream.next().unwrap() {
            assert_whole(c.header.cycle, c.header.missed, c.channels);
            last = c.header.cycle;
        }
        assert_eq!(last, 20_000);
        assert_eq!(stream.received() + stream.lost(), 20_000);
    }
}

#[test]
fn commands_are_answered_each_client_its_own() {
    let rig = rig("commands");
    let _driver = Driver::start(&rig, 18, 500.0);
    std::thread::scope(|scope| {
        for k in 0..20 {
            let rig = &rig;
            scope.spawn(move || {
                let client = patient(rig);
                let name = format!("c{}", k % 18);
                for i in 0..25 {
                    let stroke = (k * 25 + i) as f64 / 1000.0;
                    let reply = client.set_stroke(&name, stroke, Duration::from_millis(200 + i as u64)).unwrap();
                    assert_eq!((reply.value, reply.channel), (stroke, k % 18));
                    assert_eq!(reply.hold_s, (200 + i) as f64 / 1000.0);
                }
            });
        }
    });
}

#[test]
fn one_client_may_be_used_by_many_threads() {
    let rig = rig("shared");
    let _driver = Driver::start(&rig, 4, 500.0);
    let client = patient(&rig);
    std::thread::scope(|scope| {
        for k in 0..24 {
            let client = &client;
            scope.spawn(move || {
                for i in 0..10 {
                    let value = f64::from(k * 100 + i) * 1e-4;
                    assert_eq!(client.set_duty("c1", value, Duration::ZERO).unwrap().value, value);
                    client.with_latest(|s| assert_whole(s.cycle, s.missed, s.channels()));
                    assert!(client.wait(PATIENCE).unwrap());
                }
            });
        }
    });
}

#[test]
fn a_refusal_says_why_and_what_to_do() {
    let rig = rig("refused");
    let _driver = Driver::start(&rig, 2, 200.0);
    let client = Client::connect(&rig).unwrap();
    let refusal = |e: Error| match e {
        Error::Refused(r) => r,
        other => panic!("{other}"),
    };
    let e = client.set_stroke("c0", 1.5, Duration::ZERO).unwrap_err();
    assert!(e.is_bad_input());
    assert!(e.to_string().contains("outside 0.000000 to 1.000000"), "{e}");
    assert!(e.to_string().contains(Fault::SetpointOutOfRange.remedy()), "{e}");
    assert_eq!(refusal(e).reason, Reason::OutOfRange { low: 0.0, high: 1.0 });
    let e = client.set_stroke("c0", f64::NAN, Duration::ZERO).unwrap_err();
    assert_eq!(refusal(e).reason, Reason::NotFinite);
    let e = client.reset("c1").unwrap_err();
    assert!(e.to_string().contains(Fault::OpenWire.remedy()), "{e}");
    assert_eq!(refusal(e).reason, Reason::CauseRemains(Fault::OpenWire));
    let e = client.set_force("c1", 1.0, Duration::ZERO).unwrap_err();
    assert_eq!(refusal(e).reason, Reason::Unsupported);
    let e = client.command(77, CommandKind::Off, 0.0, Duration::ZERO).unwrap_err();
    assert_eq!(refusal(e).reason, Reason::UnknownChannel);
    let e = client.set_stroke("c2", 0.5, Duration::ZERO).unwrap_err();
    assert!(matches!(e, Error::UnknownChannel { .. }), "{e}");
    assert_eq!(client.all_off().unwrap().channel, ALL_CHANNELS);
    assert!(client.stop().is_ok());
}

#[test]
fn a_driver_that_does_not_answer_is_reported_and_the_command_is_not_carried_out_later() {
    let rig = rig("mute");
    let mut server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 1, 1000.0)).unwrap();
    let client = Client::connect_with(&rig, ClientOptions { answer: ANSWER, ..ClientOptions::default() }).unwrap();
    for _ in 0..40 {
        // More than may be unanswered at a time: none of the given up ones counts.
        let quick = ClientOptions { answer: Duration::from_millis(2), ..ClientOptions::default() };
        let hasty = Client::connect_with(&rig, quick).unwrap();
        assert!(matches!(hasty.set_duty("c0", 0.1, Duration::ZERO), Err(Error::NoAnswer { .. })));
    }
    for _ in 0..20 {
        let e = client.command(0, CommandKind::Duty, 0.1, Duration::ZERO);
        assert!(matches!(e, Err(Error::NoAnswer { .. })), "{e:?}");
        // Otherwise this test would wait 20 times for nothing.
        if server.commands.receive().is_some() {
            panic!("a command whose sender has given up");
        }
    }
    assert_eq!(server.commands.serve(|_| panic!("a command whose sender has given up")), 0);
    // And it is not deaf from then on, to who asks until he is answered.
    std::thread::scope(|scope| {
        let asking = scope.spawn(|| {
            loop {
                match client.set_duty("c0", 0.2, Duration::ZERO) {
                    Err(Error::NoAnswer { .. }) => {}
                    answer => return answer,
                }
            }
        });
        until("it is answered", || {
            server.commands.serve(decide);
            asking.is_finished()
        });
        assert_eq!(asking.join().unwrap().unwrap().value, 0.2);
    });
}

#[test]
fn the_event_wakes_sleepers_and_a_stopping_driver_lets_them_go() {
    let rig = rig("wake");
    let driver = Driver::start(&rig, 2, 200.0);
    let client = Client::connect(&rig).unwrap();
    let before = client.latest().cycle;
    for _ in 0..5 {
        assert!(client.wait(PATIENCE).unwrap());
    }
    until("cycles go on", || client.latest().cycle > before);
    assert!(client.is_alive());
    std::thread::scope(|scope| {
        let sleeper = scope.spawn(|| {
            let mut waiter = client.waiter().unwrap();
            loop {
                if let Err(e) = waiter.wait(Duration::from_secs(60)) {
                    return e;
                }
            }
        });
        drop(driver);
        assert!(matches!(sleeper.join().unwrap(), Error::DriverGone { stopped: true, .. }));
    });
    assert!(!client.is_alive());
    assert_eq!(client.health(), DriverHealth::Stopped);
}

#[test]
fn a_client_outlives_its_driver_and_does_not_mistake_the_next_one_for_it() {
    let rig = rig("outlive");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 3, 1000.0)).unwrap();
    let (mut writer, mut cycles, commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    let mut stream = client.stream().unwrap();
    let mut faults = client.faults();
    writer.update(&state(41, 3));
    cycles.push_snapshot(&state(41, 3));
    assert_eq!(client.health(), DriverHealth::Running);
    drop((writer, cycles, commands));

    assert_eq!(client.latest().cycle, 41);
    assert!(!client.is_alive());
    assert_eq!(client.health(), DriverHealth::Died);
    let gone = Error::DriverGone { rig: rig.clone(), pid: std::process::id(), stopped: false };
    assert_eq!(client.set_stroke("c0", 0.1, Duration::ZERO), Err(gone.clone()));
    assert_eq!(client.wait(Duration::ZERO), Err(gone.clone()));
    // What it had sent before is still there, then the end is told.
    assert_eq!(stream.next().unwrap().unwrap().header.cycle, 41);
    assert_eq!(stream.next().unwrap_err(), gone);
    assert_eq!(stream.next_within(Duration::from_secs(1)).unwrap_err(), gone);
    let died: Vec<_> = faults.by_ref().map(|c| (c.channel, c.before, c.after)).collect();
    assert_eq!(died, [0, 1, 2].map(|i| (i, None, Some(Fault::DriverDied))));
    assert!(faults.next().is_none());
    assert!(matches!(Client::connect(&rig), Err(Error::NotRunning { .. })));

    let _next = Driver::start(&rig, 3, 200.0);
    assert!(!client.is_alive());
    assert_eq!(client.latest().cycle, 41);
    assert_eq!(client.set_stroke("c0", 0.1, Duration::ZERO), Err(gone));
    let fresh = Client::connect(&rig).unwrap();
    assert!(fresh.set_stroke("c0", 0.1, Duration::ZERO).is_ok());
    // The old one goes without taking anything of the new one along.
    drop(stream);
    drop(client);
    assert!(fresh.set_stroke("c0", 0.2, Duration::ZERO).is_ok());
    assert!(fresh.wait(PATIENCE).unwrap());
}

#[test]
fn faults_are_reported_when_they_come_and_when_they_go() {
    let rig = rig("faults");
    let server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 3, 1000.0)).unwrap();
    let (mut writer, mut cycles, _commands) = server.split();
    let client = Client::connect(&rig).unwrap();
    let mut s = state(1, 3);
    s.channel[2].fault = Fault::OpenWire.code();
    writer.update(&s);
    let mut watch = client.faults();
    let change = watch.poll().unwrap();
    assert_eq!((change.channel, change.name.as_str(), change.after), (2, "c2", Some(Fault::OpenWire)));
    assert!(watch.poll().is_none());
    s.cycle = 2;
    s.channel[2].fault = 0;
    s.channel[0].fault = Fault::OverTemperature.code();
    writer.update(&s);
    cycles.ring();
    let next = |watch: &mut FaultWatch<&Client>| watch.wait(PATIENCE).unwrap().unwrap();
    let change = next(&mut watch);
    assert_eq!((change.channel, change.before, change.after), (0, None, Some(Fault::OverTemperature)));
    let change = next(&mut watch);
    assert_eq!((change.channel, change.before, change.after), (2, Some(Fault::OpenWire), None));
    assert_eq!(change.cycle, 2);
}

#[test]
fn a_loop_that_stands_still_is_noticed() {
    let rig = rig("stalled");
    let mut server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 1, 1000.0)).unwrap();
    let client = Client::connect(&rig).unwrap();
    let mut s = state(1, 1);
    s.monotonic_ns = monotonic_ns() - 2_000_000_000;
    server.state.update(&s);
    assert!(matches!(client.health(), DriverHealth::Stalled { age } if age >= Duration::from_secs(2)));
    assert!(!client.is_alive());
    assert!(client.age() >= Duration::from_secs(2));
}

#[test]
fn connecting_waits_for_a_driver_that_is_starting() {
    let rig = rig("starting");
    let lock = RigLock::acquire(&rig).unwrap();
    let impatient = ClientOptions { connect: Duration::from_millis(20), ..ClientOptions::default() };
    let e = Client::connect_with(&rig, impatient).err().unwrap();
    assert_eq!(e, Error::Starting { rig: rig.clone(), pid: std::process::id() });
    let patient = ClientOptions { connect: PATIENCE, ..ClientOptions::default() };
    std::thread::scope(|scope| {
        let connecting = scope.spawn(|| Client::connect_with(&rig, patient).map(|c| c.channels().len()));
        std::thread::sleep(Duration::from_millis(20));
        let _server = Server::create(lock, &info(&rig, 7, 1000.0)).unwrap();
        assert_eq!(connecting.join().unwrap().unwrap(), 7);
    });
}

#[test]
#[should_panic(expected = "cycle 8, channel 2")]
fn a_torn_state_would_be_noticed() {
    let mut torn = state(8, 4);
    torn.channel[2..].copy_from_slice(&state(7, 64).channel[2..]);
    assert_whole(torn.cycle, torn.missed, torn.channels());
}
