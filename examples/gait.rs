//! A robot program: walks the built-in hexapod with a tripod gait, from a process of its own.
//!
//! ```text
//! cargo run --bin sinew -- run                      # in one terminal: the driver, on simulated wires
//! cargo run -p sinew-ipc --example gait             # in another: this program; Ctrl-C ends it
//! cargo run -p sinew-ipc --example gait -- RIG 30   # another rig of the same legs, for 30 s
//! ```
//!
//! Six legs of three wires. Legs of a tripod (front and rear of one side with the middle of the other) move together, the
//! two tripods in turn: while one steps, the other carries. A shape-memory wire contracts within a second when heated but takes two
//! or three to cool and stretch again, so what needs cooling gets more time:
//!
//! | seconds | stepping tripod | carrying tripod |
//! |---|---|---|
//! | 0–1 | lifts: femora contract | pushes: coxae relax slowly ... |
//! | 1–2 | swings: coxae contract, tibiae reach out | ... |
//! | 2–4 | sets down: femora relax | ... all the four seconds |

use sinew_ipc::{Client, CommandKind, Error, FaultChange, Wanted};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Half a gait cycle, s: one tripod's step.
const STEP_S: f64 = 4.0;
/// How often setpoints are sent, all of them in one request: often enough for a smooth ramp.
const TICK: Duration = Duration::from_millis(20);
/// How long each setpoint holds: if this program hangs or dies, the wires go off this much later.
const LEASE: Duration = Duration::from_millis(500);

/// Where the strokes go, 0 = cold and long, 1 = hot and short.
const FEMUR_DOWN: f64 = 0.15;
const FEMUR_UP: f64 = 0.60;
const COXA_BACK: f64 = 0.15;
const COXA_FORWARD: f64 = 0.60;
const TIBIA_IN: f64 = 0.20;
const TIBIA_OUT: f64 = 0.45;

fn main() {
    if let Err(e) = run() {
        // The text of an error ends with what to do about it.
        eprintln!("gait: {e}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let rig = arguments.next().unwrap_or_else(|| "hexapod".to_string());
    let end = match arguments.next() {
        Some(text) => {
            Some(Duration::try_from_secs_f64(text.parse().map_err(|_| format!("{text:?} is no time in s"))?)?)
        }
        None => None,
    };

    // Ctrl-C and SIGTERM only raise a flag: this program ends where it knows what state it is in.
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, interrupted.clone())?;
    }

    // Find the driver and, by their names, the wires.
    let client = Client::connect(&rig)?;
    let legs = legs(&client)?;
    println!(
        "walking {rig:?} of driver {}: {} channels at {} Hz",
        client.info().pid,
        client.channels().len(),
        client.info().rate_hz
    );

    let result = walk(&client, &legs, end, &interrupted);

    // Whatever has happened: hand the wires back cold. Were this program killed instead, their leases would see to it.
    let mut still_on = None;
    for wire in legs.iter().flat_map(|leg| &leg.wires) {
        still_on = client.off(wire).err().or(still_on);
    }
    result?;
    match still_on {
        None => println!("all channels off"),
        Some(e) => return Err(e.into()),
    }
    Ok(())
}

/// One leg.
struct Leg {
    /// Coxa, femur, tibia: their wires, by the names they have in the rig file, and by the numbers these have in the driver.
    wires: [String; 3],
    channels: [u32; 3],
    /// Which of the two tripods it belongs to.
    tripod: usize,
}

fn legs(client: &Client) -> Result<Vec<Leg>, Error> {
    let mut legs = Vec::new();
    for (row, place) in ["front", "middle", "rear"].into_iter().enumerate() {
        for (column, side) in ["left", "right"].into_iter().enumerate() {
            let wires = ["coxa", "femur", "tibia"].map(|joint| format!("{place}_{side}_{joint}"));
            let mut channels = [0; 3];
            for (channel, wire) in channels.iter_mut().zip(&wires) {
                *channel = client.channel(wire)? as u32;
            }
            legs.push(Leg { wires, channels, tripod: (row + column) % 2 });
        }
    }
    Ok(legs)
}

