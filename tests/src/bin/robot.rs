//! A robot program for the tests, to be killed, slept and multiplied: `sinew-test-robot RIG TASK …`.
//!
//! - `hold CHANNEL STROKE HOLD_S`: renews a setpoint until it cannot any more; says `holding` once it has been taken.
//! - `stream`: reads every cycle until it cannot any more; says `streaming` after the first.
//! - `work CHANNEL CYCLES`: reads so many cycles, and commands its channel meanwhile; says `worked RECEIVED LOST COMMANDS`.
//! - `repeat CALL CHANNEL`: does nothing but this one call (`connect`, `latest`, `stream`, `wait`, `set`, `reset`, `off`), for ever; says
//!   `repeating` once it has done so.
//! - `crowd CLIENTS [CHANNEL]`: is so many clients at once, which all look, sleep until something is new, and command (without a channel
//!   they only look); says `crowded CLIENTS`, and stays until the driver is gone.
//!
//! When the driver is gone, its words go to stderr and the exit code is 3.

use sinew_ipc::{Client, ClientOptions, Error, Reason};
use std::process::ExitCode;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(40);

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match robot(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(if matches!(error, Error::DriverGone { .. }) { 3 } else { 1 })
        }
    }
}

fn robot(words: &[&str]) -> Result<(), Error> {
    let [rig, task @ ..] = words else { panic!("usage: RIG TASK …") };
    let client = Client::connect_with(rig, ClientOptions { connect: PATIENCE, answer: PATIENCE })?;
    match task {
        ["hold", channel, stroke, hold_s] => {
            let stroke = stroke.parse().expect("a stroke");
            let hold = Duration::from_secs_f64(hold_s.parse().expect("seconds"));
            client.set_stroke(channel, stroke, hold)?;
            println!("holding");
            loop {
                std::thread::sleep(hold / 10);
                client.set_stroke(channel, stroke, hold)?;
            }
        }
        ["stream"] => {
            let mut stream = client.stream()?;
            loop {
                let before = stream.received();
                stream.next_within(PATIENCE)?;
                if before == 0 && stream.received() == 1 {
                    println!("streaming");
                }
            }
        }
        ["work", channel, cycles] => {
            let cycles: u64 = cycles.parse().expect("a number of cycles");
            let index = client.channel(channel)?;
            let mut stream = client.stream()?;
            let mut commands = 0;
            while stream.received() < cycles {
                if stream.received() * 10 / cycles >= commands {
                    let stroke = 0.1 + 0.02 * commands as f64;
                    client.set_stroke(channel, stroke, Duration::from_secs(5))?;
                    commands += 1;
                    // What was acknowledged is in force: nobody else commands this channel.
                    let asked_m = client.channels()[index].length_at_stroke(stroke);
                    let target_m = client.latest().channels()[index].target_m;
                    assert!((target_m - asked_m).abs() < 1e-9, "asked for {asked_m} m, the state says {target_m} m");
                }
                stream.next_within(PATIENCE)?.expect("a running driver has a next cycle");
            }
            println!("worked {} {} {commands}", stream.received(), stream.lost());
            Ok(())
        }
        ["repeat", call, channel] => {
            for round in 0u64.. {
                match *call {
                    "connect" => drop(Client::connect(rig)?),
                    "latest" => assert!(client.latest().cycle > 0),
                    // A new one each time: opening and closing are calls too.
                    "stream" => drop(client.stream()?.next_within(PATIENCE)?),
                    "wait" => drop(client.wait(PATIENCE)?),
                    "set" => match client.set_stroke(channel, 0.2, Duration::from_secs(1)) {
                        // Somebody else has switched it off since.
                        Err(Error::Refused(refusal)) if refusal.reason == Reason::Overtaken => {}
                        answer => drop(answer?),
                    },
                    "reset" => drop(client.reset(channel)?),
                    "off" => drop(client.off(channel)?),
                    other => panic!("no such call: {other:?}"),
                }
                if round == 0 {
                    println!("repeating");
                }
            }
            Ok(())
        }
        ["crowd", clients, channel @ ..] => {
            sinew_ipc::descriptors::raise_limit();
            let clients: usize = clients.parse().expect("a number of clients");
            let options = ClientOptions { connect: PATIENCE, answer: PATIENCE };
            let mut crowd = vec![client];
            while crowd.len() < clients {
                crowd.push(Client::connect_with(rig, options)?);
            }
            for client in &crowd {
                assert!(client.latest().cycle > 0);
                assert!(client.wait(PATIENCE)?);
                if let [channel] = channel {
                    client.set_stroke(channel, 0.2, Duration::from_secs(60))?;
                }
            }
            println!("crowded {}", crowd.len());
            loop {
                crowd[0].wait(PATIENCE)?;
            }
        }
        other => panic!("no such task: {other:?}"),
    }
}
