//! Faults of client programs: killed, hung, too many, too fast.

use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rand::rngs::Xoshiro256PlusPlus;
use rustix::process::Signal;
use sinew_ipc::{CommandKind, CycleStream, Error, Fault, Mode};

use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::running::{DUTY, How, LONG, Process, Running, connect, wait_for};
use crate::site::Site;
use crate::witness::now_ns;

/// Lease of the clients that are struck, s.
const HOLD_S: f64 = 0.1;
/// Clients at once.
const CROWD: usize = 200;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![
        silenced("client_killed", "SIGKILL of the program that commands, which holds a lease of 0.1 s", Signal::KILL),
        silenced("client_hangs", "SIGSTOP of the program that commands", Signal::STOP),
        killed_anywhere(),
        crowd(),
        flood(),
        off_in_a_flood(),
        stop_in_a_flood(),
        unknown_channel(),
        nobody_resets(),
    ]
}

fn kind(
    name: &'static str,
    injected: &'static str,
    faults: &'static [Fault],
    within: f64,
    one: impl Fn(&Site, &Running, &mut CycleStream, &mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Clients,
        injected,
        expected: "",
        within,
        unit: Unit::Milliseconds,
        lost: "",
        faults,
        carry_out: Box::new(move |site, trials| {
            let running = Running::start(site, &site.name(name), &How::default())?;
            let mut stream = running.client.stream()?;
            trials.each(|rng| {
                let reaction = one(site, &running, &mut stream, rng)?;
                others_go_on(&mut stream)?;
                Ok(reaction)
            })?;
            drop(stream);
            running.stop().map(drop)
        }),
    }
}

/// Another client has got every cycle, and the other wire is where it was.
fn others_go_on(stream: &mut CycleStream) -> Result<(), Failure> {
    let mut before = None;
    while let Some(cycle) = stream.next()? {
        let wire = &cycle.channels[1];
        expect(wire.duty == DUTY && wire.fault().is_none(), || format!("the other wire is disturbed: {wire:?}"))?;
        let number = cycle.header.cycle;
        expect(before.is_none_or(|before| number == before + 1), || format!("cycle {number} after {before:?}"))?;
        before = Some(number);
    }
    expect(stream.lost() == 0, || format!("another client lost {} cycles", stream.lost()))
}

fn client(site: &Site, rig: &str, task: &[&str]) -> Result<Process, Failure> {
    Process::start(site, Command::new(site.itself()?).args(["client", rig]).args(task))
}

fn silenced(name: &'static str, injected: &'static str, signal: Signal) -> Kind {
    let one = move |site: &Site, running: &Running, _: &mut CycleStream, rng: &mut Xoshiro256PlusPlus| {
        let holder = client(site, &running.rig, &["hold", "wire0", "0.2", &HOLD_S.to_string()])?;
        wait_for("its setpoint", || Ok((running.client.latest().channel[0].duty == 0.2).then_some(())))?;
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.1)));
        let from = now_ns();
        holder.signal(signal)?;
        wait_for("the lease to run out", || {
            Ok((running.client.latest().channel[0].mode() == Mode::Lapsed).then_some(()))
        })?;
        let put = running.put()?;
        let last = put.iter().rfind(|put| put.duty[0] > 0.02).map_or(0, |put| put.at_ns);
        Ok(last.saturating_sub(from) as f64 * 1e-6)
    };
    Kind {
        expected: "that wire at the sensing pulse when its lease is over; nothing to reset",
        lost: "that program's setpoint; the other wire and another reader's stream go on without a cycle lost",
        ..kind(name, injected, &[], HOLD_S * 1e3 + 60.0, one)
    }
}

/// Killed in the middle of whatever it is doing: connecting, reading, streaming, waiting, commanding, leaving.
fn killed_anywhere() -> Kind {
    let one = |site: &Site, running: &Running, _: &mut CycleStream, rng: &mut Xoshiro256PlusPlus| {
        let busy = client(site, &running.rig, &["everything", "wire0"])?;
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.06)));
        let mut busy = busy;
        busy.signal(Signal::KILL)?;
        busy.finish()?;
        let started = Instant::now();
        running.client.set_duty("wire1", DUTY, LONG)?;
        Ok(started.elapsed().as_secs_f64() * 1e3)
    };
    Kind {
        expected: "nobody else notices; time in which the next command of another client is answered",
        lost: "that program's setpoint, when its lease is over",
        ..kind(
            "client_killed_in_any_call",
            "SIGKILL 0 to 60 ms after the start of a program that connects, looks, streams, waits, commands and leaves",
            &[],
            250.0,
            one,
        )
    }
}