/// Strokes of coxa, femur and tibia, `t_s` seconds into the leg's own gait cycle, which begins with its step.
fn strokes(t_s: f64) -> [f64; 3] {
    let t = t_s.rem_euclid(2.0 * STEP_S);
    let femur = FEMUR_DOWN + (FEMUR_UP - FEMUR_DOWN) * (ramp(t, 0.0, 1.0) - ramp(t, 2.0, 4.0));
    // Forward in the air, back on the ground: that pushes the body forward.
    let forward = ramp(t, 1.0, 2.0) - ramp(t, STEP_S, 2.0 * STEP_S);
    [COXA_BACK + (COXA_FORWARD - COXA_BACK) * forward, femur, TIBIA_IN + (TIBIA_OUT - TIBIA_IN) * forward]
}

/// From 0 to 1 between two times, without a jerk at either end.
fn ramp(t: f64, from: f64, to: f64) -> f64 {
    let x = ((t - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn phase(t_s: f64) -> String {
    let tripod = ["left", "right"][(t_s / STEP_S) as usize % 2];
    let doing = match t_s % STEP_S {
        t if t < 1.0 => "lifts",
        t if t < 2.0 => "swings",
        _ => "sets down",
    };
    format!("{tripod} tripod {doing}")
}

fn walk(client: &Client, legs: &[Leg], end: Option<Duration>, interrupted: &AtomicBool) -> Result<(), Error> {
    let mut stream = client.stream()?;
    let mut faults = client.faults();
    let (mut pose, mut refused) = (Vec::new(), BTreeSet::new());
    let start = Instant::now();
    let mut next = start;
    let mut next_line = Duration::from_secs(1);
    // Squared tracking error of the second just past, and over how many lengths.
    let (mut squares, mut lengths) = (0.0, 0u64);

    while !interrupted.load(Ordering::Relaxed) && end.is_none_or(|end| start.elapsed() < end) {
        let t_s = start.elapsed().as_secs_f64();

        // Command every wire, all in the same cycle.
        pose.clear();
        for leg in legs {
            let strokes = strokes(t_s + STEP_S * leg.tripod as f64);
            let wanted = |(channel, value)| Wanted { channel, kind: CommandKind::Stroke, value };
            pose.extend(leg.channels.into_iter().zip(strokes).map(wanted));
        }
        send(client, &mut pose, &mut refused)?;

        // See what became of it: every cycle since the last look, not only the latest.
        while let Some(cycle) = stream.next()? {
            for state in cycle.channels {
                let error_m = state.length_m - state.target_m;
                // NaN while a wire has no length or no target.
                if error_m.is_finite() {
                    squares += error_m * error_m;
                    lengths += 1;
                }
            }
        }
        for FaultChange { name, after, .. } in faults.by_ref() {
            match after {
                Some(fault) => eprintln!("{name}: {fault}; {}", fault.remedy()),
                None => eprintln!("{name}: fault cleared"),
            }
        }

        if start.elapsed() >= next_line {
            let rms_mm = 1e3 * (squares / lengths as f64).sqrt();
            println!("{t_s:6.1} s  {:<22}  rms error {rms_mm:.3} mm  lost cycles {}", phase(t_s), stream.lost());
            (squares, lengths) = (0.0, 0);
            next_line += Duration::from_secs(1);
        }
        next += TICK;
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
    }
    Ok(())
}

/// Sends a pose. Wires the driver refuses are told about once, and left out; the others walk on.
fn send(client: &Client, pose: &mut Vec<Wanted>, refused: &mut BTreeSet<String>) -> Result<(), Error> {
    let Err(error) = client.set_many(pose, LEASE) else {
        refused.clear();
        return Ok(());
    };
    let Error::RefusedTogether(refusals) = &error else { return Err(error) };
    let is_refused = |name: &str| refusals.iter().any(|refusal| refusal.channel == name);
    pose.retain(|wanted| !is_refused(client.channels()[wanted.channel as usize].name.as_str()));
    refused.retain(|name| is_refused(name));
    for refusal in refusals {
        if refused.insert(refusal.channel.clone()) {
            eprintln!("{}; {}", refusal.message(), refusal.remedy());
        }
    }
    match client.set_many(pose, LEASE) {
        // None is left, or one more has failed meanwhile: the next pose comes soon.
        Ok(_) | Err(Error::Channels { .. } | Error::RefusedTogether(_)) => Ok(()),
        Err(error) => Err(error),
    }
}