fn crowd() -> Kind {
    let one = |site: &Site, running: &Running, stream: &mut CycleStream, _: &mut Xoshiro256PlusPlus| {
        let number = CROWD.to_string();
        let mut crowd = client(site, &running.rig, &["crowd", &number, "wire0"])?;
        let mut worst_ms: f64 = 0.0;
        let status = loop {
            let started = Instant::now();
            running.client.set_duty("wire1", DUTY, LONG)?;
            worst_ms = worst_ms.max(started.elapsed().as_secs_f64() * 1e3);
            if let Some(status) = crowd.ended()? {
                break status;
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        expect(status.success(), || format!("{status}: {}", crowd.said()))?;
        // Whoever waits for an answer for longer than the two seconds a stream buffers has not read meanwhile: what it lost is counted and
        // no matter of the crowd. That the driver published every cycle stands in its report.
        *stream = running.client.stream()?;
        Ok(worst_ms)
    };
    Kind {
        expected: "each is served, or refused with the reason; longest time in which a command of another client is answered",
        lost: "nothing",
        ..kind("crowd", "200 clients of one process at once, each commands and reads", &[], 5000.0, one)
    }
}

fn flood() -> Kind {
    let one = |site: &Site, running: &Running, _: &mut CycleStream, rng: &mut Xoshiro256PlusPlus| {
        let seconds = between(rng, 0.1, 0.3).to_string();
        let mut flood = client(site, &running.rig, &["flood", "wire0", &seconds])?;
        let mut worst_ms: f64 = 0.0;
        while flood.ended()?.is_none() {
            let started = Instant::now();
            running.client.set_duty("wire1", DUTY, LONG)?;
            worst_ms = worst_ms.max(started.elapsed().as_secs_f64() * 1e3);
        }
        expect(flood.finish()?.success(), || flood.said())?;
        Ok(worst_ms)
    };
    Kind {
        expected: "eight commands a cycle at most, the rest waits or is refused as busy; longest time in which a command of another client is answered",
        lost: "nothing",
        ..kind("command_flood", "commands to one channel from four threads without a pause", &[], 500.0, one)
    }
}

/// Sixteen threads of four programs, which all want the wire that is to go off.
fn floods(site: &Site, rig: &str, seconds: f64) -> Result<Vec<Process>, Failure> {
    let seconds = seconds.to_string();
    (0..4).map(|_| client(site, rig, &["flood", "wire0", &seconds])).collect()
}

fn off_in_a_flood() -> Kind {
    const SENSING: f64 = 0.021;
    let one = |site: &Site, running: &Running, _: &mut CycleStream, rng: &mut Xoshiro256PlusPlus| {
        let floods = floods(site, &running.rig, 0.6)?;
        wait_for("the flood", || Ok((running.client.latest().channel[0].order().is_some()).then_some(())))?;
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.05, 0.2)));
        let from = now_ns();
        running.client.off("wire0")?;
        // The flood goes on, and what is asked after it counts again.
        let off = wait_for("its output", || {
            let put = running.put()?;
            Ok(put.iter().find(|put| put.at_ns >= from && put.duty[0] <= SENSING).map(|put| put.at_ns - from))
        })?;
        for mut flood in floods {
            expect(flood.finish()?.success(), || flood.said())?;
        }
        running.client.set_duty("wire0", DUTY, LONG)?;
        Ok(off as f64 * 1e-6)
    };
    Kind {
        expected: "off overtakes what waits; time from the call to the sensing pulse at the output",
        lost: "what was asked of that channel before it and waited: answered as overtaken",
        ..kind(
            "off_in_a_flood",
            "a channel is switched off while sixteen threads of four programs command it",
            &[],
            50.0,
            one,
        )
    }
}

fn stop_in_a_flood() -> Kind {
    Kind {
        name: "stop_in_a_flood",
        group: Group::Clients,
        injected: "a client stops the driver while sixteen threads of four programs command it",
        expected: "zero at all outputs, the driver ends in order; time from the call to zero",
        within: 50.0,
        unit: Unit::Milliseconds,
        lost: "the run",
        faults: &[Fault::Stopping],
        carry_out: Box::new(|site, trials| {
            trials.each(|rng| {
                let mut running = Running::start(site, &site.name("stopped"), &How::default())?;
                let floods = floods(site, &running.rig, 5.0)?;
                wait_for("the flood", || Ok((running.client.latest().channel[0].order().is_some()).then_some(())))?;
                std::thread::sleep(Duration::from_secs_f64(between(rng, 0.05, 0.2)));
                let from = now_ns();
                running.client.stop()?;
                let zero_ms = running.zero_ms(from)?;
                running.ended_in_order()?;
                drop(floods);
                Ok(zero_ms)
            })
        }),
    }
}

fn unknown_channel() -> Kind {
    let one = |_: &Site, running: &Running, _: &mut CycleStream, rng: &mut Xoshiro256PlusPlus| {
        let channel = whole(rng, 2, u64::from(u32::MAX) - 1) as u32;
        let started = Instant::now();
        match running.client.command(channel, CommandKind::Duty, 0.5, LONG) {
            Err(Error::Refused(_)) => Ok(started.elapsed().as_secs_f64() * 1e3),
            other => unexpected(format!("channel {channel}: {other:?}")),
        }
    };
    Kind {
        expected: "refused with the reason; time to the answer",
        lost: "nothing",
        ..kind("unknown_channel", "a command to a channel there is none of", &[], 250.0, one)
    }
}

/// A wire breaks and nobody who could reset it is there: it stays off, whoever comes and goes.
fn nobody_resets() -> Kind {
    Kind {
        name: "fault_outlives_its_clients",
        group: Group::Clients,
        injected: "a wire opens and is mended; clients come, ask for power without a reset, and leave",
        expected: "it stays off, every command is refused with the first cause",
        within: 0.0,
        unit: Unit::Periods,
        lost: "that channel's power until its reset",
        faults: &[Fault::OpenWire],
        carry_out: Box::new(|site, trials| {
            let mut running = Running::start(site, &site.name("unreset"), &How::default())?;
            running.process.tell("break wire0 open_wire")?;
            wait_for("the fault", || Ok(running.client.latest().channel[0].fault()))?;
            running.process.tell("mend")?;
            std::thread::sleep(Duration::from_millis(20));
            let mut seen = running.put()?.len();
            trials.each(|_| {
                let newcomer = connect(&running.rig)?;
                match newcomer.set_duty("wire0", DUTY, LONG) {
                    Err(Error::Refused(_)) => {}
                    other => return unexpected(format!("{other:?}")),
                }
                let put = running.put()?;
                let powered = put[seen..].iter().filter(|put| put.duty[0] > 0.0).count();
                seen = put.len();
                Ok(powered as f64)
            })?;
            running.client.reset("wire0")?;
            running.stop().map(drop)
        }),
    }
}

/// `sinew-trust client RIG TASK …`: the programs that are struck.
///
/// # Errors
/// When the driver does something else than it promises.
pub fn client_main(rig: &str, task: &[String]) -> Result<(), Failure> {
    let words: Vec<&str> = task.iter().map(String::as_str).collect();
    let number = |word: &str| word.parse::<f64>().map_err(|_| Failure::Unexpected(format!("{word} is no number")));
    match words[..] {
        ["hold", channel, duty, hold] => {
            let (duty, hold) = (number(duty)?, Duration::from_secs_f64(number(hold)?));
            let client = connect(rig)?;
            loop {
                client.set_duty(channel, duty, hold)?;
                std::thread::sleep(hold / 10);
            }
        }
        ["everything", channel] => loop {
            let client = connect(rig)?;
            let _ = client.latest();
            let mut stream = client.stream()?;
            client.set_duty(channel, DUTY, Duration::from_millis(50))?;
            let _ = stream.next_within(Duration::from_millis(5))?;
            client.wait(Duration::from_millis(5))?;
            let _ = client.reset(channel)?;
            client.off(channel)?;
        },
        ["crowd", many, channel] => {
            let (served, refused) = (AtomicU64::new(0), AtomicU64::new(0));
            let wrong: Vec<Failure> = std::thread::scope(|scope| {
                let member = || match connect(rig) {
                    Ok(client) => {
                        served.fetch_add(1, Ordering::Relaxed);
                        let duty = client.set_duty(channel, DUTY, LONG);
                        std::hint::black_box(client.latest());
                        // So that all of them are there at once.
                        std::thread::sleep(Duration::from_millis(200));
                        duty.map(drop).map_err(Failure::from)
                    }
                    Err(_) => {
                        refused.fetch_add(1, Ordering::Relaxed);
                        Ok(())
                    }
                };
                let crowd: Vec<_> = (0..number(many).unwrap_or(0.0) as usize).map(|_| scope.spawn(member)).collect();
                crowd.into_iter().filter_map(|one| one.join().ok().and_then(Result::err)).collect()
            });
            println!("{} served, {} refused", served.into_inner(), refused.into_inner());
            match wrong.into_iter().next() {
                Some(failure) => Err(failure),
                None => Ok(()),
            }
        }
        ["flood", channel, seconds] => {
            let until = Instant::now() + Duration::from_secs_f64(number(seconds)?);
            let client = connect(rig)?;
            let wrong: Vec<Failure> = std::thread::scope(|scope| {
                let pour = || {
                    while Instant::now() < until {
                        match client.set_duty(channel, DUTY, LONG) {
                            Ok(_) | Err(Error::Refused(_)) => {}
                            Err(error) => return Err(Failure::from(error)),
                        }
                    }
                    Ok(())
                };
                let pours: Vec<_> = (0..4).map(|_| scope.spawn(pour)).collect();
                pours.into_iter().filter_map(|one| one.join().ok().and_then(Result::err)).collect()
            });
            match wrong.into_iter().next() {
                Some(failure) => Err(failure),
                None => Ok(()),
            }
        }
        _ => unexpected(format!("there is no such task: {words:?}")),
    }
}
